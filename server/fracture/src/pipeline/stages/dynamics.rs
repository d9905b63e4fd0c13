//! Deformation of bodies under pulses, with the effect `dynamics`.
//!
//! Contacts of one duration τ have the forces f_g s_g(t), s_g = sin(πt/τ) until τ. At the time t* of the largest energy, the
//! coordinates of the body in its reduced basis B are those of undamped vibrations, c. Whatever is outside the span of B
//! follows the forces f' = Σ s_g(t*) f_g as in statics. So the displacement is the static one under f', plus B(c − B'f').
//! What is static outside the span is orthogonal to it in stiffness, so that energies add.
//!
//! Based on: module `modes` of [`crate::elasticity`]; the sum of both parts is the method of mode acceleration (R. R.
//! Craig & A. J. Kurdila, *Fundamentals of Structural Dynamics*, 2006, chapter 11). Its use with a basis of snapshots,
//! and one time for the whole body, are ours.

use super::contact_set::ContactSet;
use super::strain::{StrainEnergy, alone_error_max, spread_min};
use crate::cancel_token::CancelToken;
use crate::elasticity::{
    ContactLoad, ElasticWorkspace, Elasticity, ElasticityError, ModalResponse, NodalLoad, Pulse, PulseLoad,
    ReducedBasis, ReducedModes,
};
use crate::pipeline::error::FractureError;
use crate::pipeline::prepared::object::PreparedObject;
use crate::pipeline::prepared::parameters::DisplacementMethod;
use crate::pipeline::request::context::RequestContext;
use crate::pipeline::request::fracture_request::FractureRequest;
use crate::pipeline::workspace::Workspace;
use crate::scene::{EffectKind, EffectSet};

/// Refuses a request with the effect `dynamics` that strikes a body without vibrations, or that adds a weight.
///
/// # Errors
/// [`FractureError::DynamicsGravity`], [`FractureError::DynamicsUnprepared`],
/// [`FractureError::DynamicsAnchorsUnprepared`].
pub(super) fn check(prepared: &PreparedObject, effects: EffectSet, contacts: &ContactSet) -> Result<(), FractureError> {
    if !effects.has(EffectKind::Dynamics) {
        return Ok(());
    }
    if effects.has(EffectKind::Gravity) {
        return Err(FractureError::DynamicsGravity);
    }
    contacts.bodies.iter().try_for_each(|(body, _)| vibrations(prepared, *body, effects).map(|_| ()))
}

/// The basis of body `body` under `effects`, and its vibrations.
fn vibrations(
    prepared: &PreparedObject,
    body: usize,
    effects: EffectSet,
) -> Result<(&ReducedBasis, &ReducedModes), FractureError> {
    let found = prepared.basis(body, effects).and_then(|basis| Some((basis, basis.modes()?)));
    found.ok_or(match effects.has(EffectKind::Anchored) {
        true => FractureError::DynamicsAnchorsUnprepared { body },
        false => FractureError::DynamicsUnprepared { body },
    })
}

/// Contacts of one body by the durations of their pulses.
struct PulseGroups {
    /// Pulses in units of the body's local time, each of another duration.
    pulses: Vec<Pulse>,
    /// Pulse of every contact.
    of_contact: Vec<usize>,
}

impl PulseGroups {
    /// Groups of contacts with these durations, s, in the order of the first contact of each.
    fn new(durations_s: &[f64], times_per_s: f64) -> Self {
        let mut known: Vec<f64> = Vec::new();
        let mut group = |duration_s: &f64| {
            known.iter().position(|own| own == duration_s).unwrap_or_else(|| {
                known.push(*duration_s);
                known.len() - 1
            })
        };
        let of_contact = durations_s.iter().map(&mut group).collect();
        let pulses = known.iter().map(|duration_s| Pulse { duration: duration_s * times_per_s }).collect();
        Self { pulses, of_contact }
    }

    /// The contacts of one group.
    fn contacts(&self, group: usize, contacts: &[ContactLoad]) -> Vec<ContactLoad> {
        let own = contacts.iter().zip(&self.of_contact).filter(|(_, own)| **own == group);
        own.map(|(contact, _)| *contact).collect()
    }

    /// The contacts with the forces of their groups, over those at the peak.
    fn scaled(&self, forces: &[f64], contacts: &[ContactLoad]) -> Vec<ContactLoad> {
        let own = contacts.iter().zip(&self.of_contact);
        own.map(|(contact, group)| ContactLoad { impulse: contact.impulse * forces[*group], ..*contact }).collect()
    }
}

/// One body and how the request strikes it.
struct StruckBody<'a> {
    elasticity: &'a Elasticity,
    basis: &'a ReducedBasis,
    request: &'a FractureRequest,
    /// See [`alone_error_max`].
    alone_error_max: Option<f64>,
    cancel: &'a CancelToken,
}

