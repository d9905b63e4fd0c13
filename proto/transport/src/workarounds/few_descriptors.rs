//! A server without descriptors never recovers.
//!
//! **Symptom.** The server keeps about seven descriptors per client, also after the client died. The cleanup that closes them needs
//! some itself. Clients that use up all of them shut every later client out for good.
//!
//! **Reproduction** (iceoryx2 0.10.0). `ulimit -n 64`, and 15 clients at once, of which some are killed, as in the test `descriptors`
//! of `shatter-server`. Without this file, four of seven daemons never replied again.
//!
//! **Upstream.** No issue known.
//!
//! **Delete.** This file and its call in `buckets` of the daemon, once the transport cleans up without opening files, or sets some
//! descriptors aside.

use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

/// Descriptors of a daemon without clients, and of what it does beside them: cleanup, loading, probes. 43 to 46 were counted at rest.
const OWN: u64 = 64;

/// Descriptors per client; 6.4 were counted with 15 clients.
const PER_CLIENT: u64 = 7;

/// Raises the limit of descriptors as far as the system allows it, and returns the number of clients to admit: at most `clients_max`.
pub fn clients(clients_max: usize) -> usize {
    let limit = getrlimit(Resource::Nofile);
    let raised = Rlimit { current: limit.maximum, maximum: limit.maximum };
    let current = match setrlimit(Resource::Nofile, raised) {
        Ok(()) => limit.maximum,
        Err(_) => limit.current,
    };
    let Some(limit) = current else { return clients_max };
    let clients = sufficient(limit, clients_max);
    if clients < clients_max {
        tracing::warn!(
            limit,
            clients,
            clients_max,
            "the limit of descriptors (ulimit -n, LimitNOFILE) suffices for fewer clients"
        );
    }
    clients
}

/// Number of clients that `limit` descriptors suffice for: at least one.
fn sufficient(limit: u64, clients_max: usize) -> usize {
    let clients = limit.saturating_sub(OWN) / PER_CLIENT;
    usize::try_from(clients).unwrap_or(clients_max).clamp(1, clients_max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_low_limit_admits_fewer_clients() {
        let admitted = [0, 56, 64, 78, 1024, u64::MAX].map(|limit| sufficient(limit, 128));
        assert_eq!(admitted, [1, 1, 1, 2, 128, 128]);
        assert_eq!(sufficient(1024, 32), 32);
    }
}
