//! The ports of one connection, shared by everything that came from it.

use crate::Deadline;
use crate::sent_requests::{SentRequest, SentRequests};
use crate::waiters::Waiters;
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
use shatter_proto::result::{AlignedBlock, ResultHeader};
use shatter_proto::{Error, ErrorKind, PROTOCOL_VERSION};
use shatter_transport::instance::Instance;
use shatter_transport::paths::ServicePaths;
use shatter_transport::workarounds::dead_daemon::{DaemonLock, LIVENESS_INTERVAL};
use shatter_transport::workarounds::forked_processes::OwnedByProcess;
use shatter_transport::workarounds::unclear_errors::need_memory;
use shatter_transport::workarounds::{lost_wakeups, shared_memory};
use shatter_transport::{
    CONTROL_SERVICE, Ipc, STRIKE_SERVICE, WAKE_CLIENT_SERVICE, WAKE_DAEMON_SERVICE, client_config, failed, service_name,
};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Shared memory that a request may need beyond what exists, bytes.
const SEND_BYTES: u64 = 256 * 1024;

/// When the daemon's lock was tested last.
pub(crate) struct LivenessCheck(Instant);

impl LivenessCheck {
    /// Just now.
    pub(crate) fn now() -> Self {
        Self(Instant::now())
    }
}

/// A request under way.
pub(crate) type PendingRequest = OwnedByProcess<PendingResponse<Ipc, RequestWire, (), [AlignedBlock], ResultHeader>>;
/// A result, lent by the daemon.
pub(crate) type LoanedResult = OwnedByProcess<Response<Ipc, [AlignedBlock], ResultHeader>>;
/// A request to the control service under way.
pub(crate) type PendingControlRequest =
    OwnedByProcess<PendingResponse<Ipc, ControlRequestWire, (), [AlignedBlock], ControlReplyHeader>>;

/// Counts a result as held until it is dropped. Each request tells the daemon how many are, so that no client gets all of its buckets.
pub(crate) struct LoanCount(Arc<AtomicU64>);

impl Drop for LoanCount {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}

/// The ports of a connection.
struct ConnectionPorts {
    requests: Client<Ipc, RequestWire, (), [AlignedBlock], ResultHeader>,
    control: Client<Ipc, ControlRequestWire, (), [AlignedBlock], ControlReplyHeader>,
    notifier: Notifier<Ipc>,
    listener: Listener<Ipc>,
}

impl ConnectionPorts {
    /// Opens the services that the daemon created; never creates one.
    fn open(node: &Node<Ipc>) -> Result<Self, Error> {
        let requests = node
            .service_builder(&service_name(STRIKE_SERVICE)?)
            .request_response::<RequestWire, [AlignedBlock]>()
            .response_user_header::<ResultHeader>()
            .open()
            .map_err(open_failed)?;
        let control = node
            .service_builder(&service_name(CONTROL_SERVICE)?)
            .request_response::<ControlRequestWire, [AlignedBlock]>()
            .response_user_header::<ControlReplyHeader>()
            .open()
            .map_err(open_failed)?;
        let event = |name| {
            let builder = node.service_builder(&service_name(name)?).event();
            builder.open().map_err(|error| failed(name, error))
        };
        let (notifier, listener) = (event(WAKE_DAEMON_SERVICE)?, event(WAKE_CLIENT_SERVICE)?);
        Ok(Self {
            requests: requests.client_builder().create().map_err(client_failed)?,
            control: control.client_builder().create().map_err(client_failed)?,
            notifier: notifier.notifier_builder().create().map_err(|error| failed(WAKE_DAEMON_SERVICE, error))?,
            listener: listener.listener_builder().create().map_err(|error| failed(WAKE_CLIENT_SERVICE, error))?,
        })
    }
}

