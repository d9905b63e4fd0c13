//! The control service: which objects are loaded, the state of the service, and why it closed a request without a result.
//!
//! The daemon's waiting thread replies from a pool of its own, so a full queue or an exhausted pool of results does not block it.

use crate::error::ErrorWire;
use crate::name::OBJECT_NAME_MAX;
use crate::request::{REQUEST_MAGIC, head};
use crate::result::{AlignedBlock, StageKind};
use crate::{Error, ErrorKind, PROTOCOL_VERSION, text};
use bytemuck::{Pod, Zeroable};

/// Rows that one reply carries at most; a longer list is asked for in parts.
pub const ROWS_MAX: usize = 64;

/// Blocks that one reply needs at most.
pub const REPLY_BLOCKS: usize = (ROWS_MAX * size_of::<ObjectRow>()).div_ceil(size_of::<AlignedBlock>());

/// A request to the control service.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ControlRequest {
    /// Objects, from this position on. Rows are [`ObjectRow`]s.
    List(u32),
    /// State of the service. One [`ServiceStatusRow`].
    Status,
    /// Why the service closed the request with this sequence without a result. One [`ErrorWire`], or no row if the service does not
    /// know the request.
    RequestError(u64),
    /// Progress of the request with this sequence. One [`ProgressRow`], or no row if it neither waits nor computes.
    Progress(u64),
    /// Releases the result kept under `handle`, once the request with the sequence `after` has arrived, and so all that this client
    /// sent before. No row; `unknown_handle` if there is none.
    Release {
        /// Handle of the result.
        handle: u64,
        /// Sequence of the last request that the client sent before; zero: there is none.
        after: u64,
    },
}

/// A [`ControlRequest`] as it travels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct ControlRequestWire {
    /// [`REQUEST_MAGIC`].
    pub magic: u32,
    /// [`PROTOCOL_VERSION`].
    pub version: u32,
    /// 1: list. 2: status. 3: error of a request. 4: progress. 5: release.
    pub kind: u32,
    /// First row of a list, else zero.
    pub first: u32,
    /// Sequence of the request that an error or progress is about, or the handle to release; else zero.
    pub sequence: u64,
    /// The client's listener: woken with the reply, and the owner of the request.
    pub listener: [u8; 16],
    /// Sequence of the last request that the client sent before a release; else zero. Requests and control requests travel separately,
    /// so the daemon delays a release until this request has arrived.
    pub after: u64,
    /// Zero.
    pub reserved: [u64; 7],
}

/// Header of a reply.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct ControlReplyHeader {
    /// [`REQUEST_MAGIC`].
    pub magic: u32,
    /// [`PROTOCOL_VERSION`].
    pub version: u32,
    /// Rows in this reply.
    pub rows: u32,
    /// Rows there are.
    pub total: u32,
    /// Bytes per row.
    pub row_bytes: u32,
    /// 1 if the only row is the error of the control request itself.
    pub refused: u32,
    /// Zero.
    pub reserved: [u64; 5],
}

/// Whether an object can be struck.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
#[non_exhaustive]
pub enum ObjectState {
    /// Its database could not be loaded.
    Failed = 0,
    /// It can be struck.
    Ready = 1,
    /// Its database has been found and is not loaded yet.
    Loading = 2,
}

impl ObjectState {
    /// The name used in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Failed => "failed",
            Self::Ready => "ready",
            Self::Loading => "loading",
        }
    }
}

