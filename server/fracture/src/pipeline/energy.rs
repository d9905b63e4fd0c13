//! Load and elasticity: from an impact to strain energy on the crack lattice's nodes.
//!
//! Based on: Schvartzman & Otaduy (I3D 2014), section 3: one quasi-static solve per impact; inertia relief, anchors and units
//! are ours. With diagonal L, modulus E and peak force F, energies in joules are F²/(E·L) times local ones.

use super::falloff::falloff;
use super::{
    AnchoredBody, ContactSet, ElasticModel, ElasticRequest, FractureError, PreparedObject, Stage, StageObserver,
    Workspace,
};
use crate::cancel_token::CancelToken;
use crate::elasticity::{DrivingEnergy, ElasticityError, NodalLoad, ReducedBasis};
use crate::scene::EffectKind;

/// Strain energy of one struck body.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyEnergy {
    /// Which body.
    pub body: usize,
    /// Share of the body's strain energy on each node of the crack lattice; sum 1.
    pub shares: Vec<f64>,
    /// The body's strain energy, J.
    pub energy_j: f64,
    /// Relative error of the energy, estimated, if the displacement is a reduced one; `None`: it was solved for.
    pub reduced_error: Option<f64>,
    /// Contact radius in effect, m: the largest of its contacts after raising them to what the lattice resolves.
    pub radius_m: f64,
}

impl BodyEnergy {
    /// Joule·meters² per unit of a local first moment of the shares: energy times the square of the diagonal.
    pub fn unit_j_m2(&self, diagonal_m: f64) -> f64 {
        self.energy_j * diagonal_m * diagonal_m
    }
}

/// The strain energy of every body that `impact` strikes: from its deformation, or a falloff where its effects do without.
pub fn strain_energy(
    prepared: &PreparedObject,
    impact: &ContactSet,
    workspace: &mut Workspace,
    token: &CancelToken,
    watch: &mut dyn StageObserver,
) -> Result<Vec<BodyEnergy>, FractureError> {
    apply(prepared, impact, workspace, watch)?;
    strain_energy_applied(prepared, impact, workspace, token, watch)
}

/// As [`strain_energy`], after [`apply`].
pub(super) fn strain_energy_applied(
    prepared: &PreparedObject,
    impact: &ContactSet,
    workspace: &mut Workspace,
    token: &CancelToken,
    watch: &mut dyn StageObserver,
) -> Result<Vec<BodyEnergy>, FractureError> {
    if impact.effects.has(EffectKind::Elastic) {
        return deformed(prepared, impact, workspace, token, watch);
    }
    watch.enter(Stage::Load);
    let energies = falloff(prepared, impact);
    let told = energies.iter().flatten().map(|energy| size_of_val(energy.shares.as_slice()) as u64);
    watch.leave(Stage::Load, told.sum());
    energies
}

/// What `impact` applies to every body that it strikes, into the workspace; none where its effects do without deformation.
pub(super) fn apply(
    prepared: &PreparedObject,
    impact: &ContactSet,
    workspace: &mut Workspace,
    watch: &mut dyn StageObserver,
) -> Result<(), FractureError> {
    if !impact.effects.has(EffectKind::Elastic) {
        return Ok(());
    }
    let held = prepared.held(impact.effects)?;
    let count = workspace.loads.len().max(impact.bodies.len());
    workspace.loads.resize_with(count, NodalLoad::default);
    for ((index, contacts), load) in impact.bodies.iter().zip(&mut workspace.loads) {
        let own = held.and_then(|held| held.body(*index));
        let elasticity = own.map_or(&prepared.solid(*index)?.elasticity, |own| &own.elasticity);
        watch.enter(Stage::Load);
        let touched = elasticity.touch(contacts, load, &mut workspace.elasticity);
        touched.map_err(|source| FractureError::of_body(*index, source))?;
        watch.leave(Stage::Load, size_of_val(load.applied.as_slice()) as u64);
    }
    Ok(())
}

/// The largest contact radius in effect under `load`, m.
pub(super) fn radius_m(prepared: &PreparedObject, load: &NodalLoad) -> f64 {
    load.touches.iter().map(|touch| touch.radius).fold(0.0, f64::max) * prepared.frame.diagonal_m
}

