//! Load and elasticity stages: strain energy on the crack lattice's nodes.
//!
//! Based on: Schvartzman & Otaduy (I3D 2014), section 3: one quasi-static solve per impact. Inertia relief, anchors and
//! units are ours. With diagonal L, modulus E and peak force F, energies in joules are F²/(E·L) times local ones.

use super::contact_set::ContactSet;
use super::dynamics;
use super::falloff::falloff;
use super::indentation::IndentationEnergy;
use super::onset::{StressPeak, StressedBody};
use super::strain::{
    StrainEnergy, WEAK_ERROR_MAX, WEAK_ERROR_RATIO, WEAK_STRESS, alone_error_max, may_be_weak, spread_min,
};
use crate::cancel_token::CancelToken;
use crate::elasticity::{CompletedEnergy, DrivingEnergy, Elasticity, ElasticityError, NodalLoad, ReducedBasis};
use crate::lattice::Lattice;
use crate::pipeline::error::FractureError;
use crate::pipeline::prepared::anchored::{AnchoredBody, Weight};
use crate::pipeline::prepared::object::{ElasticModel, PreparedObject};
use crate::pipeline::prepared::parameters::DisplacementMethod;
use crate::pipeline::request::context::RequestContext;
use crate::pipeline::request::fracture_request::FractureRequest;
use crate::pipeline::request::stage::Stage;
use crate::pipeline::workspace::Workspace;
use crate::scene::EffectKind;
use crate::strength::{Criterion, Deformation};
use nalgebra::Vector3;

/// Strain energy of one struck body.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyEnergy {
    /// Index of the body.
    pub body: usize,
    /// Share of [`Self::energy_j`] on each node of the crack lattice; sum 1. Empty once the threshold test has
    /// moved them into an energy density field.
    pub shares: Vec<f64>,
    /// Strain energy that drives cracks, J: with the effect `tensile` and by the criterion of strength a part of
    /// [`Self::strain_j`].
    pub energy_j: f64,
    /// Strain energy of the whole body under all its loads, J; `None` without a displacement.
    pub strain_j: Option<f64>,
    /// Energies of the indentations of its contacts under the requested load, whatever factor lowers it.
    pub indentation: IndentationEnergy,
    /// Largest stresses, with the criterion by strength.
    pub peaks: Vec<StressPeak>,
    /// Estimated relative error of the energy if the displacement is a reduced one; `None` if it was solved for.
    pub reduced_error: Option<f64>,
    /// Largest effective contact radius of the body, m: that whose energy was computed.
    pub radius_m: f64,
}

impl BodyEnergy {
    /// J·m² per unit of a local first moment of the shares: energy times the squared diagonal.
    pub fn unit_j_m2(&self, diagonal_m: f64) -> f64 {
        self.energy_j * diagonal_m * diagonal_m
    }

    /// Multiplies all loads by `factor`.
    pub(in crate::pipeline) fn scale(&mut self, factor: f64) {
        self.energy_j *= factor * factor;
        self.strain_j = self.strain_j.map(|strain_j| strain_j * factor * factor);
        self.peaks.iter_mut().for_each(|peak| peak.stress_over_strength *= factor);
    }
}

/// The strain energy of every body that `contacts` strike: from its deformation, or from a falloff without the effect
/// `elastic`.
///
/// # Errors
/// [`FractureError`], naming the body.
pub fn strain_energy(
    context: RequestContext<'_>,
    contacts: &ContactSet,
    workspace: &mut Workspace,
) -> Result<Vec<BodyEnergy>, FractureError> {
    apply(context, contacts, workspace)?;
    strain_energy_applied(context, contacts, workspace)
}

/// As [`strain_energy`], after [`apply`].
pub(in crate::pipeline) fn strain_energy_applied(
    context: RequestContext<'_>,
    contacts: &ContactSet,
    workspace: &mut Workspace,
) -> Result<Vec<BodyEnergy>, FractureError> {
    if context.request.effects.has(EffectKind::Elastic) {
        return deformed(context, contacts, workspace);
    }
    let load = context.observer.stage(Stage::Load);
    let energies = falloff(context.prepared, contacts)?;
    load.produced_bytes(energies.iter().map(|energy| size_of_val(energy.shares.as_slice()) as u64).sum());
    Ok(energies)
}

