//! Decision when the diagram of a request is accurate enough.

use super::termination::Termination;
use crate::cancel_token::CancelToken;
use crate::centroidal::{Diagram, GAP_CERTAIN, StepDecision, StopCondition, gap};
use crate::pipeline::request::budget::TimeBudget;
use crate::pipeline::request::fracture_request::FractureRequest;

/// Number of values of F that an estimate of the gap uses.
const LOOKED_AT: usize = 3;

/// Weight of the last iteration's time in the expected time, if it was faster than expected. A slower one replaces the
/// expected time.
const WEIGHT: f64 = 0.5;

/// Observes the descent of one diagram, or of several in sequence: its estimated error, and the time left for the later
/// stages.
pub(in crate::pipeline) struct ConvergenceMonitor<'a> {
    cancel: &'a CancelToken,
    gap_max: Option<f64>,
    /// Expected time of the later stages, s.
    rest_s: f64,
    /// Expected time of an iteration, s.
    step_s: f64,
    /// Remaining time at the last decision, s.
    left_s: f64,
    history: Vec<f64>,
    ending: Option<Termination>,
}

impl<'a> ConvergenceMonitor<'a> {
    /// Monitor of a diagram of `sites` sites for `request`, within `budget`.
    pub fn new(request: &FractureRequest, budget: Option<TimeBudget>, sites: u32, cancel: &'a CancelToken) -> Self {
        let cost = budget.map(|budget| budget.cost);
        let [rest_s, step_s] = cost.map_or([0.0; 2], |cost| [cost.rest_s(sites), cost.iteration_s(sites)]);
        let (gap_max, left_s, history) = (request.gap_max, cancel.remaining_s(), Vec::with_capacity(LOOKED_AT));
        Self { cancel, gap_max, rest_s, step_s, left_s, history, ending: None }
    }

    /// Monitor of the diagrams of a degree search. It leaves time for the start of a diagram of `sites` sites, the
    /// estimate.
    pub fn of_search(
        request: &FractureRequest,
        budget: Option<TimeBudget>,
        sites: u32,
        cancel: &'a CancelToken,
    ) -> Self {
        let start_s = budget.map_or(0.0, |budget| budget.cost.start_s(sites));
        let alone = Self::new(request, budget, sites, cancel);
        Self { rest_s: alone.rest_s + start_s, ..alone }
    }

    /// Reason why the descent of `diagram` ended.
    pub fn ending(&self, diagram: &Diagram) -> Termination {
        let own = if diagram.converged { Termination::Converged } else { Termination::Iterations };
        self.ending.unwrap_or(own)
    }

    /// Number of further iterations that fit into the remaining time.
    fn steps(&mut self, iterations: usize) -> f64 {
        let left_s = self.cancel.remaining_s();
        if left_s.is_infinite() {
            return f64::INFINITY;
        }
        let took_s = self.left_s - left_s;
        self.left_s = left_s;
        if iterations > 0 {
            self.step_s = took_s.max(self.step_s + WEIGHT * (took_s - self.step_s));
        }
        (left_s - self.rest_s) / self.step_s
    }
}

