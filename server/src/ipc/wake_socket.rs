//! Wake-ups: clients wake the daemon, and the daemon wakes single clients.

use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::prelude::{CallbackProgression, FileDescriptorBased};
use shatter_transport::Ipc;
use shatter_transport::workarounds::lost_wakeups;
use std::collections::HashSet;
use std::os::fd::{AsRawFd, RawFd};
use std::time::Duration;
use tokio::io::Interest;
use tokio::io::unix::AsyncFd;

/// Socket on which clients wake the daemon.
pub struct WakeSocket(AsyncFd<Descriptor>);

struct Descriptor {
    listener: Listener<Ipc>,
    fd: RawFd,
}

impl AsRawFd for Descriptor {
    fn as_raw_fd(&self) -> RawFd {
        self.fd
    }
}

impl WakeSocket {
    /// Registers the socket with the current tokio runtime.
    ///
    /// # Errors
    /// Those of tokio, which registers the descriptor.
    pub fn new(listener: Listener<Ipc>) -> std::io::Result<Self> {
        // SAFETY: the descriptor is neither closed nor used without the listener, which lives beside it in `Descriptor`.
        let fd = unsafe { listener.file_descriptor().native_handle() };
        // SAFETY: the listener keeps its one descriptor open until it is dropped, which `AsyncFd` does after it has
        // deregistered it; `as_raw_fd` always returns this descriptor.
        Ok(Self(unsafe { AsyncFd::register_with_interest(Descriptor { listener, fd }, Interest::READABLE)? }))
    }

    /// Waits until a client wakes the daemon, but no longer than `tick`, because wake-ups can be lost.
    pub async fn wait(&self, tick: Duration) {
        if let Ok(Ok(mut ready)) = tokio::time::timeout(tick, self.0.readable()).await {
            ready.clear_ready();
        }
        lost_wakeups::reset(&self.0.get_ref().listener);
    }
}

/// Waker of clients, shared by all threads.
pub struct ClientWaker(Notifier<Ipc>);

impl ClientWaker {
    /// Creates a waker over this port.
    pub fn new(notifier: Notifier<Ipc>) -> Self {
        Self(notifier)
    }

    /// Clients that listen.
    pub fn listeners(&self) -> HashSet<[u8; 16]> {
        let mut listeners = HashSet::new();
        self.0.for_each_listener(|_, details| {
            listeners.insert(details.listener_id.value().to_le_bytes());
            CallbackProgression::Continue
        });
        listeners
    }

    /// Wakes the client whose listener has this id.
    ///
    /// A dead client or a lost wake-up does no harm: clients poll every few milliseconds.
    pub fn wake(&self, listener: [u8; 16]) {
        let id = u128::from_le_bytes(listener);
        self.0.for_each_listener(|monofier, details| {
            if details.listener_id.value() != id {
                return CallbackProgression::Continue;
            }
            if let Err(error) = monofier.notify() {
                tracing::debug!(?error, "cannot wake a client");
            }
            CallbackProgression::Stop
        });
    }
}
