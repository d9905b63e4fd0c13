//! Contents of a result as C reads them: facts are copied, meshes stay in shared memory.

use crate::error::text;
use shatter_client::FractureResult;
use shatter_proto::result as wire;
use std::ffi::c_char;
use std::mem::offset_of;
use std::ptr;
use std::time::Duration;

/// No fragment or no material. Neighbor of a run that faces no fragment of the result; second fragment of a bond with the world; material
/// of a triangle without one.
pub const NONE: u32 = u32::MAX;

/// First hit of a ray on an object. The surface is the one onto which contact points are projected: that of the fragments that the request asks for.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Hit {
    /// Point of the hit, m.
    pub point_m: [f64; 3],
    /// Outward normal of the surface at the point, of length one.
    pub normal: [f64; 3],
    /// Distance from the origin of the ray to the point, m.
    pub distance_m: f64,
    /// Body (component of the object) that was hit.
    pub body: u32,
    /// True if there is a hit. If not, the request had no ray, and all other fields are zero.
    pub present: bool,
}

impl From<Option<shatter_client::Hit>> for Hit {
    fn from(hit: Option<shatter_client::Hit>) -> Self {
        hit.map_or(
            Self { point_m: [0.0; 3], normal: [0.0; 3], distance_m: 0.0, body: 0, present: false },
            |shatter_client::Hit { point_m, normal, distance_m, body, .. }| Self {
                point_m,
                normal,
                distance_m,
                body,
                present: true,
            },
        )
    }
}

/// Summary of a result.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Summary {
    /// Number of fragments; 0: the object stayed whole, or the request asked only for the threshold.
    pub fragment_count: u32,
    /// Sites asked of the diagram.
    pub sites: u32,
    /// Degree n of the criterion; 1: the object stays whole.
    pub fracture_degree: u32,
    /// Source of the degree. 0: threshold. 1: closed form. 2: inferred. 3: verified. 4: optimized. 5: forced.
    pub degree_source: u32,
    /// True if the object's cap on the degree was reached.
    pub capped: bool,
    /// Reason to stop. 0: no diagram was made. 1: a cap. 2: converged. 3: the error was met. 4: time. 5: iterations.
    pub stop_reason: u32,
    /// Source of the energy. 0: solve. 1: reduced basis. 2: falloff. 3: a bound: the object stays whole whatever the displacements are.
    pub elastic: u32,
    /// Preset, a `ShatterQuality`.
    pub quality: u32,
    /// Iterations of the diagrams: the most of all bodies.
    pub iterations: u32,
    /// Cause of `overrun_ns`. 1: the request waited in the queue. 2: without a reduced basis, the displacements were solved for. 3: they
    /// were solved for because the estimated error of reduced ones was too large. 4: energy and degree took most of the
    /// time. 5: the cells did. 6: the stages after them did.
    pub overrun: u32,
    /// Outer surface of the fragments. 0: that of the lattice. 1: the input surface itself.
    pub surface: u32,
    /// γ used, J·m².
    pub gamma_j_m2: f64,
    /// E_1/γ; an upper bound of it if `elastic` is 3.
    pub e1_over_gamma: f64,
    /// Factor on the impulses at which the object just breaks, sqrt(γ/E_1); a lower bound of it if `elastic` is 3. With the effect
    /// `gravity`: of a request for the threshold, the factor on the impulses alone; otherwise the factor on all loads, weight among them.
    /// Without meaning for an even division.
    pub threshold_impulse_factor: f64,
    /// Strain energy of the struck bodies at peak load, J: of all contacts, and of the weight with the effect `gravity`; with the effect
    /// `dynamics`, its largest over time. 0 if `elastic` is 2 or 3.
    pub strain_j: f64,
    /// Largest averaged equivalent stress over the tensile strength. This and the next three are 0 with the paper's criterion.
    pub stress_over_strength: f64,
    /// Energy of the new surface, J: toughness times the area of all cracks.
    pub surface_j: f64,
    /// Kinetic energy of the release velocities, J; 0 without the effect `release`.
    pub released_j: f64,
    /// Energy that a given number of sites lacks, J.
    pub deficit_j: f64,
    /// Kinetic energy that the contacts can take from the motion of object and partners, J; 0 without partners.
    pub impactor_j: f64,
    /// Energy of these that the object does not store, J; 0 without partners, and if `elastic` is 3.
    pub remainder_j: f64,
    /// Factor on all loads, 0 to 1, so that the object stores no more than `impactor_j`; 1 if nothing was lowered.
    pub load_factor: f64,
    /// Nearness of the examples that decided the degree, 0 to 1.
    pub confidence: f64,
    /// Largest contact radius in effect, m.
    pub radius_m: f64,
    /// Estimated relative error of the elastic energy.
    pub energy_error: f64,
    /// Estimated relative energy of the diagrams above the end of their descents.
    pub cvd_gap: f64,
    /// Seed used.
    pub seed: u64,
    /// Handle of this result for later requests (`ShatterImpact.from_handle`); 0: the service does not keep it.
    pub handle: u64,
    /// Time from admission until right before the result was sent, ns.
    pub time_ns: u64,
    /// Time by which `time_ns` exceeds `ShatterImpact.time_ms_max`, ns; 0: it was kept, or there was no limit.
    pub overrun_ns: u64,
    /// Time from sending the request to finding the result, ns.
    pub round_trip_ns: u64,
    /// Size of the result, bytes.
    pub bytes: u64,
    /// Hit of the request's ray.
    pub hit: Hit,
}

