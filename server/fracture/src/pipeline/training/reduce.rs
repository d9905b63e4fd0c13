//! Reduced bases from the examples' impacts, and their errors on others.
//!
//! Ours: the problem is linear, so every contact of an example yields three snapshots, one per direction of its force.
//! Bodies of quadratic elements have a basis without examples, too, because a solve for them takes long. Most of their
//! contacts yield only one snapshot, so that the basis knows more places.

use super::sample::ImpactSampler;
use crate::cancel_token::CancelToken;
use crate::centroidal::EnergyField;
use crate::degree;
use crate::elasticity::{
    ContactLoad, DrivingEnergy, ElasticWorkspace, Elasticity, ElementOrder, ErrorEstimate, NodalLoad, ReducedBasis,
    Support,
};
use crate::lift::LiftKind;
use crate::pipeline::error::FractureError;
use crate::pipeline::prepared::object::PreparedObject;
use crate::pipeline::prepared::reduction::{CompletionErrors, ReductionErrors, TRAINED_RADIUS_MIN};
use crate::pipeline::request::context::RequestContext;
use crate::pipeline::request::fracture_request::FractureRequest;
use crate::pipeline::request::solver_settings::REDUCED_ERROR_MAX;
use crate::pipeline::stages::contact_set::ContactSet;
use crate::pipeline::stages::energy::strain_energy;
use crate::pipeline::stages::strain::alone_share;
use crate::pipeline::workspace::Workspace;
use crate::scene::{EffectKind, EffectSet};
use nalgebra::Vector3;
use rayon::prelude::*;

/// Largest size of one body's basis, bytes; larger lattices get fewer displacements.
const BASIS_BYTES_MAX: usize = 13 << 20;

/// As [`BASIS_BYTES_MAX`], for quadratic elements, without their strains.
///
/// Median energy errors of a vase of 58,752 nodes: 27 % with 32 MiB and 17 % with 48 MiB, of a plate of 79,127 nodes 1.0 % and 0.4 %.
pub(crate) const BASIS_BYTES_MAX_QUADRATIC: usize = 48 << 20;

/// Largest size of one body's snapshots during the computation, bytes; larger lattices get fewer snapshots.
const SNAPSHOT_BYTES_MAX: usize = 1 << 30;

/// Smallest number of displacements of a basis.
const RANK_MIN: usize = 8;

/// Number of held-out impacts, none of which is an example. Every other one fits the error estimates, the rest tests
/// them.
const HELD_OUT: u64 = 128;

/// As [`HELD_OUT`], for objects with quadratic elements, whose solves take long.
const HELD_OUT_QUADRATIC: u64 = 24;

/// Number of further impacts, at any angle and narrower, that fit the errors of completed displacements on regular cells.
///
/// The basis of a plate of 1:100 misses most of a push along it. Linear elements then lack 1 to 10 %, the most under narrow contacts.
const HELD_OUT_OTHER: u64 = 12;

/// Number of impacts along the surface after those of [`HELD_OUT_OTHER`], which only bound the same errors.
///
/// If a contact bends a plate, a linear solve adds about twice the energy that is missing after it. If it pushes along the plate, it adds
/// ten times that energy or more.
const HELD_OUT_ALONG: u64 = 6;

/// Largest estimated error of a completed displacement over the worst of all held-out impacts.
const WORST: f64 = 1.5;

/// Smallest number of impacts whose contacts yield the basis of a body with quadratic elements.
const IMPACTS_QUADRATIC: u64 = 60;

/// As [`IMPACTS_QUADRATIC`], for sheets on long cells.
const IMPACTS_SHEET: u64 = 32;

/// Number of impacts per example for the same bases.
const IMPACTS_PER_EXAMPLE: u64 = 2;

/// One of how many contacts has forces in three directions with quadratic elements.
///
/// Median errors of the basis alone with three directions of each contact and with one: plate of 1:100 9.3 % and 0.9 %, mug 1.5 % and 1.2 %.
const CONTACTS_IN_THREE_DIRECTIONS: usize = 8;

/// Radii of the held-out impacts with quadratic elements over those that are drawn, in turn, so that half have the default radius.
/// Only those of sheets and of further impacts become narrower.
const RADII_OF_QUADRATIC: [f64; 3] = [1.0, 0.5, 0.25];

