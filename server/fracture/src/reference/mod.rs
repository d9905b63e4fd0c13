//! Problems with known answers: what tests and the stability study measure the rooms by.
//!
//! Every function returns an error relative to the exact solution that it names, so that a caller needs no more than a
//! bound.

mod bodies;
mod elastic;
mod spectra;

pub use bodies::{ball, kuhn, perturbed};
pub use elastic::{
    bar_error, bending_error, bending_sagitta_error, cantilever_error, fixed_bar_error, hanging_error, patch_error,
    pin_difference, plate_error, traction,
};
pub use spectra::{ball_spectrum_error, box_spectrum_error};