impl From<&FractureResult> for Summary {
    fn from(result: &FractureResult) -> Self {
        let facts = result.summary();
        Self {
            fragment_count: result.fragments().len() as u32,
            sites: facts.sites,
            fracture_degree: facts.fracture_degree,
            degree_source: facts.degree_origin.code(),
            capped: facts.is_capped,
            stop_reason: facts.stop_criterion.code(),
            elastic: facts.energy_source.code(),
            quality: facts.quality.map_or(0, shatter_client::Quality::number),
            iterations: facts.iterations,
            overrun: facts.missed_time.map_or(0, |missed| missed.cause.code()),
            surface: facts.surface.code(),
            gamma_j_m2: facts.gamma_j_m2,
            e1_over_gamma: facts.e1_over_gamma,
            threshold_impulse_factor: facts.threshold_impulse_factor,
            strain_j: facts.strain_j.unwrap_or(0.0),
            stress_over_strength: facts.stress_over_strength.unwrap_or(0.0),
            surface_j: facts.surface_j.unwrap_or(0.0),
            released_j: facts.released_j.unwrap_or(0.0),
            deficit_j: facts.deficit_j.unwrap_or(0.0),
            impactor_j: facts.impactor_j.unwrap_or(0.0),
            remainder_j: facts.remainder_j.unwrap_or(0.0),
            load_factor: facts.load_factor.unwrap_or(1.0),
            confidence: facts.confidence,
            radius_m: facts.radius_m,
            energy_error: facts.energy_error,
            cvd_gap: facts.cvd_gap,
            seed: facts.seed,
            handle: facts.handle.unwrap_or(0),
            time_ns: nanoseconds(facts.time),
            overrun_ns: facts.missed_time.map_or(0, |missed| nanoseconds(missed.by)),
            round_trip_ns: nanoseconds(result.round_trip()),
            bytes: result.bytes(),
            hit: result.hit().into(),
        }
    }
}

