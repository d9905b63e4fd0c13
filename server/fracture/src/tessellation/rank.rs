//! Ranks: the index of every point in every sheet that contains it, from which vertices and merges follow.
//!
//! The vertices of a sheet are its lattice nodes (outer sheets only), edge points, face points and tetrahedron points,
//! each ascending. A fragment has one vertex of a point per run that contains it. Its first run (the outer one, else
//! that with the lowest neighbor) keeps the vertex; the others merge into it.

use super::points::CrackPoints;
use super::sheet::CrackSheetIndex;
use super::topology::{FACE_EDGES, Topology};
use crate::lattice::{EDGES, Lattice};
use nalgebra::Point3;

/// Inputs of the ranks.
#[derive(Clone, Copy)]
pub(super) struct Input<'a> {
    pub lattice: &'a Lattice,
    pub topology: &'a Topology,
    pub labels: &'a [u32],
    pub fragments: usize,
    pub points: &'a CrackPoints,
    pub sheets: &'a CrackSheetIndex,
}

/// Ranks of points in sheets, by boundary, cut edge, cut face and cut tetrahedron.
///
/// Outer ranks of points inside the lattice are not set.
#[derive(Debug, Default)]
pub(super) struct Ranks {
    /// Fragment of each boundary node, and its rank in the outer sheet; side by side, because they are read together.
    pub node: Vec<[u32; 2]>,
    /// Rank of each edge point in the crack of the edge.
    pub edge: Vec<u32>,
    /// Ranks of each edge point in the outer sheets of the edge's two nodes.
    pub edge_outer: Vec<[u32; 2]>,
    /// Ranks of each face point in the cracks of the face's three edges.
    pub face: Vec<[u32; 3]>,
    /// Ranks of each face point in the outer sheets of the face's three nodes.
    pub face_outer: Vec<[u32; 3]>,
    /// Ranks of each tetrahedron point in the cracks of the tetrahedron's six edges.
    pub tet: Vec<[u32; 6]>,
    /// Number of vertices of each sheet.
    pub vertices: Vec<u32>,
}

/// A vertex of a run on side `side` of `sheet`: 0 is the lower fragment's; outer sheets have only side 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct RunVertex {
    pub sheet: u32,
    pub side: usize,
    pub rank: u32,
}

/// Two vertices of one fragment at the same point, the later and the first.
#[derive(Clone, Copy, Debug)]
pub(super) struct MergePair {
    pub from: RunVertex,
    pub to: RunVertex,
}

impl Ranks {
    /// Computes all ranks, and the number of vertices of each sheet.
    pub fn count(&mut self, input: Input<'_>) {
        let mut vertices = std::mem::take(&mut self.vertices);
        vertices.clear();
        vertices.resize(input.fragments + input.sheets.pairs.len(), 0);
        let mut next = |sheet: u32| {
            let count = &mut vertices[sheet as usize];
            *count += 1;
            *count - 1
        };
        self.node.clear();
        self.node.resize(input.topology.nodes, [0; 2]);
        for &node in &input.topology.boundary_nodes {
            let label = input.labels[node as usize];
            self.node[node as usize] = [label, next(label)];
        }
        self.count_edges(input, &mut next);
        self.count_faces(input, &mut next);
        self.tet.clear();
        self.tet.extend(input.points.tets.simplices.iter().map(|&tet| input.tet_sheets(tet).map(&mut next)));
        self.vertices = vertices;
    }

    fn count_edges(&mut self, input: Input<'_>, mut next: impl FnMut(u32) -> u32) {
        self.edge.clear();
        self.edge_outer.clear();
        let points = input.points;
        for ((&edge, &sheet), sides) in points.edges.simplices.iter().zip(&input.sheets.of_edge).zip(&points.sides) {
            self.edge.push(next(sheet));
            let outer = input.topology.boundary_edge[edge as usize];
            self.edge_outer.push(if outer { sides.map(&mut next) } else { [0; 2] });
        }
    }

    fn count_faces(&mut self, input: Input<'_>, mut next: impl FnMut(u32) -> u32) {
        self.face.clear();
        self.face_outer.clear();
        for (&face, &sheets) in input.points.faces.simplices.iter().zip(&input.sheets.of_face) {
            self.face.push(sheets.map(&mut next));
            let outer = input.topology.boundary_face[face as usize];
            let nodes = input.topology.faces[face as usize];
            self.face_outer.push(if outer { nodes.map(|node| next(input.labels[node as usize])) } else { [0; 3] });
        }
    }

    /// Writes every merge to `merges`, ascending in rank within each run, and counts those of each crack's two runs in
    /// `counts`.
    ///
    /// The lower fragment's run comes first.
    pub fn list_merges(&self, input: Input<'_>, merges: &mut Vec<MergePair>, counts: &mut Vec<[u32; 2]>) {
        merges.clear();
        counts.clear();
        counts.resize(input.sheets.pairs.len(), [0; 2]);
        self.for_each_merge(input, |merge| {
            counts[merge.from.sheet as usize - input.fragments][merge.from.side] += 1;
            merges.push(merge);
        });
    }

    fn for_each_merge(&self, input: Input<'_>, mut visit: impl FnMut(MergePair)) {
        self.edge_merges(input, &mut visit);
        self.face_merges(input, &mut visit);
        self.tet_merges(input, &mut visit);
    }

