//! Count and emit: the triangles of every sheet, each crack polygon once for both of its fragments.
//!
//! Polygons are found in lattice order, in parallel over parts of the lattice, where what they look up lies close
//! together; then they are grouped by sheet, and each sheet's triangles are written on their own.

use super::pattern::{FACE_CODE, PATTERNS, Split, TET_CODE};
use super::rank::{Input, Ranks};
use crate::lattice::EDGES;
use nalgebra::Point3;
use rayon::prelude::*;

/// Boundary faces or tetrahedra that one task looks through.
const CHUNK: usize = 2048;

/// One polygon: ranks of its corners in its sheet, counter-clockwise seen from outside (outer sheets) or from the upper
/// fragment. A triangle's last corner is of no meaning.
#[derive(Clone, Copy, Debug)]
struct Polygon {
    sheet: u32,
    corners: [u32; 4],
    split: Split,
}

/// Polygons grouped by sheet, each group in lattice order.
#[derive(Debug, Default)]
pub(super) struct Polygons {
    /// In lattice order, boundary first, by chunk.
    found: Vec<Vec<Polygon>>,
    grouped: Vec<Polygon>,
    /// First polygon of each sheet.
    offsets: Vec<usize>,
    /// Triangles of each sheet.
    pub triangles: Vec<u32>,
}

impl Polygons {
    /// Finds all polygons, counts the triangles of every sheet and groups the polygons.
    pub fn group(&mut self, input: Input<'_>, ranks: &Ranks) {
        self.find(input, ranks);
        let sheets = input.fragments + input.sheets.pairs.len();
        self.triangles.clear();
        self.triangles.resize(sheets, 0);
        self.offsets.clear();
        self.offsets.resize(sheets + 2, 0);
        for polygon in self.found.iter().flatten() {
            self.triangles[polygon.sheet as usize] += polygon.split.triangles() as u32;
            self.offsets[polygon.sheet as usize + 2] += 1;
        }
        (0..sheets).for_each(|sheet| self.offsets[sheet + 2] += self.offsets[sheet + 1]);
        self.grouped.resize(self.offsets[sheets + 1], Polygon { sheet: 0, corners: [0; 4], split: Split::Triangle });
        for &polygon in self.found.iter().flatten() {
            let next = &mut self.offsets[polygon.sheet as usize + 1];
            self.grouped[*next] = polygon;
            *next += 1;
        }
    }

    /// The triangles of `sheet` into `out`, as ranks. `vertices` are the sheet's.
    pub fn write(&self, sheet: usize, vertices: &[Point3<f64>], out: &mut [[u32; 3]]) {
        let mut next = 0;
        let mut push = |triangle: [u32; 3]| {
            out[next] = triangle;
            next += 1;
        };
        let apart = |a: u32, b: u32| (vertices[a as usize] - vertices[b as usize]).norm_squared();
        for &Polygon { corners: [p, q, r, s], split, .. } in &self.grouped[self.offsets[sheet]..self.offsets[sheet + 1]]
        {
            match split {
                Split::Triangle => push([p, q, r]),
                Split::Shorter if apart(q, s) < apart(p, r) => {
                    push([q, r, s]);
                    push([s, p, q]);
                }
                Split::Shorter | Split::First => {
                    push([p, q, r]);
                    push([r, s, p]);
                }
            }
        }
    }

    fn find(&mut self, input: Input<'_>, ranks: &Ranks) {
        let (faces, tets) = (input.topology.boundary.len(), input.lattice.tets.len());
        let outer_chunks = faces.div_ceil(CHUNK);
        self.found.resize_with(outer_chunks + tets.div_ceil(CHUNK), Vec::new);
        self.found.par_iter_mut().enumerate().for_each(|(chunk, found)| {
            found.clear();
            if chunk < outer_chunks {
                let first = chunk * CHUNK;
                (first..faces.min(first + CHUNK)).for_each(|face| outer_polygons(input, ranks, face, found));
            } else {
                let first = (chunk - outer_chunks) * CHUNK;
                (first..tets.min(first + CHUNK)).for_each(|tet| crack_polygons(input, ranks, tet, found));
            }
        });
    }
}

