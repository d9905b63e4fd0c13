//! From the name of a service to a connection.

use crate::control::{self, ObjectFacts, Status};
use crate::session::{Attempt, Session};
use crate::{Deadline, Object};
use shatter_proto::convention::Convention;
use shatter_proto::name::{ServiceName, unknown_object};
use shatter_proto::{Error, ErrorKind};
use shatter_transport::paths::ServicePaths;
use std::ffi::OsString;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Pause between two looks for a daemon that is starting.
const PAUSE: Duration = Duration::from_millis(5);

/// The service where nothing names another.
const SERVICE: &str = "default";

/// Who finds no place waits so long for one: the daemon may not have buried those who died a moment ago.
const PLACE: Duration = Duration::from_secs(1);
/// How long a hold that is dropped waits for the reply; the service gives the answer back by itself after a while.
const GOODBYE: Duration = Duration::from_millis(100);

/// A connection to a service. Cheap to clone: clones share it.
///
/// It outlives the daemon: strikes and questions under way when a daemon goes away end with `lost`, and the next ones go to
/// the daemon that then serves, or end with `no_daemon` at once.
#[derive(Clone)]
pub struct Client {
    line: Arc<Session>,
    convention: Convention,
}

/// An answer that the service keeps; dropping this gives it back, and waits for the reply for a tenth of a second at most.
pub struct RetainGuard {
    service: Client,
    handle: u64,
}

impl RetainGuard {
    /// Names the answer to strikes.
    pub fn handle(&self) -> u64 {
        self.handle
    }
}

impl Drop for RetainGuard {
    fn drop(&mut self) {
        if let Err(refusal) = self.service.release(self.handle, Deadline::after(GOODBYE)) {
            tracing::debug!(%refusal, "an answer was not given back");
        }
    }
}

/// Where the service `name` of this user lives.
///
/// # Errors
/// `service_name` for a name that a service cannot have, `runtime_folder` where the user has none.
pub fn place(name: &str) -> Result<ServicePaths, Error> {
    let name = ServiceName::new(name)?;
    let runtime = std::env::var_os("XDG_RUNTIME_DIR");
    Ok(ServicePaths::new(&name, runtime.as_deref().map(Path::new), rustix::process::geteuid().as_raw()))
}

/// Environment variable that names the service of those who name none.
pub const SERVICE_VARIABLE: &str = "SHATTER_SERVICE";

/// The service of those who name none: `SHATTER_SERVICE`, or `default` where that is not set.
///
/// # Errors
/// `service_name` if the variable holds no name of a service.
pub fn default_service() -> Result<String, Error> {
    named(std::env::var_os(SERVICE_VARIABLE))
}

/// The service that this value of the variable names.
fn named(variable: Option<OsString>) -> Result<String, Error> {
    let Some(variable) = variable else { return Ok(SERVICE.to_owned()) };
    let name = ServiceName::new(&variable.to_string_lossy());
    name.map(|name| name.as_str().to_owned()).map_err(|refusal| {
        Error::new(ErrorKind::ServiceName, SERVICE_VARIABLE, format!("{SERVICE_VARIABLE}: {refusal}"))
    })
}

impl Client {
    /// Connects, as [`Self::connect`], to the service that `SHATTER_SERVICE` names, or to `default` where that is not set.
    ///
    /// # Errors
    /// Those of [`Self::connect`].
    pub fn connect_default(deadline: Deadline) -> Result<Self, Error> {
        Self::connect(&default_service()?, deadline)
    }

    /// Connects to the service `name`. Without a daemon the refusal comes at once; one that is starting is waited for, and a place
    /// for a second.
    ///
    /// # Errors
    /// `no_daemon`, `version_mismatch` (names both versions), `busy` (no place for another client),
    /// `runtime_folder`, `service_name`, `transport`.
    pub fn connect(name: &str, deadline: Deadline) -> Result<Self, Error> {
        Self::connect_at(&place(name)?, deadline)
    }

