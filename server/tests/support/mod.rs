//! Common parts of the daemon's tests: test places, a toy engine, daemons in this process and in others.

#![allow(dead_code, unused_imports, reason = "every test file uses another part")]

mod bar;
mod daemon;
mod directory;
mod fake_object;
mod raw;

pub use bar::bar;
pub use daemon::{Child, InProcess, play, role, shatter, shatter_program, shatterd, under};
pub use directory::{TestDirectory, leave_tags, leave_unfinished, within};
pub use fake_object::{addresses, loader, order};
pub use raw::{RawPeer, Sent};

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::Rng;
use shatter_client::Deadline;
use std::fmt::Display;
use std::time::Duration;

/// Timeout long enough for a loaded machine; a test that reaches it has failed.
pub fn timeout() -> Deadline {
    Deadline::ms(60_000)
}

/// Waits with a timeout until `holds`.
#[track_caller]
pub fn eventually<T: Display>(what: impl Fn() -> T, holds: impl Fn() -> bool) {
    let deadline = timeout();
    while !holds() {
        assert!(!deadline.passed(), "never: {}", what());
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Number of descriptors that the process `pid` has open.
pub fn descriptors(pid: u32) -> usize {
    std::fs::read_dir(format!("/proc/{pid}/fd")).unwrap().count()
}

/// Median and maximum of times, as text.
pub fn quantiles(mut times: Vec<Duration>) -> String {
    times.sort();
    let ms = |time: Duration| time.as_secs_f64() * 1e3;
    format!("median {:.0} ms, most {:.0} ms", ms(times[times.len() / 2]), ms(times[times.len() - 1]))
}

/// Sleeps a random time up to `most_us`, μs.
pub fn pause(random: &mut ChaCha8Rng, most_us: u64) {
    std::thread::sleep(Duration::from_micros(random.next_u64() % most_us));
}
