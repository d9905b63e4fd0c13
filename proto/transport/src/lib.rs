//! The transport between `shatterd` and its clients: configuration, names, files and folders.

pub mod daemon_info;
pub mod instance;
pub mod paths;
pub mod private_folder;
pub mod regular_file;
mod transport;
pub mod workarounds;

pub use transport::*;
pub use workarounds::private_segments::Ipc;

/// Version of the transport. iceoryx2 demands the same on both sides, patch included.
pub const TRANSPORT_VERSION: &str = "iceoryx2 0.10.0";
