//! The thread that serves one page: it takes requests in their order and replies to each.

use crate::baking::{self, BakeJob, Bakes};
use crate::daemon::ViewDaemon;
use crate::download;
use crate::impact_request::{effects, impact, invalid};
use crate::recording::Recording;
use crate::result_message::ResultMessage;
use crate::scene_check;
use crate::shown_pieces::ShownPieces;
use serde_json::{Value, json};
use shatter_client::{Client, Deadline, Effect, FractureResult, Impact, Object, ObjectFacts};
use shatter_proto::{Error, ErrorKind};
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::mpsc::{Receiver, Sender};

/// Timeout of a reply of the service.
const REPLY_TIMEOUT: Duration = Duration::from_secs(5);

/// Timeout of the result of a request.
const RESULT_TIMEOUT: Duration = Duration::from_secs(120);

/// Longest time for a new daemon to load its objects.
const LOAD_TIMEOUT: Duration = Duration::from_secs(20);

/// A message of the page.
pub(crate) enum PageMessage {
    /// A request as JSON.
    Text(String),
    /// A file: its length of head (four bytes, little-endian), the head as JSON, the contents.
    Binary(Vec<u8>),
}

/// A message to the page.
pub(crate) enum Reply {
    /// JSON.
    Text(String),
    /// See [`ResultMessage`].
    Binary(Vec<u8>),
}

/// Parts that the workers of all pages share.
#[derive(Clone)]
pub(crate) struct WorkerSetup {
    pub daemon: Arc<ViewDaemon>,
    pub recording: Option<Arc<Recording>>,
    pub bakes: Arc<Bakes>,
}

/// Message for a page that cannot be served.
pub(crate) fn too_many_pages(most: usize) -> String {
    let message = format!("{most} pages are open already; close one of them, then load this page again");
    failure(0, &Error::new(ErrorKind::Busy, "pages", message)).to_string()
}

/// Message for a page that sends too many requests.
pub(crate) fn too_many_requests(most: usize) -> String {
    let message = format!("{most} requests of this page wait already; this one is refused");
    failure(0, &Error::new(ErrorKind::Busy, "requests", message)).to_string()
}

/// Starts the worker of a page. It ends when the page goes away.
pub(crate) fn start(setup: WorkerSetup, mut requests: Receiver<PageMessage>, replies: Sender<Reply>) {
    std::thread::spawn(move || {
        let mut worker = Worker { setup, client: None, replies, bake: None };
        while let Some(message) = requests.blocking_recv() {
            if !worker.handle(message) {
                return;
            }
        }
    });
}

struct Worker {
    setup: WorkerSetup,
    client: Option<Client>,
    replies: Sender<Reply>,
    bake: Option<BakeJob>,
}

/// The document of an error, in reply to request `id`.
fn failure(id: u64, error: &Error) -> Value {
    let mut document = error.document();
    document["id"] = json!(id);
    document
}

impl Worker {
    /// Serves one message. False if the page is gone.
    fn handle(&mut self, message: PageMessage) -> bool {
        let (id, outcome) = match message {
            PageMessage::Binary(bytes) => match file(&bytes) {
                Ok((head, contents)) => (id(&head), self.upload(&head, contents)),
                Err(error) => (0, Err(error)),
            },
            PageMessage::Text(text) => match serde_json::from_str::<Value>(&text) {
                Ok(request) => (id(&request), self.serve(&request)),
                Err(error) => (0, Err(invalid("request", format!("no JSON: {error}")))),
            },
        };
        let reply = outcome.unwrap_or_else(|error| Some(Reply::Text(failure(id, &error).to_string())));
        reply.is_none_or(|reply| self.replies.blocking_send(reply).is_ok())
    }

