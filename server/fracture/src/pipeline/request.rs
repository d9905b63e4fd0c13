//! What one strike asks for.

use super::{DEGREE_MAX, GAME_ERROR_MAX, GAME_TOLERANCE, TimeBudget};
use crate::centroidal::ITERATIONS_MAX;
use crate::lift::LiftKind;
use crate::scene::EffectSet;
use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

/// Seed of a strike that names none; the same as in the client (a test of `shatter-server` compares them).
pub const SEED_DEFAULT: u64 = 0;

/// One contact, in the coordinates of the mesh file (meters, y up).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImpactContact {
    /// Where, meters.
    pub point_m: Point3<f64>,
    /// Impulse handed to the object, N·s.
    pub impulse_ns: Vector3<f64>,
    /// Contact duration, s; `None`: the scene's default.
    pub duration_s: Option<f64>,
    /// Contact radius, m; `None`: the scene's default.
    pub radius_m: Option<f64>,
}

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

/// Where displacements come from: of an object, and of one strike.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ElasticRequest {
    /// From the reduced basis where there is one and it is exact enough for this impact, else from the solve.
    #[default]
    Reduced,
    /// From the solve.
    Solve,
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
    /// less: [`SLIVER_CUBES`](super::SLIVER_CUBES).
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
