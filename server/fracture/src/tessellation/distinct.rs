//! Distinct positions in single precision, so that a reader that joins equal positions finds the same closed surface.
//!
//! Points of the input surface and crack points near them can be closer than single precision resolves: in triangles
//! with a small height, or in almost flat tetrahedra. Such *close vertices* are listed by a bound. Only they are compared
//! when a fragment is written, and one of two at the same position is moved by the spacing of single precision.
//!
//! Ours. The bound: let p be a point in the interior of a simplex s with barycentric coordinates of at least m, and let h
//! be the smallest height of all tetrahedra around s. A barycentric coordinate changes by at most |p − q|/h from p to q,
//! and is 0 outside the open star of s. So every point q outside the star, or on a simplex that lacks a node of s, is at
//! a distance of at least m·h. Points on simplices that contain s are at this distance by their own m and h.

use super::cut::NONE;
use super::flat_simplices::is_close;
use super::rank::{Input, Ranks};
use super::{RunRange, Tessellation};
use std::collections::{HashMap, HashSet};
use std::ops::Range;

impl Ranks {
    /// Lists the close vertices, ascending; sheet s begins at `offsets[s]`.
    pub fn list_close_vertices(&self, input: Input<'_>, offsets: &[usize], close: &mut Vec<u32>) {
        close.clear();
        let Input { topology, points, .. } = input;
        let flat = &topology.flat;
        let mut list = CloseVertices { ranks: self, input, offsets, close };
        flat.nodes.iter().filter(|node| topology.is_boundary_node(**node)).for_each(|&node| list.node(node));
        let slot = |slots: &[u32], simplex: u32| Some(slots[simplex as usize]).filter(|slot| *slot != NONE);
        for &edge in &flat.edges {
            let Some(slot) = slot(&points.edges.slots, edge) else { continue };
            let (place, nodes) = (points.edges.places[slot as usize], topology.edges[edge as usize]);
            let [from, to] = nodes.map(|node| input.lattice.nodes[node as usize]);
            let margin = (place - from).norm().min((place - to).norm()) / (to - from).norm();
            if is_close(margin, flat.height(nodes)) {
                list.edge_with_nodes(slot as usize, edge);
            }
        }
        for &face in &flat.faces {
            slot(&points.faces.slots, face).into_iter().for_each(|slot| list.face_with_edges(slot as usize, face));
        }
        for &tet in &flat.tets {
            slot(&points.tets.slots, tet).into_iter().for_each(|slot| list.tet_with_faces(slot as usize, tet));
        }
        close.sort_unstable();
        close.dedup();
    }
}

/// List of close vertices. With a point, the points on the boundary of its simplex are listed.
struct CloseVertices<'a> {
    ranks: &'a Ranks,
    input: Input<'a>,
    offsets: &'a [usize],
    close: &'a mut Vec<u32>,
}

impl CloseVertices<'_> {
    fn push(&mut self, sheet: u32, rank: u32) {
        self.close.push((self.offsets[sheet as usize] + rank as usize) as u32);
    }

    fn node(&mut self, node: u32) {
        let [label, rank] = self.ranks.node[node as usize];
        self.push(label, rank);
    }

    fn edge_with_nodes(&mut self, slot: usize, edge: u32) {
        self.push(self.input.sheets.of_edge[slot], self.ranks.edge[slot]);
        if self.input.topology.boundary_edge[edge as usize] {
            (0..2).for_each(|k| self.push(self.input.points.sides[slot][k], self.ranks.edge_outer[slot][k]));
        }
        for node in self.input.topology.edges[edge as usize] {
            if self.input.topology.is_boundary_node(node) {
                self.node(node);
            }
        }
    }

    fn face_with_edges(&mut self, slot: usize, face: u32) {
        (0..3).for_each(|k| self.push(self.input.sheets.of_face[slot][k], self.ranks.face[slot][k]));
        if self.input.topology.boundary_face[face as usize] {
            let nodes = self.input.topology.faces[face as usize];
            let label = |k: usize| self.input.labels[nodes[k] as usize];
            (0..3).for_each(|k| self.push(label(k), self.ranks.face_outer[slot][k]));
        }
        for edge in self.input.topology.face_edges[face as usize] {
            self.edge_with_nodes(self.input.points.edges.slots[edge as usize] as usize, edge);
        }
    }

    fn tet_with_faces(&mut self, slot: usize, tet: u32) {
        let sheets = self.input.tet_sheets(tet);
        (0..6).for_each(|k| self.push(sheets[k], self.ranks.tet[slot][k]));
        for face in self.input.topology.tet_faces[tet as usize] {
            self.face_with_edges(self.input.points.faces.slots[face as usize] as usize, face);
        }
    }
}

impl Tessellation {
    /// Moves vertices of a fragment that have the position of another point. `positions` are those of all fragments.
    pub(super) fn make_distinct(&self, positions: &mut [[f32; 3]]) {
        if self.close_vertices.is_empty() {
            return;
        }
        for range in &self.fragments {
            let close = self.close_in(range.runs.clone(), range.vertices.start);
            if !close.is_empty() {
                let merges = &self.merges[range.merges.clone()];
                separate(&mut positions[range.vertices.clone()], merges, &close);
            }
        }
    }

    /// The close vertices of some runs, ascending, relative to `first`.
    fn close_in(&self, runs: Range<usize>, first: usize) -> Vec<u32> {
        let of_run = |run: &RunRange| {
            let sheet = self.vertex_offsets[run.sheet] as u32..self.vertex_offsets[run.sheet + 1] as u32;
            let [from, to] =
                [sheet.start, sheet.end].map(|end| self.close_vertices.partition_point(|&vertex| vertex < end));
            let start = run.vertices.start - first;
            self.close_vertices[from..to].iter().map(move |vertex| vertex - sheet.start + start as u32)
        };
        self.runs[runs].iter().flat_map(of_run).collect()
    }
}

/// Gives the points of `close` vertices different positions. `merges` joins vertices of one point.
fn separate(positions: &mut [[f32; 3]], merges: &[[u32; 2]], close: &[u32]) {
    let joined: HashMap<u32, u32> =
        merges.iter().filter(|[from, _]| close.binary_search(from).is_ok()).map(|&[from, to]| (from, to)).collect();
    let mut taken = HashSet::new();
    for vertex in close.iter().filter(|vertex| !joined.contains_key(vertex)) {
        let position = &mut positions[*vertex as usize];
        let own = *position;
        let mut shifts = shifts(own);
        while !taken.insert(position.map(|x| (x + 0.0).to_bits())) {
            *position = shifts.next().unwrap_or(own);
        }
    }
    for (from, to) in joined {
        positions[from as usize] = positions[to as usize];
    }
}

/// Positions near `position`, at multiples of the spacing of single precision at its largest coordinate.
fn shifts(position: [f32; 3]) -> impl Iterator<Item = [f32; 3]> {
    let largest = position.iter().fold(f32::MIN_POSITIVE / f32::EPSILON, |most, x| most.max(x.abs()));
    (1_u16..=u16::MAX).flat_map(move |count| {
        (0..6).map(move |side| {
            let mut shifted = position;
            let distance = f32::from(count) * f32::EPSILON * largest;
            shifted[side % 3] += if side < 3 { distance } else { -distance };
            shifted
        })
    })
}
