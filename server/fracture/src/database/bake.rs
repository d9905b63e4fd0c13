//! Baking: a mesh and a few numbers become a prepared object.

use super::Tables;
use super::bake_step::{BakeSize, BakeStep};
use super::learned::EXAMPLES_MAX;
use super::lost_parts::SeveredParts;
use super::share::{PartialBake, Share};
use super::stored_values::{self, RATIOS, RatioRange};
use super::stuffed::lattices;
use crate::cancel_token::{CancelToken, Cancelled};
use crate::degree;
use crate::elasticity::ElasticityError;
use crate::lattice::{BodyLattice, Lattice, LatticeError};
use crate::lift::{self, Extension, LiftError, LiftKind, LiftedLattice};
use crate::pipeline::{
    self, BakeParameters, BakeReport, ElasticModel, ElasticRequest, FractureError, MissingLift, PreparedBody,
    PreparedObject, Preset, calibrate,
};
use crate::scene::{DEFAULT_FRAGMENT_DIAGONALS, Material, is_invisible};
use crate::skin::{BoundaryAttributes, Skin};
use crate::sparse::Precision;
use crate::surface::{RawMesh, Surface, SurfaceError};
use crate::tessellation::Topology;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// What to bake, apart from the mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BakeRequest {
    /// The object's name: 1 to [`NAME_BYTES_MAX`] bytes, no path separators, no control or invisible characters.
    pub name: String,
    /// The material's name, for the record.
    pub material_name: String,
    /// What it is made of.
    pub material: Material,
    /// Reference fragment size d, m; `None`: a tenth of the diagonal.
    pub fragment_size_m: Option<f64>,
    /// Threshold γ, J·m²; `None`: from material and fragment size.
    pub gamma_j_m2: Option<f64>,
    /// Which preset the lattices are of, as far as nothing below says otherwise.
    pub quality: Preset,
    /// Spacing of the elastic lattice over the diagonal; `None`: the preset's number of nodes.
    pub elastic_spacing: Option<f64>,
    /// Spacing of the crack lattice over the diagonal; `None`: the preset's number of nodes.
    pub crack_spacing: Option<f64>,
    /// κ; `None`: fitted on sampled impacts, which takes most of the time on small lattices.
    pub kappa: Option<f64>,
    /// Impacts to learn the degree from; with any, κ is fitted on them.
    pub examples: u64,
    /// Whether they give the object a reduced basis, too.
    pub elastic: ElasticRequest,
    /// Of the factor of the stiffness, of bodies for which it is exact enough.
    pub factor: Precision,
    /// What the object shall be prepared for; examples need elasticity and interior distances.
    pub tables: Tables,
    /// Everything random while baking follows from it.
    pub seed: u64,
    /// Whether parts that the preset's lattice severs become bodies of their own; else the object is refused. No part of what is
    /// stored.
    #[serde(skip, default)]
    pub allows_severed: bool,
    /// Triangles along which the object is cracked already, in the coordinates of the mesh; which way they face does not matter.
    #[serde(skip)]
    pub cracks: Option<RawMesh>,
}

impl BakeRequest {
    /// An object of that name and material, everything else at its default.
    pub fn new(name: impl Into<String>, material_name: impl Into<String>, material: Material) -> Self {
        Self {
            name: name.into(),
            material_name: material_name.into(),
            material,
            fragment_size_m: None,
            gamma_j_m2: None,
            quality: Preset::default(),
            elastic_spacing: None,
            crack_spacing: None,
            kappa: None,
            examples: 0,
            elastic: ElasticRequest::Reduced,
            factor: Precision::F64,
            tables: Tables::ALL,
            seed: 0,
            allows_severed: true,
            cracks: None,
        }
    }

    /// Everything else that determines the object.
    pub fn without_cracks(&self) -> Self {
        // The sheets themselves may be large.
        Self {
            name: self.name.clone(),
            material_name: self.material_name.clone(),
            material: self.material.clone(),
            allows_severed: false,
            cracks: None,
            ..*self
        }
    }

    /// The tables that are made.
    pub(super) fn tables(&self) -> Tables {
        let learns = self.examples > 0;
        Tables { elastic: self.tables.elastic || learns, interior: self.tables.interior || learns, ..self.tables }
    }
}

