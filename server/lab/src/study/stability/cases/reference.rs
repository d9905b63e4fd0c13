//! Cases: elasticity and spectra against exact solutions.

use super::super::trial::TrialFault;
use shatter_fracture::lattice::block;
use shatter_fracture::reference::{
    ball_spectrum_error, bar_error, bending_error, bending_sagitta_error, box_spectrum_error, cantilever_error,
    patch_error, perturbed, pin_difference, plate_error,
};

pub fn patch() -> Result<f64, TrialFault> {
    Ok(patch_error(&perturbed([3, 2, 2], 0.2, 0.12, 11), 0.3)?)
}

/// Observed order of convergence between a spacing and half of it.
fn order(coarse: f64, fine: f64) -> f64 {
    (coarse / fine).log2()
}

pub fn bending() -> Result<f64, TrialFault> {
    Ok(bending_error(&block([24, 6, 6], 1.0 / 6.0), 0.3)?.abs())
}

pub fn bending_order() -> Result<f64, TrialFault> {
    let error = |fine: usize| bending_error(&block([4 * fine, fine, fine], 1.0 / fine as f64), 0.3);
    Ok(order(error(2)?, error(4)?))
}

pub fn sagitta_order() -> Result<f64, TrialFault> {
    let error = |fine: usize| bending_sagitta_error(&block([4 * fine, fine, fine], 1.0 / fine as f64), 0.3);
    Ok(order(error(2)?, error(4)?))
}

pub fn plate() -> Result<f64, TrialFault> {
    Ok(plate_error(&block([24, 24, 4], 0.25), 0.3)?.abs())
}

pub fn cantilever() -> Result<f64, TrialFault> {
    Ok(cantilever_error(4)?.abs())
}

pub fn bar_order() -> Result<f64, TrialFault> {
    Ok(order(bar_error(2)?, bar_error(4)?))
}

pub fn pins() -> Result<f64, TrialFault> {
    Ok(pin_difference(&perturbed([6, 4, 4], 0.1, 0.1, 3))?)
}

pub fn box_spectrum() -> Result<f64, TrialFault> {
    Ok(box_spectrum_error(4)?)
}

pub fn box_spectrum_order() -> Result<f64, TrialFault> {
    Ok(order(box_spectrum_error(2)?, box_spectrum_error(4)?))
}

pub fn ball_spectrum() -> Result<f64, TrialFault> {
    Ok(ball_spectrum_error(12)?)
}
