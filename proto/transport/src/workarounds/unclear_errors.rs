//! A failure does not say which limit of the process was reached.
//!
//! **Symptom.** With few file descriptors (`ulimit -n`), little address space (`ulimit -v`) or small files (`ulimit -f`), calls fail with
//! errors that name none of them. With few data (`ulimit -d`), a client ends with SIGSEGV.
//! If a response cannot be mapped, the client sees the same as for a daemon that went away.
//!
//! **Reproduction** (iceoryx2 0.10.0). `ulimit -n 40`, `ulimit -v 300000`, `ulimit -f 100` or `ulimit -d 1000` before a client connects.
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

/// Least memory of a process that connects, bytes: what the client and its host allocate.
const CLIENT_MEMORY: u64 = 16 << 20;

/// Refuses a connection of a process whose limit of data segments is too low: the transport does not check its allocations there, and
/// the process would end with SIGSEGV.
///
/// # Errors
/// `shared_memory`.
pub fn need_memory() -> Result<(), Error> {
    match getrlimit(Resource::Data).current.filter(|limit| *limit < CLIENT_MEMORY) {
        None => Ok(()),
        Some(limit) => {
            let message = format!(
                "this process may allocate only {} kB (ulimit -d), a connection needs {} kB; raise that limit",
                limit / 1024,
                CLIENT_MEMORY / 1024
            );
            Err(Error::new(ErrorKind::SharedMemory, "ulimit -d", message))
        }
    }
}

/// Suffix for an error of the transport if the process may open few files, write only small ones or map only some memory; empty otherwise.
pub fn hint() -> String {
    let limit = |resource, usual| getrlimit(resource).current.filter(|limit| *limit < usual);
    let files = limit(Resource::Nofile, FILES_FEW);
    let bytes = limit(Resource::Fsize, FILE_SMALL);
    let files = files.map(|files| format!(" (this process may open only {files} files: ulimit -n)"));
    let bytes = bytes.map(|bytes| format!(" (this process may write only {bytes} bytes to a file: ulimit -f)"));
    let mapped = getrlimit(Resource::As).current;
    let mapped = mapped.map(|bytes| format!(" (this process may map only {} MB: ulimit -v)", bytes / 1_000_000));
    [files, bytes, mapped].into_iter().flatten().collect()
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
