//! A strike under way.

use crate::answer::nanoseconds;
use crate::border::{border, end, given};
use crate::refusal::{Refusal, text};
use crate::{Broken, Code};
use shatter_client::{Deadline, Poll};
use std::ffi::c_char;
use std::mem::MaybeUninit;

/// A strike under way. One thread at a time.
pub struct Ticket(pub(crate) shatter_client::Ticket);

/// What a strike does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum State {
    /// It is on its way to the daemon, or among those that wait.
    Waiting = 0,
    /// It is being computed.
    Computing = 1,
    /// It was answered, refused or given up: `shatter_ticket_poll` tells.
    Ended = 2,
}

/// How far a strike is.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Progress {
    /// What it does.
    pub state: State,
    /// Zero.
    pub reserved: u32,
    /// Time since the daemon took it in, ns; zero unless it is being computed.
    pub age_ns: u64,
    /// The stage that computes, or computed last; empty unless it is being computed.
    pub stage: [c_char; 32],
}

/// Looks for the answer; never blocks. Once a frame is often enough. Returns `SHATTER_CODE_OK` with `broken` NULL while there is none;
/// with an answer, which is handed out once: free it with `shatter_broken_free`.
///
/// Codes: the refusal of the service; `lost` if the daemon went away; `bad_answer` if the answer fails the checks. After an answer or
/// an error the ticket is spent (`cancelled`), except after `busy` at `answers`: free answers that you hold, and poll again.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_ticket_poll(
    ticket: Option<&mut Ticket>,
    broken: Option<&mut MaybeUninit<Option<Box<Broken>>>>,
    refusal: Option<&mut MaybeUninit<Refusal>>,
) -> Code {
    border(refusal, || {
        let broken = given("broken", broken)?;
        broken.write(None);
        if let Poll::Ready(answer) = given("ticket", ticket)?.0.poll()? {
            broken.write(Some(Box::new(Broken(answer))));
        }
        Ok(())
    })
}

/// Waits for the answer. On `late` the ticket is still good: wait again, or free it to cancel the strike. Otherwise as
/// `shatter_ticket_poll`; `broken` is NULL where it failed.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_ticket_wait(
    ticket: Option<&mut Ticket>,
    timeout_ms: u64,
    broken: Option<&mut MaybeUninit<Option<Box<Broken>>>>,
    refusal: Option<&mut MaybeUninit<Refusal>>,
) -> Code {
    border(refusal, || {
        let broken = given("broken", broken)?;
        broken.write(None);
        broken.write(Some(Box::new(Broken(given("ticket", ticket)?.0.wait(Deadline::ms(timeout_ms))?))));
        Ok(())
    })
}

/// How far the strike is, as the daemon said last; never blocks: each call takes in the reply to the one before, and asks again.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_ticket_progress(
    ticket: Option<&mut Ticket>,
    progress: Option<&mut MaybeUninit<Progress>>,
    refusal: Option<&mut MaybeUninit<Refusal>>,
) -> Code {
    border(refusal, || {
        let (ticket, place) = (given("ticket", ticket)?, given("progress", progress)?);
        place.write(ticket.0.progress().into());
        Ok(())
    })
}

/// Frees a ticket and cancels its strike if that is still under way; NULL is fine.
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