    fn serve(&mut self, request: &Value) -> Result<Option<Reply>, Error> {
        let id = id(request);
        let text = |mut value: Value| {
            value["id"] = json!(id);
            Ok(Some(Reply::Text(value.to_string())))
        };
        match request["op"].as_str() {
            Some("objects") => {
                let listed = self.objects()?;
                text(json!({
                    "reply": "objects",
                    "service": self.setup.daemon.service(),
                    "records": self.setup.recording.is_some(),
                    "objects": listed.iter().map(facts).collect::<Vec<_>>(),
                }))
            }
            Some("strike") => self.strike(id, request),
            Some("intact") => self.intact(id, request),
            Some("threshold") => {
                let result = self.result(request, &impact(&request["impact"])?.threshold_only())?;
                let summary = result.summary();
                text(json!({
                    "reply": "threshold",
                    "factor": summary.threshold_impulse_factor,
                    "radius_m": summary.radius_m,
                    "round_trip_ns": u64::try_from(result.round_trip().as_nanos()).unwrap_or(u64::MAX),
                }))
            }
            Some("download") => {
                let format = download::Format::by_name(request["format"].as_str().unwrap_or_default())?;
                let shown = self.shown(request)?;
                let layers = request["layers"].as_array();
                let is_whole = layers.is_some_and(|layers| layers.iter().all(|layer| layer["impact"].is_null()));
                let (name, bytes) = download::file(name(request)?, &shown, is_whole, format)?;
                let head = json!({ "id": id, "reply": "file", "name": name });
                Ok(Some(Reply::Binary(ResultMessage::new(head, &[("file", &bytes)]).into_bytes())))
            }
            Some("check_scene") => {
                let scene = request["scene"].as_str().ok_or_else(|| invalid("scene", "must be a text"))?;
                let daemon = &self.setup.daemon;
                let mut reply = scene_check::check(scene, request["paint"].as_str(), daemon.databases())?;
                reply["databases"] = scene_check::folder(name(request)?, daemon);
                text(reply)
            }
            Some("cancel_bake") => {
                self.bake = None;
                text(json!({ "reply": "canceled" }))
            }
            Some("save_recording") => {
                let recording = self.setup.recording.as_ref();
                let saved = recording.map(|recording| recording.write()).transpose()?;
                text(json!({ "reply": "saved", "file": saved.map(|file| file.display().to_string()) }))
            }
            _ => Err(invalid("op", "unknown; load the page again")),
        }
    }

    /// The object in one piece, as the service would send its fragments.
    fn intact(&mut self, id: u64, request: &Value) -> Result<Option<Reply>, Error> {
        let enabled = effects(request, "enable")?;
        let (result, material) = self.whole(request, &enabled)?;
        Ok(Some(self.message(id, request, &result, &material)))
    }

    /// The object in one piece, and its material.
    fn whole(&mut self, request: &Value, enabled: &[Effect]) -> Result<(FractureResult, String), Error> {
        let name = name(request)?;
        self.with_client(|client| {
            let object = ready(client, name)?;
            let impact = object.even(1, Deadline::after(RESULT_TIMEOUT))?;
            let impact = enabled.iter().fold(impact, |impact, effect| impact.enable(*effect));
            let result = object.strike(&impact)?.wait(Deadline::after(RESULT_TIMEOUT))?;
            Ok((result, object.facts().material.clone()))
        })
    }

    /// The results of the impacts in `layers`, each with the pieces that are shown of it. A layer without an impact is the whole object.
    fn shown(&mut self, request: &Value) -> Result<Vec<ShownPieces>, Error> {
        let layers = request["layers"].as_array().ok_or_else(|| invalid("layers", "must be a list"))?;
        let enabled = effects(request, "enable")?;
        let mut shown = Vec::new();
        for layer in layers {
            let result = match &layer["impact"] {
                Value::Null => self.whole(request, &enabled)?.0,
                given => self.result(request, &impact(given)?)?,
            };
            let ids = serde_json::from_value(layer["pieces"].clone());
            let ids = ids.map_err(|error| invalid("pieces", format!("must be a list of ids: {error}")))?;
            shown.push(ShownPieces { result, ids });
        }
        Ok(shown)
    }

    fn strike(&mut self, id: u64, request: &Value) -> Result<Option<Reply>, Error> {
        let (result, material) = self.struck(request, &impact(&request["impact"])?)?;
        Ok(Some(self.message(id, request, &result, &material)))
    }

