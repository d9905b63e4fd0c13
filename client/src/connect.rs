//! From the name of a service to a connection.

use crate::control::{self, ObjectFacts, Status};
use crate::link::{Link, daemon_lives};
use crate::{Deadline, Object};
use shatter_proto::hello::Hello;
use shatter_proto::name::ServiceName;
use shatter_proto::place::Place;
use shatter_proto::{Kind, Refusal};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// Pause between two looks for a daemon that is starting.
const PAUSE: Duration = Duration::from_millis(5);

/// A connection to a service. Cheap to clone: clones share it.
#[derive(Clone)]
pub struct Shatter {
    link: Arc<Link>,
}

/// Where the service `name` of this user lives.
pub fn place(name: &str) -> Result<Place, Refusal> {
    let name = ServiceName::new(name)?;
    let runtime = std::env::var_os("XDG_RUNTIME_DIR");
    Ok(Place::new(&name, runtime.as_deref().map(Path::new), rustix::process::geteuid().as_raw()))
}

impl Shatter {
    /// Connects to the service `name`. Without a daemon the refusal comes at once; one that is starting is waited for.
    ///
    /// Errors: `no_daemon`, `version_mismatch` (names both versions), `busy` (no place for another client),
    /// `runtime_folder`, `service_name`, `transport`.
    pub fn connect(name: &str, deadline: Deadline) -> Result<Self, Refusal> {
        Self::connect_at(&place(name)?, deadline)
    }

    /// Connects to the service at `place`, as [`Self::connect`].
    pub fn connect_at(place: &Place, deadline: Deadline) -> Result<Self, Refusal> {
        loop {
            match attempt(place) {
                Ok(link) => return Ok(Self { link: Arc::new(link) }),
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
        control::objects(&self.link, deadline)
    }

    /// The object `name`, ready to be struck. Errors: `unknown_object`, `corrupt_object`.
    pub fn object(&self, name: &str, deadline: Deadline) -> Result<Object, Refusal> {
        let objects = self.objects(deadline)?;
        match objects.into_iter().find(|facts| facts.name == name) {
            Some(facts) => match facts.refusal {
                Some(refusal) if !facts.ready => Err(refusal),
                _ => Ok(Object::new(self.link.clone(), facts)),
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
        self.link.doze(deadline);
    }

    /// How the service goes.
    pub fn status(&self, deadline: Deadline) -> Result<Status, Refusal> {
        control::status(&self.link, deadline)
    }
}

/// Why an attempt to connect failed.
enum Attempt {
    /// Trying again changes nothing.
    Final(Refusal),
    /// A daemon is starting, or just ended.
    Starting(Refusal),
}

fn attempt(place: &Place) -> Result<Link, Attempt> {
    if !place.exists().map_err(Attempt::Final)? || !daemon_lives(place) {
        return Err(Attempt::Final(no_daemon(place, "no daemon of service")));
    }
    let Ok(json) = std::fs::read_to_string(place.hello()) else {
        return Err(Attempt::Starting(no_daemon(place, "not ready in time: the daemon of service")));
    };
    Hello::from_json(&json).and_then(|hello| hello.check()).map_err(Attempt::Final)?;
    Link::open(place).map_err(|refusal| match refusal.kind {
        Kind::Transport => Attempt::Starting(refusal),
        _ => Attempt::Final(refusal),
    })
}

fn no_daemon(place: &Place, what: &str) -> Refusal {
    let service = place.service.as_str();
    let message = format!("{what} `{service}` in {}", place.folder.display());
    Refusal::new(Kind::NoDaemon, service, message)
}