/// Number of the first held-out impact, above all numbers of examples.
const HELD_OUT_FIRST: u64 = 1 << 32;

/// Computes and tests the bases of all bodies. Without impacts there are only those of quadratic elements, with `rank_max`
/// 0 there are none.
///
/// # Errors
/// [`FractureError`] of an impact, or for a canceled `token`.
pub fn reduce(prepared: &mut PreparedObject, rank_max: usize, token: &CancelToken) -> Result<(), FractureError> {
    prepared.reduction = None;
    prepared.bodies.iter_mut().flat_map(|body| &mut body.solid).for_each(|solid| solid.reduced = None);
    for index in 0..prepared.bodies.len() {
        let Some(solid) = &prepared.bodies[index].solid else { continue };
        let basis = basis(prepared, index, &solid.elasticity, rank_max, token)?;
        if let Some(solid) = &mut prepared.bodies[index].solid {
            solid.reduced = basis;
        }
    }
    if prepared.bodies.iter().all(|body| body.reduced().is_none()) {
        return Ok(());
    }
    let trials = trials(prepared, None, token)?;
    let is_steep = prepared.has_long_cells();
    for index in 0..prepared.bodies.len() {
        if let Some(solid) = &mut prepared.bodies[index].solid {
            solid.reduced = solid.reduced.take().map(|basis| fitted(basis, (index, is_steep), &trials));
        }
    }
    prepared.reduction = ReductionErrors::of(prepared, &trials);
    Ok(())
}

/// The basis of body `index` with its errors estimated by `trials`. If `is_steep`, completed displacements have an exponent of at least 1 and no bound.
pub(super) fn fitted(basis: ReducedBasis, (index, is_steep): (usize, bool), trials: &[Trial]) -> ReducedBasis {
    let own = || trials.iter().filter(|trial| trial.body == index && trial.fits);
    // Residuals along a plate would make the estimate of those that bend it too low.
    let pairs: Vec<_> = own().filter(|own| own.is_told).map(|own| (own.residual, own.energy_error)).collect();
    let completed = own().filter_map(|trial| trial.completed.as_ref());
    let completed: Vec<_> = completed.map(|own| (own.gain, own.energy_error)).collect();
    let (fit, error_max) = match is_steep {
        true => (ErrorEstimate::fit_steep as fn(&[(f64, f64)]) -> ErrorEstimate, f64::INFINITY),
        false => (ErrorEstimate::fit as _, completed_error_max(index, trials)),
    };
    let completed = ErrorEstimate { error_max, ..fit(&completed) };
    // Of a push along a disc, a basis missed 22 % where a smaller exponent told 3 %.
    let alone = if basis.completed_estimate().is_some() { ErrorEstimate::fit_steep } else { fit };
    basis.estimating(alone(&pairs)).estimating_completed(completed)
}

/// Largest error that completed displacements of body `index` are estimated to have; infinite with too few `trials` of them.
fn completed_error_max(index: usize, trials: &[Trial]) -> f64 {
    let own = trials.iter().filter(|trial| trial.body == index).filter_map(|trial| trial.completed.as_ref());
    let errors: Vec<f64> = own.map(|own| own.energy_error).filter(|error| *error > 0.0).collect();
    let worst = errors.iter().copied().fold(0.0, f64::max);
    if errors.len() < ErrorEstimate::PAIRS_MIN { f64::INFINITY } else { WORST * worst }
}

/// The basis of body `index`, held as in `elasticity`, from the contacts of the object's impacts.
pub(super) fn basis(
    prepared: &PreparedObject,
    index: usize,
    elasticity: &Elasticity,
    rank_max: usize,
    token: &CancelToken,
) -> Result<Option<ReducedBasis>, FractureError> {
    let order = elasticity.order();
    let bytes_max = match order {
        ElementOrder::Linear => BASIS_BYTES_MAX,
        ElementOrder::Quadratic => BASIS_BYTES_MAX_QUADRATIC,
    };
    let rank_max = rank_max.min(bytes_max / (size_of::<f32>() * elasticity.size()));
    let column_bytes = elasticity.snapshot_bytes();
    if rank_max < RANK_MIN {
        return Ok(None);
    }
    let failed = |source| FractureError::of_body(index, source);
    let mut loads = Vec::new();
    let mut workspace = Workspace::default();
    for (number, contact) in contacts(prepared, index)?.into_iter().enumerate() {
        let directions = directions(order, number, &contact.impulse);
        if (loads.len() + directions.len()) * column_bytes > SNAPSHOT_BYTES_MAX {
            break;
        }
        for impulse in directions {
            let mut load = NodalLoad::default();
            elasticity
                .load(&[ContactLoad { impulse, ..contact }], &mut load, &mut workspace.elasticity)
                .map_err(failed)?;
            loads.push(load);
        }
    }
    if loads.len() < RANK_MIN {
        return Ok(None);
    }
    if let Support::Anchored(_) = elasticity.support() {
        loads.extend((0..3).map(|axis| elasticity.weight_load(&Vector3::ith(axis, 1.0))));
    }
    elasticity.reduce(&prepared.solid(index)?.lattice, &loads, rank_max, token).map_err(failed)
}

