//! A contact: put together step by step, and validated.

use super::{Contact, ContactWire, Purpose, duration, radius, ray, squarable};
use crate::{Error, ErrorKind};

impl Contact {
    /// A contact at `point_m`, whose impulse is still zero. Duration and radius are the object's.
    pub fn new(point_m: [f64; 3]) -> Self {
        Self { point_m, ray: None, impulse_ns: [0.0; 3], duration_s: None, radius_m: None }
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
}

impl ContactWire {
    /// Validates contact `i` of a request.
    ///
    /// # Errors
    /// `contact_point`, `ray`, `impulse`, `contact_duration`, `contact_radius`.
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
