//! Section 0 of the method as one function.
//!
//! Based on: Schvartzman & Otaduy, *Fracture Animation Based on High-Dimensional Voronoi Diagrams* (I3D 2014), figure 2.

use super::error::FractureError;
use super::output::cut::MeshSources;
use super::output::ledger::{CRACK_SHARE, EnergyLedger, lower_limits};
use super::output::meshes::FractureMeshes;
use super::output::slivers;
use super::prepared::object::PreparedObject;
use super::request::context::RequestContext;
use super::request::fracture_request::{DegreeRequest, FractureRequest};
use super::request::stage::Stage;
use super::result::{Fracture, FractureOutcome, ImpactorReport, ThresholdReport};
use super::stages::cells::{CellPartition, divide};
use super::stages::contact_set::ContactSet;
use super::stages::energy::{BodyEnergy, apply, radius_m, strain_energy, strain_energy_applied};
use super::stages::impactor::{impactor_energy_j, limit_load};
use super::stages::onset::ObjectOnset;
use super::stages::threshold::{self, ThresholdResult};
use super::stages::{controls, threshold_bound};
use super::workspace::Workspace;
use crate::cancel_token::CancelToken;
use crate::centroidal::{Diagram, EnergyField};
use crate::degree;
use crate::lift::LiftKind;
use crate::scene::EffectKind;
use crate::strength::Criterion;
use crate::tessellation::TessellationWorkspace;

/// Breaks the object by the impact of the request.
///
/// If the object stays intact, the threshold test is the last stage. If a bound of E_1 is already below γ, only the
/// load stage runs before that test.
///
/// # Errors
/// [`FractureError`], naming the contact or the body.
pub fn strike(context: RequestContext<'_>, workspace: &mut Workspace) -> Result<FractureOutcome, FractureError> {
    let begun_s = context.cancel.remaining_s();
    let plan = context.request.planned().degrade_for_budget(context.prepared, begun_s);
    walk(context.with_request(&plan), begun_s, workspace, FractureMeshes::new)
}

impl PreparedObject {
    /// Strikes the object, with new memory, no observer and no way to stop. [`strike`] takes all three.
    ///
    /// # Errors
    /// Those of [`strike`].
    pub fn strike(&self, request: &FractureRequest) -> Result<FractureOutcome, FractureError> {
        strike(RequestContext::new(self, request, &CancelToken::default(), &()), &mut Workspace::default())
    }
}