/// Computes the displacement of a body under the pulses of its contacts, at the time of its largest energy.
///
/// Load `place` of the workspace holds the peak forces of all contacts, and then their forces at that time.
///
/// # Errors
/// [`FractureError::DynamicsUnprepared`], [`FractureError::Elasticity`], [`FractureError::Canceled`].
pub(super) fn displace_dynamic(
    context: RequestContext<'_>,
    contacts: &ContactSet,
    place: usize,
    workspace: &mut Workspace,
) -> Result<StrainEnergy, FractureError> {
    let RequestContext { prepared, request, cancel, observer } = context;
    let (body, own) = &contacts.bodies[place];
    let held = prepared.held(request.effects)?.and_then(|held| held.body(*body));
    let stiffness = held.map_or(&prepared.solid(*body)?.elasticity, |own| &own.elasticity);
    let (basis, modes) = vibrations(prepared, *body, request.effects)?;
    let failed = |source| FractureError::of_body(*body, source);
    let alone_error_max = alone_error_max(prepared, basis, request);
    let struck = StruckBody { elasticity: stiffness, basis, request, alone_error_max, cancel };
    let effect = observer.effect(EffectKind::Dynamics);
    let groups = PulseGroups::new(&contacts.durations_s[place], ContactSet::times_per_s(prepared));
    let spread_min = spread_min(Some(basis), request);
    let Workspace { loads, elasticity, .. } = workspace;
    let (response, missed) =
        struck.respond(modes, (&groups, own, spread_min), &loads[place], elasticity).map_err(failed)?;
    let scaled = groups.scaled(&response.forces, own);
    stiffness.touch_checked(&scaled, spread_min, &mut loads[place], elasticity).map_err(failed)?;
    effect.produced(&response.coordinates);
    let strained = struck.displace(&response, place, workspace).map_err(failed)?;
    let lost = missed.after(struck.at_rest(&response, place, workspace)) / ReducedBasis::energy(&response.coordinates);
    Ok(StrainEnergy { reduced_error: strained.reduced_error.map(|error| error + lost), ..strained })
}

/// Energy that a basis misses at rest under the peak forces.
struct MissedEnergy {
    /// Missed energy over that in the basis.
    share: f64,
    /// Energy in the basis.
    at_peak: f64,
}

impl MissedEnergy {
    /// Missed energy that the forces no longer hold where those in the basis have this energy at rest.
    ///
    /// Whatever the basis misses vibrates as well, but is taken to follow the forces. So this part is not in the result.
    fn after(&self, at_rest: f64) -> f64 {
        self.share * (self.at_peak - at_rest).max(0.0)
    }
}

