//! What a strike of a preset chooses.

use super::fracture_request::{DegreeRequest, FractureRequest};
use crate::centroidal::{ITERATIONS_MAX, TOLERANCE};
use crate::pipeline::prepared::parameters::{ElasticRequest, RANK_MAX};
use crate::pipeline::prepared::preset::Preset;

/// Tolerance of [`Preset::Game`]: its diagrams end some 2 % above the best of several, 1 % above the ends of their descents.
pub const GAME_TOLERANCE: f64 = 2e-2;

/// [`SolverSettings::reduced_error_max`] of [`Preset::Game`]: what its elastic lattice is off by, too, so that a solve would gain little.
pub const GAME_ERROR_MAX: f64 = 0.1;

/// The same of [`Preset::Draft`], which would rather be wrong than late.
pub const DRAFT_ERROR_MAX: f64 = 0.25;

/// A larger estimated error of the energy is worth a solve. The density is then off by some four times as much.
pub const REDUCED_ERROR_MAX: f64 = 0.02;

/// What a strike chooses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolverSettings {
    /// Where displacements come from.
    pub elastic: ElasticRequest,
    /// Displacements of a body's basis that are used at most; `None`: all.
    pub rank_max: Option<u32>,
    /// Largest estimated error of the elastic energy with which a reduced displacement is taken; above, it is solved for.
    pub reduced_error_max: f64,
    /// Where the descent of a diagram ends.
    pub tolerance: f64,
    /// Iterations of a diagram at most.
    pub iterations_max: usize,
    /// Where the number of sites comes from.
    pub degree: DegreeRequest,
}

impl Preset {
    /// What a strike of it chooses.
    pub fn dials(self) -> SolverSettings {
        let game = SolverSettings {
            elastic: ElasticRequest::Reduced,
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
                elastic: ElasticRequest::Solve,
                tolerance: 1e-6,
                degree: DegreeRequest::Verified,
                ..film
            },
        }
    }
}

impl FractureRequest {
    /// With all dials as `quality` has them.
    #[must_use]
    pub fn of_quality(self, quality: Preset) -> Self {
        let SolverSettings { elastic, rank_max, reduced_error_max, tolerance, iterations_max, degree } =
            quality.dials();
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
            let [fast, fine] = [pair[0].dials(), pair[1].dials()];
            assert!(fine.tolerance < fast.tolerance && fine.iterations_max >= fast.iterations_max, "{pair:?}");
            let rank = |dials: SolverSettings| dials.rank_max.unwrap_or(u32::MAX);
            assert!(rank(fine) >= rank(fast), "{pair:?}");
            assert!(fine.elastic == ElasticRequest::Solve || fast.elastic == ElasticRequest::Reduced, "{pair:?}");
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
