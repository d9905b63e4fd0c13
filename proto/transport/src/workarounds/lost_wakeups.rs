//! A notification can be lost, and a timeout of zero never ends.
//!
//! **Symptom.** A listener that drains its socket between a notifier's `send` and its change of state stays in the state `NOTIFIED`
//! with an empty socket: later notifications are skipped until the listener waits again. A `timed_wait` of less than a microsecond is
//! a socket timeout of zero, which means no timeout.
//!
//! **Reproduction** (iceoryx2 0.10.0). 2 to 8 notifiers and one listener that polls its descriptor: 18 of 7.1 million notifications were
//! lost; by `timed_wait` 2 of 7.9 million.
//!
//! **Upstream.** No issue known.
//!
//! **Delete.** [`bounded`] and [`reset`], and the tick of the daemon (`times.tick_ms`), once a notification cannot be lost.

use crate::Ipc;
use iceoryx2::port::listener::Listener;
use std::time::Duration;

/// Longest wait between two polls of the ports.
pub const TICK: Duration = Duration::from_millis(5);

/// Shortest wait: the socket below takes a timeout of less than a microsecond for no timeout.
const TICK_MIN: Duration = Duration::from_millis(1);

/// Length of the next wait of a caller that has `left` time: at most [`TICK`], and long enough to end.
pub fn bounded(left: Duration) -> Duration {
    left.clamp(TICK_MIN, TICK)
}

/// Drains `listener` whether or not its descriptor was readable, so that the next notification is sent.
pub fn reset(listener: &Listener<Ipc>) {
    if let Err(error) = listener.try_wait(|_| {}) {
        tracing::debug!(?error, "cannot read the wake-up socket");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_wait_is_bounded() {
        let ms = Duration::from_millis;
        assert_eq!([Duration::ZERO, ms(3), ms(60_000)].map(bounded), [ms(1), ms(3), ms(5)]);
    }
}
