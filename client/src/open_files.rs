//! A process that may map little memory: the transport fails there without saying why.

use crate::connection::Connection;
use rustix::process::{Resource, getrlimit};
use shatter_proto::{Error, ErrorKind};

/// `lost`, or what is wrong where the daemon lives and this process may map little memory: the transport then tells the same as of a
/// daemon that went away.
pub(crate) fn unmapped(lost: Error, link: &Connection) -> Error {
    let limit = getrlimit(Resource::As).current;
    match limit {
        Some(bytes) if lost.kind == ErrorKind::Lost && link.daemon_lives() => {
            let message = format!(
                "the daemon lives but was not reached: its shared memory can probably not be mapped, because this process may map only {} MB (ulimit -v); raise that limit",
                bytes / 1_000_000
            );
            Error::new(ErrorKind::SharedMemory, "ulimit -v", message)
        }
        _ => lost,
    }
}
