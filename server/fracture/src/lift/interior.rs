//! The interior lift: the positions, and beside them the biharmonic embedding that knows of concavities.
//!
//! Based on: Y. Lipman, R. M. Rustamov & T. A. Funkhouser, *Biharmonic distance* (ACM Transactions on Graphics 29,
//! 2010), equation 4, d² = Σ (φ_k(x) − φ_k(y))²/λ_k², in the volume instead of on the surface; to join it with the
//! positions is ours.

use super::{Lift, LiftError, LiftKind, Spectrum, gap};
use crate::lattice::Lattice;
use crate::token::Token;

/// Eigenfunctions of the default interior lift, before the cut moves to a gap.
pub const MODES_DEFAULT: usize = 16;
/// Weight of the embedding against the positions in the default interior lift.
pub const ALPHA_DEFAULT: f64 = 1.0;
/// Eigenfunctions an interior lift can have at most: far more than help, and few enough for the iteration's basis.
pub const MODES_MAX: usize = 64;

/// The interior lift X = s·[x; α·ψ(x)] with about `modes` eigenfunctions, at most [`MODES_MAX`]; dimension 3 + those
/// kept. α = 0 or no modes gives X = x.
///
/// A lattice with fewer non-constant functions than `modes` uses all it has. Errors as [`Spectrum::compute`], and
/// [`LiftError::InvalidAlpha`], [`LiftError::TooManyModes`].
pub fn interior(lattice: &Lattice, modes: usize, alpha: f64, token: &Token) -> Result<Lift, LiftError> {
    if modes > MODES_MAX {
        return Err(LiftError::TooManyModes { modes, max: MODES_MAX });
    }
    let needed = gap::needed(modes, lattice.nodes.len().saturating_sub(1));
    let spectrum = Spectrum::compute(lattice, needed, token)?;
    spectrum.lift(lattice, modes, alpha)
}

impl Spectrum {
    /// The interior lift from these eigenpairs of `lattice`: see [`interior`]. The spectrum is cut near `modes` where
    /// the eigenvalues grow by the largest factor.
    ///
    /// With ψ_k = c·φ_k/λ_k, c is such that the volume mean of tr(JᵀJ)/3 of ψ alone is 1. Since ∫|∇φ_k|² = λ_k, that is
    /// c² = 3V / Σ 1/λ_k.
    ///
    /// Errors: [`LiftError::InvalidAlpha`].
    pub fn lift(&self, lattice: &Lattice, modes: usize, alpha: f64) -> Result<Lift, LiftError> {
        if !(alpha >= 0.0 && alpha.is_finite()) {
            return Err(LiftError::InvalidAlpha { alpha });
        }
        let kept = if modes == 0 || alpha == 0.0 { 0 } else { gap::cut(&self.eigenvalues, modes, self.whole) };
        let inverse_sum: f64 = self.eigenvalues[..kept].iter().map(|value| 1.0 / value).sum();
        let unit = alpha * (3.0 * lattice.volume() / inverse_sum).sqrt();
        let weights: Vec<f64> = self.eigenvalues[..kept].iter().map(|value| unit / value).collect();
        let mut coordinates = Vec::with_capacity(lattice.nodes.len() * (3 + kept));
        for (node, position) in lattice.nodes.iter().enumerate() {
            coordinates.extend_from_slice(position.coords.as_slice());
            coordinates.extend(weights.iter().enumerate().map(|(k, weight)| weight * self.function(k)[node]));
        }
        Ok(Lift::scaled(LiftKind::Interior, lattice, 3 + kept, coordinates))
    }
}