/// Forces of contact `number`: along three axes, of most contacts with quadratic elements only its own `impulse`.
fn directions(order: ElementOrder, number: usize, impulse: &Vector3<f64>) -> Vec<Vector3<f64>> {
    match order {
        ElementOrder::Quadratic if !number.is_multiple_of(CONTACTS_IN_THREE_DIRECTIONS) => vec![impulse.normalize()],
        _ => (0..3).map(|axis| Vector3::ith(axis, 1.0)).collect(),
    }
}

/// All contacts of the object's impacts on body `index`, and of more impacts if its elements are quadratic.
fn contacts(prepared: &PreparedObject, index: usize) -> Result<Vec<ContactLoad>, FractureError> {
    let least = if prepared.has_long_cells() { IMPACTS_SHEET } else { IMPACTS_QUADRATIC };
    let impacts = match prepared.solid(index)?.elasticity.order() {
        ElementOrder::Linear => prepared.impacts,
        ElementOrder::Quadratic => least.max(IMPACTS_PER_EXAMPLE * prepared.impacts),
    };
    let sampler = ImpactSampler::new(prepared);
    let mut contacts = Vec::new();
    for impact in 0..impacts {
        let strike = sampler.impact(prepared.parameters.seed, impact);
        let bodies = ContactSet::new(prepared, &strike)?.bodies;
        contacts.extend(bodies.into_iter().filter(|(body, _)| *body == index).flat_map(|(_, contacts)| contacts));
    }
    Ok(contacts)
}

/// One body under one held-out impact, both solved and reduced.
#[derive(Clone)]
pub(super) struct Trial {
    body: usize,
    /// True if the estimates are fitted to this trial.
    fits: bool,
    /// True if the bake reports its errors. The other trials only help to estimate them.
    is_told: bool,
    residual: f64,
    energy_error: f64,
    density_error: f64,
    degree_error: f64,
    completed: Option<CompletedTrial>,
}

/// The completed displacement of a trial.
#[derive(Clone)]
struct CompletedTrial {
    gain: f64,
    energy_error: f64,
    density_error: f64,
}

/// The held-out impacts, with the effect `more` in addition, which anchors the object.
pub(super) fn trials(
    prepared: &PreparedObject,
    more: Option<EffectKind>,
    token: &CancelToken,
) -> Result<Vec<Trial>, FractureError> {
    let sampler = ImpactSampler::new(prepared);
    let [told, others, along] = held_out_counts(prepared);
    // Nothing bounds the errors of anchored bodies.
    let along = if more.is_some() { 0 } else { along };
    let one = |workspace: &mut Workspace, number: u64| {
        let mut strike = held_out(&sampler, prepared, number);
        strike.effects = more.into_iter().fold(strike.effects, EffectSet::with);
        let mut trials = trial(prepared, &strike, workspace, token)?;
        let is_told = number < told;
        let fits = if is_told { number.is_multiple_of(2) } else { number < told + others };
        trials.iter_mut().for_each(|own| (own.fits, own.is_told) = (fits, is_told));
        Ok::<_, FractureError>(trials)
    };
    let all: Vec<Vec<Trial>> =
        (0..told + others + along).into_par_iter().map_init(Workspace::default, one).collect::<Result<_, _>>()?;
    Ok(all.into_iter().flatten().collect())
}