/// A connection to one daemon. Fields are dropped in this order: ports before the node.
pub(crate) struct Connection {
    ports: OwnedByProcess<ConnectionPorts>,
    sent: SentRequests,
    waiters: Waiters,
    loans: Arc<AtomicU64>,
    /// Its daemon is known to have gone away.
    is_lost: AtomicBool,
    paths: ServicePaths,
    lock: DaemonLock,
    _node: OwnedByProcess<Node<Ipc>>,
}

impl Connection {
    /// Connects to the daemon at `paths` whose transport is `instance`.
    pub(crate) fn open(paths: &ServicePaths, instance: &Instance) -> Result<Self, Error> {
        need_memory()?;
        shared_memory::need(shared_memory::CONNECTION_BYTES)?;
        instance.check(paths.uid)?;
        let lock = DaemonLock::open(paths, instance).ok_or_else(|| failed("lock", "the daemon went away"))?;
        let config = client_config(instance)?;
        let node = NodeBuilder::new()
            .config(&config)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<Ipc>()
            .map_err(|error| failed("node", error))?;
        let ports = ConnectionPorts::open(&node)?;
        shared_memory::populate_mapped(&instance.folder)?;
        Ok(Self {
            ports: OwnedByProcess::new(ports),
            sent: SentRequests::default(),
            waiters: Waiters::default(),
            loans: Arc::default(),
            is_lost: AtomicBool::new(false),
            paths: paths.clone(),
            lock,
            _node: OwnedByProcess::new(node),
        })
    }

    /// Sequence of the request after which a release has its turn; zero: none.
    pub(crate) fn followed(&self) -> u64 {
        self.sent.followed()
    }

    /// Counts one more result as held.
    pub(crate) fn count_loan(&self) -> LoanCount {
        self.loans.fetch_add(1, Ordering::Relaxed);
        LoanCount(self.loans.clone())
    }

    /// The tasks that await tickets of this connection.
    pub(crate) fn waiters(&self) -> &Waiters {
        &self.waiters
    }

    /// The id by which the daemon knows this connection.
    pub(crate) fn listener(&self) -> [u8; 16] {
        self.ports.listener.id().value().to_le_bytes()
    }

    /// Sends a request. Waits for other threads that send, and for nothing else.
    pub(crate) fn send(&self, request: RequestWire) -> Result<(PendingRequest, SentRequest), Error> {
        shared_memory::need(SEND_BYTES)?;
        let next = self.sent.next();
        let (sequence, held) = (next.sequence, self.loans.load(Ordering::Relaxed));
        let loan = self.ports.requests.loan_uninit().map_err(loan_failed)?;
        let pending = loan.write_payload(RequestWire { sequence, held, ..request }).send().map_err(send_failed)?;
        let sent = next.sent();
        self.wake_daemon(pending.number_of_server_connections())?;
        Ok((OwnedByProcess::new(pending), sent))
    }

    /// Sends a request to the control service. Never blocks.
    pub(crate) fn ask(&self, request: ControlRequest) -> Result<PendingControlRequest, Error> {
        shared_memory::need(SEND_BYTES)?;
        let loan = self.ports.control.loan_uninit().map_err(loan_failed)?;
        let pending = loan.write_payload(request.wire(self.listener())).send().map_err(send_failed)?;
        self.wake_daemon(pending.number_of_server_connections())?;
        Ok(OwnedByProcess::new(pending))
    }

    /// Wakes the daemon; a failure costs at most a tick of its clock. A request that reached no daemon is lost: a later daemon does
    /// not find it.
    fn wake_daemon(&self, daemon_count: usize) -> Result<(), Error> {
        if daemon_count == 0 {
            return Err(self.lost());
        }
        if let Err(error) = self.ports.notifier.notify() {
            tracing::debug!(?error, "the daemon was not woken");
        }
        Ok(())
    }

