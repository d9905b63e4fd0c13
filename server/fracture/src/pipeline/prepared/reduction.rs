//! How well the reduced bases of an object do.

use serde::{Deserialize, Serialize};
/// How well the bases do on impacts that they have not seen: medians over bodies struck.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReductionErrors {
    /// Displacements of each body's basis; 0: it has none.
    pub rank: Vec<usize>,
    /// Displacements that were compared.
    pub holdout: usize,
    /// Relative error of the elastic energy.
    pub energy_error_median: f64,
    /// Its ninth decile.
    pub energy_error_p90: f64,
    /// Volume integral of the difference of the energy densities over that of the density.
    pub density_error_median: f64,
    /// Relative error of the closed form's n₀ at the object's own γ.
    pub degree_error_median: f64,
    /// Share of the estimated errors that are within a factor 3 of the true ones, on displacements they were not fitted to.
    pub estimates_within_3: f64,
    /// Share of the same that a strike would solve for, the estimate being too large.
    pub solved: f64,
}
