//! Interior lift: positions joined with the biharmonic embedding, which reflects concavities.
//!
//! Based on: Y. Lipman, R. M. Rustamov & T. A. Funkhouser, *Biharmonic distance* (ACM Transactions on Graphics 29,
//! 2010), equation 4, d² = Σ (φ_k(x) − φ_k(y))²/λ_k², in the volume instead of on the surface. Joining it with the
//! positions is our own.

use super::{LiftError, LiftKind, LiftedLattice, Spectrum, gap};
use crate::cancel_token::CancelToken;
use crate::lattice::Lattice;

/// Number of eigenfunctions requested for the default interior lift. The cut at a spectral gap keeps 4 to 16.
///
/// The cost of a request grows with the dimension. Few functions suffice, because those that separate limbs come first,
/// and a gap in the spectrum follows them.
///
/// Measured on a horse of 6,039 nodes with uniform energy: number of starts, of 24, in which a cell joined two lower
/// legs.
/// - 14 sites: 24 with Euclidean distances; 4, 3, 5 with α = 1 and 6, 13, 21 functions.
/// - 20 sites: 21 with Euclidean distances; 0, 0, 0 with α = 1 and 6, 13, 21 functions.
///
/// Measured on a brush of 16 prongs with 12 sites: share of the volume in detached pieces of cells. It is 28.7 % with
/// Euclidean distances, and 11.6, 15.9, 6.6, 8.4 % with 4, 8, 15, 24 functions.
///
/// The gap rule keeps 5 on the horse, 7 on a comb of 8 teeth, 15 on the brush, 6 on a cube.
pub const MODES_DEFAULT: usize = 10;
/// Weight α of the embedding relative to the positions in the default interior lift.
///
/// Measured on the same horse with α = ½, 1, 2, 5. 99th percentile of σ₁/σ₃: 3.0, 5.8, 11.4, 28.5. Starts with 14 sites
/// that join lower legs: 9, 4, 0, 2 of 24. Detached pieces of 120 cells: 0.04, 0.3, 2.2, 14 per start. Above 1 little
/// is gained, and fine cells fall apart.
///
/// With 10 sites, 9 of 24 starts still join two hooves at any α from 1 to 3 (Euclidean: 24), because a cell of a tenth
/// of the horse outweighs a hoof.
pub const ALPHA_DEFAULT: f64 = 1.0;
/// Largest number of eigenfunctions of an interior lift: far more than are useful, and few
/// enough for the iteration's basis.
pub const MODES_MAX: usize = 64;

/// Computes the interior lift X = s·[x; α·ψ(x)] with about `modes` eigenfunctions, at most [`MODES_MAX`].
///
/// See [`Spectrum::lift`]. α = 0 or no modes yields X = x, without computing eigenpairs. A lattice with fewer
/// non-constant functions than `modes` uses all of them.
///
/// # Errors
/// As [`Spectrum::compute`], and [`LiftError::InvalidAlpha`].
pub fn interior(lattice: &Lattice, modes: usize, alpha: f64, token: &CancelToken) -> Result<LiftedLattice, LiftError> {
    check(alpha)?;
    if modes > MODES_MAX {
        return Err(LiftError::TooManyModes { modes, max: MODES_MAX });
    }
    if modes == 0 || alpha == 0.0 {
        return Ok(assemble(lattice, &[], |_| &[]));
    }
    let needed = gap::needed(modes, lattice.nodes.len().saturating_sub(1));
    Spectrum::compute(lattice, needed, token)?.lift(lattice, modes, alpha)
}

fn check(alpha: f64) -> Result<(), LiftError> {
    if alpha >= 0.0 && alpha.is_finite() { Ok(()) } else { Err(LiftError::InvalidAlpha { alpha }) }
}

impl Spectrum {
    /// Interior lift from these eigenpairs of `lattice`.
    ///
    /// The spectrum is cut near `modes`, where the eigenvalues grow by the largest factor. The
    /// dimension is 3 + the functions kept.
    ///
    /// ψ_k = c·φ_k/λ_k, with c such that the volume mean of tr(JᵀJ)/3 of ψ alone is 1. Since
    /// ∫|∇φ_k|² = λ_k, c² = 3V / Σ 1/λ_k.
    ///
    /// # Errors
    /// [`LiftError::InvalidAlpha`].
    pub fn lift(&self, lattice: &Lattice, modes: usize, alpha: f64) -> Result<LiftedLattice, LiftError> {
        check(alpha)?;
        let kept = if modes == 0 || alpha == 0.0 { 0 } else { gap::cut(&self.eigenvalues, modes, self.whole) };
        let inverse_sum: f64 = self.eigenvalues[..kept].iter().map(|value| 1.0 / value).sum();
        let unit = alpha * (3.0 * lattice.volume() / inverse_sum).sqrt();
        let weights: Vec<f64> = self.eigenvalues[..kept].iter().map(|value| unit / value).collect();
        Ok(assemble(lattice, &weights, |k| self.function(k)))
    }
}

/// Assembles X = s·[x; weights·functions].
fn assemble<'a>(lattice: &Lattice, weights: &[f64], function: impl Fn(usize) -> &'a [f64]) -> LiftedLattice {
    let dimension = 3 + weights.len();
    let mut coordinates = Vec::with_capacity(lattice.nodes.len() * dimension);
    for (node, position) in lattice.nodes.iter().enumerate() {
        coordinates.extend_from_slice(position.coords.as_slice());
        coordinates.extend(weights.iter().enumerate().map(|(k, weight)| weight * function(k)[node]));
    }
    LiftedLattice::scaled(LiftKind::Interior, lattice, dimension, coordinates)
}