/// An object, loaded or not.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ObjectRow {
    /// UTF-8.
    pub name: [u8; OBJECT_NAME_MAX],
    /// Bytes of `name` that count.
    pub name_length: u32,
    /// Number of an [`ObjectState`]. Unless it is ready, `error` is the reason, and everything else is zero.
    pub state: u32,
    /// Bodies (components).
    pub bodies: u32,
    /// Cap on the degree.
    pub degree_max: u32,
    /// Nodes of the elastic lattices.
    pub elastic_nodes: u32,
    /// Nodes of the crack lattices.
    pub crack_nodes: u32,
    /// Bytes of `material` that count.
    pub material_length: u32,
    /// 1 for the first version of it since the daemon started, one more for each that replaced another.
    pub generation: u32,
    /// UTF-8.
    pub material: [u8; 32],
    /// γ, J·m².
    pub gamma_j_m2: f64,
    /// Young's modulus, Pa.
    pub young_pa: f64,
    /// Poisson's ratio.
    pub poisson: f64,
    /// Density, kg/m³.
    pub density_kg_m3: f64,
    /// Volume, m³.
    pub volume_m3: f64,
    /// Diagonal of the bounding box, m.
    pub diagonal_m: f64,
    /// Center of the bounding box, m.
    pub center_m: [f64; 3],
    /// Lowest and highest corner of the mesh, m. Without an exact surface, rays hit the lattice's, which can lie outside by part of
    /// its spacing.
    pub bounds_m: [[f64; 3]; 2],
    /// Default contact radius, m.
    pub radius_m: f64,
    /// Default contact duration, s.
    pub duration_s: f64,
    /// Bytes of memory that it holds.
    pub memory_bytes: u64,
    /// Bytes of the file that it was loaded from.
    pub file_bytes: u64,
    /// When it was loaded, ns since 1970 (UTC).
    pub loaded_unix_ns: u64,
    /// Time that it took, ns.
    pub load_ns: u64,
    /// Results of more fragments are refused; 0: no limit.
    pub fragments_max: u64,
    /// Longer results are refused, bytes; 0: no limit.
    pub bytes_max: u64,
    /// Why the object cannot be struck; if it is ready, why its changed file could not be loaded, so that the version loaded before
    /// is still served. Of kind 0 otherwise.
    pub error: ErrorWire,
}

/// Times of one stage, ns, since the daemon started.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Latency {
    /// Number of runs.
    pub count: u64,
    /// Median.
    pub p50_ns: u64,
    /// 90th percentile.
    pub p90_ns: u64,
    /// 99th percentile.
    pub p99_ns: u64,
    /// Longest.
    pub max_ns: u64,
}

/// State of the service.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct ServiceStatusRow {
    /// Process id of the daemon.
    pub pid: u32,
    /// Objects ready.
    pub objects_ready: u32,
    /// Objects that could not be loaded.
    pub objects_failed: u32,
    /// Threads that compute.
    pub threads: u32,
    /// Requests computing now.
    pub running: u32,
    /// Requests waiting now.
    pub queued: u32,
    /// Requests that may wait.
    pub queue_max: u32,
    /// Clients connected now.
    pub clients: u32,
    /// Buckets of results.
    pub buckets: u32,
    /// Of the objects ready, those whose file was changed and can no longer be loaded.
    pub objects_outdated: u32,
    /// Clients that may be connected.
    pub clients_max: u32,
    /// 1 while the daemon is ending.
    pub ending: u32,
    /// Objects whose databases are being loaded, none of them ready before.
    pub objects_loading: u32,
    /// Zero.
    pub reserved: u32,
    /// Bytes per bucket.
    pub bucket_bytes: u64,
    /// Results that their clients have not read yet.
    pub unread: u64,
    /// Most buckets that were held at once.
    pub buckets_used_max: u64,
    /// Bytes of shared memory that the buckets take up.
    pub buckets_bytes: u64,
    /// Daemons that served under this name before this one since its runtime folder was made; failed starts do not count.
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
    /// Bytes of memory that the objects hold.
    pub memory_bytes: u64,
    /// Number of reloads of the databases since the daemon started.
    pub reloads: u64,
    /// When they were last read, ns since 1970 (UTC).
    pub read_unix_ns: u64,
    /// Objects that were replaced or removed, and are still being struck, or whose results are kept.
    pub retired: u64,
    /// Bytes of memory that these hold until their last request ends and their last result is no longer kept.
    pub retired_bytes: u64,
    /// Results that are kept so that their fragments can be struck.
    pub kept: u64,
    /// Bytes of memory that these hold.
    pub kept_bytes: u64,
    /// From the arrival of a request to its result.
    pub strike: Latency,
    /// By stage, in the order of [`StageKind::ALL`].
    pub stages: [Latency; StageKind::ALL.len()],
}

/// Progress of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct ProgressRow {
    /// 1: it waits. 2: it computes.
    pub state: u32,
    /// Number of the [`StageKind`] that computes, or that computed last.
    pub stage: u32,
    /// Time since the daemon took it in, ns.
    pub age_ns: u64,
}

const _: () = assert!(size_of::<ControlRequestWire>() == 104);
const _: () = assert!(size_of::<ControlReplyHeader>() == 64);
const _: () = assert!(size_of::<ObjectRow>() == 712);
const _: () = assert!(size_of::<ServiceStatusRow>() == 56 + 20 * 8 + 9 * 40);

