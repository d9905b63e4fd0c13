//! A result: header, section table, sections.
//!
//! The header is sent as the transport's user header. The payload is a slice of [`AlignedBlock`]s. It begins with the section
//! table, one [`SectionWire`] per section. The sections follow in the order of [`SectionKind::ALL`], each at a multiple
//! of 64 bytes. Indices and merge pairs count from the first vertex of their fragment; all other numbers count from the
//! beginning of their section.
//!
//! Each run of triangles has its own vertices. A vertex on the border of two runs appears in both, at bitwise equal
//! positions. The merge pairs list vertices that are one point (after Manifold, *merge vectors*). So a fragment can be
//! checked to be closed although its normals differ across runs.
//!
//! Units, axes and winding are those of the default convention. The result of a request with another convention
//! ([`crate::convention`]) uses that one's axes, winding and unit of length; `_m`, `_m2` and `_m3` then stand for that unit.
//!
//! Types whose names end with `Wire` are rows of shared memory: choices are numbers, and zero means absent. Hosts read the plain
//! types beside them: [`Summary`], [`StageCost`], [`EffectCost`], [`Bond`], [`DebrisPoint`]. [`FragmentVelocity`],
//! [`OuterAttributes`] and [`SkinVertex`] contain numbers only and serve as both.

use crate::convention::Convention;
use crate::in_meters::InMeters;
use bytemuck::{Pod, Zeroable};

pub use crate::codes::{
    DegreeMethod, DegreeOrigin, EnergySource, FractureCriterion, FragmentSurface, OverrunCause, StageKind,
    StopCriterion,
};
pub use crate::costs::{EffectCost, EffectWire, StageCost, StageWire};
pub use crate::output_rows::*;
pub use crate::sections::SectionKind;
pub use crate::summary::{MissedTime, Summary, SummaryWire};

/// First bytes of every result.
pub const RESULT_MAGIC: u32 = u32::from_le_bytes(*b"SHTa");

/// The element in which results are lent: its alignment is the alignment of every section.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
#[repr(align(64))]
pub struct AlignedBlock {
    /// Whatever the section table says.
    pub bytes: [u8; 64],
}

/// Bytes per [`AlignedBlock`], and alignment of every section.
pub const BLOCK_BYTES: usize = size_of::<AlignedBlock>();

/// Header of a result.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct ResultHeader {
    /// [`RESULT_MAGIC`].
    pub magic: u32,
    /// [`crate::PROTOCOL_VERSION`].
    pub version: u32,
    /// 1: complete. Errors travel over the control service.
    pub status: u32,
    /// Entries of the section table.
    pub sections: u32,
    /// Bytes of the payload that count; the lent slice may be longer.
    pub used_bytes: u64,
    /// Sequence of the request that led to it.
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

/// Neighbor of an outer run: no fragment.
pub const OUTER: u32 = u32::MAX;

/// Triangles of one fragment that face one neighbor, or the outside. The outer run, if any, comes first; after those with
/// neighbors follow the sides of earlier cracks, where a fragment was struck again: one per fragment of the earlier result on
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
    /// Center of mass in the coordinates of the object, m.
    pub center_m: [f64; 3],
    /// Inertia tensor about the center, kg·m²: xx, yy, zz, xy, xz, yz.
    pub inertia_kg_m2: [f64; 6],
    /// Distance-weighted energy of the cell it belongs to, J·m².
    pub energy_j_m2: f64,
}

impl InMeters for FragmentWire {
    fn in_meters(&self, from: &Convention) -> Self {
        Self {
            volume_m3: from.meters3(self.volume_m3),
            center_m: from.our_vector(self.center_m),
            inertia_kg_m2: from.our_inertia(self.inertia_kg_m2),
            ..*self
        }
    }
}

const _: () = assert!(size_of::<AlignedBlock>() == 64 && align_of::<AlignedBlock>() == 64);
const _: () = assert!(size_of::<ResultHeader>() == 64);
const _: () = assert!(size_of::<SectionWire>() == 24);
const _: () = assert!(size_of::<SummaryWire>() == 392);
const _: () = assert!(size_of::<StageWire>() == 24);
const _: () = assert!(size_of::<RunWire>() == 32);
const _: () = assert!(size_of::<FragmentWire>() == 144);
const _: () = assert!(size_of::<EffectWire>() == 24);
const _: () = assert!(crate::PROTOCOL_VERSION == 12, "sizes above are those of version 12");
