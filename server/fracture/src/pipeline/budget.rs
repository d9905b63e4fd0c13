//! What quality falls, and in which order, where time is short.
//!
//! The iterations of the diagram fall first, down to none; then a solve becomes a reduced displacement, even one whose estimated error is
//! large; then a search of the degree becomes a guess. Whether pieces are closed, their masses and the caps never fall. What a request
//! says by itself does not fall, either.

use super::{Cost, DegreeRequest, ElasticRequest, Prepared, Strike};
use crate::centroidal::ITERATIONS_MAX;

/// What is known of the time of one strike, and what of it may fall. The time that is left tells
/// [`Watch::remaining_s`](super::Watch::remaining_s).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Budget {
    /// What strikes of the object take.
    pub cost: Cost,
    /// Whether a solve may become a reduced displacement.
    pub elastic_falls: bool,
    /// Whether a search of the degree may become a guess.
    pub degree_falls: bool,
}

/// Sites that are reckoned with while nobody knows how many there will be.
const SITES_EXPECTED: u32 = 50;

/// Largest estimated error of a reduced displacement that stands in for a solve that there is no time for.
pub const HURRIED_ERROR_MAX: f64 = 0.25;

impl Strike {
    /// The strike as it is begun with `remaining_s` seconds left.
    pub(super) fn hurried(self, prepared: &Prepared, remaining_s: f64) -> Self {
        let Some(Budget { cost, elastic_falls: true, .. }) = self.budget else { return self };
        let sites = match self.degree {
            DegreeRequest::Sites(sites) => sites,
            _ => SITES_EXPECTED,
        };
        let solve_s = cost.front_s(ElasticRequest::Solve) + cost.start_s(sites) + cost.rest_s(sites);
        let basis = prepared.bodies.iter().any(|body| body.reduced().is_some());
        if !basis || remaining_s >= solve_s {
            return self;
        }
        let reduced_error_max = self.reduced_error_max.max(HURRIED_ERROR_MAX);
        Self { elastic: ElasticRequest::Reduced, reduced_error_max, ..self }
    }

    /// Whether there is time, of `remaining_s` seconds, to search the degree of a body that is guessed to get so many sites.
    pub(super) fn may_search(&self, sites: u32, remaining_s: f64) -> bool {
        let Some(Budget { cost, degree_falls: true, .. }) = self.budget else { return true };
        let search_s = match self.degree {
            DegreeRequest::Optimised => cost.optimise_s(sites),
            _ => cost.verify_s(sites),
        };
        remaining_s >= search_s + cost.rest_s(sites)
    }

    /// With the dials by which `error_max` is met: a reduced displacement where its estimate allows, as many iterations as it takes.
    #[must_use]
    pub fn to_the_error(self, error_max: f64) -> Self {
        Self {
            elastic: ElasticRequest::Reduced,
            rank_max: None,
            reduced_error_max: error_max,
            gap_max: Some(error_max),
            tolerance: 0.0,
            iterations_max: ITERATIONS_MAX,
            ..self
        }
    }
}