/// One fragment: a closed mesh, and the data of a rigid body. Pointers point into shared memory and are valid until `shatter_result_free`;
/// NULL where the result does not have the data. Positions are relative to `center_m`.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Fragment {
    /// Index of the fragment in the result.
    pub id: u32,
    /// Body (component of the object) that the fragment comes from.
    pub body: u32,
    /// Volume, m³.
    pub volume_m3: f64,
    /// Mass, kg.
    pub mass_kg: f64,
    /// Center of mass in the coordinates of the object, m.
    pub center_m: [f64; 3],
    /// Inertia tensor about the center, kg·m²: xx, yy, zz, xy, xz, yz.
    pub inertia_kg_m2: [f64; 6],
    /// Velocity of the center once the fragment is free, in addition to the object's, m/s; zero unless `release` is on.
    pub linear_m_s: [f64; 3],
    /// Angular velocity, in addition to the object's, rad/s; zero unless `release` is on.
    pub angular_rad_s: [f64; 3],
    /// Positions, three coordinates per vertex, m.
    pub positions: *const f32,
    /// Normals, three coordinates per vertex, of length one; NULL unless `normals` is on.
    pub normals: *const f32,
    /// Texture coordinates, two per vertex, m; NULL unless `uv` is on.
    pub uvs: *const f32,
    /// Attributes of outer faces, one per vertex; NULL unless `attributes` is on.
    pub attributes: *const VertexAttributes,
    /// Second texture coordinates of the input on outer faces, two per vertex, v upwards, zero on cracks; NULL unless `attributes` is on
    /// and the input has them.
    pub outer_uvs2: *const f32,
    /// Colors of the input on outer faces, four bytes per vertex: red, green, blue, alpha; white on cracks; NULL unless `attributes` is
    /// on and the input has any.
    pub outer_colors: *const u8,
    /// Number of vertices.
    pub vertex_count: usize,
    /// Indices of vertices, three per triangle, counter-clockwise from outside unless the convention is clockwise.
    pub indices: *const u32,
    /// Number of indices.
    pub index_count: usize,
    /// The input's materials, one per triangle, `SHATTER_NONE` on cracks; NULL unless `attributes` is on and the input has any.
    pub materials: *const u32,
    /// Pairs (from, to) of vertices that are the same point: with them every edge has exactly one opposite.
    pub merges: *const u32,
    /// Number of merge pairs.
    pub merge_count: usize,
    /// Number of runs; see `shatter_result_run`.
    pub run_count: usize,
}

impl From<&shatter_client::Fragment<'_>> for Fragment {
    fn from(fragment: &shatter_client::Fragment<'_>) -> Self {
        let velocity = fragment.velocity();
        Self {
            id: fragment.id(),
            body: fragment.body(),
            volume_m3: fragment.volume_m3(),
            mass_kg: fragment.mass_kg(),
            center_m: fragment.center_m(),
            inertia_kg_m2: fragment.inertia_kg_m2(),
            linear_m_s: velocity.map_or([0.0; 3], |velocity| velocity.linear_m_s),
            angular_rad_s: velocity.map_or([0.0; 3], |velocity| velocity.angular_rad_s),
            positions: start(fragment.positions()),
            normals: start(fragment.normals()),
            uvs: start(fragment.uvs()),
            attributes: start(fragment.outer_attributes()),
            outer_uvs2: start(fragment.outer_uvs2()),
            outer_colors: start(fragment.outer_colors()),
            vertex_count: fragment.positions().len(),
            indices: start(fragment.indices()),
            index_count: fragment.indices().len(),
            materials: start(fragment.materials()),
            merges: start(fragment.merges()),
            merge_count: fragment.merges().len(),
            run_count: fragment.runs().len(),
        }
    }
}

/// Triangles of one fragment that face one neighbor, the outside, or a fragment of an earlier result. The outer run comes first, if there
/// is one. Each run has vertices of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct Run {
    /// The fragment on the other side of the crack; `SHATTER_NONE`: the outside, or a fragment of an earlier result.
    pub neighbor: u32,
    /// True if the run is a side of a crack, also of an earlier result; else it is the outside.
    pub crack: bool,
    /// First index of the run, counted from the fragment's first.
    pub index_first: u32,
    /// Number of indices.
    pub index_count: u32,
    /// First vertex of the run, counted from the fragment's first.
    pub vertex_first: u32,
    /// Number of vertices.
    pub vertex_count: u32,
}

