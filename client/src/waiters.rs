//! Tasks that await results over one connection.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::task::Waker;

/// The wakers of the tasks that await tickets of one connection.
#[derive(Default)]
pub(crate) struct Waiters(Mutex<State>);

#[derive(Default)]
struct State {
    wakers: Vec<Waker>,
    /// Whether a thread listens for them.
    has_listener: bool,
}

impl Waiters {
    fn state(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds `waker`, once; `start` begins to listen where no thread does, and its error is returned.
    ///
    /// # Errors
    /// Those of `start`.
    pub(crate) fn add<E>(&self, waker: &Waker, start: impl FnOnce() -> Result<(), E>) -> Result<(), E> {
        let mut state = self.state();
        if !state.wakers.iter().any(|other| other.will_wake(waker)) {
            state.wakers.push(waker.clone());
        }
        if !state.has_listener {
            start()?;
            state.has_listener = true;
        }
        Ok(())
    }

    /// Wakes all tasks; `false`: there was none, and the listening thread ends.
    pub(crate) fn wake_all(&self) -> bool {
        let mut state = self.state();
        if state.wakers.is_empty() {
            state.has_listener = false;
            return false;
        }
        let wakers = std::mem::take(&mut state.wakers);
        drop(state);
        wakers.into_iter().for_each(Waker::wake);
        true
    }
}
