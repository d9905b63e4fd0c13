//! Incidences of a lattice, prepared once per body for all of its tessellations.

use super::TessellationError;
use super::flat_quads::FlatQuads;
use super::flat_simplices::FlatSimplices;
use crate::lattice::{BoundaryFace, EDGES, FACES, Lattice};
use crate::memory::held;

/// Edges of a face by index in its sorted node triple; edge k of [`Topology::face_edges`].
pub const FACE_EDGES: [[usize; 2]; 3] = [[0, 1], [0, 2], [1, 2]];

/// A triangle of the lattice's boundary with its incidences.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OuterFace {
    /// Node indices, counter-clockwise seen from outside.
    pub nodes: [u32; 3],
    /// Edges; edge k joins `nodes[k]` and `nodes[(k + 1) % 3]`.
    pub edges: [u32; 3],
    /// Index in [`Topology::faces`].
    pub face: u32,
    /// The tetrahedron of the face.
    pub tet: u32,
}

/// Edges, faces and boundary of a lattice, with their incidences.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Topology {
    /// Number of lattice nodes.
    pub nodes: usize,
    /// All edges as (lower node, higher node), sorted.
    pub edges: Vec<[u32; 2]>,
    /// All faces with ascending nodes, sorted.
    pub faces: Vec<[u32; 3]>,
    /// The edges of each face, in the order of [`FACE_EDGES`].
    pub face_edges: Vec<[u32; 3]>,
    /// The edges of each tetrahedron, in the order of [`EDGES`].
    pub tet_edges: Vec<[u32; 6]>,
    /// The faces of each tetrahedron, in the order of [`FACES`]: face k is opposite node k.
    pub tet_faces: Vec<[u32; 4]>,
    /// The boundary, in the order of [`Lattice::boundary`].
    pub boundary: Vec<OuterFace>,
    /// Nodes on the boundary, ascending.
    pub boundary_nodes: Vec<u32>,
    /// True for edges on the boundary; length `edges`.
    pub boundary_edge: Vec<bool>,
    /// True for faces on the boundary; length `faces`.
    pub boundary_face: Vec<bool>,
    /// Simplices whose points can be close to others.
    pub(super) flat: FlatSimplices,
    /// Quadrilaterals of the boundary across which cracks are straight.
    pub(super) flat_quads: FlatQuads,
    neighbor_offsets: Vec<u32>,
    neighbors: Vec<u32>,
}

impl Topology {
    /// One more than the highest label, after a check that the labels fit the lattice.
    pub(super) fn fragment_count(&self, labels: &[u32]) -> Result<usize, TessellationError> {
        let nodes = self.nodes;
        if labels.len() != nodes {
            return Err(TessellationError::LabelCount { nodes, labels: labels.len() });
        }
        match labels.iter().position(|&label| label as usize >= nodes) {
            Some(node) => Err(TessellationError::LabelOutOfRange { node, label: labels[node] }),
            None => Ok(labels.iter().max().map_or(0, |&label| label as usize + 1)),
        }
    }

    /// Computes the incidences of `lattice`; O(t log t) in its tetrahedra.
    pub fn new(lattice: &Lattice) -> Self {
        let nodes = lattice.nodes.len();
        let edges = lattice.edges();
        let (faces, tet_faces) = unique_faces(lattice);
        let finder = Finder::new(nodes, &edges);
        let face_edges =
            faces.iter().map(|face| FACE_EDGES.map(|[i, j]| finder.find(&edges, face[i], face[j]))).collect();
        let tet_edges =
            lattice.tets.iter().map(|tet| EDGES.map(|[i, j]| finder.find(&edges, tet[i], tet[j]))).collect();
        let (neighbor_offsets, neighbors) = adjacency(nodes, &edges);
        let mut topology = Self {
            nodes,
            boundary_edge: vec![false; edges.len()],
            boundary_face: vec![false; faces.len()],
            edges,
            faces,
            face_edges,
            tet_edges,
            tet_faces,
            neighbor_offsets,
            neighbors,
            ..Self::default()
        };
        topology.mark_boundary(&lattice.boundary(), &finder);
        topology.flat = FlatSimplices::new(lattice, &topology.edges, &topology.faces);
        topology.flat_quads = FlatQuads::new(lattice, &topology);
        topology.shrink();
        topology
    }

