//! An object of the service.

use crate::link::Link;
use crate::{Impact, ObjectFacts, Ticket};
use shatter_proto::Refusal;
use std::sync::Arc;

/// An object that can be struck. Cheap to clone.
#[derive(Clone)]
pub struct Object {
    link: Arc<Link>,
    facts: Arc<ObjectFacts>,
}

impl Object {
    pub(crate) fn new(link: Arc<Link>, facts: ObjectFacts) -> Self {
        Self { link, facts: Arc::new(facts) }
    }

    /// What the service says about it.
    pub fn facts(&self) -> &ObjectFacts {
        &self.facts
    }

    /// Sends a strike. Never blocks: the answer is fetched from the ticket.
    ///
    /// Errors: whatever the daemon would refuse in the request's own fields, found before it is sent; `busy` if the
    /// connection has too many strikes under way.
    pub fn strike(&self, impact: &Impact) -> Result<Ticket, Refusal> {
        Ticket::send(self.link.clone(), &impact.strike(&self.facts.name))
    }
}
