//! First half of the load stage: converts contacts from meters and newton-seconds to relative forces in the local
//! frame, by body.
//!
//! Based on: Hertz impact as a half-sine pulse (Johnson, *Contact Mechanics*, 1985, section 11.4): peak force F =
//! (π/2)·J/τ.

use crate::elasticity::{self, NearestBoundaryPoint};
use crate::pipeline::contact::ImpactContact;
use crate::pipeline::error::{CONTACTS_MAX, FractureError};
use crate::pipeline::prepared::object::PreparedObject;
use crate::pipeline::prepared::parameters::SurfaceKind;
use crate::pipeline::request::fracture_request::FractureRequest;
use crate::scene::{DEFAULT_DURATION_S, DEFAULT_RADIUS_DIAGONALS, EffectKind};
use nalgebra::Vector3;

/// Rounding step of relative forces, so that scaling an impact does not change their bits.
const FORCE_STEP: f64 = 1.0 / (1u64 << 40) as f64;

/// Index of a struck body, and its contacts.
type BodyContacts = (usize, Vec<elasticity::ContactLoad>);

/// Contacts of one request, in local units and by body.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactSet {
    /// Largest peak force of all contacts, N; the unit of relative forces.
    pub peak_force_n: f64,
    /// Struck bodies in ascending order with their contacts: impulses as fractions of the peak force, lengths local.
    pub bodies: Vec<BodyContacts>,
    /// Durations of the contacts of each struck body, s.
    pub durations_s: Vec<Vec<f64>>,
    /// Index of the body that each contact of the request strikes.
    pub body_of_contact: Vec<usize>,
}

impl ContactSet {
    /// Validates the contacts of `strike` and assigns each to the nearest body.
    ///
    /// # Errors
    /// [`FractureError`] by the contact that is invalid or too far from every body.
    pub fn new(prepared: &PreparedObject, strike: &FractureRequest) -> Result<Self, FractureError> {
        let count = strike.contacts.len();
        if !(1..=CONTACTS_MAX).contains(&count) {
            return Err(FractureError::ContactCount(count));
        }
        let forces = strike
            .contacts
            .iter()
            .enumerate()
            .map(|(index, contact)| peak_force_n(index, contact))
            .collect::<Result<Vec<_>, _>>()?;
        let peak_force_n = forces.iter().map(|force| force.norm()).fold(0.0, f64::max);
        let mut bodies: Vec<(BodyContacts, Vec<f64>)> = Vec::new();
        let mut body_of_contact = Vec::with_capacity(count);
        for (index, (contact, force)) in strike.contacts.iter().zip(&forces).enumerate() {
            let relative = *force / peak_force_n;
            let (body, mut local) = locate((prepared, strike.surface), index, contact, relative)?;
            if strike.effects.has(EffectKind::Elastic) {
                // The boundary of the coarser lattice may be farther away than the radius. The load is still spread
                // from the nearest boundary point.
                local.radius = local.radius.max(prepared.solid(body)?.elasticity.distance(&local.point));
            }
            let duration_s = duration_s(contact);
            body_of_contact.push(body);
            match bodies.iter_mut().find(|((known, _), _)| *known == body) {
                Some(((_, contacts), durations_s)) => {
                    contacts.push(local);
                    durations_s.push(duration_s);
                }
                None => bodies.push(((body, vec![local]), vec![duration_s])),
            }
        }
        bodies.sort_by_key(|((body, _), _)| *body);
        let (bodies, durations_s) = bodies.into_iter().unzip();
        Ok(Self { peak_force_n, bodies, durations_s, body_of_contact })
    }
}

impl ContactSet {
    /// Joules per unit of local energy: F²/(E·L).
    pub fn unit_j(&self, prepared: &PreparedObject) -> f64 {
        self.peak_force_n.powi(2) / (prepared.parameters.material.young_pa * prepared.frame.diagonal_m)
    }

