//! Forecast of computing times, from the times of recent requests of the same kind.

use shatter_proto::request::{DegreeRule, Purpose, Request};
use std::collections::HashMap;
use std::time::{Duration, Instant};

/// Weight of the latest request in the moving average.
const WEIGHT: f64 = 0.25;

/// Minimum time between two reductions of a forecast, so that a burst of impossible requests does not distort it.
const REDUCTION_INTERVAL: Duration = Duration::from_millis(100);

/// Factor that reduces a forecast which kept a request from computing. A forecast that is too high is thus corrected by refused
/// requests, too, not only by those that compute.
const REDUCTION_FACTOR: f64 = 0.9;

/// Maximum number of kinds of work; beyond it the forecast starts again.
const WORK_MAX: usize = 4096;

/// Kind of work: requests of one kind take about the same time.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct WorkKind {
    object: String,
    /// Rule of the degree; for a number of sites its order of magnitude.
    rule: u32,
    /// Effects that are switched on and off, lift, source of displacements, whether a fragment is struck, preset, iterations; error and
    /// time by their orders of magnitude.
    how: [u64; 10],
}

impl WorkKind {
    /// Kind of work of `strike`.
    pub fn of(strike: &Request) -> Self {
        let rule = match (strike.purpose, strike.degree) {
            (Purpose::Threshold, _) => 0,
            (Purpose::Aim, _) => u32::MAX,
            (_, DegreeRule::Preset | DegreeRule::Inferred | DegreeRule::ClosedForm) => 1,
            (_, DegreeRule::Verified) => 2,
            (_, DegreeRule::Optimized) => 3,
            (_, DegreeRule::Sites(sites)) => 4 + sites.max(1).ilog2(),
        };
        let lift = strike.lift.map_or(0, |lift| 1 + lift as u64);
        let again = u64::from(strike.from.is_some());
        let magnitude = |value: Option<f64>| value.map_or(0, |value| value.to_bits() >> 52);
        let how = [
            strike.enable.bits(),
            strike.disable.bits(),
            lift,
            strike.elastic as u64,
            strike.surface as u64,
            again,
            strike.quality.map_or(0, |quality| quality.number().into()),
            strike.iterations_max.map_or(0, |count| 1 + u64::from(count)),
            magnitude(strike.error_max),
            magnitude(strike.time_ms_max),
        ];
        Self { object: strike.object.clone(), rule, how }
    }
}

/// Moving averages by kind of work.
#[derive(Default)]
pub struct Forecast {
    means: HashMap<WorkKind, MovingAverage>,
}

/// Moving average of computing times.
struct MovingAverage {
    time: Duration,
    reduced: Option<Instant>,
}

impl Forecast {
    /// Expected computing time; `None` if no request of this kind has computed yet.
    pub fn of(&self, work: &WorkKind) -> Option<Duration> {
        self.means.get(work).map(|mean| mean.time)
    }

    /// Records that a request has computed for `time`.
    pub fn learn(&mut self, work: &WorkKind, time: Duration) {
        if let Some(mean) = self.means.get_mut(work) {
            mean.time = mean.time.mul_f64(1.0 - WEIGHT) + time.mul_f64(WEIGHT);
            return;
        }
        if self.means.len() >= WORK_MAX {
            self.means.clear();
        }
        self.means.insert(work.clone(), MovingAverage { time, reduced: None });
    }

    /// Records that a request was stopped at its deadline after `time`, which is a lower bound of its computing time.
    pub fn learn_lower_bound(&mut self, work: &WorkKind, time: Duration) {
        if self.of(work).is_none_or(|mean| mean < time) {
            self.learn(work, time);
        }
    }

    /// Records that a request was refused at this moment because of its forecast.
    pub fn reduce_estimate(&mut self, work: &WorkKind, at: Instant) {
        let Some(mean) = self.means.get_mut(work) else { return };
        if mean.reduced.is_none_or(|last| at.saturating_duration_since(last) >= REDUCTION_INTERVAL) {
            (mean.time, mean.reduced) = (mean.time.mul_f64(REDUCTION_FACTOR), Some(at));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn work(object: &str, degree: DegreeRule) -> WorkKind {
        WorkKind::of(&Request { object: object.to_owned(), degree, ..Request::default() })
    }

    #[test]
    fn the_mean_follows_what_strikes_take() {
        let mut forecast = Forecast::default();
        let vase = work("vase", DegreeRule::Sites(20));
        assert_eq!(forecast.of(&vase), None);
        forecast.learn(&vase, Duration::from_millis(8));
        assert_eq!(forecast.of(&vase), Some(Duration::from_millis(8)));
        (0..40).for_each(|_| forecast.learn(&vase, Duration::from_millis(20)));
        assert!(forecast.of(&vase).unwrap().abs_diff(Duration::from_millis(20)) < Duration::from_micros(10));
        assert_eq!(forecast.of(&work("vase", DegreeRule::Sites(31))), forecast.of(&vase), "a similar number of sites");
        for other in [
            work("statue", DegreeRule::Sites(20)),
            work("vase", DegreeRule::Sites(512)),
            work("vase", DegreeRule::Optimized),
        ] {
            assert_eq!(forecast.of(&other), None);
        }
    }

    #[test]
    fn a_too_high_estimate_recovers() {
        let mut forecast = Forecast::default();
        let vase = work("vase", DegreeRule::Inferred);
        forecast.learn(&vase, Duration::from_secs(1));
        let begun = Instant::now();
        let mut refused = |pause: Duration| {
            let refuses = |k: &u32| {
                let refuse = forecast.of(&vase).unwrap() > Duration::from_millis(60);
                forecast.reduce_estimate(&vase, begun + *k * pause);
                refuse
            };
            (1..200).take_while(refuses).count()
        };
        assert_eq!(refused(Duration::from_micros(1)), 199, "a burst reduces the forecast once");
        assert!(refused(REDUCTION_INTERVAL) < 30);
    }

    #[test]
    fn a_canceled_request_gives_a_lower_bound() {
        let mut forecast = Forecast::default();
        let vase = work("vase", DegreeRule::Inferred);
        let ms = Duration::from_millis;
        forecast.learn_lower_bound(&vase, ms(30));
        forecast.learn_lower_bound(&vase, ms(10));
        assert_eq!(forecast.of(&vase), Some(ms(30)));
        forecast.learn_lower_bound(&vase, ms(50));
        assert_eq!(forecast.of(&vase), Some(ms(35)));
    }
}
