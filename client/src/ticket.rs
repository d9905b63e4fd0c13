//! A request under way.

use crate::connection::{Connection, LivenessCheck, PendingControlRequest, PendingRequest, receive_failed};
use crate::control;
use crate::sent_requests::SentRequest;
use crate::{Deadline, FractureResult};
use shatter_proto::control::{ControlRequest, ProgressRow};
use shatter_proto::convention::Convention;
use shatter_proto::error::ErrorWire;
use shatter_proto::request::Request;
use shatter_proto::result::StageKind;
use shatter_proto::{Error, ErrorKind};
use shatter_transport::workarounds::dead_clients::is_evicted;
use shatter_transport::workarounds::forked_processes::OwnedByProcess;
use shatter_transport::workarounds::unclear_errors::explain_lost;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Time to wait for the daemon's reason after it closed a request without a result.
const REASON_WAIT: Duration = Duration::from_secs(2);

/// Outcome of [`Ticket::poll`].
#[must_use = "a result is handed out once"]
pub enum Poll {
    /// The request is still under way.
    Pending,
    /// The result. It is handed out once.
    Ready(FractureResult),
}

/// Progress of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Progress {
    /// On its way to the daemon, or in its queue.
    Waiting,
    /// Being computed.
    Computing {
        /// The stage that computes, or that computed last.
        stage: StageKind,
        /// Time since the daemon admitted the request.
        age: Duration,
    },
    /// Complete, refused or canceled: [`Ticket::poll`] tells.
    Ended,
}

/// A request under way. Dropping it cancels the request.
#[must_use = "dropping a ticket cancels its request"]
pub struct Ticket {
    progress: Progress,
    progress_request: Option<PendingControlRequest>,
    connection: Arc<Connection>,
    convention: Convention,
    request: SentRequest,
    sent: Instant,
    liveness: LivenessCheck,
    state: State,
}

enum State {
    /// The daemon has it.
    Sent(PendingRequest),
    /// The daemon closed it without a result, and is asked for the reason.
    Closed { since: Instant, reason: Option<PendingControlRequest> },
    /// The result or an error was handed out.
    Done,
}

impl Ticket {
    pub(crate) fn send(connection: Arc<Connection>, request: &Request) -> Result<Self, Error> {
        let wire = request.wire(connection.listener())?;
        let sent = Instant::now();
        let (pending, sent_request) = connection.send(wire)?;
        let (progress, progress_request, liveness) = (Progress::Waiting, None, LivenessCheck::now());
        let (convention, state) = (request.convention, State::Sent(pending));
        Ok(Self { progress, progress_request, connection, convention, request: sent_request, sent, liveness, state })
    }

    pub(crate) fn connection(&self) -> &Arc<Connection> {
        &self.connection
    }

    /// Looks for the result; never blocks. Once a frame is often enough.
    ///
    /// # Errors
    /// The error of the service; `lost` if the daemon went away; `bad_result` if a result fails the checks; `busy` at `results` if
    /// too many results are held: drop some and poll again. After any other error, and after the result, the ticket is spent and
    /// only returns `ticket_spent`.
    pub fn poll(&mut self) -> Result<Poll, Error> {
        self.connection.check_process()?;
        let found = match &mut self.state {
            State::Done => return Err(spent()),
            State::Sent(pending) => {
                Self::receive(&self.connection, pending, (self.request.sequence, self.convention), self.sent)
            }
            State::Closed { since, reason } => {
                Self::ask_reason(&self.connection, self.request.sequence, *since, reason)
            }
        };
        match found {
            Ok(Found::Nothing) => match self.connection.check_alive(&mut self.liveness) {
                Ok(()) => Ok(Poll::Pending),
                Err(lost) => {
                    self.state = State::Done;
                    Err(lost)
                }
            },
            Ok(Found::Result(result)) => {
                self.request.note_arrival();
                self.state = State::Done;
                Ok(Poll::Ready(result))
            }
            Ok(Found::Closed) => {
                self.request.note_arrival();
                self.state = State::Closed { since: Instant::now(), reason: None };
                self.poll()
            }
            // Results that are held elsewhere are in the way: the request is still good.
            Err(error) if error.kind == ErrorKind::Busy && error.at == "results" => Err(error),
            Err(error) => {
                self.state = State::Done;
                Err(error)
            }
        }
    }

