//! The control service: what it says of objects and of itself.

use crate::connection::{Connection, LivenessCheck, PendingControlRequest, receive_failed};
use crate::{Deadline, Status};
use shatter_export::contact::{ContactBody, ContactPolicy, ElasticMaterial};
use shatter_proto::control::{ControlRequest, ObjectRow, ObjectState, ReplyRow, ServiceStatusRow, read};
use shatter_proto::error::ErrorWire;
use shatter_proto::{Error, ErrorKind};
use std::time::Duration;

/// Facts about one object, as the service reports them.
#[derive(Clone, Debug, PartialEq)]
#[must_use]
#[non_exhaustive]
pub struct ObjectFacts {
    /// Its name.
    pub name: String,
    /// Whether it can be struck, is being loaded, or could not be loaded. Unless it is ready, everything but the name and `error` is
    /// zero.
    pub state: ObjectState,
    /// Why it cannot be struck: `loading` or `corrupt_object`. If it is ready: why its changed file could not be loaded; the version
    /// loaded before is served until that file is mended or removed.
    pub error: Option<Error>,
    /// Name of its material.
    pub material: String,
    /// Bodies (components).
    pub bodies: u32,
    /// Cap on the degree.
    pub degree_max: u32,
    /// Results of more fragments are refused; `None`: no limit.
    pub fragments_max: Option<u64>,
    /// Longer results are refused, bytes; `None`: no limit.
    pub bytes_max: Option<u64>,
    /// Nodes of the elastic lattices.
    pub elastic_nodes: u32,
    /// Nodes of the crack lattices.
    pub crack_nodes: u32,
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
    /// Lowest and highest corner of the mesh, m, or of the lattice if it is loaded without its skin. Without an exact surface, rays
    /// hit the lattice's, which can lie outside by part of its spacing.
    pub bounds_m: [[f64; 3]; 2],
    /// Default contact radius, m.
    pub radius_m: f64,
    /// Default contact duration, s.
    pub duration_s: f64,
    /// 1 for the first version of it since the daemon started, one more for each that replaced another.
    pub generation: u32,
    /// Bytes of memory that it holds in the daemon.
    pub memory_bytes: u64,
    /// Bytes of the file that it was loaded from.
    pub file_bytes: u64,
    /// When it was loaded: time since 1970 (UTC).
    pub loaded_unix: Duration,
    /// Time that loading took.
    pub load_time: Duration,
}

impl ObjectFacts {
    /// Whether it can be struck.
    #[must_use]
    pub fn is_ready(&self) -> bool {
        self.state == ObjectState::Ready
    }

    /// The object's material, for the theory of contacts.
    #[must_use]
    pub fn contact_material(&self) -> ElasticMaterial {
        ElasticMaterial { young_pa: self.young_pa, poisson: self.poisson }
    }

    /// Policy for the contacts of a body that is `mass_kg` of the object: contacts nearer than its own contact radius are merged. The
    /// touched surface counts as a sphere of a quarter of the diagonal; use [`ContactPolicy::radius`] where the host knows better.
    pub fn contact_policy(&self, mass_kg: f64) -> ContactPolicy {
        let own = ContactBody { material: self.contact_material(), mass_kg, radius_m: 0.25 * self.diagonal_m };
        ContactPolicy::new(own).merge(self.radius_m)
    }
}

impl ObjectFacts {
    fn of(row: &ObjectRow) -> Self {
        Self {
            name: row.name(),
            state: row.state(),
            error: row.error(),
            material: row.material(),
            bodies: row.bodies,
            degree_max: row.degree_max,
            fragments_max: Some(row.fragments_max).filter(|most| *most > 0),
            bytes_max: Some(row.bytes_max).filter(|most| *most > 0),
            elastic_nodes: row.elastic_nodes,
            crack_nodes: row.crack_nodes,
            gamma_j_m2: row.gamma_j_m2,
            young_pa: row.young_pa,
            poisson: row.poisson,
            density_kg_m3: row.density_kg_m3,
            volume_m3: row.volume_m3,
            diagonal_m: row.diagonal_m,
            center_m: row.center_m,
            bounds_m: row.bounds_m,
            radius_m: row.radius_m,
            duration_s: row.duration_s,
            generation: row.generation,
            memory_bytes: row.memory_bytes,
            file_bytes: row.file_bytes,
            loaded_unix: Duration::from_nanos(row.loaded_unix_ns),
            load_time: Duration::from_nanos(row.load_ns),
        }
    }
}

pub(crate) fn objects(connection: &Connection, deadline: Deadline) -> Result<Vec<ObjectFacts>, Error> {
    let mut objects: Vec<ObjectFacts> = Vec::new();
    loop {
        let (rows, total) = ask::<ObjectRow>(connection, ControlRequest::List(objects.len() as u32), deadline)?;
        objects.extend(rows.iter().map(ObjectFacts::of));
        if rows.is_empty() || objects.len() >= total as usize {
            return Ok(objects);
        }
    }
}

pub(crate) fn status(connection: &Connection, deadline: Deadline) -> Result<Status, Error> {
    let (rows, _) = ask::<ServiceStatusRow>(connection, ControlRequest::Status, deadline)?;
    rows.first().map(Status::of).ok_or_else(no_reply)
}

pub(crate) fn release(connection: &Connection, handle: u64, deadline: Deadline) -> Result<(), Error> {
    let after = connection.followed();
    ask::<ErrorWire>(connection, ControlRequest::Release { handle, after }, deadline).map(|_| ())
}

/// Asks and waits; returns the rows and how many there are in all.
fn ask<R: ReplyRow>(
    connection: &Connection,
    request: ControlRequest,
    deadline: Deadline,
) -> Result<(Vec<R>, u32), Error> {
    let pending = connection.ask(request)?;
    let mut liveness = LivenessCheck::now();
    loop {
        if let Some(reply) = poll::<R>(connection, &pending)? {
            return Ok(reply);
        }
        if deadline.passed() {
            return Err(Error::new(ErrorKind::Late, "control", "the service did not reply in time"));
        }
        connection.check_alive(&mut liveness)?;
        connection.wait(deadline);
    }
}

/// Looks for the reply; never blocks.
pub(crate) fn poll<R: ReplyRow>(
    connection: &Connection,
    pending: &PendingControlRequest,
) -> Result<Option<(Vec<R>, u32)>, Error> {
    let is_connected = pending.is_connected();
    match pending.receive().map_err(receive_failed)? {
        Some(reply) => Ok(Some((read::<R>(reply.user_header(), reply.payload())?, reply.user_header().total))),
        None if is_connected => Ok(None),
        None if connection.daemon_lives() => Err(no_reply()),
        None => Err(connection.lost()),
    }
}

fn no_reply() -> Error {
    Error::new(ErrorKind::Busy, "control", "the service closed the control request without a reply")
}
