//! The one stop mechanism: every stage polls a token, inside its loops too, and may ask it how much time is left.

use std::fmt::{self, Debug, Formatter};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The work was cancelled; its partial results are dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// Shared by the thread that waits and the threads that work. Clones are cheap and refer to the same work.
///
/// Granularity: stages poll at least once per Lloyd iteration, per 4096 lattice nodes, and per factorisation or
/// eigenvalue block.
#[derive(Clone, Default)]
pub struct CancelToken {
    cancelled: Arc<AtomicBool>,
    remaining: Option<Arc<dyn Fn() -> f64 + Send + Sync>>,
}

impl CancelToken {
    /// A token of the same work that also knows how much time is left: `remaining_s` returns seconds, less than 0 after the end. This
    /// crate has no clock; the caller brings one.
    #[must_use]
    pub fn with_time(&self, remaining_s: impl Fn() -> f64 + Send + Sync + 'static) -> Self {
        Self { cancelled: self.cancelled.clone(), remaining: Some(Arc::new(remaining_s)) }
    }

    /// Asks the work to stop at its next checkpoint. Never blocks; calling it twice is harmless.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// Whether the work was asked to stop.
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    /// The checkpoint.
    ///
    /// # Errors
    /// [`Cancelled`] once the work was asked to stop.
    pub fn check(&self) -> Result<(), Cancelled> {
        if self.is_cancelled() { Err(Cancelled) } else { Ok(()) }
    }

    /// Seconds until the result is due, less than 0 after that; infinity if the work may take any time.
    pub fn remaining_s(&self) -> f64 {
        self.remaining.as_ref().map_or(f64::INFINITY, |remaining_s| remaining_s())
    }
}

impl Debug for CancelToken {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        let (is_cancelled, is_timed) = (self.is_cancelled(), self.remaining.is_some());
        formatter.debug_struct("CancelToken").field("is_cancelled", &is_cancelled).field("is_timed", &is_timed).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_token_with_time_is_cancelled_with_the_one_that_it_came_from() {
        let token = CancelToken::default();
        let timed = token.with_time(|| 0.25);
        assert_eq!((token.remaining_s(), timed.remaining_s()), (f64::INFINITY, 0.25));
        token.cancel();
        assert_eq!(timed.check(), Err(Cancelled));
    }
}
