//! Strains of several tetrahedra in SIMD lanes, and their energy densities.
//!
//! Based on: C. Miehe, M. Hofacker & F. Welschinger (CMAME 199, 2010), equation 20, for the tensile part.
//!
//! Principal strains are the roots t of t³ − 3t = det D of the deviator's direction D (O. K. Smith, *Eigenvalues of a
//! symmetric 3 × 3 matrix*, CACM 4, 1961). Newton's method finds the outermost, instead of Smith's angles, which have
//! no SIMD form. The remaining quadratic yields the others.

use super::element::Lame;
use crate::simd::SimdLanes;

/// Components xx, yy, zz, xy, yz, xz of a strain, in N lanes.
pub(super) type Strain<const N: usize> = [SimdLanes<N>; 6];

/// Strain at a node, components xx, yy, zz, xy, yz, xz; its energy density; 0.
pub(super) type StrainRow = [f32; 8];

/// Steps of Newton's method. Errors start at 1e-3 and fall to 1e-6, 1e-12 and rounding.
const STEPS: usize = 3;

/// √3, the outermost root for det D = 0.
const ROOT_3: f64 = 1.732_050_807_568_877_2;

impl Lame {
    /// Energy density ½ σ:ε = λ/2 (tr ε)² + μ ε:ε.
    #[inline(always)]
    pub(super) fn energy_densities<const N: usize>(self, strain: &Strain<N>) -> SimdLanes<N> {
        let trace = strain[0] + strain[1] + strain[2];
        trace * trace * (0.5 * self.lambda) + norm_squared(strain) * self.mu
    }

    /// Tensile energy density ψ⁺ = λ/2 ⟨tr ε⟩₊² + μ Σ ⟨ε_a⟩₊², with the principal strains ε_a.
    ///
    /// Never negative, and never above the whole density if λ ≥ 0.
    #[inline(always)]
    pub(super) fn tensile_energy_densities<const N: usize>(self, strain: &Strain<N>) -> SimdLanes<N> {
        let trace = strain[0] + strain[1] + strain[2];
        let [a, b, c] = principal_strains(strain);
        let stretch = a.positive_square() + b.positive_square() + c.positive_square();
        trace.positive_square() * (0.5 * self.lambda) + stretch * self.mu
    }
}

/// Squared Frobenius norm ε:ε.
#[inline(always)]
fn norm_squared<const N: usize>([xx, yy, zz, xy, yz, xz]: &Strain<N>) -> SimdLanes<N> {
    *xx * *xx + *yy * *yy + *zz * *zz + (*xy * *xy + *yz * *yz + *xz * *xz) * 2.0
}

/// Principal strains (eigenvalues), in arbitrary order.
///
/// Two nearly equal ones may differ by a spurious 1e-8 of the strain. Symmetric functions of them, such as the tensile
/// energy, keep full precision.
#[inline(always)]
pub(super) fn principal_strains<const N: usize>(strain: &Strain<N>) -> [SimdLanes<N>; 3] {
    let mean = (strain[0] + strain[1] + strain[2]) * (1.0 / 3.0);
    let deviator = [strain[0] - mean, strain[1] - mean, strain[2] - mean, strain[3], strain[4], strain[5]];
    let spread = (norm_squared(&deviator) * (1.0 / 6.0)).map(f64::sqrt);
    let inverse = spread.map(|spread| if spread > f64::MIN_POSITIVE { 1.0 / spread } else { 0.0 });
    let determinant = determinant(&deviator) * inverse * inverse * inverse;
    let half = determinant.map(|determinant| (0.5 * determinant.abs()).min(1.0));
    let mut root = half.map(|half| ROOT_3 + half * (1.0 / 3.0 - half * (ROOT_3 + 1.0 / 3.0 - 2.0)));
    for _ in 0..STEPS {
        root = root.zip(half, |t, half| t - (t * (t * t - 3.0) - 2.0 * half) / (3.0 * (t * t - 1.0)));
    }
    let apart = root.map(|t| (0.75 * (2.0 - t) * (2.0 + t)).max(0.0).sqrt());
    let signed = spread.zip(determinant, |spread, determinant| if determinant < 0.0 { -spread } else { spread });
    [mean + signed * root, mean + signed * (apart - root * 0.5), mean - signed * (apart + root * 0.5)]
}

#[inline(always)]
fn determinant<const N: usize>([x, y, z, xy, yz, xz]: &Strain<N>) -> SimdLanes<N> {
    *x * (*y * *z - *yz * *yz) - *xy * (*xy * *z - *yz * *xz) + *xz * (*xy * *yz - *y * *xz)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix3, Vector3};
    use proptest::prelude::*;

    fn check(strain: Matrix3<f64>) {
        let (scale, lame) = (strain.norm(), Lame::new(0.3));
        let entries = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)].map(|place| SimdLanes([strain[place]]));
        let sorted = |mut values: Vec<f64>| {
            values.sort_by(|a, b| b.total_cmp(a));
            values
        };
        let expected = sorted(strain.symmetric_eigenvalues().iter().copied().collect());
        let found = sorted(principal_strains(&entries).map(|value| value.0[0]).into());
        for (value, expected) in found.iter().zip(&expected) {
            assert!((value - expected).abs() <= 3e-8 * scale, "{value} for {expected}");
        }
        let stretch: f64 = expected.iter().map(|value| value.max(0.0).powi(2)).sum();
        let exact = 0.5 * lame.lambda * strain.trace().max(0.0).powi(2) + lame.mu * stretch;
        let [tensile, whole] = [lame.tensile_energy_densities(&entries), lame.energy_densities(&entries)];
        assert!((tensile.0[0] - exact).abs() <= 1e-14 * scale * scale);
        let exact = 0.5 * lame.lambda * strain.trace().powi(2) + lame.mu * strain.norm_squared();
        assert!((whole.0[0] - exact).abs() <= 1e-14 * scale * scale);
    }

    #[test]
    fn repeated_and_vanishing_principal_strains_keep_the_energy() {
        let turn = nalgebra::Rotation3::from_euler_angles(0.4, 1.2, -0.7);
        for diagonal in
            [[1.0; 3], [1.0, 1.0, -2.0], [0.0, 0.0, 1.0], [0.0; 3], [-1.0, -1.0, 0.0], [1.0, 1.0 + 1e-9, 0.5]]
        {
            for scale in [1.0, 1e-100, 1e100] {
                let strain = turn * Matrix3::from_diagonal(&Vector3::from(diagonal)) * turn.inverse();
                check((strain + strain.transpose()) * (0.5 * scale));
            }
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
