//! Rays: the contact is the point where one first meets the object.

use crate::{Deadline, FractureResult, Impact, Object};
use shatter_proto::request::Contact;
use shatter_proto::result::{FragmentSurface, HitWire};
use shatter_proto::{Error, ErrorKind};

/// A ray, in the coordinates of the connection: those of the mesh file unless it has a convention.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Origin, m.
    pub origin_m: [f64; 3],
    /// Direction, of any length but zero.
    pub direction: [f64; 3],
}

/// The contact where the ray first meets the object; its impulse is still zero.
impl From<Ray> for Contact {
    fn from(ray: Ray) -> Self {
        Self::new(ray.origin_m).ray(ray.direction)
    }
}

/// First intersection of a ray with an object, in the coordinates of the connection.
///
/// The surface is the one that the service projects contact points on: that of the fragments which the request asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Hit {
    /// The point, m.
    pub point_m: [f64; 3],
    /// Outward normal of the surface there, of length one.
    pub normal: [f64; 3],
    /// From the origin of the ray to the point, m.
    pub distance_m: f64,
    /// Body (component of the object) that it lies on.
    pub body: u32,
    /// Surface that the ray hit: the input's own, or the boundary of the crack lattice, which approximates it.
    pub surface: FragmentSurface,
}

impl Hit {
    /// Of its row, if the request had a ray.
    fn of(row: &HitWire) -> Option<Self> {
        let HitWire { point_m, normal, distance_m, body, surface: _ } = *row;
        row.hit_surface().map(|surface| Self { point_m, normal, distance_m, body, surface })
    }
}

impl FractureResult {
    /// Intersection of the request's ray with the object; `None` if the request had no ray.
    #[must_use]
    pub fn hit(&self) -> Option<Hit> {
        Hit::of(&self.raw_view().summary.hit)
    }
}

impl Object {
    /// Returns the first intersection of `ray` with the object; waits for the service. To do so without waiting, strike with [`Impact::aim`] and
    /// read [`FractureResult::hit`].
    ///
    /// # Errors
    /// `ray` without a direction, `ray_missed` with the closest approach, and those of [`Object::strike`] and
    /// [`Ticket::wait`](crate::Ticket::wait).
    pub fn aim(&self, ray: Ray, deadline: Deadline) -> Result<Hit, Error> {
        self.first_hit(&Impact::aim(ray), deadline)
    }

    /// Returns the first intersection of `ray` with fragment `fragment` of the result that the service keeps under `handle`. A
    /// fragment with the lattice's surface is hit on its whole tetrahedra, up to a spacing of the crack lattice within its surface.
    ///
    /// # Errors
    /// Those of [`Object::aim`], and `unknown_handle`, `unknown_fragment`, `fragment_size`.
    pub fn aim_at_fragment(&self, handle: u64, fragment: u32, ray: Ray, deadline: Deadline) -> Result<Hit, Error> {
        self.first_hit(&Impact::aim(ray).from(handle, fragment), deadline)
    }

    fn first_hit(&self, aim: &Impact, deadline: Deadline) -> Result<Hit, Error> {
        let result = self.strike(aim)?.wait(deadline)?;
        result.hit().ok_or_else(|| Error::new(ErrorKind::BadResult, "hit", "the service sent no hit for a ray"))
    }
}
