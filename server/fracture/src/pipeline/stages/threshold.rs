//! Threshold: does the object break at all?
//!
//! Based on: Schvartzman & Otaduy (I3D 2014), section 3.1: an object breaks if its distance-weighted deformation energy
//! exceeds γ. E_1 is the energy of the whole body as one fragment.

use super::energy::BodyEnergy;
use crate::centroidal::EnergyField;
use crate::degree;
use crate::pipeline::error::FractureError;
use crate::pipeline::prepared::object::PreparedObject;

/// E_1 of every struck body against γ.
#[derive(Clone, Debug, PartialEq)]
pub struct ThresholdResult {
    /// γ, J·m².
    pub gamma_j_m2: f64,
    /// The struck bodies.
    pub bodies: Vec<usize>,
    /// γ of each struck body in units of its own share field: dimensionless, local.
    pub gammas: Vec<f64>,
    /// E_1 of each struck body, in the same units.
    pub first_moments: Vec<f64>,
}

impl ThresholdResult {
    /// Compares each field's first moment with γ.
    pub fn new(prepared: &PreparedObject, gamma_j_m2: f64, energies: &[BodyEnergy], fields: &[EnergyField]) -> Self {
        let unit = |energy: &BodyEnergy| gamma_j_m2 / energy.unit_j_m2(prepared.frame.diagonal_m);
        let gammas: Vec<f64> = energies.iter().map(unit).collect();
        let bodies = energies.iter().map(|energy| energy.body).collect();
        Self { gamma_j_m2, bodies, gammas, first_moments: fields.iter().map(degree::first_moment).collect() }
    }

    /// The largest E_1/γ; above 1 something breaks.
    pub fn e1_over_gamma(&self) -> f64 {
        self.first_moments.iter().zip(&self.gammas).map(|(first, gamma)| first / gamma).fold(0.0, f64::max)
    }
}

/// The threshold under weight is found to this relative precision of E_1.
const PRECISION: f64 = 1e-6;

/// Most impacts that are tried for it.
const TRIALS_MAX: usize = 48;

/// While only one side is known, every trial goes this much further, or as far as a threshold without weight would be.
const STRIDE: f64 = 4.0;

/// The factor on the impulses at which the object just breaks while its weight stays as it is; 0 where the weight alone breaks it.
/// `e1_over_gamma` tells E_1/γ at a factor: no multiple of its square then, which is why the factor is searched for, by regula
/// falsi on √E_1, nearly linear in it, and a bisection every third time.
///
/// # Errors
/// Those of `e1_over_gamma`.
pub(in crate::pipeline) fn under_weight(
    e1_over_gamma: &mut dyn FnMut(f64) -> Result<f64, FractureError>,
) -> Result<f64, FractureError> {
    // A factor and its √(E_1/γ), each.
    let (mut holds, mut breaks): (Option<[f64; 2]>, Option<[f64; 2]>) = (None, None);
    let mut factor = 1.0;
    for trial in 0..TRIALS_MAX {
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

    /// E_1/γ of a blow that adds to, or takes from, a weight whose own E_1/γ is `weight`².
    #[track_caller]
    fn check(blow: f64, weight: f64) {
        let mut trials = 0;
        let mut e1_over_gamma = |factor: f64| {
            trials += 1;
            Ok((blow * factor + weight).powi(2))
        };
        let found = under_weight(&mut e1_over_gamma).unwrap();
        let exact = if weight >= 1.0 { 0.0 } else { (1.0 - weight) / blow };
        assert!((found - exact).abs() * blow <= 1e-6, "{found} of {exact}");
        assert!(exact == 0.0 || trials < 30, "{trials} trials for {exact}");
    }

    #[test]
    fn the_threshold_under_weight_is_found() {
        for blow in [1e-9, 0.1, 1.0, 3.0, 1e7] {
            for weight in [0.0, 0.3, 0.999, 1.1, -0.5] {
                check(blow, weight);
            }
        }
    }
}