impl StruckBody<'_> {
    /// The response to the contacts of all groups, whose peak forces together are `load`, and what the basis misses of that.
    fn respond(
        &self,
        modes: &ReducedModes,
        (groups, contacts, spread_min): (&PulseGroups, &[ContactLoad], f64),
        load: &NodalLoad,
        workspace: &mut ElasticWorkspace,
    ) -> Result<(ModalResponse, MissedEnergy), ElasticityError> {
        let mut whole = Vec::new();
        let at_peak = self.basis.project(load, &mut whole);
        // Contacts that cancel have no energy at rest.
        let missed = Some(self.missed(load, &whole, workspace)).filter(|missed| missed.is_finite()).unwrap_or(0.0);
        let mut coordinates = vec![whole];
        if groups.pulses.len() > 1 {
            let mut own = NodalLoad::default();
            coordinates.clear();
            for group in 0..groups.pulses.len() {
                let contacts = groups.contacts(group, contacts);
                self.elasticity.touch_checked(&contacts, spread_min, &mut own, workspace)?;
                let mut projected = Vec::new();
                self.basis.project(&own, &mut projected);
                coordinates.push(projected);
            }
        }
        let loads = groups.pulses.iter().zip(&coordinates);
        let loads: Vec<PulseLoad<'_>> =
            loads.map(|(pulse, own)| PulseLoad { pulse: *pulse, coordinates: own }).collect();
        Ok((modes.respond(&loads, missed), MissedEnergy { share: missed, at_peak }))
    }

    /// Energy in the basis at rest under the forces at the time of `response`, those of load `place`.
    fn at_rest(&self, response: &ModalResponse, place: usize, workspace: &mut Workspace) -> f64 {
        match response.forces.iter().all(|force| *force == 0.0) {
            true => 0.0,
            false => self.basis.project(&workspace.loads[place], &mut workspace.coordinates),
        }
    }

    /// Estimated energy that the basis misses under `load`, over that of its displacement with these coordinates; not finite
    /// without energy.
    fn missed(&self, load: &NodalLoad, coordinates: &[f64], workspace: &mut ElasticWorkspace) -> f64 {
        self.basis.estimate().error(self.basis.residual(self.elasticity, load, coordinates, workspace))
    }

    /// Computes the displacement under load `place` with the coordinates of `response`.
    ///
    /// As without dynamics, uses the basis, the basis completed by a linear solve, or a solve. The error that decides is the
    /// static energy that is missed, over the energy of the response.
    fn displace(
        &self,
        response: &ModalResponse,
        place: usize,
        workspace: &mut Workspace,
    ) -> Result<StrainEnergy, ElasticityError> {
        let is_reduced = self.request.elastic == DisplacementMethod::Reduced;
        if response.forces.iter().all(|force| *force == 0.0) {
            // Contacts that are over leave no static part.
            let expanded = self.expand(response, 0.0, workspace);
            return Ok(StrainEnergy { reduced_error: expanded.reduced_error.filter(|_| is_reduced), ..expanded });
        }
        let Workspace { loads, coordinates, elasticity, .. } = workspace;
        let at_rest = self.basis.project(&loads[place], coordinates);
        if is_reduced {
            let dynamic = ReducedBasis::energy(&response.coordinates);
            let missed = self.missed(&loads[place], coordinates, elasticity) * at_rest / dynamic;
            if self.alone_error_max.is_some_and(|most| missed <= most) {
                return Ok(self.expand(response, missed, workspace));
            }
        }
        let moved = response.coordinates.iter().zip(&*coordinates).map(|(own, at_rest)| own - at_rest).collect();
        let moved = MovedBasis { response, moved, at_rest };
        if is_reduced && let Some(completed) = self.complete(&moved, place, workspace)? {
            return Ok(completed);
        }
        self.solve(&moved, place, workspace)
    }

    /// The displacement in the span of the basis, which misses a share of the energy.
    fn expand(&self, response: &ModalResponse, missed: f64, workspace: &mut Workspace) -> StrainEnergy {
        let Workspace { displacement, elasticity, .. } = workspace;
        let is_reduced = self.request.elastic == DisplacementMethod::Reduced;
        let used = if is_reduced { self.basis.used(self.request.rank_max) } else { self.basis.rank() };
        self.basis.expand(&response.coordinates[..used], displacement, elasticity);
        let error = ReducedBasis::truncated_error(&response.coordinates, used, missed);
        let energy = ReducedBasis::energy(&response.coordinates[..used]);
        StrainEnergy { energy, reduced_error: Some(error), is_expanded: true, completion: None }
    }

    /// The displacement completed by a linear solve; `None` if the basis has no data for it, or its error is too large.
    fn complete(
        &self,
        moved: &MovedBasis<'_>,
        place: usize,
        workspace: &mut Workspace,
    ) -> Result<Option<StrainEnergy>, ElasticityError> {
        let Workspace { loads, displacement, coordinates, elasticity, .. } = workspace;
        let (body, load) = (self.elasticity, &mut loads[place]);
        let completed = self.basis.complete(body, load, coordinates, displacement, elasticity, self.cancel)?;
        let Some(completed) = completed else { return Ok(None) };
        let energy = moved.energy(completed.energy);
        let error = completed.error * completed.energy / energy;
        let is_accurate = error <= self.request.reduced_error_max;
        if is_accurate {
            self.basis.superpose(&moved.moved, displacement, elasticity);
        }
        let completion = Some(completed.shares());
        Ok(is_accurate.then_some(StrainEnergy { energy, reduced_error: Some(error), is_expanded: true, completion }))
    }

    /// The displacement that was solved for, moved in the span of the basis.
    fn solve(
        &self,
        moved: &MovedBasis<'_>,
        place: usize,
        workspace: &mut Workspace,
    ) -> Result<StrainEnergy, ElasticityError> {
        let Workspace { loads, displacement, elasticity, .. } = workspace;
        let (body, load) = (self.elasticity, &mut loads[place]);
        body.balance(load);
        body.solve(&load.forces, displacement, elasticity, self.cancel)?;
        let energy = moved.energy(body.elastic_energy(&load.forces, displacement));
        self.basis.superpose_on_solution(body, &moved.moved, displacement, elasticity);
        Ok(StrainEnergy { energy, reduced_error: None, is_expanded: true, completion: None })
    }
}

/// Response in the span of a basis, beside the displacement at rest under the same forces.
struct MovedBasis<'a> {
    response: &'a ModalResponse,
    /// Coordinates of the response less those at rest.
    moved: Vec<f64>,
    /// Energy at rest in the span.
    at_rest: f64,
}

impl MovedBasis<'_> {
    /// Energy of the response with the static remainder of a displacement whose energy at rest is `whole`.
    fn energy(&self, whole: f64) -> f64 {
        // A projection has no more energy; an approximate solution may have less by its tolerance.
        ReducedBasis::energy(&self.response.coordinates) + (whole - self.at_rest).max(0.0)
    }
}
