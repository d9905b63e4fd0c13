//! Baking: a mesh and a few numbers become a prepared object.

use crate::degree;
use crate::elasticity::ElasticityError;
use crate::lattice::{self, Lattice, LatticeError, Levels};
use crate::lift::{self, Carry, Lift, LiftError, LiftKind};
use crate::pipeline::{BakeReport, Body, Parameters, Prepared, StrikeError, Unprepared, calibrate};
use crate::scene::{DEFAULT_FRAGMENT_DIAGONALS, Material};
use crate::surface::{Defect, DefectKind, Inside, RawMesh, Surface, SurfaceError};
use crate::token::{Cancelled, Token};

/// What to bake, apart from the mesh.
#[derive(Clone, Debug)]
pub struct BakeRequest {
    /// The object's name: 1 to 63 bytes, no path separators, no control characters.
    pub name: String,
    /// The material's name, for the record.
    pub material_name: String,
    /// What it is made of.
    pub material: Material,
    /// Reference fragment size d, m; `None`: a tenth of the diagonal.
    pub fragment_size_m: Option<f64>,
    /// Threshold γ, J·m²; `None`: from material and fragment size.
    pub gamma_j_m2: Option<f64>,
    /// Spacing of the elastic lattice over the diagonal; `None`: about 3 000 nodes.
    pub elastic_spacing: Option<f64>,
    /// Spacing of the crack lattice over the diagonal; `None`: about 12 000 nodes.
    pub crack_spacing: Option<f64>,
    /// Everything random while baking follows from it.
    pub seed: u64,
}

/// What baking does, in order; the caller may show it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Welding, orienting, naming defects.
    Surface,
    /// Winding numbers and the volume that they enclose.
    Volume,
    /// Both lattices and the operator between them.
    Lattices,
    /// Eigenpairs of body `0`.
    Lift(usize),
    /// Stiffness and factor of body `0`.
    Elasticity(usize),
    /// κ, from sampled impacts.
    Calibration,
}

