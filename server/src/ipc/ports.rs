//! Services and ports: impact requests with a pool of buckets, control requests with a small separate pool, and two wake-up services.

use super::{ClientWaker, WakeSocket};
use bytemuck::Zeroable;
use iceoryx2::active_request::ActiveRequest;
use iceoryx2::node::{Node, NodeBuilder};
use iceoryx2::port::client::Client;
use iceoryx2::port::server::Server;
use iceoryx2::port::{LoanError, ReceiveError};
use iceoryx2::prelude::{PortFactory as _, SignalHandlingMode};
use iceoryx2::response_mut_uninit::ResponseMutUninit;
use iceoryx2::service::port_factory::{event, request_response};
use shatter_proto::control::{ControlReplyHeader, ControlRequestWire, REPLY_BLOCKS};
use shatter_proto::request::RequestWire;
use shatter_proto::result::{AlignedBlock, BLOCK_BYTES, ResultHeader};
use shatter_proto::text::counted;
use shatter_proto::{Error, ErrorKind};
use shatter_transport::instance::Instance;
use shatter_transport::workarounds::populated_pages::PopulatedPages;
use shatter_transport::workarounds::response_pool;
use shatter_transport::{
    CONTROL_REQUESTS_PER_CLIENT_MAX, CONTROL_SERVICE, Ipc, STRIKE_SERVICE, STRIKES_PER_CLIENT_MAX, WAKE_CLIENT_SERVICE,
    WAKE_DAEMON_SERVICE, config, failed, service_name,
};
use std::mem::MaybeUninit;

/// Received impact request.
pub type ActiveImpactRequest = ActiveRequest<Ipc, RequestWire, (), [AlignedBlock], ResultHeader>;
/// Received control request.
pub type ActiveControlRequest = ActiveRequest<Ipc, ControlRequestWire, (), [AlignedBlock], ControlReplyHeader>;
/// Loaned response buffer, not written yet.
pub type LoanedBuffer = ResponseMutUninit<Ipc, [MaybeUninit<AlignedBlock>], ResultHeader>;

type RequestFactory = request_response::PortFactory<Ipc, RequestWire, (), [AlignedBlock], ResultHeader>;
type ControlFactory = request_response::PortFactory<Ipc, ControlRequestWire, (), [AlignedBlock], ControlReplyHeader>;

/// Additional client for the daemon itself, for the rehearsal.
const OWN_CLIENTS: usize = 1;
/// Additional processes beside clients: the daemon, its connection checks, and a few that are just ending.
const OTHER_NODES: usize = 4;
/// Maximum number of unread control replies.
const REPLIES: usize = 64;

/// Size of the result pool, and number of clients.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PoolSize {
    /// Maximum number of connected clients.
    pub clients: usize,
    /// Number of buckets.
    pub buckets: usize,
    /// Blocks per bucket.
    pub blocks: usize,
}

impl PoolSize {
    /// Bytes per bucket.
    pub fn bucket_bytes(&self) -> u64 {
        (self.blocks * BLOCK_BYTES) as u64
    }
}

/// Ports of the daemon. Fields are dropped in this order: ports, factories, node.
pub struct DaemonPorts {
    strikes: Server<Ipc, RequestWire, (), [AlignedBlock], ResultHeader>,
    control_requests: Server<Ipc, ControlRequestWire, (), [AlignedBlock], ControlReplyHeader>,
    /// Client of the rehearsal; kept, so that the number of free client slots equals the limit.
    rehearsal: Client<Ipc, RequestWire, (), [AlignedBlock], ResultHeader>,
    impact_request_factory: RequestFactory,
    _control_factory: ControlFactory,
    _events: [event::PortFactory<Ipc>; 2],
    node: Node<Ipc>,
    pool: PoolSize,
}

