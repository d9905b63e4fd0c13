//! One request.

use super::budget::TimeBudget;
use super::solver_settings::{GAME_ERROR_MAX, GAME_TOLERANCE};
use crate::centroidal::ITERATIONS_MAX;
use crate::lift::{LiftKind, LiftedLattice};
use crate::pipeline::DEGREE_MAX;
use crate::pipeline::contact::ImpactContact;
use crate::pipeline::error::FractureError;
use crate::pipeline::prepared::object::PreparedObject;
use crate::pipeline::prepared::parameters::{DisplacementMethod, SurfaceKind};
use crate::pipeline::prepared::warped_body::WarpedBody;
use crate::scene::{EffectKind, EffectSet};
use crate::strength::{Criterion, StrengthConstants};
use nalgebra::{Point3, Vector3};

/// Default seed of a request, equal to that of the client (a test of `shatter-server` compares them).
pub const SEED_DEFAULT: u64 = 0;

/// Rule that chooses the number of sites.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DegreeRequest {
    /// The given number, at least 1.
    Sites(u32),
    /// The calibrated closed form.
    ClosedForm,
    /// The estimate learned from the object's examples; the closed form outside their range.
    Inferred,
    /// The inferred number, corrected to the smallest one near it that passes γ.
    Verified,
    /// Full optimization: the first n at which the running minimum of E_max(n) passes γ.
    Optimized,
}

/// An impact with its options.
#[derive(Clone, Debug, PartialEq)]
pub struct FractureRequest {
    /// Contacts, at least one.
    pub contacts: Vec<ImpactContact>,
    /// Rule that chooses the number of sites.
    pub degree: DegreeRequest,
    /// Largest number of sites, of all bodies together. A larger computed degree is reduced to it; a larger given degree is an error.
    pub degree_max: u32,
    /// Threshold γ, J·m²; `None`: the object's own.
    pub gamma_j_m2: Option<f64>,
    /// Factor on the load that the object withstands, under both criteria: on the strengths of its material. Its own γ and G_c are
    /// multiplied by the square, γ of the request is not.
    pub strength_scale: f64,
    /// Rule that decides whether the object breaks. Without the effect `elastic` there is no stress, so the paper's applies.
    pub criterion: Criterion,
    /// Source of the displacements.
    pub elastic: DisplacementMethod,
    /// Number of displacements of the reduced basis to use, the most energetic first, at least one; `None`: all.
    ///
    /// The reported error includes the part that the unused displacements would have added, and may be large. This
    /// limit never triggers a solve: only the error of the whole basis does.
    pub rank_max: Option<u32>,
    /// Lift, used if the effect for interior distances is on.
    pub lift: LiftKind,
    /// Surface of the fragments.
    pub surface: SurfaceKind,
    /// Effects to simulate.
    pub effects: EffectSet,
    /// Volume below which pieces are merged into a neighbor, m³, with
    /// [`EffectKind::Slivers`](crate::scene::EffectKind).
    ///
    /// `None` or a smaller volume: [`SLIVER_CUBES`](crate::pipeline::SLIVER_CUBES).
    pub volume_min_m3: Option<f64>,
    /// Relative decrease of a diagram's energy in one iteration below which the descent ends.
    pub tolerance: f64,
    /// Largest number of iterations of a diagram's descent on the nodes. With 0, the sites stay at the end of the
    /// coarser levels, if any.
    pub iterations_max: usize,
    /// Estimated gap of a diagram at which its descent also ends; `None`: no such test.
    pub gap_max: Option<f64>,
    /// Largest estimated relative error of the elastic energy at which a reduced displacement is accepted instead of a
    /// solve. With [`Criterion::Strength`](crate::strength::Criterion::Strength), five times as much, up to 0.5, where
    /// its stresses are below a quarter of the strength.
    pub reduced_error_max: f64,
    /// Parts of the computation that may be simplified when time is short; `None`: none.
    pub budget: Option<TimeBudget>,
    /// Seed of all random numbers.
    pub seed: u64,
    /// True to stop after the threshold test, with the impulse that just breaks the object and no fragments.
    pub threshold_only: bool,
}

impl FractureRequest {
    /// A request with one contact at `point_m` (mesh file, m), this impulse (N·s) and default options.
    pub fn at(point_m: Point3<f64>, impulse_ns: Vector3<f64>) -> Self {
        Self {
            contacts: vec![ImpactContact { point_m, impulse_ns, duration_s: None, radius_m: None, partner: None }],
            degree: DegreeRequest::Inferred,
            degree_max: DEGREE_MAX,
            gamma_j_m2: None,
            strength_scale: 1.0,
            criterion: Criterion::default(),
            elastic: DisplacementMethod::Reduced,
            rank_max: None,
            lift: LiftKind::Interior,
            surface: SurfaceKind::Exact,
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

    /// The same request with another seed.
    #[must_use]
    pub fn seeded(self, seed: u64) -> Self {
        Self { seed, ..self }
    }
}

impl FractureRequest {
    /// The request as it is carried out.
    ///
    /// Without interior distances, the lift is Euclidean. Without examples, the closed form replaces the inferred
    /// degree. Without elasticity, the criterion is that of the paper.
    pub fn planned(&self) -> Self {
        let lift = if self.effects.has(EffectKind::Interior) { self.lift } else { LiftKind::Euclidean };
        let degree = match self.degree {
            DegreeRequest::Inferred if !self.effects.has(EffectKind::Examples) => DegreeRequest::ClosedForm,
            degree => degree,
        };
        let criterion = if self.effects.has(EffectKind::Elastic) { self.criterion } else { Criterion::Paper };
        Self { lift, degree, criterion, ..self.clone() }
    }

    /// The γ that decides, J·m².
    pub(in crate::pipeline) fn scaled_gamma_j_m2(&self, prepared: &PreparedObject) -> f64 {
        self.gamma_j_m2.unwrap_or(self.strength_scale.powi(2) * prepared.gamma_j_m2)
    }

    /// Constants of the material that decide when the object breaks.
    pub(in crate::pipeline) fn strength_constants(&self, prepared: &PreparedObject) -> StrengthConstants {
        prepared.strength_constants().scaled(self.strength_scale)
    }

    /// The artist's controls of body `body`, if the request uses them and there are any.
    pub fn controls_of<'a>(&self, prepared: &'a PreparedObject, body: usize) -> Option<&'a WarpedBody> {
        prepared.bodies[body].warped.as_ref().filter(|_| self.effects.has(EffectKind::Warp))
    }

    /// The lift of body `body` in which cells have planar faces.
    ///
    /// # Errors
    /// [`FractureError::LiftUnprepared`].
    pub fn lift_of<'a>(&self, prepared: &'a PreparedObject, body: usize) -> Result<&'a LiftedLattice, FractureError> {
        let bent = self.controls_of(prepared, body).and_then(|warped| warped.lift(self.lift));
        bent.map_or_else(|| prepared.lift(body, self.lift), Ok)
    }
}
