//! Linear tetrahedron and isotropic material law.
//!
//! Based on: T. J. R. Hughes, *The Finite Element Method* (1987), sections 2.7 and 3.I.

use crate::lattice::Lattice;
use nalgebra::{Matrix3, Vector3};

/// Lamé's constants for Young's modulus 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lame {
    /// λ = ν / ((1 + ν)(1 − 2ν)).
    pub lambda: f64,
    /// μ = 1 / (2(1 + ν)), the shear modulus.
    pub mu: f64,
}

impl Lame {
    /// Poisson's ratio.
    pub(super) fn poisson(self) -> f64 {
        0.5 * self.lambda / (self.lambda + self.mu)
    }

    /// Constants for Poisson's ratio `poisson`, −1 < ν < ½.
    pub fn new(poisson: f64) -> Self {
        Self { lambda: poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)), mu: 0.5 / (1.0 + poisson) }
    }
}

/// Volume and shape gradients of one tetrahedron.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Element {
    /// ∇φ of the four nodes, 1/local length.
    pub gradients: [Vector3<f64>; 4],
    /// Volume, local.
    pub volume: f64,
}

impl Element {
    /// Computes volume and gradients of tetrahedron `tet`. `None` unless the volume is positive and finite.
    pub fn new(lattice: &Lattice, tet: usize) -> Option<Self> {
        let edges = lattice.edge_matrix(tet);
        let volume = edges.determinant() / 6.0;
        let inverse = edges.try_inverse().filter(|_| volume > 0.0 && volume.is_finite())?;
        let [b, c, d] = [0, 1, 2].map(|row| inverse.row(row).transpose());
        Some(Self { gradients: [-(b + c + d), b, c, d], volume })
    }

    /// Stiffness block (3 × 3) between nodes `i` and `j`: V (λ ∇φ_i ∇φ_jᵀ + μ ∇φ_j ∇φ_iᵀ + μ (∇φ_i·∇φ_j) I).
    pub fn stiffness(&self, i: usize, j: usize, lame: Lame) -> Matrix3<f64> {
        let (a, b) = (&self.gradients[i], &self.gradients[j]);
        let dyad = a * b.transpose();
        (dyad * lame.lambda + dyad.transpose() * lame.mu + Matrix3::from_diagonal_element(lame.mu * a.dot(b)))
            * self.volume
    }
}
