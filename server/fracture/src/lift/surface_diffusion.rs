//! Surface diffusion lift: diffusion coordinates of the boundary, extended inside.
//!
//! Based on: R. M. Rustamov, Y. Lipman & T. Funkhouser, *Interior distance using barycentric coordinates* (Computer
//! Graphics Forum 28, 2009): v*_i = (e^(−λ_k t)·φ_k(v_i)) with the eigenpairs of the surface's Laplacian and t = 1/(8
//! λ_1), extended by barycentric coordinates.

use super::boundary::BoundarySurface;
use super::extension::Extension;
use super::{LiftError, LiftKind, LiftedLattice, MODES_MAX, Spectrum, gap, stretch};
use crate::cancel_token::CancelToken;
use crate::lattice::Lattice;

/// Requested eigenfunctions of the default surface lift. The cut at a gap keeps 14 to 26.
///
/// These are more than those of the interior lift, because the surface lift has no positions in addition.
/// Around 10 the widest gap often leaves four, which flatten slender bodies (an arch of 11 728 nodes: median of
/// σ₁/σ₃ 1 300) and split fine cells (a mug, 120 sites: 2.1 % of the volume in detached pieces and 166 pieces;
/// with 22 functions 0.6 % and 139).
pub const SURFACE_MODES_DEFAULT: usize = 20;
/// Largest number of shells, the outer one and cavities, that a surface lift distinguishes.
pub const SHELLS_MAX: usize = 64;
/// Median of σ₁/σ₃ from which on the scale of the lift, (det g)^(1/5), consists of rounding errors.
///
/// The smallest eigenvalue of g = JᵀJ is then 10⁻¹² of the largest.
const STRETCH_MAX: f64 = 1e6;

/// Computes the surface diffusion lift with about `modes` eigenfunctions, at most [`MODES_MAX`].
///
/// The spectrum is cut where the eigenvalues grow by the largest factor. As in the literature the lift contains no
/// positions, so it may be nearly flat in places; see [`super::stretch`].
///
/// No heat flows between the shells of a body with cavities. Such a body has one eigenfunction to λ = 0 per shell, its
/// constant. All of them are kept, because they distinguish the shells. The dimension is the number of functions kept,
/// plus that of the shells if there are several.
///
/// # Errors
/// [`LiftError::TooManyModes`], [`LiftError::TooManyShells`]; [`LiftError::Flat`]; those of [`Spectrum::of_surface`] and of
/// [`Extension::carry`].
pub fn surface_diffusion(
    lattice: &Lattice,
    carry: Extension,
    modes: usize,
    token: &CancelToken,
) -> Result<LiftedLattice, LiftError> {
    if modes > MODES_MAX {
        return Err(LiftError::TooManyModes { modes, max: MODES_MAX });
    }
    let surface = BoundarySurface::new(lattice);
    let (dimension, values) = diffusion(&surface, modes, token)?;
    let coordinates = carry.carry(lattice, &surface, &values, dimension, token)?;
    let lift = LiftedLattice::scaled(LiftKind::SurfaceDiffusion, lattice, dimension, coordinates);
    let stretch = stretch(&lift, lattice).median;
    if stretch < STRETCH_MAX { Ok(lift) } else { Err(LiftError::Flat { stretch }) }
}

/// Dimension, and v* on the surface's nodes: node-major, `surface nodes × dimension`.
fn diffusion(surface: &BoundarySurface, modes: usize, token: &CancelToken) -> Result<(usize, Vec<f64>), LiftError> {
    let shells = surface.shells();
    if shells.len() > SHELLS_MAX {
        return Err(LiftError::TooManyShells { shells: shells.len(), max: SHELLS_MAX });
    }
    let needed = gap::needed(modes, surface.nodes.len().saturating_sub(shells.len()));
    let spectrum = Spectrum::of_surface(surface, needed, token)?;
    let kept = gap::cut(&spectrum.eigenvalues, modes, spectrum.whole);
    let constants = if shells.len() > 1 { shells.len() } else { 0 };
    let dimension = constants + kept;
    let mut values = vec![0.0; surface.nodes.len() * dimension];
    for (k, shell) in shells.iter().enumerate().take(constants) {
        let value = shell.area().sqrt().recip();
        shell.nodes.iter().for_each(|&node| values[node as usize * dimension + k] = value);
    }
    for k in 0..kept {
        // λ_k t with t = 1/(8 λ_1).
        let decay = (-spectrum.eigenvalues[k] / (8.0 * spectrum.eigenvalues[0])).exp();
        for (node, value) in spectrum.function(k).iter().enumerate() {
            values[node * dimension + constants + k] = decay * value;
        }
    }
    Ok((dimension, values))
}
