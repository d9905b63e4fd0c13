//! The Laplacian L of linear tetrahedra with natural (Neumann) boundary, and the lumped mass M.
//!
//! Based on: G. Dziuk, *Finite elements for the Beltrami operator on arbitrary surfaces* (1988), one dimension up: on
//! one tetrahedron ∫∇λ_i·∇λ_j = V g_i·g_j with g_i the constant gradients of the barycentric coordinates.

use super::LiftError;
use crate::lattice::Lattice;
use crate::sparse::Symmetric;
use nalgebra::{Matrix1, Matrix3, Matrix3x4, Matrix4, Vector3};
use rayon::prelude::*;

/// L and M.
pub(super) struct Laplacian<'a> {
    lattice: &'a Lattice,
    /// L, one row per node; local lengths.
    pub(super) stiffness: Symmetric,
    /// The diagonal of M: each node's share of the volume; positive.
    pub(super) mass: Vec<f64>,
}

impl<'a> Laplacian<'a> {
    /// Assembles L and M of a connected lattice.
    ///
    /// Errors: [`LiftError::TooFewNodes`] (no tetrahedron), [`LiftError::DegenerateTet`], [`LiftError::Disconnected`],
    /// [`LiftError::Sparse`].
    pub(super) fn new(lattice: &'a Lattice) -> Result<Self, LiftError> {
        if lattice.tets.is_empty() {
            return Err(LiftError::TooFewNodes { nodes: lattice.nodes.len(), wanted: 0, needed: 4 });
        }
        let elements: Vec<Option<Matrix4<f64>>> =
            (0..lattice.tets.len()).into_par_iter().map(|tet| element(lattice, tet)).collect();
        if let Some(tet) = elements.iter().position(Option::is_none) {
            return Err(LiftError::DegenerateTet { tet });
        }
        let elements: Vec<Matrix4<f64>> = elements.into_iter().flatten().collect();
        let components = components(lattice);
        if components != 1 {
            return Err(LiftError::Disconnected { components });
        }
        let entry = |tet: usize, i: usize, j: usize| Matrix1::new(elements[tet][(i, j)]);
        let stiffness = Symmetric::assemble(lattice.nodes.len(), &lattice.tets, entry)?;
        Ok(Self { lattice, stiffness, mass: lattice.node_volumes() })
    }

    /// Number of nodes.
    pub(super) fn order(&self) -> usize {
        self.mass.len()
    }

    /// An upper bound of the smallest positive eigenvalue of L φ = λ M φ, and close to it for compact shapes: the
    /// Rayleigh quotient of the coordinate along the longest principal axis, volume over ∫x².
    pub(super) fn smallest_bound(&self) -> f64 {
        let volume: f64 = self.mass.iter().sum();
        let weighted = |sum: Vector3<f64>, (node, mass): (&nalgebra::Point3<f64>, &f64)| sum + node.coords * *mass;
        let centre = self.lattice.nodes.iter().zip(&self.mass).fold(Vector3::zeros(), weighted) / volume;
        let mut covariance = Matrix3::zeros();
        for (node, mass) in self.lattice.nodes.iter().zip(&self.mass) {
            let offset = node.coords - centre;
            covariance += offset * offset.transpose() * (*mass / volume);
        }
        // The largest diagonal entry is at least a third of the largest eigenvalue: near enough for a shift.
        1.0 / covariance.diagonal().max()
    }
}

/// The element matrix of tetrahedron `tet`, unless its volume is not positive or anything is not finite.
fn element(lattice: &Lattice, tet: usize) -> Option<Matrix4<f64>> {
    let edges = lattice.edge_matrix(tet);
    let volume = edges.determinant() / 6.0;
    let inverse = edges.try_inverse()?;
    let mut gradients = Matrix3x4::zeros();
    gradients.fixed_columns_mut::<3>(1).copy_from(&inverse.transpose());
    gradients.set_column(0, &-(gradients.column(1) + gradients.column(2) + gradients.column(3)));
    let element = gradients.transpose() * gradients * volume;
    (volume > 0.0 && volume.is_finite() && element.iter().all(|value| value.is_finite())).then_some(element)
}

/// Connected components of the graph whose edges are those of the tetrahedra; nodes of no tetrahedron are components of
/// their own. Union by the lower root, with path halving.
fn components(lattice: &Lattice) -> usize {
    let mut parents: Vec<u32> = (0..lattice.nodes.len() as u32).collect();
    let mut count = lattice.nodes.len();
    for nodes in &lattice.tets {
        for &node in &nodes[1..] {
            let (a, b) = (root(&mut parents, nodes[0]), root(&mut parents, node));
            if a != b {
                parents[a.max(b) as usize] = a.min(b);
                count -= 1;
            }
        }
    }
    count
}

fn root(parents: &mut [u32], mut node: u32) -> u32 {
    while parents[node as usize] != node {
        parents[node as usize] = parents[parents[node as usize] as usize];
        node = parents[node as usize];
    }
    node
}
