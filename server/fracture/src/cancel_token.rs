//! One small copyable object for cancellation and progress, polled by every stage, inside its loops too.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

/// The work was cancelled; whatever it had computed is dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// Shared by whoever waits and whoever works. Cloning is cheap and refers to the same work.
///
/// Granularity: stages poll at least once per Lloyd iteration, per 4096 lattice nodes, and per factorisation or
/// eigenvalue block.
#[derive(Clone, Debug, Default)]
pub struct CancelToken(Arc<State>);

#[derive(Debug, Default)]
struct State {
    cancelled: AtomicBool,
    permille: AtomicU32,
}

impl CancelToken {
    /// Asks the work to stop at its next checkpoint. Never blocks; calling it twice is harmless.
    pub fn cancel(&self) {
        self.0.cancelled.store(true, Ordering::Relaxed);
    }

    /// Whether the work was asked to stop.
    pub fn is_cancelled(&self) -> bool {
        self.0.cancelled.load(Ordering::Relaxed)
    }

    /// The checkpoint: an error once the work was asked to stop.
    pub fn check(&self) -> Result<(), Cancelled> {
        if self.is_cancelled() { Err(Cancelled) } else { Ok(()) }
    }

    /// Publishes how far the work is, 0 ..= 1; values outside are clamped.
    pub fn report(&self, fraction: f64) {
        let permille = (fraction.clamp(0.0, 1.0) * 1000.0) as u32;
        self.0.permille.store(permille, Ordering::Relaxed);
    }

    /// The last published fraction, in steps of 1/1000.
    pub fn progress(&self) -> f64 {
        f64::from(self.0.permille.load(Ordering::Relaxed)) / 1000.0
    }
}
