//! Kinetic energy that an impact brings, and the factor on its load that keeps the strain energy within that.
//!
//! Contacts c have the directions d_c of their impulses on the object, and closing speeds v_c. Impulses λ_c ≥ 0 along d_c
//! take the energy v·λ − ½ λ·Aλ from the motion of the object and its partners. A[c, e] = d_c·d_e/m + (r_c × d_c)·I⁻¹(r_e × d_e)
//! is summed over the bodies that both contacts touch. The largest value is E_in: ½ v·A⁺v unless a contact would pull.
//!
//! Based on: the inverse mass J M⁻¹Jᵀ of contacts (F. Pfeiffer & C. Glocker, *Multibody Dynamics with Unilateral
//! Contacts*, 1996). E_in as a limit of the load is ours: see [`super::indentation`].

use super::contact_set::ContactSet;
use super::energy::BodyEnergy;
use super::indentation::{IndentationEnergy, load_factor};
use crate::fragment::RigidProperties;
use crate::pipeline::contact::{ImpactPartner, PartnerError};
use crate::pipeline::prepared::object::PreparedObject;
use crate::pipeline::request::fracture_request::FractureRequest;
use crate::pipeline::result::ImpactorReport;
use crate::scene::EffectKind;
use nalgebra::{DMatrix, DVector, Matrix3, Point3, Vector3};

/// Eigenvalues of the inverse masses below this share of the largest count as zero: their contacts depend on each other.
///
/// Speeds rounded to 32 bits change the energy of contacts 20 pm to 0.1 m apart by 2.4e-7 at most (test).
const DEPENDENT: f64 = 1e-9;

/// Share of the largest impulse up to which a negative one is taken for rounding.
const ROUNDING: f64 = 1e-9;

/// E_in of `request`, J; `None` without partners.
///
/// # Errors
/// [`PartnerError`], naming the contact.
pub(in crate::pipeline) fn impactor_energy_j(
    prepared: &PreparedObject,
    request: &FractureRequest,
    contacts: &ContactSet,
) -> Result<Option<f64>, PartnerError> {
    let partners = partners(request)?;
    if partners.is_empty() {
        return Ok(None);
    }
    let line = |contact: usize| {
        let own = &request.contacts[contact];
        ContactLine { point: own.point_m, direction: own.impulse_ns.normalize() }
    };
    let lines: Vec<ContactLine> = (0..partners.len()).map(line).collect();
    let object = contacts.bodies.iter().map(|(body, _)| (*body, RigidBody::of_object(prepared, request, *body)));
    let object: Vec<(usize, Option<RigidBody>)> = object.collect();
    let own = |contact: usize| object.iter().find(|(body, _)| *body == contacts.body_of_contact[contact])?.1.as_ref();
    let striking: Vec<Option<RigidBody>> = partners.iter().map(RigidBody::of_partner).collect();
    let of_bodies = |row: usize, column: usize| {
        let is_same_body = contacts.body_of_contact[row] == contacts.body_of_contact[column];
        let is_same_partner = partners[row].id == partners[column].id;
        let bodies = [own(row).filter(|_| is_same_body), striking[row].as_ref().filter(|_| is_same_partner)];
        bodies.into_iter().flatten().map(|body| body.inverse_mass_of(&lines[row], &lines[column])).sum()
    };
    // One half and its mirror image, so that rounding leaves the matrix symmetric.
    let inverse_masses =
        DMatrix::from_fn(partners.len(), partners.len(), |row, column| of_bodies(row.min(column), row.max(column)));
    let immovable: Vec<usize> = (0..partners.len()).filter(|own| inverse_masses[(*own, *own)] == 0.0).collect();
    if !immovable.is_empty() {
        return Err(PartnerError::Immovable { contacts: immovable });
    }
    let speeds_m_s = DVector::from_iterator(partners.len(), partners.iter().map(|partner| partner.speed_m_s));
    let energy_j = energy_j(&inverse_masses, &speeds_m_s);
    if energy_j.is_finite() { Ok(Some(energy_j)) } else { Err(PartnerError::Energy(energy_j)) }
}

