//! Common steps of the cases: bake a mesh, strike it, and check that the result is sound.

use nalgebra::{Point3, Vector3};
use shatter_engine::wire;
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{BakeError, BakeRequest, bake};
use shatter_fracture::elasticity::ElasticityError;
use shatter_fracture::fragment::closed;
use shatter_fracture::lattice::LatticeError;
use shatter_fracture::lift::LiftError;
use shatter_fracture::pipeline::{
    DegreeRequest, DegreeSource, FractureError, FractureRequest, FragmentRow, PreparedObject, RunRow, SurfaceKind,
};
use shatter_fracture::scene::{Material, MaterialError};
use shatter_fracture::surface::{RawMesh, SurfaceError};
use shatter_server::commands::CommandError;

/// Error of a case that has no figure: an error as the programs name it, or an internal fault.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TrialFault {
    /// Kind, as in `error.kind` of the programs' documents.
    pub kind: String,
    /// Message.
    pub message: String,
}

impl TrialFault {
    /// Internal fault.
    pub fn ours(kind: &str, message: impl Into<String>) -> Self {
        Self { kind: kind.to_owned(), message: message.into() }
    }
}

impl From<CommandError> for TrialFault {
    fn from(failure: CommandError) -> Self {
        Self { kind: failure.kind().to_owned(), message: failure.message().to_owned() }
    }
}

/// Converts errors by way of the command line's kinds.
macro_rules! as_the_programs_say {
    ($($error:ty),*) => {$(
        impl From<$error> for TrialFault {
            fn from(error: $error) -> Self {
                CommandError::from(error).into()
            }
        }
    )*};
}

as_the_programs_say!(BakeError, SurfaceError, LatticeError, MaterialError);

impl From<FractureError> for TrialFault {
    fn from(error: FractureError) -> Self {
        let error = wire::engine_error(error);
        Self { kind: error.kind.name().to_owned(), message: error.message }
    }
}

impl From<ElasticityError> for TrialFault {
    fn from(error: ElasticityError) -> Self {
        Self::ours("elasticity", error.to_string())
    }
}

impl From<LiftError> for TrialFault {
    fn from(error: LiftError) -> Self {
        Self::ours("lift", error.to_string())
    }
}

/// Built-in material of that name.
pub fn material(name: &str) -> Result<Material, TrialFault> {
    Ok(Material::named(name)?)
}

/// Stone on lattices of a few hundred nodes; there are many cases, and none needs a finer lattice.
pub fn coarse() -> Result<BakeRequest, TrialFault> {
    Ok(BakeRequest { elastic_spacing: Some(0.1), crack_spacing: Some(0.0625), ..fine()? })
}

/// Stone at default spacings.
pub fn fine() -> Result<BakeRequest, TrialFault> {
    Ok(BakeRequest { surface: SurfaceKind::Lattice, ..BakeRequest::new("case", "stone", material("stone")?) })
}

/// Bakes a mesh.
pub fn baked(mesh: RawMesh, request: &BakeRequest) -> Result<PreparedObject, TrialFault> {
    Ok(bake(mesh, request, &CancelToken::default(), &mut |_| ())?)
}

/// Request with 12 sites and an impulse of 1 N·s along −`outward`.
///
/// The contact is where the ray from the box's center along `outward` leaves the first body for the last time; this is well defined on
/// every body.
pub fn at(prepared: &PreparedObject, outward: [f64; 3]) -> FractureRequest {
    let outward = Vector3::from(outward).normalize();
    let nodes = prepared.bodies.iter().flat_map(|body| body.crack.nodes.iter());
    let farthest = nodes.max_by(|a, b| a.coords.dot(&outward).total_cmp(&b.coords.dot(&outward)));
    let point_m = prepared.frame.to_meters(farthest.unwrap_or(&Point3::origin()));
    sites(FractureRequest::at(point_m, -outward).seeded(1), 12)
}

