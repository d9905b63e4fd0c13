//! Threshold test by an upper bound of E_1, without a solve.

use super::contact_set::ContactSet;
use crate::elasticity::{NodalLoad, RESPONSE_MAX};
use crate::pipeline::prepared::object::PreparedObject;
use crate::pipeline::prepared::parameters::DisplacementMethod;
use crate::pipeline::request::fracture_request::{DegreeRequest, FractureRequest};
use crate::scene::EffectKind;
use crate::strength::Criterion;

/// True if a bound may decide `strike`: γ decides, the body is free, and neither exact figures nor a number of sites
/// are requested.
pub(in crate::pipeline) fn is_sufficient(strike: &FractureRequest) -> bool {
    let free = strike.effects.has(EffectKind::Elastic) && !strike.effects.has(EffectKind::Anchored);
    let exact = strike.threshold_only || strike.elastic == DisplacementMethod::Solve;
    strike.criterion == Criterion::Paper && free && !exact && !matches!(strike.degree, DegreeRequest::Sites(_))
}

/// An upper bound of E_1/γ over all struck bodies, if it is at most 1. `loads` belong to the bodies of the impact.
pub(in crate::pipeline) fn below(
    prepared: &PreparedObject,
    strike: &FractureRequest,
    impact: &ContactSet,
    gamma_j_m2: f64,
    loads: &mut [NodalLoad],
) -> Option<f64> {
    let unit = impact.unit_j(prepared) * prepared.frame.diagonal_m * prepared.frame.diagonal_m / gamma_j_m2;
    let unit = dynamic_factor(strike, impact)? * unit;
    let mut most = 0.0f64;
    for ((body, _), load) in impact.bodies.iter().zip(loads) {
        // A request with a missing lift must fail later with its error, so no bound decides it.
        prepared.lift(*body, strike.lift).ok()?;
        let bound = prepared.bodies[*body].bound.as_ref()?;
        prepared.solid(*body).ok()?.elasticity.balance(load);
        let first_moment = bound.first_moment(strike.lift, load)?;
        let own = first_moment * unit;
        most = Some(own).filter(|own| own.is_normal() && *own <= 1.0)?.max(most);
    }
    Some(most)
}

/// Bound of a body's energy over that under its peak forces at rest; `None` where contacts of one body differ in duration,
/// since what cancels at rest may then add up.
fn dynamic_factor(strike: &FractureRequest, impact: &ContactSet) -> Option<f64> {
    if !strike.effects.has(EffectKind::Dynamics) {
        return Some(1.0);
    }
    let is_one = |durations: &Vec<f64>| durations.windows(2).all(|pair| pair[0] == pair[1]);
    // Energies grow with the square of the displacement of each vibration, and none exceeds this.
    impact.durations_s.iter().all(is_one).then_some(RESPONSE_MAX * RESPONSE_MAX)
}