/// Writes the forces of `contacts` on every struck body into the workspace; nothing without the effect `elastic`.
pub(in crate::pipeline) fn apply(
    context: RequestContext<'_>,
    contacts: &ContactSet,
    workspace: &mut Workspace,
) -> Result<(), FractureError> {
    let RequestContext { prepared, request, observer, .. } = context;
    if !request.effects.has(EffectKind::Elastic) {
        return Ok(());
    }
    dynamics::check(prepared, request.effects, contacts)?;
    let held = prepared.held(request.effects)?;
    let count = workspace.loads.len().max(contacts.bodies.len());
    workspace.loads.resize_with(count, NodalLoad::default);
    for ((index, contacts), load) in contacts.bodies.iter().zip(&mut workspace.loads) {
        let own = held.and_then(|held| held.body(*index));
        let elasticity = own.map_or(&prepared.solid(*index)?.elasticity, |own| &own.elasticity);
        let stage = observer.stage(Stage::Load);
        let spread_min = spread_min(prepared.basis(*index, request.effects), request);
        let touched = elasticity.touch(contacts, spread_min, load, &mut workspace.elasticity);
        touched.map_err(|source| FractureError::of_body(*index, source))?;
        stage.produced(&load.applied);
    }
    Ok(())
}

/// The largest effective contact radius under `load`, m.
pub(in crate::pipeline) fn radius_m(prepared: &PreparedObject, load: &NodalLoad) -> f64 {
    load.touches.iter().map(|touch| touch.radius).fold(0.0, f64::max) * prepared.frame.diagonal_m
}

/// The energies of every struck body under the loads in the workspace.
fn deformed(
    context: RequestContext<'_>,
    contacts: &ContactSet,
    workspace: &mut Workspace,
) -> Result<Vec<BodyEnergy>, FractureError> {
    let RequestContext { prepared, request, cancel, observer } = context;
    let (unit_j, held) = (contacts.unit_j(prepared), prepared.held(request.effects)?);
    let mut energies = Vec::with_capacity(contacts.bodies.len());
    let poisson = prepared.parameters.material.poisson;
    for (place, (index, contacts_of_body)) in contacts.bodies.iter().enumerate() {
        let (body, solid) = (&prepared.bodies[*index], prepared.solid(*index)?);
        let own = held.and_then(|held| held.body(*index));
        let elasticity = own.map_or(&solid.elasticity, |own| &own.elasticity);
        let basis = prepared.basis(*index, request.effects);
        let failed = |source| FractureError::of_body(*index, source);
        let stage = observer.stage(Stage::Elasticity);
        let weak = displace_weak(context, contacts, (solid, elasticity, basis), place, workspace)?;
        let (strained, known_peaks) = match (weak, own) {
            (Some((strained, peaks)), _) => (strained, Some(peaks)),
            _ if request.effects.has(EffectKind::Dynamics) => {
                (dynamics::displace_dynamic(context, contacts, place, workspace)?, None)
            }
            (None, Some(own)) => (displace_held(context, contacts, own, place, workspace)?, None),
            (None, None) => (displace((elasticity, basis), context, place, workspace).map_err(failed)?, None),
        };
        if let Some(own) = own {
            observer.part(EffectKind::Anchored, own.elasticity.own_bytes() as u64);
        }
        observer.part(EffectKind::Elastic, size_of_val(workspace.displacement.as_slice()) as u64);
        let tensile = request.effects.has(EffectKind::Tensile).then(|| observer.effect(EffectKind::Tensile));
        let used = basis.filter(|_| strained.is_expanded);
        let parts = (elasticity, used, &solid.lattice);
        let compressive = compressive_share(prepared, request);
        tet_energies(parts, strained.energy, compressive, place, workspace, cancel).map_err(failed)?;
        if let Some(tensile) = tensile {
            tensile.produced(&workspace.tet_energy);
        }
        let mut peaks = known_peaks.unwrap_or_default();
        if request.criterion == Criterion::Strength && peaks.is_empty() {
            let deformation = match used.is_some_and(ReducedBasis::has_node_strains) {
                true => Deformation::NodeStrains {
                    strains: &workspace.displacement,
                    completion: strained.completion.map(|shares| (workspace.elasticity.completion(), shares)),
                },
                false => Deformation::Displacement(&workspace.displacement),
            };
            let stressed = StressedBody { place, solid, elasticity, deformation, load: &workspace.loads[place] };
            peaks = stressed.peaks(context, contacts)?;
        }
        let mut shares = Vec::with_capacity(body.crack.nodes.len());
        solid.transfer.apply(&workspace.tet_energy, &mut shares);
        let total: f64 = shares.iter().sum();
        if total == 0.0 {
            return Err(FractureError::Balanced { body: *index });
        }
        if !total.is_finite() {
            return Err(FractureError::Range(total));
        }
        shares.iter_mut().for_each(|share| *share /= total);
        stage.produced(&shares);
        energies.push(BodyEnergy {
            body: *index,
            shares,
            energy_j: total * unit_j,
            strain_j: Some((strained.energy + workspace.loads[place].near_energy()) * unit_j),
            indentation: IndentationEnergy::new(contacts_of_body, &workspace.loads[place], poisson, unit_j),
            peaks,
            reduced_error: strained.reduced_error,
            radius_m: radius_m(prepared, &workspace.loads[place]),
        });
    }
    Ok(energies)
}