/// The factor on all loads with which `energies` and the indentations of contacts add up to at most `energy_j`.
pub(in crate::pipeline) fn limit_load(energy_j: f64, energies: &[BodyEnergy]) -> ImpactorReport {
    let strain_j: f64 = energies.iter().filter_map(|energy| energy.strain_j).sum();
    let of_bodies = energies.iter().map(|energy| energy.indentation);
    let indentation = of_bodies.fold(IndentationEnergy::default(), |sum, own| IndentationEnergy {
        bells_j: sum.bells_j + own.bells_j,
        hertz_j: sum.hertz_j + own.hertz_j,
    });
    ImpactorReport { energy_j, load_factor: Some(load_factor(energy_j, strain_j, indentation)) }
}

/// Partners of all contacts, after the checks; empty without partners.
fn partners(request: &FractureRequest) -> Result<Vec<ImpactPartner>, PartnerError> {
    let given: Vec<ImpactPartner> = request.contacts.iter().filter_map(|contact| contact.partner).collect();
    if given.is_empty() {
        return Ok(given);
    }
    if let Some(contact) = request.contacts.iter().position(|contact| contact.partner.is_none()) {
        return Err(PartnerError::Missing { contact });
    }
    for (contact, own) in given.iter().enumerate() {
        own.check(contact)?;
        let first = given.iter().position(|other| other.id == own.id).unwrap_or(contact);
        if let Some(key) = given[first].difference(own) {
            return Err(PartnerError::Differs { contacts: [first, contact], key });
        }
    }
    match () {
        () if !request.effects.has(EffectKind::Elastic) => Err(PartnerError::Elastic),
        () if request.effects.has(EffectKind::Gravity) => Err(PartnerError::Gravity),
        () if request.threshold_only => Err(PartnerError::Threshold),
        () => Ok(given),
    }
}

impl ImpactPartner {
    /// Checks the numbers of the partner of contact `contact`.
    fn check(&self, contact: usize) -> Result<(), PartnerError> {
        if self.mass_kg.is_nan() || self.mass_kg <= 0.0 {
            return Err(PartnerError::Mass { contact, value: self.mass_kg });
        }
        let numbers = std::iter::once(("speed", self.speed_m_s)).chain(self.center_m.iter().map(|x| ("center", *x)));
        let mut numbers = numbers.chain(self.inertia_kg_m2.iter().map(|x| ("inertia", *x)));
        if let Some((key, value)) = numbers.find(|(_, value)| !value.is_finite()) {
            return Err(PartnerError::Number { contact, key, value });
        }
        let is_definite = self.inertia_kg_m2 == [0.0; 6] || self.inertia().cholesky().is_some();
        if is_definite { Ok(()) } else { Err(PartnerError::Inertia { contact }) }
    }

    /// Name of the first property that differs from that of `other`; the speed may differ.
    fn difference(&self, other: &Self) -> Option<&'static str> {
        match () {
            () if self.mass_kg != other.mass_kg => Some("mass"),
            () if self.center_m != other.center_m => Some("center"),
            () if self.inertia_kg_m2 != other.inertia_kg_m2 => Some("inertia"),
            () => None,
        }
    }

    fn inertia(&self) -> Matrix3<f64> {
        let [xx, yy, zz, xy, xz, yz] = self.inertia_kg_m2;
        Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
    }
}

/// Line along which a contact pushes: its point, m, and a unit vector.
struct ContactLine {
    point: Point3<f64>,
    direction: Vector3<f64>,
}

/// Body that an impulse moves.
struct RigidBody {
    inverse_mass: f64,
    /// Center of mass, m.
    center: Point3<f64>,
    /// Inverse of the inertia tensor about the center, 1/(kg·m²); zero: it does not rotate.
    inverse_inertia: Matrix3<f64>,
}