/// Number of held-out impacts whose errors the bake reports, and of [`HELD_OUT_OTHER`] and [`HELD_OUT_ALONG`] ones after them.
fn held_out_counts(prepared: &PreparedObject) -> [u64; 3] {
    match (prepared.has_quadratic_elements(), prepared.has_long_cells()) {
        (false, _) => [HELD_OUT, 0, 0],
        (true, true) => [HELD_OUT_QUADRATIC, 0, 0],
        (true, false) => [HELD_OUT_QUADRATIC, HELD_OUT_OTHER, HELD_OUT_ALONG],
    }
}

/// Held-out impact `number`. Even numbers fit and odd ones test, with the same radii.
fn held_out(sampler: &ImpactSampler<'_>, prepared: &PreparedObject, number: u64) -> FractureRequest {
    let (seed, index) = (prepared.parameters.seed, HELD_OUT_FIRST + number);
    let [told, others, _] = held_out_counts(prepared);
    let is_other = number >= told;
    let mut strike = match is_other {
        false => sampler.impact(seed, index),
        true if number < told + others => sampler.impact_at_any_angle(seed, index),
        true => sampler.impact_along(seed, index),
    };
    if prepared.has_quadratic_elements() {
        let is_narrow = is_other || prepared.has_long_cells();
        let least = if is_narrow { 0.0 } else { TRAINED_RADIUS_MIN * prepared.frame.diagonal_m };
        let scale = RADII_OF_QUADRATIC[(number / 2) as usize % RADII_OF_QUADRATIC.len()];
        let radii = strike.contacts.iter_mut().filter_map(|own| own.radius_m.as_mut());
        radii.for_each(|radius_m| *radius_m = (*radius_m * scale).max(least));
    }
    strike
}

fn trial(
    prepared: &PreparedObject,
    strike: &FractureRequest,
    workspace: &mut Workspace,
    token: &CancelToken,
) -> Result<Vec<Trial>, FractureError> {
    let impact = ContactSet::new(prepared, strike)?;
    let solved = match strain_energy(RequestContext::new(prepared, strike, token, &()), &impact, workspace) {
        // Two contacts that cancel have no energy to compare.
        Err(FractureError::Balanced { .. }) => return Ok(Vec::new()),
        solved => solved?,
    };
    let mut trials = Vec::new();
    for (place, ((index, _), solved)) in impact.bodies.iter().zip(solved).enumerate() {
        let body = &prepared.bodies[*index];
        let solid = prepared.solid(*index)?;
        let Some(reduced) = prepared.basis(*index, strike.effects) else { continue };
        let held = prepared.held(strike.effects)?.and_then(|held| held.body(*index));
        let stiffness = held.map_or(&solid.elasticity, |own| &own.elasticity);
        let failed = |source| FractureError::of_body(*index, source);
        let unit_j = impact.unit_j(prepared);
        // The shares of an expanded displacement, its energy over the solved one, and the difference of their densities.
        let compared = |expanded: (&[f64], f64), energies: &mut Vec<f64>, scratch: &mut ElasticWorkspace| {
            let parts = (stiffness, &solid.lattice);
            let found = reduced.tet_energy(parts, expanded, DrivingEnergy::Total, (energies, scratch), token);
            found.map_err(failed)?;
            let mut shares = Vec::new();
            solid.transfer.apply(energies, &mut shares);
            let total: f64 = shares.iter().sum();
            let ratio = total * unit_j / solved.energy_j;
            let differences = shares.iter().zip(&solved.shares).map(|(own, true_)| (own / total * ratio - true_).abs());
            let density_error: f64 = differences.sum();
            shares.iter_mut().for_each(|share| *share /= total);
            Ok::<_, FractureError>((shares, ratio, density_error))
        };
        let Workspace { loads, displacement, coordinates, elasticity, tet_energy, .. } = workspace;
        let load = &mut loads[place];
        let energy = reduced.project(load, coordinates);
        let residual = reduced.residual(stiffness, load, coordinates, elasticity);
        reduced.expand(coordinates, displacement, elasticity);
        let (shares, ratio, density_error) = compared((displacement, energy), tet_energy, elasticity)?;
        let completed = reduced
            .complete(stiffness, load, coordinates, displacement, elasticity, token)
            .map_err(failed)?
            .map(|own| {
                let (_, ratio, density_error) = compared((displacement, own.energy), tet_energy, elasticity)?;
                let energy_error = (ratio - 1.0).abs();
                Ok::<_, FractureError>(CompletedTrial { gain: own.gain, energy_error, density_error })
            })
            .transpose()?;
        // Objects of scenes may lack the interior lift.
        let lift = body.lift(LiftKind::Interior).map_or_else(|| prepared.lift(*index, LiftKind::Euclidean), Ok)?;
        let [own, wanted] = [(shares, ratio), (solved.shares, 1.0)].map(|(mut shares, ratio)| {
            let field = EnergyField::new(lift, &body.volumes, &mut shares)
                .map_err(|source| FractureError::Field { body: *index, source })?;
            let unit = solved.energy_j * ratio * prepared.frame.diagonal_m.powi(2);
            Ok::<_, FractureError>(degree::closed_form(&field, &body.slenderness, prepared.gamma_j_m2 / unit))
        });
        trials.push(Trial {
            body: *index,
            fits: false,
            is_told: true,
            residual,
            energy_error: (ratio - 1.0).abs(),
            density_error,
            degree_error: (own? / wanted? - 1.0).abs(),
            completed,
        });
    }
    Ok(trials)
}