    /// Frees what the lists reserved and do not use: that of the edges was six times too long.
    fn shrink(&mut self) {
        self.edges.shrink_to_fit();
        self.faces.shrink_to_fit();
        self.face_edges.shrink_to_fit();
        self.tet_edges.shrink_to_fit();
        self.boundary.shrink_to_fit();
        self.boundary_nodes.shrink_to_fit();
        self.flat.shrink();
        self.flat_quads.shrink();
    }

    /// Changes `labels` where two boundary triangles in one plane and the faces below them would be divided unlike each
    /// other: two opposite corners of their quadrilateral have one label, and the two others have others.
    pub fn join_opposite_corners(&self, labels: &mut [u32]) {
        self.flat_quads.join_opposite_corners(labels);
    }

    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        held(&self.edges)
            + held(&self.faces)
            + held(&self.face_edges)
            + held(&self.tet_edges)
            + held(&self.tet_faces)
            + held(&self.boundary)
            + held(&self.boundary_nodes)
            + held(&self.boundary_edge)
            + held(&self.boundary_face)
            + self.flat.bytes()
            + self.flat_quads.bytes()
            + held(&self.neighbor_offsets)
            + held(&self.neighbors)
    }

    /// True for nodes on the boundary.
    pub(super) fn is_boundary_node(&self, node: u32) -> bool {
        self.boundary_nodes.binary_search(&node).is_ok()
    }

    /// Nodes that share an edge with `node`, ascending.
    pub fn neighbors(&self, node: usize) -> &[u32] {
        &self.neighbors[self.neighbor_offsets[node] as usize..self.neighbor_offsets[node + 1] as usize]
    }

    fn mark_boundary(&mut self, boundary: &[BoundaryFace], finder: &Finder) {
        let mut on_boundary = vec![false; self.nodes];
        for &BoundaryFace { nodes, tet } in boundary {
            let edges = [0, 1, 2].map(|k| finder.find(&self.edges, nodes[k], nodes[(k + 1) % 3]));
            let mut key = nodes;
            key.sort_unstable();
            let face = self.tet_faces[tet as usize].into_iter().find(|&face| self.faces[face as usize] == key);
            let face = face.unwrap_or_default(); // a boundary face is a face of its own tetrahedron
            self.boundary_face[face as usize] = true;
            edges.iter().for_each(|&edge| self.boundary_edge[edge as usize] = true);
            nodes.iter().for_each(|&node| on_boundary[node as usize] = true);
            self.boundary.push(OuterFace { nodes, edges, face, tet });
        }
        self.boundary_nodes = (0..self.nodes as u32).filter(|&node| on_boundary[node as usize]).collect();
    }
}

/// Index of the first edge of each lower node.
struct Finder(Vec<u32>);

impl Finder {
    fn new(nodes: usize, edges: &[[u32; 2]]) -> Self {
        let mut offsets = vec![0; nodes + 1];
        edges.iter().for_each(|edge| offsets[edge[0] as usize + 1] += 1);
        (0..nodes).for_each(|node| offsets[node + 1] += offsets[node]);
        Self(offsets)
    }

    /// Index of the edge between `a` and `b`, which must exist.
    fn find(&self, edges: &[[u32; 2]], a: u32, b: u32) -> u32 {
        let (lower, higher) = (a.min(b), a.max(b));
        let (first, last) = (self.0[lower as usize], self.0[lower as usize + 1]);
        first + edges[first as usize..last as usize].partition_point(|edge| edge[1] < higher) as u32
    }
}

fn unique_faces(lattice: &Lattice) -> (Vec<[u32; 3]>, Vec<[u32; 4]>) {
    let mut keyed: Vec<([u32; 3], u32, u8)> = Vec::with_capacity(4 * lattice.tets.len());
    for (tet, nodes) in lattice.tets.iter().enumerate() {
        for (face, corners) in FACES.iter().enumerate() {
            let mut key = corners.map(|corner| nodes[corner]);
            key.sort_unstable();
            keyed.push((key, tet as u32, face as u8));
        }
    }
    keyed.sort_unstable();
    let mut faces: Vec<[u32; 3]> = Vec::with_capacity(2 * lattice.tets.len() + 2);
    let mut tet_faces = vec![[0; 4]; lattice.tets.len()];
    for same in keyed.chunk_by(|a, b| a.0 == b.0) {
        for &(_, tet, face) in same {
            tet_faces[tet as usize][face as usize] = faces.len() as u32;
        }
        faces.push(same[0].0);
    }
    (faces, tet_faces)
}

