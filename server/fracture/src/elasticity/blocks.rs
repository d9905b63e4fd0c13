//! Gradients and volumes of tetrahedra, in blocks for SIMD.

use super::element::Element;
use super::strain::Strain;
use crate::memory::held;
use crate::simd::SimdLanes;
use nalgebra::Vector3;

/// Number of tetrahedra per SIMD block.
pub(super) const SIDE: usize = 4;

/// Gradients and volumes of all tetrahedra, computed once so that a request inverts no matrix.
#[derive(Debug)]
pub(super) struct Elements {
    pub(super) blocks: Vec<Block>,
}

/// Three vectors of each of [`SIDE`] tetrahedra.
pub(super) type Triple = [[SimdLanes<SIDE>; 3]; 3];

/// Block of [`SIDE`] tetrahedra. Missing ones in the last block are zero.
#[derive(Clone, Debug)]
pub(super) struct Block {
    /// ∇φ of the second, third and fourth node, in 1/local length. That of the first is minus their sum.
    gradients: Triple,
    /// Volumes, local.
    pub(super) volumes: SimdLanes<SIDE>,
}

impl Elements {
    /// Packs the elements into SIMD blocks.
    pub(super) fn new(elements: &[Element]) -> Self {
        Self { blocks: elements.chunks(SIDE).map(Block::new).collect() }
    }

    /// Bytes of memory that they hold.
    pub(super) fn bytes(&self) -> usize {
        held(&self.blocks)
    }
}

impl Block {
    fn new(elements: &[Element]) -> Self {
        let lanes = |of: &dyn Fn(&Element) -> f64| {
            let mut lanes = SimdLanes::all(0.0);
            lanes.0.iter_mut().zip(elements).for_each(|(lane, element)| *lane = of(element));
            lanes
        };
        let gradients = [1, 2, 3].map(|node| [0, 1, 2].map(|axis| lanes(&|element| element.gradients[node][axis])));
        Self { gradients, volumes: lanes(&|element| element.volume) }
    }

    /// ∇φ of all four nodes, in 1/local length.
    #[inline(always)]
    pub(super) fn all_gradients(&self) -> [[SimdLanes<SIDE>; 3]; 4] {
        let [a, b, c] = self.gradients;
        let first = std::array::from_fn(|axis| (a[axis] + b[axis] + c[axis]) * -1.0);
        [first, a, b, c]
    }

    /// Volume and gradients of the tetrahedron at place `lane`.
    pub(super) fn element(&self, lane: usize) -> Element {
        let gradients = self.all_gradients().map(|own| Vector3::from(own.map(|component| component.0[lane])));
        Element { gradients, volume: self.volumes.0[lane] }
    }

    /// Strains ε of the tetrahedra `tets`.
    #[inline(always)]
    pub(super) fn strain(&self, tets: &[[u32; 4]], displacement: &[f64]) -> Strain<SIDE> {
        // Indexed by edge, then by component.
        let mut edges = [[SimdLanes::all(0.0); 3]; 3];
        for (lane, tet) in tets.iter().enumerate().take(SIDE) {
            let first = &displacement[3 * tet[0] as usize..][..3];
            for edge in 0..3 {
                let other = &displacement[3 * tet[edge + 1] as usize..][..3];
                for axis in 0..3 {
                    edges[edge][axis].0[lane] = other[axis] - first[axis];
                }
            }
        }
        let g = &self.gradients;
        let sheared = |i, j| (derivative(&edges, g, i, j) + derivative(&edges, g, j, i)) * 0.5;
        let stretched = |i| derivative(&edges, g, i, i);
        [stretched(0), stretched(1), stretched(2), sheared(0, 1), sheared(1, 2), sheared(0, 2)]
    }
}

/// ∂u_i/∂x_j from the displacements along the edges and the gradients of their ends.
#[inline(always)]
fn derivative(edges: &Triple, gradients: &Triple, i: usize, j: usize) -> SimdLanes<SIDE> {
    edges[0][i] * gradients[0][j] + edges[1][i] * gradients[1][j] + edges[2][i] * gradients[2][j]
}
