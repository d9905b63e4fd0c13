//! A strike under way.

use crate::connection::{Connection, LivenessCheck, PendingControlRequest, PendingRequest, receive_failed};
use crate::control;
use crate::{Deadline, FractureResult};
use shatter_proto::control::{ControlRequest, ProgressRow};
use shatter_proto::convention::Convention;
use shatter_proto::error::ErrorWire;
use shatter_proto::request::Request;
use shatter_proto::result::STAGES;
use shatter_proto::{Error, ErrorKind};
use shatter_transport::workarounds::dead_clients::is_evicted;
use shatter_transport::workarounds::unclear_errors::unmapped;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A reason that does not come within this time does not come.
const VERDICT: Duration = Duration::from_secs(2);

/// What [`Ticket::poll`] finds.
#[must_use = "an answer is handed out once"]
pub enum Poll {
    /// Not yet.
    Pending,
    /// The answer. It is handed out once.
    Ready(FractureResult),
}

/// How far a strike is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Progress {
    /// On its way to the daemon, or among those that wait.
    Waiting,
    /// In this stage, since so long with the daemon.
    Computing {
        /// Name of the stage.
        stage: &'static str,
        /// Since the daemon took it in.
        age: Duration,
    },
    /// Answered, refused or given up: [`Ticket::poll`] tells.
    Ended,
}

/// A strike under way. Dropping it cancels the strike.
#[must_use = "dropping a ticket cancels its strike"]
pub struct Ticket {
    progress: Progress,
    question: Option<PendingControlRequest>,
    link: Arc<Connection>,
    convention: Convention,
    sequence: u64,
    sent: Instant,
    pulse: LivenessCheck,
    state: State,
}

enum State {
    /// The daemon has it.
    Struck(PendingRequest),
    /// The daemon closed it without an answer, and is asked why.
    Closed { since: Instant, question: Option<PendingControlRequest> },
    /// Answered or refused.
    Done,
}

impl Ticket {
    pub(crate) fn send(link: Arc<Connection>, strike: &Request) -> Result<Self, Error> {
        let wire = strike.wire(link.listener(), 0)?;
        let sent = Instant::now();
        let (pending, sequence) = link.send(wire)?;
        let (progress, question, pulse) = (Progress::Waiting, None, LivenessCheck::now());
        let (convention, state) = (strike.convention, State::Struck(pending));
        Ok(Self { progress, question, link, convention, sequence, sent, pulse, state })
    }

    pub(crate) fn link(&self) -> &Arc<Connection> {
        &self.link
    }

    /// Looks for the answer; never blocks. Once a frame is often enough.
    ///
    /// # Errors
    /// The refusal of the service; `lost` if the daemon went away; `bad_answer` if an answer fails the checks.
    /// After an answer or an error the ticket is spent and only says so.
    pub fn poll(&mut self) -> Result<Poll, Error> {
        let found = match &mut self.state {
            State::Done => return Err(Error::new(ErrorKind::Cancelled, "ticket", "the ticket is spent")),
            State::Struck(pending) => Self::answer(&self.link, pending, (self.sequence, self.convention), self.sent),
            State::Closed { since, question } => Self::verdict(&self.link, self.sequence, *since, question),
        };
        match found {
            Ok(Found::Nothing) => match self.link.feel(&mut self.pulse) {
                Ok(()) => Ok(Poll::Pending),
                Err(lost) => {
                    self.state = State::Done;
                    Err(lost)
                }
            },
            Ok(Found::Answer(broken)) => {
                self.state = State::Done;
                Ok(Poll::Ready(broken))
            }
            Ok(Found::Closed) => {
                self.state = State::Closed { since: Instant::now(), question: None };
                self.poll()
            }
            // Answers held elsewhere are in the way: the strike is still good.
            Err(refusal) if refusal.kind == ErrorKind::Busy && refusal.at == "answers" => Err(refusal),
            Err(refusal) => {
                self.state = State::Done;
                Err(refusal)
            }
        }
    }

    /// How far the strike is, as the daemon said last; never blocks: each call takes in what it replied to the one before, and asks
    /// again. For a bar under long strikes, once a frame. What cannot be asked now is asked by the next call.
    pub fn progress(&mut self) -> Progress {
        if matches!(self.state, State::Done) {
            self.question = None;
            return Progress::Ended;
        }
        match self.question.take() {
            None => self.question = self.link.ask(ControlRequest::Progress(self.sequence)).ok(),
            Some(question) => match control::poll::<ProgressRow>(&self.link, &question) {
                Ok(None) => self.question = Some(question),
                Ok(Some((rows, _))) => self.progress = rows.first().map_or(Progress::Ended, said),
                // Asked again by the next call.
                Err(_) => {}
            },
        }
        self.progress
    }

    /// Waits for the answer. On `late` the ticket is still good: wait again, or drop it to cancel.
    ///
    /// # Errors
    /// `late` at `ticket` after the deadline, and those of [`Self::poll`].
    pub fn wait(&mut self, deadline: Deadline) -> Result<FractureResult, Error> {
        loop {
            if let Poll::Ready(broken) = self.poll()? {
                return Ok(broken);
            }
            if deadline.passed() {
                let message = format!("no answer after {:.1} s", self.sent.elapsed().as_secs_f64());
                return Err(Error::new(ErrorKind::Late, "ticket", message));
            }
            self.link.wait(deadline);
        }
    }

    fn answer(
        link: &Connection,
        pending: &PendingRequest,
        request: (u64, Convention),
        sent: Instant,
    ) -> Result<Found, Error> {
        // Asked before receiving: an answer sent between the two calls is then not overlooked.
        let connected = pending.is_connected();
        match pending.receive().map_err(receive_failed)? {
            Some(answer) => Ok(Found::Answer(FractureResult::new(answer, request, sent.elapsed(), link.count_loan())?)),
            None if connected => Ok(Found::Nothing),
            None => Ok(Found::Closed),
        }
    }

    /// Fetches the reason from the control service.
    fn verdict(
        link: &Connection,
        sequence: u64,
        since: Instant,
        question: &mut Option<PendingControlRequest>,
    ) -> Result<Found, Error> {
        let overdue = since.elapsed() > VERDICT;
        let silent = || Error::new(ErrorKind::Failed, "strike", "the service closed the strike and gave no reason");
        match question {
            None => match link.ask(ControlRequest::Verdict(sequence)) {
                Ok(pending) => *question = Some(pending),
                Err(refusal) if refusal.kind == ErrorKind::Busy && !overdue => {}
                Err(refusal) => return Err(refusal),
            },
            Some(pending) => match control::poll::<ErrorWire>(link, pending) {
                Ok(None) => {}
                Ok(Some((rows, _))) => {
                    let verdict =
                        rows.first().map_or_else(|| unmapped(link.lost(), || link.daemon_lives()), Error::from);
                    return Err(if is_evicted(&verdict) { link.evicted() } else { verdict });
                }
                Err(refusal) if refusal.kind == ErrorKind::Busy && !overdue => *question = None,
                Err(refusal) => return Err(refusal),
            },
        }
        if overdue { Err(silent()) } else { Ok(Found::Nothing) }
    }
}

/// A row that a daemon of a later version may have filled differently says that it computes.
fn said(row: &ProgressRow) -> Progress {
    match (row.state, STAGES.get(row.stage as usize)) {
        (1, _) => Progress::Waiting,
        (_, stage) => {
            Progress::Computing { stage: stage.copied().unwrap_or("unknown"), age: Duration::from_nanos(row.age_ns) }
        }
    }
}

enum Found {
    Nothing,
    Answer(FractureResult),
    Closed,
}
