//! An object of the service.

use crate::session::Session;
use crate::{Impact, ObjectFacts, Ticket};
use shatter_proto::Error;
use shatter_proto::convention::Convention;
use std::sync::Arc;

/// An object that can be struck. Cheap to clone.
#[derive(Clone)]
pub struct Object {
    line: Arc<Session>,
    convention: Convention,
    facts: Arc<ObjectFacts>,
}

impl Object {
    pub(crate) fn new(line: Arc<Session>, convention: Convention, facts: ObjectFacts) -> Self {
        Self { line, convention, facts: Arc::new(facts) }
    }

    /// In whose coordinates it is struck and answered.
    pub(crate) fn convention(&self) -> Convention {
        self.convention
    }

    /// What the service says about it: in meters and along the axes of the mesh file, whatever the convention.
    pub fn facts(&self) -> &ObjectFacts {
        &self.facts
    }

    /// Sends a strike. Never waits: the answer is fetched from the ticket. The first strike after the daemon was lost connects
    /// to its successor, which takes some milliseconds.
    ///
    /// # Errors
    /// Whatever the daemon would refuse in the request's own fields, found before it is sent; `busy` if the
    /// connection has too many strikes under way; `lost` if it reached no daemon, `no_daemon` while there is none.
    pub fn strike(&self, impact: &Impact) -> Result<Ticket, Error> {
        let strike = impact.strike(&self.facts.name, self.convention);
        self.line.over(|link| Ticket::send(link, &strike))
    }
}
