//! Laplacian L of linear elements and lumped mass M.
//!
//! The elements are tetrahedra with natural (Neumann) boundary, or triangles of a closed surface.
//!
//! Based on: G. Dziuk, *Finite elements for the Beltrami operator on arbitrary surfaces* (1988), in one
//! dimension more. On a tetrahedron ∫∇λ_i·∇λ_j = V g_i·g_j with g_i the constant gradients of the barycentric
//! coordinates. On a triangle the same integral is e_i·e_j/(4 A), with e_i the edge opposite corner i: the
//! cotangent weights of U. Pinkall & K. Polthier, *Computing discrete minimal surfaces and their conjugates*
//! (Experimental Mathematics 2, 1993).

use super::LiftError;
use crate::lattice::Lattice;
use crate::sparse::SymmetricMatrix;
use nalgebra::{Matrix1, Matrix3, Matrix3x4, Matrix4, Point3, Vector3};
use rayon::prelude::*;

/// Laplacian L and lumped mass M of one lattice or surface.
pub(super) struct Laplacian<'a> {
    points: &'a [Point3<f64>],
    /// L, one row per node; local lengths.
    pub(super) stiffness: SymmetricMatrix,
    /// Diagonal of M: each node's share of the volume or area; positive.
    pub(super) mass: Vec<f64>,
}

impl<'a> Laplacian<'a> {
    /// Assembles L and M of a connected lattice.
    ///
    /// # Errors
    /// [`LiftError::TooFewNodes`] (no tetrahedron), [`LiftError::DegenerateTet`], [`LiftError::Disconnected`],
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
        let stiffness = SymmetricMatrix::assemble(lattice.nodes.len(), &lattice.tets, entry)?;
        Ok(Self { points: &lattice.nodes, stiffness, mass: lattice.node_volumes() })
    }

    /// Assembles L and M of a closed, connected triangle surface: the cotangent Laplacian.
    ///
    /// # Errors
    /// [`LiftError::DegenerateFace`], [`LiftError::Sparse`].
    pub(super) fn of_triangles(points: &'a [Point3<f64>], triangles: &[[u32; 3]]) -> Result<Self, LiftError> {
        let (mut mass, mut entries) = (vec![0.0; points.len()], Vec::with_capacity(6 * triangles.len()));
        for (face, corners) in triangles.iter().enumerate() {
            let [a, b, c] = corners.map(|node| points[node as usize]);
            let opposite = [c - b, a - c, b - a];
            let area = 0.5 * opposite[0].cross(&opposite[1]).norm();
            if !area.is_normal() {
                return Err(LiftError::DegenerateFace { face });
            }
            for i in 0..3 {
                mass[corners[i] as usize] += area / 3.0;
                entries.extend((i..3).map(|j| (corners[i], corners[j], opposite[i].dot(&opposite[j]) / (4.0 * area))));
            }
        }
        Ok(Self { points, stiffness: SymmetricMatrix::from_triplets(points.len(), &entries)?, mass })
    }

    /// Number of nodes.
    pub(super) fn order(&self) -> usize {
        self.mass.len()
    }

    /// Upper bound of the smallest positive eigenvalue of L φ = λ M φ, close to it for compact shapes.
    ///
    /// It is the Rayleigh quotient of a coordinate along the longest axis, at most volume over ∫x². On a surface it is
    /// area over ∫x², and the gradient is the tangential one.
    pub(super) fn smallest_bound(&self) -> f64 {
        let volume: f64 = self.mass.iter().sum();
        let weighted = |sum: Vector3<f64>, (node, mass): (&Point3<f64>, &f64)| sum + node.coords * *mass;
        let center = self.points.iter().zip(&self.mass).fold(Vector3::zeros(), weighted) / volume;
        let mut covariance = Matrix3::zeros();
        for (node, mass) in self.points.iter().zip(&self.mass) {
            let offset = node.coords - center;
            covariance += offset * offset.transpose() * (*mass / volume);
        }
        // The largest diagonal entry is at least a third of the largest eigenvalue, which is close enough for a shift.
        1.0 / covariance.diagonal().max()
    }
}

/// Element matrix of tetrahedron `tet`. `None` if its volume is not positive or an entry is not finite.
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

/// Number of connected components of the lattice's edge graph. Each node of no tetrahedron counts as one.
///
/// Union by the lower root, with path halving.
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

/// Root of `node`'s tree. Halves the path on the way.
pub(super) fn root(parents: &mut [u32], mut node: u32) -> u32 {
    while parents[node as usize] != node {
        parents[node as usize] = parents[parents[node as usize] as usize];
        node = parents[node as usize];
    }
    node
}
