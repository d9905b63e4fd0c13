//! Ordering of control requests after impact requests.
//!
//! The two kinds travel through separate services, so a control request can overtake an earlier impact request. It names the impact request
//! that it follows by sequence number, and waits until that one has arrived.

use crate::ipc::ActiveControlRequest;
use shatter_proto::control::ControlRequest;
use std::collections::{HashMap, HashSet, VecDeque};
use std::time::{Duration, Instant};

/// Identifies a client.
pub type ListenerId = [u8; 16];

/// Longest wait of a control request; after it, the client is assumed never to have sent the named impact request.
const TIMEOUT: Duration = Duration::from_secs(5);

/// Maximum number of waiting control requests; further ones get their reply at once.
const HELD_MAX: usize = 1024;

/// Arrived impact requests by client, and control requests that wait for others.
#[derive(Default)]
pub struct PendingArrivals {
    last: HashMap<ListenerId, u64>,
    early: VecDeque<EarlyControlRequest>,
}

/// Control request that overtook an impact request.
struct EarlyControlRequest {
    active: ActiveControlRequest,
    listener: ListenerId,
    request: ControlRequest,
    since: Instant,
}

impl PendingArrivals {
    /// Records that impact request `sequence` of this client has arrived. Those of one client arrive in the order of sending.
    pub fn note(&mut self, listener: ListenerId, sequence: u64) {
        let last = self.last.entry(listener).or_default();
        *last = sequence.max(*last);
    }

    /// Whether the impact requests that `request` follows have arrived.
    pub fn follows_all_requests(&self, listener: ListenerId, request: ControlRequest) -> bool {
        request.after() <= self.last.get(&listener).copied().unwrap_or(0)
    }

    /// Holds a control request; returns it if too many are held.
    pub fn hold(
        &mut self,
        active: ActiveControlRequest,
        listener: ListenerId,
        request: ControlRequest,
    ) -> Option<ActiveControlRequest> {
        if self.early.len() >= HELD_MAX {
            return Some(active);
        }
        self.early.push_back(EarlyControlRequest { active, listener, request, since: Instant::now() });
        None
    }

    /// Whether any control request is held.
    pub fn is_waiting(&self) -> bool {
        !self.early.is_empty()
    }

    /// Control requests whose impact requests have arrived or never will, in order of arrival.
    pub fn due(&mut self) -> Vec<ActiveControlRequest> {
        let (mut due, mut early) = (Vec::new(), VecDeque::new());
        for held in std::mem::take(&mut self.early) {
            if held.since.elapsed() > TIMEOUT || self.follows_all_requests(held.listener, held.request) {
                due.push(held.active);
            } else {
                early.push_back(held);
            }
        }
        self.early = early;
        due
    }

    /// Drops the clients that are gone.
    pub fn retain(&mut self, listeners: &HashSet<ListenerId>) {
        self.last.retain(|listener, _| listeners.contains(listener));
    }
}
