//! Random choices of a defect: how strong, where, how many.

use nalgebra::Vector3;
use shatter_fracture::random::RandomStream;

/// A stream of choices.
pub(super) struct ChoiceStream(RandomStream);

impl ChoiceStream {
    /// Determined by (seed, stream).
    pub fn new(seed: u64, stream: u64) -> Self {
        Self(RandomStream::new(seed, stream))
    }

    /// Uniform in [low, high).
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.uniform()
    }

    /// Ten to a power that is uniform in [low, high).
    pub fn decade(&mut self, low: f64, high: f64) -> f64 {
        10f64.powf(self.between(low, high))
    }

    /// One of 0 .. count; 0 of none.
    pub fn below(&mut self, count: usize) -> usize {
        ((self.0.uniform() * count as f64) as usize).min(count.saturating_sub(1))
    }

    /// True in `share` of all cases.
    pub fn chance(&mut self, share: f64) -> bool {
        self.0.uniform() < share
    }

    /// A number of things to spoil: at least one, at most `share` of `count`, more often few than many.
    pub fn few(&mut self, count: usize, share: f64) -> usize {
        let most = (count as f64 * share).max(1.0);
        1 + (self.0.uniform().powi(2) * (most - 1.0)) as usize
    }

    /// A unit vector, uniform over the sphere.
    pub fn direction(&mut self) -> Vector3<f64> {
        let z = self.between(-1.0, 1.0);
        let (sine, cosine) = self.between(0.0, std::f64::consts::TAU).sin_cos();
        let radius = (1.0 - z * z).sqrt();
        Vector3::new(radius * cosine, radius * sine, z)
    }
}
