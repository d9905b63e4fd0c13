//! An object of the service.

use crate::line::Line;
use crate::{Impact, ObjectFacts, Ticket};
use shatter_proto::Refusal;
use std::sync::Arc;

/// An object that can be struck. Cheap to clone.
#[derive(Clone)]
pub struct Object {
    line: Arc<Line>,
    facts: Arc<ObjectFacts>,
}

impl Object {
    pub(crate) fn new(line: Arc<Line>, facts: ObjectFacts) -> Self {
        Self { line, facts: Arc::new(facts) }
    }

    /// What the service says about it.
    pub fn facts(&self) -> &ObjectFacts {
        &self.facts
    }

    /// Sends a strike. Never waits: the answer is fetched from the ticket. The first strike after the daemon was lost connects
    /// to its successor, which takes some milliseconds.
    ///
    /// Errors: whatever the daemon would refuse in the request's own fields, found before it is sent; `busy` if the
    /// connection has too many strikes under way; `lost` if it reached no daemon, `no_daemon` while there is none.
    pub fn strike(&self, impact: &Impact) -> Result<Ticket, Refusal> {
        let strike = impact.strike(&self.facts.name);
        self.line.over(|link| Ticket::send(link, &strike))
    }
}
