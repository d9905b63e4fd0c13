//! Time budget of a request: which parts of the computation are simplified when time is short, and in which order.
//!
//! 1. The iterations of the diagram are reduced, down to none.
//! 2. A solve becomes a reduced displacement, even with a large estimated error, and then one of half the basis.
//! 3. A search for the degree becomes an estimate.
//!
//! Closed fragments, masses and maxima are never given up. Explicit options of a request are kept, except that a
//! requested search is started and becomes the estimate when its time ends.

use super::cost::RequestCost;
use super::fracture_request::{DegreeRequest, FractureRequest};
use crate::centroidal::ITERATIONS_MAX;
use crate::pipeline::prepared::object::PreparedObject;
use crate::pipeline::prepared::parameters::{DisplacementMethod, RANK_MAX};

/// Expected cost of a request, and the parts that may be simplified.
///
/// The remaining time is known to its [`CancelToken`](crate::cancel_token::CancelToken::remaining_s).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeBudget {
    /// Expected cost of requests on the object.
    pub cost: RequestCost,
    /// True if a solve may become a reduced displacement.
    pub elastic_falls: bool,
    /// True if a search for the degree is skipped when the remaining time is too short for it.
    pub degree_falls: bool,
}

/// Site count assumed before the degree is known.
const SITES_EXPECTED: u32 = 50;

/// Largest estimated error at which a reduced displacement replaces a solve for lack of time.
pub const DEGRADED_ERROR_MAX: f64 = 0.25;

/// Largest number of basis displacements if there is no time for a diagram's first iteration.
pub const DEGRADED_RANK_MAX: u32 = RANK_MAX as u32 / 2;

impl TimeBudget {
    /// The budget with the cost rescaled by the pace so far: the energies, solved for or not, took `front_s` seconds.
    pub(in crate::pipeline) fn rescaled(self, solved: bool, front_s: f64) -> Self {
        let elastic = if solved { DisplacementMethod::Solve } else { DisplacementMethod::Reduced };
        Self { cost: self.cost.scaled_by(self.cost.time_scale(elastic, front_s)), ..self }
    }

    /// True if `remaining_s` seconds suffice for a search of the degree by `rule` on bodies with `sites` estimated
    /// sites.
    pub(in crate::pipeline) fn allows_search(&self, rule: DegreeRequest, sites: u32, remaining_s: f64) -> bool {
        let cost = &self.cost;
        let search_s = match rule {
            DegreeRequest::Optimized => cost.optimize_s(sites),
            _ => cost.verify_s(sites),
        };
        !self.degree_falls || remaining_s >= search_s + cost.rest_s(sites)
    }
}

impl FractureRequest {
    /// The request with the simplifications that `remaining_s` seconds require at its start.
    pub(in crate::pipeline) fn degrade_for_budget(self, prepared: &PreparedObject, remaining_s: f64) -> Self {
        let Some(TimeBudget { cost, elastic_falls: true, .. }) = self.budget else { return self };
        let sites = match self.degree {
            DegreeRequest::Sites(sites) => sites,
            _ => SITES_EXPECTED,
        };
        let [solve_s, reduced_s] =
            [DisplacementMethod::Solve, DisplacementMethod::Reduced].map(|elastic| cost.request_s(elastic, sites, 0));
        let basis = prepared.bodies.iter().any(|body| body.reduced().is_some());
        if !basis || remaining_s >= solve_s {
            return self;
        }
        let reduced_error_max = self.reduced_error_max.max(DEGRADED_ERROR_MAX);
        let half = |rank_max: Option<u32>| Some(rank_max.map_or(DEGRADED_RANK_MAX, |most| most.min(DEGRADED_RANK_MAX)));
        let rank_max = if remaining_s < reduced_s { half(self.rank_max) } else { self.rank_max };
        Self { elastic: DisplacementMethod::Reduced, reduced_error_max, rank_max, ..self }
    }

    /// The same request with settings for a given error.
    ///
    /// Reduced displacements are used if their estimated error is at most `error_max`, and diagrams iterate until their
    /// estimated gap is.
    #[must_use]
    pub fn to_the_error(self, error_max: f64) -> Self {
        Self {
            elastic: DisplacementMethod::Reduced,
            rank_max: None,
            reduced_error_max: error_max,
            gap_max: Some(error_max),
            tolerance: 0.0,
            iterations_max: ITERATIONS_MAX,
            ..self
        }
    }
}