impl ReductionErrors {
    /// The figures of `trials`; `None` if empty.
    fn of(prepared: &PreparedObject, trials: &[Trial]) -> Option<Self> {
        let trials: Vec<&Trial> = trials.iter().filter(|trial| trial.is_told).collect();
        // The estimated and the true error, and whether a request would be solved.
        let estimates: Vec<(f64, f64, bool)> = trials
            .iter()
            .filter(|trial| !trial.fits)
            .filter_map(|trial| {
                let reduced = prepared.bodies[trial.body].reduced()?;
                let completed = trial.completed.as_ref().zip(reduced.completed_estimate());
                let completed = completed.map(|(own, estimate)| (estimate.error(own.gain), own.energy_error));
                let own = (reduced.estimate().error(trial.residual), trial.energy_error);
                let share = alone_share(prepared, reduced);
                let told = completed.filter(|_| share.is_none()).unwrap_or(own);
                let is_alone = share.is_some_and(|share| own.0 <= share * REDUCED_ERROR_MAX);
                let is_completed = completed.is_some_and(|completed| completed.0 <= REDUCED_ERROR_MAX);
                Some((told.0, told.1, !is_alone && !is_completed))
            })
            .collect();
        let share = |holds: &dyn Fn(&(f64, f64, bool)) -> bool| {
            estimates.iter().filter(|own| holds(own)).count() as f64 / estimates.len() as f64
        };
        Some(Self {
            rank: prepared.bodies.iter().map(|body| body.reduced().map_or(0, ReducedBasis::rank)).collect(),
            holdout: trials.len(),
            energy_error_median: quantile(&trials, 0.5, |trial| trial.energy_error)?,
            energy_error_p90: quantile(&trials, 0.9, |trial| trial.energy_error)?,
            density_error_median: quantile(&trials, 0.5, |trial| trial.density_error)?,
            degree_error_median: quantile(&trials, 0.5, |trial| trial.degree_error)?,
            estimates_within_3: share(&|(estimate, error, _)| (1.0 / 3.0..=3.0).contains(&(estimate / error))),
            solved: share(&|(.., is_solved)| *is_solved),
            completed: CompletionErrors::of(&trials),
        })
    }
}

impl CompletionErrors {
    /// The figures of the completed displacements of `trials`; `None` without any.
    fn of(trials: &[&Trial]) -> Option<Self> {
        let completed: Vec<&CompletedTrial> = trials.iter().filter_map(|trial| trial.completed.as_ref()).collect();
        Some(Self {
            energy_error_median: quantile(&completed, 0.5, |own| own.energy_error)?,
            energy_error_p90: quantile(&completed, 0.9, |own| own.energy_error)?,
            density_error_median: quantile(&completed, 0.5, |own| own.density_error)?,
        })
    }
}

/// The quantile `share` of `value`; `None` if empty.
fn quantile<T>(all: &[T], share: f64, value: impl Fn(&T) -> f64) -> Option<f64> {
    let mut sorted: Vec<f64> = all.iter().map(value).collect();
    sorted.sort_by(f64::total_cmp);
    sorted.get((sorted.len() as f64 * share) as usize).copied()
}

#[cfg(test)]
#[path = "reduce_tests.rs"]
mod tests;
