//! Neumann spectra with closed forms.

use super::ball;
use crate::cancel_token::CancelToken;
use crate::lattice::{Lattice, block};
use crate::lift::{LiftError, Spectrum};
use std::f64::consts::PI;

/// Largest relative error of the eigenvalues of `lattice` against `exact` (ascending, without zero).
fn error(lattice: &Lattice, exact: &[f64]) -> Result<f64, LiftError> {
    let computed = Spectrum::compute(lattice, exact.len(), &CancelToken::default())?.eigenvalues;
    Ok(computed.iter().zip(exact).map(|(value, exact)| (value / exact - 1.0).abs()).fold(0.0, f64::max))
}

/// Largest relative error of the first twelve Neumann eigenvalues of the box 1 × 0.8 × 0.6.
///
/// Exact: π²(i²/a² + j²/b² + k²/c²). `fine` cubes span 0.2.
///
/// # Errors
/// [`LiftError`] if the eigenvalues do not converge.
pub fn box_spectrum_error(fine: usize) -> Result<f64, LiftError> {
    let sides = [1.0, 0.8, 0.6];
    let mut exact: Vec<f64> = (1..1000)
        .map(|index| {
            let modes = [index % 10, index / 10 % 10, index / 100];
            (0..3).map(|axis| (PI * f64::from(modes[axis]) / sides[axis]).powi(2)).sum()
        })
        .collect();
    exact.sort_unstable_by(f64::total_cmp);
    error(&block([5 * fine, 4 * fine, 3 * fine], 0.2 / fine as f64), &exact[..12])
}

/// Largest relative error of the first eight Neumann eigenvalues of the unit ball, `cells` cubes across.
///
/// Exact: the squares of the first zeros of the derivatives of the spherical Bessel functions j_1
/// (three times) and j_2 (five times).
///
/// # Errors
/// [`LiftError`] if the eigenvalues do not converge.
pub fn ball_spectrum_error(cells: usize) -> Result<f64, LiftError> {
    let zeros = [(2.081_575_977_8, 3), (3.342_093_657_4, 5)];
    let exact: Vec<f64> = zeros.iter().flat_map(|&(zero, times)| vec![f64::powi(zero, 2); times]).collect();
    error(&ball(cells), &exact)
}
