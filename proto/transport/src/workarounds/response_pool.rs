//! Pools of responses: growth panics, a failed loan is counted for ever, a full buffer blocks.
//!
//! **Symptom.** (1) `override_response_preallocation` with a growing pool (`PowerOfTwo`, `BestFit`) ends in an index out of bounds
//! (`segment_state.rs`) as soon as the pool grows. (2) A loan that fails still counts against `max_loaned_responses_per_request`. With
//! a limit of 1 the request can never be answered, not even by an error. (3) Without overflow, and with the default backpressure
//! strategy, `send` blocks while it holds the port, so all threads of the server stop, even for a client that was killed. (4) Channels
//! are recycled: a late response lies in the buffer of a newer request, and with a buffer of one that request's own response is lost
//! while `send` returns success.
//!
//! **Reproduction** (iceoryx2 0.10.0). (1) The fifth loan of a pool of two. (2) One `OutOfMemory`, then `ExceedsMaxLoans` at every
//! further loan of the request. (3) A buffer of two, three responses, a client that reads none. (4) A client with two active
//! requests uses the first channel again at its sixth; the first request was abandoned, and is answered then.
//!
//! **Upstream.** (4) is issue 1905, closed, and still reproducible in 0.10.0. For the others no issue is known.
//!
//! **Delete.** The constants here; ports then take the defaults of the transport. [`is_awaited`] before a send, once (4) is mended.

use crate::Ipc;
use iceoryx2::active_request::ActiveRequest;
use iceoryx2::prelude::{AllocationStrategy, BackpressureStrategy, ZeroCopySend};
use std::fmt::Debug;

/// One segment of equal buckets, whose exhaustion is an error.
pub const ALLOCATION: AllocationStrategy = AllocationStrategy::Static;

/// Loans of one request: a failed one is never taken off the count, so there are several.
pub const LOANS_PER_REQUEST: usize = 4;

/// A response for which there is no room is dropped; the client that does not read is the one that goes without.
pub const BACKPRESSURE: BackpressureStrategy = BackpressureStrategy::DiscardData;

/// Responses that a request's channel holds: its own, and a late one of the request that had the channel before.
pub const BUFFER: usize = 2;

/// Whether the client still waits for the response to `request`. Asked right before every send.
pub fn is_awaited<Request, Response, Header>(request: &ActiveRequest<Ipc, Request, (), [Response], Header>) -> bool
where
    Request: Debug + ZeroCopySend,
    Response: Debug + ZeroCopySend,
    Header: Debug + ZeroCopySend,
{
    request.is_connected()
}
