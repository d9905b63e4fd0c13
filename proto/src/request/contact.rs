//! A contact, put together step by step.

use super::{Contact, squarable};

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
