//! How long strikes take: what is expected of the next one by what the last ones of its object took.

use std::collections::HashMap;
use std::time::Duration;

/// Weight of the last strike.
const WEIGHT: f64 = 0.25;

/// Objects that are remembered; the memory is begun anew beyond.
const OBJECTS_MAX: usize = 4096;

/// Moving averages by object.
#[derive(Default)]
pub struct Forecast {
    means: HashMap<String, Duration>,
}

impl Forecast {
    /// How long a strike of `object` computes; `None`: none has yet.
    pub fn of(&self, object: &str) -> Option<Duration> {
        self.means.get(object).copied()
    }

    /// One has computed for `time`.
    pub fn learn(&mut self, object: &str, time: Duration) {
        if let Some(mean) = self.means.get_mut(object) {
            *mean = mean.mul_f64(1.0 - WEIGHT) + time.mul_f64(WEIGHT);
            return;
        }
        if self.means.len() >= OBJECTS_MAX {
            self.means.clear();
        }
        self.means.insert(object.to_owned(), time);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_follows_what_strikes_take() {
        let mut forecast = Forecast::default();
        assert_eq!(forecast.of("vase"), None);
        forecast.learn("vase", Duration::from_millis(8));
        assert_eq!(forecast.of("vase"), Some(Duration::from_millis(8)));
        (0..40).for_each(|_| forecast.learn("vase", Duration::from_millis(20)));
        assert!(forecast.of("vase").unwrap().abs_diff(Duration::from_millis(20)) < Duration::from_micros(10));
        assert_eq!(forecast.of("statue"), None);
    }
}
