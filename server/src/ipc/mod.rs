//! The daemon's side of the transport.
//!
//! Constraints (iceoryx2 0.10.0): wake-ups can be lost, so every wait has a bound. The buckets come from a static pool of equal size,
//! so its exhaustion is an error and not a panic. A failed loan must not use up a request's loans. A full `/dev/shm` kills with
//! SIGBUS unless the pages are populated first. A daemon that is killed during its start leaves a service that cannot be opened.
//!
//! Every process of the same user can write to the transport's management memory and crash the daemon: the user is the trust domain,
//! the folders are closed to others, and a supervisor should restart the daemon.

mod client_entry;
mod memory;
mod ports;
mod runtime_directory;
mod stale_segments;
mod wake_socket;

pub use client_entry::ClientEntryCheck;
pub use memory::PopulatedPages;
pub use ports::{ActiveControlRequest, ActiveImpactRequest, LoanedBuffer, PoolSize, Ports, loan};
pub use runtime_directory::{RestartHistory, RuntimeDirectory};
pub use stale_segments::StaleSegmentReaper;
pub use wake_socket::{ClientWaker, WakeSocket};
