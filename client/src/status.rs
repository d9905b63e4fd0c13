//! Status of a service, as it reports it.

use shatter_proto::control::{Latency, ServiceStatusRow};
use shatter_proto::result::StageKind;
use std::time::Duration;

/// State of a service; counters since the daemon started.
#[derive(Clone, Debug, PartialEq, Eq)]
#[must_use]
#[non_exhaustive]
pub struct Status {
    /// Process id of the daemon.
    pub pid: u32,
    /// Whether the daemon is ending.
    pub is_ending: bool,
    /// Time since the daemon started.
    pub uptime: Duration,
    /// Daemons that served under this name before this one since its runtime folder was made; failed starts do not count.
    pub restarts: u64,
    /// Of the restarts, those after a daemon that was killed or crashed.
    pub crashes: u64,
    /// Threads that compute.
    pub threads: u32,
    /// Clients connected now.
    pub clients: u32,
    /// Clients that may be connected.
    pub clients_max: u32,
    /// Objects ready.
    pub objects_ready: u32,
    /// Objects whose databases are being loaded, none of them ready before.
    pub objects_loading: u32,
    /// Objects that could not be loaded.
    pub objects_failed: u32,
    /// Of the objects ready, those whose file was changed and can no longer be loaded.
    pub objects_outdated: u32,
    /// Memory of the objects, bytes.
    pub memory_bytes: u64,
    /// Objects that were replaced or removed, and are still being struck, or whose results are kept.
    pub retired: u64,
    /// Memory of these, bytes.
    pub retired_bytes: u64,
    /// Number of reloads of the databases.
    pub reloads: u64,
    /// When the databases were read last: time since 1970 (UTC).
    pub read_unix: Duration,
    /// Requests computing now.
    pub running: u32,
    /// Requests waiting now.
    pub queued: u32,
    /// Requests that may wait.
    pub queue_max: u32,
    /// Buckets of results.
    pub buckets: u32,
    /// Size of a bucket, bytes.
    pub bucket_bytes: u64,
    /// Most buckets that were held or prepared at once.
    pub buckets_used_max: u64,
    /// Shared memory of the buckets, bytes.
    pub buckets_bytes: u64,
    /// Results that their clients have not read yet.
    pub unread: u64,
    /// Results that are kept so that their fragments can be struck.
    pub kept: u64,
    /// Memory of these, bytes.
    pub kept_bytes: u64,
    /// Requests that got a result.
    pub completed: u64,
    /// Requests refused as wrong.
    pub refused: u64,
    /// Requests refused because the service was full.
    pub busy: u64,
    /// Requests whose deadline passed, or would have.
    pub late: u64,
    /// Requests that failed inside the service.
    pub failed: u64,
    /// Requests that their client canceled, or whose client died.
    pub canceled: u64,
    /// Times from the arrival of a request to its result.
    pub request_times: Latency,
    /// Times by stage, in the order in which data flows.
    pub stage_times: Vec<(StageKind, Latency)>,
}

impl Status {
    pub(crate) fn of(row: &ServiceStatusRow) -> Self {
        Self {
            pid: row.pid,
            is_ending: row.ending != 0,
            uptime: Duration::from_nanos(row.uptime_ns),
            restarts: row.restarts,
            crashes: row.crashes,
            threads: row.threads,
            clients: row.clients,
            clients_max: row.clients_max,
            objects_ready: row.objects_ready,
            objects_loading: row.objects_loading,
            objects_failed: row.objects_failed,
            objects_outdated: row.objects_outdated,
            memory_bytes: row.memory_bytes,
            retired: row.retired,
            retired_bytes: row.retired_bytes,
            reloads: row.reloads,
            read_unix: Duration::from_nanos(row.read_unix_ns),
            running: row.running,
            queued: row.queued,
            queue_max: row.queue_max,
            buckets: row.buckets,
            bucket_bytes: row.bucket_bytes,
            buckets_used_max: row.buckets_used_max,
            buckets_bytes: row.buckets_bytes,
            unread: row.unread,
            kept: row.kept,
            kept_bytes: row.kept_bytes,
            completed: row.completed,
            refused: row.refused,
            busy: row.busy,
            late: row.late,
            failed: row.failed,
            canceled: row.canceled,
            request_times: row.strike,
            stage_times: StageKind::ALL.iter().copied().zip(row.stages).collect(),
        }
    }
}
