//! A server without descriptors never recovers.
//!
//! **Symptom.** The server keeps about seven descriptors per client, also after the client died. The cleanup that closes them needs
//! some itself: without them it removes a dead client's files and keeps its place. After clients have used all of them, no later client
//! can connect.
//!
//! **Reproduction** (iceoryx2 0.10.0). `ulimit -n 64`, and 15 clients at once, of which some are killed, as in the test `descriptors`
//! of `shatter-server`. Without this file, four of seven daemons never replied again.
//!
//! **Upstream.** No issue known.
//!
//! **Delete.** This file and its call in `buckets` of the daemon, once the transport cleans up without opening files, or reserves some
//! descriptors.

use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
use shatter_proto::{Error, ErrorKind};

/// Descriptors of a daemon without clients, and of what it does beside them: cleanup, loading, probes. 43 to 46 were counted at rest.
const OWN: u64 = 64;

/// Descriptors per client; 6.4 were counted with 15 clients.
const PER_CLIENT: u64 = 7;

/// Raises the limit of descriptors as far as the system allows it, and returns the number of clients to admit: at most `clients_max`.
///
/// # Errors
/// `configuration` if the limit does not suffice for one client.
pub fn clients(clients_max: usize) -> Result<usize, Error> {
    let limit = getrlimit(Resource::Nofile);
    let raised = Rlimit { current: limit.maximum, maximum: limit.maximum };
    let current = match setrlimit(Resource::Nofile, raised) {
        Ok(()) => limit.maximum,
        Err(_) => limit.current,
    };
    let Some(limit) = current else { return Ok(clients_max) };
    let clients = sufficient(limit, clients_max)?;
    if clients < clients_max {
        tracing::warn!(
            limit,
            clients,
            clients_max,
            "the limit of descriptors (ulimit -n, LimitNOFILE) suffices for fewer clients"
        );
    }
    Ok(clients)
}

/// Number of clients that `limit` descriptors suffice for.
///
/// # Errors
/// As of [`clients`].
fn sufficient(limit: u64, clients_max: usize) -> Result<usize, Error> {
    match usize::try_from(limit.saturating_sub(OWN) / PER_CLIENT).unwrap_or(clients_max) {
        0 => {
            let least = OWN + PER_CLIENT;
            let message =
                format!("the limit of descriptors is {limit}; raise it to {least} or more (ulimit -n, LimitNOFILE)");
            Err(Error::new(ErrorKind::Configuration, "ulimit -n", message))
        }
        clients => Ok(clients.min(clients_max)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_low_limit_admits_fewer_clients_and_one_that_admits_none_is_refused() {
        let admitted = [71, 78, 1024, u64::MAX].map(|limit| sufficient(limit, 128).unwrap());
        assert_eq!(admitted, [1, 2, 128, 128]);
        assert_eq!(sufficient(1024, 32).unwrap(), 32);
        for limit in [0, 56, 70] {
            let refused = sufficient(limit, 32).unwrap_err();
            let wanted = format!("the limit of descriptors is {limit}; raise it to 71 or more");
            assert!(refused.message.starts_with(&wanted), "{refused}");
        }
    }
}
