//! Connecting to a service by its name.

use crate::control::{self, ObjectFacts};
use crate::session::{ConnectError, Session};
use crate::{Deadline, Object, Status};
use shatter_proto::control::ObjectState;
use shatter_proto::convention::Convention;
use shatter_proto::name::{ServiceName, object_being_loaded, object_name, unknown_object};
use shatter_proto::{Error, ErrorKind};
use shatter_transport::paths::ServicePaths;
use std::ffi::OsString;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Pause between two attempts to connect to a daemon that is starting.
const PAUSE: Duration = Duration::from_millis(5);

/// The default service.
const SERVICE: &str = "default";

/// Time during which connecting is retried while the service has its maximum number of clients: the daemon may not have removed dead ones yet.
const FULL_WAIT: Duration = Duration::from_secs(1);

/// Longest time for which dropping a guard waits for the reply; the service drops the result by itself after a while.
const RELEASE_WAIT: Duration = Duration::from_millis(100);

/// A connection to a service. Cheap to clone: clones share it.
///
/// It outlives the daemon: requests under way when a daemon goes away end with `lost`, and the next ones go to
/// the daemon that then serves, or end with `no_daemon` at once.
#[derive(Clone)]
pub struct Client {
    session: Arc<Session>,
    convention: Convention,
}

/// Releases a result that the service keeps when it is dropped; waits for the reply for a tenth of a second at most.
#[must_use = "dropping a guard releases the result"]
pub struct RetainGuard {
    client: Client,
    handle: u64,
}

impl RetainGuard {
    /// Names the result to later requests.
    #[must_use]
    pub fn handle(&self) -> u64 {
        self.handle
    }
}

impl Drop for RetainGuard {
    fn drop(&mut self) {
        if let Err(error) = self.client.release(self.handle, Deadline::after(RELEASE_WAIT)) {
            tracing::debug!(%error, "a result was not released");
        }
    }
}

/// The files and folders of this user's service `name`.
///
/// # Errors
/// `service_name` for a name that a service cannot have.
pub fn service_paths(name: &str) -> Result<ServicePaths, Error> {
    let name = ServiceName::new(name)?;
    let runtime = std::env::var_os("XDG_RUNTIME_DIR");
    Ok(ServicePaths::new(&name, runtime.as_deref().map(Path::new), rustix::process::geteuid().as_raw()))
}

/// Environment variable that names the default service.
pub const SERVICE_VARIABLE: &str = "SHATTER_SERVICE";

/// The default service: the value of `SHATTER_SERVICE`, or `default` where that is not set.
///
/// # Errors
/// `service_name` if the variable holds no name of a service.
pub fn default_service() -> Result<String, Error> {
    named(std::env::var_os(SERVICE_VARIABLE))
}

/// The service that a value of the variable names.
fn named(variable: Option<OsString>) -> Result<String, Error> {
    let Some(variable) = variable else { return Ok(SERVICE.to_owned()) };
    let name = ServiceName::new(&variable.to_string_lossy());
    name.map(|name| name.as_str().to_owned())
        .map_err(|error| Error::new(ErrorKind::ServiceName, SERVICE_VARIABLE, format!("{SERVICE_VARIABLE}: {error}")))
}

impl Client {
    /// Connects, as [`Self::connect`], to the service that `SHATTER_SERVICE` names, or to `default` where that is not set.
    ///
    /// # Errors
    /// Those of [`Self::connect`].
    pub fn connect_default(deadline: Deadline) -> Result<Self, Error> {
        Self::connect(&default_service()?, deadline)
    }

    /// Connects to the service `name`. Without a daemon this fails at once; it waits for one that is starting, and up to a second
    /// where the service has as many clients as it may.
    ///
    /// # Errors
    /// `no_daemon`, `version_mismatch` (names both versions), `busy` (as many clients as it may have), `shared_memory`,
    /// `runtime_folder`, `service_name`, `transport`.
    pub fn connect(name: &str, deadline: Deadline) -> Result<Self, Error> {
        Self::connect_at(&service_paths(name)?, deadline)
    }

    /// Connects to the service at `paths`, as [`Self::connect`].
    ///
    /// # Errors
    /// Those of [`Self::connect`].
    pub fn connect_at(paths: &ServicePaths, deadline: Deadline) -> Result<Self, Error> {
        let begun = Instant::now();
        let is_full =
            |error: &Error| error.kind == ErrorKind::Busy && begun.elapsed() < FULL_WAIT && !deadline.passed();
        loop {
            match Session::open(paths) {
                Ok(session) => return Ok(Self { session: Arc::new(session), convention: Convention::default() }),
                Err(ConnectError::Final(error)) if is_full(&error) => std::thread::sleep(PAUSE.min(deadline.left())),
                Err(ConnectError::Final(error)) => return Err(error),
                Err(ConnectError::Starting(error)) if deadline.passed() => return Err(error),
                Err(ConnectError::Starting(_)) => std::thread::sleep(PAUSE.min(deadline.left())),
            }
        }
    }