impl From<shatter_client::Run<'_>> for Run {
    fn from(run: shatter_client::Run<'_>) -> Self {
        Self {
            neighbor: run.neighbor.unwrap_or(NONE),
            crack: run.is_crack,
            index_first: run.index_first,
            index_count: run.indices.len() as u32,
            vertex_first: run.vertex_first,
            vertex_count: run.positions.len() as u32,
        }
    }
}

/// The convex proxy of a fragment, for collisions: at most 64 triangles. Pointers as in `ShatterFragment`.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Hull {
    /// Positions, three coordinates per corner, m, relative to the fragment's center.
    pub positions: *const f32,
    /// Number of corners; 0: `hulls` is off, or the fragment is too flat for one.
    pub vertex_count: usize,
    /// Indices of corners, three per triangle, counter-clockwise from outside unless the convention is clockwise.
    pub indices: *const u32,
    /// Number of indices.
    pub index_count: usize,
    /// Volume of the part of the fragment inside the hull, divided by the fragment's volume.
    pub coverage: f64,
    /// Largest depth of the surface of any other fragment below the hull's surface, m.
    pub margin_m: f64,
}

impl From<Option<shatter_client::HullMesh<'_>>> for Hull {
    fn from(hull: Option<shatter_client::HullMesh<'_>>) -> Self {
        let of = |hull: &shatter_client::HullMesh<'_>| (hull.coverage, hull.margin_m);
        let (coverage, margin_m) = hull.as_ref().map_or((0.0, 0.0), of);
        let (positions, indices) = hull.map_or((&[][..], &[][..]), |hull| (hull.positions, hull.indices));
        let (vertex_count, index_count) = (positions.len(), indices.len());
        Self { positions: start(positions), vertex_count, indices: start(indices), index_count, coverage, margin_m }
    }
}

/// The input's own triangles that belong to a fragment, for rendering. With the crack faces of the fragment's runs they are its visible
/// surface. Pointers as in `ShatterFragment`.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Skin {
    /// Vertices.
    pub vertices: *const SkinVertex,
    /// Number of vertices; 0: `skin` is off, or the fragment has no part of the input's surface.
    pub vertex_count: usize,
    /// Indices of vertices, three per triangle, counter-clockwise from outside unless the convention is clockwise.
    pub indices: *const u32,
    /// Number of indices.
    pub index_count: usize,
    /// One per triangle: the index of a material in the mesh file, or `SHATTER_NONE`; NULL if the file has none.
    pub materials: *const u32,
    /// Second texture coordinates, two per vertex, v upwards; NULL if the file has none.
    pub uvs2: *const f32,
    /// Colors, four bytes per vertex: red, green, blue, alpha; NULL if the file has none.
    pub colors: *const u8,
}

impl From<Option<shatter_client::FragmentSkin<'_>>> for Skin {
    fn from(skin: Option<shatter_client::FragmentSkin<'_>>) -> Self {
        let Some(skin) = skin else {
            let (vertices, indices, materials) = (ptr::null(), ptr::null(), ptr::null());
            let (uvs2, colors) = (ptr::null(), ptr::null());
            return Self { vertices, vertex_count: 0, indices, index_count: 0, materials, uvs2, colors };
        };
        Self {
            vertices: start(skin.vertices),
            vertex_count: skin.vertices.len(),
            indices: start(skin.indices),
            index_count: skin.indices.len(),
            materials: start(skin.materials),
            uvs2: start(skin.uvs2),
            colors: start(skin.colors),
        }
    }
}

/// Attributes of a vertex on an outer face; zero on crack faces.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct VertexAttributes {
    /// Normal, of length one.
    pub normal: [f32; 3],
    /// Texture coordinates of the input, v upwards (OBJ's; 1 - v of glTF's); zero where it has none.
    pub uv: [f32; 2],
}

