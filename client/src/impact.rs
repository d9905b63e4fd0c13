//! An impact and its options, put together step by step.

use crate::Ray;
use shatter_export::contact::MergedContact;
use shatter_proto::convention::Convention;
use shatter_proto::effect::{Effect, Effects};
use shatter_proto::request::{
    Contact, DegreeRule, DisplacementSource, Lift, Purpose, Quality, Request, RequestedCriterion, RequestedSurface,
    RetainedFragment,
};
use std::time::Duration;

/// An impact: contacts, and how to compute the result. Lengths in m and directions in the coordinates of the mesh
/// file, +Y up; over a connection with another convention ([`Client::with_convention`](crate::Client::with_convention)) in its
/// unit and along its axes. [`Object::strike`](crate::Object::strike) checks the values.
#[derive(Clone, Debug, PartialEq)]
#[must_use = "an impact does nothing until it strikes an object"]
pub struct Impact(Request);

impl Impact {
    /// An impact of these contacts, of which the service takes 1 to 8.
    pub fn new(contacts: impl IntoIterator<Item = Contact>) -> Self {
        Self(Request { contacts: contacts.into_iter().collect(), ..Request::default() })
    }

    /// An impact of the contacts of a simulator, in their order; `None` without contacts. Options are the caller's to add.
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

    /// Sets the source of the number of sites; by default the preset says.
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

    /// Sets the source of displacements; by default the preset says.
    pub fn elastic(mut self, elastic: DisplacementSource) -> Self {
        self.0.elastic = elastic;
        self
    }

    /// Rule that decides whether the object breaks, instead of the object's own.
    pub fn criterion(mut self, criterion: RequestedCriterion) -> Self {
        self.0.criterion = Some(criterion);
        self
    }

    /// Outer surface of the fragments; by default the input's own, if the object has a mesh of it. The lattice's has fewer triangles, for a
    /// lower level of detail. The fragments of a fragment keep its surface.
    pub fn surface(mut self, surface: RequestedSurface) -> Self {
        self.0.surface = surface;
        self
    }

    /// Preset of all settings that the impact does not set; by default the object's.
    pub fn quality(mut self, quality: Quality) -> Self {
        self.0.quality = Some(quality);
        self
    }

    /// Largest estimated relative error of the elastic energy and of the diagram: both are refined until it is met.
    pub fn error(mut self, error_max: f64) -> Self {
        self.0.error_max = Some(error_max);
        self
    }

    /// Time from the admission of the request until its result is sent, ms: quality falls where that is short, and
    /// [`Summary::stop_criterion`](crate::Summary::stop_criterion) tells.
    pub fn time_ms(mut self, time_ms_max: f64) -> Self {
        self.0.time_ms_max = Some(time_ms_max);
        self
    }

    /// Iterations of the diagram at most, instead of the preset's.
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

    /// Seed of all random numbers; 0 by default.
    pub fn seed(mut self, seed: u64) -> Self {
        self.0.seed = seed;
        self
    }

    /// Largest number of fragments; the service refuses a result of more.
    pub fn fragments_max(mut self, count: u32) -> Self {
        self.0.fragments_max = Some(count);
        self
    }

    /// Largest size of the result, bytes; the service refuses a larger one.
    pub fn bytes_max(mut self, bytes: u64) -> Self {
        self.0.bytes_max = Some(bytes);
        self
    }

    /// Time after admission within which the result is of use. The service serves requests with less time left first. It refuses one
    /// that cannot be in time at once, and stops one that is not in time: both with `late`.
    pub fn deadline(mut self, time: Duration) -> Self {
        self.0.deadline = Some(time);
        self
    }

    /// Asks the service to keep the result for a while, so that its fragments can be struck: see
    /// [`FractureResult::handle`](crate::FractureResult::handle).
    pub fn keep(mut self) -> Self {
        self.0.keep = true;
        self
    }

    /// Strikes fragment `fragment` of the result that the service keeps under `handle`, instead of the object.
    pub fn from(mut self, handle: u64, fragment: u32) -> Self {
        self.0.from = Some(RetainedFragment { handle, fragment });
        self
    }

    /// Asks for the load that just breaks the object, without fragments.
    pub fn threshold_only(mut self) -> Self {
        self.0.purpose = Purpose::Threshold;
        self
    }

    /// The request for `object` in `convention`.
    pub(crate) fn request(&self, object: &str, convention: Convention) -> Request {
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
        let request = Impact::of(&found).unwrap().request("vase", Convention::GLTF);
        assert_eq!(request.contacts.len(), 2);
        assert_eq!((request.contacts[0].point_m, request.contacts[1].impulse_ns), ([1.0, 2.0, 3.0], [0.0, 0.5, 0.0]));
        let durations = request.contacts.iter().map(|contact| contact.duration_s);
        assert!(durations.eq(found.iter().map(|merged| Some(merged.hertz.duration_s))));
        assert!(request.contacts.iter().all(|contact| contact.radius_m.is_some()));
    }
}
