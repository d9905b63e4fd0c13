//! List requests that wait for a scan of the database folder.

use crate::ipc::ActiveControlRequest;
use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// Longest wait of a list request; the folder may be on a disk that does not respond.
const WAIT_MAX: Duration = Duration::from_millis(100);

/// Maximum number of waiting list requests; further ones get their reply at once.
const HELD_MAX: usize = 1024;

/// List requests, each of which gets its reply when a scan that began after its arrival is over.
#[derive(Default)]
pub struct PendingListRequests(VecDeque<WaitingList>);

struct WaitingList {
    active: ActiveControlRequest,
    scan: u64,
    since: Instant,
}

impl PendingListRequests {
    /// Holds a request until scan number `scan` is over; returns it if too many are held.
    pub fn hold(&mut self, active: ActiveControlRequest, scan: u64) -> Option<ActiveControlRequest> {
        if self.0.len() >= HELD_MAX {
            return Some(active);
        }
        self.0.push_back(WaitingList { active, scan, since: Instant::now() });
        None
    }

    /// Requests whose scan is over or takes too long, after `done` scans, in order of arrival.
    pub fn due(&mut self, done: u64) -> Vec<ActiveControlRequest> {
        let is_due = |list: &&WaitingList| list.scan <= done || list.since.elapsed() > WAIT_MAX;
        let count = self.0.iter().take_while(is_due).count();
        self.0.drain(..count).map(|list| list.active).collect()
    }
}
