//! What one strike asks for.

use super::budget::TimeBudget;
use super::solver_settings::{GAME_ERROR_MAX, GAME_TOLERANCE};
use crate::centroidal::ITERATIONS_MAX;
use crate::lift::{LiftKind, LiftedLattice};
use crate::pipeline::DEGREE_MAX;
use crate::pipeline::contact::ImpactContact;
use crate::pipeline::error::FractureError;
use crate::pipeline::prepared::object::PreparedObject;
use crate::pipeline::prepared::parameters::ElasticRequest;
use crate::pipeline::prepared::warped_body::WarpedBody;
use crate::scene::{EffectKind, EffectSet};
use nalgebra::{Point3, Vector3};

/// Seed of a strike that names none; the same as in the client (a test of `shatter-server` compares them).
pub const SEED_DEFAULT: u64 = 0;

/// Where the number of sites comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DegreeRequest {
    /// This many sites, at least 1.
    Sites(u32),
    /// The calibrated closed form.
    ClosedForm,
    /// What the object has learned from its examples; the closed form where they do not reach.
    Inferred,
    /// The inferred number, made to hold: the smallest near it that passes γ.
    Verified,
    /// The full optimisation: the first n at which the running minimum of E_max(n) passes γ.
    Optimised,
}

/// One request.
#[derive(Clone, Debug, PartialEq)]
pub struct FractureRequest {
    /// At least one contact.
    pub contacts: Vec<ImpactContact>,
    /// Where the number of sites comes from.
    pub degree: DegreeRequest,
    /// Sites at most, of all bodies each; a larger degree is cut, a larger number asked for refused.
    pub degree_max: u32,
    /// Threshold γ in J·m²; `None`: the object's own.
    pub gamma_j_m2: Option<f64>,
    /// Where displacements come from.
    pub elastic: ElasticRequest,
    /// Displacements of the reduced basis that are used, the most energetic first, at least one; `None`: all. What the others would have
    /// added counts as error, which is told and may be large: a solve is for impacts that the whole basis does not reach.
    pub rank_max: Option<u32>,
    /// Which lift, where interior distances are on.
    pub lift: LiftKind,
    /// What is simulated.
    pub effects: EffectSet,
    /// With [`EffectKind::Slivers`](crate::scene::EffectKind): pieces of less volume become part of a neighbor, m³; `None`, or where it is
    /// less: [`SLIVER_CUBES`](crate::pipeline::SLIVER_CUBES).
    pub volume_min_m3: Option<f64>,
    /// Where the descent of a diagram ends: an iteration lowers its energy by less than this part of it.
    pub tolerance: f64,
    /// Iterations of a diagram's descent on the nodes at most; with 0 its sites stay where coarser levels, if there are any, end.
    pub iterations_max: usize,
    /// Estimated gap of a diagram at which its descent ends, too; `None`: it does not.
    pub gap_max: Option<f64>,
    /// Largest estimated error of the elastic energy with which a reduced displacement is taken; above, it is solved for.
    pub reduced_error_max: f64,
    /// What falls where time is short; `None`: nothing, whatever it takes.
    pub budget: Option<TimeBudget>,
    /// Everything random follows from it.
    pub seed: u64,
    /// Stop after the threshold test: the impulse that just breaks the object is asked for, no fragments.
    pub threshold_only: bool,
}

impl FractureRequest {
    /// One contact at `point_m` (mesh file, m) with this impulse (N·s), everything else at its default.
    pub fn at(point_m: Point3<f64>, impulse_ns: Vector3<f64>) -> Self {
        Self {
            contacts: vec![ImpactContact { point_m, impulse_ns, duration_s: None, radius_m: None }],
            degree: DegreeRequest::Inferred,
            degree_max: DEGREE_MAX,
            gamma_j_m2: None,
            elastic: ElasticRequest::Reduced,
            rank_max: None,
            lift: LiftKind::Interior,
            effects: EffectSet::default(),
            volume_min_m3: None,
            tolerance: GAME_TOLERANCE,
            iterations_max: ITERATIONS_MAX,
            gap_max: None,
            reduced_error_max: GAME_ERROR_MAX,
            budget: None,
            seed: SEED_DEFAULT,
            threshold_only: false,
        }
    }

    /// With this seed instead of the default one.
    #[must_use]
    pub fn seeded(self, seed: u64) -> Self {
        Self { seed, ..self }
    }
}

impl FractureRequest {
    /// The strike as it is carried out: without interior distances the lift is the straight one, without examples the closed form
    /// decides where they would have.
    pub fn planned(&self) -> Self {
        let lift = if self.effects.has(EffectKind::Interior) { self.lift } else { LiftKind::Euclidean };
        let degree = match self.degree {
            DegreeRequest::Inferred if !self.effects.has(EffectKind::Examples) => DegreeRequest::ClosedForm,
            degree => degree,
        };
        Self { lift, degree, ..self.clone() }
    }

    /// What the artist's controls make of body `body`, if the request follows them and there are any.
    pub fn controls_of<'a>(&self, prepared: &'a PreparedObject, body: usize) -> Option<&'a WarpedBody> {
        prepared.bodies[body].warped.as_ref().filter(|_| self.effects.has(EffectKind::Warp))
    }

    /// The lift of body `body` in which the cells are straight.
    ///
    /// # Errors
    /// [`FractureError::LiftUnprepared`].
    pub fn lift_of<'a>(&self, prepared: &'a PreparedObject, body: usize) -> Result<&'a LiftedLattice, FractureError> {
        let bent = self.controls_of(prepared, body).and_then(|warped| warped.lift(self.lift));
        bent.map_or_else(|| prepared.lift(body, self.lift), Ok)
    }
}
