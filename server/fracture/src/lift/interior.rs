//! The interior lift: the positions, and beside them the biharmonic embedding that knows of concavities.
//!
//! Based on: Y. Lipman, R. M. Rustamov & T. A. Funkhouser, *Biharmonic distance* (ACM Transactions on Graphics 29,
//! 2010), equation 4, d² = Σ (φ_k(x) − φ_k(y))²/λ_k², in the volume instead of on the surface; to join it with the
//! positions is ours.

use super::{LiftError, LiftKind, LiftedLattice, Spectrum, gap};
use crate::cancel_token::CancelToken;
use crate::lattice::Lattice;

/// Eigenfunctions of the default interior lift, before the cut moves to a gap: 4 to 16 are kept.
///
/// A strike's cost grows with the dimension, and few functions are enough: those that tell limbs apart come first, and
/// a gap follows them. Starts in which a cell joined two lower legs of a horse (6 039 nodes, uniform energy, 24
/// starts of 14 sites): Euclidean 24, α = 1 with 6, 13 or 21 functions 4, 3 and 5; of 20 sites 21 and 0, 0, 0. Volume in
/// detached pieces of cells on a brush of 16 prongs (12 sites): Euclidean 28.7 %, with 4, 8, 15, 24 functions 11.6, 15.9,
/// 6.6 and 8.4 %. The gap rule keeps 5 on the horse, 7 on a comb of 8 teeth, 15 on the brush, 6 on a cube.
pub const MODES_DEFAULT: usize = 10;
/// Weight of the embedding against the positions in the default interior lift.
///
/// On the same horse: 99th percentile of σ₁/σ₃ with α = ½, 1, 2, 5: 3.0, 5.8, 11.4, 28.5; starts of 14 sites that join
/// lower legs: 9, 4, 0, 2 of 24; detached pieces of 120 cells: 0.04, 0.3, 2.2, 14 per start. Beyond 1 little is gained
/// and fine cells fall apart. With 10 sites 9, of 24 starts, still join two hooves, at any α from 1 to 3 (Euclidean:
/// 24): a cell of a tenth of the horse outweighs a hoof.
pub const ALPHA_DEFAULT: f64 = 1.0;
/// Eigenfunctions an interior lift can have at most: far more than help, and few enough for the iteration's basis.
pub const MODES_MAX: usize = 64;

/// The interior lift X = s·[x; α·ψ(x)] with about `modes` eigenfunctions, at most [`MODES_MAX`]: see
/// [`Spectrum::lift`]. α = 0 or no modes gives X = x, without eigenpairs; a lattice with fewer non-constant functions
/// than `modes` uses all it has.
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
    /// The interior lift from these eigenpairs of `lattice`. The spectrum is cut near `modes`, where the eigenvalues
    /// grow by the largest factor; the dimension is 3 + the functions kept.
    ///
    /// With ψ_k = c·φ_k/λ_k, c is such that the volume mean of tr(JᵀJ)/3 of ψ alone is 1. Since ∫|∇φ_k|² = λ_k, that is
    /// c² = 3V / Σ 1/λ_k.
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

/// X = s·[x; weights·functions].
fn assemble<'a>(lattice: &Lattice, weights: &[f64], function: impl Fn(usize) -> &'a [f64]) -> LiftedLattice {
    let dimension = 3 + weights.len();
    let mut coordinates = Vec::with_capacity(lattice.nodes.len() * dimension);
    for (node, position) in lattice.nodes.iter().enumerate() {
        coordinates.extend_from_slice(position.coords.as_slice());
        coordinates.extend(weights.iter().enumerate().map(|(k, weight)| weight * function(k)[node]));
    }
    LiftedLattice::scaled(LiftKind::Interior, lattice, dimension, coordinates)
}
