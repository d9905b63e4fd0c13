//! Two processes that clean up after dead ones race.
//!
//! **Symptom.** Every process cleans up after dead nodes, on three occasions. Of two that do so at once, the slower one removes the
//! registration of a process that took over the slot since: a living client is taken for a dead one. A process that cleans up can
//! also wait for a file that a dead one left unfinished. If it finds a node that is just starting, it aborts (`InstanceStillAlive`).
//!
//! **Reproduction** (iceoryx2 0.10.0). Clients that connect while others are killed beside them; the tests `faults` and `forgotten` of
//! `shatter-server` do that.
//!
//! **Upstream.** The abort is issue 1880 (fix: pull request 1936, open). For the race no issue is known.
//!
//! **Delete.** [`never_clean_up`]; and [`is_evicted`] with `Connection::evicted` and the second call of `Session::call` of
//! `shatter-client`, once a living client is never taken for a dead one.

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
    error.kind == ErrorKind::Cancelled
}
