//! All contacts of a step, body by body.

use super::merge::{ContactGroup, merged};
use super::{CONTACTS_MAX, ContactBody, ContactEvent, ImpulseLost, MergedContact};
use std::collections::BTreeMap;

/// A body keeps at most this many contacts of a step apart before they are merged; beyond, the weakest joins the nearest.
const TOUCHES_MAX: usize = 16 * CONTACTS_MAX;

/// When contacts of a body become a strike.
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
    /// Of a body: every contact faster than 0.1 m/s is sent, those nearer than a tenth of its radius are one, and nothing cools down.
    pub fn new(own: ContactBody) -> Self {
        let merge_m = if own.radius_m.is_finite() { 0.1 * own.radius_m.abs() } else { 0.0 };
        Self { own, merge_m, impulse_min_ns: 0.0, speed_min_m_s: 0.1, cooldown_s: 0.0 }
    }

    /// Radius of its surface, m; negative for a hollow.
    pub fn radius(self, radius_m: f64) -> Self {
        Self { own: ContactBody { radius_m, ..self.own }, ..self }
    }

    /// Contacts nearer than this become one, m.
    pub fn merge(self, merge_m: f64) -> Self {
        Self { merge_m, ..self }
    }

    /// Steps whose impulses (sum of their sizes) are below this are not sent, N·s. What just breaks an object is what
    /// `shatter threshold` says, and an impact of the client with `threshold_only`: half of it at the weakest place leaves
    /// out most of what breaks nothing, before it costs a message.
    pub fn impulse_min(self, impulse_min_ns: f64) -> Self {
        Self { impulse_min_ns, ..self }
    }

    /// Contacts slower than this are none, m/s: those of bodies at rest, whose impulses carry weight.
    pub fn speed_min(self, speed_min_m_s: f64) -> Self {
        Self { speed_min_m_s, ..self }
    }

    /// After a strike no other follows for so long, s.
    pub fn cooldown(self, cooldown_s: f64) -> Self {
        Self { cooldown_s, ..self }
    }

    /// What is struck, as a partner of a contact.
    pub fn own(&self) -> ContactBody {
        self.own
    }
}

/// Contacts of the step under way, and when which body was struck last. `K` names bodies, as the host does.
#[derive(Clone)]
pub struct ContactCollector<K> {
    bodies: BTreeMap<K, Body>,
}

#[derive(Clone)]
struct Body {
    terms: ContactPolicy,
    groups: Vec<ContactGroup>,
    /// Time of the step that struck it last, s.
    struck_s: Option<f64>,
}

impl<K> Default for ContactCollector<K> {
    fn default() -> Self {
        Self { bodies: BTreeMap::new() }
    }
}

impl<K: Ord + Clone> ContactCollector<K> {
    /// From now on contacts of `body` become strikes on these terms. A body that is watched already gets new terms, and is cooling down
    /// as before.
    pub fn watch(&mut self, body: K, terms: ContactPolicy) {
        let new = Body { terms, groups: Vec::new(), struck_s: None };
        self.bodies.entry(body).or_insert(new).terms = terms;
    }

    /// `body` is no more, or shall not break.
    pub fn forget(&mut self, body: &K) {
        self.bodies.remove(body);
    }

    /// The terms of `body`, if it is watched.
    pub fn terms(&self, body: &K) -> Option<&ContactPolicy> {
        self.bodies.get(body).map(|body| &body.terms)
    }

    /// One contact of the step under way. Left out: bodies that are not watched, contacts that are too slow, without an impulse, or with
    /// a figure that is not finite.
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

    /// The step at `now_s` (the simulation's time, s) is over: who is struck how, in the order of the bodies; never more blows than a
    /// strike takes, none of them weaker than the ones after it. A body whose contacts would lose more than half of their impulse, one
    /// that lands flat for instance, comes with an [`ImpulseLost`] instead, and is not cooling down.
    ///
    /// # Errors
    /// Per object: [`ImpulseLost`] if merging lost part of an impulse.
    pub fn step(&mut self, now_s: f64) -> Vec<(K, Result<Vec<MergedContact>, ImpulseLost>)> {
        self.bodies.iter_mut().filter_map(|(name, body)| Some((name.clone(), body.step(now_s)?))).collect()
    }
}

impl Body {
    /// Makes one of the weakest contact and the nearest to it, so that none of its impulse is lost.
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
        // A simulation that was set back does not wait for the time it had.
        let cooling = |struck_s: f64| (0.0..self.terms.cooldown_s).contains(&(now_s - struck_s));
        if groups.is_empty() || impulse_ns < self.terms.impulse_min_ns || self.struck_s.is_some_and(cooling) {
            return None;
        }
        let blows = merged(groups, &self.terms.own, self.terms.merge_m);
        if blows.is_ok() {
            self.struck_s = Some(now_s);
        }
        Some(blows)
    }
}
