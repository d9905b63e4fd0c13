//! One strike from its arrival to its end.

use super::forecast::WorkKind;
use crate::error_mailbox::RequestKey;
use crate::ipc::{ActiveImpactRequest, LoanedBuffer, loan};
use crate::retained::RetainedTarget;
use iceoryx2::response_mut::ResponseMut;
use shatter_engine::object::ServedObject;
use shatter_engine::stage_profiler::CurrentStage;
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::pipeline::RetainedFragments;
use shatter_proto::request::Request;
use shatter_proto::result::{Block, ResultHeader};
use shatter_proto::{Error, ErrorKind};
use shatter_transport::workarounds::response_pool::is_awaited;
use shatter_transport::{Ipc, failed};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::Instant;

/// A lent answer, written.
pub(super) type WrittenResult = ResponseMut<Ipc, [Block], ResultHeader>;

/// Why the daemon stopped a strike that computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum StopCause {
    /// Its deadline passed.
    Late,
    /// The daemon is ending.
    Ending,
}

impl StopCause {
    /// What its client is told.
    pub(super) fn refusal(self) -> Error {
        match self {
            Self::Late => Error::new(ErrorKind::Late, "deadline", "the deadline passed before the answer was ready"),
            Self::Ending => Error::new(ErrorKind::Stopping, "daemon", "the daemon is ending"),
        }
    }
}

/// What to do: a strike, and what it strikes.
pub(super) struct JobPayload {
    pub strike: Request,
    pub object: Arc<dyn ServedObject>,
    /// Where a fragment of an answer is struck: what was kept of that.
    pub kept: Option<Arc<RetainedFragments>>,
}

/// One strike. The request is shared by the thread that computes the answer and the one that looks whether somebody still
/// waits for it; both hold the lock for microseconds.
pub struct Job {
    request: Mutex<Option<ActiveImpactRequest>>,
    cargo: Mutex<Option<JobPayload>>,
    token: CancelToken,
    key: RequestKey,
    arrived: Instant,
    /// The stage that it is in.
    stage: CurrentStage,
    /// What kind of work it is, once it is understood.
    work: WorkKind,
    /// Why it was stopped while it computed.
    stopped: OnceLock<StopCause>,
}

impl Job {
    /// A strike that arrived now from the client with this listener.
    pub(super) fn new(request: ActiveImpactRequest, listener: [u8; 16], sequence: u64) -> Self {
        Self {
            request: Mutex::new(Some(request)),
            cargo: Mutex::new(None),
            token: CancelToken::default(),
            key: (listener, sequence),
            arrived: Instant::now(),
            stage: CurrentStage::default(),
            work: WorkKind::default(),
            stopped: OnceLock::new(),
        }
    }

    /// What to do, once it is understood.
    pub(super) fn place(&mut self, strike: Request, (object, kept): RetainedTarget) {
        self.work = WorkKind::of(&strike);
        self.cargo = Mutex::new(Some(JobPayload { strike, object, kept }));
    }

    /// What to do; handed out once, so that the object is held no longer than it is struck.
    pub(super) fn unload(&self) -> Result<JobPayload, Error> {
        let missing = || Error::new(ErrorKind::Failed, "queue", "a strike was queued before it was understood");
        self.cargo.lock().unwrap_or_else(PoisonError::into_inner).take().ok_or_else(missing)
    }

    /// Names the strike to its client.
    pub(super) fn key(&self) -> RequestKey {
        self.key
    }

    /// What kind of work it is.
    pub(super) fn work(&self) -> &WorkKind {
        &self.work
    }

    /// Polled by the stages.
    pub(super) fn token(&self) -> &CancelToken {
        &self.token
    }

    /// The stage that it is in.
    pub(super) fn stage(&self) -> &CurrentStage {
        &self.stage
    }

    /// When it arrived.
    pub fn arrived(&self) -> Instant {
        self.arrived
    }

    fn request(&self) -> MutexGuard<'_, Option<ActiveImpactRequest>> {
        self.request.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Asks it to stop at its next checkpoint.
    pub(super) fn cancel(&self) {
        self.token.cancel();
    }

    /// Asks it to stop at its next checkpoint, and why.
    pub(super) fn stop(&self, why: StopCause) {
        self.stopped.get_or_init(|| why);
        self.cancel();
    }

    /// Why it was asked to stop.
    pub(super) fn stopped(&self) -> Option<StopCause> {
        self.stopped.get().copied()
    }

    /// Its client, for messages: the first digits of what names it.
    pub(super) fn client(&self) -> String {
        self.key.0[..4].iter().map(|byte| format!("{byte:02x}")).collect()
    }

    /// Cancels the strike if its client gave it up or vanished; whether it did.
    pub(super) fn cancel_if_abandoned(&self) -> bool {
        let abandoned = match &*self.request() {
            Some(request) => !request.is_connected(),
            None => false,
        };
        if abandoned {
            self.cancel();
        }
        abandoned
    }

    /// Lends memory for the answer.
    pub(super) fn loan(&self, blocks: usize) -> Result<LoanedBuffer, Error> {
        match &*self.request() {
            Some(request) => loan(request, blocks),
            None => Err(closed()),
        }
    }

    /// Sends the answer. The request stays open until the client has read the answer or gone: so it is seen what is unread.
    pub(super) fn send(&self, answer: WrittenResult) -> Result<(), Error> {
        match &*self.request() {
            Some(request) if is_awaited(request) => answer.send().map_err(|error| failed("send", error)),
            _ => Err(closed()),
        }
    }

    /// Whether the client still waits, or has not read the answer yet.
    pub(super) fn is_open(&self) -> bool {
        self.request().as_ref().is_some_and(|request| request.is_connected())
    }

    /// Closes the request without an answer. The verdict must be kept before.
    pub(super) fn close(&self) {
        self.request().take();
    }
}

fn closed() -> Error {
    Error::new(ErrorKind::Cancelled, "client", "nobody waits for the answer any more")
}
