//! A strike under way.

use crate::control;
use crate::link::{Link, PendingQuestion, PendingStrike, Pulse, receive_failed};
use crate::unmapped::unmapped;
use crate::{Broken, Deadline};
use shatter_proto::answer::STAGES;
use shatter_proto::control::{ProgressRow, Question};
use shatter_proto::convention::Convention;
use shatter_proto::refusal::RefusalWire;
use shatter_proto::request::Strike;
use shatter_proto::{Kind, Refusal};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A reason that does not come within this time does not come.
const VERDICT: Duration = Duration::from_secs(2);

/// What [`Ticket::poll`] finds.
pub enum Poll {
    /// Not yet.
    Pending,
    /// The answer. It is handed out once.
    Ready(Broken),
}

/// How far a strike is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
pub struct Ticket {
    progress: Progress,
    question: Option<PendingQuestion>,
    link: Arc<Link>,
    convention: Convention,
    sequence: u64,
    sent: Instant,
    pulse: Pulse,
    state: State,
}

enum State {
    /// The daemon has it.
    Struck(PendingStrike),
    /// The daemon closed it without an answer, and is asked why.
    Closed { since: Instant, question: Option<PendingQuestion> },
    /// Answered or refused.
    Done,
}

impl Ticket {
    pub(crate) fn send(link: Arc<Link>, strike: &Strike) -> Result<Self, Refusal> {
        let wire = strike.wire(link.listener(), 0)?;
        let sent = Instant::now();
        let (pending, sequence) = link.send(wire)?;
        let (progress, question, pulse) = (Progress::Waiting, None, Pulse::now());
        let (convention, state) = (strike.convention, State::Struck(pending));
        Ok(Self { progress, question, link, convention, sequence, sent, pulse, state })
    }

    pub(crate) fn link(&self) -> &Arc<Link> {
        &self.link
    }

    /// Looks for the answer; never blocks. Once a frame is often enough.
    ///
    /// Errors: the refusal of the service; `lost` if the daemon went away; `bad_answer` if an answer fails the checks.
    /// After an answer or an error the ticket is spent and only says so.
    pub fn poll(&mut self) -> Result<Poll, Refusal> {
        let found = match &mut self.state {
            State::Done => return Err(Refusal::new(Kind::Cancelled, "ticket", "the ticket is spent")),
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
            Err(refusal) if refusal.kind == Kind::Busy && refusal.at == "answers" => Err(refusal),
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
            None => self.question = self.link.ask(Question::Progress(self.sequence)).ok(),
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
    pub fn wait(&mut self, deadline: Deadline) -> Result<Broken, Refusal> {
        loop {
            if let Poll::Ready(broken) = self.poll()? {
                return Ok(broken);
            }
            if deadline.passed() {
                let message = format!("no answer after {:.1} s", self.sent.elapsed().as_secs_f64());
                return Err(Refusal::new(Kind::Late, "ticket", message));
            }
            self.link.doze(deadline);
        }
    }

    fn answer(
        link: &Link,
        pending: &PendingStrike,
        request: (u64, Convention),
        sent: Instant,
    ) -> Result<Found, Refusal> {
        // Asked before receiving: an answer sent between the two calls is then not overlooked.
        let connected = pending.is_connected();
        match pending.receive().map_err(receive_failed)? {
            Some(answer) => Ok(Found::Answer(Broken::new(answer, request, sent.elapsed(), link.hold())?)),
            None if connected => Ok(Found::Nothing),
            None => Ok(Found::Closed),
        }
    }

    /// Fetches the reason from the control service.
    fn verdict(
        link: &Link,
        sequence: u64,
        since: Instant,
        question: &mut Option<PendingQuestion>,
    ) -> Result<Found, Refusal> {
        let overdue = since.elapsed() > VERDICT;
        let silent = || Refusal::new(Kind::Failed, "strike", "the service closed the strike and gave no reason");
        match question {
            None => match link.ask(Question::Verdict(sequence)) {
                Ok(pending) => *question = Some(pending),
                Err(refusal) if refusal.kind == Kind::Busy && !overdue => {}
                Err(refusal) => return Err(refusal),
            },
            Some(pending) => match control::poll::<RefusalWire>(link, pending) {
                Ok(None) => {}
                Ok(Some((rows, _))) => {
                    let verdict = rows.first().map_or_else(|| unmapped(link.lost(), link), Refusal::from);
                    // Whoever asks has not given it up: the transport took this client for one that died.
                    return Err(if verdict.kind == Kind::Cancelled { link.mislaid() } else { verdict });
                }
                Err(refusal) if refusal.kind == Kind::Busy && !overdue => *question = None,
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
    Answer(Broken),
    Closed,
}
