//! Strain energy of a displacement, and the loads that it may come from.

use crate::elasticity::ReducedBasis;
use crate::pipeline::prepared::object::PreparedObject;
use crate::pipeline::prepared::parameters::DisplacementMethod;
use crate::pipeline::prepared::reduction::TRAINED_RADIUS_MIN;
use crate::pipeline::request::fracture_request::FractureRequest;

/// Energy of a displacement.
#[derive(Clone, Copy)]
pub(super) struct StrainEnergy {
    /// Elastic energy of the whole body, local; ½ f·u at rest.
    pub energy: f64,
    /// Estimated relative error of the energy of a reduced displacement; `None`: it was solved for.
    pub reduced_error: Option<f64>,
    /// True if the displacement is as [`ReducedBasis::expand`] writes it.
    pub is_expanded: bool,
}

/// Share of the largest error of a request above which the basis alone is not enough where a linear solve can complete it.
///
/// Estimates are within about a factor of two of the errors of the basis alone.
const ALONE: f64 = 0.5;

/// Largest estimated error at which the displacement of the basis alone serves the request; `None`: at no error.
pub(super) fn alone_error_max(
    prepared: &PreparedObject,
    basis: &ReducedBasis,
    request: &FractureRequest,
) -> Option<f64> {
    let share = if basis.completed_estimate().is_some() { ALONE } else { 1.0 };
    (!prepared.has_long_cells()).then_some(share * request.reduced_error_max)
}

/// Smallest radius of loads in a half-space on a body with this basis: a reduced basis has no smaller ones.
pub(super) fn spread_min(basis: Option<&ReducedBasis>, request: &FractureRequest) -> f64 {
    let is_reduced = request.elastic == DisplacementMethod::Reduced && basis.is_some();
    if is_reduced { TRAINED_RADIUS_MIN } else { 0.0 }
}
