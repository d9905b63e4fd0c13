//! How long strikes take: what is expected of the next one by what the last ones of its kind took.

use shatter_proto::request::{Degree, Purpose, Strike};
use std::collections::HashMap;
use std::time::Duration;

/// Weight of the last strike.
const WEIGHT: f64 = 0.25;

/// What an expectation that kept a strike from computing is multiplied by: one that is too high is then corrected, if not by strikes
/// that compute, by those that may not.
const DOUBT: f64 = 0.9;

/// Kinds of work that are remembered; the memory is begun anew beyond.
const WORK_MAX: usize = 4096;

/// A kind of work: strikes of one kind take about as long.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Work {
    object: String,
    /// Rule of the degree; for a number of sites its magnitude.
    rule: u32,
}

impl Work {
    /// What `strike` asks for.
    pub fn of(strike: &Strike) -> Self {
        let rule = match (strike.purpose, strike.degree) {
            (Purpose::Threshold, _) => 0,
            (_, Degree::Inferred | Degree::ClosedForm) => 1,
            (_, Degree::Verified) => 2,
            (_, Degree::Optimised) => 3,
            (_, Degree::Sites(sites)) => 4 + sites.max(1).ilog2(),
        };
        Self { object: strike.object.clone(), rule }
    }
}

/// Moving averages by kind of work.
#[derive(Default)]
pub struct Forecast {
    means: HashMap<Work, Duration>,
}

impl Forecast {
    /// How long such a strike computes; `None`: none has yet.
    pub fn of(&self, work: &Work) -> Option<Duration> {
        self.means.get(work).copied()
    }

    /// One has computed for `time`.
    pub fn learn(&mut self, work: &Work, time: Duration) {
        if let Some(mean) = self.means.get_mut(work) {
            *mean = mean.mul_f64(1.0 - WEIGHT) + time.mul_f64(WEIGHT);
            return;
        }
        if self.means.len() >= WORK_MAX {
            self.means.clear();
        }
        self.means.insert(work.clone(), time);
    }

    /// One was refused for what was expected of it.
    pub fn doubt(&mut self, work: &Work) {
        if let Some(mean) = self.means.get_mut(work) {
            *mean = mean.mul_f64(DOUBT);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn work(object: &str, degree: Degree) -> Work {
        Work::of(&Strike { object: object.to_owned(), degree, ..Strike::default() })
    }

    #[test]
    fn the_mean_follows_what_strikes_take() {
        let mut forecast = Forecast::default();
        let vase = work("vase", Degree::Sites(20));
        assert_eq!(forecast.of(&vase), None);
        forecast.learn(&vase, Duration::from_millis(8));
        assert_eq!(forecast.of(&vase), Some(Duration::from_millis(8)));
        (0..40).for_each(|_| forecast.learn(&vase, Duration::from_millis(20)));
        assert!(forecast.of(&vase).unwrap().abs_diff(Duration::from_millis(20)) < Duration::from_micros(10));
        assert_eq!(forecast.of(&work("vase", Degree::Sites(31))), forecast.of(&vase), "about as many");
        for other in
            [work("statue", Degree::Sites(20)), work("vase", Degree::Sites(512)), work("vase", Degree::Optimised)]
        {
            assert_eq!(forecast.of(&other), None);
        }
    }

    #[test]
    fn what_keeps_strikes_from_computing_does_not_do_so_for_ever() {
        let mut forecast = Forecast::default();
        let vase = work("vase", Degree::Inferred);
        forecast.learn(&vase, Duration::from_secs(1));
        let refused = (0..).take_while(|_| {
            let refuse = forecast.of(&vase).unwrap() > Duration::from_millis(60);
            forecast.doubt(&vase);
            refuse
        });
        assert!(refused.count() < 30);
    }
}
