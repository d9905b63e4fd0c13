//! Rows that effects add to results: as they lie in shared memory, and as hosts read them.

use crate::codes::FragmentSurface;
use crate::convention::Convention;
use crate::in_meters::InMeters;
use bytemuck::{Pod, Zeroable};

/// Velocity of a fragment once it is free, in addition to the object's motion. Neither linear nor angular momentum is left when all
/// fragments are summed up. Plain numbers in this order (`repr(C)`).
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct FragmentVelocity {
    /// Velocity of the center of mass, m/s.
    pub linear_m_s: [f64; 3],
    /// Angular velocity, rad/s.
    pub angular_rad_s: [f64; 3],
}

impl InMeters for FragmentVelocity {
    fn in_meters(&self, from: &Convention) -> Self {
        Self { linear_m_s: from.our_vector(self.linear_m_s), angular_rad_s: from.our_axial(self.angular_rad_s) }
    }
}

/// First intersection of a ray with the object.
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
    /// Surface that the ray hit: 1 more than its code. 0 if the request had no ray, and everything else is zero.
    pub surface: u32,
}

impl HitWire {
    /// [`Self::surface`] of a hit on `surface`.
    #[must_use]
    pub fn code_of(surface: FragmentSurface) -> u32 {
        surface.code() + 1
    }

    /// The surface that the ray hit; `None` without a ray.
    #[must_use]
    pub fn hit_surface(&self) -> Option<FragmentSurface> {
        Some(FragmentSurface::from_code(self.surface.checked_sub(1)?))
    }
}

/// Second fragment of a bond that ties the first to the world: no fragment.
pub const WORLD: u32 = u32::MAX;

/// A [`Bond`] as it travels.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct BondWire {
    /// The fragments, the lower id first; the second may be [`WORLD`].
    pub fragments: [u32; 2],
    /// See [`Bond::area_m2`].
    pub area_m2: f64,
    /// See [`Bond::normal`].
    pub normal: [f64; 3],
    /// See [`Bond::centroid_m`].
    pub centroid_m: [f64; 3],
}

impl InMeters for BondWire {
    fn in_meters(&self, from: &Convention) -> Self {
        Self {
            area_m2: from.meters2(self.area_m2),
            normal: from.our_direction(self.normal),
            centroid_m: from.our_vector(self.centroid_m),
            ..*self
        }
    }
}

impl BondWire {
    /// Whether it ties a fragment to the world.
    pub fn holds_to_world(&self) -> bool {
        self.fragments[1] == WORLD
    }
}

/// Two fragments that touch; or one that lies, in part at least, in an anchor of the scene, and the world that holds it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Bond {
    /// The fragment; of two the one with the lower id.
    pub fragment: u32,
    /// The other fragment; `None`: the world.
    pub neighbor: Option<u32>,
    /// Area of the crack between them, m². Of a bond with the world: of the triangles of the fragment's outer surface whose
    /// centroids the anchors hold; zero where they hold inner parts alone.
    pub area_m2: f64,
    /// Mean normal of that area, of length one, out of `fragment`; zero where the area is closed upon itself, or zero.
    pub normal: [f64; 3],
    /// Centroid of that area in the coordinates of the object, m; of the held nodes of the crack lattice where the area is zero.
    pub centroid_m: [f64; 3],
}

impl Bond {
    /// A bond of `fragment` with `neighbor`, or with the world, without an area.
    #[must_use]
    pub fn new(fragment: u32, neighbor: Option<u32>) -> Self {
        Self { fragment, neighbor, area_m2: 0.0, normal: [0.0; 3], centroid_m: [0.0; 3] }
    }

    /// Whether it ties a fragment to the world.
    #[must_use]
    pub fn is_with_world(&self) -> bool {
        self.neighbor.is_none()
    }

    /// Ids of the fragments that it ties: one, or two in ascending order.
    pub fn fragments(&self) -> impl Iterator<Item = u32> {
        std::iter::once(self.fragment).chain(self.neighbor)
    }
}