/// The energies of every body that `impact` strikes, under the workspace's loads.
fn deformed(
    prepared: &PreparedObject,
    impact: &ContactSet,
    workspace: &mut Workspace,
    token: &CancelToken,
    watch: &mut dyn StageObserver,
) -> Result<Vec<BodyEnergy>, FractureError> {
    let (unit_j, held) = (prepared.unit_j(impact), prepared.held(impact.effects)?);
    let mut energies = Vec::with_capacity(impact.bodies.len());
    for (place, (index, _)) in impact.bodies.iter().enumerate() {
        let (body, solid) = (&prepared.bodies[*index], prepared.solid(*index)?);
        let own = held.and_then(|held| held.body(*index));
        let elasticity = own.map_or(&solid.elasticity, |own| &own.elasticity);
        let failed = |source| FractureError::of_body(*index, source);
        watch.enter(Stage::Elasticity);
        let reduced_error = match own {
            Some(own) => displace_held(prepared, impact, own, place, workspace, token, watch).map(|()| None),
            None => displace(solid, impact, place, workspace, token),
        };
        let reduced_error = reduced_error.map_err(failed)?;
        watch.part(EffectKind::Elastic, size_of_val(workspace.displacement.as_slice()) as u64);
        let tensile = impact.effects.has(EffectKind::Tensile);
        let driving = if tensile { DrivingEnergy::Tensile } else { DrivingEnergy::Total };
        if tensile {
            watch.begin(EffectKind::Tensile);
        }
        elasticity
            .tet_energy(&solid.lattice, &workspace.displacement, driving, &mut workspace.tet_energy, token)
            .map_err(failed)?;
        if tensile {
            watch.end(EffectKind::Tensile, size_of_val(workspace.tet_energy.as_slice()) as u64);
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
        watch.leave(Stage::Elasticity, size_of_val(shares.as_slice()) as u64);
        energies.push(BodyEnergy {
            body: *index,
            shares,
            energy_j: total * unit_j,
            reduced_error,
            radius_m: radius_m(prepared, &workspace.loads[place]),
        });
    }
    Ok(energies)
}

/// A larger estimated error of the energy is worth a solve. The density is then off by some four times as much.
pub const REDUCED_ERROR_MAX: f64 = 0.02;

/// The displacement under load `place` of the workspace: from the reduced basis if that is asked for and all of it good enough, with the
/// estimated error of what is used of it, else from the solve.
fn displace(
    solid: &ElasticModel,
    impact: &ContactSet,
    place: usize,
    workspace: &mut Workspace,
    token: &CancelToken,
) -> Result<Option<f64>, ElasticityError> {
    let Workspace { loads, displacement, coordinates, elasticity, .. } = workspace;
    let load = &mut loads[place];
    if let (ElasticRequest::Reduced, Some(reduced)) = (impact.elastic, &solid.reduced) {
        reduced.project(load, coordinates);
        let error = reduced.estimate().error(reduced.residual(&solid.elasticity, load, coordinates, elasticity));
        if error <= impact.reduced_error_max {
            let used = reduced.used(impact.rank_max);
            reduced.expand(&coordinates[..used], displacement, elasticity);
            return Ok(Some(ReducedBasis::truncated_error(coordinates, used, error)));
        }
    }
    solid.elasticity.balance(load);
    solid.elasticity.solve(&load.forces, displacement, elasticity, token)?;
    Ok(None)
}

/// The displacement of a held body under load `place` of the workspace, and under its weight where that is asked for. Reduced bases are
/// those of free bodies: it is solved for.
fn displace_held(
    prepared: &PreparedObject,
    impact: &ContactSet,
    own: &AnchoredBody,
    place: usize,
    workspace: &mut Workspace,
    token: &CancelToken,
    watch: &mut dyn StageObserver,
) -> Result<(), ElasticityError> {
    let Workspace { loads, displacement, elasticity, .. } = workspace;
    own.elasticity.balance(&mut loads[place]);
    own.elasticity.solve(&loads[place].forces, displacement, elasticity, token)?;
    watch.part(EffectKind::Anchored, own.elasticity.own_bytes() as u64);
    if let Some(sag) = own.sag.as_ref().filter(|_| impact.effects.has(EffectKind::Gravity)) {
        watch.begin(EffectKind::Gravity);
        let unit = prepared.weight_unit(impact);
        displacement.iter_mut().zip(sag).for_each(|(u, w)| *u += unit * w);
        watch.end(EffectKind::Gravity, size_of_val(sag.as_slice()) as u64);
    }
    Ok(())
}
