//! Cancellation of work in progress.
//!
//! [`CancelToken`] is the only way to stop a computation. Every stage polls it, inside its loops too, and may read the
//! time that is left from it.

use std::fmt::{self, Debug, Formatter};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Error of a stage that was canceled. Its partial results are dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("canceled")]
pub struct Canceled;

/// Stop flag shared by the thread that waits and the threads that compute.
///
/// Clones are cheap and refer to the same work. Stages poll at least once per Lloyd iteration, per 4096 lattice nodes,
/// and per factorization or eigenvalue block.
#[derive(Clone, Default)]
pub struct CancelToken {
    canceled: Arc<AtomicBool>,
    remaining: Option<Arc<dyn Fn() -> f64 + Send + Sync>>,
}

impl CancelToken {
    /// Returns a token of the same work that also reports the time left.
    ///
    /// `remaining_s` returns seconds, negative after the deadline. This crate reads no
    /// clock, so the caller supplies it.
    #[must_use]
    pub fn with_time(&self, remaining_s: impl Fn() -> f64 + Send + Sync + 'static) -> Self {
        Self { canceled: self.canceled.clone(), remaining: Some(Arc::new(remaining_s)) }
    }

    /// Requests the work to stop at its next checkpoint. Never blocks; repeated calls have no further effect.
    pub fn cancel(&self) {
        self.canceled.store(true, Ordering::Relaxed);
    }

    /// Returns true once [`Self::cancel`] was called on this token or a clone.
    pub fn is_canceled(&self) -> bool {
        self.canceled.load(Ordering::Relaxed)
    }

    /// Checkpoint of a stage: fails once the work is canceled.
    ///
    /// # Errors
    /// [`Canceled`] once the work was asked to stop.
    pub fn check(&self) -> Result<(), Canceled> {
        if self.is_canceled() { Err(Canceled) } else { Ok(()) }
    }

    /// Seconds until the result is due: negative after the deadline, infinite without one.
    pub fn remaining_s(&self) -> f64 {
        self.remaining.as_ref().map_or(f64::INFINITY, |remaining_s| remaining_s())
    }
}

impl Debug for CancelToken {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        let (is_canceled, is_timed) = (self.is_canceled(), self.remaining.is_some());
        formatter.debug_struct("CancelToken").field("is_canceled", &is_canceled).field("is_timed", &is_timed).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_derived_token_is_canceled_with_its_parent() {
        let token = CancelToken::default();
        let timed = token.with_time(|| 0.25);
        assert_eq!((token.remaining_s(), timed.remaining_s()), (f64::INFINITY, 0.25));
        token.cancel();
        assert_eq!(timed.check(), Err(Canceled));
    }
}
