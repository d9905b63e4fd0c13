//! The option `--wait SECONDS`: wait until a service, or an object of it, can be used.

use super::reply;
use shatter_client::{Client, Convention, Deadline, Error, Object};
use shatter_proto::text::quoted;
use std::time::{Duration, Instant};

/// Pause between two attempts.
const PAUSE: Duration = Duration::from_millis(50);

/// The value of `--wait`, s.
///
/// # Errors
/// A message for text that is not a number, or for a number that is negative or too large.
pub(super) fn seconds(text: &str) -> Result<Duration, String> {
    let seconds: f64 = text.parse().map_err(|_| format!("`{}` is not a number", quoted(text)))?;
    Duration::try_from_secs_f64(seconds).map_err(|_| "must be from 0 to 1e19, in seconds".to_owned())
}

/// Result of `attempt`. Repeats it after an error that may pass, until the deadline, if there is one.
///
/// # Errors
/// The last error of `attempt`.
pub(super) fn until<T>(deadline: Option<Deadline>, attempt: impl Fn() -> Result<T, Error>) -> Result<T, Error> {
    loop {
        match (attempt(), deadline) {
            (Err(error), Some(deadline)) if error.kind.retry() && !deadline.passed() => {
                std::thread::sleep(PAUSE.min(deadline.left()));
            }
            (result, _) => return result,
        }
    }
}

/// Finds the object `name` of `service`, for requests in `convention`. Waits up to `wait` for a daemon, and for the object while its
/// database is being loaded. Each of the two replies may take longer than that: as long as usual,
/// or without `wait` until `usual`.
///
/// # Errors
/// Those of [`Client::connect`] and [`Client::object`]; once the wait is over, the last of them.
pub(super) fn object(
    service: &str,
    name: &str,
    convention: Convention,
    wait: Option<Duration>,
    usual: impl Fn() -> Deadline,
) -> Result<Object, Error> {
    let (begun, deadline) = (Instant::now(), wait.map(Deadline::after));
    let timeout = || if wait.is_some() { reply() } else { usual() };
    let waited = |error: Error| match (wait, error.kind.retry()) {
        (Some(_), true) => {
            let message = format!("{}; waited {:.1} s (--wait)", error.message, begun.elapsed().as_secs_f64());
            Error { message, ..error }
        }
        _ => error,
    };
    let connected = until(deadline, || Client::connect(service, timeout()));
    let connection = connected.map_err(waited)?.with_convention(convention);
    until(deadline, || connection.object(name, timeout())).map_err(waited)
}
