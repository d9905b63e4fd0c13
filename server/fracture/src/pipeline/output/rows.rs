//! Tables of the fragments: one row each, offsets into the bulk sections.

use nalgebra::{Point3, Vector3};

/// Neighbor of an outer run, and of a run on an earlier crack: no fragment.
pub const OUTER: u32 = u32::MAX;

/// One fragment. Offsets point into the sections; index values are relative to the fragment's first vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FragmentRow {
    /// Position in the table; dense from 0.
    pub id: u32,
    /// Body (component of the object) it comes from.
    pub body: u32,
    /// First vertex in the positions section.
    pub vertex_first: u32,
    /// Number of vertices.
    pub vertex_count: u32,
    /// First index in the indices section.
    pub index_first: u32,
    /// Number of indices, three per triangle.
    pub index_count: u32,
    /// First run in the runs section; the outer run, if any, comes first.
    pub run_first: u32,
    /// Number of runs.
    pub run_count: u32,
    /// First pair in the merge section.
    pub merge_first: u32,
    /// Number of merge pairs.
    pub merge_count: u32,
    /// Volume, m³.
    pub volume_m3: f64,
    /// Mass, kg.
    pub mass_kg: f64,
    /// Center of mass in the coordinates of the mesh file, m. Positions are relative to it.
    pub center_m: [f64; 3],
    /// Inertia about the center, axes of the mesh file, kg·m²: xx, yy, zz, xy, xz, yz (tensor entries, so off-diagonal
    /// ones carry their minus sign).
    pub inertia_kg_m2: [f64; 6],
    /// Distance-weighted energy E_i of the cell it belongs to, J·m².
    pub energy_j_m2: f64,
}

/// Triangles of one fragment that face one neighbor, or the outside. The fragment of an earlier answer on the other side of an
/// earlier crack is not told of: such runs follow those with neighbors, one per fragment that was there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RunRow {
    /// The fragment it belongs to.
    pub fragment: u32,
    /// The fragment on the other side, or [`OUTER`]: the outside, or a fragment of an earlier answer.
    pub neighbor: u32,
    /// Whether it is a side of a crack, be it an earlier one.
    pub crack: bool,
    /// First vertex in the positions section.
    pub vertex_first: u32,
    /// Number of vertices.
    pub vertex_count: u32,
    /// First index in the indices section.
    pub index_first: u32,
    /// Number of indices.
    pub index_count: u32,
}

/// Lengths of the bulk sections.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BulkCounts {
    /// Vertices: three f32 each.
    pub vertices: usize,
    /// Indices: one u32 each.
    pub indices: usize,
    /// Merge pairs: two u32 each.
    pub merges: usize,
}

/// Second fragment of a bond that ties the first to the world: no fragment.
pub const WORLD: u32 = u32::MAX;

/// Two fragments that touch; or one that lies, in part at least, in an anchor, and the world that holds it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BondRow {
    /// The fragments, the lower id first; the second may be [`WORLD`].
    pub fragments: [u32; 2],
    /// Area of the crack between them, m². Of a bond with the world: of the triangles of the fragment's outer surface whose
    /// centroids lie in anchors; zero where these hold inner parts alone.
    pub area_m2: f64,
    /// Mean normal of that area from the first to the second, of length one; zero where it closes upon itself, or there is none.
    pub normal: Vector3<f64>,
    /// Centroid of that area, coordinates of the mesh file, m; of the held nodes of the crack lattice where there is none.
    pub centroid_m: Point3<f64>,
}
