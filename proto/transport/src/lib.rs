//! Where `shatterd` and its clients meet: the transport as both configure it, its names, files and folders.

pub mod daemon_info;
pub mod instance;
pub mod paths;
pub mod private_folder;
pub mod shared_memory;
mod transport;

pub use transport::*;

/// Version of the transport. iceoryx2 demands the same on both sides, patch included.
pub const TRANSPORT_VERSION: &str = "iceoryx2 0.10.0";
