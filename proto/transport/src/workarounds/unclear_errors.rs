//! A failure does not say which limit of the process was reached.
//!
//! **Symptom.** With few file descriptors (`ulimit -n`) or little address space (`ulimit -v`) calls fail with errors that name neither. Where
//! a response cannot be mapped, the client sees what it sees of a daemon that ended.
//!
//! **Reproduction** (iceoryx2 0.10.0). `ulimit -n 40` or `ulimit -v 300000` before a client connects.
//!
//! **Upstream.** No issue known.
//!
//! **Delete.** This file and its calls, once errors carry the reason of the system.

use rustix::process::{Resource, getrlimit};
use shatter_proto::{Error, ErrorKind};

/// A process that may open fewer files is told so when the transport fails.
const FILES_FEW: u64 = 256;

/// What an error of the transport does not say: that the process may open few files. Empty where it may open many.
pub fn hint() -> String {
    match getrlimit(Resource::Nofile).current {
        Some(files) if files < FILES_FEW => format!(" (this process may open only {files} files)"),
        _ => String::new(),
    }
}

/// `lost`, or the limit that was reached where the daemon lives and this process may map little memory.
pub fn unmapped(lost: Error, daemon_lives: impl FnOnce() -> bool) -> Error {
    match getrlimit(Resource::As).current {
        Some(bytes) if lost.kind == ErrorKind::Lost && daemon_lives() => {
            let message = format!(
                "the daemon lives but was not reached: its shared memory can probably not be mapped, because this process may map only {} MB (ulimit -v); raise that limit",
                bytes / 1_000_000
            );
            Error::new(ErrorKind::SharedMemory, "ulimit -v", message)
        }
        _ => lost,
    }
}
