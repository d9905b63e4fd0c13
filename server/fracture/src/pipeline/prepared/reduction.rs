//! Errors of an object's reduced bases.

use serde::{Deserialize, Serialize};

/// Errors of the reduced bases on held-out impacts, over all struck bodies.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReductionErrors {
    /// Number of displacements of each body's basis; 0: none.
    pub rank: Vec<usize>,
    /// Number of displacements compared.
    pub holdout: usize,
    /// Median relative error of the elastic energy.
    pub energy_error_median: f64,
    /// 90th percentile of the relative error of the elastic energy.
    pub energy_error_p90: f64,
    /// Median of the volume integral of the energy densities' difference, over that of the density.
    pub density_error_median: f64,
    /// Median relative error of the closed form's n₀ at the object's own γ.
    pub degree_error_median: f64,
    /// Share of the estimated errors within a factor of 3 of the true ones, on displacements not used to fit the
    /// estimate.
    pub estimates_within_3: f64,
    /// Share of the same displacements whose estimated error is large enough for a solve, also if completed.
    pub solved: f64,
    /// Errors of displacements completed by a linear solve; `None` without quadratic elements.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub completed: Option<CompletionErrors>,
}

/// Errors of completed displacements on the same impacts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CompletionErrors {
    /// Median relative error of the elastic energy.
    pub energy_error_median: f64,
    /// 90th percentile of the relative error of the elastic energy.
    pub energy_error_p90: f64,
    /// Median of the volume integral of the energy densities' difference, over that of the density.
    pub density_error_median: f64,
}
