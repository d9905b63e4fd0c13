//! Expected times of requests for an object on this machine: measured when it is loaded, corrected by every request.
//!
//! The costs are not stored in databases, whose bytes must not depend on the machine that bakes them.

use shatter_fracture::pipeline::{CostSample, DisplacementMethod, RequestCost};
use shatter_proto::effect::Effects;
use std::collections::{HashMap, VecDeque};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Initial ratio of expected to measured time of the stages after the diagram.
const MARGIN: f64 = 1.2;

/// Quantile of the recent ratios that becomes the expected ratio.
const QUANTILE: f64 = 0.95;

/// Maximum number of recent requests, and the number from which [`MARGIN`] has no influence.
const STRIKES: [usize; 2] = [64, 8];

/// Maximum number of effect sets with separate statistics; beyond it all statistics start again.
const EFFECTS_MAX: usize = 256;

/// Costs of one object.
pub struct ObjectCosts(Mutex<Known>);

struct Known {
    cost: RequestCost,
    measured: bool,
    /// Recent requests by effect bits and by whether they were solved for (which changes the pace): pace, and ratio of the time after
    /// the diagram to the measured time at that pace.
    rests: HashMap<(u64, bool), VecDeque<[f64; 2]>>,
}

impl ObjectCosts {
    /// Creates the costs of an object from an estimate.
    pub fn new(cost: RequestCost) -> Self {
        Self(Mutex::new(Known { cost, measured: false, rests: HashMap::new() }))
    }

    fn known(&self) -> MutexGuard<'_, Known> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Expected cost of a request with these effects; `solved`: whether displacements are solved for.
    pub fn of(&self, effects: Effects, solved: bool) -> RequestCost {
        let known = self.known();
        let [time_scale, rest] = known.rests.get(&(effects.bits(), solved)).map_or([1.0, MARGIN], expected);
        known.cost.scaled(time_scale).with_rest(rest)
    }

    /// Whether the costs were measured.
    pub fn is_measured(&self) -> bool {
        self.known().measured
    }

    /// Replaces the costs by a fit to measurements.
    pub fn measured(&self, samples: &[CostSample]) {
        if let Some(cost) = RequestCost::fit(samples) {
            *self.known() = Known { cost, measured: true, rests: HashMap::new() };
        }
    }

    /// Corrects the costs by the times of one request.
    pub fn learn(&self, effects: Effects, took: &CostSample) {
        let mut known = self.known();
        let elastic = if took.solved { DisplacementMethod::Solve } else { DisplacementMethod::Reduced };
        let time_scale = known.cost.time_scale(elastic, took.front_s);
        let ratio = took.rest_s / (time_scale * known.cost.rest_s(took.sites));
        if !ratio.is_normal() {
            return;
        }
        if known.rests.len() >= EFFECTS_MAX {
            known.rests.clear();
        }
        let rests = known.rests.entry((effects.bits(), took.solved)).or_default();
        if rests.len() == STRIKES[0] {
            rests.pop_front();
        }
        rests.push_back([time_scale, ratio]);
    }
}

/// Median pace, and the ratio that few of the next requests exceed if they resemble the recent ones.
fn expected(rests: &VecDeque<[f64; 2]>) -> [f64; 2] {
    let missing = STRIKES[1].saturating_sub(rests.len());
    let quantile = |part: usize, share: f64, prior: f64| {
        let known = rests.iter().map(|rest| rest[part]);
        let mut sorted: Vec<f64> = known.chain(std::iter::repeat_n(prior, missing)).collect();
        sorted.sort_by(f64::total_cmp);
        sorted.get((share * sorted.len() as f64) as usize).copied().unwrap_or(prior)
    };
    [quantile(0, 0.5, 1.0), quantile(1, QUANTILE, MARGIN)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use shatter_proto::effect::Effect;

    #[test]
    fn the_cost_after_the_diagram_is_learned_per_effect() {
        let cost = RequestCost {
            reduced_s: 1e-3,
            solve_s: 2e-3,
            start_s: [1e-3, 0.0],
            iteration_s: [1e-3, 0.0],
            rest_s: [1e-3, 0.0],
        };
        let costs = ObjectCosts::new(cost);
        let (plain, hulls) = (Effects::default(), Effects::of([Effect::Hulls]));
        let took = |time_scale: f64, rest_s: f64| CostSample {
            sites: 9,
            solved: false,
            iterations: 3,
            front_s: time_scale * 1e-3,
            diagram_s: time_scale * 4e-3,
            rest_s: time_scale * rest_s,
        };
        let of = |effects| costs.of(effects, false);
        let expected_ms = |effects| of(effects).rest_s(9) / of(effects).reduced_s;
        assert_eq!(expected_ms(plain), MARGIN);
        // Nine of ten take 2 ms at their own pace, one takes 5 ms.
        (0..STRIKES[0]).for_each(|strike| {
            costs.learn(hulls, &took([1.0, 2.0][strike % 2], if strike % 10 == 3 { 5e-3 } else { 2e-3 }))
        });
        assert!((expected_ms(hulls) - 5.0).abs() < 1e-9, "{}", expected_ms(hulls));
        assert_eq!(expected_ms(plain), MARGIN);
        assert_eq!((of(hulls).reduced_s, costs.of(hulls, true)), (2e-3, costs.of(plain, true)));
        (0..STRIKES[0] - 3).for_each(|_| costs.learn(hulls, &took(1.0, 2e-3)));
        assert!((expected_ms(hulls) - 2.0).abs() < 1e-9, "old requests are forgotten");
        assert_eq!(of(hulls).reduced_s, 1e-3);
        costs.learn(hulls, &took(1.0, 0.0));
        costs.learn(plain, &took(1.0, 0.5e-3));
        assert_eq!(expected_ms(plain), MARGIN, "one request changes little");
        (1..STRIKES[1]).for_each(|_| costs.learn(plain, &took(1.0, 0.5e-3)));
        assert!((expected_ms(plain) - 0.5).abs() < 1e-9);
    }
}
