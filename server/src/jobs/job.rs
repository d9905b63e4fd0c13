//! One request from arrival to end.

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
use shatter_proto::result::{AlignedBlock, ResultHeader};
use shatter_proto::{Error, ErrorKind};
use shatter_transport::workarounds::response_pool::is_awaited;
use shatter_transport::{Ipc, failed};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::Instant;

/// Loaned response buffer with a complete result.
pub(super) type WrittenResult = ResponseMut<Ipc, [AlignedBlock], ResultHeader>;

/// Reason for which the daemon stopped a computing request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum StopCause {
    /// Its deadline passed.
    Late,
    /// The daemon is stopping.
    Ending,
}

impl StopCause {
    /// Error that the client receives.
    pub(super) fn error(self) -> Error {
        match self {
            Self::Late => Error::new(ErrorKind::Late, "deadline", "the deadline passed before the result was ready"),
            Self::Ending => Error::new(ErrorKind::Stopping, "daemon", "the daemon is ending; retry later"),
        }
    }
}

/// Work of a job: a validated request and its target.
pub(super) struct JobPayload {
    pub strike: Request,
    pub object: Arc<dyn ServedObject>,
    /// Retained result whose fragment is struck; `None`: the intact object is struck.
    pub kept: Option<Arc<RetainedFragments>>,
}

/// One request.
///
/// Two threads share the connection: one computes the result, the other checks whether the client still waits for it. Both hold the lock
/// for microseconds.
pub struct Job {
    request: Mutex<Option<ActiveImpactRequest>>,
    payload: Mutex<Option<JobPayload>>,
    token: CancelToken,
    key: RequestKey,
    arrived: Instant,
    /// Current stage.
    stage: CurrentStage,
    /// Kind of work; set after validation.
    work: WorkKind,
    /// Reason for stopping it while it computed.
    stopped: OnceLock<StopCause>,
}

impl Job {
    /// Creates a job for a request that arrives now from the client with this listener.
    pub(super) fn new(request: ActiveImpactRequest, listener: [u8; 16], sequence: u64) -> Self {
        Self {
            request: Mutex::new(Some(request)),
            payload: Mutex::new(None),
            token: CancelToken::default(),
            key: (listener, sequence),
            arrived: Instant::now(),
            stage: CurrentStage::default(),
            work: WorkKind::default(),
            stopped: OnceLock::new(),
        }
    }

    /// Sets the work, after validation.
    pub(super) fn set_work(&mut self, strike: Request, (object, kept): RetainedTarget) {
        self.work = WorkKind::of(&strike);
        self.payload = Mutex::new(Some(JobPayload { strike, object, kept }));
    }

    /// Takes the work out; works once, so that the job holds the object no longer than it computes.
    pub(super) fn unload(&self) -> Result<JobPayload, Error> {
        let missing = || Error::new(ErrorKind::Failed, "queue", "a request was queued before it was validated");
        self.payload.lock().unwrap_or_else(PoisonError::into_inner).take().ok_or_else(missing)
    }

    /// Identifies the request to its client.
    pub(super) fn key(&self) -> RequestKey {
        self.key
    }

    /// Kind of work.
    pub(super) fn work(&self) -> &WorkKind {
        &self.work
    }

    /// Cancellation token, polled by the stages.
    pub(super) fn token(&self) -> &CancelToken {
        &self.token
    }

    /// Current stage.
    pub(super) fn stage(&self) -> &CurrentStage {
        &self.stage
    }

    /// Time of arrival.
    pub fn arrived(&self) -> Instant {
        self.arrived
    }

    fn request(&self) -> MutexGuard<'_, Option<ActiveImpactRequest>> {
        self.request.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Asks the job to stop at its next checkpoint.
    pub(super) fn cancel(&self) {
        self.token.cancel();
    }

    /// Asks the job to stop at its next checkpoint, for the reason `why`.
    pub(super) fn stop(&self, why: StopCause) {
        self.stopped.get_or_init(|| why);
        self.cancel();
    }

    /// Reason for which the job was asked to stop.
    pub(super) fn stopped(&self) -> Option<StopCause> {
        self.stopped.get().copied()
    }

    /// Short name of the client for messages: the first hexadecimal digits of its listener.
    pub(super) fn client(&self) -> String {
        self.key.0[..4].iter().map(|byte| format!("{byte:02x}")).collect()
    }

    /// Cancels the job if its client dropped the request or died; returns whether it did.
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

    /// Loans memory for the result.
    pub(super) fn loan(&self, blocks: usize) -> Result<LoanedBuffer, Error> {
        match &*self.request() {
            Some(request) => loan(request, blocks),
            None => Err(closed()),
        }
    }

    /// Sends the result. The connection stays open until the client has read the result or is gone, which shows whether it is unread.
    pub(super) fn send(&self, written: WrittenResult) -> Result<(), Error> {
        match &*self.request() {
            Some(request) if is_awaited(request) => written.send().map_err(|error| failed("send", error)),
            _ => Err(closed()),
        }
    }

    /// Whether the client still waits, or has not read the result yet.
    pub(super) fn is_open(&self) -> bool {
        self.request().as_ref().is_some_and(|request| request.is_connected())
    }

    /// Closes the request without a result. The error must be stored in the mailbox before.
    pub(super) fn close(&self) {
        self.request().take();
    }
}

fn closed() -> Error {
    Error::new(ErrorKind::Canceled, "client", "the client no longer waits for the result")
}
