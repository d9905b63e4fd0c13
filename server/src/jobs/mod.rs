//! Strikes on their way: a bounded queue, a few that compute, and the bookkeeping between the thread that waits and the
//! threads that compute.

mod crew;
mod flight;

pub use crew::{Crew, Event, threads};
pub use flight::Flight;

use crate::catalog::Catalog;
use crate::ipc::ActiveStrike;
use crate::metrics::End;
use shatter_proto::{Kind, Refusal};
use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Instant;

/// Strikes that wait and strikes that compute. Owned by the waiting thread.
pub struct Jobs {
    waiting: VecDeque<Arc<Flight>>,
    running: Vec<Arc<Flight>>,
    at_once: usize,
    queue_max: usize,
    crew: Arc<Crew>,
}

impl Jobs {
    /// No strike yet. At most `at_once` compute, at most `queue_max` wait.
    pub fn new(at_once: usize, queue_max: usize, crew: Arc<Crew>) -> Self {
        Self { waiting: VecDeque::new(), running: Vec::new(), at_once, queue_max, crew }
    }

    /// Strikes that compute.
    pub fn running(&self) -> usize {
        self.running.len()
    }

    /// Strikes that wait.
    pub fn queued(&self) -> usize {
        self.waiting.len()
    }

    /// Takes a strike in, or refuses it at once; the end in that case.
    pub fn admit(&mut self, active: ActiveStrike, catalog: &Catalog) -> Option<End> {
        // The one copy: the sender can still write to the original.
        let wire = *active.payload();
        let mut flight = Flight::new(active, wire.listener, wire.sequence);
        let placed = wire.validate().and_then(|strike| {
            let object = catalog.get(&strike.object)?;
            if self.waiting.len() >= self.queue_max {
                let message = format!("{} strikes wait already", self.waiting.len());
                return Err(Refusal::new(Kind::Busy, "queue", message));
            }
            Ok((strike, object))
        });
        match placed {
            Ok((strike, object)) => {
                flight.place(strike, object);
                self.waiting.push_back(Arc::new(flight));
                self.dispatch();
                None
            }
            Err(refusal) => {
                tracing::info!(kind = refusal.kind.name(), at = refusal.at, "refused");
                self.crew.refuse(&flight, &refusal);
                Some(End::of(&refusal))
            }
        }
    }

    /// Lets waiting strikes compute while there is room.
    fn dispatch(&mut self) {
        while self.running.len() < self.at_once {
            let Some(flight) = self.waiting.pop_front() else { return };
            self.running.push(flight.clone());
            self.crew.fly(flight);
        }
    }

    /// A strike has ended.
    pub fn landed(&mut self, flight: &Arc<Flight>) {
        self.running.retain(|other| !Arc::ptr_eq(other, flight));
        self.dispatch();
    }

    /// Cancels what nobody waits for any more; returns how many of the waiting were dropped.
    pub fn prune(&mut self) -> usize {
        for flight in &self.running {
            flight.cancel_if_abandoned();
        }
        let before = self.waiting.len();
        self.waiting.retain(|flight| !flight.cancel_if_abandoned());
        before - self.waiting.len()
    }

    /// Refuses everything that waits; what computes may finish. Returns how many were refused.
    pub fn stop(&mut self) -> usize {
        let refusal = Refusal::new(Kind::Stopping, "daemon", "the daemon is ending");
        let waiting = std::mem::take(&mut self.waiting);
        for flight in &waiting {
            self.crew.refuse(flight, &refusal);
        }
        waiting.len()
    }

    /// Asks what computes to stop at its next checkpoint.
    pub fn cancel(&self) {
        for flight in &self.running {
            flight.cancel();
        }
    }

    /// When the oldest strike that computes arrived.
    pub fn oldest(&self) -> Option<Instant> {
        self.running.iter().map(|flight| flight.arrived()).min()
    }
}
