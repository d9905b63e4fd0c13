//! Databases that were found and are not loaded yet: since when, and how long that is expected to take.

use shatter_proto::{Error, ErrorKind};
use std::time::{Duration, Instant};

/// Bytes of a file that are loaded in a second, while no database is loaded that could tell: 2.66 GB took 6 s on two cores.
const BYTES_PER_S: f64 = 4e8;

/// A folder is looked at twice, a quarter of a second apart, before its new databases are loaded.
const REST: Duration = Duration::from_millis(500);

/// Shortest and longest time after which a client is told to ask again.
const WAITS: [Duration; 2] = [Duration::from_millis(100), Duration::from_secs(600)];

/// A load that goes on.
#[derive(Clone, Copy)]
pub struct LoadInProgress {
    since: Instant,
    expected: Duration,
}

impl LoadInProgress {
    /// Begins now, of databases of so many bytes; `known` are the bytes and load times of others.
    pub fn now(bytes: u64, known: impl Iterator<Item = (u64, Duration)>) -> Self {
        let (loaded, took) =
            known.fold((0, Duration::ZERO), |(loaded, took), (bytes, time)| (loaded + bytes, took + time));
        let time_s =
            if loaded > 0 { took.as_secs_f64() * bytes as f64 / loaded as f64 } else { bytes as f64 / BYTES_PER_S };
        Self { since: Instant::now(), expected: REST + Duration::from_secs_f64(time_s) }
    }

    /// What a strike of the object `name` is told meanwhile.
    pub fn refusal(&self, name: &str) -> Error {
        let message = format!("the database of `{name}` is being loaded; send the strike again later");
        Error::new(ErrorKind::Loading, name, message).after(self.left(self.since.elapsed()))
    }

    /// How long it is expected to go on after `elapsed`. One that takes longer than expected takes a tenth of its time more.
    fn left(&self, elapsed: Duration) -> Duration {
        self.expected.saturating_sub(elapsed).max(elapsed / 10).clamp(WAITS[0], WAITS[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_wait_follows_the_size_and_counts_down() {
        let s = Duration::from_secs_f64;
        let unknown = LoadInProgress::now(4_000_000_000, std::iter::empty());
        assert_eq!(unknown.expected, REST + s(10.0));
        let known = LoadInProgress::now(300, [(100, s(1.0)), (200, s(5.0))].into_iter());
        assert_eq!(known.expected, REST + s(6.0));
        let waits = [0.0, 2.0, 4.0, 6.0].map(|elapsed| known.left(s(elapsed)));
        assert!(waits.is_sorted_by(|a, b| a > b) && waits[0] == s(6.5), "{waits:?}");
        assert_eq!((known.left(s(60.0)), LoadInProgress::now(0, std::iter::empty()).left(REST)), (s(6.0), WAITS[0]));
        assert_eq!(known.refusal("pot").kind, ErrorKind::Loading);
    }
}