    /// Sleeps until the daemon notifies this connection, a tick has passed, or the deadline.
    pub(crate) fn wait(&self, deadline: Deadline) {
        if deadline.passed() {
            return;
        }
        let tick = lost_wakeups::bounded(deadline.left());
        if let Err(error) = self.ports.listener.timed_wait(|_| {}, tick) {
            tracing::debug!(?error, "cannot listen");
            std::thread::sleep(tick.min(Duration::from_millis(1)));
        }
    }

    /// Tests whether the daemon lives, unless it did so a moment ago.
    ///
    /// # Errors
    /// `lost` if the daemon went away.
    pub(crate) fn check_alive(&self, last: &mut LivenessCheck) -> Result<(), Error> {
        if last.0.elapsed() < LIVENESS_INTERVAL {
            return Ok(());
        }
        *last = LivenessCheck::now();
        if self.daemon_lives() { Ok(()) } else { Err(self.lost()) }
    }

    /// Whether its daemon is known to have gone away, or the process that connected is another one.
    pub(crate) fn is_lost(&self) -> bool {
        self.is_lost.load(Ordering::Relaxed) || self.ports.is_forked()
    }

    /// Refuses what another process sent, of which this one was forked.
    ///
    /// # Errors
    /// `lost`.
    pub(crate) fn check_process(&self) -> Result<(), Error> {
        if self.ports.is_forked() {
            let message = "the request belongs to the process before the fork; send it again";
            return Err(Error::new(ErrorKind::Lost, self.paths.service.as_str(), message));
        }
        Ok(())
    }

    /// Whether its daemon lives. Another one of the same name does not count.
    pub(crate) fn daemon_lives(&self) -> bool {
        self.lock.is_held()
    }

    /// The error for a daemon that lives and has dropped this connection; remembered as [`Self::lost`] is.
    pub(crate) fn evicted(&self) -> Error {
        self.lost_because("took this connection for that of a dead client; send it again")
    }

    /// The error for a daemon that went away; remembered, so that the next request goes to another one. Daemons keep nothing of
    /// a request: sending it again is safe.
    pub(crate) fn lost(&self) -> Error {
        let start = self.paths.start_command();
        let what = "went away; no result will come, and sending it again is safe once a daemon serves";
        self.lost_because(&format!("{what} (start one with `{start}`)"))
    }

    fn lost_because(&self, what: &str) -> Error {
        self.is_lost.store(true, Ordering::Relaxed);
        let service = self.paths.service.as_str();
        Error::new(ErrorKind::Lost, service, format!("the daemon of service `{service}` {what}"))
    }
}

fn open_failed(error: RequestResponseOpenError) -> Error {
    match error {
        RequestResponseOpenError::ExceedsMaxNumberOfNodes => too_many(),
        RequestResponseOpenError::VersionMismatch | RequestResponseOpenError::IncompatibleRequestOrResponseType => {
            let message = format!(
                "the daemon speaks another version of the protocol than this client, which speaks {PROTOCOL_VERSION}; use a client and a \
                 daemon of one release"
            );
            Error::new(ErrorKind::VersionMismatch, "service", message)
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
    Error::new(
        ErrorKind::Busy,
        "clients",
        "the daemon admits no more clients; disconnect one, or raise the daemon's `service.clients_max`",
    )
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

/// The error for a thread that cannot be started.
pub(crate) fn no_thread(error: &std::io::Error) -> Error {
    Error::new(
        ErrorKind::Failed,
        "threads",
        format!("no thread can be started: {error}; raise the limits of this process (ulimit -u, -v, -d)"),
    )
}

fn full() -> Error {
    Error::new(ErrorKind::Busy, "connection", "this connection has as many requests under way as it may")
}

/// The error for a failed receive.
pub(crate) fn receive_failed(error: ReceiveError) -> Error {
    match error {
        ReceiveError::ExceedsMaxBorrows => {
            Error::new(ErrorKind::Busy, "results", "too many results are held; drop some")
        }
        error => failed("receive", error),
    }
}
