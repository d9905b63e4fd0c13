//! Strain energy of a displacement, and the loads that it may come from.

use crate::elasticity::ReducedBasis;
use crate::pipeline::prepared::object::PreparedObject;
use crate::pipeline::prepared::parameters::DisplacementMethod;
use crate::pipeline::prepared::reduction::TRAINED_RADIUS_MIN;
use crate::pipeline::request::fracture_request::{DegreeRequest, FractureRequest};
use crate::scene::EffectKind;
use crate::strength::Criterion;

/// Energy of a displacement.
#[derive(Clone, Copy)]
pub(super) struct StrainEnergy {
    /// Elastic energy of the whole body, local; ½ f·u at rest.
    pub energy: f64,
    /// Estimated relative error of the energy of a reduced displacement; `None`: it was solved for.
    pub reduced_error: Option<f64>,
    /// True if the displacement is as [`ReducedBasis::expand`] writes it.
    pub is_expanded: bool,
    /// [Factors](crate::elasticity::CompletedEnergy::shares) of the displacement of linear elements that completes it;
    /// `None` without one.
    pub completion: Option<[f64; 2]>,
}

/// Share of the largest error of a request above which the basis alone is not enough where a linear solve can complete it.
///
/// Of narrow contacts on a plate the basis alone misses up to twice what is estimated: 5.7 % instead of 3.2 %.
const ALONE: f64 = 0.3;

/// Largest estimated error at which the displacement of the basis alone serves the request; `None`: at no error.
pub(super) fn alone_error_max(
    prepared: &PreparedObject,
    basis: &ReducedBasis,
    request: &FractureRequest,
) -> Option<f64> {
    alone_share(prepared, basis).map(|share| share * request.reduced_error_max)
}

/// Largest estimated error of the basis alone over the accepted error; `None`: a linear solve always completes it.
pub(in crate::pipeline) fn alone_share(prepared: &PreparedObject, basis: &ReducedBasis) -> Option<f64> {
    let share = if basis.completed_estimate().is_some() { ALONE } else { 1.0 };
    (!prepared.has_long_cells()).then_some(share)
}

/// Peak stress over the strength below which an impact on a body by the criterion of strength is weak, with the basis alone.
///
/// With told errors of the energy of at most [`WEAK_ERROR_MAX`], peak stresses of the basis alone were at least 0.53 of those of
/// solves: 175 random impacts on a mug, an arch and a plate.
pub(super) const WEAK_STRESS: f64 = 0.25;

/// Largest estimated error of the energy of the basis alone at which a weak impact needs no better displacement.
pub(super) const WEAK_ERROR_MAX: f64 = 0.5;

/// The same limit, over the largest error that the request accepts.
pub(super) const WEAK_ERROR_RATIO: f64 = 5.0;

/// True if an impact that the body withstands may end with a rough displacement, where stresses are far below the strength.
pub(super) fn may_be_weak(request: &FractureRequest) -> bool {
    let is_exact = request.threshold_only || request.elastic == DisplacementMethod::Solve;
    let is_given = matches!(request.degree, DegreeRequest::Sites(_));
    let is_static = [EffectKind::Dynamics, EffectKind::Gravity].into_iter().all(|effect| !request.effects.has(effect));
    request.criterion == Criterion::Strength && is_static && !is_exact && !is_given
}

/// Smallest radius of loads in a half-space on a body with this basis: a reduced basis has no smaller ones.
pub(super) fn spread_min(basis: Option<&ReducedBasis>, request: &FractureRequest) -> f64 {
    let is_reduced = request.elastic == DisplacementMethod::Reduced && basis.is_some();
    if is_reduced { TRAINED_RADIUS_MIN } else { 0.0 }
}
