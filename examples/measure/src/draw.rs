//! Random numbers of campaigns.

use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

/// Random parameters; an index has its own stream, so that it means the same in a campaign of any length.
pub(crate) struct Draw(ChaCha8Rng);

impl Draw {
    pub(crate) fn new(seed: u64, index: usize) -> Self {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(index as u64);
        Draw(generator)
    }

    pub(crate) fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.random::<f64>()
    }

    pub(crate) fn log_within(&mut self, low: f64, high: f64) -> f64 {
        self.within(low.ln(), high.ln()).exp()
    }

    /// One of `count` indices.
    pub(crate) fn below(&mut self, count: usize) -> usize {
        ((self.0.random::<f64>() * count as f64) as usize).min(count.saturating_sub(1))
    }

    /// One of some values.
    pub(crate) fn of<T: Copy, const N: usize>(&mut self, values: [T; N]) -> T {
        values[self.below(N)]
    }

    pub(crate) fn with(&mut self, probability: f64) -> bool {
        self.0.random::<f64>() < probability
    }
}
