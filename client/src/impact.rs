//! What strikes an object, put together step by step.

use crate::Ray;
use shatter_export::contact::MergedContact;
use shatter_proto::convention::Convention;
use shatter_proto::effect::{Effect, Effects};
use shatter_proto::request::{
    Contact, DegreeRule, DisplacementSource, Lift, Purpose, Quality, Request, RetainedFragment,
};
use std::time::Duration;

/// One impact: contacts, and how the answer shall be computed. Lengths in m and directions in the coordinates of the mesh
/// file, +Y up; over a connection with another convention ([`Client::with_convention`](crate::Client::with_convention)) in its
/// unit and along its axes. Nothing is checked here; the service names what it refuses.
#[derive(Clone, Debug, PartialEq)]
#[must_use = "an impact does nothing until it strikes an object"]
pub struct Impact(Request);

impl Impact {
    /// An impact of these contacts, of which the service takes 1 to 8.
    pub fn new(contacts: impl IntoIterator<Item = Contact>) -> Self {
        Self(Request { contacts: contacts.into_iter().collect(), ..Request::default() })
    }

    /// The contacts that a simulator told of, in their order; `None` of none. How the answer shall be computed is the caller's to add.
    pub fn of(contacts: &[MergedContact]) -> Option<Self> {
        let contact = |merged: &MergedContact| {
            let contact = Contact::new(merged.point_m).impulse(merged.impulse_ns);
            contact.duration(merged.hertz.duration_s).radius(merged.hertz.radius_m)
        };
        (!contacts.is_empty()).then(|| Self::new(contacts.iter().map(contact)))
    }

    /// Asks where `ray` first meets the object, without an impact.
    pub fn aim(ray: Ray) -> Self {
        let mut impact = Self::new([ray.into()]);
        impact.0.purpose = Purpose::Aim;
        impact
    }

    /// Where the number of sites comes from; by default the preset says.
    pub fn degree(mut self, degree: DegreeRule) -> Self {
        self.0.degree = degree;
        self
    }

    /// γ, J·m², instead of the object's own.
    pub fn gamma(mut self, gamma_j_m2: f64) -> Self {
        self.0.gamma_j_m2 = Some(gamma_j_m2);
        self
    }

    /// Which lift, instead of the object's own.
    pub fn lift(mut self, lift: Lift) -> Self {
        self.0.lift = Some(lift);
        self
    }

    /// Where displacements come from; by default the preset says.
    pub fn elastic(mut self, elastic: DisplacementSource) -> Self {
        self.0.elastic = elastic;
        self
    }

    /// Which preset says what nothing else says; by default the object's.
    pub fn quality(mut self, quality: Quality) -> Self {
        self.0.quality = Some(quality);
        self
    }

    /// Largest estimated relative error, of the elastic energy and of how the pieces are centered: both are computed until it is met.
    pub fn error(mut self, error_max: f64) -> Self {
        self.0.error_max = Some(error_max);
        self
    }

    /// How long the service may take from when it takes the strike in until it sends the answer, ms: quality falls where that is short,
    /// and the answer says what stopped it.
    pub fn time_ms(mut self, time_ms_max: f64) -> Self {
        self.0.time_ms_max = Some(time_ms_max);
        self
    }

    /// Iterations at most by which the pieces are centered, instead of the preset's.
    pub fn iterations(mut self, iterations_max: u32) -> Self {
        self.0.iterations_max = Some(iterations_max);
        self
    }

    /// Switches an effect on.
    pub fn enable(mut self, effect: Effect) -> Self {
        self.0.enable = Effects::of(self.0.enable.iter().chain([effect]));
        self
    }

    /// Switches an effect off.
    pub fn disable(mut self, effect: Effect) -> Self {
        self.0.disable = Effects::of(self.0.disable.iter().chain([effect]));
        self
    }

    /// Everything random follows from it; 0 by default.
    pub fn seed(mut self, seed: u64) -> Self {
        self.0.seed = seed;
        self
    }

    /// Refuse an answer of more fragments.
    pub fn fragments_max(mut self, count: u32) -> Self {
        self.0.fragments_max = Some(count);
        self
    }

    /// Refuse an answer of more bytes.
    pub fn bytes_max(mut self, bytes: u64) -> Self {
        self.0.bytes_max = Some(bytes);
        self
    }

    /// How long after the daemon took it in the answer is still of use. Strikes with less time left go first; one that cannot be
    /// in time is refused at once, one that is not costs no more work: both with `late`.
    pub fn deadline(mut self, time: Duration) -> Self {
        self.0.deadline = Some(time);
        self
    }

    /// Asks the service to keep the answer for a while, so that its fragments can be struck: see
    /// [`FractureResult::handle`](crate::FractureResult::handle).
    pub fn keep(mut self) -> Self {
        self.0.keep = true;
        self
    }

    /// Strikes fragment `fragment` of the answer that is kept under `handle`, instead of the object.
    pub fn from(mut self, handle: u64, fragment: u32) -> Self {
        self.0.from = Some(RetainedFragment { handle, fragment });
        self
    }

    /// Asks for the load that just breaks the object, without fragments.
    pub fn threshold_only(mut self) -> Self {
        self.0.purpose = Purpose::Threshold;
        self
    }

    /// The strike of `object` in `convention`.
    pub(crate) fn strike(&self, object: &str, convention: Convention) -> Request {
        Request { object: object.to_owned(), convention, ..self.0.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shatter_export::contact::{ContactBody, ContactCollector, ContactEvent, ContactPolicy, ElasticMaterial};

    #[test]
    fn contacts_become_an_impact() {
        assert_eq!(Impact::of(&[]), None);
        let vase =
            ContactBody { material: ElasticMaterial { young_pa: 70e9, poisson: 0.2 }, mass_kg: 1.2, radius_m: 0.08 };
        let other = ContactBody { material: ElasticMaterial::STEEL, mass_kg: 0.033, radius_m: 0.01 };
        let mut contacts = ContactCollector::default();
        contacts.watch("vase", ContactPolicy::new(vase));
        for (point_m, impulse_ns) in [([1.0, 2.0, 3.0], [1.0, 0.0, 0.0]), ([9.0; 3], [0.0, 0.5, 0.0])] {
            contacts.touch(&"vase", ContactEvent { point_m, impulse_ns, speed_m_s: 3.0, other });
        }
        let (_, found) = contacts.step(0.0).remove(0);
        let found = found.unwrap();
        let strike = Impact::of(&found).unwrap().strike("vase", Convention::GLTF);
        assert_eq!(strike.contacts.len(), 2);
        assert_eq!((strike.contacts[0].point_m, strike.contacts[1].impulse_ns), ([1.0, 2.0, 3.0], [0.0, 0.5, 0.0]));
        let durations = strike.contacts.iter().map(|contact| contact.duration_s);
        assert!(durations.eq(found.iter().map(|blow| Some(blow.hertz.duration_s))));
        assert!(strike.contacts.iter().all(|contact| contact.radius_m.is_some()));
    }
}
