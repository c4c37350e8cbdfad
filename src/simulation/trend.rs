use serde::{Deserialize, Serialize};

/// The most blocks of time for which a batch keeps the sums of squares of its states; of more, neighbours are joined.
const MOST_BLOCKS: usize = 32;

/// Σ 1 and Σ x_i² over equal blocks of time, however long the simulation becomes: when all blocks are full, neighbours
/// are joined and blocks are twice as long from there on.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(super) struct Trend {
    /// Samples of each trajectory in a block.
    length: usize,
    /// The numbers of a block.
    width: usize,
    /// Σ 1 and Σ x_i² of each block, one after another.
    sums: Vec<f64>,
}

impl Trend {
    pub(super) fn new(states: usize) -> Self {
        let width = states + 1;
        Trend { length: 1, width, sums: Vec::with_capacity(MOST_BLOCKS * width) }
    }

    /// Adds a state, which is sample number `sample` of its trajectory, from 0.
    pub(super) fn add(&mut self, sample: usize, x: &[f64]) {
        let width = self.width;
        while sample / self.length >= MOST_BLOCKS {
            let joined = self.sums.chunks(2 * width).flat_map(|pair| {
                let (first, second) = pair.split_at(width);
                first.iter().enumerate().map(move |(i, sum)| sum + second.get(i).copied().unwrap_or(0.0))
            });
            self.sums = joined.collect();
            self.length *= 2;
        }
        let block = sample / self.length * width;
        if block >= self.sums.len() {
            self.sums.resize(block + width, 0.0);
        }
        let sums = &mut self.sums[block..block + width];
        sums[0] += 1.0;
        for (sum, x) in sums[1..].iter_mut().zip(x) {
            *sum += x * x;
        }
    }

    /// Σ 1 and Σ x_i² for state i over the earlier and the later half of `samples` samples of each trajectory, to a block.
    pub(super) fn halves(&self, i: usize, samples: usize) -> [(f64, f64); 2] {
        let mut halves = [(0.0, 0.0); 2];
        for (k, sums) in self.sums.chunks_exact(self.width).enumerate() {
            let half = &mut halves[usize::from((2 * k + 1) * self.length > samples)];
            half.0 += sums[0];
            half.1 += sums[i + 1];
        }
        halves
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_joined_and_the_halves_are_halves() {
        for samples in [1_usize, 2, 3, 32, 33, 64, 65, 1000] {
            let mut trend = Trend::new(1);
            (0..samples).for_each(|k| trend.add(k, &[(k as f64).sqrt()]));
            let [(early, first), (late, second)] = trend.halves(0, samples);
            assert_eq!(early + late, samples as f64);
            // Sums of square roots squared are off by a rounding each.
            let all = (samples * (samples - 1) / 2) as f64;
            assert!((first + second - all).abs() <= 1e-12 * all);
            assert!((early - late).abs() <= trend.length as f64, "{samples}: {early} and {late}");
        }
    }
}
