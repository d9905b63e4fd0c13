//! What both sides tell the transport: names, limits and the configuration that keeps services apart.

use crate::instance::Instance;
use iceoryx2::prelude::{Config, FileName, Path, SemanticString, ServiceName, ZeroCopySend};
use iceoryx2::service::{Service, internal::ServiceInternal};
use iceoryx2::unique_id_generator::unique_system_id::UniqueSystemId;
use iceoryx2_bb_elementary_traits::testing::abandonable::Abandonable;
use iceoryx2_bb_lock_free::mpmc::counting_bit_set::RelocatableCountingBitSet;
use iceoryx2_cal::arc_sync_policy::mutex_protected::MutexProtected;
use iceoryx2_cal::dynamic_storage::file::Storage;
use iceoryx2_cal::event::trigger::{State, unix_datagram_socket::GenericUnixDatagramSocketTrigger};
use iceoryx2_cal::resizable_shared_memory::dynamic::DynamicMemory;
use iceoryx2_cal::shared_memory::file::Memory;
use iceoryx2_cal::shm_allocator::{bump_allocator::BumpAllocator, pool_allocator::PoolAllocator};
use iceoryx2_cal::{bag, hash, monitoring, reactor, serialize, static_storage, zero_copy_connection::file::Connection};
use shatter_proto::{Error, ErrorKind};
use std::fmt::Debug;
use std::os::unix::ffi::OsStrExt;

/// The variant of the transport: ports may be shared between threads, and every segment is a file of the instance's folder.
///
/// The variants of iceoryx2 put segments into `/dev/shm` itself, where every user of the machine can read their names, and make the
/// files that are opened next. The folder of an instance is closed to other users, and lies in shared memory all the same.
#[derive(Clone, Debug)]
pub struct Ipc {}

impl Service for Ipc {
    type StaticStorage = static_storage::recommended::Ipc;
    type ConfigSerializer = serialize::recommended::Recommended;
    type PersistentDynamicStorage<T: Debug + Send + Sync + ZeroCopySend + 'static> = Storage<T>;
    type Bag = bag::recommended::Recommended;
    type DynamicStorage<T: Debug + Send + Sync + ZeroCopySend + 'static> = Storage<T>;
    type ServiceNameHasher = hash::recommended::Recommended;
    type SharedMemory = Memory<PoolAllocator>;
    type ResizableSharedMemory = DynamicMemory<PoolAllocator, Memory<PoolAllocator>>;
    type Connection = Connection;
    type Event =
        GenericUnixDatagramSocketTrigger<RelocatableCountingBitSet, Storage<State<RelocatableCountingBitSet, ()>>>;
    type Monitoring = monitoring::recommended::Ipc;
    type Reactor = reactor::recommended::Ipc;
    type ArcThreadSafetyPolicy<T: Send + Debug + Abandonable> = MutexProtected<T>;
    type BlackboardMgmt<T: Send + Sync + Debug + ZeroCopySend + 'static> = Storage<T>;
    type BlackboardPayload = Memory<BumpAllocator>;
    type UniqueId = UniqueSystemId;
}

impl ServiceInternal<Self> for Ipc {}

/// First part of the name of every file in an instance's folder. Short: paths of sockets are bounded.
pub const PREFIX: &str = "s_";

/// Strikes. The protocol's version is part of the name: another version is another service.
pub const STRIKE_SERVICE: &str = "shatter/strike/v1";
/// List, status, verdicts.
pub const CONTROL_SERVICE: &str = "shatter/control/v1";
/// Wakes the daemon after a request.
pub const WAKE_DAEMON_SERVICE: &str = "shatter/wake-daemon/v1";
/// Wakes one client after an answer.
pub const WAKE_CLIENT_SERVICE: &str = "shatter/wake-client/v1";

/// Clients at once that a daemon may be set to serve.
pub const CLIENTS_MAX: usize = 128;
/// Strikes of one client that may be under way at once.
pub const STRIKES_PER_CLIENT_MAX: usize = 64;
/// Questions of one client that may be under way at once.
pub const QUESTIONS_PER_CLIENT_MAX: usize = 4;

/// A process that may open fewer files is told so when the transport fails: it does not say what it lacks.
const FILES_FEW: u64 = 256;

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

/// The configuration of a client: it buries nobody. The daemon does; of two that bury at once the slower takes the place of whoever
/// came after the dead, and a client could wait for what a dead one left unfinished.
///
/// # Errors
/// Those of [`config`].
pub fn client_config(instance: &Instance) -> Result<Config, Error> {
    let mut config = config(instance)?;
    config.global.node.cleanup_dead_nodes_on_creation = false;
    config.global.node.cleanup_dead_nodes_on_destruction = false;
    config.global.service.cleanup_dead_nodes_on_open = false;
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
    let limit = rustix::process::getrlimit(rustix::process::Resource::Nofile).current;
    let hint = match limit {
        Some(files) if files < FILES_FEW => format!(" (this process may open only {files} files)"),
        _ => String::new(),
    };
    Error::new(ErrorKind::Transport, at, format!("the transport failed at {at}: {error:?}{hint}"))
}
