//! Quadratic tetrahedra on the lattice of the linear ones: edge functions in addition to those of the nodes.
//!
//! Linear tetrahedra are too stiff in bending unless many lie across a wall. Quadratic ones bend exactly. Their
//! displacement is the linear one of the corner nodes plus b_e c_e for every edge e, with b_e = 4 λ_i λ_j and the
//! barycentric coordinates λ of its ends. b_e vanishes at all corner nodes, so the first coefficients are the
//! displacements there, and all rigid motions have c = 0. Loads on the node functions are those of the linear body, so
//! equilibrium depends on them alone. Vectors have three components per node, then three per edge.
//!
//! Based on: O. C. Zienkiewicz, J. P. de S. R. Gago & D. W. Kelly, *The hierarchical concept in finite element
//! analysis* (Computers & Structures 16, 1983).

mod condensation;
mod conjugate_gradients;
mod energy;
mod load;
mod product;
mod restrict;

#[cfg(test)]
pub(super) use condensation::ElementStiffness;
pub(super) use energy::{
    QuadraticEnergies, StrainEnergies, StrainRows, TensileStrainEnergies, corner_strains, energies,
};
pub(super) use product::element_forces;
pub(super) use restrict::SnapshotRows;

use super::element::{Element, Lame};
use crate::lattice::{EDGES, Lattice};
use crate::memory::held;
use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

/// Share of the energy that the last steps of a solve added at most.
///
/// The share of the energy that is then missing is at most about as large, far below the error of the discretization.
pub(super) const SOLVED: f64 = 1e-4;

/// As [`SOLVED`], for snapshots. Any displacements make a basis. With 1e-3 instead of 1e-6, that of the mug misses 7.5 % of
/// the energy as before, and takes half the time.
pub(super) const SNAPSHOT: f64 = 1e-3;

/// Polynomial order of the elements of a body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ElementOrder {
    /// Linear tetrahedra of four nodes.
    #[default]
    Linear,
    /// Quadratic tetrahedra of ten nodes, with straight sides.
    Quadratic,
}

/// Edge functions of a lattice.
#[derive(Debug)]
pub(super) struct EdgeFunctions {
    /// Four nodes of each tetrahedron.
    pub(super) corners: Vec<[u32; 4]>,
    /// Six edges of each tetrahedron, in the order of [`EDGES`].
    pub(super) tets: Vec<[u32; 6]>,
    /// Volume of each tetrahedron, local.
    pub(super) volumes: Vec<f64>,
    /// Nodes of each edge, the lower first.
    pub(super) ends: Vec<[u32; 2]>,
    /// Edges of each boundary face, the one opposite its k-th node at place k.
    pub(super) faces: Vec<[u32; 3]>,
    /// Inverse of each edge's own block of the stiffness.
    pub(super) inverse_blocks: Vec<Matrix3<f64>>,
    /// Diagonal of the stiffness, three per edge.
    pub(super) diagonal: Vec<f64>,
    /// ∫ b_e of each edge, of unit density.
    masses: Vec<f64>,
    /// ∫ b_e (x − c) of each edge, with the center of mass c.
    moments: Vec<Vector3<f64>>,
}

impl EdgeFunctions {
    /// Edge functions of `lattice`, whose nodes have the positions `arm` relative to the center of mass.
    ///
    /// `None` if a tetrahedron has no positive volume.
    pub(super) fn new(lattice: &Lattice, lame: Lame, arm: impl Fn(usize) -> Vector3<f64>) -> Option<Self> {
        let ends = lattice.edges();
        let edge = |a: u32, b: u32| ends.partition_point(|other| *other < [a.min(b), a.max(b)]) as u32;
        let tets: Vec<[u32; 6]> =
            lattice.tets.iter().map(|nodes| EDGES.map(|[i, j]| edge(nodes[i], nodes[j]))).collect();
        let face = |[a, b, c]: [u32; 3]| [edge(b, c), edge(c, a), edge(a, b)];
        let faces = lattice.boundary().iter().map(|own| face(own.nodes)).collect();
        let mut blocks = vec![Matrix3::zeros(); ends.len()];
        let (mut masses, mut moments) = (vec![0.0; ends.len()], vec![Vector3::zeros(); ends.len()]);
        let mut volumes = Vec::with_capacity(tets.len());
        for (tet, (nodes, edges)) in lattice.tets.iter().zip(&tets).enumerate() {
            let element = Element::new(lattice, tet)?;
            volumes.push(element.volume);
            let places = nodes.map(|node| arm(node as usize));
            let sum: Vector3<f64> = places.iter().sum();
            for (&edge, [i, j]) in edges.iter().zip(EDGES) {
                blocks[edge as usize] += own_block(&element, i, j, lame);
                masses[edge as usize] += element.volume / 5.0;
                moments[edge as usize] += (sum + places[i] + places[j]) * (element.volume / 30.0);
            }
        }
        let diagonal = blocks.iter().flat_map(|block| block.diagonal().data.0[0]).collect();
        let inverse_blocks = blocks.into_iter().map(Matrix3::try_inverse).collect::<Option<_>>()?;
        let corners = lattice.tets.clone();
        Some(Self { corners, tets, volumes, ends, faces, inverse_blocks, diagonal, masses, moments })
    }

    /// Number of edges.
    pub(super) fn count(&self) -> usize {
        self.ends.len()
    }

    /// Bytes of memory that they hold.
    pub(super) fn bytes(&self) -> usize {
        let Self { corners, tets, volumes, ends, faces, inverse_blocks, diagonal, masses, moments } = self;
        let tables = held(corners) + held(tets) + held(volumes) + held(ends) + held(faces);
        tables + held(inverse_blocks) + held(diagonal) + held(masses) + held(moments)
    }

    /// Inertial force on the function of edge `edge` under an acceleration, linear and angular.
    pub(super) fn inertial_force(&self, edge: usize, [linear, angular]: &[Vector3<f64>; 2]) -> Vector3<f64> {
        linear * self.masses[edge] + angular.cross(&self.moments[edge])
    }
}

/// Stiffness block of the function of the edge between the corners `i` and `j` with itself.
///
/// With G = ∫ ∇b ∇bᵀ it is (λ + μ) G + μ tr G · 1.
fn own_block(element: &Element, i: usize, j: usize, lame: Lame) -> Matrix3<f64> {
    let (a, b) = (&element.gradients[i], &element.gradients[j]);
    let dyad = a * b.transpose();
    let squares = (a * a.transpose() + b * b.transpose()) * 2.0;
    let products = (squares + dyad + dyad.transpose()) * (16.0 * element.volume / 20.0);
    products * (lame.lambda + lame.mu) + Matrix3::from_diagonal_element(lame.mu * products.trace())
}
