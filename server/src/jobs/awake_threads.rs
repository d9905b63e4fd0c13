//! Threads that stay awake during a request.
//!
//! Most parts of a request take a fraction of a millisecond. A thread that sleeps between them wakes up when they are nearly over.
//!
//! # No deadlock
//! A thread that waits for a part of its request runs other tasks on the same stack. If it began to stay there, the request would wait
//! for itself. So a thread can only enter before the request has parts:
//! - A task waits for the tasks above it on its stack and for its parts. [`State::stay`] also waits for the end of a request.
//! - Tasks above another one, and parts, begin after it. Those of the request's own task begin after its entrance closes.
//! - A stay begins before the entrance closes.
//!
//! Let the time of a request's own task be the closing of its entrance, and that of any other task its beginning. Then every task waits
//! for later ones only, and no cycle exists. This holds for any number of requests on a pool, nested or not. Tasks must not wait for
//! parts while they hold a lock.

use rayon::Yield;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread::Thread;
use std::time::{Duration, Instant};

/// Largest number of threads that stay awake beside that of the request: few parts of a request have work for more.
const THREADS_MAX: usize = 3;

/// Longest time for which the entrance is open. Sleeping threads of an idle machine enter within 10 to 50 µs.
const ENTRANCE_TIME: Duration = Duration::from_micros(200);

/// Keeps threads of the current pool awake until it is dropped. They run parts of the request, and give way to other threads of the
/// machine while there are none.
pub(super) struct AwakeThreads(Arc<State>);

/// State that the threads share.
struct State {
    /// Number of threads that may still enter; 0: the entrance is closed.
    places: AtomicUsize,
    is_over: AtomicBool,
    /// Thread of the request.
    own: Thread,
}

impl AwakeThreads {
    /// Must be called on a thread of a pool, before the request has parts.
    pub fn new() -> Self {
        let count = THREADS_MAX.min(rayon::current_num_threads().saturating_sub(1));
        let state = Arc::new(State::new(count));
        for _ in 0..count {
            let state = state.clone();
            rayon::spawn(move || state.stay());
        }
        let begun = Instant::now();
        // Sleeps: giving way took 4 to 16 ms on a busy machine, since others then use up their time slices.
        while state.is_open()
            && let Some(left) = ENTRANCE_TIME.checked_sub(begun.elapsed())
        {
            std::thread::park_timeout(left);
        }
        state.close();
        Self(state)
    }
}

impl Drop for AwakeThreads {
    fn drop(&mut self) {
        self.0.is_over.store(true, Ordering::Relaxed);
    }
}

impl State {
    fn new(places: usize) -> Self {
        let (places, is_over) = (AtomicUsize::new(places), AtomicBool::new(false));
        Self { places, is_over, own: std::thread::current() }
    }

    fn is_open(&self) -> bool {
        self.places.load(Ordering::Relaxed) > 0
    }

    /// Closes the entrance. Entries happen before it, by the ordering of both.
    fn close(&self) {
        self.places.swap(0, Ordering::AcqRel);
    }

    /// Runs parts until the request is over. Returns at once if the entrance is closed.
    fn stay(&self) {
        let enter = |places: usize| places.checked_sub(1);
        if self.places.fetch_update(Ordering::AcqRel, Ordering::Relaxed, enter).is_err() {
            return;
        }
        if !self.is_open() {
            self.own.unpark();
        }
        // Each thread takes one place.
        while self.is_open() {
            std::thread::yield_now();
        }
        while !self.is_over.load(Ordering::Relaxed) {
            if rayon::yield_now() != Some(Yield::Executed) {
                std::thread::yield_now();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayon::{ThreadPool, ThreadPoolBuilder};
    use std::panic::{AssertUnwindSafe, catch_unwind};
    use std::sync::mpsc;

    fn pool(threads: usize) -> ThreadPool {
        ThreadPoolBuilder::new().num_threads(threads).build().unwrap()
    }

    /// Number of leaves of a tree of parts, in which threads wait for each other.
    fn leaves(depth: u32, seed: u64) -> u64 {
        if depth == 0 {
            return 1 + (0..seed % 200).map(std::hint::black_box).sum::<u64>() / u64::MAX;
        }
        let (left, right) = (|| leaves(depth - 1, seed / 2 + 7), || leaves(depth - 1, seed / 3 + 5));
        let (left, right) = rayon::join(left, right);
        left + right
    }

    #[test]
    fn threads_stay_until_the_end_and_run_parts() {
        for threads in 1..=6 {
            let pool = pool(threads);
            pool.install(|| {
                let _awake = AwakeThreads::new();
                assert_eq!(leaves(6, 1000), 64);
            });
            // All threads are free again.
            pool.broadcast(|_| ());
        }
    }

    #[test]
    fn no_thread_enters_late() {
        let pool = pool(2);
        let ((begin, begun), (end, ended)) = (mpsc::channel(), mpsc::channel::<()>());
        pool.spawn(move || {
            begin.send(()).unwrap();
            ended.recv().unwrap();
        });
        begun.recv().unwrap();
        pool.install(|| {
            // No thread is free to enter.
            let awake = AwakeThreads::new();
            assert!(!awake.0.is_open());
            // The request's own thread takes the task that is left, and would wait for itself.
            assert_eq!(rayon::yield_now(), Some(Yield::Executed));
            assert_eq!(rayon::yield_now(), Some(Yield::Idle));
            end.send(()).unwrap();
        });
    }

    #[test]
    fn a_panic_ends_the_wait() {
        let pool = pool(3);
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

    /// Requests of several clients on one pool, which threads run on top of each other.
    #[test]
    fn many_requests_on_small_pools_all_end() {
        for threads in 2..=4 {
            let pool = pool(threads);
            let client = |index: u64| {
                for request in 0..2000 {
                    let (send, receive) = mpsc::channel();
                    let seed = (index + 1) * 7919 * request;
                    pool.spawn(move || {
                        let _awake = AwakeThreads::new();
                        send.send(leaves(4, seed)).unwrap();
                    });
                    assert_eq!(receive.recv().unwrap(), 16);
                    // Threads are then awake, asleep or about to sleep.
                    let (begun, pause) = (Instant::now(), Duration::from_micros(seed % 200));
                    match request % 3 {
                        0 => std::thread::sleep(pause),
                        _ => while begun.elapsed() < pause {},
                    }
                }
            };
            std::thread::scope(|scope| (0..4).for_each(|index| _ = scope.spawn(move || client(index))));
            pool.broadcast(|_| ());
        }
    }
}
