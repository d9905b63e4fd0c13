//! Threads that stay awake during a request.
//!
//! Most parts of a request take a fraction of a millisecond. A thread that sleeps between them wakes up when they are nearly over.

use rayon::Yield;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Largest number of threads that stay awake beside that of the request: few parts of a request have work for more.
const THREADS_MAX: usize = 3;

/// Keeps threads of the current pool awake until it is dropped. They run parts of the request, and give way to other threads of the
/// machine while there are none.
pub(super) struct AwakeThreads(Arc<AtomicBool>);

impl AwakeThreads {
    /// Must be called on a thread of a pool, on which only this request runs.
    pub fn new() -> Self {
        let is_over = Arc::new(AtomicBool::new(false));
        let (own, seen) = (rayon::current_thread_index().unwrap_or_default(), is_over.clone());
        rayon::spawn_broadcast(move |context| {
            let after = (context.index() + context.num_threads() - own) % context.num_threads();
            // The request's own thread must not wait here: it ends the wait.
            let stays = (1..=THREADS_MAX).contains(&after);
            while stays && !seen.load(Ordering::Relaxed) {
                if rayon::yield_now() != Some(Yield::Executed) {
                    std::thread::yield_now();
                }
            }
        });
        Self(is_over)
    }
}

impl Drop for AwakeThreads {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayon::ThreadPoolBuilder;
    use std::panic::{AssertUnwindSafe, catch_unwind};

    #[test]
    fn threads_stay_until_the_end_and_run_parts() {
        for count in 1..=6 {
            let pool = ThreadPoolBuilder::new().num_threads(count).build().unwrap();
            pool.install(|| {
                let awake = AwakeThreads::new();
                // More parts than threads, nested, so that any thread waits for another one.
                let sum = |from: u64| (from..from + 1000).sum::<u64>();
                let halves = |from: u64| rayon::join(|| sum(from), || sum(from + 1000));
                let ((a, b), (c, d)) = rayon::join(|| halves(0), || halves(2000));
                assert_eq!(a + b + c + d, sum(0) + sum(1000) + sum(2000) + sum(3000));
                drop(awake);
            });
            // All threads are free again.
            pool.broadcast(|_| ());
        }
    }

    #[test]
    fn a_panic_ends_the_wait() {
        let pool = ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        let failing = AssertUnwindSafe(|| {
            pool.install(|| {
                let _awake = AwakeThreads::new();
                assert_eq!(pool.current_num_threads(), 2, "a request fails");
            });
        });
        assert!(catch_unwind(failing).is_err());
        // Returns when all threads are free.
        pool.broadcast(|_| ());
    }
}
