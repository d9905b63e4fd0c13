//! From the name of a service to a connection.

use crate::control::{self, ObjectFacts, Status};
use crate::line::{Attempt, Line};
use crate::{Deadline, Object};
use shatter_proto::name::ServiceName;
use shatter_proto::place::Place;
use shatter_proto::{Kind, Refusal};
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Pause between two looks for a daemon that is starting.
const PAUSE: Duration = Duration::from_millis(5);

/// Who finds no place waits so long for one: the daemon may not have buried those who died a moment ago.
const PLACE: Duration = Duration::from_secs(1);

/// A connection to a service. Cheap to clone: clones share it.
///
/// It outlives the daemon: strikes and questions under way when a daemon goes away end with `lost`, and the next ones go to
/// the daemon that then serves, or end with `no_daemon` at once.
#[derive(Clone)]
pub struct Shatter {
    line: Arc<Line>,
}

/// Where the service `name` of this user lives.
pub fn place(name: &str) -> Result<Place, Refusal> {
    let name = ServiceName::new(name)?;
    let runtime = std::env::var_os("XDG_RUNTIME_DIR");
    Ok(Place::new(&name, runtime.as_deref().map(Path::new), rustix::process::geteuid().as_raw()))
}

impl Shatter {
    /// Connects to the service `name`. Without a daemon the refusal comes at once; one that is starting is waited for, and a place
    /// for a second.
    ///
    /// Errors: `no_daemon`, `version_mismatch` (names both versions), `busy` (no place for another client),
    /// `runtime_folder`, `service_name`, `transport`.
    pub fn connect(name: &str, deadline: Deadline) -> Result<Self, Refusal> {
        Self::connect_at(&place(name)?, deadline)
    }

    /// Connects to the service at `place`, as [`Self::connect`].
    pub fn connect_at(place: &Place, deadline: Deadline) -> Result<Self, Refusal> {
        let begun = Instant::now();
        let full = |refusal: &Refusal| refusal.kind == Kind::Busy && begun.elapsed() < PLACE && !deadline.passed();
        loop {
            match Line::open(place) {
                Ok(line) => return Ok(Self { line: Arc::new(line) }),
                Err(Attempt::Final(refusal)) if full(&refusal) => std::thread::sleep(PAUSE.min(deadline.left())),
                Err(Attempt::Final(refusal)) => return Err(refusal),
                Err(Attempt::Starting(refusal)) if deadline.passed() => return Err(refusal),
                Err(Attempt::Starting(_)) => std::thread::sleep(PAUSE.min(deadline.left())),
            }
        }
    }

    /// Connects like [`Self::connect`], but waits for a daemon to appear.
    pub fn wait_for(name: &str, deadline: Deadline) -> Result<Self, Refusal> {
        let place = place(name)?;
        loop {
            match Self::connect_at(&place, deadline) {
                Err(refusal) if refusal.kind == Kind::NoDaemon && !deadline.passed() => {
                    std::thread::sleep(PAUSE.min(deadline.left()));
                }
                result => return result,
            }
        }
    }

    /// All objects, ready or not, by name.
    pub fn objects(&self, deadline: Deadline) -> Result<Vec<ObjectFacts>, Refusal> {
        let link = self.line.link()?;
        control::objects(&link, deadline)
    }

    /// The object `name`, ready to be struck. Errors: `unknown_object`, `corrupt_object`.
    pub fn object(&self, name: &str, deadline: Deadline) -> Result<Object, Refusal> {
        let objects = self.objects(deadline)?;
        match objects.into_iter().find(|facts| facts.name == name) {
            Some(facts) => match facts.refusal {
                Some(refusal) if !facts.ready => Err(refusal),
                _ => Ok(Object::new(self.line.clone(), facts)),
            },
            None => {
                let message = format!("the service has no object `{name}`");
                Err(Refusal::new(Kind::UnknownObject, name, message))
            }
        }
    }

    /// Sleeps until the service has something for this connection, a few milliseconds have passed, or the deadline: between two
    /// looks at tickets, for a thread that has nothing else to do.
    pub fn doze(&self, deadline: Deadline) {
        self.line.last().doze(deadline);
    }

    /// How the service goes.
    pub fn status(&self, deadline: Deadline) -> Result<Status, Refusal> {
        let link = self.line.link()?;
        control::status(&link, deadline)
    }
}
