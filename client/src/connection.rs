//! The ports of one connection, shared by everything that came from it.

use crate::Deadline;
use crate::result_future::Waiters;
use iceoryx2::node::{Node, NodeBuilder};
use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::client::{Client, RequestSendError};
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::{LoanError, ReceiveError};
use iceoryx2::prelude::SignalHandlingMode;
use iceoryx2::response::Response;
use iceoryx2::service::builder::request_response::RequestResponseOpenError;
use iceoryx2::service::port_factory::client::ClientCreateError;
use shatter_proto::control::{ControlReplyHeader, ControlRequest, ControlRequestWire};
use shatter_proto::request::RequestWire;
use shatter_proto::result::{Block, ResultHeader};
use shatter_proto::{Error, ErrorKind};
use shatter_transport::instance::Instance;
use shatter_transport::paths::ServicePaths;
use shatter_transport::workarounds::dead_daemon::{DaemonLock, PULSE};
use shatter_transport::workarounds::{lost_wakeups, shared_memory};
use shatter_transport::{
    CONTROL_SERVICE, Ipc, STRIKE_SERVICE, WAKE_CLIENT_SERVICE, WAKE_DAEMON_SERVICE, client_config, failed, service_name,
};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// What a request may need beyond what exists, should a new daemon have come meanwhile.
const ROOM_TO_SEND: u64 = 256 * 1024;

/// When the daemon's lock was last looked at.
pub(crate) struct LivenessCheck(Instant);

impl LivenessCheck {
    /// Just now.
    pub(crate) fn now() -> Self {
        Self(Instant::now())
    }
}

/// A strike under way.
pub(crate) type PendingRequest = PendingResponse<Ipc, RequestWire, (), [Block], ResultHeader>;
/// An answer, lent.
pub(crate) type LoanedResult = Response<Ipc, [Block], ResultHeader>;
/// A question under way.
pub(crate) type PendingControlRequest = PendingResponse<Ipc, ControlRequestWire, (), [Block], ControlReplyHeader>;

/// An answer that is held: the daemon is told how many there are, and gives no client all of its buckets.
pub(crate) struct LoanCount(Arc<AtomicU64>);

impl Drop for LoanCount {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}

/// The ports of a connection.
struct Ports {
    strikes: Client<Ipc, RequestWire, (), [Block], ResultHeader>,
    questions: Client<Ipc, ControlRequestWire, (), [Block], ControlReplyHeader>,
    wake: Notifier<Ipc>,
    woken: Listener<Ipc>,
}

impl Ports {
    /// Opens the services that the daemon created; never creates one.
    fn open(node: &Node<Ipc>) -> Result<Self, Error> {
        let strikes = node
            .service_builder(&service_name(STRIKE_SERVICE)?)
            .request_response::<RequestWire, [Block]>()
            .response_user_header::<ResultHeader>()
            .open()
            .map_err(open_failed)?;
        let questions = node
            .service_builder(&service_name(CONTROL_SERVICE)?)
            .request_response::<ControlRequestWire, [Block]>()
            .response_user_header::<ControlReplyHeader>()
            .open()
            .map_err(open_failed)?;
        let event = |name| {
            let builder = node.service_builder(&service_name(name)?).event();
            builder.open().map_err(|error| failed(name, error))
        };
        let (wake, woken) = (event(WAKE_DAEMON_SERVICE)?, event(WAKE_CLIENT_SERVICE)?);
        Ok(Self {
            strikes: strikes.client_builder().create().map_err(client_failed)?,
            questions: questions.client_builder().create().map_err(client_failed)?,
            wake: wake.notifier_builder().create().map_err(|error| failed(WAKE_DAEMON_SERVICE, error))?,
            woken: woken.listener_builder().create().map_err(|error| failed(WAKE_CLIENT_SERVICE, error))?,
        })
    }
}

/// One connection. Fields are dropped in this order: ports before the node.
pub(crate) struct Connection {
    ports: Ports,
    /// Sequence of the strike that was sent last.
    sent: Mutex<u64>,
    audience: Waiters,
    held: Arc<AtomicU64>,
    /// Its daemon went away.
    lost: AtomicBool,
    place: ServicePaths,
    lock: DaemonLock,
    _node: Node<Ipc>,
}

impl Connection {
    /// Connects to the daemon of `place` whose transport is `instance`.
    pub(crate) fn open(place: &ServicePaths, instance: &Instance) -> Result<Self, Error> {
        shared_memory::need(shared_memory::CONNECTION_BYTES)?;
        instance.check(place.uid)?;
        let lock = DaemonLock::open(place, instance).ok_or_else(|| failed("lock", "the daemon went away"))?;
        let config = client_config(instance)?;
        let node = NodeBuilder::new()
            .config(&config)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<Ipc>()
            .map_err(|error| failed("node", error))?;
        let ports = Ports::open(&node)?;
        shared_memory::populate_mapped(&instance.folder)?;
        Ok(Self {
            ports,
            sent: Mutex::default(),
            audience: Waiters::default(),
            held: Arc::default(),
            lost: AtomicBool::new(false),
            place: place.clone(),
            lock,
            _node: node,
        })
    }

    fn sent(&self) -> MutexGuard<'_, u64> {
        self.sent.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sequence of the strike that was sent last; zero: none was.
    pub(crate) fn last_sequence(&self) -> u64 {
        *self.sent()
    }

    /// Answers that are held, counting one more.
    pub(crate) fn count_loan(&self) -> LoanCount {
        self.held.fetch_add(1, Ordering::Relaxed);
        LoanCount(self.held.clone())
    }

    /// Those who await tickets of this connection.
    pub(crate) fn audience(&self) -> &Waiters {
        &self.audience
    }

