//! An object of the service.

use crate::session::Session;
use crate::{Impact, ObjectFacts, Ticket};
use shatter_proto::Error;
use shatter_proto::convention::Convention;
use std::sync::Arc;

/// An object that can be struck. Cheap to clone.
#[derive(Clone)]
pub struct Object {
    session: Arc<Session>,
    convention: Convention,
    facts: Arc<ObjectFacts>,
}

impl Object {
    pub(crate) fn new(session: Arc<Session>, convention: Convention, facts: ObjectFacts) -> Self {
        Self { session, convention, facts: Arc::new(facts) }
    }

    /// The coordinates of its requests and results.
    pub(crate) fn convention(&self) -> Convention {
        self.convention
    }

    /// Facts that the service reports about it: in meters and along the axes of the mesh file, whatever the convention.
    pub fn facts(&self) -> &ObjectFacts {
        &self.facts
    }

    /// Sends a request. Never waits: the ticket fetches the result. The first request after the daemon was lost connects
    /// to its successor, which takes some milliseconds.
    ///
    /// # Errors
    /// Every error that the daemon would find in the request's own fields, found before it is sent; `busy` if the
    /// connection has too many requests under way; `lost` if it reached no daemon, `no_daemon` while there is none.
    pub fn strike(&self, impact: &Impact) -> Result<Ticket, Error> {
        let request = impact.request(&self.facts.name, self.convention);
        self.session.call(|connection| Ticket::send(connection, &request))
    }
}