    /// Connects to the service at `place`, as [`Self::connect`].
    ///
    /// # Errors
    /// Those of [`Self::connect`].
    pub fn connect_at(place: &ServicePaths, deadline: Deadline) -> Result<Self, Error> {
        let begun = Instant::now();
        let full = |refusal: &Error| refusal.kind == ErrorKind::Busy && begun.elapsed() < PLACE && !deadline.passed();
        loop {
            match Session::open(place) {
                Ok(line) => return Ok(Self { line: Arc::new(line), convention: Convention::default() }),
                Err(Attempt::Final(refusal)) if full(&refusal) => std::thread::sleep(PAUSE.min(deadline.left())),
                Err(Attempt::Final(refusal)) => return Err(refusal),
                Err(Attempt::Starting(refusal)) if deadline.passed() => return Err(refusal),
                Err(Attempt::Starting(_)) => std::thread::sleep(PAUSE.min(deadline.left())),
            }
        }
    }

    /// Connects like [`Self::connect`], but waits for a daemon to appear.
    ///
    /// # Errors
    /// Those of [`Self::connect`].
    pub fn wait_for(name: &str, deadline: Deadline) -> Result<Self, Error> {
        let place = place(name)?;
        loop {
            match Self::connect_at(&place, deadline) {
                Err(refusal) if refusal.kind == ErrorKind::NoDaemon && !deadline.passed() => {
                    std::thread::sleep(PAUSE.min(deadline.left()));
                }
                result => return result,
            }
        }
    }

    /// The same connection for a host with these coordinates: impacts of objects taken from it are read, and their answers written, in
    /// its axes, unit and winding. A host has one of them, so it is said once and not with every impact, where it could be forgotten;
    /// clones of one connection may have different ones. What is none is refused with the strike, as `convention`.
    pub fn with_convention(&self, convention: Convention) -> Self {
        Self { line: self.line.clone(), convention }
    }

    /// All objects, ready or not, by name.
    ///
    /// # Errors
    /// `no_daemon`, `lost` or `transport` if the connection fails, `late` after the deadline.
    pub fn objects(&self, deadline: Deadline) -> Result<Vec<ObjectFacts>, Error> {
        self.line.over(|link| control::objects(&link, deadline))
    }

    /// The object `name`, ready to be struck.
    ///
    /// # Errors
    /// `unknown_object`, `corrupt_object`, and those of [`Self::objects`].
    pub fn object(&self, name: &str, deadline: Deadline) -> Result<Object, Error> {
        let objects = self.objects(deadline)?;
        let names: Vec<String> = objects.iter().map(|facts| facts.name.clone()).collect();
        match objects.into_iter().find(|facts| facts.name == name) {
            Some(facts) => match facts.refusal {
                Some(refusal) if !facts.ready => Err(refusal),
                _ => Ok(Object::new(self.line.clone(), self.convention, facts)),
            },
            None => {
                let names: Vec<&str> = names.iter().map(String::as_str).collect();
                Err(unknown_object(name, &names))
            }
        }
    }

    /// Sleeps until the service has something for this connection, a few milliseconds have passed, or the deadline: between two
    /// looks at tickets, for a thread that has nothing else to do.
    pub fn wait_for_reply(&self, deadline: Deadline) {
        self.line.last().wait(deadline);
    }

    /// Gives back the answer that is kept under `handle`: its fragments cannot be struck any more. Strikes that were sent before over
    /// this connection still find it.
    ///
    /// # Errors
    /// `unknown_handle` if none is, and those of [`Self::objects`].
    pub fn release(&self, handle: u64, deadline: Deadline) -> Result<(), Error> {
        self.line.over(|link| control::release(&link, handle, deadline))
    }

    /// Gives the answer that is kept under `handle` back once the hold is dropped.
    pub fn retain(&self, handle: u64) -> RetainGuard {
        RetainGuard { service: self.clone(), handle }
    }

    /// How the service goes.
    ///
    /// # Errors
    /// Those of [`Self::objects`].
    pub fn status(&self, deadline: Deadline) -> Result<Status, Error> {
        self.line.over(|link| control::status(&link, deadline))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_names_no_service_gets_that_of_the_environment() {
        assert_eq!(named(None), Ok("default".to_owned()));
        assert_eq!(named(Some("studio".into())), Ok("studio".to_owned()));
        for odd in ["", "a b"] {
            let refusal = named(Some(odd.into())).unwrap_err();
            assert_eq!(
                (refusal.kind, refusal.at.as_str()),
                (ErrorKind::ServiceName, SERVICE_VARIABLE),
                "{}",
                refusal.message
            );
        }
    }
}
