//! Strain energy without elasticity, by distance from the contacts.
//!
//! Based on: the half-space under a point load (J. Boussinesq, 1885; Johnson, *Contact Mechanics*, 1985, section 3.2),
//! whose stress falls with the inverse square of the distance. Limiting it to the mean pressure within the contact
//! radius a is ours: σ = F/(πa²) / (1 + (d/a)²), W = σ²/(2E). Energies of contacts add. Bodies that bend, or are not
//! large relative to their contacts, have more energy in reality, and a different distribution.

use super::contact_set::ContactSet;
use super::energy::BodyEnergy;
use crate::elasticity::ContactLoad;
use crate::pipeline::error::FractureError;
use crate::pipeline::prepared::object::PreparedObject;
use nalgebra::Point3;

/// Smallest contact radius in spacings of the crack lattice, which does not resolve smaller ones.
const RADIUS_SPACINGS: f64 = 1.0;

/// The energy of every struck body.
///
/// Errors: [`FractureError::Balanced`] if impulses are so small, or contacts so wide, that the energy underflows.
///
/// # Errors
/// [`FractureError::Balanced`] where impulses are too weak, or their contacts too wide, for a number to hold their energy.
pub(in crate::pipeline) fn falloff(
    prepared: &PreparedObject,
    impact: &ContactSet,
) -> Result<Vec<BodyEnergy>, FractureError> {
    let unit_j = impact.unit_j(prepared);
    let least = RADIUS_SPACINGS * prepared.parameters.crack_spacing;
    let energy = |(index, contacts): &(usize, Vec<ContactLoad>)| {
        let body = &prepared.bodies[*index];
        let of = |(node, volume): (&Point3<f64>, &f64)| {
            volume * contacts.iter().map(|contact| density(contact, least, node)).sum::<f64>()
        };
        let mut shares: Vec<f64> = body.crack.nodes.iter().zip(&body.volumes).map(of).collect();
        let total: f64 = shares.iter().sum();
        if !total.is_normal() {
            return Err(FractureError::Balanced { body: *index });
        }
        shares.iter_mut().for_each(|share| *share /= total);
        let radius = contacts.iter().map(|contact| contact.radius.max(least)).fold(0.0, f64::max);
        Ok(BodyEnergy {
            body: *index,
            shares,
            energy_j: total * unit_j,
            strain_j: None,
            indentation: Default::default(),
            peaks: Vec::new(),
            reduced_error: None,
            radius_m: radius * prepared.frame.diagonal_m,
        })
    };
    impact.bodies.iter().map(energy).collect()
}

/// Energy density W at `node`, in units of E.
fn density(contact: &ContactLoad, least: f64, node: &Point3<f64>) -> f64 {
    let square = contact.radius.max(least).powi(2);
    let pressure = contact.impulse.norm() / (std::f64::consts::PI * square);
    let stress = pressure / (1.0 + (node - contact.point).norm_squared() / square);
    0.5 * stress * stress
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    /// ∫W over the half-space below a contact is F²/(4Ea).
    #[test]
    fn the_energy_below_a_contact_is_that_of_the_formula() {
        let contact = ContactLoad { point: Point3::origin(), impulse: Vector3::new(0.0, -2.0, 0.0), radius: 0.1 };
        let step = 0.1 / 64.0;
        let shell = |k: usize| {
            let r = (k as f64 + 0.5) * step;
            std::f64::consts::TAU * r * r * step * density(&contact, 0.05, &Point3::new(r, 0.0, 0.0))
        };
        let sum: f64 = (0..1 << 20).map(shell).sum();
        assert!((sum / 10.0 - 1.0).abs() < 1e-3, "{sum}");
        assert_eq!(density(&contact, 0.2, &Point3::origin()), density(&contact, 0.1, &Point3::origin()) / 16.0);
    }
}
