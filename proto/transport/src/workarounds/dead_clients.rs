//! Two processes that clean up after dead ones race with each other.
//!
//! **Symptom.** Every process cleans up after dead nodes, on three occasions. If two do so at once, the slower one can remove the
//! registration of a process that has since taken the slot. A living client is then treated as dead. A process that cleans up can
//! also wait for a file that a dead process left unfinished. If it finds a node that is just starting, it aborts
//! (`InstanceStillAlive`).
//!
//! **Reproduction** (iceoryx2 0.10.0). Clients connect while others are killed, as in the tests `faults` and `reconnect` of
//! `shatter-server`.
//!
//! **Upstream.** The abort is issue 1880 (fix: pull request 1936, open). For the race no issue is known.
//!
//! **Delete.** [`never_clean_up`]; also [`is_evicted`], `Connection::evicted`, and the second attempt in `Session::call`
//! of `shatter-client`, once a living client is never treated as dead.

use iceoryx2::prelude::Config;
use shatter_proto::{Error, ErrorKind};

/// Leaves the cleanup to the daemon, which is one process and does it on one thread.
pub fn never_clean_up(config: &mut Config) {
    config.global.node.cleanup_dead_nodes_on_creation = false;
    config.global.node.cleanup_dead_nodes_on_destruction = false;
    config.global.service.cleanup_dead_nodes_on_open = false;
}

/// True if the transport took this client for a dead one.
///
/// `error` is the daemon's reason for closing a request that this client has not canceled: only the transport can then have caused it.
pub fn is_evicted(error: &Error) -> bool {
    error.kind == ErrorKind::Canceled
}
