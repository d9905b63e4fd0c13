//! Schedule of requests: due times and targets, drawn from a seed.

use super::plan::{ClientPlan, LoadTarget};
use fastrand::Rng;
use std::time::Duration;

/// Random source of due times, targets and contacts.
pub struct Schedule {
    random: Rng,
    rate: Option<f64>,
    due: Duration,
    weights: Vec<f64>,
}

impl Schedule {
    /// Creates the schedule of a plan.
    pub fn new(plan: &ClientPlan) -> Self {
        let sum: f64 = plan.targets.iter().map(|target| target.weight).sum();
        let weights = plan.targets.iter().map(|LoadTarget { weight, .. }| weight / sum).collect();
        Self { random: Rng::with_seed(plan.seed), rate: plan.rate, due: Duration::ZERO, weights }
    }

    /// Due time of the next request, from the start of the run; exponential pauses make a Poisson process. `None` without a rate.
    pub fn next(&mut self) -> Option<Duration> {
        let rate = self.rate?;
        let pause = -(1.0 - self.random.f64()).ln() / rate;
        self.due += Duration::from_secs_f64(pause);
        Some(self.due)
    }

    /// Index of the next target.
    pub fn target(&mut self) -> usize {
        let mut left = self.random.f64();
        let found = self.weights.iter().position(|weight| {
            left -= weight;
            left < 0.0
        });
        found.unwrap_or(self.weights.len() - 1)
    }

    /// Random index below `count`.
    pub fn pick(&mut self, count: usize) -> usize {
        self.random.usize(..count)
    }

    /// Seed for a request.
    pub fn seed(&mut self) -> u64 {
        self.random.u64(..)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(rate: Option<f64>) -> ClientPlan {
        let target = |object: &str, weight| LoadTarget { object: object.to_owned(), weight, degree: 1 };
        let targets = vec![target("often", 9.0), target("seldom", 1.0)];
        ClientPlan { targets, rate, seconds: 1.0, deadline_ms: None, seed: 3, begin_unix_ns: 0 }
    }

    #[test]
    fn arrivals_have_the_rate_and_the_spread_of_a_poisson_process() {
        let mut schedule = Schedule::new(&plan(Some(200.0)));
        let due: Vec<f64> = (0..20_000).map(|_| schedule.next().unwrap().as_secs_f64()).collect();
        assert!((due[19_999] / 100.0 - 1.0).abs() < 0.03, "{}", due[19_999]);
        let pauses: Vec<f64> = due.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let mean = pauses.iter().sum::<f64>() / pauses.len() as f64;
        let variance = pauses.iter().map(|pause| (pause - mean).powi(2)).sum::<f64>() / pauses.len() as f64;
        assert!((variance.sqrt() / mean - 1.0).abs() < 0.05, "{mean} {variance}");
        assert_eq!(Schedule::new(&plan(None)).next(), None);
    }

    #[test]
    fn targets_come_by_their_weights_and_a_seed_decides_all() {
        let draw = || {
            let mut schedule = Schedule::new(&plan(Some(1.0)));
            (0..1000).map(|_| schedule.target()).collect::<Vec<_>>()
        };
        let often = draw().iter().filter(|target| **target == 0).count();
        assert!((860..940).contains(&often), "{often}");
        assert_eq!(draw(), draw());
    }
}
