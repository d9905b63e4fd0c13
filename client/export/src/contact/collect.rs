//! Collection of all contacts of a step, by body.

use super::merge::{ContactGroup, merged};
use super::{CONTACTS_MAX, ContactBody, ContactEvent, ImpulseLost, MergedContact};
use std::collections::BTreeMap;

/// Largest number of separate contacts of a body per step before merging; beyond it, the weakest joins the nearest.
const TOUCHES_MAX: usize = 16 * CONTACTS_MAX;

/// Rules by which contacts of a body become an impact.
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use = "a policy does nothing until a collector watches a body by it"]
pub struct ContactPolicy {
    own: ContactBody,
    merge_m: f64,
    impulse_min_ns: f64,
    speed_min_m_s: f64,
    cooldown_s: f64,
}

impl ContactPolicy {
    /// Rules for a body with the defaults: contacts faster than 0.1 m/s count, contacts nearer than a tenth of its radius merge, and there
    /// is no cooldown.
    pub fn new(own: ContactBody) -> Self {
        let merge_m = if own.radius_m.is_finite() { 0.1 * own.radius_m.abs() } else { 0.0 };
        Self { own, merge_m, impulse_min_ns: 0.0, speed_min_m_s: 0.1, cooldown_s: 0.0 }
    }

    /// Radius of the body's surface, m; negative if it is concave.
    pub fn radius(self, radius_m: f64) -> Self {
        Self { own: ContactBody { radius_m, ..self.own }, ..self }
    }

    /// Distance below which contacts merge, m.
    pub fn merge(self, merge_m: f64) -> Self {
        Self { merge_m, ..self }
    }

    /// Smallest impulse of a step, N·s: weaker steps (sum of the magnitudes) make no impact. The impulse that just breaks an object comes
    /// from `shatter threshold`, or from an impact of the client with `threshold_only`. Half of it at the weakest point leaves out most
    /// impacts that break nothing, before they cost a message.
    pub fn impulse_min(self, impulse_min_ns: f64) -> Self {
        Self { impulse_min_ns, ..self }
    }

    /// Smallest approach speed of a contact, m/s. Slower ones are those of bodies at rest, whose impulses carry weight.
    pub fn speed_min(self, speed_min_m_s: f64) -> Self {
        Self { speed_min_m_s, ..self }
    }

    /// Time after an impact in which no other follows, s.
    pub fn cooldown(self, cooldown_s: f64) -> Self {
        Self { cooldown_s, ..self }
    }

    /// The struck body, as a partner of a contact.
    pub fn own(&self) -> ContactBody {
        self.own
    }
}

/// Contacts of the current step, and the time of each body's last impact. `K` is the host's name for a body.
#[derive(Clone)]
pub struct ContactCollector<K> {
    bodies: BTreeMap<K, Body>,
}

#[derive(Clone)]
struct Body {
    terms: ContactPolicy,
    groups: Vec<ContactGroup>,
    /// Time of the step of its last impact, s.
    struck_s: Option<f64>,
}

impl<K> Default for ContactCollector<K> {
    fn default() -> Self {
        Self { bodies: BTreeMap::new() }
    }
}

impl<K: Ord + Clone> ContactCollector<K> {
    /// Watches `body`: its contacts become impacts by these rules from now on. A body that is watched already gets the new rules, and its
    /// cooldown goes on.
    pub fn watch(&mut self, body: K, terms: ContactPolicy) {
        let new = Body { terms, groups: Vec::new(), struck_s: None };
        self.bodies.entry(body).or_insert(new).terms = terms;
    }

    /// Stops watching `body`, which was removed or shall not break.
    pub fn forget(&mut self, body: &K) {
        self.bodies.remove(body);
    }

    /// Rules of `body`, if it is watched.
    pub fn terms(&self, body: &K) -> Option<&ContactPolicy> {
        self.bodies.get(body).map(|body| &body.terms)
    }

    /// Adds a contact of the current step. Ignores bodies that are not watched, and contacts that are too slow, have no impulse, or have a
    /// number that is not finite.
    pub fn touch(&mut self, body: &K, touch: ContactEvent) {
        let Some(body) = self.bodies.get_mut(body) else { return };
        let Some(group) = ContactGroup::of(&touch).filter(|_| touch.speed_m_s >= body.terms.speed_min_m_s) else {
            return;
        };
        body.groups.push(group);
        if body.groups.len() > TOUCHES_MAX {
            body.join_weakest();
        }
    }

    /// Ends the step at `now_s` (simulation time, s), and returns the impacts in the order of the bodies. A body has at most as many
    /// contacts as a request takes, the strongest first. A body whose contacts would lose more than half of their impulse, such as one that
    /// lands flat, comes with an [`ImpulseLost`] instead, and has no cooldown.
    ///
    /// # Errors
    /// Per body: [`ImpulseLost`] if merging lost part of an impulse.
    pub fn step(&mut self, now_s: f64) -> Vec<(K, Result<Vec<MergedContact>, ImpulseLost>)> {
        self.bodies.iter_mut().filter_map(|(name, body)| Some((name.clone(), body.step(now_s)?))).collect()
    }
}

impl Body {
    /// Merges the weakest contact with the nearest to it, so that none of its impulse is lost.
    fn join_weakest(&mut self) {
        self.groups.sort_by(|a, b| b.weight().total_cmp(&a.weight()));
        let Some(weakest) = self.groups.pop() else { return };
        let nearest = self.groups.iter_mut().min_by(|a, b| a.distance(&weakest).total_cmp(&b.distance(&weakest)));
        match nearest {
            Some(nearest) => *nearest = nearest.with(&weakest),
            None => self.groups.push(weakest),
        }
    }

    fn step(&mut self, now_s: f64) -> Option<Result<Vec<MergedContact>, ImpulseLost>> {
        let groups = std::mem::take(&mut self.groups);
        let impulse_ns: f64 = groups.iter().map(ContactGroup::weight).sum();
        // A simulation that was set back does not wait for its former time.
        let cooling = |struck_s: f64| (0.0..self.terms.cooldown_s).contains(&(now_s - struck_s));
        if groups.is_empty() || impulse_ns < self.terms.impulse_min_ns || self.struck_s.is_some_and(cooling) {
            return None;
        }
        let merged_contacts = merged(groups, &self.terms.own, self.terms.merge_m);
        if merged_contacts.is_ok() {
            self.struck_s = Some(now_s);
        }
        Some(merged_contacts)
    }
}
