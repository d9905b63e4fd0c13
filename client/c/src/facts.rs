//! Facts that the service reports of its objects and of itself.

use crate::error::{ErrorRecord, text};
use crate::result_rows::nanoseconds;
use shatter_client::ObjectFacts;
use std::ffi::c_char;

/// Facts of an object. Texts are UTF-8 and end with a zero.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Facts {
    /// Name.
    pub name: [c_char; 72],
    /// Name of its material.
    pub material: [c_char; 40],
    /// True if the object can be struck. If not, `error` has the reason, and all other fields but the name are zero.
    pub ready: bool,
    /// Bodies (components).
    pub bodies: u32,
    /// Cap on the degree.
    pub degree_max: u32,
    /// Version of the object: 1 for the first since the daemon started, one more for each replacement.
    pub generation: u32,
    /// Nodes of the elastic lattices.
    pub elastic_nodes: u32,
    /// Nodes of the crack lattices.
    pub crack_nodes: u32,
    /// Largest number of fragments of a result, beyond which the service refuses; 0: no limit.
    pub fragments_max: u64,
    /// Largest size of a result, bytes, beyond which the service refuses; 0: no limit.
    pub bytes_max: u64,
    /// γ, J·m².
    pub gamma_j_m2: f64,
    /// Young's modulus, Pa.
    pub young_pa: f64,
    /// Poisson's ratio.
    pub poisson: f64,
    /// Density, kg/m³.
    pub density_kg_m3: f64,
    /// Volume, m³: the sum of the fragments' volumes.
    pub volume_m3: f64,
    /// Diagonal of the bounding box, m.
    pub diagonal_m: f64,
    /// Center of the bounding box, m.
    pub center_m: [f64; 3],
    /// Lowest corner of the mesh, m, or of the lattice if it is loaded without its skin. Without an exact surface, rays hit the lattice's,
    /// which can lie outside by part of its spacing.
    pub low_m: [f64; 3],
    /// Highest corner of the mesh, m.
    pub high_m: [f64; 3],
    /// Default contact radius, m.
    pub radius_m: f64,
    /// Default contact duration, s.
    pub duration_s: f64,
    /// Memory of the object in the daemon, bytes.
    pub memory_bytes: u64,
    /// Size of the file that the object was loaded from, bytes.
    pub file_bytes: u64,
    /// Reason why the object could not be loaded. If it is ready: reason why its changed file could not be loaded; the version before is
    /// served.
    pub error: ErrorRecord,
}

impl From<&ObjectFacts> for Facts {
    fn from(facts: &ObjectFacts) -> Self {
        Self {
            name: text(&facts.name),
            material: text(&facts.material),
            ready: facts.is_ready(),
            bodies: facts.bodies,
            degree_max: facts.degree_max,
            generation: facts.generation,
            elastic_nodes: facts.elastic_nodes,
            crack_nodes: facts.crack_nodes,
            fragments_max: facts.fragments_max.unwrap_or(0),
            bytes_max: facts.bytes_max.unwrap_or(0),
            gamma_j_m2: facts.gamma_j_m2,
            young_pa: facts.young_pa,
            poisson: facts.poisson,
            density_kg_m3: facts.density_kg_m3,
            volume_m3: facts.volume_m3,
            diagonal_m: facts.diagonal_m,
            center_m: facts.center_m,
            low_m: facts.bounds_m[0],
            high_m: facts.bounds_m[1],
            radius_m: facts.radius_m,
            duration_s: facts.duration_s,
            memory_bytes: facts.memory_bytes,
            file_bytes: facts.file_bytes,
            error: facts.error.as_ref().map_or_else(ErrorRecord::none, ErrorRecord::from),
        }
    }
}

/// State of a service; counters since the daemon started.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Status {
    /// Process id of the daemon.
    pub pid: u32,
    /// True if the daemon is ending.
    pub ending: bool,
    /// Objects that are ready.
    pub objects_ready: u32,
    /// Objects that could not be loaded.
    pub objects_failed: u32,
    /// Threads that compute.
    pub threads: u32,
    /// Requests being computed now.
    pub running: u32,
    /// Requests waiting now.
    pub queued: u32,
    /// Requests that may wait.
    pub queue_max: u32,
    /// Clients connected now.
    pub clients: u32,
    /// Clients that may be connected.
    pub clients_max: u32,
    /// Buckets for results.
    pub buckets: u32,
    /// Always zero.
    pub reserved: u32,
    /// Bytes per bucket.
    pub bucket_bytes: u64,
    /// Results that their clients have not read yet.
    pub unread: u64,
    /// Results that are kept so that their fragments can be struck.
    pub kept: u64,
    /// Daemons that served under this name before this one.
    pub restarts: u64,
    /// Of the restarts, those after a daemon that was killed or crashed.
    pub crashes: u64,
    /// Time since the daemon started, ns.
    pub uptime_ns: u64,
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
    /// Memory of the objects, bytes.
    pub memory_bytes: u64,
    /// Time from the arrival of a request to its result, ns: median.
    pub strike_p50_ns: u64,
    /// 99th percentile of that time, ns.
    pub strike_p99_ns: u64,
    /// Longest such time, ns.
    pub strike_max_ns: u64,
}

impl From<&shatter_client::Status> for Status {
    fn from(own: &shatter_client::Status) -> Self {
        Self {
            pid: own.pid,
            ending: own.is_ending,
            objects_ready: own.objects_ready,
            objects_failed: own.objects_failed,
            threads: own.threads,
            running: own.running,
            queued: own.queued,
            queue_max: own.queue_max,
            clients: own.clients,
            clients_max: own.clients_max,
            buckets: own.buckets,
            reserved: 0,
            bucket_bytes: own.bucket_bytes,
            unread: own.unread,
            kept: own.kept,
            restarts: own.restarts,
            crashes: own.crashes,
            uptime_ns: nanoseconds(own.uptime),
            completed: own.completed,
            refused: own.refused,
            busy: own.busy,
            late: own.late,
            failed: own.failed,
            canceled: own.canceled,
            memory_bytes: own.memory_bytes,
            strike_p50_ns: own.request_times.p50_ns,
            strike_p99_ns: own.request_times.p99_ns,
            strike_max_ns: own.request_times.max_ns,
        }
    }
}