    /// Progress of the request, as the daemon reported it last; never blocks. For a progress bar, once a frame: each call reads the reply to
    /// the call before, and asks again.
    pub fn progress(&mut self) -> Progress {
        if matches!(self.state, State::Done) || self.connection.check_process().is_err() {
            self.progress_request = None;
            return Progress::Ended;
        }
        match self.progress_request.take() {
            None => self.progress_request = self.connection.ask(ControlRequest::Progress(self.request.sequence)).ok(),
            Some(request) => match control::poll::<ProgressRow>(&self.connection, &request) {
                Ok(None) => self.progress_request = Some(request),
                Ok(Some((rows, _))) => self.progress = rows.first().map_or(Progress::Ended, progress),
                // The next call asks again.
                Err(_) => {}
            },
        }
        self.progress
    }

    /// Waits for the result. After `late` the ticket is still good: wait again, or drop it to cancel.
    ///
    /// # Errors
    /// `late` at `ticket` after the deadline, and those of [`Self::poll`].
    pub fn wait(&mut self, deadline: Deadline) -> Result<FractureResult, Error> {
        loop {
            if let Poll::Ready(result) = self.poll()? {
                return Ok(result);
            }
            if deadline.passed() {
                let message = format!("no result after {:.1} s", self.sent.elapsed().as_secs_f64());
                return Err(Error::new(ErrorKind::Late, "ticket", message));
            }
            self.connection.wait(deadline);
        }
    }

    fn receive(
        connection: &Connection,
        pending: &PendingRequest,
        request: (u64, Convention),
        sent: Instant,
    ) -> Result<Found, Error> {
        // Tested before receiving: a result sent between the two calls is then not overlooked.
        let is_connected = pending.is_connected();
        match pending.receive().map_err(receive_failed)? {
            Some(loan) => {
                let loan = OwnedByProcess::new(loan);
                let result = FractureResult::new(loan, request, sent.elapsed(), connection.count_loan())?;
                Ok(Found::Result(result))
            }
            None if is_connected => Ok(Found::Nothing),
            None => Ok(Found::Closed),
        }
    }

    /// Fetches the reason from the control service.
    fn ask_reason(
        connection: &Connection,
        sequence: u64,
        since: Instant,
        reason: &mut Option<PendingControlRequest>,
    ) -> Result<Found, Error> {
        let is_overdue = since.elapsed() > REASON_WAIT;
        match reason {
            None => match connection.ask(ControlRequest::RequestError(sequence)) {
                Ok(pending) => *reason = Some(pending),
                Err(error) if error.kind == ErrorKind::Busy && !is_overdue => {}
                Err(error) => return Err(error),
            },
            Some(pending) => match control::poll::<ErrorWire>(connection, pending) {
                Ok(None) => {}
                Ok(Some((rows, _))) => {
                    let lost = || explain_lost(connection.lost(), || connection.daemon_lives());
                    let error = rows.first().map_or_else(lost, Error::from);
                    return Err(if is_evicted(&error) { connection.evicted() } else { error });
                }
                Err(error) if error.kind == ErrorKind::Busy && !is_overdue => *reason = None,
                Err(error) => return Err(error),
            },
        }
        if is_overdue {
            let message = "the service closed the request and gave no reason";
            return Err(Error::new(ErrorKind::Failed, "strike", message));
        }
        Ok(Found::Nothing)
    }
}

fn spent() -> Error {
    let message = "the ticket has already handed out its result or its error; send the request again";
    Error::new(ErrorKind::TicketSpent, "ticket", message)
}

/// A row that a daemon of a later version may have filled differently counts as computing.
fn progress(row: &ProgressRow) -> Progress {
    match row.state {
        1 => Progress::Waiting,
        _ => {
            let (stage, age) = (StageKind::from_code(row.stage), Duration::from_nanos(row.age_ns));
            Progress::Computing { stage, age }
        }
    }
}

enum Found {
    Nothing,
    Result(FractureResult),
    Closed,
}
