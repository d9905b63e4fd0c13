//! Results that clients asked the daemon to retain, so that their fragments can be struck again.
//!
//! A result is retained before it is sent. It is removed when a client releases it (`release`), when `times.kept_s` has passed (use
//! does not extend it), or when `results.kept_max` newer results are retained. A full store rejects no result: it evicts the oldest
//! one.
//!
//! A retained result belongs to the service, not to a connection. All clients of a service belong to one user, and the command that
//! struck the object has ended when the next command strikes a fragment.
//!
//! A retained result also holds its version of the object, which may have been replaced since. Accepted requests keep both alive.
//! `RetainedFragments::bytes` counts the memory of the result.

use shatter_engine::object::ServedObject;
use shatter_fracture::pipeline::RetainedFragments;
use shatter_proto::request::{RetainedFragment, unknown_handle};
use shatter_proto::text::counted;
use shatter_proto::{Error, ErrorKind};
use std::collections::VecDeque;
use std::hash::{BuildHasher, RandomState};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Handles of a daemon count up from a random multiple of this number, so that handles of an earlier daemon are unknown to it. They
/// stay integers that JSON readers represent exactly.
const RUN: u64 = 1 << 20;

/// Target of a request: an object, and the retained result if the target is a fragment.
pub type RetainedTarget = (Arc<dyn ServedObject>, Option<Arc<RetainedFragments>>);

/// Retained results, the oldest first.
pub struct RetainedResults {
    kept: VecDeque<Entry>,
    next: u64,
    count_max: usize,
    time: Duration,
}

/// Retained result.
struct Entry {
    handle: u64,
    name: String,
    object: Arc<dyn ServedObject>,
    kept: Arc<RetainedFragments>,
    bytes: u64,
    since: Instant,
}

/// Results that are no longer retained. Dropping them frees their memory, which takes a while.
#[must_use]
pub struct EvictedResults(Vec<Entry>);

impl EvictedResults {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl RetainedResults {
    /// Creates an empty store of at most `count_max` results, each for no longer than `time`.
    pub fn new(count_max: usize, time: Duration) -> Self {
        let run = (RandomState::new().hash_one(RUN) & 0xffff_ffff).max(1);
        Self { kept: VecDeque::new(), next: run * RUN, count_max, time }
    }

    /// Whether the store retains anything at all.
    pub fn allows_keeping(&self) -> bool {
        self.count_max > 0
    }

    /// Retains a result of the object `name` from `now` on; returns its handle, and the results that it evicts.
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

    /// Target of a request that strikes this fragment of a result of the object `name`.
    ///
    /// # Errors
    /// `unknown_handle`, `unknown_fragment`.
    pub fn target(&self, name: &str, origin: RetainedFragment, now: Instant) -> Result<RetainedTarget, Error> {
        let RetainedFragment { handle, fragment } = origin;
        let lives = |entry: &&Entry| entry.handle == handle && now.saturating_duration_since(entry.since) < self.time;
        let entry = self.kept.iter().find(lives).ok_or_else(|| unknown_handle(handle))?;
        if entry.name != name {
            let message = format!(
                "handle {handle} belongs to a result of `{}`, not of `{name}`; name the object that it came from",
                entry.name
            );
            return Err(Error::new(ErrorKind::UnknownHandle, handle.to_string(), message));
        }
        let count = entry.kept.fragments();
        if fragment >= count {
            let message = format!(
                "fragment {fragment} does not exist: the result has {}, counted from 0",
                counted(count.into(), "fragment")
            );
            return Err(Error::new(ErrorKind::UnknownFragment, fragment.to_string(), message));
        }
        Ok((entry.object.clone(), Some(entry.kept.clone())))
    }

    /// Releases a result.
    ///
    /// # Errors
    /// `unknown_handle`.
    pub fn release(&mut self, handle: u64) -> Result<EvictedResults, Error> {
        let place = self.kept.iter().position(|entry| entry.handle == handle);
        let entry = place.and_then(|place| self.kept.remove(place)).ok_or_else(|| unknown_handle(handle))?;
        Ok(EvictedResults(vec![entry]))
    }

    /// Evicts the results whose time is over at `now`.
    pub fn expire(&mut self, now: Instant) -> EvictedResults {
        let over = |entry: &Entry| now.saturating_duration_since(entry.since) >= self.time;
        let count = self.kept.iter().take_while(|entry| over(entry)).count();
        EvictedResults(self.kept.drain(..count).collect())
    }

    /// Number of retained results, and their memory in bytes.
    pub fn extent(&self) -> (u64, u64) {
        (self.kept.len() as u64, self.kept.iter().map(|entry| entry.bytes).sum())
    }
}
