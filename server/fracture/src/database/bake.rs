//! Baking: a prepared object from a mesh and parameters.

use super::Tables;
use super::bake_error::BakeError;
use super::bake_request::{BakeRequest, check, gamma};
use super::bake_step::{BakeSize, BakeStep};
use super::hash::input_hash;
use super::share::{BakeShare, PartialBake};
use super::stored_values::{self, PlausibleRange};
use super::stuffed::lattices;
use super::thin::{report_exact, report_loose_sheets};
use crate::cancel_token::{CancelToken, Canceled};
use crate::cutting::{
    CuttingError, CuttingMesh, CuttingMeshes, FilledSurface, RepairKind, SurfaceRepair, cutting_meshes,
};
use crate::degree;
use crate::elasticity::ElasticityError;
use crate::lattice::{BodyLattice, Lattice};
use crate::lift::{self, Extension, LiftError, LiftKind, LiftedLattice};
use crate::pipeline::{
    self, BakeParameters, BakeReport, DisplacementMethod, ElasticModel, MissingLift, PreparedBody, PreparedObject,
    SurfaceKind, SurfaceReport, calibrate,
};
use crate::skin::{BoundaryAttributes, Skin};
use crate::surface::{LocalFrame, RawMesh, Surface};
use crate::tessellation::Topology;
use nalgebra::Vector3;
use std::sync::Arc;

/// Bakes `raw`. Deterministic in (mesh, request). Calls `progress` at the start of each step.
///
/// # Errors
/// [`BakeError`]; `token` cancels.
pub fn bake(
    raw: RawMesh,
    request: &BakeRequest,
    token: &CancelToken,
    progress: &mut dyn FnMut(BakeStep),
) -> Result<PreparedObject, BakeError> {
    PartialBake::begin(raw, request, BakeShare::WHOLE, token, progress)?.complete(token, progress)
}

impl BakeRequest {
    /// Bakes `mesh`, with no observer and no way to stop. [`bake`] takes both.
    ///
    /// # Errors
    /// Those of [`bake`].
    pub fn bake(&self, mesh: RawMesh) -> Result<PreparedObject, BakeError> {
        bake(mesh, self, &CancelToken::default(), &mut |_| ())
    }
}

/// Bakes everything except the examples and the data learned from them.
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
    let is_exact = request.surface == SurfaceKind::Exact && request.cracks.is_none();
    let input = is_exact.then(|| input_hash(&surface, None));
    let filled = if is_exact { FilledSurface::new(surface) } else { FilledSurface::unchanged(surface) };
    let surface = &filled.surface;
    let (parameters, levels, mut report) = lattices(request, surface, token, progress)?;
    report.input_hash = input.unwrap_or(report.input_hash);
    let tables = request.tables();
    let gamma_j_m2 = plausible_gamma(request, &parameters, &surface.frame)?;
    let bodies = assembled(levels.bodies, &parameters, &report, tables, token)?;
    let mut prepared = PreparedObject {
        name: request.name.clone(),
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
        anchored_bases: Vec::new(),
        held: None,
        skin: None,
    };
    progress(BakeStep::Sized(BakeSize::of(&prepared, surface, request)));
    // First, because a body with a free joint is refused.
    factor(&prepared, progress)?;
    if pipeline::raise_orders(&mut prepared, token)? {
        progress(BakeStep::Sized(BakeSize::of(&prepared, surface, request)));
    }
    lifts(&mut prepared, tables, token, progress)?;
    if is_exact {
        exact_surface(&filled, &mut prepared, tables, token, progress)?;
    } else if request.surface == SurfaceKind::Exact {
        prepared.report.surface.reason = Some("existing cracks are slots of the lattice".to_owned());
    }
    let spacing = prepared.parameters.crack_spacing;
    prepared.skin = skin_of(surface, &mut prepared.bodies, spacing, tables, request.cracks.is_some()).map(Arc::new);
    Ok(prepared)
}

/// Threshold γ of a request, J·m²; all parameters must be plausible with it.
fn plausible_gamma(request: &BakeRequest, parameters: &BakeParameters, frame: &LocalFrame) -> Result<f64, BakeError> {
    let gamma_j_m2 = gamma(request, parameters);
    if !(gamma_j_m2.is_normal() && gamma_j_m2 > 0.0) {
        return Err(BakeError::NotPositive { key: "gamma from the fragment size", value: gamma_j_m2 });
    }
    match stored_values::unusual(parameters, frame, gamma_j_m2, degree::KAPPA) {
        Some(PlausibleRange { key, over, value }) => Err(BakeError::Unusual { key, over, value }),
        None => Ok(gamma_j_m2),
    }
}

/// Factors the stiffness of all bodies.
fn factor(prepared: &PreparedObject, progress: &mut dyn FnMut(BakeStep)) -> Result<(), BakeError> {
    for (index, body) in prepared.bodies.iter().enumerate() {
        progress(BakeStep::Elasticity(index));
        if let Some(solid) = &body.solid {
            solid.elasticity.factor().map_err(|source| elasticity_error(index, solid, source, &prepared.frame))?;
        }
    }
    Ok(())
}

/// Computes the selected lifts of all bodies.
fn lifts(
    prepared: &mut PreparedObject,
    tables: Tables,
    token: &CancelToken,
    progress: &mut dyn FnMut(BakeStep),
) -> Result<(), BakeError> {
    let PreparedObject { bodies, parameters, report, .. } = prepared;
    for (index, body) in bodies.iter_mut().enumerate() {
        progress(BakeStep::Lift(index));
        let failed = |source| BakeError::Lift { body: index, source };
        let interior = || lift::interior(&body.crack, parameters.modes, parameters.alpha, token).map_err(failed);
        body.interior = tables.interior.then(interior).transpose()?;
        let diffusion = || surface_lift(&body.crack, index, report, token);
        body.surface_diffusion = tables.surface_diffusion.then(diffusion).transpose()?.flatten();
    }
    Ok(())
}