impl RigidBody {
    /// Body `body` of the object; `None` if it is anchored.
    fn of_object(prepared: &PreparedObject, request: &FractureRequest, body: usize) -> Option<Self> {
        let held = prepared.held.as_ref().filter(|_| request.effects.has(EffectKind::Anchored));
        if held.is_some_and(|held| held.body(body).is_some()) {
            return None;
        }
        let RigidProperties { volume, center, inertia } = prepared.bodies[body].rigid_properties();
        let (density_kg_m3, length_m) = (prepared.parameters.material.density_kg_m3, prepared.frame.diagonal_m);
        let mass_kg = density_kg_m3 * volume * length_m.powi(3);
        let inertia_kg_m2 = inertia * (density_kg_m3 * length_m.powi(5));
        Some(Self {
            inverse_mass: 1.0 / mass_kg,
            center: prepared.frame.to_meters(&center),
            inverse_inertia: inertia_kg_m2.try_inverse().unwrap_or_default(),
        })
    }

    /// A partner; `None` if it does not move.
    fn of_partner(partner: &ImpactPartner) -> Option<Self> {
        let inverse_inertia = partner.inertia().try_inverse().unwrap_or_default();
        let inverse_mass = 1.0 / partner.mass_kg;
        (inverse_mass > 0.0).then_some(Self { inverse_mass, center: partner.center_m, inverse_inertia })
    }

    /// Speed along line `one` per impulse along line `other`, 1/kg.
    fn inverse_mass_of(&self, one: &ContactLine, other: &ContactLine) -> f64 {
        let lever = |line: &ContactLine| (line.point - self.center).cross(&line.direction);
        let turned = lever(one).dot(&(self.inverse_inertia * lever(other)));
        self.inverse_mass * one.direction.dot(&other.direction) + turned
    }
}

/// The largest energy that impulses at contacts can take from these closing speeds, J, if no contact pulls.
fn energy_j(inverse_masses: &DMatrix<f64>, speeds_m_s: &DVector<f64>) -> f64 {
    let count = speeds_m_s.len();
    let all: Vec<usize> = (0..count).collect();
    let whole = stopped(inverse_masses, speeds_m_s, &all);
    if whole.pushes {
        return whole.energy_j;
    }
    // The largest energy is that of the contacts which push; there are at most 255 choices.
    let subsets = (1..1_u32 << count).map(|bits| all.iter().copied().filter(|own| bits >> own & 1 == 1).collect());
    let subsets = subsets.map(|own: Vec<usize>| stopped(inverse_masses, speeds_m_s, &own));
    let pushing = subsets.filter(|own| own.pushes).map(|own| own.energy_j);
    // Speeds that no rigid bodies have may leave a part with more than the whole.
    pushing.fold(0.0, f64::max).min(whole.energy_j)
}

/// Result of impulses that bring contacts to rest.
struct StoppedContacts {
    /// Energy that they take, J.
    energy_j: f64,
    /// True if no impulse pulls.
    pushes: bool,
}

/// Stops the contacts `own`; the others have no impulse.
fn stopped(inverse_masses: &DMatrix<f64>, speeds_m_s: &DVector<f64>, own: &[usize]) -> StoppedContacts {
    let speeds = speeds_m_s.select_rows(own);
    let eigen = inverse_masses.select_rows(own).select_columns(own).symmetric_eigen();
    let least = DEPENDENT * eigen.eigenvalues.amax();
    let inverse = eigen.eigenvalues.map(|value| if value > least { 1.0 / value } else { 0.0 });
    let impulses = &eigen.eigenvectors * eigen.eigenvectors.tr_mul(&speeds).component_mul(&inverse);
    let pull = -ROUNDING * impulses.amax();
    StoppedContacts { energy_j: 0.5 * impulses.dot(&speeds), pushes: impulses.iter().all(|impulse| *impulse >= pull) }
}

#[cfg(test)]
mod tests;
