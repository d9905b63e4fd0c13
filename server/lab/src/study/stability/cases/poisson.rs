//! Locking: error of pure bending against Poisson's ratio, for two ways to divide cubes into tetrahedra.

use super::super::TrialFault;
use shatter_fracture::lattice::block;
use shatter_fracture::reference::{bending_error, kuhn};

/// Relative deficit of the energy in pure bending at one Poisson's ratio.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BendingDeficit {
    /// Poisson's ratio ν.
    pub poisson: f64,
    /// Deficit on the body-centered lattice of the bake, six cubes across.
    pub body_centered: f64,
    /// Deficit on cubes divided into six tetrahedra, eight across; a badly stuffed boundary resembles it.
    pub six_per_cube: f64,
}

/// Curve that determines the largest accepted Poisson's ratio.
pub fn bending_deficits() -> Result<Vec<BendingDeficit>, TrialFault> {
    let centered = block([18, 6, 6], 1.0 / 6.0);
    let cut = kuhn([24, 8, 8], 0.125);
    let at = |poisson: f64| {
        Ok(BendingDeficit {
            poisson,
            body_centered: bending_error(&centered, poisson)?,
            six_per_cube: bending_error(&cut, poisson)?,
        })
    };
    [-0.3, 0.0, 0.1, 0.2, 0.3, 0.35, 0.4, 0.42, 0.45, 0.47, 0.48, 0.49, 0.495, 0.499].into_iter().map(at).collect()
}

pub fn bending_at_045() -> Result<f64, TrialFault> {
    Ok(bending_error(&block([18, 6, 6], 1.0 / 6.0), 0.45)?.abs())
}

pub fn worst_lattice_at_045() -> Result<f64, TrialFault> {
    Ok(bending_error(&kuhn([24, 8, 8], 0.125), 0.45)?.abs())
}

pub fn worst_lattice_at_0499() -> Result<f64, TrialFault> {
    Ok(bending_error(&kuhn([24, 8, 8], 0.125), 0.499)?.abs())
}
