//! Processes that may map little memory: the transport fails there without saying why.

use crate::connection::Connection;
use rustix::process::{Resource, getrlimit};
use shatter_proto::{Error, ErrorKind};

/// `lost`, or a `shared_memory` error where the daemon lives and this process may map little memory: the transport then reports the
/// same as for a daemon that went away.
pub(crate) fn explain_lost(lost: Error, connection: &Connection) -> Error {
    match getrlimit(Resource::As).current {
        Some(bytes) if lost.kind == ErrorKind::Lost && connection.daemon_lives() => {
            let message = format!(
                "the daemon lives but was not reached: this process may map only {} MB (ulimit -v), probably too little for the daemon's shared memory; raise that limit",
                bytes / 1_000_000
            );
            Error::new(ErrorKind::SharedMemory, "ulimit -v", message)
        }
        _ => lost,
    }
}
