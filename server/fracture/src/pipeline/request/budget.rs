//! What quality falls, and in which order, where time is short.
//!
//! The iterations of the diagram fall first, down to none; then a solve becomes a reduced displacement, even one whose estimated error is
//! large, and that one of half the basis; then a search of the degree becomes a guess. Whether pieces are closed, their masses and the caps never fall. What a request
//! says by itself does not fall, either, except that a search that was asked for is begun, and becomes the guess where time ends it.

use super::cost::StrikeCost;
use super::fracture_request::{DegreeRequest, FractureRequest};
use crate::centroidal::ITERATIONS_MAX;
use crate::pipeline::prepared::object::PreparedObject;
use crate::pipeline::prepared::parameters::{ElasticRequest, RANK_MAX};

/// What is known of the time of one strike, and what of it may fall. How much time is left is known to its
/// [`CancelToken`](crate::cancel_token::CancelToken::remaining_s).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeBudget {
    /// What strikes of the object take.
    pub cost: StrikeCost,
    /// Whether a solve may become a reduced displacement.
    pub elastic_falls: bool,
    /// Whether a search of the degree that there is no time for is not begun.
    pub degree_falls: bool,
}

/// Sites that are reckoned with while nobody knows how many there will be.
const SITES_EXPECTED: u32 = 50;

/// Largest estimated error of a reduced displacement that stands in for a solve that there is no time for.
pub const HURRIED_ERROR_MAX: f64 = 0.25;

/// Displacements of a basis at most where there is no time for a diagram's first iteration.
pub const HURRIED_RANK_MAX: u32 = RANK_MAX as u32 / 2;

impl TimeBudget {
    /// The budget of what is left, at the pace of what came so far: energies, solved for or not, which took `front_s` seconds.
    pub(in crate::pipeline) fn rescaled(self, solved: bool, front_s: f64) -> Self {
        let elastic = if solved { ElasticRequest::Solve } else { ElasticRequest::Reduced };
        Self { cost: self.cost.at_pace(self.cost.pace(elastic, front_s)), ..self }
    }

    /// Whether `remaining_s` seconds are enough to search the degree, as `rule` says, of bodies that are guessed to get so many sites.
    pub(in crate::pipeline) fn allows_search(&self, rule: DegreeRequest, sites: u32, remaining_s: f64) -> bool {
        let cost = &self.cost;
        let search_s = match rule {
            DegreeRequest::Optimised => cost.optimise_s(sites),
            _ => cost.verify_s(sites),
        };
        !self.degree_falls || remaining_s >= search_s + cost.rest_s(sites)
    }
}

impl FractureRequest {
    /// The strike as it is begun with `remaining_s` seconds left.
    pub(in crate::pipeline) fn degrade_for_budget(self, prepared: &PreparedObject, remaining_s: f64) -> Self {
        let Some(TimeBudget { cost, elastic_falls: true, .. }) = self.budget else { return self };
        let sites = match self.degree {
            DegreeRequest::Sites(sites) => sites,
            _ => SITES_EXPECTED,
        };
        let [solve_s, reduced_s] =
            [ElasticRequest::Solve, ElasticRequest::Reduced].map(|elastic| cost.strike_s(elastic, sites, 0));
        let basis = prepared.bodies.iter().any(|body| body.reduced().is_some());
        if !basis || remaining_s >= solve_s {
            return self;
        }
        let reduced_error_max = self.reduced_error_max.max(HURRIED_ERROR_MAX);
        let half = |rank_max: Option<u32>| Some(rank_max.map_or(HURRIED_RANK_MAX, |most| most.min(HURRIED_RANK_MAX)));
        let rank_max = if remaining_s < reduced_s { half(self.rank_max) } else { self.rank_max };
        Self { elastic: ElasticRequest::Reduced, reduced_error_max, rank_max, ..self }
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
