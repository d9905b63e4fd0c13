//! The fracture degree: how many fragments a strain energy field makes.
//!
//! [`first_moment`] says whether the body breaks at all, [`closed_form`] and [`decide`] how often at no cost,
//! [`optimise`] how often by the criterion itself, and [`fit_kappa`] reconciles the two.

mod calibrate;
mod criterion;
mod curve;
mod slender;
#[cfg(test)]
mod tests;

pub use calibrate::{Calibration, KAPPA, SITES_MIN, Sample, fit_kappa, samples};
pub use criterion::{COEFFICIENT, Degree, closed_form, decide, first_moment, reference_gamma, threshold_factor};
pub use curve::{Curve, CurveOptions, Optimised, Point, optimise};
pub use slender::Slenderness;