impl ControlRequest {
    /// The request as it travels.
    pub fn wire(self, listener: [u8; 16]) -> ControlRequestWire {
        let (kind, first, sequence, after) = match self {
            Self::List(first) => (1, first, 0, 0),
            Self::Status => (2, 0, 0, 0),
            Self::RequestError(sequence) => (3, 0, sequence, 0),
            Self::Progress(sequence) => (4, 0, sequence, 0),
            Self::Release { handle, after } => (5, 0, handle, after),
        };
        let (magic, version) = (REQUEST_MAGIC, PROTOCOL_VERSION);
        ControlRequestWire { magic, version, kind, first, sequence, listener, after, reserved: [0; 7] }
    }

    /// Sequence of the request that must have arrived before the daemon replies; zero: none.
    pub fn after(self) -> u64 {
        match self {
            Self::Release { after, .. } => after,
            Self::Progress(sequence) => sequence,
            Self::List(_) | Self::Status | Self::RequestError(_) => 0,
        }
    }
}

impl ControlRequestWire {
    /// Validates a private copy of a control request. Never panics, whatever the bytes.
    ///
    /// # Errors
    /// `bad_magic`, `version_mismatch`, `reserved_field`, `unknown_request`.
    pub fn validate(&self) -> Result<ControlRequest, Error> {
        head(self.magic, self.version)?;
        if let Some(i) = self.reserved.iter().position(|word| *word != 0) {
            return Err(Error::new(ErrorKind::ReservedField, format!("reserved[{i}]"), "reserved words must be zero"));
        }
        match (self.kind, self.first, self.sequence, self.after) {
            (1, first, 0, 0) => Ok(ControlRequest::List(first)),
            (2, 0, 0, 0) => Ok(ControlRequest::Status),
            (3, 0, sequence, 0) => Ok(ControlRequest::RequestError(sequence)),
            (4, 0, sequence, 0) => Ok(ControlRequest::Progress(sequence)),
            (5, 0, handle, after) => Ok(ControlRequest::Release { handle, after }),
            (other, ..) => {
                Err(Error::new(ErrorKind::UnknownRequest, other.to_string(), "no such request to the control service"))
            }
        }
    }
}

/// A type whose rows travel in replies.
pub trait ReplyRow: Pod {}
impl ReplyRow for ObjectRow {}
impl ReplyRow for ServiceStatusRow {}
impl ReplyRow for ProgressRow {}
impl ReplyRow for ErrorWire {}

/// Blocks needed for `rows` rows of type `R`.
pub fn blocks<R: ReplyRow>(rows: usize) -> usize {
    (rows * size_of::<R>()).div_ceil(size_of::<AlignedBlock>())
}

/// Writes rows into a payload of at least [`blocks`] blocks and returns the header; what does not fit is left out.
pub fn write<R: ReplyRow>(payload: &mut [AlignedBlock], rows: &[R], total: usize, refused: bool) -> ControlReplyHeader {
    let bytes: &mut [u8] = bytemuck::cast_slice_mut(payload);
    let rows = &rows[..rows.len().min(bytes.len() / size_of::<R>())];
    let source: &[u8] = bytemuck::cast_slice(rows);
    bytes[..source.len()].copy_from_slice(source);
    bytes[source.len()..].fill(0);
    ControlReplyHeader {
        magic: REQUEST_MAGIC,
        version: PROTOCOL_VERSION,
        rows: rows.len() as u32,
        total: total as u32,
        row_bytes: size_of::<R>() as u32,
        refused: u32::from(refused),
        reserved: [0; 5],
    }
}

/// Reads the rows of a reply, checked.
///
/// # Errors
/// `bad_result` for rows that do not fit `R`, and the error with which the service replied.
pub fn read<R: ReplyRow>(header: &ControlReplyHeader, payload: &[AlignedBlock]) -> Result<Vec<R>, Error> {
    head(header.magic, header.version).map_err(|error| bad(error.message))?;
    if header.refused != 0 {
        let rows = copy::<ErrorWire>(header, payload)?;
        return Err(rows.first().map_or_else(|| bad("an error without a row"), Error::from));
    }
    copy(header, payload)
}

