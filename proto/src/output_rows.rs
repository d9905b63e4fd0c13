//! What answers carry beside the pieces, if it is asked for.

use bytemuck::{Pod, Zeroable};

/// How a fragment moves once it is free, on top of how the object moved. Sums over all fragments: neither linear nor angular
/// momentum.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct VelocityWire {
    /// Velocity of the center of mass, m/s.
    pub linear_m_s: [f64; 3],
    /// Angular velocity, rad/s.
    pub angular_rad_s: [f64; 3],
}

/// Where a ray first met the object.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct HitWire {
    /// The point, m.
    pub point_m: [f64; 3],
    /// Normal of the surface there, outward, of length one.
    pub normal: [f64; 3],
    /// From the origin of the ray to the point, m.
    pub distance_m: f64,
    /// Body (component of the object) that it lies on.
    pub body: u32,
    /// 1 if the strike had a ray; else 0, and everything else is zero.
    pub present: u32,
}

/// Second fragment of a bond that ties the first to the world: no fragment.
pub const WORLD: u32 = u32::MAX;

/// Two fragments that touch; or one that lies, in part at least, in an anchor of the scene, and the world that holds it.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct BondWire {
    /// The fragments, the lower id first; the second may be [`WORLD`].
    pub fragments: [u32; 2],
    /// Area of the crack between them, m². Of a bond with the world: of the triangles of the fragment's outer surface whose
    /// centroids the anchors hold; zero where they hold inner parts alone.
    pub area_m2: f64,
    /// Mean normal of that area, of length one, from the first to the second; zero where it closes upon itself, or there is none.
    pub normal: [f64; 3],
    /// Centroid of that area in the coordinates of the mesh file, m; of the held nodes of the crack lattice where there is none.
    pub centroid_m: [f64; 3],
}

impl BondWire {
    /// Whether it ties a fragment to the world.
    pub fn holds_to_world(&self) -> bool {
        self.fragments[1] == WORLD
    }
}

/// A point of a crack from which dust and chips come.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct DebrisWire {
    /// The fragment on whose crack face it lies: of two neighbors the one with the lower id.
    pub fragment: u32,
    /// The other one.
    pub neighbor: u32,
    /// Where, m, relative to the fragment's center of mass.
    pub position_m: [f32; 3],
    /// Normal of the crack there, out of the fragment.
    pub normal: [f32; 3],
    /// Diameter, m.
    pub size_m: f32,
    /// Zero.
    pub reserved: u32,
}

/// The convex proxy of one fragment: at most [`HULL_FACES_MAX`] triangles, and fewer vertices.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct HullWire {
    /// First vertex in the hull positions.
    pub vertex_first: u32,
    /// Number of vertices; zero: the fragment is too flat for a hull.
    pub vertex_count: u32,
    /// First index in the hull indices.
    pub index_first: u32,
    /// Number of indices, three per triangle.
    pub index_count: u32,
    /// Volume of the part of the fragment inside the hull over that of the fragment.
    pub coverage: f64,
    /// The deepest that the surface of any other fragment lies below the hull's surface, m.
    pub margin_m: f64,
}

/// How a vertex of an outer face looks; zero on crack faces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct VertexAttributeWire {
    /// Of length one.
    pub normal: [f32; 3],
    /// Texture coordinates of the input, v upwards (OBJ's; 1 − v of glTF's); zero where it has none.
    pub uv: [f32; 2],
}

/// The part of the input's surface that one fragment wears; nothing where no part of it is its.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct SkinWire {
    /// First vertex in the skin vertices.
    pub vertex_first: u32,
    /// Number of vertices.
    pub vertex_count: u32,
    /// First index in the skin indices.
    pub index_first: u32,
    /// Number of indices, three per triangle.
    pub index_count: u32,
}

/// A vertex of a skin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct SkinVertexWire {
    /// Relative to the fragment's center of mass, m.
    pub position_m: [f32; 3],
    /// Of length one.
    pub normal: [f32; 3],
    /// Texture coordinates of the input, v upwards (OBJ's; 1 − v of glTF's); zero where it has none.
    pub uv: [f32; 2],
}

/// Material of a triangle that has none of the input's: of crack faces, for instance.
pub const NO_MATERIAL: u32 = u32::MAX;

/// Most triangles of a hull.
pub const HULL_FACES_MAX: usize = 64;
