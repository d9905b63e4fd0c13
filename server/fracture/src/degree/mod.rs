//! The fracture degree: the number of fragments for a strain energy field.
//!
//! - [`first_moment`] is E_1, which decides whether the body breaks; [`reach`] bounds it.
//! - [`closed_form`] and [`decide`] estimate the degree at almost no cost, a trained [`PoseNetwork`] from examples.
//! - [`optimize`] computes it by the criterion itself; [`verify`] does so from an estimate.
//! - [`fit_kappa`] calibrates the closed form to the criterion.

mod calibrate;
mod criterion;
mod curve;
mod first_moment_bound;
mod pose_network;
mod slenderness;
#[cfg(test)]
mod tests;
mod training_sample;
mod verify;

pub use calibrate::{Calibration, CalibrationSample, KAPPA, SITES_MIN, fit_kappa, samples};
pub use criterion::{
    COEFFICIENT, SiteCount, closed_form, closed_form_and_evenness, decide, evenness, first_moment, reference_gamma,
    threshold_factor,
};
pub use curve::{CurveOptions, CurvePoint, EnergyCurve, OptimizedDegree, optimize};
pub use first_moment_bound::{reach, reach_range};
pub use pose_network::{PoseNetwork, Prediction, TrainedNetwork, train};
pub use slenderness::Slenderness;
pub use training_sample::{DESCRIPTOR_LENGTH, TrainingSample, descriptor, sites, target};
pub use verify::{VerifiedDegree, verify};
