//! Configuration of the transport on both sides: names, limits, and the separation of services.

use crate::instance::Instance;
use crate::workarounds::{dead_clients, unclear_errors};
use iceoryx2::prelude::{Config, FileName, Path, SemanticString, ServiceName};
use shatter_proto::{Error, ErrorKind};
use std::os::unix::ffi::OsStrExt;

/// First part of the name of every file in an instance's folder. Short: paths of sockets are bounded.
pub const PREFIX: &str = "s_";

/// Strikes. The protocol's version is part of the name: another version is another service.
pub const STRIKE_SERVICE: &str = "shatter/strike/v1";
/// List, status, errors of requests.
pub const CONTROL_SERVICE: &str = "shatter/control/v1";
/// Wakes the daemon after a request.
pub const WAKE_DAEMON_SERVICE: &str = "shatter/wake-daemon/v1";
/// Wakes one client after a result.
pub const WAKE_CLIENT_SERVICE: &str = "shatter/wake-client/v1";

/// Clients at once that a daemon may be set to serve.
pub const CLIENTS_MAX: usize = 128;
/// Strikes of one client that may be under way at once.
pub const STRIKES_PER_CLIENT_MAX: usize = 64;
/// Questions of one client that may be under way at once.
pub const CONTROL_REQUESTS_PER_CLIENT_MAX: usize = 4;

/// The daemon's configuration of the transport for `instance`; the machine's and the user's own files are not read.
///
/// # Errors
/// `runtime_folder` for a folder whose path the transport does not take.
pub fn config(instance: &Instance) -> Result<Config, Error> {
    let mut config = Config::default();
    let folder = Path::new(instance.folder.as_os_str().as_bytes());
    let prefix = FileName::new(PREFIX.as_bytes());
    match (folder, prefix) {
        (Ok(folder), Ok(prefix)) => {
            config.global.set_root_path(&folder);
            config.global.prefix = prefix;
            Ok(config)
        }
        _ => {
            let at = instance.folder.display().to_string();
            let message = format!("the transport cannot use the folder {at}");
            Err(Error::new(ErrorKind::RuntimeFolder, at, message))
        }
    }
}

/// The configuration of a client: it does not clean up after dead processes, see [`dead_clients`].
///
/// # Errors
/// Those of [`config`].
pub fn client_config(instance: &Instance) -> Result<Config, Error> {
    let mut config = config(instance)?;
    dead_clients::never_clean_up(&mut config);
    Ok(config)
}

/// One of the names above as the transport wants it.
///
/// # Errors
/// `transport` for a name that the transport does not take.
pub fn service_name(name: &str) -> Result<ServiceName, Error> {
    ServiceName::new(name).map_err(|error| failed(name, error))
}

/// A call of the transport that failed.
pub fn failed(at: &str, error: impl std::fmt::Debug) -> Error {
    let hint = unclear_errors::hint();
    Error::new(ErrorKind::Transport, at, format!("the transport failed at {at}: {error:?}{hint}"))
}
