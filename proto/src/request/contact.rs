//! A contact: put together step by step, and validated.

use super::{ContactPartner, Purpose, given, ray, squarable};
use crate::text::number;
use crate::{Error, ErrorKind};
use bytemuck::{Pod, Zeroable};

/// A contact as it travels. Everything finite; zero: the daemon chooses.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ContactWire {
    /// The contact point, m, or the origin of the ray. In the coordinates of the object, or of the request's convention, as are
    /// impulse, radius, and all lengths of the partner.
    pub point_m: [f64; 3],
    /// Impulse handed to the object, N·s; not zero, unless the request only aims.
    pub impulse_ns: [f64; 3],
    /// Contact duration, s; zero: the object's default.
    pub duration_s: f64,
    /// Contact radius, m; zero: the object's default.
    pub radius_m: f64,
    /// Direction of a ray whose first hit is the contact point; zero: there is no ray.
    pub ray: [f64; 3],
    /// Number of the body that strikes the object here: contacts with the same number have the same partner.
    pub partner: u64,
    /// Its mass, kg, may be infinite; zero: it is unknown, and so are its other properties.
    pub partner_mass_kg: f64,
    /// Closing speed of partner and object along the impulse, m/s; negative where they separate.
    pub speed_m_s: f64,
    /// Center of mass of the partner, m; of no effect without inertia.
    pub partner_center_m: [f64; 3],
    /// Inertia tensor of the partner about its center, kg·m²: xx, yy, zz, xy, xz, yz. Zero: it does not rotate.
    pub partner_inertia_kg_m2: [f64; 6],
}

const _: () = assert!(size_of::<ContactWire>() == 184);

/// One contact of an impact, in the coordinates of the request's convention. See [`ContactWire`] for the units.
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use = "a contact does nothing until it is part of an impact"]
pub struct Contact {
    /// The contact point, m; with a ray, its origin.
    pub point_m: [f64; 3],
    /// Direction of a ray, of any length: the contact point is where the ray first meets the object.
    pub ray: Option<[f64; 3]>,
    /// Impulse, N·s.
    pub impulse_ns: [f64; 3],
    /// Duration, s; `None`: the object's default.
    pub duration_s: Option<f64>,
    /// Radius, m; `None`: the object's default.
    pub radius_m: Option<f64>,
    /// Body that strikes the object here, and how fast; `None`: unknown, the energy of the impact has no limit.
    pub partner: Option<ContactPartner>,
}

impl Contact {
    /// A contact at `point_m`, whose impulse is still zero. Duration and radius are the object's.
    pub fn new(point_m: [f64; 3]) -> Self {
        Self { point_m, ray: None, impulse_ns: [0.0; 3], duration_s: None, radius_m: None, partner: None }
    }

    /// Makes the point the origin of a ray along `direction`: the contact is where the ray first meets the object. For impacts of one
    /// contact.
    pub fn ray(self, direction: [f64; 3]) -> Self {
        Self { ray: Some(direction), ..self }
    }

    /// Impulse, N·s: what the contact hands to the object. In a convention's unit of length: kg·unit/s.
    pub fn impulse(self, impulse_ns: [f64; 3]) -> Self {
        Self { impulse_ns, ..self }
    }

    /// Impulse along the ray, N·s; in a convention's unit of length kg·unit/s. Without a ray the impulse stays as it is.
    pub fn impulse_along_ray(self, impulse_ns: f64) -> Self {
        let Some(ray) = self.ray.map(squarable) else { return self };
        let length = ray.iter().map(|x| x * x).sum::<f64>().sqrt();
        self.impulse(ray.map(|x| impulse_ns * x / length))
    }

    /// Duration, s.
    pub fn duration(self, duration_s: f64) -> Self {
        Self { duration_s: Some(duration_s), ..self }
    }

    /// Radius, m.
    pub fn radius(self, radius_m: f64) -> Self {
        Self { radius_m: Some(radius_m), ..self }
    }

    /// The body that strikes the object here. Give one for all contacts or for none.
    pub fn partner(self, partner: ContactPartner) -> Self {
        Self { partner: Some(partner), ..self }
    }

    /// Contact `i` as it travels.
    ///
    /// # Errors
    /// `contact_duration`, `contact_radius`, `contact_partner`, `ray`, for a given zero.
    pub(super) fn wire(&self, i: usize) -> Result<ContactWire, Error> {
        let mut wire = ContactWire {
            point_m: self.point_m,
            impulse_ns: self.impulse_ns,
            duration_s: given(self.duration_s, |value| duration(i, value))?,
            radius_m: given(self.radius_m, |value| radius(i, value))?,
            ray: ray::wire(i, self.ray)?,
            ..ContactWire::zeroed()
        };
        if let Some(partner) = &self.partner {
            partner.write(i, &mut wire)?;
        }
        Ok(wire)
    }
}

impl ContactWire {
    /// Validates contact `i` of a request.
    ///
    /// # Errors
    /// `contact_point`, `ray`, `impulse`, `contact_duration`, `contact_radius`, `contact_partner`.
    pub(super) fn validate(&self, i: usize, purpose: Purpose) -> Result<Contact, Error> {
        if !self.point_m.iter().all(|x| x.is_finite()) {
            let at = format!("contacts[{i}].point_m");
            return Err(Error::new(ErrorKind::ContactPoint, at, format!("contact {i}: the point is not finite")));
        }
        // A ray without a direction leaves its impulse without one, too: the ray is what is wrong.
        let ray = ray::direction(i, self.ray)?;
        // The square is what the energy is made of: it must neither vanish nor overflow.
        let square: f64 = self.impulse_ns.iter().map(|x| x * x).sum();
        if !square.is_finite() || (square == 0.0 && purpose != Purpose::Aim) {
            let what = match square {
                0.0 => "zero or too small to be squared; pass a larger one",
                _ if self.impulse_ns.iter().all(|x| x.is_finite()) => "too large to be squared; pass a smaller one",
                _ => "not finite; pass a finite one",
            };
            let at = format!("contacts[{i}].impulse_ns");
            let message = format!("contact {i}: the impulse is {what}");
            return Err(Error::new(ErrorKind::Impulse, at, message));
        }
        Ok(Contact {
            point_m: self.point_m,
            ray,
            impulse_ns: self.impulse_ns,
            duration_s: positive_or_default(self.duration_s, |value| duration(i, value))?,
            radius_m: positive_or_default(self.radius_m, |value| radius(i, value))?,
            partner: ContactPartner::read(i, self)?,
        })
    }
}

/// Zero: not given. Otherwise finite and positive.
fn positive_or_default(value: f64, refuse: impl Fn(f64) -> Error) -> Result<Option<f64>, Error> {
    match value {
        0.0 => Ok(None),
        value if value.is_finite() && value > 0.0 => Ok(Some(value)),
        value => Err(refuse(value)),
    }
}

fn duration(i: usize, value: f64) -> Error {
    let at = format!("contacts[{i}].duration_s");
    let message = format!("contact {i}: duration {}: must be finite and above zero", number(value));
    Error::new(ErrorKind::ContactDuration, at, message)
}

fn radius(i: usize, value: f64) -> Error {
    let at = format!("contacts[{i}].radius_m");
    let message = format!("contact {i}: radius {}: must be finite and above zero", number(value));
    Error::new(ErrorKind::ContactRadius, at, message)
}