/// A vertex of a skin.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct SkinVertex {
    /// Position relative to the fragment's center, m.
    pub position_m: [f32; 3],
    /// Normal, of length one.
    pub normal: [f32; 3],
    /// Texture coordinates of the input, v upwards (OBJ's; 1 - v of glTF's); zero where it has none.
    pub uv: [f32; 2],
}

/// Two fragments that touch; or one that an anchor of the scene holds, and the world.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Bond {
    /// The fragments, the lower id first; the second is `SHATTER_NONE` in a bond with the world.
    pub fragments: [u32; 2],
    /// Area of the crack between them, m². In a bond with the world: area of the outer triangles that the anchors hold.
    pub area_m2: f64,
    /// Mean normal of that area, of length one, from the first to the second; zero if the area has none.
    pub normal: [f64; 3],
    /// Centroid of that area in the coordinates of the object, m.
    pub centroid_m: [f64; 3],
}

/// A point of a crack from which dust and chips come.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Debris {
    /// Fragment whose crack face has the point: of two neighbors the one with the lower id.
    pub fragment: u32,
    /// The other fragment.
    pub neighbor: u32,
    /// Position relative to the fragment's center, m.
    pub position_m: [f32; 3],
    /// Normal of the crack at the point, out of the fragment.
    pub normal: [f32; 3],
    /// Diameter, m.
    pub size_m: f32,
    /// Always zero.
    pub reserved: u32,
}

/// Cost of one stage or effect.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Counter {
    /// Number of the stage or effect. Stages. 0: load. 1: elasticity. 2: threshold. 3: degree. 4: centroidal. 5: labels. 6: tessellation.
    /// 7: fragments. Effects: the index of their bit in `ShatterEffect`.
    pub number: u32,
    /// True if it ran.
    pub ran: bool,
    /// Time it took, ns.
    pub ns: u64,
    /// Bytes of results it produced, or of tables it used.
    pub bytes: u64,
}

/// Content hash: 16 hexadecimal digits, and a zero. Equal for identical results, whatever the times and the number of threads.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Hash {
    /// The digits.
    pub text: [c_char; 24],
}

impl From<&FractureResult> for Hash {
    fn from(result: &FractureResult) -> Self {
        Self { text: text(&result.digest().output_hash) }
    }
}

/// Checks that rows of shared memory, which C reads under another name, have the same fields at the same offsets.
macro_rules! same {
    ($($own:ident is $wire:ident: $($field:ident)*;)*) => {
        $(const _: () = assert!(size_of::<$own>() == size_of::<wire::$wire>());
        const _: () = assert!(align_of::<$own>() == align_of::<wire::$wire>());
        $(const _: () = assert!(offset_of!($own, $field) == offset_of!(wire::$wire, $field));)*)*
    };
}

same! {
    VertexAttributes is OuterAttributes: normal uv;
    SkinVertex is SkinVertex: position_m normal uv;
    Bond is BondWire: fragments area_m2 normal centroid_m;
    Debris is DebrisWire: fragment neighbor position_m normal size_m reserved;
    Counter is StageWire: ran ns bytes;
    Counter is EffectWire: ran ns bytes;
}

/// The daemon writes `ran` as a word of 0 or 1, whose first byte is the `bool` only on little-endian machines.
const _: () = assert!(cfg!(target_endian = "little"));

const _: () = assert!(NONE == wire::OUTER && NONE == wire::WORLD && NONE == wire::NO_MATERIAL);

/// A time in nanoseconds.
pub(crate) fn nanoseconds(time: Duration) -> u64 {
    u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)
}

/// Address of the first row, as C reads it; NULL if it is empty.
pub(crate) fn start<T, U>(part: &[T]) -> *const U {
    if part.is_empty() { ptr::null() } else { part.as_ptr().cast() }
}
