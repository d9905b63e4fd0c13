//! Errors of closed requests, kept until the clients collect them.

use shatter_proto::error::ErrorWire;
use shatter_transport::{CLIENTS_MAX, STRIKES_PER_CLIENT_MAX};
use std::collections::{HashMap, VecDeque};

/// Capacity: the number of requests that all clients together can have in flight; beyond it the oldest errors are dropped.
const KEPT: usize = CLIENTS_MAX * STRIKES_PER_CLIENT_MAX;

/// Number of collected errors kept for clients that ask again because a reply was lost, over all clients.
const TOLD: usize = 256;

/// Identifies a request: the listener of its client, and its sequence number.
pub type RequestKey = ([u8; 16], u64);

/// Mailbox of errors.
#[derive(Default)]
pub struct ErrorMailbox {
    by_strike: HashMap<RequestKey, ErrorWire>,
    order: VecDeque<RequestKey>,
    told: VecDeque<(RequestKey, ErrorWire)>,
}

impl ErrorMailbox {
    /// Stores the error of a request.
    pub fn keep(&mut self, strike: RequestKey, verdict: ErrorWire) {
        if self.by_strike.insert(strike, verdict).is_some() {
            // A client reused a sequence number; the new error is the youngest.
            self.order.retain(|other| *other != strike);
        }
        self.order.push_back(strike);
        while self.order.len() > KEPT {
            if let Some(oldest) = self.order.pop_front() {
                self.by_strike.remove(&oldest);
            }
        }
    }

    /// Returns the error of a request, if it is known.
    pub fn tell(&mut self, strike: RequestKey) -> Option<ErrorWire> {
        let Some(verdict) = self.by_strike.remove(&strike) else {
            return self.told.iter().rev().find(|(told, _)| *told == strike).map(|(_, verdict)| *verdict);
        };
        self.order.retain(|other| *other != strike);
        self.told.push_back((strike, verdict));
        while self.told.len() > TOLD {
            self.told.pop_front();
        }
        Some(verdict)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shatter_proto::{Error, ErrorKind};

    #[test]
    fn the_oldest_verdicts_are_forgotten_first() {
        let mut verdicts = ErrorMailbox::default();
        let verdict = |n: u64| ErrorWire::from(&Error::new(ErrorKind::Busy, n.to_string(), "full"));
        for n in 0..=KEPT as u64 {
            verdicts.keep(([1; 16], n), verdict(n));
            verdicts.keep(([1; 16], n), verdict(n));
        }
        verdicts.keep(([1; 16], 1), verdict(1));
        verdicts.keep(([3; 16], 1), verdict(1));
        assert_eq!((verdicts.by_strike.len(), verdicts.order.len()), (KEPT, KEPT));
        assert_eq!((verdicts.tell(([1; 16], 0)), verdicts.tell(([1; 16], 2))), (None, None));
        assert_eq!(verdicts.tell(([1; 16], 1)), Some(verdict(1)));
        assert_eq!(verdicts.tell(([2; 16], 1)), None);
    }

    #[test]
    fn what_was_told_is_told_again_and_takes_no_room() {
        let mut verdicts = ErrorMailbox::default();
        let verdict = |n: u64| ErrorWire::from(&Error::new(ErrorKind::Busy, n.to_string(), "full"));
        for n in 0..10_000 {
            verdicts.keep(([1; 16], n), verdict(n));
            assert_eq!(
                (verdicts.tell(([1; 16], n)), verdicts.tell(([1; 16], n))),
                (Some(verdict(n)), Some(verdict(n)))
            );
        }
        assert_eq!((verdicts.by_strike.len(), verdicts.order.len(), verdicts.told.len()), (0, 0, TOLD));
        assert!(verdicts.by_strike.capacity() < 64 && verdicts.tell(([1; 16], 0)).is_none());
    }
}