impl From<&BondWire> for Bond {
    fn from(row: &BondWire) -> Self {
        let BondWire { fragments: [fragment, neighbor], area_m2, normal, centroid_m } = *row;
        Self { fragment, neighbor: (neighbor != WORLD).then_some(neighbor), area_m2, normal, centroid_m }
    }
}

/// A [`DebrisPoint`] as it travels.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct DebrisWire {
    /// See [`DebrisPoint::fragment`].
    pub fragment: u32,
    /// The other fragment.
    pub neighbor: u32,
    /// See [`DebrisPoint::position_m`].
    pub position_m: [f32; 3],
    /// See [`DebrisPoint::normal`].
    pub normal: [f32; 3],
    /// Diameter, m.
    pub size_m: f32,
    /// Zero.
    pub reserved: u32,
}

impl InMeters for DebrisWire {
    fn in_meters(&self, from: &Convention) -> Self {
        Self {
            position_m: from.our_vector_f32(self.position_m),
            normal: from.our_direction(self.normal),
            size_m: from.meters(self.size_m.into()) as f32,
            ..*self
        }
    }
}

/// A point of a crack from which dust and chips come.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct DebrisPoint {
    /// The fragment on whose crack face it lies: of two neighbors the one with the lower id.
    pub fragment: u32,
    /// The fragment on the other side of the crack.
    pub neighbor: u32,
    /// Position relative to the center of mass of `fragment`, m.
    pub position_m: [f32; 3],
    /// Normal of the crack there, of length one, out of `fragment`.
    pub normal: [f32; 3],
    /// Diameter, m.
    pub size_m: f32,
}

impl From<&DebrisWire> for DebrisPoint {
    fn from(row: &DebrisWire) -> Self {
        let DebrisWire { fragment, neighbor, position_m, normal, size_m, reserved: _ } = *row;
        Self { fragment, neighbor, position_m, normal, size_m }
    }
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

impl InMeters for HullWire {
    fn in_meters(&self, from: &Convention) -> Self {
        Self { margin_m: from.meters(self.margin_m), ..*self }
    }
}

/// The input's normal and texture coordinates at a vertex of an outer face; zero on crack faces. Plain numbers in this order
/// (`repr(C)`): a slice can be handed to a GPU as it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct OuterAttributes {
    /// Of length one.
    pub normal: [f32; 3],
    /// Texture coordinates of the input, v upwards (OBJ's; 1 − v of glTF's); zero where it has none.
    pub uv: [f32; 2],
}

impl InMeters for OuterAttributes {
    fn in_meters(&self, from: &Convention) -> Self {
        Self { normal: from.our_direction(self.normal), ..*self }
    }
}

/// The part of the input's surface that belongs to one fragment; empty if the fragment has no outer surface.
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

/// A vertex of a skin. Plain numbers in this order (`repr(C)`): a slice can be handed to a GPU as it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct SkinVertex {
    /// Relative to the fragment's center of mass, m.
    pub position_m: [f32; 3],
    /// Of length one.
    pub normal: [f32; 3],
    /// Texture coordinates of the input, v upwards (OBJ's; 1 − v of glTF's); zero where it has none.
    pub uv: [f32; 2],
}

impl InMeters for SkinVertex {
    fn in_meters(&self, from: &Convention) -> Self {
        Self { position_m: from.our_vector_f32(self.position_m), normal: from.our_direction(self.normal), ..*self }
    }
}

/// Material of a triangle that has none of the input's: of crack faces, for instance.
pub const NO_MATERIAL: u32 = u32::MAX;

/// Most triangles of a hull.
pub const HULL_FACES_MAX: usize = 64;

const _: () = assert!(size_of::<FragmentVelocity>() == 48);
const _: () = assert!(size_of::<BondWire>() == 64);
const _: () = assert!(size_of::<DebrisWire>() == 40);
const _: () = assert!(size_of::<HullWire>() == 32);
const _: () = assert!(size_of::<OuterAttributes>() == 20);
const _: () = assert!(size_of::<SkinWire>() == 16);
const _: () = assert!(size_of::<SkinVertex>() == 32);
