//! A forked process that drops its copies of ports and nodes takes them from its parent.
//!
//! **Symptom.** After a fork, the parent's requests get no replies once the child has ended or dropped its copies: the destructors of
//! ports, nodes, requests and responses change the shared memory that both processes use.
//!
//! **Reproduction** (iceoryx2 0.10.0). A Python client connects and forks; the child calls `sys.exit(0)`; the parent waits for a result.
//!
//! **Upstream.** No issue known.
//!
//! **Delete.** [`OwnedByProcess`], once destructors check the process.

use std::ops::Deref;

/// A port, node, request or response that only the process which made it drops.
pub struct OwnedByProcess<T> {
    /// Taken by the destructor alone.
    value: Option<T>,
    process: u32,
}

impl<T> OwnedByProcess<T> {
    /// Holds `value`, made by this process.
    pub fn new(value: T) -> Self {
        Self { value: Some(value), process: std::process::id() }
    }

    /// Whether another process made it, of which this one was forked.
    pub fn is_forked(&self) -> bool {
        self.process != std::process::id()
    }
}

impl<T> Deref for OwnedByProcess<T> {
    type Target = T;

    fn deref(&self) -> &T {
        match &self.value {
            Some(value) => value,
            None => unreachable!("only the destructor takes the value"),
        }
    }
}

impl<T> Drop for OwnedByProcess<T> {
    fn drop(&mut self) {
        if self.is_forked() {
            std::mem::forget(self.value.take());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicBool, Ordering};

    struct Dropped<'a>(&'a AtomicBool);

    impl Drop for Dropped<'_> {
        fn drop(&mut self) {
            self.0.store(true, Ordering::Relaxed);
        }
    }

    #[test]
    fn a_value_is_dropped_only_by_the_process_that_made_it() {
        let dropped = AtomicBool::new(false);
        let forked = OwnedByProcess { value: Some(Dropped(&dropped)), process: 0 };
        assert!(forked.is_forked());
        drop(forked);
        assert!(!dropped.load(Ordering::Relaxed));
        drop(OwnedByProcess::new(Dropped(&dropped)));
        assert!(dropped.load(Ordering::Relaxed));
    }
}
