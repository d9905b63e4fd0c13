//! An answer: header, section table, sections.
//!
//! The header travels as the transport's user header. The payload is a slice of [`Block`]s: first the section table, one
//! [`SectionWire`] per section, then the sections in the order of [`SectionKind::ALL`], each beginning at a multiple of
//! 64 bytes. Index values and merge pairs are relative to the first vertex of their fragment; everything else counts from
//! the beginning of its section.
//!
//! Vertex sets belong to runs: a vertex on the rim of two runs appears in both, at bitwise equal positions, and the merge
//! pairs say which ones are the same, so that a fragment is provably closed although its normals split (after Manifold,
//! *merge vectors*).
//!
//! Meters, axes and winding are said for the default convention. A strike with another one ([`crate::convention`]) is answered in its
//! axes, winding and unit of length: then `_m`, `_m2` and `_m3` stand for that unit.

use crate::effect::Effect;
use crate::name::OBJECT_NAME_MAX;
use crate::request::Quality;
use crate::text;
use bytemuck::{Pod, Zeroable};

pub use crate::overrun::{MissedTime, OVERRUNS, OverrunCause};

pub use crate::output_rows::{
    BondWire, DebrisWire, HULL_FACES_MAX, HitWire, HullWire, NO_MATERIAL, SkinVertexWire, SkinWire, VelocityWire,
    VertexAttributeWire, WORLD,
};

/// First bytes of every answer.
pub const ANSWER_MAGIC: u32 = u32::from_le_bytes(*b"SHTa");

/// The element in which answers are lent: its alignment is the alignment of every section.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
#[repr(align(64))]
pub struct Block {
    /// Whatever the section table says.
    pub bytes: [u8; 64],
}

/// Bytes per [`Block`], and alignment of every section.
pub const BLOCK_BYTES: usize = size_of::<Block>();

/// Header of an answer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct ResultHeader {
    /// [`ANSWER_MAGIC`].
    pub magic: u32,
    /// [`crate::PROTOCOL_VERSION`].
    pub version: u32,
    /// 1: answered. Refusals travel over the control service.
    pub status: u32,
    /// Entries of the section table.
    pub sections: u32,
    /// Bytes of the payload that count; the lent slice may be longer.
    pub used_bytes: u64,
    /// Sequence of the request that is answered.
    pub sequence: u64,
    /// Zero.
    pub reserved: [u64; 4],
}

/// Entry of the section table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct SectionWire {
    /// [`SectionKind`] as a number.
    pub kind: u32,
    /// Bytes per element.
    pub element_bytes: u32,
    /// First byte, counted from the beginning of the payload; a multiple of 64.
    pub offset: u64,
    /// Length in bytes, without padding; a multiple of `element_bytes`.
    pub length: u64,
}

pub use crate::sections::SectionKind;

/// Which rule produced the fracture degree; the numbers of [`SummaryWire::degree_source`].
pub const DEGREE_SOURCES: [&str; 6] = ["threshold", "closed_form", "inferred", "verified", "optimised", "forced"];

/// Where the number of sites was to come from; the numbers of [`SummaryWire::degree`].
pub const DEGREES: [&str; 6] = ["preset", "closed_form", "optimised", "sites", "verified", "inferred"];

/// Where the energy came from; the numbers of [`SummaryWire::elastic`]. Solved if one body's displacements were; falloff where the
/// effect `elastic` is off; bounded where the object stays whole whatever the displacements are, so that there are none.
pub const ELASTIC_SOURCES: [&str; 4] = ["solve", "reduced", "falloff", "bounded"];

/// What stopped the strike; the numbers of [`SummaryWire::stop_reason`]. Complete: no diagram was made. Capped: the degree reached a cap.
/// Else what ended the descent of the diagrams: their tolerance, the error or the time of the strike, or the iterations allowed.
pub const STOP_REASONS: [&str; 6] = ["complete", "capped", "converged", "error_met", "time", "iterations"];

/// Stages, by the number in [`StageWire::stage`].
pub const STAGES: [&str; 8] =
    ["load", "elasticity", "threshold", "degree", "centroidal", "labels", "tessellation", "fragments"];