    /// What names this connection to the daemon.
    pub(crate) fn listener(&self) -> [u8; 16] {
        self.ports.woken.id().value().to_le_bytes()
    }

    /// Sends a strike; returns its sequence, too. Sequences are in the order of sending, whichever threads send: the daemon tells by
    /// them what a release came after. Waits for nothing but other threads that send.
    pub(crate) fn send(&self, strike: RequestWire) -> Result<(PendingRequest, u64), Error> {
        shared_memory::need(ROOM_TO_SEND)?;
        let mut sent = self.sent();
        let (sequence, held) = (*sent + 1, self.held.load(Ordering::Relaxed));
        let request = self.ports.strikes.loan_uninit().map_err(loan_failed)?;
        let strike = RequestWire { sequence, held, ..strike };
        let pending = request.write_payload(strike).send().map_err(send_failed)?;
        *sent = sequence;
        drop(sent);
        self.wake_daemon(pending.number_of_server_connections())?;
        Ok((pending, sequence))
    }

    /// Sends a question. Never blocks.
    pub(crate) fn ask(&self, question: ControlRequest) -> Result<PendingControlRequest, Error> {
        shared_memory::need(ROOM_TO_SEND)?;
        let request = self.ports.questions.loan_uninit().map_err(loan_failed)?;
        let pending = request.write_payload(question.wire(self.listener())).send().map_err(send_failed)?;
        self.wake_daemon(pending.number_of_server_connections())?;
        Ok(pending)
    }

    /// Wakes the daemon; a failure costs a tick of its clock, no more. What reached no daemon is lost: one that comes later
    /// does not find it.
    fn wake_daemon(&self, daemons: usize) -> Result<(), Error> {
        if daemons == 0 {
            return Err(self.lost());
        }
        if let Err(error) = self.ports.wake.notify() {
            tracing::debug!(?error, "the daemon was not woken");
        }
        Ok(())
    }

    /// Sleeps until the daemon rings, a tick has passed, or the deadline.
    pub(crate) fn wait(&self, deadline: Deadline) {
        if deadline.passed() {
            return;
        }
        let tick = lost_wakeups::bounded(deadline.left());
        if let Err(error) = self.ports.woken.timed_wait(|_| {}, tick) {
            tracing::debug!(?error, "cannot listen");
            std::thread::sleep(tick.min(Duration::from_millis(1)));
        }
    }

    /// Whether a daemon of this name lives, looked at not too often; the error says that it went away.
    pub(crate) fn feel(&self, pulse: &mut LivenessCheck) -> Result<(), Error> {
        if pulse.0.elapsed() < PULSE {
            return Ok(());
        }
        pulse.0 = Instant::now();
        if self.daemon_lives() { Ok(()) } else { Err(self.lost()) }
    }

    /// Whether its daemon is known to have gone away.
    pub(crate) fn is_lost(&self) -> bool {
        self.lost.load(Ordering::Relaxed)
    }

    /// Whether its daemon lives. Another one of the same name does not count.
    pub(crate) fn daemon_lives(&self) -> bool {
        self.lock.is_held()
    }

    /// The refusal for a daemon that lives and has lost sight of this connection; remembered as [`Self::lost`] is.
    pub(crate) fn evicted(&self) -> Error {
        self.lost.store(true, Ordering::Relaxed);
        let service = self.place.service.as_str();
        let message = format!("the daemon of service `{service}` took this connection for a dead one; send it again");
        Error::new(ErrorKind::Lost, service, message)
    }

    /// The refusal for a daemon that went away; remembered, so that what comes next goes to another one. Daemons keep nothing of
    /// a strike: sending it again is safe.
    pub(crate) fn lost(&self) -> Error {
        self.lost.store(true, Ordering::Relaxed);
        let service = self.place.service.as_str();
        let message =
            format!("the daemon of service `{service}` went away; no answer will come, and sending it again is safe");
        Error::new(ErrorKind::Lost, service, message)
    }
}

fn open_failed(error: RequestResponseOpenError) -> Error {
    match error {
        RequestResponseOpenError::ExceedsMaxNumberOfNodes => too_many(),
        RequestResponseOpenError::VersionMismatch | RequestResponseOpenError::IncompatibleRequestOrResponseType => {
            Error::new(ErrorKind::VersionMismatch, "service", format!("the daemon is of another version: {error}"))
        }
        error => failed("open", error),
    }
}

fn client_failed(error: ClientCreateError) -> Error {
    match error {
        ClientCreateError::ExceedsMaxSupportedClients => too_many(),
        error => failed("client", error),
    }
}

fn too_many() -> Error {
    Error::new(ErrorKind::Busy, "clients", "the service has no place for another client")
}

fn loan_failed(error: LoanError) -> Error {
    match error {
        LoanError::OutOfMemory | LoanError::ExceedsMaxLoans => full(),
        error => failed("loan", error),
    }
}

fn send_failed(error: RequestSendError) -> Error {
    match error {
        RequestSendError::ExceedsMaxActiveRequests => full(),
        error => failed("send", error),
    }
}

/// The thread that awaited tickets need could not be started.
pub(crate) fn no_thread(error: &std::io::Error) -> Error {
    Error::new(ErrorKind::Failed, "threads", format!("no thread can be started: {error}"))
}

fn full() -> Error {
    Error::new(ErrorKind::Busy, "connection", "this connection has as many requests under way as it may")
}

/// Nothing could be received.
pub(crate) fn receive_failed(error: ReceiveError) -> Error {
    match error {
        ReceiveError::ExceedsMaxBorrows => {
            Error::new(ErrorKind::Busy, "answers", "too many answers are held; drop some")
        }
        error => failed("receive", error),
    }
}