/// Share of the volume that may be in components which the lattice drops: beyond it, what is left is another object.
pub(super) const GONE_MAX: f64 = 0.25;

/// Why an object was not baked.
#[derive(Debug, thiserror::Error)]
pub enum BakeError {
    /// The name cannot be a file's name or is too long for a request.
    #[error(
        "object name {0:?}: 1 to {NAME_BYTES_MAX} bytes without path separators, control or invisible characters or a leading dot"
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
    /// A number that no object of this size and material has.
    #[error("{key} is {value:e} times {over}: must be {:e} to {:e} times", RATIOS.start(), RATIOS.end())]
    Unusual {
        /// Which number.
        key: &'static str,
        /// Over what.
        over: &'static str,
        /// How many times that it is.
        value: f64,
    },
    /// The mesh has no surface or no inside.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// The existing cracks are no sheets.
    #[error("existing cracks: {0}")]
    Cracks(SurfaceError),
    /// The existing cracks leave too little of the object.
    #[error(
        "existing cracks take {percent:.0} % of the object at crack spacing {spacing:.5}: bake with a finer one, or fewer of them"
    )]
    CracksTakeAll {
        /// Their share of the volume, per cent.
        percent: f64,
        /// Crack spacing over the diagonal.
        spacing: f64,
    },
    /// Walls are too thin for any lattice that is accepted, or for the one that was asked for.
    #[error(
        "a quarter of the surface or more has walls of {thickness_m:.3e} m or less: crack spacing {spacing:.5} loses them, \
         {spacing_needed:.5} is needed{possible}",
        possible = if *possible { "" } else { ", finer than what can be baked" }
    )]
    TooThin {
        /// Thickness that a quarter of the surface does not exceed, m.
        thickness_m: f64,
        /// Crack spacing in question, over the diagonal.
        spacing: f64,
        /// Crack spacing that keeps such walls, over the diagonal.
        spacing_needed: f64,
        /// Whether that spacing is accepted.
        possible: bool,
    },
    /// A preset that was not asked for by name severs parts.
    #[error("{0}")]
    Severed(Box<SeveredParts>),
    /// More examples than a database holds.
    #[error("{asked} examples: at most {EXAMPLES_MAX}")]
    TooManyExamples {
        /// How many were asked for.
        asked: u64,
    },
    /// Most of the object is in components that no lattice of that spacing keeps.
    #[error(
        "{count} components with {percent:.0} % of the volume are smaller than crack spacing {spacing:.5} resolves: bake with a \
         finer one, or fewer components at a time"
    )]
    TooSmall {
        /// How many.
        count: u64,
        /// Their share of the volume, per cent.
        percent: f64,
        /// Crack spacing over the diagonal.
        spacing: f64,
    },
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
    #[error(transparent)]
    Calibration(FractureError),
    /// Cancelled at a checkpoint.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl BakeError {
    /// Whether the work was cancelled, wherever it was.
    pub fn is_cancelled(&self) -> bool {
        matches!(
            self,
            Self::Cancelled(_)
                | Self::Surface(SurfaceError::Cancelled(_))
                | Self::Cracks(SurfaceError::Cancelled(_))
                | Self::Lattice(LatticeError::Cancelled(_))
                | Self::Lift { source: LiftError::Cancelled(_), .. }
                | Self::Elasticity { source: ElasticityError::Cancelled(_), .. }
                | Self::Calibration(FractureError::Cancelled(_))
        )
    }
}

impl From<FractureError> for BakeError {
    fn from(error: FractureError) -> Self {
        match error {
            FractureError::Cancelled(cancelled) => Self::Cancelled(cancelled),
            error => Self::Calibration(error),
        }
    }
}

/// Longest object name in bytes: it travels in a fixed field of the request.
pub const NAME_BYTES_MAX: usize = 64;

/// Bakes `raw`. Deterministic in (mesh, request); `progress` is told of each step as it begins.
pub fn bake(
    raw: RawMesh,
    request: &BakeRequest,
    token: &CancelToken,
    progress: &mut dyn FnMut(BakeStep),
) -> Result<PreparedObject, BakeError> {
    PartialBake::begin(raw, request, Share::WHOLE, token, progress)?.complete(token, progress)
}

