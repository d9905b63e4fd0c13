//! Section 0 of the method as one function.
//!
//! Based on: Schvartzman & Otaduy, *Fracture Animation Based on High-Dimensional Voronoi Diagrams* (I3D 2014), figure 2.

use super::cells::{Division, divide};
use super::energy::{apply, radius_m, strain_energy_applied};
use super::meshes::MeshSources;
use super::{
    BodyEnergy, ContactSet, DegreeRequest, DegreeSource, FractureError, FractureMeshes, FractureOutcome,
    FractureRequest, PreparedObject, Stage, StageObserver, ThresholdResult, Workspace, energy_bound, strain_energy,
    threshold, warped,
};
use crate::cancel_token::CancelToken;
use crate::centroidal::{Diagram, EnergyField};
use crate::degree;
use crate::lift::LiftKind;
use crate::scene::EffectKind;
use crate::tessellation;

/// An impact goes in, fragments come out. Stage names are told to `watch`; `token` may stop the work at any checkpoint.
/// Where the object stays whole nothing after the threshold test runs, and nothing before it but the load where a bound of E_1 will
/// do and is below γ.
pub fn strike(
    prepared: &PreparedObject,
    strike: &FractureRequest,
    workspace: &mut Workspace,
    token: &CancelToken,
    watch: &mut dyn StageObserver,
) -> Result<FractureOutcome, FractureError> {
    walk(prepared, strike, workspace, token, watch, |broken, scratch, watch| {
        FractureMeshes::new(broken, scratch, token, watch)
    })
}

/// The walk up to the cells, which `cut` makes pieces of.
pub(super) fn walk(
    prepared: &PreparedObject,
    strike: &FractureRequest,
    workspace: &mut Workspace,
    token: &CancelToken,
    watch: &mut dyn StageObserver,
    cut: impl FnOnce(
        MeshSources<'_>,
        &mut tessellation::TessellationWorkspace,
        &mut dyn StageObserver,
    ) -> Result<FractureMeshes, FractureError>,
) -> Result<FractureOutcome, FractureError> {
    let begun_s = watch.remaining_s();
    let mut hurried = strike.planned().degrade_for_budget(prepared, begun_s);
    let strike = &hurried;
    let gamma_j_m2 = check(prepared, strike)?;
    watch.enter(Stage::Load);
    let impact = ContactSet::new(prepared, strike);
    watch.leave(Stage::Load, 0);
    let impact = impact?;
    apply(prepared, &impact, workspace, watch)?;
    if energy_bound::will_do(strike) {
        watch.enter(Stage::Threshold);
        let below = energy_bound::below(prepared, strike, &impact, gamma_j_m2, &mut workspace.loads);
        watch.leave(Stage::Threshold, 0);
        if let Some(e1_over_gamma) = below {
            let loads = workspace.loads.iter().take(impact.bodies.len());
            let radius_m = loads.map(|load| radius_m(prepared, load)).fold(0.0, f64::max);
            let dials = dialled(strike, holding(gamma_j_m2, e1_over_gamma, radius_m));
            return Ok(FractureOutcome { bounded: true, ..dials });
        }
    }
    let mut energies = strain_energy_applied(prepared, &impact, workspace, token, watch)?;

    watch.enter(Stage::Threshold);
    let mut shares: Vec<Vec<f64>> = energies.iter_mut().map(|energy| std::mem::take(&mut energy.shares)).collect();
    let fields = fields(prepared, strike, &energies, &mut shares)?;
    if strike.lift != LiftKind::Euclidean {
        let tables = fields.iter().map(|field| size_of_val(field.lift().coordinates.as_slice()) as u64);
        watch.part(EffectKind::Interior, tables.sum());
    }
    let verdict = ThresholdResult::new(prepared, gamma_j_m2, &energies, &fields);
    watch.leave(Stage::Threshold, 0);
    if !verdict.e1_over_gamma().is_normal() {
        return Err(FractureError::Range(verdict.e1_over_gamma()));
    }

    let holds = verdict.e1_over_gamma() <= 1.0 && !matches!(strike.degree, DegreeRequest::Sites(_));
    if holds || strike.threshold_only {
        let mut outcome = dialled(strike, whole(&verdict, &energies));
        if strike.threshold_only && strike.effects.has(EffectKind::Gravity) {
            let mut harder = |factor| weighed(prepared, strike, &impact, factor, workspace, token, watch);
            outcome.impulse_factor = threshold::under_weight(&mut harder)?;
        }
        return Ok(outcome);
    }
    hurried.rescale_cost(&energies, begun_s - watch.remaining_s());
    let strike = &hurried;
    let masses = warped::repainted(prepared, strike, &energies, &fields);
    let followed = warped::followed(prepared, strike, &energies, &fields, &masses)?;
    let mut division = divide(prepared, strike, &verdict, &followed, workspace, token, watch)?;
    warped::guard(prepared, strike, &energies, &mut division.cells, watch);
    let Workspace { tessellation, spare, .. } = workspace;
    let pieces = MeshSources { prepared, strike, energies: &energies, fields: &fields, division: &division, spare };
    let pieces = cut(pieces, tessellation, watch)?;
    Ok(dialled(strike, broken(&verdict, &energies, &division, pieces)))
}

