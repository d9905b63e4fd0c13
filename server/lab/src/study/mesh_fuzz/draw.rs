//! Random choices of a defect: strength, place, number.

use nalgebra::Vector3;
use shatter_fracture::random::RandomStream;

/// Random stream of choices.
pub(super) struct ChoiceStream(RandomStream);

impl ChoiceStream {
    /// Creates the stream determined by (seed, stream).
    pub fn new(seed: u64, stream: u64) -> Self {
        Self(RandomStream::new(seed, stream))
    }

    /// Uniform number in [low, high).
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.uniform()
    }

    /// Ten to a power that is uniform in [low, high).
    pub fn decade(&mut self, low: f64, high: f64) -> f64 {
        10f64.powf(self.between(low, high))
    }

    /// Index below `count`; 0 if `count` is 0.
    pub fn below(&mut self, count: usize) -> usize {
        ((self.0.uniform() * count as f64) as usize).min(count.saturating_sub(1))
    }

    /// True with probability `share`.
    pub fn chance(&mut self, share: f64) -> bool {
        self.0.uniform() < share
    }

    /// Number of damaged elements: at least one, at most `share` of `count`, more often small than large.
    pub fn few(&mut self, count: usize, share: f64) -> usize {
        let most = (count as f64 * share).max(1.0);
        1 + (self.0.uniform().powi(2) * (most - 1.0)) as usize
    }

    /// Unit vector, uniform over the sphere.
    pub fn direction(&mut self) -> Vector3<f64> {
        let z = self.between(-1.0, 1.0);
        let (sine, cosine) = self.between(0.0, std::f64::consts::TAU).sin_cos();
        let radius = (1.0 - z * z).sqrt();
        Vector3::new(radius * cosine, radius * sine, z)
    }
}