/// Share of the compressive energy that drives cracks: all by the criterion of the paper, none with the effect `tensile`.
///
/// By the criterion of strength, it is (σ_t/σ_c)²: as far from the strength, pulled and pressed matter drives cracks alike.
fn compressive_share(prepared: &PreparedObject, request: &FractureRequest) -> f64 {
    match request.criterion {
        _ if request.effects.has(EffectKind::Tensile) => 0.0,
        Criterion::Paper => 1.0,
        Criterion::Strength => {
            let constants = request.strength_constants(prepared);
            (constants.strength_pa / constants.compressive_strength_pa).powi(2)
        }
    }
}

/// Writes the energies that drive cracks, of the tetrahedra under load `place` of the workspace, with its near field: the
/// tensile ones, and the share `compressive` of the rest. The workspace has the displacement, as the basis expanded it if one
/// was used, and `energy` is its energy.
fn tet_energies(
    (elasticity, used, lattice): (&Elasticity, Option<&ReducedBasis>, &Lattice),
    energy: f64,
    compressive: f64,
    place: usize,
    workspace: &mut Workspace,
    cancel: &CancelToken,
) -> Result<(), ElasticityError> {
    let Workspace { displacement, tet_energy, tet_energy_total, loads, elasticity: scratch, .. } = workspace;
    let load = &loads[place];
    let mut fill = |driving: DrivingEnergy, tet_energy: &mut Vec<f64>| {
        match used {
            Some(basis) => {
                let reduced = (displacement.as_slice(), energy);
                basis.tet_energy((elasticity, lattice), reduced, driving, (tet_energy, scratch), cancel)
            }
            None => elasticity.tet_energy(lattice, displacement, driving, tet_energy, cancel),
        }?;
        Ok::<_, ElasticityError>(elasticity.near_field_sum(load, tet_energy))
    };
    if compressive == 1.0 {
        fill(DrivingEnergy::Total, tet_energy)?;
        elasticity.add_near_field(load, 1.0, tet_energy);
        return Ok(());
    }
    let is_needed = compressive > 0.0 || load.near_energy() > 0.0;
    let whole = if is_needed { fill(DrivingEnergy::Total, tet_energy_total)? } else { 0.0 };
    fill(DrivingEnergy::Tensile, tet_energy)?;
    if compressive > 0.0 {
        let both = tet_energy.iter_mut().zip(tet_energy_total.iter());
        both.for_each(|(own, total)| *own += compressive * (total - *own));
    }
    // The near field drives cracks to the share to which the tetrahedra do that it adds to.
    let own = elasticity.near_field_sum(load, tet_energy);
    elasticity.add_near_field(load, if whole > 0.0 { own / whole } else { 1.0 }, tet_energy);
    Ok(())
}

