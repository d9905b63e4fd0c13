//! Triangles of every sheet: counting and writing, each crack polygon once for both of its fragments.
//!
//! Polygons are computed in lattice order, which keeps memory accesses local, in parallel over parts of the lattice.
//! Each part counts its triangles of each sheet and writes them into its own range of the sheet.

use super::pattern::{FACE_CODE, PATTERNS, PolygonSplit, TET_CODE};
use super::rank::{Input, Ranks};
use crate::lattice::EDGES;
use nalgebra::Point3;
use rayon::prelude::*;

/// Smallest number of boundary faces or cut tetrahedra in a part.
const PART_MIN: usize = 1024;

/// Largest number of parts, of the boundary and of the cut tetrahedra each.
const PARTS: usize = 12;

/// Triangles of one part, in lattice order.
///
/// Corners are ranks in the sheet, counter-clockwise seen from outside (outer sheets) or from the upper fragment.
#[derive(Debug, Default)]
struct Part {
    found: Vec<[u32; 3]>,
    /// Sheet and length of each sequence of triangles that belong to one sheet.
    sequences: Vec<(u32, u32)>,
    /// Number of triangles of each sheet.
    triangles: Vec<u32>,
}

/// All polygons, those of the boundary first.
#[derive(Debug, Default)]
pub(super) struct CrackPolygons {
    parts: Vec<Part>,
    /// Number of triangles of each sheet.
    pub triangles: Vec<u32>,
}

impl Part {
    fn begin(&mut self, sheets: usize) {
        self.found.clear();
        self.sequences.clear();
        self.triangles.clear();
        self.triangles.resize(sheets, 0);
    }

    fn end(&mut self) {
        self.sequences.iter().for_each(|&(sheet, count)| self.triangles[sheet as usize] += count);
    }

    fn triangle(&mut self, sheet: u32, corners: [u32; 3]) {
        self.found.push(corners);
        match self.sequences.last_mut() {
            Some((last, count)) if *last == sheet => *count += 1,
            _ => self.sequences.push((sheet, 1)),
        }
    }

    /// Adds a quadrilateral, split from its first to its third corner.
    fn quadrilateral(&mut self, sheet: u32, [p, q, r, s]: [u32; 4]) {
        self.triangle(sheet, [p, q, r]);
        self.triangle(sheet, [r, s, p]);
    }

    /// Writes the triangles into this part's range of each sheet. They fit exactly.
    fn write(&self, pieces: &mut [&mut [[u32; 3]]]) {
        let mut rest = &self.found[..];
        for &(sheet, count) in &self.sequences {
            let (own, others) = rest.split_at(count as usize);
            let piece = &mut pieces[sheet as usize];
            let (out, free) = std::mem::take(piece).split_at_mut(count as usize);
            out.copy_from_slice(own);
            (rest, *piece) = (others, free);
        }
    }
}

impl CrackPolygons {
    /// Computes all polygons and counts the triangles of every sheet.
    pub fn find(&mut self, input: Input<'_>, ranks: &Ranks) {
        let (boundary, cut) = (input.topology.boundary.len(), &input.points.cut_tets);
        let sheets = input.fragments + input.sheets.pairs.len();
        let size = |count: usize| count.div_ceil(PARTS).max(PART_MIN);
        let [outer_size, cut_size] = [size(boundary), size(cut.len())];
        let outer_parts = boundary.div_ceil(outer_size);
        self.parts.resize_with(outer_parts + cut.len().div_ceil(cut_size), Part::default);
        self.parts.par_iter_mut().enumerate().for_each(|(part, own)| {
            own.begin(sheets);
            if part < outer_parts {
                let first = part * outer_size;
                (first..boundary.min(first + outer_size)).for_each(|face| outer_polygons(input, ranks, face, own));
            } else {
                let first = (part - outer_parts) * cut_size;
                let tets = &cut[first..cut.len().min(first + cut_size)];
                tets.iter().for_each(|tet| crack_polygons(input, ranks, *tet as usize, own));
            }
            own.end();
        });
        self.triangles.clear();
        self.triangles.resize(sheets, 0);
        for part in &self.parts {
            self.triangles.iter_mut().zip(&part.triangles).for_each(|(sum, own)| *sum += own);
        }
    }

    /// Writes all triangles, sheet by sheet, as ranks. `out` has the length of their total number.
    pub fn write(&self, out: &mut [[u32; 3]]) {
        let sheets = self.triangles.len();
        let mut pieces: Vec<_> = self.parts.iter().map(|_| Vec::with_capacity(sheets)).collect();
        let mut rest = out;
        for sheet in 0..sheets {
            for (part, pieces) in self.parts.iter().zip(&mut pieces) {
                let (own, others) = rest.split_at_mut(part.triangles[sheet] as usize);
                pieces.push(own);
                rest = others;
            }
        }
        self.parts.par_iter().zip(pieces).for_each(|(part, mut pieces)| part.write(&mut pieces));
    }
}

