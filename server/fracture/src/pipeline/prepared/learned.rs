//! Degree model learned from an object's examples, and its errors.

use crate::degree::PoseNetwork;
use serde::{Deserialize, Serialize};
/// Degree model learned from examples.
#[derive(Clone, Debug, PartialEq)]
pub struct LearnedModel {
    /// Maps descriptors to targets.
    pub network: PoseNetwork,
    /// Cross-validated errors.
    pub quality: LearnedErrors,
}

/// Leave-one-example-out relative errors |Δn|/n of degrees of at least [`SITES_MIN`](crate::degree::SITES_MIN).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LearnedErrors {
    /// Number of labels behind these figures.
    pub holdout: usize,
    /// Median error of the network.
    pub median_relative_error: f64,
    /// 90th percentile of the network's error.
    pub p90_relative_error: f64,
    /// Median error of the closed form with the κ of these examples.
    pub closed_form_median: f64,
    /// 90th percentile of the closed form's error.
    pub closed_form_p90: f64,
    /// Median error of a network on the impact's pose and magnitude instead.
    pub pose_network_median: f64,
    /// 90th percentile of that network's error.
    pub pose_network_p90: f64,
    /// Number of labels below [`SITES_MIN`](crate::degree::SITES_MIN), which the other figures exclude.
    pub few_holdout: usize,
    /// Share of those labels at which the network's error is at most one site; `None` without such labels.
    pub few_within_one: Option<f64>,
    /// Median difference between two labels of one field at one γ from different starts, the noise floor of any model.
    pub label_noise_median: f64,
}