/// Runs all stages of a planned request that had `begun_s` seconds left at its start.
///
/// `cut` makes meshes of the cells: [`FractureMeshes::new`] for an object, or those of a fragment's children.
pub(in crate::pipeline) fn walk(
    context: RequestContext<'_>,
    begun_s: f64,
    workspace: &mut Workspace,
    cut: impl Fn(MeshSources<'_>, &mut TessellationWorkspace) -> Result<FractureMeshes, FractureError>,
) -> Result<FractureOutcome, FractureError> {
    let RequestContext { prepared, request, cancel, observer } = context;
    let gamma_j_m2 = check(prepared, request)?;
    let contacts = {
        let _load = observer.stage(Stage::Load);
        ContactSet::new(prepared, request)?
    };
    let impactor_j = impactor_energy_j(prepared, request, &contacts)?;
    apply(context, &contacts, workspace)?;
    if threshold_bound::is_sufficient(request) {
        let _threshold = observer.stage(Stage::Threshold);
        let below = threshold_bound::below(prepared, request, &contacts, gamma_j_m2, &mut workspace.loads);
        if let Some(e1_over_gamma) = below {
            let loads = workspace.loads.iter().take(contacts.bodies.len());
            let radius_m = loads.map(|load| radius_m(prepared, load)).fold(0.0, f64::max);
            let report = report((prepared, request), gamma_j_m2, e1_over_gamma, radius_m);
            // The bound holds for every lower load, too.
            let impactor = impactor_j.map(|energy_j| ImpactorReport { energy_j, load_factor: None });
            return Ok(FractureOutcome::Intact(ThresholdReport { is_bound: true, impactor, ..report }));
        }
    }
    let mut energies = strain_energy_applied(context, &contacts, workspace)?;
    let mut shares: Vec<Vec<f64>> = energies.iter_mut().map(|energy| std::mem::take(&mut energy.shares)).collect();
    let (fields, mut threshold) = tested(context, gamma_j_m2, &energies, &mut shares)?;
    let mut onset = onset(context, &energies)?;
    let mut report = of_energies((prepared, request), &threshold, &energies, onset.as_ref());
    let factor = limited(impactor_j, (&mut energies, &mut threshold, onset.as_mut()), &mut report);
    let breaks = onset.as_ref().map_or(report.e1_over_gamma > 1.0, ObjectOnset::breaks);
    let holds = factor == 0.0 || (!breaks && !matches!(request.degree, DegreeRequest::Sites(_)));
    if request.threshold_only && request.effects.has(EffectKind::Gravity) {
        report.impulse_factor = threshold::under_weight(&mut |factor| weighed(context, &contacts, factor, workspace))?;
    }
    if holds || request.threshold_only {
        return Ok(FractureOutcome::Intact(report));
    }
    let solved = energies.iter().any(|energy| energy.reduced_error.is_none());
    let budget = request.budget.map(|budget| budget.rescaled(solved, begun_s - cancel.remaining_s()));
    let masses = controls::repainted(prepared, request, &energies, &fields);
    let followed = controls::followed(prepared, request, &energies, &fields, &masses)?;
    let (is_given, constants) =
        (matches!(request.degree, DegreeRequest::Sites(_)), request.strength_constants(prepared));
    let mut limits = onset.as_ref().map(|onset| onset.site_limits(prepared, &energies, CRACK_SHARE));
    for turn in 0.. {
        let division = divide(context, budget, &threshold, (&followed, limits.as_deref()), workspace)?;
        if limits.is_some() && division.cells.is_empty() {
            break;
        }
        let Workspace { tessellation, spare, .. } = workspace;
        let sources = MeshSources { context, energies: &energies, fields: &fields, division: &division, spare };
        let meshes = cut(sources, tessellation)?;
        let is_over = limits.as_mut().is_some_and(|limits| {
            !is_given && lower_limits((limits, turn), &division.cells, (&meshes, &energies), constants.toughness_j_m2)
        });
        if !is_over {
            let ledger = onset.as_ref().map(|_| EnergyLedger::new(&meshes, &energies, constants.toughness_j_m2));
            return Ok(FractureOutcome::Fractured(Box::new(fracture(report, &division, (meshes, ledger)))));
        }
    }
    Ok(FractureOutcome::Intact(report))
}

/// Lowers all loads to the energy of the impactor, if that is known; returns the factor.
fn limited(
    impactor_j: Option<f64>,
    (energies, threshold, onset): (&mut [BodyEnergy], &mut ThresholdResult, Option<&mut ObjectOnset>),
    report: &mut ThresholdReport,
) -> f64 {
    report.impactor = impactor_j.map(|energy_j| limit_load(energy_j, energies));
    let factor = report.impactor.and_then(|impactor| impactor.load_factor).unwrap_or(1.0);
    if factor < 1.0 {
        energies.iter_mut().for_each(|energy| energy.scale(factor));
        threshold.scale(factor);
        report.e1_over_gamma = threshold.e1_over_gamma();
        report.strain_j = energies.iter().map(|energy| energy.strain_j).sum();
        if let Some(onset) = onset {
            onset.scale(factor);
            report.onset = Some(onset.report);
        }
    }
    factor
}

/// The criterion by strength and energy; `None` if the request asks for that of the paper.
fn onset(context: RequestContext<'_>, energies: &[BodyEnergy]) -> Result<Option<ObjectOnset>, FractureError> {
    if context.request.criterion == Criterion::Paper {
        return Ok(None);
    }
    let _threshold = context.observer.stage(Stage::Threshold);
    ObjectOnset::new(context, energies, slivers::least_volume(context)).map(Some)
}

/// Threshold test: energy densities of the struck bodies, with the values `shares`, and E_1 of each body compared to γ.
fn tested<'a>(
    context: RequestContext<'a>,
    gamma_j_m2: f64,
    energies: &[BodyEnergy],
    shares: &'a mut [Vec<f64>],
) -> Result<(Vec<EnergyField<'a>>, ThresholdResult), FractureError> {
    let RequestContext { prepared, request, observer, .. } = context;
    let _threshold = observer.stage(Stage::Threshold);
    let fields = fields(prepared, request, energies, shares)?;
    if request.lift != LiftKind::Euclidean {
        let tables = fields.iter().map(|field| size_of_val(field.lift().coordinates.as_slice()) as u64);
        observer.part(EffectKind::Interior, tables.sum());
    }
    let threshold = ThresholdResult::new(prepared, gamma_j_m2, energies, &fields);
    match threshold.e1_over_gamma() {
        normal if normal.is_normal() => Ok((fields, threshold)),
        other => Err(FractureError::Range(other)),
    }
}

/// Energy densities of the struck bodies, in the lift of the request, with the values `shares`.
fn fields<'a>(
    prepared: &'a PreparedObject,
    request: &FractureRequest,
    energies: &[BodyEnergy],
    shares: &'a mut [Vec<f64>],
) -> Result<Vec<EnergyField<'a>>, FractureError> {
    let field = |(energy, shares): (&BodyEnergy, &'a mut Vec<f64>)| {
        let body = &prepared.bodies[energy.body];
        let field = EnergyField::on_checked(prepared.lift(energy.body, request.lift)?, &body.volumes, shares);
        let field = field.map_err(|source| FractureError::Field { body: energy.body, source })?;
        Ok(field.grouped(&body.clusters))
    };
    energies.iter().zip(shares).map(field).collect()
}

