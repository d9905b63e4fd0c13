//! Strain energy of a displacement, and the loads that it may come from.

use crate::elasticity::ReducedBasis;
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

/// Smallest radius of loads in a half-space on a body with this basis: a reduced basis has no smaller ones.
pub(super) fn spread_min(basis: Option<&ReducedBasis>, request: &FractureRequest) -> f64 {
    let is_reduced = request.elastic == DisplacementMethod::Reduced && basis.is_some();
    if is_reduced { TRAINED_RADIUS_MIN } else { 0.0 }
}
