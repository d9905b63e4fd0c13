//! Application of an artist's controls to the division of a body.

use super::energy::BodyEnergy;
use crate::centroidal::EnergyField;
use crate::pipeline::error::FractureError;
use crate::pipeline::prepared::object::PreparedObject;
use crate::pipeline::request::fracture_request::FractureRequest;

/// Masses of the fields after painting, with unchanged totals; `None` for a body without paint.
pub(in crate::pipeline) fn repainted(
    prepared: &PreparedObject,
    strike: &FractureRequest,
    energies: &[BodyEnergy],
    fields: &[EnergyField],
) -> Vec<Option<Vec<f64>>> {
    let repaint = |(energy, field): (&BodyEnergy, &EnergyField)| {
        let factors = &strike.controls_of(prepared, energy.body).filter(|warped| !warped.factors.is_empty())?.factors;
        let mut masses: Vec<f64> = field.mass().iter().zip(factors).map(|(mass, factor)| mass * factor).collect();
        let scale = field.mass().iter().sum::<f64>() / masses.iter().sum::<f64>();
        masses.iter_mut().for_each(|mass| *mass *= scale);
        Some(masses)
    };
    energies.iter().zip(fields).map(repaint).collect()
}

/// Fields under the controls: in the warped space, painted, with the fixed sites.
pub(in crate::pipeline) fn followed<'a>(
    prepared: &'a PreparedObject,
    strike: &FractureRequest,
    energies: &[BodyEnergy],
    fields: &[EnergyField<'a>],
    masses: &'a [Option<Vec<f64>>],
) -> Result<Vec<EnergyField<'a>>, FractureError> {
    let follow = |((energy, field), mass): ((&BodyEnergy, &EnergyField<'a>), &'a Option<Vec<f64>>)| {
        let mass = mass.as_deref().unwrap_or(field.mass());
        let field = field.like(strike.lift_of(prepared, energy.body)?, mass);
        Ok(strike.controls_of(prepared, energy.body).map_or(field, |warped| field.pinned(&warped.pins)))
    };
    energies.iter().zip(fields).zip(masses).map(follow).collect()
}
