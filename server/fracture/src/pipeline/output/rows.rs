//! Rows of the tables of fragments, with offsets into the bulk sections.

use nalgebra::{Point3, Vector3};

/// Marks the neighbor of an outer run, or of a run on an earlier crack: no fragment.
pub const OUTER: u32 = u32::MAX;

/// One fragment. Offsets refer to the sections; index values are relative to the fragment's first vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FragmentRow {
    /// Index in the table, from 0 without gaps.
    pub id: u32,
    /// Body (connected component of the object) that the fragment was part of.
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
    /// Center of mass in the coordinates of the mesh file, m; the origin of the positions.
    pub center_m: [f64; 3],
    /// Inertia about the center, axes of the mesh file, kg·m²: xx, yy, zz, xy, xz, yz.
    ///
    /// Tensor entries, so off-diagonal ones include their minus sign.
    pub inertia_kg_m2: [f64; 6],
    /// Distance-weighted energy E_i of the fragment's cell, J·m².
    pub energy_j_m2: f64,
}

/// Triangles of one fragment that face one neighbor, or no fragment of the result.
///
/// Runs on earlier cracks follow those with neighbors, one per fragment of the earlier result on the other side. They
/// do not name that fragment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RunRow {
    /// Fragment of the run.
    pub fragment: u32,
    /// Fragment on the other side, or [`OUTER`]: the outside, or a fragment of an earlier result.
    pub neighbor: u32,
    /// True on a crack, including earlier ones.
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
    /// Number of vertices, three f32 each.
    pub vertices: usize,
    /// Number of indices, one u32 each.
    pub indices: usize,
    /// Number of merge pairs, two u32 each.
    pub merges: usize,
}

/// Marks the second fragment of a bond with the world: no fragment.
pub const WORLD: u32 = u32::MAX;

/// A contact area of two fragments, or of a fragment partly inside an anchor and the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BondRow {
    /// Fragments, the lower id first; the second may be [`WORLD`].
    pub fragments: [u32; 2],
    /// Area of the crack between the fragments, m².
    ///
    /// With the world: area of the triangles of the fragment's outer surface with centroids in anchors; 0 if anchors
    /// hold only inner parts.
    pub area_m2: f64,
    /// Mean unit normal of that area, from the first to the second; zero if the area is closed or empty.
    pub normal: Vector3<f64>,
    /// Centroid of that area, coordinates of the mesh file, m. Without area: mean of the anchored nodes of the crack
    /// lattice.
    pub centroid_m: Point3<f64>,
}
