//! A failure does not say which limit of the process was reached.
//!
//! **Symptom.** With few file descriptors (`ulimit -n`), little address space (`ulimit -v`) or small files (`ulimit -f`), calls fail with
//! errors that name none of them.
//! If a response cannot be mapped, the client sees the same as for a daemon that went away.
//!
//! **Reproduction** (iceoryx2 0.10.0). `ulimit -n 40`, `ulimit -v 300000` or `ulimit -f 100` before a client connects.
//!
//! **Upstream.** No issue known.
//!
//! **Delete.** This file and its calls, once errors carry the system's reason.

use rustix::process::{Resource, getrlimit};
use shatter_proto::{Error, ErrorKind};

/// If a process may open fewer files, errors of the transport report the limit.
const FILES_FEW: u64 = 256;

/// If a process may write only smaller files, bytes, errors of the transport report the limit: segments count as files.
const FILE_SMALL: u64 = 1 << 30;

/// Suffix for an error of the transport if the process may open few files or write only small ones; empty otherwise.
pub fn hint() -> String {
    let limit = |resource, usual| getrlimit(resource).current.filter(|limit| *limit < usual);
    let files = limit(Resource::Nofile, FILES_FEW);
    let bytes = limit(Resource::Fsize, FILE_SMALL);
    let files = files.map(|files| format!(" (this process may open only {files} files: ulimit -n)"));
    let bytes = bytes.map(|bytes| format!(" (this process may write only {bytes} bytes to a file: ulimit -f)"));
    [files, bytes].into_iter().flatten().collect()
}

/// A `shared_memory` error, if a limit of this process can be why it did not reach a daemon; otherwise the error as it is.
///
/// # Errors
/// `error`, if no limit is low.
pub fn explain_unreached(error: Error) -> Result<Error, Error> {
    let limits = hint();
    if limits.is_empty() {
        return Err(error);
    }
    let message = format!("the daemon lives but was not reached; raise the limit of this process: {error}");
    Ok(Error::new(ErrorKind::SharedMemory, "ulimit", message))
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
