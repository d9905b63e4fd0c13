//! Solver settings of a preset.

use super::fracture_request::{DegreeRequest, FractureRequest};
use crate::centroidal::{ITERATIONS_MAX, TOLERANCE};
use crate::pipeline::prepared::parameters::{DisplacementMethod, RANK_MAX};
use crate::pipeline::prepared::preset::Preset;

/// Tolerance of [`Preset::Game`].
///
/// Measured: its diagrams end about 2 % above the best of several, and 1 % above the ends of their own descents.
pub const GAME_TOLERANCE: f64 = 2e-2;

/// [`SolverSettings::reduced_error_max`] of [`Preset::Game`].
///
/// The preset's elastic lattice has an error of the same size, so a solve would gain little.
pub const GAME_ERROR_MAX: f64 = 0.1;

/// The same of [`Preset::Draft`], which prefers speed to accuracy.
pub const DRAFT_ERROR_MAX: f64 = 0.25;

/// The same of [`Preset::Film`]. The relative error of the energy density is about four times as large.
pub const REDUCED_ERROR_MAX: f64 = 0.02;

/// Settings that trade the accuracy of a request for time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolverSettings {
    /// Source of the displacements.
    pub elastic: DisplacementMethod,
    /// Largest number of displacements of a body's basis; `None`: all.
    pub rank_max: Option<u32>,
    /// Largest estimated relative error of the elastic energy at which a reduced displacement is accepted instead of a
    /// solve.
    pub reduced_error_max: f64,
    /// Relative decrease of a diagram's energy in one iteration below which the descent ends.
    pub tolerance: f64,
    /// Largest number of iterations of a diagram.
    pub iterations_max: usize,
    /// Rule that chooses the number of sites.
    pub degree: DegreeRequest,
}

impl Preset {
    /// The solver settings of this preset.
    pub fn solver_settings(self) -> SolverSettings {
        let game = SolverSettings {
            elastic: DisplacementMethod::Reduced,
            rank_max: None,
            reduced_error_max: GAME_ERROR_MAX,
            tolerance: GAME_TOLERANCE,
            iterations_max: ITERATIONS_MAX,
            degree: DegreeRequest::Inferred,
        };
        let film = SolverSettings { reduced_error_max: REDUCED_ERROR_MAX, tolerance: TOLERANCE, ..game };
        match self {
            Self::Draft => SolverSettings {
                rank_max: Some(RANK_MAX as u32 / 2),
                reduced_error_max: DRAFT_ERROR_MAX,
                tolerance: 5e-2,
                iterations_max: 4,
                ..game
            },
            Self::Game => game,
            Self::Film => film,
            Self::Reference => SolverSettings {
                elastic: DisplacementMethod::Solve,
                tolerance: 1e-6,
                degree: DegreeRequest::Verified,
                ..film
            },
        }
    }
}

impl FractureRequest {
    /// The same request with all solver settings of the preset `quality`.
    #[must_use]
    pub fn of_quality(self, quality: Preset) -> Self {
        let SolverSettings { elastic, rank_max, reduced_error_max, tolerance, iterations_max, degree } =
            quality.solver_settings();
        Self { elastic, rank_max, reduced_error_max, tolerance, iterations_max, degree, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Point3, Vector3};

    #[test]
    fn every_preset_is_at_least_as_accurate_as_the_one_before() {
        for pair in Preset::ALL.windows(2) {
            let [fast, fine] = [pair[0].solver_settings(), pair[1].solver_settings()];
            assert!(fine.tolerance < fast.tolerance && fine.iterations_max >= fast.iterations_max, "{pair:?}");
            let rank = |solver_settings: SolverSettings| solver_settings.rank_max.unwrap_or(u32::MAX);
            assert!(rank(fine) >= rank(fast), "{pair:?}");
            assert!(
                fine.elastic == DisplacementMethod::Solve || fast.elastic == DisplacementMethod::Reduced,
                "{pair:?}"
            );
            let [fast, fine] = [pair[0].lattices(), pair[1].lattices()];
            assert!(fine.crack_nodes >= fast.crack_nodes && fine.elastic_nodes >= fast.elastic_nodes, "{pair:?}");
        }
    }

    #[test]
    fn the_default_preset_is_the_default_of_a_strike() {
        let strike = FractureRequest::at(Point3::origin(), Vector3::x());
        assert_eq!(strike.clone().of_quality(Preset::default()), strike);
        assert!(Preset::ALL.into_iter().all(|quality| Preset::by_name(quality.name()) == Some(quality)));
        assert_eq!(Preset::by_name("normal"), None);
    }
}