/// Everything but the examples and what is learned from them.
pub(super) fn whole(
    raw: RawMesh,
    request: &BakeRequest,
    token: &CancelToken,
    progress: &mut dyn FnMut(BakeStep),
) -> Result<PreparedObject, BakeError> {
    check(request)?;
    progress(BakeStep::Surface);
    let surface = Surface::repair(raw)?;
    token.check()?;
    let (parameters, levels, mut report) = lattices(request, &surface, token, progress)?;
    let tables = request.tables();
    let assembled = assembled(levels.bodies, &parameters, tables, token)?;
    progress(BakeStep::Sized(BakeSize::of(&assembled, &surface, &parameters, request)));
    let mut bodies = Vec::with_capacity(assembled.len());
    for (index, (crack, solid)) in assembled.into_iter().enumerate() {
        progress(BakeStep::Lift(index));
        let failed = |source| BakeError::Lift { body: index, source };
        let interior = || lift::interior(&crack, parameters.modes, parameters.alpha, token).map_err(failed);
        let interior = tables.interior.then(interior).transpose()?;
        let surface = || surface_lift(&crack, index, &mut report, token);
        let surface_diffusion = tables.surface_diffusion.then(surface).transpose()?.flatten();
        progress(BakeStep::Elasticity(index));
        if let Some(solid) = &solid {
            solid.elasticity.factor().map_err(|source| BakeError::Elasticity { body: index, source })?;
        }
        bodies.push(PreparedBody { solid, interior, surface_diffusion, ..PreparedBody::new(crack) });
    }
    let gamma_j_m2 = gamma(request, &parameters);
    if !(gamma_j_m2.is_normal() && gamma_j_m2 > 0.0) {
        return Err(BakeError::NotPositive { key: "gamma from the fragment size", value: gamma_j_m2 });
    }
    if let Some(RatioRange { key, over, value }) =
        stored_values::unusual(&parameters, &surface.frame, gamma_j_m2, degree::KAPPA)
    {
        return Err(BakeError::Unusual { key, over, value });
    }
    let name = request.name.clone();
    let skin = dressed(&surface, &mut bodies, parameters.crack_spacing, tables, request.cracks.is_some());
    Ok(PreparedObject {
        name,
        frame: surface.frame,
        parameters,
        gamma_j_m2,
        kappa: degree::KAPPA,
        report,
        bodies,
        impacts: 0,
        examples: Vec::new(),
        learned: None,
        reduction: None,
        held: None,
        skin: skin.map(Arc::new),
    })
}

/// The crack lattice of each body, and its elasticity if that is wanted, not factored yet.
fn assembled(
    bodies: Vec<BodyLattice>,
    parameters: &BakeParameters,
    tables: Tables,
    token: &CancelToken,
) -> Result<Vec<(Lattice, Option<ElasticModel>)>, BakeError> {
    let one = |(body, BodyLattice { elastic, crack, transfer })| {
        let solid = || ElasticModel::new(elastic, transfer, parameters.material.poisson, parameters.factor, token);
        let failed = |source| BakeError::Elasticity { body, source };
        Ok((crack, tables.elastic.then(solid).transpose().map_err(failed)?))
    };
    bodies.into_iter().enumerate().map(one).collect()
}

/// The input's triangles for skins, and their looks for the bodies, as far as they are wanted; with the walls of existing cracks.
fn dressed(
    surface: &Surface,
    bodies: &mut [PreparedBody],
    spacing: f64,
    tables: Tables,
    cracked: bool,
) -> Option<Skin> {
    let wanted = tables.attributes || tables.skin;
    let lattices: Vec<(&Lattice, &Topology)> = bodies.iter().map(|body| (&body.crack, &body.topology)).collect();
    let skin = wanted.then(|| Skin::of(surface, &lattices.iter().map(|(own, _)| *own).collect::<Vec<_>>(), spacing))?;
    let outer = if tables.attributes { BoundaryAttributes::of(&skin, &lattices, spacing) } else { Vec::new() };
    let skin = if cracked { skin.with_walls(&lattices, spacing) } else { skin };
    bodies.iter_mut().zip(outer).for_each(|(body, outer)| body.outer = Some(outer));
    tables.skin.then_some(skin)
}