/// The polygons of boundary face `face`: one begins where, going round, a label does; that of a face with one label
/// begins at corner 0.
fn outer_polygons(input: Input<'_>, ranks: &Ranks, face: usize, found: &mut Vec<Polygon>) {
    let outer = &input.topology.boundary[face];
    let labels = outer.nodes.map(|node| input.labels[node as usize]);
    let node = |k: usize| ranks.node[outer.nodes[k] as usize];
    for (a, b, c) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
        let sheet = labels[a];
        let edge = |k: usize| {
            let [first, _] = input.topology.edges[outer.edges[k] as usize];
            let slot = input.points.edges.slots[outer.edges[k] as usize] as usize;
            ranks.edge_outer[slot][usize::from(input.labels[first as usize] != sheet)]
        };
        let (corners, split) = match (labels[a] == labels[b], labels[a] == labels[c]) {
            (true, true) if a == 0 => ([node(a), node(b), node(c), node(a)], Split::Triangle),
            (_, true) => continue,
            (true, false) => ([node(a), node(b), edge(b), edge(c)], Split::Shorter),
            _ if labels[b] == labels[c] => ([node(a), edge(a), edge(c), node(a)], Split::Triangle),
            // Split from the node: the face point is inside the face, so that neither triangle can fold over.
            _ => ([node(a), edge(a), face_rank(input, ranks, face, a), edge(c)], Split::First),
        };
        found.push(Polygon { sheet, corners, split });
    }
}

/// Rank of the point on boundary face `face` in the outer sheet of its corner `corner`.
fn face_rank(input: Input<'_>, ranks: &Ranks, face: usize, corner: usize) -> u32 {
    let outer = &input.topology.boundary[face];
    let nodes = input.topology.faces[outer.face as usize];
    let place = usize::from(nodes[1] == outer.nodes[corner]) + 2 * usize::from(nodes[2] == outer.nodes[corner]);
    ranks.face_outer[input.points.faces.slots[outer.face as usize] as usize][place]
}

/// The polygons inside tetrahedron `tet`.
fn crack_polygons(input: Input<'_>, ranks: &Ranks, tet: usize, found: &mut Vec<Polygon>) {
    let mask = input.points.masks[tet];
    if mask == 0 {
        return;
    }
    let nodes = &input.lattice.tets[tet];
    let slot = |edge: u8| input.points.edges.slots[input.topology.tet_edges[tet][edge as usize] as usize] as usize;
    for polygon in PATTERNS[mask as usize].polygons() {
        let sheet = input.sheets.of_edge[slot(polygon.edge)];
        let rank = |k: usize| match polygon.corners[k] {
            TET_CODE => ranks.tet[input.points.tets.slots[tet] as usize][polygon.edge as usize],
            code @ FACE_CODE.. => {
                let face = input.topology.tet_faces[tet][(code - FACE_CODE) as usize];
                let slot = input.points.faces.slots[face as usize] as usize;
                let [first, second, _] = input.sheets.of_face[slot];
                ranks.face[slot][if first == sheet {
                    0
                } else if second == sheet {
                    1
                } else {
                    2
                }]
            }
            code => ranks.edge[slot(code)],
        };
        let [p, q, r] = [rank(0), rank(1), rank(2)];
        let s = if polygon.split == Split::Triangle { p } else { rank(3) };
        let [from, to] = EDGES[polygon.edge as usize].map(|node| input.labels[nodes[node] as usize]);
        let corners = match (from < to, polygon.split) {
            (true, _) => [p, q, r, s],
            (false, Split::Triangle) => [p, r, q, p],
            (false, _) => [p, s, r, q],
        };
        found.push(Polygon { sheet, corners, split: polygon.split });
    }
}
