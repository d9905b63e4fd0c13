//! The daemon's side of the transport.
//!
//! What shaped it (iceoryx2 0.10.0): wake-ups can be lost, so every wait has a bound; a static pool of equal buckets, whose
//! exhaustion is an error and not a panic; a failed loan must not use up a request's loans; a full `/dev/shm` kills with
//! SIGBUS unless the pages are asked for first; a daemon killed while starting leaves a service that nobody can open.
//!
//! Every process of the same user can write to the transport's management memory and bring the daemon down: the user is
//! the trust domain, the folders are closed to others, and a supervisor should restart what falls.

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
