//! Rays of strikes: where they meet the object, and the result of a strike that only aims.

use super::refusal_in;
use crate::object::Outcome;
use bytemuck::Zeroable;
use nalgebra::Vector3;
use shatter_fracture::pipeline::{Hit, Ray, StrikeError, Watch};
use shatter_proto::Refusal;
use shatter_proto::answer::{HitWire, SummaryWire};
use shatter_proto::convention::Convention;
use shatter_proto::layout::{Counts, Sections};
use shatter_proto::request::{Contact, Strike, squarable};

/// Where the ray of `strike` first meets what it strikes; nothing without a ray.
pub(super) fn first_hit(
    strike: &Strike,
    aim: impl FnOnce(&Ray) -> Result<Hit, StrikeError>,
) -> Result<HitWire, Refusal> {
    let convention = &strike.convention;
    match strike.contacts.first().and_then(|contact| ray(contact, convention)) {
        None => Ok(HitWire::zeroed()),
        Some(ray) => aim(&ray).map(|hit| written(&hit, convention)).map_err(|error| refusal_in(error, convention)),
    }
}

/// `strike` at the point that its ray hit.
pub(super) fn pointed(strike: &Strike, hit: &HitWire) -> Strike {
    let mut strike = strike.clone();
    if let Some(contact) = strike.contacts.first_mut().filter(|_| hit.present != 0) {
        (contact.point_m, contact.ray) = (hit.point_m, None);
    }
    strike
}

fn ray(contact: &Contact, from: &Convention) -> Option<Ray> {
    let direction = Vector3::from(from.our_direction(squarable(contact.ray?)));
    Some(Ray { origin_m: from.our_vector(contact.point_m).into(), direction })
}

fn written(hit: &Hit, to: &Convention) -> HitWire {
    HitWire {
        point_m: to.vector(hit.point_m.coords.into()),
        normal: to.direction(hit.normal.into()),
        distance_m: to.length(hit.distance_m),
        body: hit.body as u32,
        present: 1,
    }
}

/// The result of a strike that only aims.
pub(super) struct Aimed {
    object: String,
    seed: u64,
    hit: HitWire,
}

impl Aimed {
    /// Of `strike`, whose ray hit there.
    pub fn new(strike: &Strike, hit: HitWire) -> Self {
        Self { object: strike.object.clone(), seed: strike.seed, hit }
    }
}

impl Outcome for Aimed {
    fn counts(&self) -> Counts {
        Counts::default()
    }

    fn write(&self, sections: &mut Sections<'_>, _watch: &mut dyn Watch) -> Result<(), Refusal> {
        let mut summary = SummaryWire { fracture_degree: 1, seed: self.seed, hit: self.hit, ..SummaryWire::zeroed() };
        summary.set_object(&self.object);
        *sections.summary = summary;
        Ok(())
    }
}
