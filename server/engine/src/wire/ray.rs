//! Rays of requests: their hits, and the result of a request that only aims.

use super::engine_error_in;
use crate::object::EngineResult;
use bytemuck::Zeroable;
use nalgebra::Vector3;
use shatter_fracture::pipeline::{AimRay, FractureError, StageObserver, SurfaceHit, SurfaceKind};
use shatter_proto::Error;
use shatter_proto::convention::Convention;
use shatter_proto::layout::{SectionCounts, SectionsMut};
use shatter_proto::request::{Contact, Request, squarable};
use shatter_proto::result::{FragmentSurface, HitWire, SummaryWire};

/// First hit of the ray of `strike`; zeroed without a ray.
pub(super) fn first_hit(
    strike: &Request,
    aim: impl FnOnce(&AimRay) -> Result<SurfaceHit, FractureError>,
) -> Result<HitWire, Error> {
    let convention = &strike.convention;
    match strike.contacts.first().and_then(|contact| ray(contact, convention)) {
        None => Ok(HitWire::zeroed()),
        Some(ray) => aim(&ray).map(|hit| written(&hit, convention)).map_err(|error| engine_error_in(error, convention)),
    }
}

/// Copy of `strike` with the contact at the point that its ray hit.
pub(super) fn pointed(strike: &Request, hit: &HitWire) -> Request {
    let mut strike = strike.clone();
    if let Some(contact) = strike.contacts.first_mut().filter(|_| hit.surface != 0) {
        (contact.point_m, contact.ray) = (hit.point_m, None);
    }
    strike
}

fn ray(contact: &Contact, from: &Convention) -> Option<AimRay> {
    let direction = Vector3::from(from.our_direction(squarable(contact.ray?)));
    Some(AimRay { origin_m: from.our_vector(contact.point_m).into(), direction })
}

fn written(hit: &SurfaceHit, to: &Convention) -> HitWire {
    HitWire {
        point_m: to.vector(hit.point_m.coords.into()),
        normal: to.direction(hit.normal.into()),
        distance_m: to.length(hit.distance_m),
        body: hit.body as u32,
        surface: HitWire::code_of(fragment_surface(hit.surface)),
    }
}

fn fragment_surface(kind: SurfaceKind) -> FragmentSurface {
    match kind {
        SurfaceKind::Exact => FragmentSurface::Exact,
        SurfaceKind::Lattice => FragmentSurface::Lattice,
    }
}

/// Result of a request that only aims.
pub(super) struct AimResult {
    object: String,
    seed: u64,
    hit: HitWire,
}

impl AimResult {
    /// Creates the result of `strike` with this hit.
    pub fn new(strike: &Request, hit: HitWire) -> Self {
        Self { object: strike.object.clone(), seed: strike.seed, hit }
    }
}

impl EngineResult for AimResult {
    fn counts(&self) -> SectionCounts {
        SectionCounts::default()
    }

    fn write(&self, sections: &mut SectionsMut<'_>, _observer: &dyn StageObserver) -> Result<(), Error> {
        let mut summary = SummaryWire { fracture_degree: 1, seed: self.seed, hit: self.hit, ..SummaryWire::zeroed() };
        summary.set_object(&self.object);
        *sections.summary = summary;
        Ok(())
    }
}
