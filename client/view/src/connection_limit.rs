//! A bounded number of open connections.

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use tokio::task::JoinHandle;

/// Maximum number of open connections: a browser opens at most six, and each holds a descriptor.
pub(crate) const CONNECTIONS_MAX: usize = 32;

/// An open connection.
struct OpenConnection {
    task: JoinHandle<()>,
    is_trusted: Arc<AtomicBool>,
}

/// Open connections, the oldest first. Dropping them closes all.
#[derive(Default)]
pub(crate) struct OpenConnections(VecDeque<OpenConnection>);

impl OpenConnections {
    /// Makes space for one more: closes the oldest connection that has not presented the cookie. False if all have.
    pub fn free_slot(&mut self) -> bool {
        self.0.retain(|connection| !connection.task.is_finished());
        if self.0.len() < CONNECTIONS_MAX {
            return true;
        }
        let idle = self.0.iter().position(|connection| !connection.is_trusted.load(Ordering::Relaxed));
        let Some(closed) = idle.and_then(|idle| self.0.remove(idle)) else { return false };
        closed.task.abort();
        true
    }

    /// Adds a connection; `is_trusted` is set once it has presented the cookie.
    pub fn add(&mut self, task: JoinHandle<()>, is_trusted: Arc<AtomicBool>) {
        self.0.push_back(OpenConnection { task, is_trusted });
    }
}

impl Drop for OpenConnections {
    fn drop(&mut self) {
        self.0.iter().for_each(|connection| connection.task.abort());
    }
}