/// E_1/γ of `contacts` with impulses times `factor` and unchanged weight; with the criterion by strength, the inverse
/// square of the factor on all loads that just break the object.
fn weighed(
    context: RequestContext<'_>,
    contacts: &ContactSet,
    factor: f64,
    workspace: &mut Workspace,
) -> Result<f64, FractureError> {
    let RequestContext { prepared, request, .. } = context;
    let contacts = ContactSet { peak_force_n: contacts.peak_force_n * factor, ..contacts.clone() };
    let mut energies = strain_energy(context, &contacts, workspace)?;
    let mut shares: Vec<Vec<f64>> = energies.iter_mut().map(|energy| std::mem::take(&mut energy.shares)).collect();
    let fields = fields(prepared, request, &energies, &mut shares)?;
    let gamma_j_m2 = request.scaled_gamma_j_m2(prepared);
    if let Some(onset) = onset(context, &energies)? {
        return Ok(onset.load_factor().powi(-2).max(HELD));
    }
    Ok(ThresholdResult::new(prepared, gamma_j_m2, &energies, &fields).e1_over_gamma())
}

/// Least value of a criterion, for bodies that no load breaks.
const HELD: f64 = 1e-12;

/// The effective γ, J·m², after the checks of the request that need no body.
fn check(prepared: &PreparedObject, request: &FractureRequest) -> Result<f64, FractureError> {
    if !(request.strength_scale.is_finite() && request.strength_scale > 0.0) {
        return Err(FractureError::StrengthScale(request.strength_scale));
    }
    let gamma_j_m2 = request.scaled_gamma_j_m2(prepared);
    if !(gamma_j_m2.is_finite() && gamma_j_m2 > 0.0) {
        return Err(FractureError::Gamma(gamma_j_m2));
    }
    match request.degree {
        DegreeRequest::Sites(degree) if !(1..=request.degree_max).contains(&degree) => {
            Err(FractureError::Degree { degree, cap: request.degree_max })
        }
        _ => Ok(gamma_j_m2),
    }
}

fn report(
    (prepared, request): (&PreparedObject, &FractureRequest),
    gamma_j_m2: f64,
    e1_over_gamma: f64,
    radius_m: f64,
) -> ThresholdReport {
    let has_elastic = request.effects.has(EffectKind::Elastic);
    ThresholdReport {
        gamma_j_m2,
        e1_over_gamma,
        is_bound: false,
        impulse_factor: degree::threshold_factor(e1_over_gamma, 1.0),
        strain_j: None,
        impactor: None,
        onset: None,
        radius_m,
        reduced_error: None,
        discretization_error: prepared.report.discretization_error().filter(|_| has_elastic),
        rank_max: request.rank_max,
        reduced_error_max: request.reduced_error_max,
    }
}

fn of_energies(
    (prepared, request): (&PreparedObject, &FractureRequest),
    threshold: &ThresholdResult,
    energies: &[BodyEnergy],
    onset: Option<&ObjectOnset>,
) -> ThresholdReport {
    let reduced_error =
        energies.iter().try_fold(0.0, |worst: f64, energy| energy.reduced_error.map(|own| worst.max(own)));
    let radius_m = energies.iter().map(|energy| energy.radius_m).fold(0.0, f64::max);
    let report = report((prepared, request), threshold.gamma_j_m2, threshold.e1_over_gamma(), radius_m);
    let strain_j = energies.iter().map(|energy| energy.strain_j).sum();
    let impulse_factor = onset.map_or(report.impulse_factor, ObjectOnset::load_factor);
    ThresholdReport { reduced_error, strain_j, impulse_factor, onset: onset.map(|onset| onset.report), ..report }
}

fn fracture(
    threshold: ThresholdReport,
    division: &CellPartition,
    (meshes, ledger): (FractureMeshes, Option<EnergyLedger>),
) -> Fracture {
    let diagrams = || division.cells.iter().map(|cells| &cells.diagram);
    let sites: usize = diagrams().map(Diagram::count).sum();
    Fracture {
        threshold,
        sites: sites as u32,
        fracture_degree: division.degree,
        degree_source: division.source,
        confidence: division.confidence,
        capped: division.capped,
        iterations: diagrams().map(Diagram::iterations).max().unwrap_or(0),
        cvd_gap: diagrams().map(Diagram::gap).reduce(f64::max),
        ending: division.ending,
        ledger,
        meshes,
    }
}
