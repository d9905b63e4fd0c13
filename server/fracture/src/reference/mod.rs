//! Reference problems with known solutions, shared by the tests and the stability study.
//!
//! Each function ending in `_error` returns an error relative to the exact solution that it names,
//! so a caller needs only a bound.

mod bodies;
mod elastic;
mod spectra;

pub use bodies::{ball, kuhn, perturbed};
pub use elastic::{
    bar_error, bending_error, bending_sagitta_error, cantilever_error, fixed_bar_error, hanging_error, patch_error,
    pin_difference, plate_error, traction,
};
pub use spectra::{ball_spectrum_error, box_spectrum_error};
