//! Questions to the small service beside the strikes.

use crate::Deadline;
use crate::connection::{Connection, LivenessCheck, PendingControlRequest, receive_failed};
use shatter_export::contact::{ContactBody, ContactPolicy, ElasticMaterial};
use shatter_proto::control::{ControlRequest, Latency, ObjectRow, ObjectState, ReplyRow, StatusRow, read};
use shatter_proto::error::ErrorWire;
use shatter_proto::result::STAGES;
use shatter_proto::{Error, ErrorKind};
use std::time::Duration;

/// What `list` says about one object.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectFacts {
    /// Its name.
    pub name: String,
    /// Whether it can be struck. If not, everything but `state` and `refusal` is zero.
    pub ready: bool,
    /// The same in more words: also whether it is being loaded.
    pub state: ObjectState,
    /// Why it cannot be struck: `loading` or `corrupt_object`. If it is ready: why what lies in its place now could not; the version loaded before is
    /// served until that is mended or removed.
    pub refusal: Option<Error>,
    /// Name of its material.
    pub material: String,
    /// Bodies (components).
    pub bodies: u32,
    /// Cap on the degree.
    pub degree_max: u32,
    /// A strike with more fragments is refused, if there is such a limit.
    pub fragments_max: Option<u64>,
    /// A strike with a longer answer is refused, bytes, if there is such a limit.
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
    /// Volume, m³.
    pub volume_m3: f64,
    /// Diagonal of the bounding box, m.
    pub diagonal_m: f64,
    /// Center of the bounding box, m.
    pub center_m: [f64; 3],
    /// Lowest and highest corner of the mesh, m. The lattice's surface, which rays hit, can lie outside by part of its spacing.
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
    /// When it was loaded, since 1970 (UTC).
    pub loaded_unix: Duration,
    /// How long that took.
    pub load_time: Duration,
}

impl ObjectFacts {
    /// What the object is made of, for the theory of contacts.
    pub fn contact_material(&self) -> ElasticMaterial {
        ElasticMaterial { young_pa: self.young_pa, poisson: self.poisson }
    }

    /// Terms of a body that is `mass_kg` of the object: contacts nearer than its own contact radius are one. Its surface where it is
    /// touched is taken for a sphere of a quarter of the diagonal; say better with [`ContactPolicy::radius`] where the host knows.
    pub fn contact_terms(&self, mass_kg: f64) -> ContactPolicy {
        let own = ContactBody { material: self.contact_material(), mass_kg, radius_m: 0.25 * self.diagonal_m };
        ContactPolicy::new(own).merge(self.radius_m)
    }
}

impl From<&ObjectRow> for ObjectFacts {
    fn from(row: &ObjectRow) -> Self {
        Self {
            name: row.name(),
            ready: row.state() == ObjectState::Ready,
            state: row.state(),
            refusal: row.refusal(),
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

/// How the service goes; counters since the daemon started.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Status(pub(crate) StatusRow);

impl Status {
    /// The row as it travelled.
    pub fn row(&self) -> &StatusRow {
        &self.0
    }

    /// Times by stage, in the order in which data flows.
    pub fn stages(&self) -> impl Iterator<Item = (&'static str, &Latency)> {
        STAGES.into_iter().zip(&self.0.stages)
    }
}

pub(crate) fn objects(link: &Connection, deadline: Deadline) -> Result<Vec<ObjectFacts>, Error> {
    let mut objects: Vec<ObjectFacts> = Vec::new();
    loop {
        let (rows, total) = ask::<ObjectRow>(link, ControlRequest::List(objects.len() as u32), deadline)?;
        objects.extend(rows.iter().map(ObjectFacts::from));
        if rows.is_empty() || objects.len() >= total as usize {
            return Ok(objects);
        }
    }
}

pub(crate) fn status(link: &Connection, deadline: Deadline) -> Result<Status, Error> {
    let (rows, _) = ask::<StatusRow>(link, ControlRequest::Status, deadline)?;
    rows.first().copied().map(Status).ok_or_else(unanswered)
}

pub(crate) fn release(link: &Connection, handle: u64, deadline: Deadline) -> Result<(), Error> {
    let after = link.last_sequence();
    ask::<ErrorWire>(link, ControlRequest::Release { handle, after }, deadline).map(|_| ())
}

/// Asks and waits; returns the rows and how many there are in all.
fn ask<R: ReplyRow>(link: &Connection, question: ControlRequest, deadline: Deadline) -> Result<(Vec<R>, u32), Error> {
    let pending = link.ask(question)?;
    let mut pulse = LivenessCheck::now();
    loop {
        if let Some(reply) = poll::<R>(link, &pending)? {
            return Ok(reply);
        }
        if deadline.passed() {
            return Err(Error::new(ErrorKind::Late, "control", "the service did not reply in time"));
        }
        link.feel(&mut pulse)?;
        link.wait(deadline);
    }
}

/// Looks for the reply; never blocks.
pub(crate) fn poll<R: ReplyRow>(
    link: &Connection,
    pending: &PendingControlRequest,
) -> Result<Option<(Vec<R>, u32)>, Error> {
    let connected = pending.is_connected();
    match pending.receive().map_err(receive_failed)? {
        Some(reply) => Ok(Some((read::<R>(reply.user_header(), reply.payload())?, reply.user_header().total))),
        None if connected => Ok(None),
        None if link.daemon_lives() => Err(unanswered()),
        None => Err(link.lost()),
    }
}

fn unanswered() -> Error {
    Error::new(ErrorKind::Busy, "control", "the service closed the question without a reply")
}
