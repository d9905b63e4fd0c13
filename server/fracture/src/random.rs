//! Counter-based random numbers.
//!
//! The same (seed, stream, index) yields the same number on every machine and for any number of threads.
//!
//! Based on: D. J. Bernstein, *ChaCha, a variant of Salsa20* (2008), eight rounds, through `rand_chacha`.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Stream of random numbers, determined by (seed, stream) alone.
pub struct RandomStream(ChaCha8Rng);

impl RandomStream {
    /// Creates stream number `stream` of `seed`. Streams of one seed are independent.
    pub fn new(seed: u64, stream: u64) -> Self {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(stream);
        Self(generator)
    }

    /// Next number, uniform in [0, 1), with 53 random bits.
    pub fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * (1.0 / 9_007_199_254_740_992.0)
    }

    /// Next 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0.next_u64()
    }
}
