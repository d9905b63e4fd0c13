//! Count and emit: the triangles of every sheet, grouped by sheet, each crack polygon once for both of its fragments.

use super::pattern::{FACE_CODE, PATTERNS, Split, TET_CODE, mask};
use super::rank::{Input, Ranks};
use nalgebra::Point3;

/// Polygons of one tetrahedron fit in three bits, those of a boundary face in two.
const POLYGON_BITS: u32 = 3;

/// Polygons grouped by sheet, as tetrahedron (cracks) or boundary face (outer sheets) and polygon number.
#[derive(Debug, Default)]
pub(super) struct Polygons {
    /// Codes: (tetrahedron or boundary face) · 8 + polygon.
    codes: Vec<u32>,
    /// First code of each sheet.
    offsets: Vec<usize>,
    /// Triangles of each sheet.
    pub triangles: Vec<u32>,
}

impl Polygons {
    /// Counts the triangles of every sheet and groups the polygons.
    pub fn group(&mut self, input: Input<'_>) {
        let sheets = input.fragments + input.sheets.pairs.len();
        self.triangles.clear();
        self.triangles.resize(sheets, 0);
        self.offsets.clear();
        self.offsets.resize(sheets + 2, 0);
        for_each_polygon(input, |sheet, _, triangles| {
            self.triangles[sheet as usize] += triangles as u32;
            self.offsets[sheet as usize + 2] += 1;
        });
        (0..sheets).for_each(|sheet| self.offsets[sheet + 2] += self.offsets[sheet + 1]);
        self.codes.clear();
        self.codes.resize(self.offsets[sheets + 1], 0);
        for_each_polygon(input, |sheet, code, _| {
            let next = &mut self.offsets[sheet as usize + 1];
            self.codes[*next] = code;
            *next += 1;
        });
    }

    /// The triangles of `sheet` into `out`, as ranks; counter-clockwise seen from outside (outer sheets) or from the
    /// upper fragment. `vertices` are the sheet's.
    pub fn write(&self, input: Input<'_>, ranks: &Ranks, sheet: usize, vertices: &[Point3<f64>], out: &mut [[u32; 3]]) {
        let mut writer = Writer { out, next: 0, vertices };
        for &code in &self.codes[self.offsets[sheet]..self.offsets[sheet + 1]] {
            let (simplex, polygon) = ((code >> POLYGON_BITS) as usize, (code & ((1 << POLYGON_BITS) - 1)) as usize);
            if sheet < input.fragments {
                let (corners, split) = outer_polygon(input, ranks, simplex, polygon);
                writer.write(corners, split);
            } else {
                let (corners, split) = crack_polygon(input, ranks, simplex, polygon, sheet as u32);
                writer.write(corners, split);
            }
        }
    }
}

/// Calls `tell(sheet, code, triangles)` for every polygon, in lattice order.
fn for_each_polygon(input: Input<'_>, mut tell: impl FnMut(u32, u32, usize)) {
    for (face, outer) in input.topology.boundary.iter().enumerate() {
        let labels = outer.nodes.map(|node| input.labels[node as usize]);
        for corner in 0..3 {
            if let Some(triangles) = outer_triangles(labels, corner) {
                tell(labels[corner], (face as u32) << POLYGON_BITS | corner as u32, triangles);
            }
        }
    }
    for (tet, nodes) in input.lattice.tets.iter().enumerate() {
        let labels = nodes.map(|node| input.labels[node as usize]);
        for (index, polygon) in PATTERNS[mask(labels)].polygons().iter().enumerate() {
            let sheet = input.edge_sheet(input.topology.tet_edges[tet][polygon.edge as usize]);
            tell(sheet, (tet as u32) << POLYGON_BITS | index as u32, polygon.split.triangles());
        }
    }
}

/// Triangles of the outer polygon that begins at `corner` of a boundary face: a polygon begins where, going round, a
/// label does; that of a face with one label begins at corner 0.
fn outer_triangles(labels: [u32; 3], corner: usize) -> Option<usize> {
    let [own, next, previous] = [0, 1, 2].map(|step| labels[(corner + step) % 3]);
    match (own == next, own == previous) {
        (true, true) => (corner == 0).then_some(1),
        (true, false) => Some(2),
        (false, true) => None,
        (false, false) => Some(if next == previous { 1 } else { 2 }),
    }
}

