//! Pools of responses: growth panics, a failed loan stays counted, a full buffer blocks.
//!
//! **Symptom.** (1) With `override_response_preallocation` and a growing pool (`PowerOfTwo`, `BestFit`), an index is out of bounds
//! (`segment_state.rs`) as soon as the pool grows. (2) A failed loan still counts against `max_loaned_responses_per_request`. With
//! a limit of 1 the request can never get a response, not even an error. (3) Without overflow and with the default backpressure
//! strategy, `send` blocks while it holds the port. All threads of the server then stop, even for a client that was killed. (4)
//! Channels are reused. A late response enters the buffer of a newer request. If that buffer has one slot, the newer request's own
//! response is lost, and `send` still returns success.
//!
//! **Reproduction** (iceoryx2 0.10.0). (1) The fifth loan from a pool of two. (2) One `OutOfMemory`, then `ExceedsMaxLoans` at
//! every further loan of the request. (3) A buffer of two, three responses, a client that reads none. (4) A client with two active
//! requests uses the first channel again for its sixth request. The first request was abandoned, and its response arrives then.
//!
//! **Upstream.** (4) is issue 1905, closed, and still reproducible in 0.10.0. For the others no issue is known.
//!
//! **Delete.** The constants here; ports then take the defaults of the transport. [`is_awaited`] before a send, once (4) is fixed.

use crate::Ipc;
use iceoryx2::active_request::ActiveRequest;
use iceoryx2::prelude::{AllocationStrategy, BackpressureStrategy, ZeroCopySend};
use std::fmt::Debug;

/// One segment of equal buckets, whose exhaustion is an error.
pub const ALLOCATION: AllocationStrategy = AllocationStrategy::Static;

/// Loans per request; more than one, because iceoryx2 never decrements the count after a failed loan.
pub const LOANS_PER_REQUEST: usize = 4;

/// A response for which the buffer has no space is dropped, so only the client that does not read is affected.
pub const BACKPRESSURE: BackpressureStrategy = BackpressureStrategy::DiscardData;

/// Responses that a request's channel holds: its own, and a late one of the request that had the channel before.
pub const BUFFER: usize = 2;

/// True if the client still waits for the response to `request`.
///
/// Called right before every send: channels are reused, and a late result would block another one.
pub fn is_awaited<Request, Response, Header>(request: &ActiveRequest<Ipc, Request, (), [Response], Header>) -> bool
where
    Request: Debug + ZeroCopySend,
    Response: Debug + ZeroCopySend,
    Header: Debug + ZeroCopySend,
{
    request.is_connected()
}
