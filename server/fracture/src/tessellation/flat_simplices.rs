//! Simplices around which a tetrahedron is so flat that points can be close to one another.

use super::barycentric::{EDGE_MARGIN, MARGIN, smallest_height};
use crate::lattice::Lattice;
use crate::memory::held;

/// Distance above which two points have different positions, local: eight times the spacing of single precision.
const DISTANCE_MIN: f64 = 8.0 * f32::EPSILON as f64 / 2.0;

/// True if points of a simplex can be close to others. `margin`: least barycentric coordinate; `height`: that of the tetrahedra
/// around the simplex.
pub(super) fn is_close(margin: f64, height: f64) -> bool {
    margin * height < DISTANCE_MIN
}

/// Simplices whose points can be close to others, by their smallest margins; each list ascends.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct FlatSimplices {
    /// Nodes.
    pub nodes: Vec<u32>,
    /// Edges.
    pub edges: Vec<u32>,
    /// Faces.
    pub faces: Vec<u32>,
    /// Tetrahedra.
    pub tets: Vec<u32>,
    /// Smallest height of the tetrahedra around each node, local; empty if there is no such simplex.
    heights: Vec<f32>,
}

impl FlatSimplices {
    /// The simplices of `lattice`, which has these edges and faces.
    pub fn new(lattice: &Lattice, edges: &[[u32; 2]], faces: &[[u32; 3]]) -> Self {
        let mut heights = vec![f32::INFINITY; lattice.nodes.len()];
        for (tet, nodes) in lattice.tets.iter().enumerate() {
            let height = smallest_height(&lattice.corners(tet)) as f32;
            for &node in nodes {
                let own = &mut heights[node as usize];
                *own = own.min(height);
            }
        }
        let mut flat = Self { heights, ..Self::default() };
        flat.nodes = (0..lattice.nodes.len() as u32).filter(|node| is_close(1.0, flat.height([*node]))).collect();
        flat.edges = flat.among(edges, EDGE_MARGIN);
        flat.faces = flat.among(faces, MARGIN);
        flat.tets = flat.among(&lattice.tets, MARGIN);
        if flat.edges.is_empty() {
            flat.heights = Vec::new();
        }
        flat
    }

    /// Frees what the lists reserved and do not use.
    pub fn shrink(&mut self) {
        [&mut self.nodes, &mut self.edges, &mut self.faces, &mut self.tets].into_iter().for_each(Vec::shrink_to_fit);
    }

    /// Lower bound of the heights of all tetrahedra around a simplex with these nodes, local.
    pub fn height<const N: usize>(&self, nodes: [u32; N]) -> f64 {
        nodes.iter().map(|&node| f64::from(self.heights[node as usize])).fold(0.0, f64::max)
    }

    fn among<const N: usize>(&self, simplices: &[[u32; N]], margin: f64) -> Vec<u32> {
        (0..).zip(simplices).filter(|(_, nodes)| is_close(margin, self.height(**nodes))).map(|(own, _)| own).collect()
    }

    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        let Self { nodes, edges, faces, tets, heights } = self;
        held(nodes) + held(edges) + held(faces) + held(tets) + held(heights)
    }
}
