//! The linear tetrahedron and the isotropic law.
//!
//! Based on: T. J. R. Hughes, *The Finite Element Method* (1987), sections 2.7 and 3.I.

use crate::lattice::Lattice;
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::FRAC_PI_3;

/// Lamé's constants for Young's modulus 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lame {
    /// λ = ν / ((1 + ν)(1 − 2ν)).
    pub lambda: f64,
    /// μ = 1 / (2(1 + ν)), the shear modulus.
    pub mu: f64,
}

impl Lame {
    /// Of Poisson's ratio `poisson`, −1 < ν < ½.
    pub fn new(poisson: f64) -> Self {
        Self { lambda: poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)), mu: 0.5 / (1.0 + poisson) }
    }

    /// ½ σ:ε = λ/2 (tr ε)² + μ ε:ε.
    pub fn energy_density(self, strain: &Matrix3<f64>) -> f64 {
        let trace = strain.trace();
        0.5 * self.lambda * trace * trace + self.mu * strain.norm_squared()
    }

    /// ψ⁺ = λ/2 ⟨tr ε⟩₊² + μ Σ ⟨ε_a⟩₊², ε_a the principal strains (Miehe et al. 2010, equation 20). Never negative and
    /// never above [`Self::energy_density`] where λ ≥ 0.
    pub fn tensile_energy_density(self, strain: &Matrix3<f64>) -> f64 {
        let trace = strain.trace().max(0.0);
        let stretch: f64 = principal_strains(strain).iter().map(|value| value.max(0.0).powi(2)).sum();
        0.5 * self.lambda * trace * trace + self.mu * stretch
    }
}

/// The eigenvalues of a symmetric 3 × 3 matrix, largest first, in closed form (O. K. Smith, *Eigenvalues of a symmetric
/// 3 × 3 matrix*, CACM 4, 1961): an eighth of the time of an iteration, and it ends for any input.
///
/// Two nearly equal eigenvalues may be split by 1e-8 of the matrix; symmetric functions of them, such as the tensile
/// energy, keep full precision.
pub fn principal_strains(strain: &Matrix3<f64>) -> Vector3<f64> {
    let mean = strain.trace() / 3.0;
    let deviator = strain - Matrix3::from_diagonal_element(mean);
    let spread = (deviator.norm_squared() / 6.0).sqrt();
    if spread == 0.0 {
        return Vector3::repeat(mean);
    }
    let angle = ((deviator / spread).determinant() * 0.5).clamp(-1.0, 1.0).acos() / 3.0;
    let first = mean + 2.0 * spread * angle.cos();
    let last = mean + 2.0 * spread * (angle + 2.0 * FRAC_PI_3).cos();
    Vector3::new(first, 3.0 * mean - first - last, last)
}

/// Volume and shape gradients of one tetrahedron.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Element {
    /// ∇φ of the four nodes, 1/local length.
    pub gradients: [Vector3<f64>; 4],
    /// Local.
    pub volume: f64,
}

impl Element {
    /// `None` unless the volume is positive and finite.
    pub fn new(lattice: &Lattice, tet: usize) -> Option<Self> {
        let edges = lattice.edge_matrix(tet);
        let volume = edges.determinant() / 6.0;
        let inverse = edges.try_inverse().filter(|_| volume > 0.0 && volume.is_finite())?;
        let [b, c, d] = [0, 1, 2].map(|row| inverse.row(row).transpose());
        Some(Self { gradients: [-(b + c + d), b, c, d], volume })
    }

    /// The 3 × 3 stiffness block between nodes `i` and `j`: V (λ ∇φ_i ∇φ_jᵀ + μ ∇φ_j ∇φ_iᵀ + μ (∇φ_i·∇φ_j) I).
    pub fn stiffness(&self, i: usize, j: usize, lame: Lame) -> Matrix3<f64> {
        let (a, b) = (&self.gradients[i], &self.gradients[j]);
        let dyad = a * b.transpose();
        (dyad * lame.lambda + dyad.transpose() * lame.mu + Matrix3::from_diagonal_element(lame.mu * a.dot(b)))
            * self.volume
    }
}

/// ε = sym(∇u) of tetrahedron `tet` and its volume; `displacement` has three components per node.
pub fn strain(lattice: &Lattice, tet: usize, displacement: &[f64]) -> (Matrix3<f64>, f64) {
    let edges = lattice.edge_matrix(tet);
    let [a, b, c, d] =
        lattice.tets[tet].map(|node| Vector3::from_column_slice(&displacement[3 * node as usize..][..3]));
    // Degenerate tetrahedra were refused when the body was prepared.
    let inverse = edges.try_inverse().unwrap_or_else(Matrix3::zeros);
    let gradient = Matrix3::from_columns(&[b - a, c - a, d - a]) * inverse;
    ((gradient + gradient.transpose()) * 0.5, edges.determinant() / 6.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn check(strain: Matrix3<f64>) {
        let (scale, lame) = (strain.norm(), Lame::new(0.3));
        let mut expected: Vec<f64> = strain.symmetric_eigenvalues().iter().copied().collect();
        expected.sort_by(|a, b| b.total_cmp(a));
        for (value, expected) in principal_strains(&strain).iter().zip(&expected) {
            assert!((value - expected).abs() <= 3e-8 * scale, "{value} for {expected}");
        }
        let stretch: f64 = expected.iter().map(|value| value.max(0.0).powi(2)).sum();
        let exact = 0.5 * lame.lambda * strain.trace().max(0.0).powi(2) + lame.mu * stretch;
        assert!((lame.tensile_energy_density(&strain) - exact).abs() <= 1e-14 * scale * scale);
    }

    #[test]
    fn repeated_and_vanishing_principal_strains_keep_the_energy() {
        let turn = nalgebra::Rotation3::from_euler_angles(0.4, 1.2, -0.7);
        for diagonal in
            [[1.0; 3], [1.0, 1.0, -2.0], [0.0, 0.0, 1.0], [0.0; 3], [-1.0, -1.0, 0.0], [1.0, 1.0 + 1e-9, 0.5]]
        {
            let strain = turn * Matrix3::from_diagonal(&Vector3::from(diagonal)) * turn.inverse();
            check((strain + strain.transpose()) * 0.5);
        }
    }

    proptest! {
        #[test]
        fn principal_strains_are_eigenvalues(entries in prop::array::uniform9(-1.0..1.0_f64)) {
            let any = Matrix3::from_iterator(entries);
            check(any + any.transpose());
        }
    }
}