    fn edge_merges(&self, input: Input<'_>, visit: &mut impl FnMut(MergePair)) {
        for (slot, &edge) in input.points.edges.simplices.iter().enumerate() {
            if !input.topology.boundary_edge[edge as usize] {
                continue;
            }
            let labels = input.points.sides[slot];
            for own in 0..2 {
                let side = side(labels[own], labels[1 - own]);
                let from = RunVertex { sheet: input.sheets.of_edge[slot], side, rank: self.edge[slot] };
                visit(MergePair {
                    from,
                    to: RunVertex { sheet: labels[own], side: 0, rank: self.edge_outer[slot][own] },
                });
            }
        }
    }

    fn face_merges(&self, input: Input<'_>, visit: &mut impl FnMut(MergePair)) {
        for (slot, &face) in input.points.faces.simplices.iter().enumerate() {
            let labels = input.topology.faces[face as usize].map(|node| input.labels[node as usize]);
            let outer = input.topology.boundary_face[face as usize];
            let sheets = input.sheets.of_face[slot];
            let meeting = Meeting { labels: &labels, edges: &FACE_EDGES, sheets: &sheets, ranks: &self.face[slot] };
            for (own, (&sheet, &rank)) in labels.iter().zip(&self.face_outer[slot]).enumerate() {
                let to = RunVertex { sheet, side: 0, rank };
                meeting.merge_into(own, if outer { to } else { meeting.first_run(own) }, visit);
            }
        }
    }

    fn tet_merges(&self, input: Input<'_>, visit: &mut impl FnMut(MergePair)) {
        for (&tet, ranks) in input.points.tets.simplices.iter().zip(&self.tet) {
            let labels = input.lattice.tets[tet as usize].map(|node| input.labels[node as usize]);
            let sheets = input.tet_sheets(tet);
            let meeting = Meeting { labels: &labels, edges: &EDGES, sheets: &sheets, ranks };
            (0..4).for_each(|own| meeting.merge_into(own, meeting.first_run(own), visit));
        }
    }

    /// Writes the vertices of all sheets; sheet s begins at `offsets[s]`.
    pub fn write_vertices(&self, input: Input<'_>, offsets: &[usize], vertices: &mut [Point3<f64>]) {
        let mut put = |sheet: u32, rank: u32, place: Point3<f64>| {
            vertices[offsets[sheet as usize] + rank as usize] = place;
        };
        let label = |node: u32| input.labels[node as usize];
        for &node in &input.topology.boundary_nodes {
            let [label, rank] = self.node[node as usize];
            put(label, rank, input.lattice.nodes[node as usize]);
        }
        let CrackPoints { edges, faces, tets, .. } = input.points;
        for (slot, (&edge, &place)) in edges.simplices.iter().zip(&edges.places).enumerate() {
            put(input.sheets.of_edge[slot], self.edge[slot], place);
            if input.topology.boundary_edge[edge as usize] {
                (0..2).for_each(|k| put(input.points.sides[slot][k], self.edge_outer[slot][k], place));
            }
        }
        for (slot, (&face, &place)) in faces.simplices.iter().zip(&faces.places).enumerate() {
            (0..3).for_each(|k| put(input.sheets.of_face[slot][k], self.face[slot][k], place));
            if input.topology.boundary_face[face as usize] {
                let nodes = input.topology.faces[face as usize];
                (0..3).for_each(|k| put(label(nodes[k]), self.face_outer[slot][k], place));
            }
        }
        for ((&tet, &place), ranks) in tets.simplices.iter().zip(&tets.places).zip(&self.tet) {
            let sheets = input.tet_sheets(tet);
            (0..6).for_each(|k| put(sheets[k], ranks[k], place));
        }
    }
}

impl Input<'_> {
    /// The cracks of the six edges of a tetrahedron with four labels.
    pub fn tet_sheets(&self, tet: u32) -> [u32; 6] {
        self.topology.tet_edges[tet as usize].map(|edge| self.edge_sheet(edge))
    }

    /// The crack that crosses a cut edge.
    pub fn edge_sheet(&self, edge: u32) -> u32 {
        self.sheets.of_edge[self.points.edges.slots[edge as usize] as usize]
    }
}

/// Side of a crack: 0 for the lower fragment, 1 for the upper.
fn side(own: u32, other: u32) -> usize {
    usize::from(own > other)
}

/// The cracks that meet at a face point or a tetrahedron point, by edge of its simplex.
struct Meeting<'a> {
    labels: &'a [u32],
    edges: &'a [[usize; 2]],
    sheets: &'a [u32],
    ranks: &'a [u32],
}

impl Meeting<'_> {
    /// The point as a vertex of each run of corner `own`'s label, with the label on the other side.
    fn runs(&self, own: usize) -> impl Iterator<Item = (u32, RunVertex)> {
        let touching = self.edges.iter().enumerate().filter(move |(_, edge)| edge.contains(&own));
        touching.map(move |(k, &[i, j])| {
            let across = self.labels[i + j - own];
            let side = side(self.labels[own], across);
            (across, RunVertex { sheet: self.sheets[k], side, rank: self.ranks[k] })
        })
    }

    /// The point as a vertex of the run of corner `own` with the lowest neighbor.
    fn first_run(&self, own: usize) -> RunVertex {
        let outside = (u32::MAX, RunVertex { sheet: self.labels[own], side: 0, rank: 0 });
        self.runs(own).fold(outside, |first, run| if run.0 < first.0 { run } else { first }).1
    }

    /// Merges the point's vertices in all cracks of corner `own`, except that of `to`, into `to`.
    fn merge_into(&self, own: usize, to: RunVertex, visit: &mut impl FnMut(MergePair)) {
        self.runs(own).filter(|(_, from)| from.sheet != to.sheet).for_each(|(_, from)| visit(MergePair { from, to }));
    }
}
