//! Errors of closed requests, kept until the clients collect them.

use shatter_proto::error::ErrorWire;
use shatter_transport::{CLIENTS_MAX, STRIKES_PER_CLIENT_MAX};
use std::collections::{HashMap, VecDeque};

/// Capacity: the number of requests that all clients together can have in flight; beyond it the oldest errors are dropped.
const ERRORS_MAX: usize = CLIENTS_MAX * STRIKES_PER_CLIENT_MAX;

/// Number of collected errors kept for clients that ask again because a reply was lost, over all clients.
const COLLECTED_MAX: usize = 256;

/// Identifies a request: the listener of its client, and its sequence number.
pub type RequestKey = ([u8; 16], u64);

/// Mailbox of errors.
#[derive(Default)]
pub struct ErrorMailbox {
    by_request: HashMap<RequestKey, ErrorWire>,
    order: VecDeque<RequestKey>,
    collected: VecDeque<(RequestKey, ErrorWire)>,
}

impl ErrorMailbox {
    /// Stores the error of a request.
    pub fn keep(&mut self, request: RequestKey, error: ErrorWire) {
        if self.by_request.insert(request, error).is_some() {
            // A client reused a sequence number; the new error is the youngest.
            self.order.retain(|other| *other != request);
        }
        self.order.push_back(request);
        while self.order.len() > ERRORS_MAX {
            if let Some(oldest) = self.order.pop_front() {
                self.by_request.remove(&oldest);
            }
        }
    }

    /// Returns the error of a request, if it is known.
    pub fn collect(&mut self, request: RequestKey) -> Option<ErrorWire> {
        let Some(error) = self.by_request.remove(&request) else {
            return self.collected.iter().rev().find(|(collected, _)| *collected == request).map(|(_, error)| *error);
        };
        self.order.retain(|other| *other != request);
        self.collected.push_back((request, error));
        while self.collected.len() > COLLECTED_MAX {
            self.collected.pop_front();
        }
        Some(error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shatter_proto::{Error, ErrorKind};

    #[test]
    fn the_oldest_errors_are_dropped_first() {
        let mut mailbox = ErrorMailbox::default();
        let error = |n: u64| ErrorWire::from(&Error::new(ErrorKind::Busy, n.to_string(), "full"));
        for n in 0..=ERRORS_MAX as u64 {
            mailbox.keep(([1; 16], n), error(n));
            mailbox.keep(([1; 16], n), error(n));
        }
        mailbox.keep(([1; 16], 1), error(1));
        mailbox.keep(([3; 16], 1), error(1));
        assert_eq!((mailbox.by_request.len(), mailbox.order.len()), (ERRORS_MAX, ERRORS_MAX));
        assert_eq!((mailbox.collect(([1; 16], 0)), mailbox.collect(([1; 16], 2))), (None, None));
        assert_eq!(mailbox.collect(([1; 16], 1)), Some(error(1)));
        assert_eq!(mailbox.collect(([2; 16], 1)), None);
    }

    #[test]
    fn collected_errors_can_be_collected_again() {
        let mut mailbox = ErrorMailbox::default();
        let error = |n: u64| ErrorWire::from(&Error::new(ErrorKind::Busy, n.to_string(), "full"));
        for n in 0..10_000 {
            mailbox.keep(([1; 16], n), error(n));
            assert_eq!(
                (mailbox.collect(([1; 16], n)), mailbox.collect(([1; 16], n))),
                (Some(error(n)), Some(error(n)))
            );
        }
        assert_eq!((mailbox.by_request.len(), mailbox.order.len(), mailbox.collected.len()), (0, 0, COLLECTED_MAX));
        assert!(mailbox.by_request.capacity() < 64 && mailbox.collect(([1; 16], 0)).is_none());
    }
}