/// Why an object was not baked.
#[derive(Debug, thiserror::Error)]
pub enum BakeError {
    /// The name cannot be a file's name or is too long for a request.
    #[error(
        "object name {0:?}: 1 to {NAME_BYTES_MAX} bytes without path separators, control characters or a leading dot"
    )]
    Name(String),
    /// A number is not finite and positive.
    #[error("{key} must be finite and positive, got {value}")]
    NotPositive {
        /// Which number.
        key: &'static str,
        /// What it was.
        value: f64,
    },
    /// The mesh has no surface or no inside.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// No lattice could be made.
    #[error(transparent)]
    Lattice(#[from] LatticeError),
    /// No lift could be computed.
    #[error("lift of body {body}: {source}")]
    Lift {
        /// Which body.
        body: usize,
        /// Why.
        source: LiftError,
    },
    /// The stiffness could not be factored.
    #[error("elasticity of body {body}: {source}")]
    Elasticity {
        /// Which body.
        body: usize,
        /// Why.
        source: ElasticityError,
    },
    /// A sampled impact failed.
    #[error("calibration: {0}")]
    Calibration(#[from] StrikeError),
    /// Cancelled at a checkpoint.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Longest object name in bytes: it travels in a fixed field of the request.
pub const NAME_BYTES_MAX: usize = 63;

/// Bakes `raw`. Deterministic in (mesh, request); `progress` is told of each step as it begins.
pub fn bake(
    raw: RawMesh,
    request: &BakeRequest,
    token: &Token,
    progress: &mut dyn FnMut(Step),
) -> Result<Prepared, BakeError> {
    check(request)?;
    progress(Step::Surface);
    let surface = Surface::repair(raw)?;
    token.check()?;
    progress(Step::Volume);
    let inside = Inside::new(&surface);
    let volume = inside.input_volume(token)?;
    progress(Step::Lattices);
    let parameters = parameters(request, &surface, volume)?;
    let levels = lattice::levels(&inside, parameters.elastic_spacing, parameters.crack_spacing, volume, token)?;
    let mut report = report(&surface, &inside, volume, &levels);
    let mut bodies = Vec::with_capacity(levels.bodies.len());
    for (index, lattices) in levels.bodies.into_iter().enumerate() {
        progress(Step::Lift(index));
        let failed = |source| BakeError::Lift { body: index, source };
        let interior = lift::interior(&lattices.crack, parameters.modes, parameters.alpha, token).map_err(failed)?;
        let surface_diffusion = surface_lift(&lattices.crack, index, &mut report, token)?;
        progress(Step::Elasticity(index));
        let body = Body::new(lattices, interior, parameters.material.poisson, token)
            .map_err(|source| BakeError::Elasticity { body: index, source })?;
        bodies.push(Body { surface_diffusion, ..body });
    }
    let gamma_j_m2 = request.gamma_j_m2.unwrap_or_else(|| {
        degree::reference_gamma(
            parameters.material.young_pa,
            parameters.material.strength_pa,
            parameters.fragment_size_m,
        )
    });
    let name = request.name.clone();
    let mut prepared = Prepared { name, frame: surface.frame, parameters, gamma_j_m2, kappa: 1.0, report, bodies };
    progress(Step::Calibration);
    prepared.kappa = calibrate(&prepared, token)?;
    Ok(prepared)
}

/// The surface lift of body `body`, or a line in the report: no strike needs it unless it asks for it by name.
fn surface_lift(
    crack: &Lattice,
    body: usize,
    report: &mut BakeReport,
    token: &Token,
) -> Result<Option<Lift>, Cancelled> {
    match lift::surface_diffusion(crack, Carry::Harmonic, lift::SURFACE_MODES_DEFAULT, token) {
        Ok(lift) => Ok(Some(lift)),
        Err(LiftError::Cancelled(cancelled)) => Err(cancelled),
        Err(error) => {
            let lift = LiftKind::SurfaceDiffusion;
            report.unprepared.push(Unprepared { body, lift, reason: error.to_string() });
            Ok(None)
        }
    }
}

/// Whether `name` can name an object: it names a file and travels in a fixed field.
pub fn is_object_name(name: &str) -> bool {
    (1..=NAME_BYTES_MAX).contains(&name.len())
        && !name.starts_with('.')
        && !name.chars().any(|c| c.is_control() || c == '/' || c == '\\')
}

fn check(request: &BakeRequest) -> Result<(), BakeError> {
    if !is_object_name(&request.name) {
        return Err(BakeError::Name(request.name.clone()));
    }
    let numbers = [
        ("fragment-size", request.fragment_size_m),
        ("gamma", request.gamma_j_m2),
        ("elastic-spacing", request.elastic_spacing),
        ("crack-spacing", request.crack_spacing),
    ];
    for (key, value) in numbers {
        if let Some(value) = value.filter(|value| !(value.is_finite() && *value > 0.0)) {
            return Err(BakeError::NotPositive { key, value });
        }
    }
    Ok(())
}

fn parameters(request: &BakeRequest, surface: &Surface, volume: f64) -> Result<Parameters, LatticeError> {
    let [elastic_spacing, crack_spacing] =
        lattice::spacings(volume, area(surface), request.elastic_spacing, request.crack_spacing)?;
    Ok(Parameters {
        material_name: request.material_name.clone(),
        material: request.material.clone(),
        fragment_size_m: request.fragment_size_m.unwrap_or(DEFAULT_FRAGMENT_DIAGONALS * surface.frame.diagonal_m),
        elastic_spacing,
        crack_spacing,
        modes: lift::MODES_DEFAULT,
        alpha: lift::ALPHA_DEFAULT,
        seed: request.seed,
    })
}

/// Area of the surface, local.
fn area(surface: &Surface) -> f64 {
    let triangle = |triangle| {
        let [a, b, c] = surface.corners(triangle);
        0.5 * (b - a).cross(&(c - a)).norm()
    };
    (0..surface.triangles.len()).map(triangle).sum()
}

fn report(surface: &Surface, inside: &Inside, volume: f64, levels: &Levels) -> BakeReport {
    let cubed = surface.frame.diagonal_m.powi(3);
    let lattice_volume: f64 = levels.bodies.iter().map(|body| body.crack.volume()).sum();
    let deviation = levels
        .bodies
        .iter()
        .map(|body| body.crack.deviation(&|point| inside.signed_distance(point).abs()))
        .fold(0.0, f64::max);
    let mut defects = surface.defects.clone();
    defects.extend(inside.ambiguous(&boundary_samples(levels)));
    defects.extend(dropped(inside, volume, levels));
    BakeReport {
        input_hash: input_hash(surface),
        input_volume_m3: volume * cubed,
        lattice_volume_m3: lattice_volume * cubed,
        surface_deviation: deviation,
        defects,
        unprepared: Vec::new(),
    }
}

fn boundary_samples(levels: &Levels) -> Vec<nalgebra::Point3<f64>> {
    levels.bodies.iter().flat_map(|body| body.crack.nodes.iter().copied()).collect()
}

/// Components that the crack lattice could not keep, with their share of the volume.
fn dropped(inside: &Inside, volume: f64, levels: &Levels) -> Option<Defect> {
    let dropped = &levels.crack.dropped;
    let first = inside.nearest_face(&dropped.first()?.place);
    let share = 100.0 * dropped.iter().map(|component| component.volume).sum::<f64>() / volume;
    let action = format!("left out: smaller than the lattice spacing, {share:.4} % of the volume");
    Some(Defect::new(DefectKind::DroppedComponent, dropped.len() as u64, first, action))
}

/// BLAKE3 of a normalised surface (positions and triangles), hexadecimal: what [`BakeReport::input_hash`] holds.
pub fn input_hash(surface: &Surface) -> String {
    let mut hasher = blake3::Hasher::new();
    for position in &surface.positions {
        position.iter().for_each(|x| _ = hasher.update(&x.to_le_bytes()));
    }
    for corner in surface.triangles.as_flattened() {
        hasher.update(&corner.to_le_bytes());
    }
    hasher.finalize().to_hex().to_string()
}
