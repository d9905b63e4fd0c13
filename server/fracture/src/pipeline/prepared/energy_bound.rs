//! Upper bound of E_1 under a load, without a solve. If it is below γ, the object stays intact.
//!
//! Based on: [`EigenvalueLowerBound`] for the energy and [`degree::reach`] for E_1 per unit of energy; the combination
//! is ours.
//!
//! Let ρ² be the first-moment bound of the lift ([`degree::reach`]), and U_d the energy that drives cracks (all of U,
//! or its tensile part). Then E_1 ≤ ρ²U_d ≤ ρ²U ≤ ρ²·½f'W⁻¹f/σ. The transfer to the crack lattice preserves the sum
//! of the energies.
//!
//! The energy of the near field adds to U.
//!
//! This holds for K u = f. A computed u has a residual r, and solves the load f − r exactly, which is in equilibrium
//! like f. Its energy is therefore at most (1 + |r|/|f|)² times the bound, with |·|² = (·)'W⁻¹(·). [`SLACK`] exceeds
//! the effect of rounding and of any residual that is accepted as a solution. A reduced displacement is a projection,
//! so its energy is at most U.

use super::object::{PreparedBody, PreparedObject};
use super::parameters::DisplacementMethod;
use crate::cancel_token::{CancelToken, Canceled};
use crate::degree;
use crate::elasticity::{EigenvalueLowerBound, Elasticity, ElasticityError, NodalLoad};
use crate::lift::LiftKind;
use std::ops::RangeInclusive;

/// Relative margin added to every bound.
const SLACK: f64 = 0.01;

/// Lifts in the order of [`EnergyUpperBound::values`].
const LIFTS: [LiftKind; 3] = [LiftKind::Euclidean, LiftKind::Interior, LiftKind::SurfaceDiffusion];

/// Marks the first-moment bound of a lift that the body does not have.
const UNKNOWN: f64 = 0.0;

/// Upper bound of E_1 of a free body.
#[derive(Clone, Debug, PartialEq)]
pub struct EnergyUpperBound {
    floor: EigenvalueLowerBound,
    /// First-moment bounds in the order of [`LIFTS`], local length squared.
    reaches: [f64; 3],
}

impl EnergyUpperBound {
    /// The bound of `body`; `None` without elasticity, or if its stiffness has no eigenvalue bound.
    ///
    /// # Errors
    /// [`Canceled`].
    fn of(body: &PreparedBody, token: &CancelToken) -> Result<Option<Self>, Canceled> {
        let Some(solid) = &body.solid else { return Ok(None) };
        match EigenvalueLowerBound::of(&solid.elasticity, token) {
            Err(ElasticityError::Canceled(canceled)) => Err(canceled),
            // Other errors recur in, and are reported by, the request that strikes the body.
            Err(_) | Ok(None) => Ok(None),
            Ok(Some(floor)) => {
                let reaches = LIFTS.map(|kind| body.lift(kind).map_or(UNKNOWN, degree::reach));
                Ok(Some(Self { floor, reaches }))
            }
        }
    }

    /// The bound from stored [`Self::values`].
    pub fn stored(elasticity: &Elasticity, [floor, reaches @ ..]: [f64; 4]) -> Self {
        Self { floor: EigenvalueLowerBound::stored(elasticity, floor), reaches }
    }

    /// Valid ranges of [`Self::values`] of `body`; `None` for a body without elasticity. A missing lift leaves its
    /// value unbounded.
    pub fn ranges(body: &PreparedBody) -> Option<[RangeInclusive<f64>; 4]> {
        let floor = f64::MIN_POSITIVE..=(1.0 + SLACK) * EigenvalueLowerBound::most(&body.solid.as_ref()?.elasticity);
        let reach = |kind| body.lift(kind).map_or(UNKNOWN..=f64::MAX, degree::reach_range);
        let [euclidean, interior, surface_diffusion] = LIFTS.map(reach);
        Some([floor, euclidean, interior, surface_diffusion])
    }

    /// The eigenvalue bound, positive, and the first-moment bounds of the lifts `euclidean`, `interior` and
    /// `surface_diffusion`; 0 without the lift.
    pub fn values(&self) -> [f64; 4] {
        let [euclidean, interior, surface_diffusion] = self.reaches;
        [self.floor.value(), euclidean, interior, surface_diffusion]
    }

    /// Upper bound of E_1 under `load`, which is balanced, local; `None` if the lift's first-moment bound is unknown.
    pub(in crate::pipeline) fn first_moment(&self, kind: LiftKind, load: &NodalLoad) -> Option<f64> {
        let energy = self.floor.energy(&load.forces) + load.near_energy();
        let reach = LIFTS.iter().zip(self.reaches).find(|(own, _)| **own == kind).map(|(_, reach)| reach);
        reach.filter(|reach| *reach != UNKNOWN).map(|reach| (1.0 + SLACK) * reach * energy)
    }

    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        self.floor.bytes()
    }
}

impl PreparedObject {
    /// Computes missing bounds of the bodies, unless every request is solved.
    ///
    /// # Errors
    /// [`Canceled`].
    pub fn bound(&mut self, token: &CancelToken) -> Result<(), Canceled> {
        if self.parameters.elastic == DisplacementMethod::Solve {
            return Ok(());
        }
        for body in self.bodies.iter_mut().filter(|body| body.bound.is_none()) {
            body.bound = EnergyUpperBound::of(body, token)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use crate::BakeRequest;
    use crate::pipeline::{ElementChoice, FractureRequest, RequestContext, Workspace, strike};
    use crate::scene::Material;
    use crate::surface::shapes;
    use nalgebra::{Point3, Vector3};

    /// Impulses at a plate, by their share of the one that just breaks it.
    #[test]
    fn weak_impacts_on_quadratic_elements_end_without_a_solve() {
        let request = BakeRequest {
            elastic_spacing: Some(0.06),
            crack_spacing: Some(0.06),
            elements: ElementChoice::Quadratic,
            ..BakeRequest::new("plate", "glass", Material::named("glass").unwrap())
        };
        let plate = request.bake(shapes::cuboid([0.4, 0.3, 0.05])).unwrap();
        let found = |request: &FractureRequest| {
            let token = Default::default();
            let context = RequestContext::new(&plate, request, &token, &());
            strike(context, &mut Workspace::default()).unwrap()
        };
        let contact = FractureRequest::at(Point3::new(0.07, 0.05, 0.025), -Vector3::z()).seeded(1);
        let exact = found(&FractureRequest { threshold_only: true, ..contact.clone() });
        assert!(!exact.threshold().is_bound);
        for (share, is_bound) in [(0.001, true), (0.01, true), (0.5, false)] {
            let mut request = contact.clone();
            request.contacts[0].impulse_ns *= share * exact.threshold().impulse_factor;
            let own = found(&request);
            let (e1, squared) = (own.threshold().e1_over_gamma, share * share);
            println!("{share} of the threshold: E_1 is {:.1} times that of a solve", e1 / squared);
            assert_eq!(own.threshold().is_bound, is_bound, "{share}");
            assert!(own.meshes().is_none() && (!is_bound || e1 >= squared), "{e1} of {squared}");
        }
    }
}