impl DaemonPorts {
    /// Creates the services of `instance`. Needs a tokio runtime for the wake-up socket.
    ///
    /// # Errors
    /// `transport` if a service cannot be created.
    pub fn open(instance: &Instance, pool: PoolSize) -> Result<(Self, WakeSocket, ClientWaker), Error> {
        let config = config(instance)?;
        let node = NodeBuilder::new()
            .config(&config)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<Ipc>()
            .map_err(|error| failed("node", error))?;
        let (wake_daemon, wake_client) =
            (event(&node, WAKE_DAEMON_SERVICE, pool.clients)?, event(&node, WAKE_CLIENT_SERVICE, pool.clients)?);
        let listener = wake_daemon.listener_builder().create().map_err(|error| failed(WAKE_DAEMON_SERVICE, error))?;
        let notifier = wake_client.notifier_builder().create().map_err(|error| failed(WAKE_CLIENT_SERVICE, error))?;
        let wake_socket = WakeSocket::new(listener).map_err(|error| failed(WAKE_DAEMON_SERVICE, error))?;
        let (impact_request_factory, control_factory) =
            (impact_request_factory(&node, pool.clients)?, control_factory(&node, pool.clients)?);
        let strikes = impact_request_factory
            .server_builder()
            .initial_max_slice_len(pool.blocks)
            .allocation_strategy(response_pool::ALLOCATION)
            .override_response_preallocation(move |worst| worst.min(pool.buckets))
            .max_loaned_responses_per_request(response_pool::LOANS_PER_REQUEST)
            .backpressure_strategy(response_pool::BACKPRESSURE)
            .create()
            .map_err(|error| failed(STRIKE_SERVICE, error))?;
        let control_requests = control_factory
            .server_builder()
            .initial_max_slice_len(REPLY_BLOCKS)
            .allocation_strategy(response_pool::ALLOCATION)
            .override_response_preallocation(|worst| worst.min(REPLIES))
            .max_loaned_responses_per_request(response_pool::LOANS_PER_REQUEST)
            .backpressure_strategy(response_pool::BACKPRESSURE)
            .create()
            .map_err(|error| failed(CONTROL_SERVICE, error))?;
        let rehearsal = impact_request_factory.client_builder().create().map_err(|error| failed("rehearsal", error))?;
        let events = [wake_daemon, wake_client];
        let ports = Self {
            strikes,
            control_requests,
            rehearsal,
            impact_request_factory,
            _control_factory: control_factory,
            _events: events,
            node,
            pool,
        };
        Ok((ports, wake_socket, ClientWaker::new(notifier)))
    }

    /// Size of the result pool.
    pub fn pool(&self) -> PoolSize {
        self.pool
    }

    /// Number of connected clients.
    pub fn clients(&self) -> usize {
        self.impact_request_factory.dynamic_config().number_of_clients().saturating_sub(OWN_CLIENTS)
    }

    /// Refuses if as many clients are connected as the service admits.
    ///
    /// # Errors
    /// `busy`.
    pub fn check_admission(&self) -> Result<(), Error> {
        if self.clients() < self.pool.clients {
            return Ok(());
        }
        let (clients, verb) = (self.pool.clients as u64, if self.pool.clients == 1 { "is" } else { "are" });
        let message = format!("{} {verb} connected, as many as the service admits", counted(clients, "client"));
        Err(Error::new(ErrorKind::Busy, "service.clients_max", message))
    }

    /// Next impact request that waits at the port.
    pub fn next_impact_request(&self) -> Option<ActiveImpactRequest> {
        received(self.strikes.receive())
    }

    /// Next control request that waits at the port.
    pub fn next_control_request(&self) -> Option<ActiveControlRequest> {
        received(self.control_requests.receive())
    }

    /// Reclaims the resources of dead clients; returns how many were found.
    pub fn reap_dead_clients(&self) -> u64 {
        self.node.try_cleanup_dead_nodes().cleanups
    }

