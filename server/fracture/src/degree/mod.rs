//! The fracture degree: how many fragments a strain energy field makes.
//!
//! [`first_moment`] says whether the body breaks at all, [`reach`] how large it can be, [`closed_form`] and [`decide`] how often at no cost, a trained
//! [`PoseNetwork`] how often by what examples taught, [`optimise`] how often by the criterion itself; [`verify`] begins at a guess,
//! and [`fit_kappa`] reconciles closed form and criterion.

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
pub use curve::{CurveOptions, CurvePoint, EnergyCurve, OptimizedDegree, optimise};
pub use first_moment_bound::{reach, reach_range};
pub use pose_network::{PoseNetwork, Prediction, TrainedNetwork, train};
pub use slenderness::Slenderness;
pub use training_sample::{DESCRIPTOR_LENGTH, TrainingSample, descriptor, sites, target};
pub use verify::{VerifiedDegree, verify};
