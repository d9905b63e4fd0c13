//! A server stays connected after it was killed.
//!
//! **Symptom.** `PendingResponse::is_connected` stays true, and sending to the dead server succeeds, until some process cleans up after
//! it. Without a server a pending response is connected, too.
//!
//! **Reproduction** (iceoryx2 0.10.0). SIGKILL to the daemon while a client waits for a response.
//!
//! **Upstream.** No issue known; 1763, mended in 0.10, concerns the state after the cleanup.
//!
//! **Delete.** The liveness checks of clients ([`DaemonLock`], [`PULSE`]), once a client sees that a server died. The lock itself stays:
//! it also says that one daemon serves a name.

use crate::instance::Instance;
use crate::paths::ServicePaths;
use rustix::fs::{FlockOperation, flock};
use std::fs::File;
use std::os::unix::fs::FileExt;
use std::time::Duration;

/// A client that waits looks at the lock of its daemon this often.
pub const PULSE: Duration = Duration::from_millis(200);

/// The lock file of a daemon, as it was when it served.
pub struct DaemonLock {
    file: File,
    token: String,
}

impl DaemonLock {
    /// The one of the daemon of `place` whose transport is `instance`; `None` where there is no such file.
    pub fn open(place: &ServicePaths, instance: &Instance) -> Option<Self> {
        let file = File::open(place.lock()).ok()?;
        Some(Self { file, token: instance.token.clone() })
    }

    /// Whether the daemon holds it that held it then: a daemon that takes it writes its own token into it.
    pub fn is_held(&self) -> bool {
        if !is_locked(&self.file) {
            return false;
        }
        let mut text = [0; 64];
        let length = self.file.read_at(&mut text, 0).unwrap_or(0);
        // Nothing can be read for the moment in which a daemon that takes it writes.
        let token = std::str::from_utf8(&text[..length]).ok().and_then(|text| text.lines().nth(1));
        token.is_none_or(|token| token == self.token)
    }
}

/// Whether some daemon of `place` lives.
pub fn any_lives(place: &ServicePaths) -> bool {
    File::open(place.lock()).is_ok_and(|file| is_locked(&file))
}

/// Whether some process holds the lock on a file. The kernel gives it back with the process, however that ends. A shared lock is
/// tried, so clients do not disturb each other; a starting daemon tries more than once.
fn is_locked(file: &File) -> bool {
    if flock(file, FlockOperation::NonBlockingLockShared).is_err() {
        return true;
    }
    let _ = flock(file, FlockOperation::Unlock);
    false
}