/// Computes the displacement under load `place` of the workspace by the basis alone, and its peak stresses, if they are far
/// below the strength. A linear solve would not change that the body holds, so that it is not completed.
///
/// `None` if they are not, or the request does not allow it.
fn displace_weak(
    context: RequestContext<'_>,
    contacts: &ContactSet,
    (solid, elasticity, basis): (&ElasticModel, &Elasticity, Option<&ReducedBasis>),
    place: usize,
    workspace: &mut Workspace,
) -> Result<Option<(StrainEnergy, Vec<StressPeak>)>, FractureError> {
    let RequestContext { prepared, request, .. } = context;
    // The energy of a body that holds counts in the load of another one that breaks.
    let is_alone = contacts.bodies.len() == 1;
    let Some(basis) = basis.filter(|_| is_alone && may_be_weak(request)) else { return Ok(None) };
    let Workspace { loads, displacement, coordinates, elasticity: scratch, .. } = workspace;
    if basis.project(&loads[place], coordinates) <= 0.0 {
        return Ok(None);
    }
    let error = basis.estimate().error(basis.residual(elasticity, &loads[place], coordinates, scratch));
    let is_served = alone_error_max(prepared, basis, request).is_none_or(|most| error <= most);
    let serves_weak = error <= WEAK_ERROR_MAX.min(WEAK_ERROR_RATIO * request.reduced_error_max);
    if is_served || !serves_weak {
        return Ok(None);
    }
    basis.expand(coordinates, displacement, scratch);
    let deformation = match basis.has_node_strains() {
        true => Deformation::NodeStrains { strains: displacement, completion: None },
        false => Deformation::Displacement(displacement),
    };
    let stressed = StressedBody { place, solid, elasticity, deformation, load: &loads[place] };
    let peaks = stressed.peaks(context, contacts)?;
    let is_weak = peaks.iter().all(|peak| peak.stress_over_strength < WEAK_STRESS);
    let energy = ReducedBasis::energy(coordinates);
    let strained = StrainEnergy { energy, reduced_error: Some(error), is_expanded: true, completion: None };
    Ok(is_weak.then_some((strained, peaks)))
}

/// Computes the displacement of a free body at rest under load `place` of the workspace: reduced if possible, else solved.
fn displace(
    (elasticity, basis): (&Elasticity, Option<&ReducedBasis>),
    context: RequestContext<'_>,
    place: usize,
    workspace: &mut Workspace,
) -> Result<StrainEnergy, ElasticityError> {
    if let Some(reduced) = displace_reduced((elasticity, basis), context, place, workspace)? {
        return Ok(reduced);
    }
    let Workspace { loads, displacement, elasticity: scratch, .. } = workspace;
    let load = &mut loads[place];
    elasticity.balance(load);
    elasticity.solve(&load.forces, displacement, scratch, context.cancel)?;
    let energy = elasticity.elastic_energy(&load.forces, displacement);
    Ok(StrainEnergy { energy, reduced_error: None, is_expanded: false, completion: None })
}

