//! A session with a service, whichever daemon serves: a connection, and a new one once its daemon is lost.

use crate::connection::Connection;
use shatter_proto::name::nearest;
use shatter_proto::{Error, ErrorKind};
use shatter_transport::daemon_info::DaemonInfo;
use shatter_transport::instance::Instance;
use shatter_transport::paths::ServicePaths;
use shatter_transport::regular_file;
use shatter_transport::workarounds::dead_daemon::daemon_lives;
use shatter_transport::workarounds::unclear_errors::{explain_lost, explain_unreached};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A session with a service. It outlives daemons.
pub(crate) struct Session {
    paths: ServicePaths,
    connection: Mutex<Arc<Connection>>,
}

impl Session {
    /// Connects to the daemon that serves now.
    pub(crate) fn open(paths: &ServicePaths) -> Result<Self, ConnectError> {
        let connection = Mutex::new(Arc::new(connect(paths)?));
        Ok(Self { paths: paths.clone(), connection })
    }

    fn guard(&self) -> MutexGuard<'_, Arc<Connection>> {
        self.connection.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The connection that was used last, be it lost.
    pub(crate) fn last(&self) -> Arc<Connection> {
        self.guard().clone()
    }

    /// A connection to the daemon that serves now: the last one, or a new one if another daemon serves. Never waits; connecting
    /// takes some milliseconds, once per daemon.
    ///
    /// # Errors
    /// As [`ConnectError`].
    fn connection(&self) -> Result<Arc<Connection>, Error> {
        let mut connection = self.guard();
        if connection.is_lost() || !connection.daemon_lives() {
            *connection = Arc::new(connect(&self.paths)?);
        }
        Ok(connection.clone())
    }

    /// A call over the connection; over a new one if it is lost and a daemon serves.
    ///
    /// Right after other clients died the transport may take a living client for one of them. It keeps no request that reached no
    /// daemon or got no reply.
    ///
    /// # Errors
    /// Those of the call, and `no_daemon`, `version_mismatch`, `busy` or `transport` if the new connection fails.
    pub(crate) fn call<T>(&self, call: impl Fn(Arc<Connection>) -> Result<T, Error>) -> Result<T, Error> {
        match call(self.connection()?) {
            Err(lost) if lost.kind == ErrorKind::Lost => match self.connection() {
                Ok(connection) => {
                    call(connection.clone()).map_err(|lost| explain_lost(lost, || connection.daemon_lives()))
                }
                Err(_) => Err(lost),
            },
            result => result,
        }
    }
}

/// Why an attempt to connect failed.
pub(crate) enum ConnectError {
    /// Trying again changes nothing.
    Final(Error),
    /// A daemon is starting, or just ended.
    Starting(Error),
}

impl From<ConnectError> for Error {
    fn from(error: ConnectError) -> Self {
        match error {
            ConnectError::Final(error) | ConnectError::Starting(error) => error,
        }
    }
}

fn connect(paths: &ServicePaths) -> Result<Connection, ConnectError> {
    if !paths.exists().map_err(ConnectError::Final)? || !daemon_lives(paths) {
        let error = no_daemon(paths, "no daemon of service");
        let (folder, likely, start) = (folder_choice(paths), likely_service(paths), paths.start_command());
        let message = format!("{error} ({folder}); {likely}start one with `{start}`");
        return Err(ConnectError::Final(Error { message, ..error }));
    }
    let Ok(json) = regular_file::read(&paths.hello()) else {
        return Err(ConnectError::Starting(not_ready(paths)));
    };
    let info = DaemonInfo::from_json(&json).map_err(ConnectError::Final)?;
    info.check().map_err(ConnectError::Final)?;
    let starting = || ConnectError::Starting(not_ready(paths));
    let instance = Instance::of_token(paths, &info.instance).ok_or_else(starting)?;
    let connection = Connection::open(paths, &instance).map_err(|error| match error.kind {
        ErrorKind::Transport => ConnectError::Starting(
            explain_unreached(error)
                .unwrap_or_else(|error| no_daemon(paths, &format!("not ready ({error}): the daemon of service"))),
        ),
        // The folder of a daemon that ended meanwhile.
        ErrorKind::RuntimeFolder if !daemon_serves(paths, &instance) => starting(),
        _ => ConnectError::Final(error),
    })?;
    // The file may be that of a daemon that was killed, read before its successor removed it.
    if connection.daemon_lives() { Ok(connection) } else { Err(starting()) }
}

/// Source of the runtime folder: a daemon with another `XDG_RUNTIME_DIR` is not found.
fn folder_choice(paths: &ServicePaths) -> &'static str {
    let runtime = std::env::var_os("XDG_RUNTIME_DIR").filter(|runtime| !runtime.is_empty());
    match runtime.is_some_and(|runtime| paths.folder.starts_with(runtime)) {
        true => "the folder that XDG_RUNTIME_DIR names; it must be the same for the daemon",
        false => "XDG_RUNTIME_DIR is not set; if it is for the daemon, set the same one",
    }
}

/// Suggestion of services with similar names whose daemons run.
fn likely_service(paths: &ServicePaths) -> String {
    let running = paths.others().filter(daemon_lives).map(|other| other.service.as_str().to_owned());
    let running: Vec<String> = running.collect();
    let running: Vec<&str> = running.iter().map(String::as_str).collect();
    let likely: Vec<String> =
        nearest(paths.service.as_str(), &running).iter().map(|name| format!("`{name}`")).collect();
    if likely.is_empty() {
        String::new()
    } else {
        format!("service {} runs: choose it (--service, SHATTER_SERVICE); else ", likely.join(" or "))
    }
}

/// Whether the daemon announces that it serves at `instance`.
fn daemon_serves(paths: &ServicePaths, instance: &Instance) -> bool {
    Instance::serving(paths).is_ok_and(|serving| serving == *instance)
}

fn not_ready(paths: &ServicePaths) -> Error {
    let error = no_daemon(paths, "no client can connect yet to the daemon of service");
    let message =
        format!("{error}; it may still load its databases: wait, or wait longer (--wait SECONDS, `wait_for`)");
    Error { message, ..error }
}

fn no_daemon(paths: &ServicePaths, what: &str) -> Error {
    let service = paths.service.as_str();
    let message = format!("{what} `{service}` in {}", paths.folder.display());
    Error::new(ErrorKind::NoDaemon, service, message)
}
