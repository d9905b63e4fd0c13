//! When a descent ends: asked by the descent, answered by what knows of errors, of time and of cancellation.

use super::{Diagram, three_fifths};
use crate::cancel_token::CancelToken;

/// How a descent goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepDecision {
    /// Until it converges.
    On,
    /// For one more iteration, a plain one, which takes back what over-relaxation overshot.
    Last,
    /// Not at all: the start is taken as it is. After the first iteration as [`StepDecision::Last`], so that the same number of iterations is
    /// always the same diagram.
    End,
}

/// Ends a descent before it converges.
pub trait StopCondition {
    /// Polled while labels are found; a cancelled descent has no result.
    fn cancel(&self) -> &CancelToken;

    /// Asked once labels of the start are there (`iterations` 0, `before` = `after`), and after each iteration of the finest level,
    /// which took F from `before` to `after`.
    fn decide(&mut self, iterations: usize, before: f64, after: f64) -> StepDecision;

    /// Whether the last descent was ended for want of time, so that no further one is worth its start.
    fn is_out_of_time(&self) -> bool {
        false
    }
}

/// Nothing but cancellation ends it.
impl StopCondition for &CancelToken {
    fn cancel(&self) -> &CancelToken {
        self
    }

    fn decide(&mut self, _: usize, _: f64, _: f64) -> StepDecision {
        StepDecision::On
    }
}

/// Gaps below are not told apart: estimates say so much at least.
pub const GAP_MIN: f64 = 5e-4;

/// Gap of a start that was drawn.
const GAP_START: f64 = 0.5;

/// Gap of a start that coarser levels made: 0.01 to 0.3, less with few sites.
const GAP_COARSE: f64 = 0.08;

/// Factor of a decrease to the power 3/5, of one iteration and of two: see [`gap`].
const GAP_FACTORS: [f64; 2] = [0.2, 0.08];

/// A gap is taken to be no more than so many times what is estimated: so are 97 % of those at which it is stopped because of that, from 2 to
/// 10 %, after 4 to 12 iterations.
pub const GAP_CERTAIN: f64 = 8.0;

/// How far F is above the end of the same descent, relative, estimated from F of the start and after each iteration so far, as in
/// [`Diagram::history`](super::Diagram::history).
///
/// With δ the relative decrease of the last two iterations it is 0.08·δ^(3/5), after a single one 0.2·δ^(3/5): the decrease falls by a
/// constant factor per iteration for a while, and then lingers where sites still have to change places, which is what the power stands
/// for. Power and factors are fitted to 2 880 stops after 1 to 20 iterations (five objects, 6 to 150 sites), with [`GAP_MIN`]: 81 % are
/// within a factor 4 of the truth, which is the same descent run to its end (`cargo test --release --workspace --test budget -- --ignored
/// --nocapture`).
pub fn gap(history: &[f64]) -> f64 {
    let [.., last] = *history else { return GAP_START };
    match history.len() {
        1 => GAP_START,
        2 => estimated(GAP_FACTORS[0], [history[0], last]),
        count => estimated(GAP_FACTORS[1], [history[count - 3], last]),
    }
}

/// From a decrease of F.
fn estimated(factor: f64, [before, after]: [f64; 2]) -> f64 {
    let decrease = if after > 0.0 { (before - after) / after } else { 0.0 };
    (factor * three_fifths(decrease)).max(GAP_MIN)
}

/// [`gap`] of a diagram, which knows where it started.
pub(super) fn gap_of(diagram: &Diagram) -> f64 {
    match diagram.history.len() {
        1 if diagram.coarse_iterations > 0 => GAP_COARSE,
        _ => gap(&diagram.history),
    }
}