fn copy<R: ReplyRow>(header: &ControlReplyHeader, payload: &[AlignedBlock]) -> Result<Vec<R>, Error> {
    let size = size_of::<R>();
    let rows = header.rows as usize;
    let bytes: &[u8] = bytemuck::cast_slice(payload);
    let bytes = rows.checked_mul(size).and_then(|length| bytes.get(..length));
    match bytes {
        Some(bytes) if header.row_bytes as usize == size && rows <= ROWS_MAX => {
            Ok(bytes.chunks_exact(size).map(bytemuck::pod_read_unaligned).collect())
        }
        _ => Err(bad(format!("{rows} rows of {} bytes", header.row_bytes))),
    }
}

fn bad(what: impl std::fmt::Display) -> Error {
    Error::new(ErrorKind::BadResult, "control", format!("the reply of the control service is not well formed: {what}"))
}

impl ObjectRow {
    /// Whether the object can be struck; a number that this version does not know counts as failed.
    pub fn state(&self) -> ObjectState {
        match self.state {
            1 => ObjectState::Ready,
            2 => ObjectState::Loading,
            _ => ObjectState::Failed,
        }
    }

    /// Why the object cannot be struck, or why its changed file could not be loaded.
    pub fn error(&self) -> Option<Error> {
        (self.state() != ObjectState::Ready || self.error.kind != 0).then(|| Error::from(&self.error))
    }

    /// The object's name, for showing.
    pub fn name(&self) -> String {
        text::show(&self.name, self.name_length)
    }

    /// Sets the object's name.
    pub fn set_name(&mut self, name: &str) {
        self.name_length = text::put(&mut self.name, name);
    }

    /// The material's name.
    pub fn material(&self) -> String {
        text::show(&self.material, self.material_length)
    }

    /// Sets the material's name.
    pub fn set_material(&mut self, name: &str) {
        self.material_length = text::put(&mut self.material, name);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn control_requests_round_trip() {
        for request in [
            ControlRequest::List(7),
            ControlRequest::Status,
            ControlRequest::RequestError(u64::MAX),
            ControlRequest::Progress(9),
            ControlRequest::Release { handle: 3, after: 8 },
        ] {
            assert_eq!(request.wire([3; 16]).validate().unwrap(), request);
        }
        let mut wire = ControlRequest::Status.wire([0; 16]);
        wire.reserved[2] = 1;
        assert_eq!(wire.validate().unwrap_err().at, "reserved[2]");
    }

    #[test]
    fn reply_rows_round_trip() {
        let mut row = ObjectRow::zeroed();
        row.set_name("Bär");
        let rows = vec![row; 3];
        let mut payload = vec![AlignedBlock::zeroed(); blocks::<ObjectRow>(3)];
        let header = write(&mut payload, &rows, 9, false);
        assert_eq!((header.rows, header.total), (3, 9));
        assert_eq!(read::<ObjectRow>(&header, &payload).unwrap(), rows);
        assert_eq!(read::<ServiceStatusRow>(&header, &payload).unwrap_err().kind, ErrorKind::BadResult);
    }

    #[test]
    fn an_object_row_can_be_ready_and_have_an_error() {
        let mut row = ObjectRow::zeroed();
        assert_eq!(row.error().map(|error| error.kind), Some(ErrorKind::BadResult));
        row.state = ObjectState::Ready as u32;
        assert_eq!(row.error(), None);
        let error = Error::new(ErrorKind::CorruptObject, "vase", "vase.shatter: cut short");
        row.error = ErrorWire::from(&error);
        assert_eq!(row.error(), Some(error));
    }

    #[test]
    fn the_error_of_a_control_request_comes_back() {
        let error = Error::new(ErrorKind::UnknownRequest, "9", "no such request to the control service");
        let mut payload = vec![AlignedBlock::zeroed(); REPLY_BLOCKS];
        let header = write(&mut payload, &[ErrorWire::from(&error)], 1, true);
        assert_eq!(read::<ServiceStatusRow>(&header, &payload).unwrap_err(), error);
    }

    proptest! {
        #[test]
        fn random_bytes_never_panic(request in proptest::collection::vec(any::<u8>(), 104), rows in any::<u32>()) {
            let wire: ControlRequestWire = bytemuck::pod_read_unaligned(&request);
            prop_assert!(wire.validate().is_err());
            let payload = vec![AlignedBlock::zeroed(); 3];
            let mut header = write::<ServiceStatusRow>(&mut payload.clone(), &[], 0, rows % 2 == 0);
            header.rows = rows;
            prop_assert!(rows == 0 || read::<ServiceStatusRow>(&header, &payload).is_err());
        }
    }
}