/// γ, J·m².
pub(super) fn gamma(request: &BakeRequest, parameters: &BakeParameters) -> f64 {
    let BakeParameters { material, fragment_size_m, .. } = parameters;
    let reference = || degree::reference_gamma(material.young_pa, material.strength_pa, *fragment_size_m);
    request.gamma_j_m2.unwrap_or_else(reference)
}

/// Bounds, κ and the network from the examples; κ from a few impacts of its own where a new object has too few of them.
pub(super) fn finish(
    prepared: &mut PreparedObject,
    request: Option<&BakeRequest>,
    token: &CancelToken,
    progress: &mut dyn FnMut(BakeStep),
) -> Result<(), BakeError> {
    prepared.bound(token)?;
    if prepared.impacts > 0 && prepared.parameters.elastic == ElasticRequest::Reduced {
        progress(BakeStep::Reduction);
        let rank_max = prepared.parameters.quality.lattices().rank_max;
        pipeline::reduce(prepared, rank_max, token)?;
    }
    if let Some((kappa, learned)) = pipeline::learn(&prepared.examples, prepared.parameters.seed) {
        (prepared.kappa, prepared.learned) = (kappa, Some(learned));
    }
    match request {
        Some(BakeRequest { kappa: Some(kappa), .. }) => prepared.kappa = *kappa,
        Some(request) if prepared.learned.is_none() && request.tables().elastic && request.tables().interior => {
            progress(BakeStep::Calibration);
            prepared.kappa = calibrate(prepared, token)?;
        }
        _ => {}
    }
    Ok(())
}

pub(super) fn few_enough(examples: u64) -> Result<(), BakeError> {
    let fits = examples <= EXAMPLES_MAX as u64;
    fits.then_some(()).ok_or(BakeError::TooManyExamples { asked: examples })
}

/// The surface lift of body `body`, or a line in the report: no strike needs it unless it asks for it by name.
fn surface_lift(
    crack: &Lattice,
    body: usize,
    report: &mut BakeReport,
    token: &CancelToken,
) -> Result<Option<LiftedLattice>, Cancelled> {
    match lift::surface_diffusion(crack, Extension::Harmonic, lift::SURFACE_MODES_DEFAULT, token) {
        Ok(lift) => Ok(Some(lift)),
        Err(LiftError::Cancelled(cancelled)) => Err(cancelled),
        Err(error) => {
            let lift = LiftKind::SurfaceDiffusion;
            report.unprepared.push(MissingLift { body, lift, reason: error.to_string() });
            Ok(None)
        }
    }
}

/// Whether `name` can name an object: it names a file and travels in a fixed field.
pub fn is_object_name(name: &str) -> bool {
    (1..=NAME_BYTES_MAX).contains(&name.len())
        && !name.starts_with('.')
        && !name.chars().any(|c| is_invisible(c) || c == '/' || c == '\\')
}

pub(super) fn check(request: &BakeRequest) -> Result<(), BakeError> {
    if !is_object_name(&request.name) {
        return Err(BakeError::Name(request.name.clone()));
    }
    let numbers = [
        ("fragment-size", request.fragment_size_m),
        ("gamma", request.gamma_j_m2),
        ("elastic-spacing", request.elastic_spacing),
        ("crack-spacing", request.crack_spacing),
        ("kappa", request.kappa),
    ];
    for (key, value) in numbers {
        if let Some(value) = value.filter(|value| !(value.is_finite() && *value > 0.0)) {
            return Err(BakeError::NotPositive { key, value });
        }
    }
    few_enough(request.examples)
}

pub(super) fn parameters(
    request: &BakeRequest,
    surface: &Surface,
    [elastic_spacing, crack_spacing]: [f64; 2],
) -> BakeParameters {
    BakeParameters {
        material_name: request.material_name.clone(),
        material: request.material.clone(),
        fragment_size_m: request.fragment_size_m.unwrap_or(DEFAULT_FRAGMENT_DIAGONALS * surface.frame.diagonal_m),
        elastic_spacing,
        crack_spacing,
        modes: request.quality.lattices().modes,
        alpha: lift::ALPHA_DEFAULT,
        seed: request.seed,
        elastic: request.elastic,
        factor: request.factor,
        quality: request.quality,
    }
}
