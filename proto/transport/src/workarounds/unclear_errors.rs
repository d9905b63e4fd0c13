//! A failure does not say which limit of the process was reached.
//!
//! **Symptom.** With few file descriptors (`ulimit -n`) or little address space (`ulimit -v`) calls fail with errors that name neither.
//! If a response cannot be mapped, the client sees the same as for a daemon that went away.
//!
//! **Reproduction** (iceoryx2 0.10.0). `ulimit -n 40` or `ulimit -v 300000` before a client connects.
//!
//! **Upstream.** No issue known.
//!
//! **Delete.** This file and its calls, once errors carry the system's reason.

use rustix::process::{Resource, getrlimit};
use shatter_proto::{Error, ErrorKind};

/// If a process may open fewer files, errors of the transport report the limit.
const FILES_FEW: u64 = 256;

/// Suffix for an error of the transport if the process may open few files; empty otherwise.
pub fn hint() -> String {
    match getrlimit(Resource::Nofile).current {
        Some(files) if files < FILES_FEW => format!(" (this process may open only {files} files)"),
        _ => String::new(),
    }
}

/// `lost`, or a `shared_memory` error where the daemon lives and this process may map little memory: the transport then reports the
/// same as for a daemon that went away.
pub fn explain_lost(lost: Error, daemon_lives: impl FnOnce() -> bool) -> Error {
    match getrlimit(Resource::As).current {
        Some(bytes) if lost.kind == ErrorKind::Lost && daemon_lives() => {
            let message = format!(
                "the daemon lives but was not reached: this process may map only {} MB (ulimit -v), probably too little for the daemon's shared memory; raise that limit",
                bytes / 1_000_000
            );
            Error::new(ErrorKind::SharedMemory, "ulimit -v", message)
        }
        _ => lost,
    }
}