/// The facts of a strike.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct SummaryWire {
    /// UTF-8.
    pub object: [u8; OBJECT_NAME_MAX],
    /// Bytes of `object` that count.
    pub object_length: u32,
    /// Index into [`DEGREE_SOURCES`].
    pub degree_source: u32,
    /// Sites asked of the diagram.
    pub sites: u32,
    /// n of the criterion; 1: the object stays whole.
    pub fracture_degree: u32,
    /// 1 if the object's cap on the degree was reached.
    pub capped: u32,
    /// Index into [`STOP_REASONS`].
    pub stop_reason: u32,
    /// Index into [`ELASTIC_SOURCES`].
    pub elastic: u32,
    /// The preset, by its number in a request.
    pub quality: u32,
    /// γ used, J·m².
    pub gamma_j_m2: f64,
    /// E_1/γ; where `elastic` is bounded it is at most this.
    pub e1_over_gamma: f64,
    /// Factor on the impulses at which the object just breaks, √(γ/E_1), or more where `elastic` is bounded; 0 where its weight alone breaks it. With the effect
    /// `gravity` it is searched for where nothing but the threshold is asked for; else it is that on all loads, weight among them.
    pub threshold_impulse_factor: f64,
    /// 0 to 1.
    pub confidence: f64,
    /// Seed used.
    pub seed: u64,
    /// Names this answer for later strikes; zero: not kept.
    pub handle: u64,
    /// Largest contact radius in effect, m: at least a multiple of the elastic spacing.
    pub radius_m: f64,
    /// Relative error of the elastic energy, estimated; zero where it was solved for, or there is none.
    pub energy_error: f64,
    /// Relative energy of the diagrams above the end of their descents, estimated: the largest; zero without one.
    pub cvd_gap: f64,
    /// Tolerance of the diagrams.
    pub tolerance: f64,
    /// From admission until right before the answer was sent, ns; like those of stages it differs between equal strikes.
    pub time_ns: u64,
    /// Iterations of a diagram that were allowed.
    pub iterations_max: u32,
    /// Iterations taken: the most of all bodies.
    pub iterations: u32,
    /// Displacements of a basis that were used: the most of all bodies; zero where none was.
    pub rank: u32,
    /// Coordinates of the lift beside those in space: the most of all bodies.
    pub lift_modes: u32,
    /// Nodes of the object's elastic lattices.
    pub elastic_nodes: u32,
    /// Nodes of the object's crack lattices.
    pub crack_nodes: u32,
    /// Where the number of sites was to come from, by its number in a request.
    pub degree: u32,
    /// Why the time that was asked for was exceeded: index into [`OVERRUNS`].
    pub overrun: u32,
    /// Estimated relative error up to which reduced displacements stand; beyond it they are solved for.
    pub reduced_error_max: f64,
    /// Where the ray of the strike met the object, if it had one.
    pub hit: HitWire,
    /// By how much `time_ns` exceeds the time that was asked for, ns; zero if it does not, or none was.
    pub overrun_ns: u64,
}

impl SummaryWire {
    /// The object's name, for showing.
    pub fn object(&self) -> String {
        text::show(&self.object, self.object_length)
    }

    /// Sets the object's name.
    pub fn set_object(&mut self, name: &str) {
        self.object_length = text::put(&mut self.object, name);
    }

    /// Name of the rule that produced the degree.
    pub fn degree_source(&self) -> &'static str {
        DEGREE_SOURCES.get(self.degree_source as usize).copied().unwrap_or("unknown")
    }

    /// Name of where the displacements came from.
    pub fn elastic(&self) -> &'static str {
        ELASTIC_SOURCES.get(self.elastic as usize).copied().unwrap_or("unknown")
    }

    /// Name of the preset.
    pub fn quality(&self) -> &'static str {
        Quality::by_number(self.quality).map_or("unknown", Quality::name)
    }

    /// Name of where the number of sites was to come from.
    pub fn degree(&self) -> &'static str {
        DEGREES.get(self.degree as usize).copied().unwrap_or("unknown")
    }

    /// Name of what stopped the strike.
    pub fn stop_reason(&self) -> &'static str {
        STOP_REASONS.get(self.stop_reason as usize).copied().unwrap_or("unknown")
    }
}

