//! Questions for the list of objects, which wait for a look at the folder of databases.

use crate::ipc::ActiveControlRequest;
use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// A list waits no longer for a look: the folder may be on a disk that does not respond.
const WAIT_MAX: Duration = Duration::from_millis(100);

/// Questions held back at most; one more is answered at once.
const HELD_MAX: usize = 1024;

/// Lists that are answered once a look at the folder is over that began after they were asked for.
#[derive(Default)]
pub struct WaitingLists(VecDeque<WaitingList>);

struct WaitingList {
    active: ActiveControlRequest,
    look: u64,
    since: Instant,
}

impl WaitingLists {
    /// Holds a question back until the look of that number is over; gives it back if too many are held.
    pub fn hold(&mut self, active: ActiveControlRequest, look: u64) -> Option<ActiveControlRequest> {
        if self.0.len() >= HELD_MAX {
            return Some(active);
        }
        self.0.push_back(WaitingList { active, look, since: Instant::now() });
        None
    }

    /// The questions whose look is over, or takes too long, now that `done` looks are over. Their looks are in the order in which they came.
    pub fn due(&mut self, done: u64) -> Vec<ActiveControlRequest> {
        let is_due = |list: &&WaitingList| list.look <= done || list.since.elapsed() > WAIT_MAX;
        let count = self.0.iter().take_while(is_due).count();
        self.0.drain(..count).map(|list| list.active).collect()
    }
}
