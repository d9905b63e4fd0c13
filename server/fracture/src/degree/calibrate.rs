//! Calibration of κ, the ratio of the optimized degree to the closed form's n₀.
//!
//! The closed form assumes equal E_i; the criterion depends on the largest. Their ratio hardly depends on n unless n is
//! small, so one number per object corrects it.

use super::criterion::closed_form;
use super::curve::EnergyCurve;
use super::slenderness::Slenderness;
use crate::centroidal::EnergyField;

/// Smallest degree used for κ. Smaller ones carry little information: n is an integer, and n₀ tends to 0.
pub const SITES_MIN: usize = 8;

/// κ of an object without samples: the median measured by a prototype on a horse. Solid boxes have 1.4.
pub const KAPPA: f64 = 2.0;

/// A labeled threshold of one field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CalibrationSample {
    /// n₀ of the closed form.
    pub estimate: f64,
    /// n of the optimization.
    pub sites: usize,
}

/// κ and its error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibration {
    /// Median of n/n₀.
    pub kappa: f64,
    /// Median of |κ n₀ − n|/n.
    pub error_median: f64,
    /// Number of samples.
    pub samples: usize,
}

/// One sample for each number of sites ≥ [`SITES_MIN`] that is the degree of some γ on `curve`.
///
/// Its γ is the logarithmic middle of the interval with this degree.
pub fn samples(field: &EnergyField, shape: &Slenderness, curve: &EnergyCurve) -> Vec<CalibrationSample> {
    let records = curve.points().windows(2).filter(|pair| pair[1].running_minimum < pair[0].running_minimum);
    records
        .filter(|pair| pair[1].sites >= SITES_MIN && pair[1].running_minimum > 0.0)
        .map(|pair| {
            let gamma = pair[0].running_minimum.sqrt() * pair[1].running_minimum.sqrt();
            CalibrationSample { estimate: closed_form(field, shape, gamma), sites: pair[1].sites }
        })
        .collect()
}

/// Fits κ to the samples of several fields of one object; `None` without samples.
pub fn fit_kappa(samples: &[CalibrationSample]) -> Option<Calibration> {
    let kappa = median(samples.iter().map(|sample| sample.sites as f64 / sample.estimate))?;
    let error = |sample: &CalibrationSample| (kappa * sample.estimate / sample.sites as f64 - 1.0).abs();
    let error_median = median(samples.iter().map(error))?;
    Some(Calibration { kappa, error_median, samples: samples.len() })
}

/// The middle value, or the mean of the two middle values.
fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    let upper = *sorted.get(middle)?;
    Some(if sorted.len().is_multiple_of(2) { 0.5 * (sorted[middle - 1] + upper) } else { upper })
}
