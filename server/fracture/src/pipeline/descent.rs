//! When a diagram is good enough for its strike.

use super::{Ending, Strike, Watch};
use crate::centroidal::{Diagram, GAP_CERTAIN, Pace, Stop, gap};

/// Values of F that an estimate of the gap looks at.
const LOOKED_AT: usize = 3;

/// Weight of the last iteration, if it was faster than expected, in what one is expected to take; a slower one is what is expected then.
const WEIGHT: f64 = 0.5;

/// Watches the descent of one diagram: its error, and the time that it leaves to what follows.
pub(super) struct Descent<'a> {
    watch: &'a dyn Watch,
    gap_max: Option<f64>,
    /// What follows takes this long, s.
    rest_s: f64,
    /// An iteration takes this long, s.
    step_s: f64,
    /// What was left when it was asked last, s.
    left_s: f64,
    history: Vec<f64>,
    ending: Option<Ending>,
}

impl<'a> Descent<'a> {
    /// Of a diagram of `sites` sites, which `strike` asks for.
    pub fn new(strike: &Strike, sites: u32, watch: &'a dyn Watch) -> Self {
        let cost = strike.budget.map(|budget| budget.cost);
        let [rest_s, step_s] = cost.map_or([0.0; 2], |cost| [cost.rest_s(sites), cost.iteration_s(sites)]);
        let (gap_max, left_s, history) = (strike.gap_max, watch.remaining_s(), Vec::with_capacity(LOOKED_AT));
        Self { watch, gap_max, rest_s, step_s, left_s, history, ending: None }
    }

    /// What ended the descent of `diagram`.
    pub fn ending(&self, diagram: &Diagram) -> Ending {
        let own = if diagram.converged { Ending::Converged } else { Ending::Iterations };
        self.ending.unwrap_or(own)
    }

    /// Iterations that there is time for.
    fn steps(&mut self, iterations: usize) -> f64 {
        let left_s = self.watch.remaining_s();
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

impl Stop for Descent<'_> {
    fn pace(&mut self, iterations: usize, _: f64, after: f64) -> Pace {
        if self.history.len() == LOOKED_AT {
            self.history.remove(0);
        }
        self.history.push(after);
        let met = iterations > 0 && self.gap_max.is_some_and(|gap_max| GAP_CERTAIN * gap(&self.history) <= gap_max);
        let (ending, pace) = match self.steps(iterations) {
            _ if met => (Some(Ending::ErrorMet), Pace::Last),
            steps if steps >= 2.0 => (None, Pace::On),
            steps if steps >= 1.0 => (Some(Ending::Time), Pace::Last),
            _ => (Some(Ending::Time), Pace::End),
        };
        self.ending = ending;
        pace
    }
}