/// Adds the meshes of the input surface to the bodies, or the reason why there are none to the report.
fn exact_surface(
    filled: &FilledSurface,
    prepared: &mut PreparedObject,
    tables: Tables,
    token: &CancelToken,
    progress: &mut dyn FnMut(BakeStep),
) -> Result<(), BakeError> {
    let PreparedObject { bodies, parameters, report, .. } = prepared;
    let (cracks, spacing): (Vec<&Lattice>, f64) =
        (bodies.iter().map(|body| &body.crack).collect(), parameters.crack_spacing);
    let has_attributes = tables.attributes || tables.skin;
    let frame = filled.surface.frame;
    let meshes = cutting_meshes(filled, &cracks, spacing, has_attributes, token, &mut |step| {
        progress(BakeStep::ExactSurface { round: step.round() });
    });
    let CuttingMeshes { meshes, deviation, collapsed_edges, repairs } = match meshes {
        Ok(meshes) => meshes,
        Err(CuttingError::Canceled(canceled)) => return Err(canceled.into()),
        Err(error) => {
            report.surface.reason = Some(error.reason(&frame));
            report.surface.repairs.clone_from(&filled.repairs);
            return Ok(());
        }
    };
    if !repairs.is_empty() {
        let volume: f64 = meshes.iter().flat_map(|own| &own.volumes).sum();
        report.input_volume_m3 = volume * frame.diagonal_m.powi(3);
    }
    let sum = |of: fn(&CuttingMesh) -> usize| meshes.iter().map(of).sum::<usize>() as u64;
    report.surface = SurfaceReport {
        kind: SurfaceKind::Exact,
        reason: None,
        nodes: sum(|own| own.mesh.nodes.len()),
        tets: sum(|own| own.mesh.tets.len()),
        deviation,
        collapsed_edges,
        anchored_nodes: sum(CuttingMesh::anchored_count),
        repairs,
    };
    let has = |repairs: &[SurfaceRepair], kind| repairs.iter().any(|repair| repair.kind == kind);
    if has(&filled.repairs, RepairKind::FilledHoles) && !has(&report.surface.repairs, RepairKind::FilledHoles) {
        report_loose_sheets(&mut report.defects);
    }
    let is_divided = report.surface.repairs.iter().any(|repair| repair.kind == RepairKind::DividedVertices);
    report_exact(&mut report.defects, is_divided);
    bodies.iter_mut().zip(meshes).for_each(|(body, mesh)| body.set_cutting(mesh));
    Ok(())
}

/// The bodies with their elasticity if selected, not yet factored, and without lifts.
fn assembled(
    bodies: Vec<BodyLattice>,
    parameters: &BakeParameters,
    report: &BakeReport,
    tables: Tables,
    token: &CancelToken,
) -> Result<Vec<PreparedBody>, BakeError> {
    let one = |(body, BodyLattice { elastic, crack, transfer })| {
        let (law, order) = ((parameters.material.poisson, parameters.factor), report.order(body));
        let solid = || ElasticModel::new(elastic, transfer, law, order, token);
        let failed = |source| BakeError::Elasticity { body, source };
        let solid = tables.elastic.then(solid).transpose().map_err(failed)?;
        Ok(PreparedBody { solid, ..PreparedBody::new(crack) })
    };
    bodies.into_iter().enumerate().map(one).collect()
}

/// The error of a body without a factor; it names the joint of a mechanism.
fn elasticity_error(body: usize, solid: &ElasticModel, source: ElasticityError, frame: &LocalFrame) -> BakeError {
    let ElasticityError::Mechanism { residual } = source else { return BakeError::Elasticity { body, source } };
    let lattice = &solid.lattice;
    solid.elasticity.weakest_tet(lattice).map_or(BakeError::Elasticity { body, source }, |tet| {
        let center = lattice.corners(tet).iter().map(|corner| corner.coords).sum::<Vector3<f64>>() / 4.0;
        BakeError::FreeJoint { body, place_m: frame.to_meters(&center.into()), residual }
    })
}

/// The skin and the attributes on the bodies' boundaries, as far as selected. Walls of existing cracks are included.
fn skin_of(
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

/// Computes bounds of E_1, the error of the elastic lattices, reduced bases, κ and the network from the examples.
///
/// A new object with too few examples gets κ from a few impacts drawn for that.
pub(super) fn finish(
    prepared: &mut PreparedObject,
    request: Option<&BakeRequest>,
    token: &CancelToken,
    progress: &mut dyn FnMut(BakeStep),
) -> Result<(), BakeError> {
    prepared.bound(token)?;
    if request.is_some() {
        pipeline::estimate_discretization(prepared, token)?;
    }
    let has_basis = prepared.impacts > 0 || prepared.has_quadratic_elements();
    if has_basis && prepared.parameters.elastic == DisplacementMethod::Reduced {
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

/// The surface lift of body `body`, or an entry in the report, because only requests that name this lift need it.
fn surface_lift(
    crack: &Lattice,
    body: usize,
    report: &mut BakeReport,
    token: &CancelToken,
) -> Result<Option<LiftedLattice>, Canceled> {
    match lift::surface_diffusion(crack, Extension::Harmonic, lift::SURFACE_MODES_DEFAULT, token) {
        Ok(lift) => Ok(Some(lift)),
        Err(LiftError::Canceled(canceled)) => Err(canceled),
        Err(error) => {
            let lift = LiftKind::SurfaceDiffusion;
            report.unprepared.push(MissingLift { body, lift, reason: error.to_string() });
            Ok(None)
        }
    }
}
