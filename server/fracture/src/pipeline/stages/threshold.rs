//! Threshold stage: whether the object breaks.
//!
//! Based on: Schvartzman & Otaduy (I3D 2014), section 3.1: an object breaks if its distance-weighted deformation energy
//! exceeds γ. E_1 is the energy of the whole body as one fragment.

use super::energy::BodyEnergy;
use crate::centroidal::EnergyField;
use crate::degree;
use crate::pipeline::error::FractureError;
use crate::pipeline::prepared::object::PreparedObject;

/// E_1 of every struck body, and γ in the same units.
#[derive(Clone, Debug, PartialEq)]
pub struct ThresholdResult {
    /// γ, J·m².
    pub gamma_j_m2: f64,
    /// Indices of the struck bodies.
    pub bodies: Vec<usize>,
    /// γ of each struck body in units of its own share field: dimensionless energy times local length squared.
    pub gammas: Vec<f64>,
    /// E_1 of each struck body, in the same units.
    pub first_moments: Vec<f64>,
}

impl ThresholdResult {
    /// Computes E_1 of each field and scales γ to its units.
    pub fn new(prepared: &PreparedObject, gamma_j_m2: f64, energies: &[BodyEnergy], fields: &[EnergyField]) -> Self {
        let unit = |energy: &BodyEnergy| gamma_j_m2 / energy.unit_j_m2(prepared.frame.diagonal_m);
        let gammas: Vec<f64> = energies.iter().map(unit).collect();
        let bodies = energies.iter().map(|energy| energy.body).collect();
        Self { gamma_j_m2, bodies, gammas, first_moments: fields.iter().map(degree::first_moment).collect() }
    }

    /// Multiplies all loads by `factor`.
    pub fn scale(&mut self, factor: f64) {
        self.gammas.iter_mut().for_each(|gamma| *gamma /= factor * factor);
    }

    /// The largest E_1/γ; the object breaks above 1.
    pub fn e1_over_gamma(&self) -> f64 {
        self.first_moments.iter().zip(&self.gammas).map(|(first, gamma)| first / gamma).fold(0.0, f64::max)
    }
}

/// Relative precision of E_1 in the search for the threshold under weight.
const PRECISION: f64 = 1e-6;

/// Largest number of trials of that search.
const TRIALS_MAX: usize = 48;

/// Smallest step factor of a trial while only one side of the threshold is known.
const STRIDE: f64 = 4.0;

/// Smallest factor of a trial. Far below, weight over impulse exceeds the range of 64-bit numbers.
const FACTOR_MIN: f64 = 1e-60;

/// The factor on the impulses at which the object just breaks under unchanged weight; 0 if the weight alone breaks it.
///
/// `e1_over_gamma` returns E_1/γ at a factor. With weight, E_1 is not proportional to the square of the factor, so
/// the factor is searched for. The search is regula falsi on √E_1, which is nearly linear in the factor, with a
/// bisection in every third trial.
///
/// # Errors
/// Those of `e1_over_gamma`.
pub(in crate::pipeline) fn under_weight(
    e1_over_gamma: &mut dyn FnMut(f64) -> Result<f64, FractureError>,
) -> Result<f64, FractureError> {
    // Factor and √(E_1/γ) on each side.
    let (mut holds, mut breaks): (Option<[f64; 2]>, Option<[f64; 2]>) = (None, None);
    let mut factor = 1.0;
    for trial in 0..TRIALS_MAX {
        if factor < FACTOR_MIN {
            return Ok(0.0);
        }
        let found = e1_over_gamma(factor)?.sqrt();
        if (found - 1.0).abs() <= 0.5 * PRECISION {
            return Ok(factor);
        }
        *(if found > 1.0 { &mut breaks } else { &mut holds }) = Some([factor, found]);
        factor = match (holds, breaks) {
            (None, _) => (factor / found).min(factor / STRIDE),
            (_, None) => (factor / found).max(factor * STRIDE),
            (Some([low, _]), Some([high, _])) if trial % 3 == 2 => (low * high).sqrt(),
            (Some([low, under]), Some([high, over])) => low + (high - low) * (1.0 - under) / (over - under),
        };
    }
    Ok(if holds.is_some() { factor } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::under_weight;

    /// Expects the threshold of an impact whose √(E_1/γ) at factor f is |b·f + w| for the arguments b and w.
    #[track_caller]
    fn check(impact_energy: f64, weight: f64) {
        let mut trials = 0;
        let mut e1_over_gamma = |factor: f64| {
            trials += 1;
            Ok((impact_energy * factor + weight).powi(2))
        };
        let found = under_weight(&mut e1_over_gamma).unwrap();
        let exact = if weight >= 1.0 { 0.0 } else { (1.0 - weight) / impact_energy };
        assert!((found - exact).abs() * impact_energy <= 1e-6, "{found} of {exact}");
        assert!(exact == 0.0 || trials < 30, "{trials} trials for {exact}");
    }

    #[test]
    fn no_trial_leaves_the_range_of_numbers() {
        let mut e1_over_gamma = |factor: f64| {
            assert!(factor.powi(4) > 0.0, "{factor}");
            Ok(1e20)
        };
        assert_eq!(under_weight(&mut e1_over_gamma).unwrap(), 0.0);
    }

    #[test]
    fn the_threshold_under_weight_is_found() {
        for impact_energy in [1e-9, 0.1, 1.0, 3.0, 1e7] {
            for weight in [0.0, 0.3, 0.999, 1.1, -0.5] {
                check(impact_energy, weight);
            }
        }
    }
}
