//! A peer that speaks the transport and nothing else: it sends what no client library would.

use iceoryx2::node::{Node, NodeBuilder};
use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::client::Client;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::prelude::SignalHandlingMode;
use shatter_proto::Kind;
use shatter_proto::answer::{AnswerHeader, Block, SummaryWire};
use shatter_proto::control::{ControlHeader, ControlWire, Question, read};
use shatter_proto::refusal::RefusalWire;
use shatter_proto::request::StrikeWire;
use shatter_proto::view::Checked;
use shatter_transport::instance::Instance;
use shatter_transport::place::Place;
use shatter_transport::{CONTROL_SERVICE, Ipc, STRIKE_SERVICE, WAKE_DAEMON_SERVICE, config, service_name};
use std::time::Duration;

type Questions = Client<Ipc, ControlWire, (), [Block], ControlHeader>;

/// A strike sent as it was.
pub type Sent = PendingResponse<Ipc, StrikeWire, (), [Block], AnswerHeader>;

/// A question sent as it was.
pub type Asked = PendingResponse<Ipc, ControlWire, (), [Block], ControlHeader>;

/// The peer.
pub struct RawPeer {
    strikes: Client<Ipc, StrikeWire, (), [Block], AnswerHeader>,
    questions: Questions,
    bell: Notifier<Ipc>,
    _node: Node<Ipc>,
}

impl RawPeer {
    pub fn open(place: &Place) -> Self {
        let settings = config(&Instance::serving(place).unwrap()).unwrap();
        let builder = NodeBuilder::new().config(&settings).signal_handling_mode(SignalHandlingMode::Disabled);
        let node = builder.create::<Ipc>().unwrap();
        let service = |name| node.service_builder(&service_name(name).unwrap());
        let strikes = service(STRIKE_SERVICE).request_response::<StrikeWire, [Block]>();
        let strikes = strikes.response_user_header::<AnswerHeader>().open().unwrap();
        let questions = service(CONTROL_SERVICE).request_response::<ControlWire, [Block]>();
        let questions = questions.response_user_header::<ControlHeader>().open().unwrap();
        let bell = service(WAKE_DAEMON_SERVICE).event().open().unwrap();
        Self {
            strikes: strikes.client_builder().create().unwrap(),
            questions: questions.client_builder().create().unwrap(),
            bell: bell.notifier_builder().create().unwrap(),
            _node: node,
        }
    }

    /// Sends it without asking what it is.
    pub fn send(&self, wire: StrikeWire) -> Sent {
        let sent = self.strikes.send_copy(wire).unwrap();
        self.ring();
        sent
    }

    /// Asks without asking what.
    pub fn ask(&self, wire: ControlWire) -> Asked {
        let asked = self.questions.send_copy(wire).unwrap();
        self.ring();
        asked
    }

    /// The kind of the refusal that a question got, or that it was not refused; `None`: there is no reply yet.
    pub fn reply(&self, asked: &Asked) -> Option<Result<(), Kind>> {
        let reply = asked.receive().unwrap()?;
        Some(read::<RefusalWire>(reply.user_header(), reply.payload()).map(drop).map_err(|refusal| refusal.kind))
    }

    fn ring(&self) {
        let _ = self.bell.notify();
    }

    /// Waits for what becomes of it: the facts of the answer, or the verdict.
    pub fn outcome(&self, sent: &Sent) -> Result<SummaryWire, Option<Kind>> {
        let wire = *sent.payload();
        match self.end(sent) {
            Some(summary) => Ok(summary),
            None => Err(self.verdict(wire.listener, wire.sequence)),
        }
    }

    /// Waits until it is answered or closed.
    pub fn end(&self, sent: &Sent) -> Option<SummaryWire> {
        let deadline = super::patience();
        loop {
            let connected = sent.is_connected();
            if let Some(answer) = sent.receive().unwrap() {
                let checked = Checked::new(answer.user_header(), answer.payload()).unwrap();
                return Some(*checked.view(answer.payload()).unwrap().summary);
            }
            if !connected {
                return None;
            }
            assert!(!deadline.passed(), "a request without an end");
            std::thread::sleep(Duration::from_micros(20));
        }
    }

    /// Why a strike was closed without an answer.
    fn verdict(&self, listener: [u8; 16], sequence: u64) -> Option<Kind> {
        let asked = self.questions.send_copy(Question::Verdict(sequence).wire(listener)).unwrap();
        self.ring();
        let deadline = super::patience();
        loop {
            if let Some(reply) = asked.receive().unwrap() {
                let rows = read::<RefusalWire>(reply.user_header(), reply.payload()).unwrap();
                return rows.first().map(|row| shatter_proto::Refusal::from(row).kind);
            }
            assert!(!deadline.passed(), "a question without a reply");
            std::thread::sleep(Duration::from_micros(20));
        }
    }
}