/// The energy densities of the struck bodies, in the lift of the strike; `shares` is where they lie.
fn fields<'a>(
    prepared: &'a PreparedObject,
    strike: &FractureRequest,
    energies: &[BodyEnergy],
    shares: &'a mut [Vec<f64>],
) -> Result<Vec<EnergyField<'a>>, FractureError> {
    let field = |(energy, shares): (&BodyEnergy, &'a mut Vec<f64>)| {
        let body = &prepared.bodies[energy.body];
        let field = EnergyField::on_checked(prepared.lift(energy.body, strike.lift)?, &body.volumes, shares);
        let field = field.map_err(|source| FractureError::Field { body: energy.body, source })?;
        Ok(field.grouped(&body.clusters))
    };
    energies.iter().zip(shares).map(field).collect()
}

/// E_1/γ of `impact` times `factor`, where the weight stays as it is.
fn weighed(
    prepared: &PreparedObject,
    strike: &FractureRequest,
    impact: &ContactSet,
    factor: f64,
    workspace: &mut Workspace,
    token: &CancelToken,
    watch: &mut dyn StageObserver,
) -> Result<f64, FractureError> {
    let impact = ContactSet { peak_force_n: impact.peak_force_n * factor, ..impact.clone() };
    let mut energies = strain_energy(prepared, &impact, workspace, token, watch)?;
    let mut shares: Vec<Vec<f64>> = energies.iter_mut().map(|energy| std::mem::take(&mut energy.shares)).collect();
    let fields = fields(prepared, strike, &energies, &mut shares)?;
    let gamma_j_m2 = strike.gamma_j_m2.unwrap_or(prepared.gamma_j_m2);
    Ok(ThresholdResult::new(prepared, gamma_j_m2, &energies, &fields).e1_over_gamma())
}

/// γ in effect, after a check of what does not depend on the body.
fn check(prepared: &PreparedObject, strike: &FractureRequest) -> Result<f64, FractureError> {
    let gamma_j_m2 = strike.gamma_j_m2.unwrap_or(prepared.gamma_j_m2);
    if !(gamma_j_m2.is_finite() && gamma_j_m2 > 0.0) {
        return Err(FractureError::Gamma(gamma_j_m2));
    }
    match strike.degree {
        DegreeRequest::Sites(degree) if !(1..=strike.degree_max).contains(&degree) => {
            Err(FractureError::Degree { degree, cap: strike.degree_max })
        }
        _ => Ok(gamma_j_m2),
    }
}

fn whole(verdict: &ThresholdResult, energies: &[BodyEnergy]) -> FractureOutcome {
    let reduced = energies.iter().try_fold(0.0, |worst: f64, energy| energy.reduced_error.map(|own| worst.max(own)));
    let radius_m = energies.iter().map(|energy| energy.radius_m).fold(0.0, f64::max);
    FractureOutcome { reduced_error: reduced, ..holding(verdict.gamma_j_m2, verdict.e1_over_gamma(), radius_m) }
}

/// With the dials that were in effect.
fn dialled(strike: &FractureRequest, outcome: FractureOutcome) -> FractureOutcome {
    let FractureRequest { rank_max, reduced_error_max, .. } = *strike;
    FractureOutcome { rank_max, reduced_error_max, ..outcome }
}

/// Of an object that stays whole.
fn holding(gamma_j_m2: f64, e1_over_gamma: f64, radius_m: f64) -> FractureOutcome {
    FractureOutcome {
        gamma_j_m2,
        e1_over_gamma,
        bounded: false,
        impulse_factor: degree::threshold_factor(e1_over_gamma, 1.0),
        radius_m,
        reduced_error: None,
        rank_max: None,
        reduced_error_max: 0.0,
        sites: 0,
        fracture_degree: 1,
        degree_source: DegreeSource::Threshold,
        confidence: 1.0,
        capped: false,
        iterations: 0,
        cvd_gap: None,
        ending: None,
        pieces: None,
    }
}

fn broken(
    verdict: &ThresholdResult,
    energies: &[BodyEnergy],
    division: &Division,
    pieces: FractureMeshes,
) -> FractureOutcome {
    let diagrams = || division.cells.iter().map(|cells| &cells.diagram);
    let sites: usize = diagrams().map(Diagram::count).sum();
    FractureOutcome {
        sites: sites as u32,
        fracture_degree: division.degree,
        degree_source: division.source,
        confidence: division.confidence,
        capped: division.capped,
        iterations: diagrams().map(Diagram::iterations).max().unwrap_or(0),
        cvd_gap: diagrams().map(Diagram::gap).reduce(f64::max),
        ending: division.ending,
        pieces: Some(pieces),
        ..whole(verdict, energies)
    }
}
