//! What an object has learned from its examples, and how well.

use crate::degree::PoseNetwork;
use serde::{Deserialize, Serialize};
/// What examples taught.
#[derive(Clone, Debug, PartialEq)]
pub struct LearnedModel {
    /// From descriptor to target.
    pub network: PoseNetwork,
    /// How well it does.
    pub quality: LearnedErrors,
}

/// Relative errors |Δn|/n of degrees of at least [`SITES_MIN`](crate::degree::SITES_MIN), each example left out in turn.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LearnedErrors {
    /// Labels that the figures are over.
    pub holdout: usize,
    /// Median of the network.
    pub median_relative_error: f64,
    /// Nine of ten labels are within this.
    pub p90_relative_error: f64,
    /// Median of the closed form with the κ of these examples.
    pub closed_form_median: f64,
    /// Its ninth decile.
    pub closed_form_p90: f64,
    /// Median of a network on the impact's pose and magnitude instead.
    pub pose_network_median: f64,
    /// Its ninth decile.
    pub pose_network_p90: f64,
    /// Labels below [`SITES_MIN`](crate::degree::SITES_MIN), which the other figures leave out.
    pub few_holdout: usize,
    /// Share of those that the network is off by one at most; nothing of none.
    pub few_within_one: Option<f64>,
    /// Median difference between two labels of one field at one γ from different starts: the floor for any learner.
    pub label_noise_median: f64,
}