    /// Writes the first `blocks` blocks of `buckets` buckets once, by sending real requests to itself.
    ///
    /// Afterwards the first requests find populated memory, and a transport that does not work is detected before the daemon serves.
    ///
    /// # Errors
    /// `transport` if a request is lost, `shared_memory` if memory is full.
    pub fn rehearse(&self, buckets: usize, blocks: usize, populated: &PopulatedPages) -> Result<(), Error> {
        let blocks = blocks.min(self.pool.blocks);
        let buckets = buckets.min(self.pool.buckets).min(STRIKES_PER_CLIENT_MAX);
        let send = |_| self.rehearsal.send_copy(RequestWire::zeroed()).map_err(|error| failed("rehearsal", error));
        let _pending = (0..buckets).map(send).collect::<Result<Vec<_>, _>>()?;
        let mut held = Vec::with_capacity(buckets);
        for _ in 0..buckets {
            let active = self.next_impact_request().ok_or_else(|| failed("rehearsal", "a request was lost"))?;
            let mut buffer = loan(&active, blocks)?;
            populated.ensure(buffer.payload_mut())?;
            held.push((active, buffer));
        }
        Ok(())
    }
}

/// Loans a bucket for a result.
///
/// # Errors
/// `busy` when all are held, `result_too_large`.
pub fn loan(active: &ActiveImpactRequest, blocks: usize) -> Result<LoanedBuffer, Error> {
    active.loan_slice_uninit(blocks).map_err(|error| match error {
        LoanError::OutOfMemory => Error::new(ErrorKind::Busy, "results", "clients hold all buckets of results; drop some, or raise results.buckets"),
        LoanError::ExceedsMaxLoanSize => {
            let message = format!(
                "the result of {} bytes is larger than a bucket; restart the daemon, which sizes its buckets by the objects that it \
                 loads, or raise results.bucket_mib_max",
                blocks * BLOCK_BYTES
            );
            Error::new(ErrorKind::ResultTooLarge, "results", message)
        }
        error => failed("loan", error),
    })
}

fn received<T>(result: Result<Option<T>, ReceiveError>) -> Option<T> {
    match result {
        Ok(request) => request,
        // Clients hold all of their slots; retry later.
        Err(ReceiveError::ExceedsMaxBorrows) => None,
        Err(error) => {
            tracing::warn!(?error, "cannot receive requests");
            None
        }
    }
}

fn event(node: &Node<Ipc>, name: &str, clients: usize) -> Result<event::PortFactory<Ipc>, Error> {
    let builder = node.service_builder(&service_name(name)?).event();
    let ports = clients + OWN_CLIENTS;
    let builder = builder.max_listeners(ports).max_notifiers(ports).max_nodes(clients + OTHER_NODES);
    builder.open_or_create().map_err(|error| failed(name, error))
}

fn impact_request_factory(node: &Node<Ipc>, clients: usize) -> Result<RequestFactory, Error> {
    node.service_builder(&service_name(STRIKE_SERVICE)?)
        .request_response::<RequestWire, [AlignedBlock]>()
        .response_user_header::<ResultHeader>()
        .max_clients(clients + OWN_CLIENTS)
        .max_servers(1)
        .max_nodes(clients + OTHER_NODES)
        .max_active_requests_per_client(STRIKES_PER_CLIENT_MAX)
        .max_response_buffer_size(response_pool::BUFFER)
        .max_borrowed_responses_per_pending_response(4)
        .enable_fire_and_forget_requests(false)
        .open_or_create()
        .map_err(|error| failed(STRIKE_SERVICE, error))
}

fn control_factory(node: &Node<Ipc>, clients: usize) -> Result<ControlFactory, Error> {
    node.service_builder(&service_name(CONTROL_SERVICE)?)
        .request_response::<ControlRequestWire, [AlignedBlock]>()
        .response_user_header::<ControlReplyHeader>()
        .max_clients(clients + OWN_CLIENTS)
        .max_servers(1)
        .max_nodes(clients + OTHER_NODES)
        .max_active_requests_per_client(CONTROL_REQUESTS_PER_CLIENT_MAX)
        .max_response_buffer_size(response_pool::BUFFER)
        .max_borrowed_responses_per_pending_response(2)
        .enable_fire_and_forget_requests(false)
        .open_or_create()
        .map_err(|error| failed(CONTROL_SERVICE, error))
}
