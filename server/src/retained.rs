//! Answers that are kept because their strikes asked for it, so that their fragments can be struck again.
//!
//! Accounting. An answer is kept from before it is sent until the first of these: somebody gives it back (`release`), its time is over
//! (`times.kept_s`, which no use prolongs), or `answers.kept_max` younger ones are kept. Nobody is refused for want of room here: the
//! oldest goes. It belongs to the service, not to a connection: all clients of a service are of one user, and a command that struck
//! has ended when the next one strikes a fragment. What it holds is counted by `Kept::bytes`, and the version of the object
//! that it is an answer of, which may by then be replaced; strikes that were admitted hold on to both.

use shatter_engine::object::ServedObject;
use shatter_fracture::pipeline::RetainedFragments;
use shatter_proto::request::{RetainedFragment, unknown_handle};
use shatter_proto::{Error, ErrorKind};
use std::collections::VecDeque;
use std::hash::{BuildHasher, RandomState};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Handles of one daemon follow each other from a random multiple of this on: those of an earlier daemon name nothing, and all are
/// whole numbers that JSON readers keep exact.
const RUN: u64 = 1 << 20;

/// What is struck when a fragment is.
pub type RetainedTarget = (Arc<dyn ServedObject>, Option<Arc<RetainedFragments>>);

/// The answers kept, the oldest first.
pub struct RetainedResults {
    kept: VecDeque<Entry>,
    next: u64,
    count_max: usize,
    time: Duration,
}

/// One of them.
struct Entry {
    handle: u64,
    name: String,
    object: Arc<dyn ServedObject>,
    kept: Arc<RetainedFragments>,
    bytes: u64,
    since: Instant,
}

/// Answers that are kept no longer. To drop them gives memory back, which takes a while.
#[must_use]
pub struct EvictedResults(Vec<Entry>);

impl EvictedResults {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl RetainedResults {
    /// None yet; at most `count_max`, each for no longer than `time`.
    pub fn new(count_max: usize, time: Duration) -> Self {
        let run = (RandomState::new().hash_one(RUN) & 0xffff_ffff).max(1);
        Self { kept: VecDeque::new(), next: run * RUN, count_max, time }
    }

    /// Whether any would be kept.
    pub fn keeps(&self) -> bool {
        self.count_max > 0
    }

    /// Keeps an answer of the object `name` from `now` on; its handle, and those that make room for it.
    pub fn keep(
        &mut self,
        name: &str,
        object: Arc<dyn ServedObject>,
        kept: RetainedFragments,
        now: Instant,
    ) -> (u64, EvictedResults) {
        let handle = self.next;
        self.next += 1;
        let bytes = kept.bytes() as u64;
        let entry = Entry { handle, name: name.to_owned(), object, kept: Arc::new(kept), bytes, since: now };
        self.kept.push_back(entry);
        let surplus = self.kept.len().saturating_sub(self.count_max);
        (handle, EvictedResults(self.kept.drain(..surplus).collect()))
    }

    /// What is struck when this fragment of an answer of the object `name` is.
    ///
    /// # Errors
    /// `unknown_handle`, `unknown_fragment`.
    pub fn target(&self, name: &str, origin: RetainedFragment, now: Instant) -> Result<RetainedTarget, Error> {
        let RetainedFragment { handle, fragment } = origin;
        let lives = |entry: &&Entry| entry.handle == handle && now.saturating_duration_since(entry.since) < self.time;
        let entry = self.kept.iter().find(lives).ok_or_else(|| unknown_handle(handle))?;
        if entry.name != name {
            let message = format!("handle {handle} is of an answer of `{}`, not of `{name}`", entry.name);
            return Err(Error::new(ErrorKind::UnknownHandle, handle.to_string(), message));
        }
        let count = entry.kept.fragments();
        if fragment >= count {
            let message = format!("fragment {fragment}: the answer has {count}, counted from 0");
            return Err(Error::new(ErrorKind::UnknownFragment, fragment.to_string(), message));
        }
        Ok((entry.object.clone(), Some(entry.kept.clone())))
    }

    /// Gives one back.
    ///
    /// # Errors
    /// `unknown_handle`.
    pub fn release(&mut self, handle: u64) -> Result<EvictedResults, Error> {
        let place = self.kept.iter().position(|entry| entry.handle == handle);
        let entry = place.and_then(|place| self.kept.remove(place)).ok_or_else(|| unknown_handle(handle))?;
        Ok(EvictedResults(vec![entry]))
    }

    /// Those whose time is over at `now`.
    pub fn expire(&mut self, now: Instant) -> EvictedResults {
        let over = |entry: &Entry| now.saturating_duration_since(entry.since) >= self.time;
        let count = self.kept.iter().take_while(|entry| over(entry)).count();
        EvictedResults(self.kept.drain(..count).collect())
    }

    /// How many are kept, and the bytes that they hold.
    pub fn extent(&self) -> (u64, u64) {
        (self.kept.len() as u64, self.kept.iter().map(|entry| entry.bytes).sum())
    }
}