/// The same request with a number of sites.
pub fn sites(strike: FractureRequest, sites: u32) -> FractureRequest {
    FractureRequest { degree: DegreeRequest::Sites(sites), ..strike }
}

/// Result as a client receives it.
#[derive(Clone, Debug, PartialEq)]
pub struct TrialResult {
    /// Fragments; empty if the object stays whole.
    pub rows: Vec<FragmentRow>,
    /// Runs of the fragments.
    pub runs: Vec<RunRow>,
    /// Vertices relative to each fragment's center, m.
    pub positions: Vec<[f32; 3]>,
    /// Triangle corners, relative to each fragment's first vertex.
    pub indices: Vec<u32>,
    /// E_1/γ.
    pub e1_over_gamma: f64,
    /// Factor on the impulses that just breaks the object.
    pub impulse_factor: f64,
    /// Fracture degree.
    pub degree: u32,
    /// Whether the degree was capped.
    pub capped: bool,
    /// Source of the degree.
    pub source: DegreeSource,
}

/// Strikes the object.
pub fn struck(prepared: &PreparedObject, strike: &FractureRequest) -> Result<TrialResult, TrialFault> {
    let outcome = prepared.strike(strike)?;
    let mut result = TrialResult {
        rows: Vec::new(),
        runs: Vec::new(),
        positions: Vec::new(),
        indices: Vec::new(),
        e1_over_gamma: outcome.threshold().e1_over_gamma,
        impulse_factor: outcome.threshold().impulse_factor,
        degree: outcome.fracture_degree(),
        capped: outcome.capped(),
        source: outcome.degree_source(),
    };
    if let Some(pieces) = outcome.into_meshes() {
        let emitted = pieces.emitted()?;
        (result.positions, result.indices) = (emitted.positions, emitted.indices);
        (result.rows, result.runs) = (pieces.fragments, pieces.runs);
    }
    Ok(result)
}

/// Relative difference between the sum of fragment volumes and the lattice's volume; an error if a fragment is open, not finite or
/// without mass.
pub fn sound(prepared: &PreparedObject, result: &TrialResult) -> Result<f64, TrialFault> {
    for row in &result.rows {
        let vertices = &result.positions[row.vertex_first as usize..][..row.vertex_count as usize];
        let indices = &result.indices[row.index_first as usize..][..row.index_count as usize];
        closed(vertices, indices).map_err(|open| TrialFault::ours("open", format!("fragment {}: {open}", row.id)))?;
        let numbers = row.center_m.iter().chain(&row.inertia_kg_m2).chain([&row.energy_j_m2]);
        if !(numbers.into_iter().all(|number| number.is_finite()) && row.mass_kg > 0.0 && row.mass_kg.is_finite()) {
            return Err(TrialFault::ours("not_finite", format!("fragment {}: {row:?}", row.id)));
        }
    }
    if result.rows.is_empty() {
        return Err(TrialFault::ours("whole", "the object stayed whole"));
    }
    let sum: f64 = result.rows.iter().map(|row| row.volume_m3).sum();
    Ok((sum / prepared.report.lattice_volume_m3 - 1.0).abs())
}

/// Bakes coarsely, strikes from +x, and returns the figure of [`sound`].
pub fn survives(mesh: RawMesh) -> Result<f64, TrialFault> {
    let prepared = baked(mesh, &coarse()?)?;
    let result = struck(&prepared, &at(&prepared, [1.0, 0.2, 0.1]))?;
    sound(&prepared, &result)
}

/// Largest relative difference between the fragment volumes of two results after division by `scale`; infinite if their numbers
/// differ.
pub fn difference(a: &TrialResult, b: &TrialResult, scale: f64) -> f64 {
    if a.rows.len() != b.rows.len() || a.rows.is_empty() {
        return f64::INFINITY;
    }
    let pairs = a.rows.iter().zip(&b.rows);
    pairs.map(|(a, b)| (b.volume_m3 / a.volume_m3 / scale - 1.0).abs()).fold(0.0, f64::max)
}
