//! The daemon's side of the transport.
//!
//! Workarounds for the transport are in [`shatter_transport::workarounds`].
//!
//! Every process of the same user can write to the transport's management memory and crash the daemon: the user is the trust domain,
//! the folders are closed to others, and a supervisor should restart the daemon.

mod ports;
mod runtime_directory;
mod wake_socket;

pub use ports::{ActiveControlRequest, ActiveImpactRequest, DaemonPorts, LoanedBuffer, PoolSize, loan};
pub use runtime_directory::{RestartHistory, RuntimeDirectory};
pub use wake_socket::{ClientWaker, WakeSocket};