    /// Local unit of time per second: √(E/ρ)/L, with which a body of unit modulus, density and diagonal vibrates.
    pub fn times_per_s(prepared: &PreparedObject) -> f64 {
        let material = &prepared.parameters.material;
        (material.young_pa / material.density_kg_m3).sqrt() / prepared.frame.diagonal_m
    }

    /// Fraction of the peak force per unit of local weight at unit density: ρL³/F.
    pub fn weight_unit(&self, prepared: &PreparedObject) -> f64 {
        prepared.parameters.material.density_kg_m3 * prepared.frame.diagonal_m.powi(3) / self.peak_force_n
    }
}

fn duration_s(given: &ImpactContact) -> f64 {
    given.duration_s.unwrap_or(DEFAULT_DURATION_S)
}

fn peak_force_n(contact: usize, given: &ImpactContact) -> Result<Vector3<f64>, FractureError> {
    let duration_s = duration_s(given);
    let numbers = given.point_m.iter().map(|x| ("point", *x, false));
    let numbers = numbers.chain(given.impulse_ns.iter().map(|x| ("impulse", *x, false)));
    let numbers = numbers.chain([("duration", duration_s, true), ("radius", given.radius_m.unwrap_or(1.0), true)]);
    for (key, value, positive) in numbers {
        if !value.is_finite() || (positive && value <= 0.0) {
            return Err(FractureError::Number { contact, key, value, positive });
        }
    }
    if given.impulse_ns == Vector3::zeros() {
        return Err(FractureError::ZeroImpulse { contact });
    }
    let force = given.impulse_ns * (std::f64::consts::FRAC_PI_2 / duration_s);
    if force.norm().is_normal() {
        return Ok(force);
    }
    let square = force.norm_squared();
    let value = if square.is_nan() { f64::INFINITY } else { square };
    Err(FractureError::Number { contact, key: "the square of impulse over duration", value, positive: true })
}

/// The nearest body, and the contact in its local units; an error if the surface is farther away than the radius and a lattice spacing.
///
/// The surface is that of the fragments of kind `kind`. A crack lattice approximates it to within its spacing, because it rounds
/// corners off.
fn locate(
    (prepared, kind): (&PreparedObject, SurfaceKind),
    index: usize,
    contact: &ImpactContact,
    relative: Vector3<f64>,
) -> Result<(usize, elasticity::ContactLoad), FractureError> {
    let point = prepared.frame.to_local(&contact.point_m);
    let radius = contact.radius_m.map_or(DEFAULT_RADIUS_DIAGONALS, |radius_m| radius_m / prepared.frame.diagonal_m);
    let nearest = prepared.bodies.iter().map(|body| body.contact_surface(kind).nearest(&point));
    let nearest = nearest.enumerate().filter_map(|(body, nearest)| Some((body, nearest?)));
    let nearest = nearest.reduce(|best, next| if next.1.distance < best.1.distance { next } else { best });
    let Some((body, nearest)) = nearest else { return Err(FractureError::OtherObject) };
    let NearestBoundaryPoint { place, distance, .. } = nearest;
    let lattice = prepared.report.surface_deviation.max(prepared.parameters.crack_spacing);
    // Far from the origin, the precision of a point is limited by the rounding of its coordinates.
    let rounding = f64::EPSILON * contact.point_m.coords.amax() / prepared.frame.diagonal_m;
    let limit = radius + lattice + rounding;
    if distance > limit {
        return Err(FractureError::TooFar {
            contact: index,
            distance: distance * prepared.frame.diagonal_m,
            limit: limit * prepared.frame.diagonal_m,
            surface: prepared.frame.to_meters(&place),
            unit_m: 1.0,
        });
    }
    let impulse = relative.map(|x| (x / FORCE_STEP).round() * FORCE_STEP);
    let point = prepared.bodies[body].load_place(kind, point, &nearest);
    Ok((body, elasticity::ContactLoad { point, impulse, radius }))
}
