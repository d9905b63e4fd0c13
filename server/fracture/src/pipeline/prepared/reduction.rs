//! Errors of an object's reduced bases.

use crate::scene::DEFAULT_RADIUS_DIAGONALS;
use serde::{Deserialize, Serialize};

/// Smallest contact radius of the examples, in diagonals: just below the default radius, so that it is inside their range.
///
/// The range ends at four times the default. It was chosen by the relative energy error of the bunny's reduced basis: 0.5 %
/// with this range; 2.3 % from 0.7 on; 4.5 % with half of the contacts at the default itself. Smaller contacts need a
/// larger basis, because several hundred of them fit on a surface. Their energy comes from the near field.
pub const TRAINED_RADIUS_MIN: f64 = 0.95 * DEFAULT_RADIUS_DIAGONALS;

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
