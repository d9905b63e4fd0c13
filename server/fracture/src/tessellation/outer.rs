//! Positions of the vertices of outer runs in the lattice, for the transfer of boundary data to them.

use super::{CrackPoints, Topology};
use nalgebra::Point3;

/// A vertex of an outer run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OuterVertex {
    /// A node of the lattice.
    Node(u32),
    /// A crack point on the given edge, local.
    Edge(u32, Point3<f64>),
    /// A crack point on the given face, local.
    Face(u32, Point3<f64>),
}

/// The vertices of the outer runs of the first `fragments` labels, in the order of
/// [`super::Tessellation::run_vertices`].
///
/// Nodes come first, then points on edges, then points on faces, each ascending.
pub fn outer_vertices(
    topology: &Topology,
    labels: &[u32],
    points: &CrackPoints,
    fragments: usize,
) -> Vec<Vec<OuterVertex>> {
    let mut outer = vec![Vec::new(); fragments];
    let mut put = |node: u32, origin: OuterVertex| {
        if let Some(own) = outer.get_mut(labels[node as usize] as usize) {
            own.push(origin);
        }
    };
    topology.boundary_nodes.iter().for_each(|&node| put(node, OuterVertex::Node(node)));
    for (&edge, &place) in points.edges.simplices.iter().zip(&points.edges.places) {
        if topology.boundary_edge[edge as usize] {
            topology.edges[edge as usize].iter().for_each(|&node| put(node, OuterVertex::Edge(edge, place)));
        }
    }
    for (&face, &place) in points.faces.simplices.iter().zip(&points.faces.places) {
        if topology.boundary_face[face as usize] {
            topology.faces[face as usize].iter().for_each(|&node| put(node, OuterVertex::Face(face, place)));
        }
    }
    outer
}

/// Boundary faces that contain the triangles of each fragment's outer run, in their order.
///
/// `labels` has one entry per node. Fragments that are not among the first `fragments` are left out.
pub fn outer_sources(topology: &Topology, labels: &[u32], fragments: usize) -> Vec<Vec<u32>> {
    let mut sources = vec![Vec::new(); fragments];
    let mut put = |label: u32, face: usize, count: usize| {
        if let Some(own) = sources.get_mut(label as usize) {
            own.resize(own.len() + count, face as u32);
        }
    };
    for (face, outer) in topology.boundary.iter().enumerate() {
        let [a, b, c] = outer.nodes.map(|node| labels[node as usize]);
        match (a == b, b == c, c == a) {
            (true, true, _) => put(a, face, 1),
            (false, false, false) => [a, b, c].into_iter().for_each(|label| put(label, face, 2)),
            // A lone corner has a triangle, the two others have a quadrilateral.
            (true, ..) => [(a, 2), (c, 1)].into_iter().for_each(|(label, count)| put(label, face, count)),
            (_, true, _) => [(b, 2), (a, 1)].into_iter().for_each(|(label, count)| put(label, face, count)),
            _ => [(c, 2), (b, 1)].into_iter().for_each(|(label, count)| put(label, face, count)),
        }
    }
    sources
}