/// Node adjacency in compressed rows, each ascending because the edges are sorted.
fn adjacency(nodes: usize, edges: &[[u32; 2]]) -> (Vec<u32>, Vec<u32>) {
    let mut offsets = vec![0; nodes + 1];
    edges.iter().flatten().for_each(|&node| offsets[node as usize + 1] += 1);
    (0..nodes).for_each(|node| offsets[node + 1] += offsets[node]);
    let mut next = offsets.clone();
    let mut neighbors = vec![0; 2 * edges.len()];
    let mut append = |node: u32, neighbor: u32| {
        neighbors[next[node as usize] as usize] = neighbor;
        next[node as usize] += 1;
    };
    edges.iter().for_each(|&[lower, higher]| append(higher, lower));
    edges.iter().for_each(|&[lower, higher]| append(lower, higher));
    (offsets, neighbors)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::block;

    #[test]
    fn incidences_of_a_block_agree_with_its_tetrahedra() {
        let lattice = block([3, 2, 2], 0.2);
        let topology = Topology::new(&lattice);
        for (tet, nodes) in lattice.tets.iter().enumerate() {
            for (edge, [i, j]) in topology.tet_edges[tet].into_iter().zip(EDGES) {
                assert_eq!(topology.edges[edge as usize], [nodes[i].min(nodes[j]), nodes[i].max(nodes[j])]);
            }
            for (face, corners) in topology.tet_faces[tet].into_iter().zip(FACES) {
                let mut key = corners.map(|corner| nodes[corner]);
                key.sort_unstable();
                assert_eq!(topology.faces[face as usize], key);
            }
        }
        for (face, edges) in topology.faces.iter().zip(&topology.face_edges) {
            for (&edge, [i, j]) in edges.iter().zip(FACE_EDGES) {
                assert_eq!(topology.edges[edge as usize], [face[i], face[j]]);
            }
        }
        let euler = topology.nodes as i64 - topology.edges.len() as i64 + topology.faces.len() as i64
            - lattice.tets.len() as i64;
        assert_eq!(euler, 1, "a ball");
    }

    #[test]
    fn nothing_is_reserved_beyond_what_is_used() {
        let topology = Topology::new(&block([5, 4, 3], 0.2));
        assert_eq!(topology.bytes(), topology.clone().bytes());
    }

    #[test]
    fn the_boundary_is_the_lattices_and_a_sphere() {
        let lattice = block([3, 2, 2], 0.2);
        let topology = Topology::new(&lattice);
        let expected = lattice.boundary();
        assert_eq!(topology.boundary.len(), expected.len());
        for (outer, expected) in topology.boundary.iter().zip(&expected) {
            assert_eq!((outer.nodes, outer.tet), (expected.nodes, expected.tet));
            assert!(topology.boundary_face[outer.face as usize]);
        }
        let count = |flags: &[bool]| flags.iter().filter(|&&flag| flag).count() as i64;
        let euler =
            topology.boundary_nodes.len() as i64 - count(&topology.boundary_edge) + count(&topology.boundary_face);
        assert_eq!(euler, 2);
    }

    #[test]
    fn neighbors_are_the_ends_of_edges_in_order() {
        let lattice = block([2, 2, 1], 0.2);
        let topology = Topology::new(&lattice);
        let total: usize = (0..topology.nodes).map(|node| topology.neighbors(node).len()).sum();
        assert_eq!(total, 2 * topology.edges.len());
        for node in 0..topology.nodes {
            assert!(topology.neighbors(node).is_sorted_by(|a, b| a < b));
            for &other in topology.neighbors(node) {
                let key = [other.min(node as u32), other.max(node as u32)];
                assert!(topology.edges.binary_search(&key).is_ok());
            }
        }
    }
}
