//! Databases that were found and are not loaded yet: start and expected duration of the load.

use shatter_proto::name::object_being_loaded;
use shatter_proto::{Error, ErrorKind};
use std::time::{Duration, Instant};

/// Load rate without a loaded database to measure it by, bytes/s: 2.66 GB took 6 s on two cores.
const BYTES_PER_S: f64 = 4e8;

/// Time before a load begins: the folder must look the same in two scans, a quarter of a second apart.
const REST: Duration = Duration::from_millis(500);

/// Shortest and longest time after which a client is advised to retry. Files of a batch are served one by one, and may be sparse or damaged,
/// so that sizes say little about a long wait.
const WAITS: [Duration; 2] = [Duration::from_millis(100), Duration::from_secs(5)];

/// Load in progress.
#[derive(Clone, Copy)]
pub struct LoadInProgress {
    since: Instant,
    expected: Duration,
}

impl LoadInProgress {
    /// Begins a load of so many bytes; `known` holds bytes and load times of other databases.
    pub fn now(bytes: u64, known: impl Iterator<Item = (u64, Duration)>) -> Self {
        let (loaded, took) =
            known.fold((0, Duration::ZERO), |(loaded, took), (bytes, time)| (loaded + bytes, took + time));
        let time_s =
            if loaded > 0 { took.as_secs_f64() * bytes as f64 / loaded as f64 } else { bytes as f64 / BYTES_PER_S };
        Self { since: Instant::now(), expected: REST + Duration::from_secs_f64(time_s) }
    }

    /// Error for requests of the object `name` during the load.
    pub fn error(&self, name: &str) -> Error {
        let message = format!("the database of `{name}` is being loaded; send the request again later");
        Error::new(ErrorKind::Loading, name, message).after(self.left(self.since.elapsed()))
    }

    /// Error for requests of an object that no loaded database holds, while the one of the file name `file` is loaded.
    pub fn error_of_unknown(&self, name: &str, file: &str) -> Error {
        object_being_loaded(name, file).after(self.left(self.since.elapsed()))
    }

    /// Expected remaining time after `elapsed`; a tenth of `elapsed` for a load that takes longer than expected.
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
        assert!(waits.is_sorted_by(|a, b| a >= b) && waits[1] == s(4.5), "{waits:?}");
        assert_eq!((known.left(s(30.0)), LoadInProgress::now(0, std::iter::empty()).left(REST)), (s(3.0), WAITS[0]));
        let sparse = LoadInProgress::now(20 << 30, std::iter::empty());
        assert_eq!((sparse.left(s(0.0)), sparse.left(s(600.0))), (s(5.0), s(5.0)), "the advice is bounded");
        assert_eq!(known.error("pot").kind, ErrorKind::Loading);
    }
}