impl StopCondition for ConvergenceMonitor<'_> {
    fn cancel(&self) -> &CancelToken {
        self.cancel
    }

    fn decide(&mut self, iterations: usize, _: f64, after: f64) -> StepDecision {
        if iterations == 0 {
            self.history.clear();
        }
        if self.history.len() == LOOKED_AT {
            self.history.remove(0);
        }
        self.history.push(after);
        let met = iterations > 0 && self.gap_max.is_some_and(|gap_max| GAP_CERTAIN * gap(&self.history) <= gap_max);
        let (ending, decision) = match self.steps(iterations) {
            _ if met => (Some(Termination::ErrorMet), StepDecision::Last),
            steps if steps >= 2.0 => (None, StepDecision::On),
            steps if steps >= 1.0 => (Some(Termination::Time), StepDecision::Last),
            _ => (Some(Termination::Time), StepDecision::End),
        };
        self.ending = ending;
        decision
    }

    fn is_out_of_time(&self) -> bool {
        self.ending == Some(Termination::Time)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::centroidal::GAP_MIN;
    use crate::pipeline::RequestCost;
    use nalgebra::{Point3, Vector3};
    use std::sync::Mutex;

    fn request() -> FractureRequest {
        FractureRequest::at(Point3::origin(), Vector3::x()).seeded(1)
    }

    /// Expects the decisions `decisions` at the remaining times `left_s`, with 10 s for later stages and 1 s per iteration.
    #[track_caller]
    fn check(left_s: &[f64], decisions: &[StepDecision]) {
        let cost = RequestCost {
            reduced_s: 1.0,
            solve_s: 1.0,
            start_s: [1.0, 0.0],
            iteration_s: [1.0, 0.0],
            rest_s: [10.0, 0.0],
        };
        let budget = Some(TimeBudget { cost, elastic_falls: true, degree_falls: true });
        let times_s = Mutex::new(left_s.iter().rev().copied().collect::<Vec<f64>>());
        let cancel = CancelToken::default().with_time(move || times_s.lock().unwrap().pop().unwrap());
        let mut descent = ConvergenceMonitor::new(&request(), budget, 9, &cancel);
        let found: Vec<StepDecision> =
            (0..decisions.len()).map(|iterations| descent.decide(iterations, 1.0, 1.0)).collect();
        assert_eq!(found, decisions);
    }

    #[test]
    fn iterations_leave_time_for_the_remaining_stages() {
        use StepDecision::{End, Last, On};
        check(&[20.0, 19.0, 18.0, 13.0], &[On, On, End]);
        check(&[20.0, 12.0, 11.0], &[On, Last]);
        check(&[20.0, 10.9], &[End]);
        check(&[20.0, 11.0], &[Last]);
        // A slow iteration raises the expected time to its own; a fast one lowers it by half of the difference.
        check(&[20.0, 17.0, 14.0], &[On, Last]);
        check(&[20.0, 11.9], &[Last]);
        check(&[20.0, 12.0, 11.8, 11.7], &[On, On, On]);
        check(&[f64::INFINITY, f64::INFINITY, f64::INFINITY], &[On, On]);
    }

    #[test]
    fn every_diagram_of_a_search_is_estimated_by_itself() {
        let cancel = CancelToken::default();
        let mut descent =
            ConvergenceMonitor::of_search(&FractureRequest { gap_max: Some(0.1), ..request() }, None, 9, &cancel);
        let first: Vec<StepDecision> =
            [(0, 1.0), (1, 1.0)].map(|(at, energy)| descent.decide(at, energy, energy)).into();
        assert_eq!(first, [StepDecision::On, StepDecision::Last]);
        assert_eq!(
            [0, 1].map(|at| descent.decide(at, 5.0 - f64::from(at as u8), 5.0 - 3.0 * at as f64)),
            [StepDecision::On; 2]
        );
    }

    #[test]
    fn an_error_is_met_with_room_for_the_estimate() {
        let asked = |gap_max| FractureRequest { gap_max: Some(gap_max), ..request() };
        let after = |gap_max, energies: &[f64]| {
            let cancel = CancelToken::default();
            let mut descent = ConvergenceMonitor::new(&asked(gap_max), None, 9, &cancel);
            let decisions =
                energies.iter().enumerate().map(|(iterations, energy)| descent.decide(iterations, *energy, *energy));
            decisions.last()
        };
        let energies = [1.3, 1.1, 1.08];
        let certain = GAP_CERTAIN * gap(&energies);
        assert_eq!(after(1.01 * certain, &energies), Some(StepDecision::Last));
        assert_eq!(after(0.99 * certain, &energies), Some(StepDecision::On));
        assert_eq!(after(1e9, &energies[..1]), Some(StepDecision::On), "nothing is known before the first iteration");
        assert_eq!(after(0.99 * GAP_CERTAIN * GAP_MIN, &[1.0; 9]), Some(StepDecision::On));
    }
}
