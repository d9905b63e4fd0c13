//! Requests of a connection by sequence, and the one that a release follows.

use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Requests that were sent. Sequences are in the order of sending, whichever threads send.
#[derive(Clone, Default)]
pub(crate) struct SentRequests(Arc<Mutex<Sequences>>);

#[derive(Default)]
struct Sequences {
    /// That of the request sent last; zero: none was.
    last: u64,
    /// Those of requests that are under way.
    open: BTreeSet<u64>,
    /// The highest one of which the daemon is known to have received the request.
    arrived: u64,
}

/// A request that is being sent.
pub(crate) struct NextRequest<'a> {
    pub sequence: u64,
    sequences: MutexGuard<'a, Sequences>,
    all: &'a SentRequests,
}

/// A request under way. Dropping it ends the request.
pub(crate) struct SentRequest {
    pub sequence: u64,
    all: SentRequests,
}

impl SentRequests {
    /// The request to be sent next. Until it is dropped, other threads wait with theirs.
    pub fn next(&self) -> NextRequest<'_> {
        let sequences = self.lock();
        NextRequest { sequence: sequences.last + 1, sequences, all: self }
    }

    /// Sequence of the request after which a release has its turn; zero: none. Canceled requests do not count: one that is canceled
    /// before the daemon looked for it never arrives.
    pub fn followed(&self) -> u64 {
        let sequences = self.lock();
        sequences.open.last().copied().unwrap_or(0).max(sequences.arrived)
    }

    fn lock(&self) -> MutexGuard<'_, Sequences> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl NextRequest<'_> {
    /// Counts the request as sent.
    pub fn sent(mut self) -> SentRequest {
        self.sequences.last = self.sequence;
        self.sequences.open.insert(self.sequence);
        SentRequest { sequence: self.sequence, all: self.all.clone() }
    }
}

impl SentRequest {
    /// Notes that the daemon has received the request.
    pub fn note_arrival(&self) {
        let mut sequences = self.all.lock();
        sequences.arrived = sequences.arrived.max(self.sequence);
    }
}

impl Drop for SentRequest {
    fn drop(&mut self) {
        self.all.lock().open.remove(&self.sequence);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_release_follows_what_arrives() {
        let all = SentRequests::default();
        let send = || all.next().sent();
        assert_eq!(all.followed(), 0);
        let (first, second, third) = (send(), send(), send());
        assert_eq!(all.followed(), 3);
        drop(third);
        assert_eq!(all.followed(), 2);
        first.note_arrival();
        drop(second);
        assert_eq!(all.followed(), 1);
        drop(first);
        assert_eq!((all.followed(), send().sequence), (1, 4));
    }
}
