//! A server stays connected after it was killed.
//!
//! **Symptom.** `PendingResponse::is_connected` stays true, and sending to the killed server succeeds, until some process cleans up after
//! it. A pending response without a server counts as connected, too.
//!
//! **Reproduction** (iceoryx2 0.10.0). SIGKILL to the daemon while a client waits for a response.
//!
//! **Upstream.** No issue known; 1763, fixed in 0.10, concerns the state after the cleanup.
//!
//! **Delete.** The liveness checks of clients ([`DaemonLock`], [`LIVENESS_INTERVAL`]), once a client sees that a server died. The lock
//! itself stays: it also ensures that only one daemon serves a name.

use crate::instance::Instance;
use crate::paths::ServicePaths;
use crate::regular_file;
use rustix::fs::{FlockOperation, flock};
use std::fs::File;
use std::os::unix::fs::FileExt;
use std::time::Duration;

/// Time between two tests of the daemon's lock by a client that waits.
pub const LIVENESS_INTERVAL: Duration = Duration::from_millis(200);

/// The lock file of a daemon, as it was when it served.
pub struct DaemonLock {
    file: File,
    token: String,
}

impl DaemonLock {
    /// The lock file of the daemon at `paths` whose transport is `instance`; `None` if there is no such file.
    pub fn open(paths: &ServicePaths, instance: &Instance) -> Option<Self> {
        let file = regular_file::open(&paths.lock()).ok()?;
        Some(Self { file, token: instance.token.clone() })
    }

    /// True if the same daemon still holds it: each writes its own token into it.
    pub fn is_held(&self) -> bool {
        if !is_locked(&self.file) {
            return false;
        }
        let mut text = [0; 64];
        let length = self.file.read_at(&mut text, 0).unwrap_or(0);
        // The file is empty for the moment in which another daemon writes.
        let token = std::str::from_utf8(&text[..length]).ok().and_then(|text| text.lines().nth(1));
        token.is_none_or(|token| token == self.token)
    }
}

/// True if some daemon at `paths` lives.
pub fn daemon_lives(paths: &ServicePaths) -> bool {
    regular_file::open(&paths.lock()).is_ok_and(|file| is_locked(&file))
}

/// True if some process holds the lock on a file. The kernel releases it with the process, however that ends. This tries a shared
/// lock, so clients do not disturb each other; a starting daemon tries more than once.
fn is_locked(file: &File) -> bool {
    if flock(file, FlockOperation::NonBlockingLockShared).is_err() {
        return true;
    }
    let _ = flock(file, FlockOperation::Unlock);
    false
}