    /// Connects like [`Self::connect`], but waits for a daemon to appear.
    ///
    /// # Errors
    /// Those of [`Self::connect`].
    pub fn wait_for(name: &str, deadline: Deadline) -> Result<Self, Error> {
        let paths = service_paths(name)?;
        loop {
            match Self::connect_at(&paths, deadline) {
                Err(error) if error.kind == ErrorKind::NoDaemon && !deadline.passed() => {
                    std::thread::sleep(PAUSE.min(deadline.left()));
                }
                result => return result,
            }
        }
    }

    /// The same connection for a host with these coordinates: the service reads impacts and writes results in its axes, unit and
    /// winding. Clones of one connection may have different conventions. An invalid one fails with the request, as `convention`.
    #[must_use]
    pub fn with_convention(&self, convention: Convention) -> Self {
        Self { session: self.session.clone(), convention }
    }

    /// All objects, ready or not, by name.
    ///
    /// # Errors
    /// `no_daemon`, `lost`, `busy` (at once: this connection has as many requests under way as it may), `shared_memory` or `transport`
    /// if the connection fails, `late` after the deadline.
    pub fn objects(&self, deadline: Deadline) -> Result<Vec<ObjectFacts>, Error> {
        self.session.call(|connection| control::objects(&connection, deadline))
    }

    /// The object `name`, ready to be struck.
    ///
    /// # Errors
    /// `object_name`, `unknown_object`, `corrupt_object`, `loading`, and those of [`Self::objects`].
    pub fn object(&self, name: &str, deadline: Deadline) -> Result<Object, Error> {
        object_name(name)?;
        let objects = self.objects(deadline)?;
        match objects.iter().position(|facts| facts.name == name) {
            Some(place) => {
                let facts = objects[place].clone();
                match facts.error {
                    Some(error) if facts.state != ObjectState::Ready => Err(error),
                    _ => Ok(Object::new(self.session.clone(), self.convention, facts)),
                }
            }
            None => Err(not_listed(name, &objects)),
        }
    }

    /// Sleeps until the service notifies this connection, a few milliseconds have passed, or the deadline: between two polls of
    /// tickets, for a thread that has nothing else to do.
    pub fn wait_for_reply(&self, deadline: Deadline) {
        self.session.last().wait(deadline);
    }

    /// Releases the result that the service keeps under `handle`: its fragments cannot be struck any more. Requests that this
    /// connection sent before still find it.
    ///
    /// # Errors
    /// `unknown_handle` if the service keeps none, and those of [`Self::objects`].
    pub fn release(&self, handle: u64, deadline: Deadline) -> Result<(), Error> {
        self.session.call(|connection| control::release(&connection, handle, deadline))
    }

    /// Releases the result that the service keeps under `handle` once the guard is dropped.
    pub fn retain(&self, handle: u64) -> RetainGuard {
        RetainGuard { client: self.clone(), handle }
    }

    /// State of the service.
    ///
    /// # Errors
    /// Those of [`Self::objects`].
    pub fn status(&self, deadline: Deadline) -> Result<Status, Error> {
        self.session.call(|connection| control::status(&connection, deadline))
    }
}

/// The error for an object that is not in the list: a file that is still being loaded may hold it.
fn not_listed(name: &str, objects: &[ObjectFacts]) -> Error {
    let loading = objects.iter().filter(|facts| facts.state == ObjectState::Loading);
    let mut errors = loading.filter_map(|facts| Some((&facts.name, facts.error.as_ref()?)));
    match errors.next() {
        Some((file, error)) => Error { retry_after: error.retry_after, ..object_being_loaded(name, file) },
        None => {
            let ready = objects.iter().filter(|facts| facts.state == ObjectState::Ready);
            unknown_object(name, &ready.map(|facts| facts.name.as_str()).collect::<Vec<_>>())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_service_is_that_of_the_environment() {
        assert_eq!(named(None), Ok("default".to_owned()));
        assert_eq!(named(Some("studio".into())), Ok("studio".to_owned()));
        for odd in ["", "a b"] {
            let error = named(Some(odd.into())).unwrap_err();
            assert_eq!(
                (error.kind, error.at.as_str()),
                (ErrorKind::ServiceName, SERVICE_VARIABLE),
                "{}",
                error.message
            );
        }
    }
}