    /// The message of a result, which is also recorded unless the request says otherwise.
    fn message(&self, id: u64, request: &Value, result: &FractureResult, material: &str) -> Reply {
        let has_hashes = request["hashes"].as_bool() == Some(true);
        let message = ResultMessage::of_result(id, result, material, has_hashes).into_bytes();
        let is_recorded = request["is_recorded"].as_bool() != Some(false);
        if let Some(recording) = self.setup.recording.as_ref().filter(|_| is_recorded) {
            recording.add(request, &message);
        }
        Reply::Binary(message)
    }

    /// Begins the bake of a mesh file of the page.
    fn upload(&mut self, head: &Value, contents: &[u8]) -> Result<Option<Reply>, Error> {
        self.bake = Some(baking::start(id(head), head, contents, &self.setup, self.replies.clone())?);
        Ok(None)
    }

    fn objects(&mut self) -> Result<Vec<ObjectFacts>, Error> {
        self.with_client(|client| client.objects(Deadline::after(REPLY_TIMEOUT)))
    }

    fn result(&mut self, request: &Value, impact: &Impact) -> Result<FractureResult, Error> {
        self.struck(request, impact).map(|(result, _)| result)
    }

    /// The result of an impact, and the object's material.
    fn struck(&mut self, request: &Value, impact: &Impact) -> Result<(FractureResult, String), Error> {
        let name = name(request)?;
        self.with_client(|client| {
            let object = ready(client, name)?;
            let result = object.strike(impact)?.wait(Deadline::after(RESULT_TIMEOUT))?;
            Ok((result, object.facts().material.clone()))
        })
    }

    /// Calls `call` with a connection. If the daemon is ours and ended, starts it again and repeats the call.
    fn with_client<T>(&mut self, call: impl Fn(&Client) -> Result<T, Error>) -> Result<T, Error> {
        match self.client().and_then(|client| call(&client)) {
            Err(error) if matches!(error.kind, ErrorKind::NoDaemon | ErrorKind::Lost) => {
                self.client = None;
                if self.setup.daemon.revive()? { self.client().and_then(|client| call(&client)) } else { Err(error) }
            }
            outcome => outcome,
        }
    }

    fn client(&mut self) -> Result<Client, Error> {
        if let Some(client) = &self.client {
            return Ok(client.clone());
        }
        let client = Client::connect(self.setup.daemon.service(), Deadline::after(REPLY_TIMEOUT))?;
        Ok(self.client.insert(client).clone())
    }
}

/// The object `name`; waits while it is being loaded.
fn ready(client: &Client, name: &str) -> Result<Object, Error> {
    let deadline = Deadline::after(LOAD_TIMEOUT);
    loop {
        match client.object(name, Deadline::after(REPLY_TIMEOUT)) {
            Err(error) if error.kind == ErrorKind::Loading && !deadline.passed() => {
                std::thread::sleep(Duration::from_millis(20));
            }
            outcome => return outcome,
        }
    }
}

/// The object of a request.
fn name(request: &Value) -> Result<&str, Error> {
    request["object"].as_str().ok_or_else(|| invalid("object", "must be a name"))
}

fn id(request: &Value) -> u64 {
    request["id"].as_u64().unwrap_or(0)
}

/// Head and contents of a file of the page.
fn file(bytes: &[u8]) -> Result<(Value, &[u8]), Error> {
    let malformed = || invalid("file", "the message has no head");
    let (length, rest) = bytes.split_first_chunk::<4>().ok_or_else(malformed)?;
    let (head, contents) = rest.split_at_checked(u32::from_le_bytes(*length) as usize).ok_or_else(malformed)?;
    Ok((serde_json::from_slice(head).map_err(|_| malformed())?, contents))
}

fn facts(facts: &ObjectFacts) -> Value {
    json!({
        "name": facts.name,
        "state": facts.state.name(),
        "error": facts.error.as_ref().map(|error| error.message.clone()),
        "material": facts.material,
        "bodies": facts.bodies,
        "young_pa": facts.young_pa,
        "poisson": facts.poisson,
        "density_kg_m3": facts.density_kg_m3,
        "volume_m3": facts.volume_m3,
        "diagonal_m": facts.diagonal_m,
        "bounds_m": facts.bounds_m,
        "radius_m": facts.radius_m,
        "duration_s": facts.duration_s,
        "gamma_j_m2": facts.gamma_j_m2,
        "crack_nodes": facts.crack_nodes,
        "generation": facts.generation,
    })
}
