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
/// fragment. A quadrilateral splits from its first to its third corner.
#[derive(Clone, Copy, Debug, Default)]
struct Polygon {
    sheet: u32,
    corners: [u32; 4],
    is_triangle: bool,
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
            self.triangles[polygon.sheet as usize] += if polygon.is_triangle { 1 } else { 2 };
            self.offsets[polygon.sheet as usize + 2] += 1;
        }
        (0..sheets).for_each(|sheet| self.offsets[sheet + 2] += self.offsets[sheet + 1]);
        self.grouped.resize(self.offsets[sheets + 1], Polygon::default());
        for &polygon in self.found.iter().flatten() {
            let next = &mut self.offsets[polygon.sheet as usize + 1];
            self.grouped[*next] = polygon;
            *next += 1;
        }
    }

    /// The triangles of `sheet` into `out`, as ranks.
    pub fn write(&self, sheet: usize, out: &mut [[u32; 3]]) {
        let mut next = 0;
        let mut push = |triangle: [u32; 3]| {
            out[next] = triangle;
            next += 1;
        };
        for polygon in &self.grouped[self.offsets[sheet]..self.offsets[sheet + 1]] {
            let [p, q, r, s] = polygon.corners;
            push([p, q, r]);
            if !polygon.is_triangle {
                push([r, s, p]);
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
        let slot = |k: usize| input.points.edges.slots[outer.edges[k] as usize] as usize;
        let edge = |k: usize| {
            let [first, _] = input.topology.edges[outer.edges[k] as usize];
            ranks.edge_outer[slot(k)][usize::from(input.labels[first as usize] != sheet)]
        };
        let (corners, is_triangle) = match (labels[a] == labels[b], labels[a] == labels[c]) {
            (true, true) if a == 0 => ([node(a), node(b), node(c), node(a)], true),
            (_, true) => continue,
            (true, false) => {
                let place = |k: usize| input.lattice.nodes[outer.nodes[k] as usize];
                let point = |k: usize| input.points.edges.places[slot(k)];
                let [first, second] = [apart(place(a), point(b)), apart(place(b), point(c))];
                (rotated([node(a), node(b), edge(b), edge(c)], second < first), false)
            }
            _ if labels[b] == labels[c] => ([node(a), edge(a), edge(c), node(a)], true),
            // From the node: the face point is inside the face, so that neither triangle can fold over.
            _ => ([node(a), edge(a), face_rank(input, ranks, face, a), edge(c)], false),
        };
        found.push(Polygon { sheet, corners, is_triangle });
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
    let labels = input.lattice.tets[tet].map(|node| input.labels[node as usize]);
    let slots = input.topology.tet_edges[tet].map(|edge| input.points.edges.slots[edge as usize] as usize);
    let corners = Corners { input, ranks, tet, slots };
    let pattern = PATTERNS[mask as usize].polygons();
    let joint = mask.count_ones() == 5 && corners.second_is_shorter(&[pattern[0].corners, pattern[1].corners]);
    for polygon in pattern {
        let sheet = input.sheets.of_edge[slots[polygon.edge as usize]];
        let rank = |k: usize| corners.rank(polygon.corners[k], polygon.edge, sheet);
        let is_triangle = polygon.split == Split::Triangle;
        let [p, q, r] = [rank(0), rank(1), rank(2)];
        let s = if is_triangle { p } else { rank(3) };
        let second = match polygon.split {
            Split::Triangle | Split::First => false,
            Split::Either => corners.second_is_shorter(&[polygon.corners]),
            Split::Joint => joint,
        };
        let [p, q, r, s] = rotated([p, q, r, s], second);
        let [from, to] = EDGES[polygon.edge as usize].map(|node| labels[node]);
        let corners = if from < to {
            [p, q, r, s]
        } else if is_triangle {
            [p, r, q, p]
        } else {
            [p, s, r, q]
        };
        found.push(Polygon { sheet, corners, is_triangle });
    }
}

/// The points of one tetrahedron by corner code.
struct Corners<'a> {
    input: Input<'a>,
    ranks: &'a Ranks,
    tet: usize,
    /// Slots of its edge points; no slots where an edge is not cut.
    slots: [usize; 6],
}

impl Corners<'_> {
    fn face_slot(&self, code: u8) -> usize {
        let face = self.input.topology.tet_faces[self.tet][(code - FACE_CODE) as usize];
        self.input.points.faces.slots[face as usize] as usize
    }

    fn tet_slot(&self) -> usize {
        self.input.points.tets.slots[self.tet] as usize
    }

    /// Rank in crack `sheet`, the one of `edge`.
    #[inline]
    fn rank(&self, code: u8, edge: u8, sheet: u32) -> u32 {
        match code {
            ..FACE_CODE => self.ranks.edge[self.slots[code as usize]],
            TET_CODE => self.ranks.tet[self.tet_slot()][edge as usize],
            _ => {
                let slot = self.face_slot(code);
                let [first, second, _] = self.input.sheets.of_face[slot];
                self.ranks.face[slot][if first == sheet {
                    0
                } else if second == sheet {
                    1
                } else {
                    2
                }]
            }
        }
    }

    #[inline]
    fn place(&self, code: u8) -> Point3<f64> {
        let points = self.input.points;
        match code {
            ..FACE_CODE => points.edges.places[self.slots[code as usize]],
            TET_CODE => points.tets.places[self.tet_slot()],
            _ => points.faces.places[self.face_slot(code)],
        }
    }

    /// Whether the diagonals from second to fourth corner are shorter than those from first to third, together.
    fn second_is_shorter(&self, quads: &[[u8; 4]]) -> bool {
        let total = |i: usize, j: usize| -> f64 {
            quads.iter().map(|corners| apart(self.place(corners[i]), self.place(corners[j]))).sum()
        };
        total(1, 3) < total(0, 2)
    }
}

/// Squared distance.
fn apart(a: Point3<f64>, b: Point3<f64>) -> f64 {
    (a - b).norm_squared()
}

/// Begins at the second corner if `second`, which so becomes an end of the diagonal.
fn rotated([p, q, r, s]: [u32; 4], second: bool) -> [u32; 4] {
    if second { [q, r, s, p] } else { [p, q, r, s] }
}
