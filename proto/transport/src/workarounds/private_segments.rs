//! Other users see names of segments, and can take them.
//!
//! **Symptom.** Every variant of the transport (`ipc`, `ipc_threadsafe`) puts its segments into `/dev/shm` itself. Every user of the
//! machine can list their names, predict the next ones, and create files that the daemon or a client then opens.
//!
//! **Reproduction** (iceoryx2 0.10.0). `ls /dev/shm` as another user while a daemon runs: the names consist of a prefix, ids that other
//! names show, and a kind.
//!
//! **Upstream.** No issue known; a variant with a root folder for segments would suffice.
//!
//! **Delete.** [`Ipc`] here; use the variant that accepts a folder for its segments. `iceoryx2-cal` and `iceoryx2-bb-*` are
//! dependencies for this file only.

use iceoryx2::prelude::ZeroCopySend;
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
use std::fmt::Debug;

/// The variant of the transport: ports may be shared between threads, and every segment is a file in the folder of an
/// [`Instance`](crate::instance::Instance).
///
/// The variants of iceoryx2 put segments into `/dev/shm` itself. The folder of an instance is closed to other users, and also lies in
/// shared memory.
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
