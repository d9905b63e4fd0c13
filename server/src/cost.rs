//! What strikes of an object take on this machine: measured when it is loaded, corrected by every strike.
//!
//! It belongs to no database: those have the same bytes wherever they are baked, and are served elsewhere.

use shatter_fracture::pipeline::{Cost, CostSample};
use shatter_proto::effect::Effects;
use std::collections::HashMap;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// What follows a diagram is expected to take so many times what was measured, until strikes say more.
const MARGIN: f64 = 1.2;

/// Weights of a strike that took longer than expected, and of one that did not: what is expected is what few strikes exceed.
const WEIGHTS: [f64; 2] = [0.5, 0.05];

/// Sets of effects that are told apart; the memory is begun anew beyond.
const EFFECTS_MAX: usize = 256;

/// What is known of one object.
pub struct Costs(Mutex<Known>);

struct Known {
    cost: Cost,
    measured: bool,
    /// By the bits of the effects: factor of what follows a diagram, and strikes that it is from.
    rests: HashMap<u64, (f64, u32)>,
}

impl Costs {
    /// Of an object that takes about so much.
    pub fn new(cost: Cost) -> Self {
        Self(Mutex::new(Known { cost, measured: false, rests: HashMap::new() }))
    }

    fn known(&self) -> MutexGuard<'_, Known> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What a strike with these effects is expected to take.
    pub fn of(&self, effects: Effects) -> Cost {
        let known = self.known();
        known.cost.with_rest(known.rests.get(&effects.bits()).map_or(MARGIN, |rest| rest.0))
    }

    /// Whether it was measured.
    pub fn is_measured(&self) -> bool {
        self.known().measured
    }

    /// It was measured.
    pub fn measured(&self, samples: &[CostSample]) {
        if let Some(cost) = Cost::fit(samples) {
            *self.known() = Known { cost, measured: true, rests: HashMap::new() };
        }
    }

    /// What followed the diagrams of a strike of so many sites took so long.
    pub fn learn(&self, effects: Effects, sites: u32, rest: Duration) {
        let mut known = self.known();
        let ratio = rest.as_secs_f64() / known.cost.rest_s(sites);
        if !ratio.is_normal() {
            return;
        }
        if known.rests.len() >= EFFECTS_MAX {
            known.rests.clear();
        }
        let (factor, strikes) = known.rests.entry(effects.bits()).or_insert((MARGIN, 0));
        *strikes = strikes.saturating_add(1);
        let [longer, shorter] = WEIGHTS;
        // The first ones say most: what was measured was measured on one thread.
        let weight = if ratio > *factor { longer } else { shorter.max(0.5 / f64::from(*strikes)) };
        *factor += weight * (ratio - *factor);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shatter_proto::effect::Effect;

    #[test]
    fn what_follows_a_diagram_is_learned_by_effects() {
        let cost = Cost {
            reduced_s: 1e-3,
            solve_s: 2e-3,
            start_s: [1e-3, 0.0],
            iteration_s: [1e-3, 0.0],
            rest_s: [1e-3, 0.0],
        };
        let costs = Costs::new(cost);
        let (plain, hulls) = (Effects::default(), Effects::of([Effect::Hulls]));
        assert_eq!(costs.of(plain).rest_s(9), MARGIN * 1e-3);
        (0..9).for_each(|_| costs.learn(hulls, 9, Duration::from_millis(5)));
        let learned = costs.of(hulls).rest_s(9);
        assert!((4.9e-3..5e-3).contains(&learned), "{learned}");
        assert_eq!(costs.of(plain).rest_s(9), MARGIN * 1e-3);
        costs.learn(hulls, 9, Duration::from_millis(1));
        assert!(costs.of(hulls).rest_s(9) > 4.6e-3, "one that was fast changes little");
        costs.learn(hulls, 9, Duration::ZERO);
    }
}
