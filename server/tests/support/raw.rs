//! A peer that uses the transport directly, to send messages that no client library would send.

use iceoryx2::node::{Node, NodeBuilder};
use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::client::Client;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::prelude::SignalHandlingMode;
use shatter_proto::ErrorKind;
use shatter_proto::control::{ControlReplyHeader, ControlRequest, ControlRequestWire, read};
use shatter_proto::error::ErrorWire;
use shatter_proto::request::RequestWire;
use shatter_proto::result::{AlignedBlock, ResultHeader, SummaryWire};
use shatter_proto::view::CheckedLayout;
use shatter_transport::instance::Instance;
use shatter_transport::paths::ServicePaths;
use shatter_transport::{CONTROL_SERVICE, Ipc, STRIKE_SERVICE, WAKE_DAEMON_SERVICE, config, service_name};
use std::time::Duration;

type ControlRequests = Client<Ipc, ControlRequestWire, (), [AlignedBlock], ControlReplyHeader>;

/// A request that was sent unchecked.
pub type Sent = PendingResponse<Ipc, RequestWire, (), [AlignedBlock], ResultHeader>;

/// A question that was sent unchecked.
pub type PendingControlRequest = PendingResponse<Ipc, ControlRequestWire, (), [AlignedBlock], ControlReplyHeader>;

/// A peer on the level of the transport.
pub struct RawPeer {
    strikes: Client<Ipc, RequestWire, (), [AlignedBlock], ResultHeader>,
    control_requests: ControlRequests,
    wake_notifier: Notifier<Ipc>,
    _node: Node<Ipc>,
}

impl RawPeer {
    pub fn open(place: &ServicePaths) -> Self {
        let settings = config(&Instance::serving(place).unwrap()).unwrap();
        let builder = NodeBuilder::new().config(&settings).signal_handling_mode(SignalHandlingMode::Disabled);
        let node = builder.create::<Ipc>().unwrap();
        let service = |name| node.service_builder(&service_name(name).unwrap());
        let strikes = service(STRIKE_SERVICE).request_response::<RequestWire, [AlignedBlock]>();
        let strikes = strikes.response_user_header::<ResultHeader>().open().unwrap();
        let control_requests = service(CONTROL_SERVICE).request_response::<ControlRequestWire, [AlignedBlock]>();
        let control_requests = control_requests.response_user_header::<ControlReplyHeader>().open().unwrap();
        let wake_notifier = service(WAKE_DAEMON_SERVICE).event().open().unwrap();
        Self {
            strikes: strikes.client_builder().create().unwrap(),
            control_requests: control_requests.client_builder().create().unwrap(),
            wake_notifier: wake_notifier.notifier_builder().create().unwrap(),
            _node: node,
        }
    }

    /// Sends a request unchecked.
    pub fn send(&self, wire: RequestWire) -> Sent {
        let sent = self.strikes.send_copy(wire).unwrap();
        self.ring();
        sent
    }

    /// Sends a question unchecked.
    pub fn ask(&self, wire: ControlRequestWire) -> PendingControlRequest {
        let pending = self.control_requests.send_copy(wire).unwrap();
        self.ring();
        pending
    }

    /// Reply to a question: success, or the kind of its error; `None` if there is no reply yet.
    pub fn reply(&self, pending: &PendingControlRequest) -> Option<Result<(), ErrorKind>> {
        let reply = pending.receive().unwrap()?;
        Some(read::<ErrorWire>(reply.user_header(), reply.payload()).map(drop).map_err(|error| error.kind))
    }

    fn ring(&self) {
        let _ = self.wake_notifier.notify();
    }

    /// Waits for the outcome of a request: the summary of the result, or the error.
    pub fn outcome(&self, sent: &Sent) -> Result<SummaryWire, Option<ErrorKind>> {
        let wire = *sent.payload();
        match self.end(sent) {
            Some(summary) => Ok(summary),
            None => Err(self.failure(wire.listener, wire.sequence)),
        }
    }

    /// Waits until the request has a result or is closed.
    pub fn end(&self, sent: &Sent) -> Option<SummaryWire> {
        let deadline = super::timeout();
        loop {
            let connected = sent.is_connected();
            if let Some(response) = sent.receive().unwrap() {
                let checked = CheckedLayout::new(response.user_header(), response.payload()).unwrap();
                return Some(*checked.view(response.payload()).unwrap().summary);
            }
            if !connected {
                return None;
            }
            assert!(!deadline.passed(), "a request without an end");
            std::thread::sleep(Duration::from_micros(20));
        }
    }

    /// Reason why a request was closed without a result.
    fn failure(&self, listener: [u8; 16], sequence: u64) -> Option<ErrorKind> {
        let pending = self.control_requests.send_copy(ControlRequest::RequestError(sequence).wire(listener)).unwrap();
        self.ring();
        let deadline = super::timeout();
        loop {
            if let Some(reply) = pending.receive().unwrap() {
                let rows = read::<ErrorWire>(reply.user_header(), reply.payload()).unwrap();
                return rows.first().map(|row| shatter_proto::Error::from(row).kind);
            }
            assert!(!deadline.passed(), "a question without a reply");
            std::thread::sleep(Duration::from_micros(20));
        }
    }
}
