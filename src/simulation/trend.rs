use super::store::stored;

/// The most blocks of time that are kept.
const BLOCKS: usize = 32;

/// Σ 1 and Σ x_i² over equal blocks of time, however long the simulation becomes: when all blocks are full, neighbours
/// are joined and blocks are twice as long from there on.
#[derive(Clone, Debug)]
pub(super) struct Trend<const N: usize> {
    /// Samples of each trajectory in a block.
    length: usize,
    blocks: Vec<(f64, [f64; N])>,
}
stored!(Trend[N] { length, blocks });

impl<const N: usize> Trend<N> {
    pub(super) fn new() -> Self {
        Trend { length: 1, blocks: Vec::with_capacity(BLOCKS) }
    }

    /// Adds a state, which is sample number `sample` of its trajectory, from 0.
    pub(super) fn add(&mut self, sample: usize, x: [f64; N]) {
        while sample / self.length >= BLOCKS {
            let joined = self.blocks.chunks(2).map(|pair| {
                pair.iter().fold((0.0, [0.0; N]), |(n, squares), (m, more)| {
                    (n + m, std::array::from_fn(|i| squares[i] + more[i]))
                })
            });
            self.blocks = joined.collect();
            self.length *= 2;
        }
        let block = sample / self.length;
        if block >= self.blocks.len() {
            self.blocks.resize(block + 1, (0.0, [0.0; N]));
        }
        let (count, squares) = &mut self.blocks[block];
        *count += 1.0;
        for i in 0..N {
            squares[i] += x[i] * x[i];
        }
    }

    /// Σ 1 and Σ x_i² for state i over the earlier and the later half of `samples` samples of each trajectory, to a block.
    pub(super) fn halves(&self, i: usize, samples: usize) -> [(f64, f64); 2] {
        let mut halves = [(0.0, 0.0); 2];
        for (k, (count, squares)) in self.blocks.iter().enumerate() {
            let half = &mut halves[usize::from((2 * k + 1) * self.length > samples)];
            half.0 += count;
            half.1 += squares[i];
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
            let mut trend = Trend::<1>::new();
            (0..samples).for_each(|k| trend.add(k, [(k as f64).sqrt()]));
            assert!(trend.blocks.len() <= BLOCKS);
            let [(early, first), (late, second)] = trend.halves(0, samples);
            assert_eq!(early + late, samples as f64);
            // Sums of square roots squared are off by a rounding each.
            let all = (samples * (samples - 1) / 2) as f64;
            assert!((first + second - all).abs() <= 1e-12 * all);
            assert!((early - late).abs() <= trend.length as f64, "{samples}: {early} and {late}");
        }
    }
}
