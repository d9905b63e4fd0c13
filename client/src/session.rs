//! The way to a service, whichever daemon serves: a link, and a new one once its daemon is lost.

use crate::connection::Connection;
use shatter_proto::{Error, ErrorKind};
use shatter_transport::daemon_info::DaemonInfo;
use shatter_transport::instance::Instance;
use shatter_transport::paths::ServicePaths;
use shatter_transport::workarounds::dead_daemon::any_lives;
use shatter_transport::workarounds::unclear_errors::unmapped;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The way to a service. It outlives daemons.
pub(crate) struct Session {
    place: ServicePaths,
    link: Mutex<Arc<Connection>>,
}

impl Session {
    /// Opens it to the daemon that serves now.
    pub(crate) fn open(place: &ServicePaths) -> Result<Self, Attempt> {
        let link = Mutex::new(Arc::new(attempt(place)?));
        Ok(Self { place: place.clone(), link })
    }

    fn guard(&self) -> MutexGuard<'_, Arc<Connection>> {
        self.link.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The link that was used last, whatever became of it.
    pub(crate) fn last(&self) -> Arc<Connection> {
        self.guard().clone()
    }

    /// A link to the daemon that serves now: the last one, or a new one if another daemon serves. Never waits; opening
    /// takes some milliseconds, once per daemon.
    ///
    /// # Errors
    /// As [`Attempt`].
    pub(crate) fn link(&self) -> Result<Arc<Connection>, Error> {
        let mut link = self.guard();
        if link.is_lost() || !link.daemon_lives() {
            *link = Arc::new(attempt(&self.place)?);
        }
        Ok(link.clone())
    }

    /// A call over the link; over a new one if it is lost and a daemon serves. Right after others died beside it the transport may
    /// take a living client for one of them, and nothing that reached no daemon, or was not answered, is kept there.
    pub(crate) fn over<T>(&self, call: impl Fn(Arc<Connection>) -> Result<T, Error>) -> Result<T, Error> {
        match call(self.link()?) {
            Err(lost) if lost.kind == ErrorKind::Lost => match self.link() {
                Ok(link) => call(link.clone()).map_err(|lost| unmapped(lost, || link.daemon_lives())),
                Err(_) => Err(lost),
            },
            result => result,
        }
    }
}

/// Why an attempt to connect failed.
pub(crate) enum Attempt {
    /// Trying again changes nothing.
    Final(Error),
    /// A daemon is starting, or just ended.
    Starting(Error),
}

impl From<Attempt> for Error {
    fn from(attempt: Attempt) -> Self {
        match attempt {
            Attempt::Final(refusal) | Attempt::Starting(refusal) => refusal,
        }
    }
}

fn attempt(place: &ServicePaths) -> Result<Connection, Attempt> {
    if !place.exists().map_err(Attempt::Final)? || !any_lives(place) {
        let refusal = no_daemon(place, "no daemon of service");
        let message = format!("{refusal}; start one with `shatterd serve --service {}`", place.service.as_str());
        return Err(Attempt::Final(Error { message, ..refusal }));
    }
    let Ok(json) = std::fs::read_to_string(place.hello()) else {
        return Err(Attempt::Starting(no_daemon(place, "not ready in time: the daemon of service")));
    };
    let hello = DaemonInfo::from_json(&json).map_err(Attempt::Final)?;
    hello.check().map_err(Attempt::Final)?;
    let starting = || Attempt::Starting(no_daemon(place, "not ready in time: the daemon of service"));
    let instance = Instance::of_token(place, &hello.instance).ok_or_else(starting)?;
    let link = Connection::open(place, &instance).map_err(|refusal| match refusal.kind {
        ErrorKind::Transport => {
            Attempt::Starting(no_daemon(place, &format!("not ready ({refusal}): the daemon of service")))
        }
        // The folder of a daemon that ended meanwhile.
        ErrorKind::RuntimeFolder if !daemon_serves(place, &instance) => starting(),
        _ => Attempt::Final(refusal),
    })?;
    // The hello may be that of a daemon that was killed, read before its successor removed it.
    if link.daemon_lives() { Ok(link) } else { Err(starting()) }
}

/// Whether the daemon says so that it serves at `instance`.
fn daemon_serves(place: &ServicePaths, instance: &Instance) -> bool {
    Instance::serving(place).is_ok_and(|serving| serving == *instance)
}

fn no_daemon(place: &ServicePaths, what: &str) -> Error {
    let service = place.service.as_str();
    let message = format!("{what} `{service}` in {}", place.folder.display());
    Error::new(ErrorKind::NoDaemon, service, message)
}