/// Computes the displacement under load `place` of the workspace by the basis, alone or completed by a linear solve.
///
/// `None` if the request does not allow it, there is no basis, or the whole basis is not accurate enough.
fn displace_reduced(
    (elasticity, basis): (&Elasticity, Option<&ReducedBasis>),
    RequestContext { prepared, request, cancel, .. }: RequestContext<'_>,
    place: usize,
    workspace: &mut Workspace,
) -> Result<Option<StrainEnergy>, ElasticityError> {
    let Some(basis) = basis.filter(|_| request.elastic == DisplacementMethod::Reduced) else { return Ok(None) };
    let Workspace { loads, displacement, coordinates, elasticity: scratch, .. } = workspace;
    let load = &mut loads[place];
    basis.project(load, coordinates);
    let error = basis.estimate().error(basis.residual(elasticity, load, coordinates, scratch));
    if alone_error_max(prepared, basis, request).is_some_and(|most| error <= most) {
        let used = basis.used(request.rank_max);
        basis.expand(&coordinates[..used], displacement, scratch);
        let reduced_error = Some(ReducedBasis::truncated_error(coordinates, used, error));
        let energy = ReducedBasis::energy(&coordinates[..used]);
        return Ok(Some(StrainEnergy { energy, reduced_error, is_expanded: true, completion: None }));
    }
    let completed = basis.complete(elasticity, load, coordinates, displacement, scratch, cancel)?;
    let accurate = completed.filter(|own| own.error <= request.reduced_error_max);
    let strained = |own: CompletedEnergy| {
        let (reduced_error, completion) = (Some(own.error), Some(own.shares()));
        StrainEnergy { energy: own.energy, reduced_error, is_expanded: true, completion }
    };
    Ok(accurate.map(strained))
}

/// Computes the displacement of an anchored body under load `place` of the workspace, and under its weight with the
/// effect `gravity`: reduced if possible, else solved.
///
/// # Errors
/// [`FractureError::Balanced`] where the contacts alone deform nothing: then no impulse could break the body, and its
/// weight is not what the request asks about.
fn displace_held(
    context: RequestContext<'_>,
    contacts: &ContactSet,
    own: &AnchoredBody,
    place: usize,
    workspace: &mut Workspace,
) -> Result<StrainEnergy, FractureError> {
    let RequestContext { prepared, request, observer, .. } = context;
    let body = contacts.bodies[place].0;
    let failed = |source| FractureError::of_body(body, source);
    let weight = own.weight.as_ref().filter(|_| request.effects.has(EffectKind::Gravity));
    let unit = contacts.weight_unit(prepared);
    let basis = own.reduced.as_deref();
    let Workspace { loads, coordinates, .. } = &mut *workspace;
    // Without energy, the contacts alone deform nothing.
    if basis.is_some_and(|basis| basis.project(&loads[place], coordinates) > 0.0) {
        if let Some(weight) = weight {
            loads[place].acceleration[0] = -unit * weight.gravity;
        }
        let parts = (&own.elasticity, basis);
        if let Some(reduced) = displace_reduced(parts, context, place, workspace).map_err(failed)? {
            weight.iter().for_each(|own| observer.part(EffectKind::Gravity, size_of_val(&own.gravity) as u64));
            return Ok(reduced);
        }
        let load = &mut workspace.loads[place];
        load.acceleration[0] = Vector3::zeros();
        load.forces.clear();
    }
    solve_held(context, own, (body, place), (weight, unit), workspace)
}

/// Solves for the displacement of an anchored body under load `place` of the workspace, and adds that under `unit` times
/// the weight of unit density.
fn solve_held(
    context: RequestContext<'_>,
    own: &AnchoredBody,
    (body, place): (usize, usize),
    (weight, unit): (Option<&Weight>, f64),
    workspace: &mut Workspace,
) -> Result<StrainEnergy, FractureError> {
    let RequestContext { cancel, observer, .. } = context;
    let Workspace { loads, displacement, elasticity, .. } = workspace;
    own.elasticity.balance(&mut loads[place]);
    let solved = own.elasticity.solve(&loads[place].forces, displacement, elasticity, cancel);
    solved.map_err(|source| FractureError::of_body(body, source))?;
    if displacement.iter().all(|component| *component == 0.0) {
        return Err(FractureError::Balanced { body });
    }
    let mut weight_energy = 0.0;
    if let Some(weight) = weight {
        let gravity = observer.effect(EffectKind::Gravity);
        displacement.iter_mut().zip(&weight.displacement).for_each(|(u, w)| *u += unit * w);
        weight_energy = unit * own.elasticity.elastic_energy(&own.elasticity.weight(&weight.gravity), displacement);
        gravity.produced(&weight.displacement);
    }
    let energy = own.elasticity.elastic_energy(&loads[place].forces, displacement) + weight_energy;
    Ok(StrainEnergy { energy, reduced_error: None, is_expanded: false, completion: None })
}
