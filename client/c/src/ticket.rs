//! Requests under way.

use crate::error::{ErrorRecord, text};
use crate::ffi_boundary::{end, ffi_boundary, given};
use crate::result_rows::nanoseconds;
use crate::{Code, FractureResult};
use shatter_client::{Deadline, Poll};
use std::ffi::c_char;
use std::mem::MaybeUninit;

/// A request under way. One thread may use it at a time.
pub struct Ticket(pub(crate) shatter_client::Ticket);

/// State of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum State {
    /// On its way to the daemon, or in its queue.
    Waiting = 0,
    /// Being computed.
    Computing = 1,
    /// Complete, refused or canceled: `shatter_ticket_poll` returns which.
    Ended = 2,
}

/// Progress of a request.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Progress {
    /// State of the request.
    pub state: State,
    /// Always zero.
    pub reserved: u32,
    /// Time since the daemon admitted the request, ns; zero unless it is being computed.
    pub age_ns: u64,
    /// Stage that computes, or that computed last; empty unless the request is being computed.
    pub stage: [c_char; 32],
}

/// Looks for the result; never blocks. Once a frame is often enough. Returns `SHATTER_CODE_OK` with `result` NULL while there is no result.
/// The result is handed out once: free it with `shatter_result_free`.
///
/// Codes: the error of the service; `lost` if the daemon went away; `bad_result` if the result fails the checks. After a result or an error
/// the ticket is spent (`ticket_spent`), except after `busy` at `results`: free results that you hold, and poll again.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_ticket_poll(
    ticket: Option<&mut Ticket>,
    result: Option<&mut MaybeUninit<Option<Box<FractureResult>>>>,
    error: Option<&mut MaybeUninit<ErrorRecord>>,
) -> Code {
    ffi_boundary(error, || {
        let result = given("result", result)?;
        result.write(None);
        if let Poll::Ready(ready) = given("ticket", ticket)?.0.poll()? {
            result.write(Some(Box::new(FractureResult(ready))));
        }
        Ok(())
    })
}

/// Waits for the result. After `late` the ticket is still valid: wait again, or free it to cancel the request. Otherwise as
/// `shatter_ticket_poll`; `result` is NULL after a failure.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_ticket_wait(
    ticket: Option<&mut Ticket>,
    timeout_ms: u64,
    result: Option<&mut MaybeUninit<Option<Box<FractureResult>>>>,
    error: Option<&mut MaybeUninit<ErrorRecord>>,
) -> Code {
    ffi_boundary(error, || {
        let result = given("result", result)?;
        result.write(None);
        result.write(Some(Box::new(FractureResult(given("ticket", ticket)?.0.wait(Deadline::ms(timeout_ms))?))));
        Ok(())
    })
}

/// Progress of the request, as the daemon reported it last; never blocks. Each call reads the reply to the call before, and asks again.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_ticket_progress(
    ticket: Option<&mut Ticket>,
    progress: Option<&mut MaybeUninit<Progress>>,
    error: Option<&mut MaybeUninit<ErrorRecord>>,
) -> Code {
    ffi_boundary(error, || {
        let (ticket, place) = (given("ticket", ticket)?, given("progress", progress)?);
        place.write(ticket.0.progress().into());
        Ok(())
    })
}

/// Frees a ticket and cancels its request if that is still under way; NULL is allowed.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_ticket_free(ticket: Option<Box<Ticket>>) {
    end(ticket);
}

impl From<shatter_client::Progress> for Progress {
    fn from(progress: shatter_client::Progress) -> Self {
        let (state, stage, age_ns) = match progress {
            shatter_client::Progress::Waiting => (State::Waiting, "", 0),
            shatter_client::Progress::Computing { stage, age } => (State::Computing, stage.name(), nanoseconds(age)),
            shatter_client::Progress::Ended => (State::Ended, "", 0),
            _ => (State::Computing, "", 0),
        };
        Self { state, reserved: 0, age_ns, stage: text(stage) }
    }
}
