//! Bound: how large E_1 can be under a load, before anything is solved for; where that is below γ the object stays whole.
//!
//! Based on: [`EigenvalueLowerBound`] for the energy, [`degree::reach`] for E_1 per energy; the bound is ours.
//!
//! With ρ² the reach of the lift and U_d the energy that drives cracks, all of U or its tensile part, E_1 ≤ ρ²U_d ≤ ρ²U ≤ ρ²·½f'W⁻¹f/σ:
//! the transfer to the crack lattice keeps sums. That is for K u = f. What a strike has instead of u leaves a residual r, and
//! √(½u'Ku) is a norm of f − r, in equilibrium as f is: at most (1 + |r|/|f|)² times the bound, with |·|² = (·)'W⁻¹(·). [`SLACK`]
//! is more than residuals that pass for a solution can be worth, and than rounding. A reduced displacement is a projection: its
//! energy is no more than U.

use super::object::{PreparedBody, PreparedObject};
use super::parameters::ElasticRequest;
use crate::cancel_token::{CancelToken, Cancelled};
use crate::degree;
use crate::elasticity::{EigenvalueLowerBound, Elasticity, ElasticityError};
use crate::lift::LiftKind;
use std::ops::RangeInclusive;

/// Told on top of every bound, relative.
const SLACK: f64 = 0.01;

/// Lifts in the order of their reaches.
const LIFTS: [LiftKind; 3] = [LiftKind::Euclidean, LiftKind::Interior, LiftKind::SurfaceDiffusion];

/// What stands for a reach that is not known: the body has no such lift.
const UNKNOWN: f64 = 0.0;

/// What bounds E_1 of a free body.
#[derive(Clone, Debug, PartialEq)]
pub struct EnergyUpperBound {
    floor: EigenvalueLowerBound,
    /// In the order of [`LIFTS`]; local length squared.
    reaches: [f64; 3],
}

impl EnergyUpperBound {
    /// That of `body`; `None` without elasticity, or where its stiffness has no bound.
    ///
    /// # Errors
    /// [`Cancelled`].
    fn of(body: &PreparedBody, token: &CancelToken) -> Result<Option<Self>, Cancelled> {
        let Some(solid) = &body.solid else { return Ok(None) };
        match EigenvalueLowerBound::of(&solid.elasticity, token) {
            Err(ElasticityError::Cancelled(cancelled)) => Err(cancelled),
            // Whatever else fails is told to whoever strikes it.
            Err(_) | Ok(None) => Ok(None),
            Ok(Some(floor)) => {
                let reaches = LIFTS.map(|kind| body.lift(kind).map_or(UNKNOWN, degree::reach));
                Ok(Some(Self { floor, reaches }))
            }
        }
    }

    /// From what [`Self::values`] said of the body.
    pub fn stored(elasticity: &Elasticity, [floor, reaches @ ..]: [f64; 4]) -> Self {
        Self { floor: EigenvalueLowerBound::stored(elasticity, floor), reaches }
    }

    /// What [`Self::values`] of `body` lie within; `None` for a body without elasticity. A lift that is not there bounds nothing.
    pub fn ranges(body: &PreparedBody) -> Option<[RangeInclusive<f64>; 4]> {
        let floor = f64::MIN_POSITIVE..=(1.0 + SLACK) * EigenvalueLowerBound::most(&body.solid.as_ref()?.elasticity);
        let reach = |kind| body.lift(kind).map_or(UNKNOWN..=f64::MAX, degree::reach_range);
        let [euclidean, interior, surface_diffusion] = LIFTS.map(reach);
        Some([floor, euclidean, interior, surface_diffusion])
    }

    /// The floor, positive, and the reaches in the lifts `euclidean`, `interior` and `surface_diffusion`, zero where there is none.
    pub fn values(&self) -> [f64; 4] {
        let [euclidean, interior, surface_diffusion] = self.reaches;
        [self.floor.value(), euclidean, interior, surface_diffusion]
    }

    /// At least E_1 under `forces`, local; `None` where the lift's reach is not known.
    pub(in crate::pipeline) fn first_moment(&self, kind: LiftKind, forces: &[f64]) -> Option<f64> {
        let reach = LIFTS.iter().zip(self.reaches).find(|(own, _)| **own == kind).map(|(_, reach)| reach);
        reach.filter(|reach| *reach != UNKNOWN).map(|reach| (1.0 + SLACK) * reach * self.floor.energy(forces))
    }

    /// Bytes that it holds.
    pub fn bytes(&self) -> usize {
        self.floor.bytes()
    }
}

impl PreparedObject {
    /// Finds the bounds of bodies that have none, if its strikes may do without a solve at all.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn bound(&mut self, token: &CancelToken) -> Result<(), Cancelled> {
        if self.parameters.elastic == ElasticRequest::Solve {
            return Ok(());
        }
        for body in self.bodies.iter_mut().filter(|body| body.bound.is_none()) {
            body.bound = EnergyUpperBound::of(body, token)?;
        }
        Ok(())
    }
}
