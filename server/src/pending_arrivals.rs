//! Strikes and questions travel by separate services, so a question can overtake a strike that its client sent before. Sequences put
//! them in order again: a question names the strike that it follows, and is held back until that strike has arrived.

use crate::ipc::ActiveControlRequest;
use shatter_proto::control::ControlRequest;
use std::collections::{HashMap, HashSet, VecDeque};
use std::time::{Duration, Instant};

/// What names a client.
pub type ListenerId = [u8; 16];

/// A question that waits longer for a strike is answered without it: its client names one that it never sent.
const PATIENCE: Duration = Duration::from_secs(5);

/// Questions held back at most; one more is answered at once.
const HELD_MAX: usize = 1024;

/// The strikes that have arrived, by their clients, and questions that wait for others.
#[derive(Default)]
pub struct PendingArrivals {
    last: HashMap<ListenerId, u64>,
    early: VecDeque<EarlyControlRequest>,
}

/// A question that overtook a strike.
struct EarlyControlRequest {
    active: ActiveControlRequest,
    listener: ListenerId,
    question: ControlRequest,
    since: Instant,
}

impl PendingArrivals {
    /// The strike `sequence` of this client has arrived. Those of one client arrive in the order in which they were sent.
    pub fn note(&mut self, listener: ListenerId, sequence: u64) {
        let last = self.last.entry(listener).or_default();
        *last = sequence.max(*last);
    }

    /// Whether the strikes have arrived that `question` comes after.
    pub fn precede(&self, listener: ListenerId, question: ControlRequest) -> bool {
        question.after() <= self.last.get(&listener).copied().unwrap_or(0)
    }

    /// Holds a question back; gives it back if too many are held.
    pub fn hold(
        &mut self,
        active: ActiveControlRequest,
        listener: ListenerId,
        question: ControlRequest,
    ) -> Option<ActiveControlRequest> {
        if self.early.len() >= HELD_MAX {
            return Some(active);
        }
        self.early.push_back(EarlyControlRequest { active, listener, question, since: Instant::now() });
        None
    }

    /// Whether any question is held back.
    pub fn holds_any(&self) -> bool {
        !self.early.is_empty()
    }

    /// The questions whose strikes have arrived by now, or never will, in the order in which they came.
    pub fn due(&mut self) -> Vec<ActiveControlRequest> {
        let (mut due, mut early) = (Vec::new(), VecDeque::new());
        for held in std::mem::take(&mut self.early) {
            if held.since.elapsed() > PATIENCE || self.precede(held.listener, held.question) {
                due.push(held.active);
            } else {
                early.push_back(held);
            }
        }
        self.early = early;
        due
    }

    /// Forgets the clients that are gone.
    pub fn retain(&mut self, listeners: &HashSet<ListenerId>) {
        self.last.retain(|listener, _| listeners.contains(listener));
    }
}