/// Adds the polygons of boundary face `face`: each starts at the first corner of its label in cyclic order, or at
/// corner 0.
fn outer_polygons(input: Input<'_>, ranks: &Ranks, face: usize, found: &mut Part) {
    let outer = &input.topology.boundary[face];
    let nodes = outer.nodes.map(|node| ranks.node[node as usize]);
    let (labels, node) = (nodes.map(|[label, _]| label), |k: usize| nodes[k][1]);
    if labels[0] == labels[1] && labels[0] == labels[2] {
        return found.triangle(labels[0], [node(0), node(1), node(2)]);
    }
    for (a, b, c) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
        let sheet = labels[a];
        let slot = |k: usize| input.points.edges.slots[outer.edges[k] as usize] as usize;
        let edge = |k: usize| {
            let [first, _] = input.topology.edges[outer.edges[k] as usize];
            ranks.edge_outer[slot(k)][usize::from(input.labels[first as usize] != sheet)]
        };
        match (labels[a] == labels[b], labels[a] == labels[c]) {
            (_, true) => {}
            (true, false) => {
                let place = |k: usize| input.lattice.nodes[outer.nodes[k] as usize];
                let point = |k: usize| input.points.edges.places[slot(k)];
                let [first, second] = [apart(place(a), point(b)), apart(place(b), point(c))];
                found.quadrilateral(sheet, rotated([node(a), node(b), edge(b), edge(c)], second < first));
            }
            _ if labels[b] == labels[c] => found.triangle(sheet, [node(a), edge(a), edge(c)]),
            // Split from the node. The face point is inside the face, so neither triangle can fold over.
            _ => found.quadrilateral(sheet, [node(a), edge(a), face_rank(input, ranks, face, a), edge(c)]),
        }
    }
}

/// Rank of the point on boundary face `face` in the outer sheet of its corner `corner`.
fn face_rank(input: Input<'_>, ranks: &Ranks, face: usize, corner: usize) -> u32 {
    let outer = &input.topology.boundary[face];
    let nodes = input.topology.faces[outer.face as usize];
    let place = usize::from(nodes[1] == outer.nodes[corner]) + 2 * usize::from(nodes[2] == outer.nodes[corner]);
    ranks.face_outer[input.points.faces.slots[outer.face as usize] as usize][place]
}

/// Adds the polygons inside the cut tetrahedron `tet`.
fn crack_polygons(input: Input<'_>, ranks: &Ranks, tet: usize, found: &mut Part) {
    let mask = input.points.masks[tet];
    let labels = input.lattice.tets[tet].map(|node| input.labels[node as usize]);
    let slots = input.topology.tet_edges[tet].map(|edge| input.points.edges.slots[edge as usize] as usize);
    let corners = Corners { input, ranks, tet, slots };
    let pattern = PATTERNS[mask as usize].polygons();
    let joint = mask.count_ones() == 5 && corners.second_is_shorter(&[pattern[0].corners, pattern[1].corners]);
    for polygon in pattern {
        let sheet = input.sheets.of_edge[slots[polygon.edge as usize]];
        let rank = |k: usize| corners.rank(polygon.corners[k], polygon.edge, sheet);
        let [from, to] = EDGES[polygon.edge as usize].map(|node| labels[node]);
        let [p, q, r] = [rank(0), rank(1), rank(2)];
        let second = match polygon.split {
            PolygonSplit::Triangle => {
                found.triangle(sheet, if from < to { [p, q, r] } else { [p, r, q] });
                continue;
            }
            PolygonSplit::First => false,
            PolygonSplit::Either => corners.second_is_shorter(&[polygon.corners]),
            PolygonSplit::Joint => joint,
        };
        let [p, q, r, s] = rotated([p, q, r, rank(3)], second);
        found.quadrilateral(sheet, if from < to { [p, q, r, s] } else { [p, s, r, q] });
    }
}

/// Points of one tetrahedron by corner code.
struct Corners<'a> {
    input: Input<'a>,
    ranks: &'a Ranks,
    tet: usize,
    /// Slots of the edge points; invalid for edges that are not cut.
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

    /// Rank in crack `sheet`, which must be that of `edge`.
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
    fn position(&self, code: u8) -> Point3<f64> {
        let points = self.input.points;
        match code {
            ..FACE_CODE => points.edges.places[self.slots[code as usize]],
            TET_CODE => points.tets.places[self.tet_slot()],
            _ => points.faces.places[self.face_slot(code)],
        }
    }

    /// True if the total length of the diagonals from second to fourth corner is below that of the others (by squared
    /// lengths).
    fn second_is_shorter(&self, quads: &[[u8; 4]]) -> bool {
        let total = |i: usize, j: usize| -> f64 {
            quads.iter().map(|corners| apart(self.position(corners[i]), self.position(corners[j]))).sum()
        };
        total(1, 3) < total(0, 2)
    }
}

/// Squared distance.
fn apart(a: Point3<f64>, b: Point3<f64>) -> f64 {
    (a - b).norm_squared()
}

/// The corners, rotated if `second` so that the second corner is an end of the diagonal.
fn rotated([p, q, r, s]: [u32; 4], second: bool) -> [u32; 4] {
    if second { [q, r, s, p] } else { [p, q, r, s] }
}