/// What one stage did.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct StageWire {
    /// Index into [`STAGES`].
    pub stage: u32,
    /// 1 if it ran.
    pub ran: u32,
    /// Time it took, ns; the only part of an answer that differs between equal strikes.
    pub ns: u64,
    /// Bytes of results it produced.
    pub bytes: u64,
}

impl StageWire {
    /// The stage's name.
    pub fn name(&self) -> &'static str {
        STAGES.get(self.stage as usize).copied().unwrap_or("unknown")
    }
}

/// What one effect did.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct EffectWire {
    /// Its bit: place in [`Effect::ALL`].
    pub effect: u32,
    /// 1 if it ran.
    pub ran: u32,
    /// Time it took by itself, ns; zero where it is part of a stage. Like those of stages it differs between equal strikes.
    pub ns: u64,
    /// Bytes of results it produced, or of tables it used.
    pub bytes: u64,
}

impl EffectWire {
    /// The effect's name.
    pub fn name(&self) -> &'static str {
        Effect::ALL.get(self.effect as usize).map_or("unknown", |effect| effect.name())
    }
}

/// Neighbor of an outer run: nobody.
pub const OUTER: u32 = u32::MAX;

/// Triangles of one fragment that face one neighbor, or the outside. The outer run, if any, comes first; after those with
/// neighbors follow the sides of earlier cracks, where a fragment was struck again: one per fragment of the earlier answer on
/// the other side, with material 1 and the neighbor [`OUTER`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct RunWire {
    /// The fragment it belongs to.
    pub fragment: u32,
    /// The fragment on the other side, or [`OUTER`].
    pub neighbor: u32,
    /// First vertex in the positions.
    pub vertex_first: u32,
    /// Number of vertices.
    pub vertex_count: u32,
    /// First index in the indices, a multiple of three.
    pub index_first: u32,
    /// Number of indices, three per triangle.
    pub index_count: u32,
    /// 0: outer. 1: crack.
    pub material: u32,
    /// Zero.
    pub reserved: u32,
}

/// One fragment.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct FragmentWire {
    /// Position in the table.
    pub id: u32,
    /// Body (component of the object) it comes from.
    pub body: u32,
    /// First vertex in the positions.
    pub vertex_first: u32,
    /// Number of vertices.
    pub vertex_count: u32,
    /// First index in the indices, a multiple of three.
    pub index_first: u32,
    /// Number of indices, three per triangle.
    pub index_count: u32,
    /// First run.
    pub run_first: u32,
    /// Number of runs.
    pub run_count: u32,
    /// First merge pair.
    pub merge_first: u32,
    /// Number of merge pairs.
    pub merge_count: u32,
    /// Zero.
    pub reserved: [u32; 2],
    /// Volume, m³.
    pub volume_m3: f64,
    /// Mass, kg.
    pub mass_kg: f64,
    /// Center of mass in the coordinates of the mesh file, m.
    pub center_m: [f64; 3],
    /// Inertia tensor about the center, kg·m²: xx, yy, zz, xy, xz, yz.
    pub inertia_kg_m2: [f64; 6],
    /// Distance-weighted energy of the cell it belongs to, J·m².
    pub energy_j_m2: f64,
}

const _: () = assert!(size_of::<Block>() == 64 && align_of::<Block>() == 64);
const _: () = assert!(size_of::<ResultHeader>() == 64);
const _: () = assert!(size_of::<SectionWire>() == 24);
const _: () = assert!(size_of::<SummaryWire>() == 296);
const _: () = assert!(size_of::<StageWire>() == 24);
const _: () = assert!(size_of::<RunWire>() == 32);
const _: () = assert!(size_of::<FragmentWire>() == 144);
const _: () = assert!(size_of::<EffectWire>() == 24);
const _: () = assert!(size_of::<VelocityWire>() == 48);
const _: () = assert!(size_of::<BondWire>() == 64);
const _: () = assert!(size_of::<DebrisWire>() == 40);
const _: () = assert!(size_of::<HullWire>() == 32);
const _: () = assert!(size_of::<VertexAttributeWire>() == 20);
const _: () = assert!(size_of::<SkinWire>() == 16);
const _: () = assert!(size_of::<SkinVertexWire>() == 32);
const _: () = assert!(crate::PROTOCOL_VERSION == 6, "sizes above are those of version 6");