/// Ranks of the corners of the outer polygon that begins at `corner` of boundary face `face`.
fn outer_polygon(input: Input<'_>, ranks: &Ranks, face: usize, corner: usize) -> ([u32; 4], Split) {
    let outer = input.topology.boundary[face];
    let labels = outer.nodes.map(|node| input.labels[node as usize]);
    let [a, b, c] = [0, 1, 2].map(|step| (corner + step) % 3);
    let own = labels[a];
    let node = |k: usize| ranks.node[outer.nodes[k] as usize];
    let edge = |k: usize| {
        let slot = input.points.edges.slots[outer.edges[k] as usize] as usize;
        let first = input.topology.edges[outer.edges[k] as usize][0];
        ranks.edge_outer[slot][usize::from(input.labels[first as usize] != own)]
    };
    match (own == labels[b], own == labels[c]) {
        (true, true) => ([node(a), node(b), node(c), node(a)], Split::Triangle),
        (true, false) => ([node(a), node(b), edge(b), edge(c)], Split::Shorter),
        _ if labels[b] == labels[c] => ([node(a), edge(a), edge(c), node(a)], Split::Triangle),
        _ => {
            let slot = input.points.faces.slots[outer.face as usize] as usize;
            let nodes = input.topology.faces[outer.face as usize];
            let place = usize::from(nodes[1] == outer.nodes[a]) + 2 * usize::from(nodes[2] == outer.nodes[a]);
            // Split from the node: the face point is inside the face, so that neither triangle can fold over.
            ([node(a), edge(a), ranks.face_outer[slot][place], edge(c)], Split::First)
        }
    }
}

/// Ranks of the corners of polygon `index` of tetrahedron `tet` in crack `sheet`, lower fragment behind it.
fn crack_polygon(input: Input<'_>, ranks: &Ranks, tet: usize, index: usize, sheet: u32) -> ([u32; 4], Split) {
    let labels = input.lattice.tets[tet].map(|node| input.labels[node as usize]);
    let polygon = PATTERNS[mask(labels)].polygon(index);
    let corners = polygon.corners.map(|code| match code {
        TET_CODE => ranks.tet[input.points.tets.slots[tet] as usize][polygon.edge as usize],
        FACE_CODE.. => {
            let face = input.topology.tet_faces[tet][(code - FACE_CODE) as usize];
            let slot = input.points.faces.slots[face as usize] as usize;
            let [first, second, _] = input.sheets.of_face[slot];
            let place = if first == sheet {
                0
            } else if second == sheet {
                1
            } else {
                2
            };
            ranks.face[slot][place]
        }
        _ => ranks.edge[input.points.edges.slots[input.topology.tet_edges[tet][code as usize] as usize] as usize],
    });
    let [from, to] = crate::lattice::EDGES[polygon.edge as usize].map(|node| labels[node]);
    let [p, q, r, s] = corners;
    match (from < to, polygon.split) {
        (true, split) => (corners, split),
        (false, Split::Triangle) => ([p, r, q, p], Split::Triangle),
        (false, split) => ([p, s, r, q], split),
    }
}

struct Writer<'a> {
    out: &'a mut [[u32; 3]],
    next: usize,
    vertices: &'a [Point3<f64>],
}

impl Writer<'_> {
    fn write(&mut self, corners: [u32; 4], split: Split) {
        let [p, q, r, s] = corners;
        match split {
            Split::Triangle => self.push([p, q, r]),
            Split::Shorter if self.apart(q, s) < self.apart(p, r) => {
                self.push([q, r, s]);
                self.push([s, p, q]);
            }
            Split::Shorter | Split::First => {
                self.push([p, q, r]);
                self.push([r, s, p]);
            }
        }
    }

    fn push(&mut self, triangle: [u32; 3]) {
        self.out[self.next] = triangle;
        self.next += 1;
    }

    fn apart(&self, a: u32, b: u32) -> f64 {
        (self.vertices[a as usize] - self.vertices[b as usize]).norm_squared()
    }
}
