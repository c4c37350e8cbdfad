use super::{boundaries::Boundaries, images::Images, layout::TallyLayout, passage::Record, scheme::Scheme};
use crate::field::{LANES, Lane};
use pulp::{Arch, NullaryFnOnce};
use serde::{Deserialize, Serialize};

/// Sums over blocks of consecutive samples of one trajectory, which the regression on control variates is made from.
///
/// Let s be the sums over a block of the tracked functions h, which are the monomials and the powers of speed at passages,
/// and of R = 𝓖ψ with the jumps of ψ at impacts. Kept are Σ s and the products Σ R s of the closed blocks: they estimate the
/// covariances of means over a whole trajectory, correlations within a block included. A block that begins after n samples is
/// 2√n samples long, so that blocks outlast every memory in the end and grow in number as well. All trajectories of a batch
/// begin a block at the same time.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub(super) struct Blocks {
    trajectories: usize,
    /// The samples before the open block.
    begun: usize,
    /// The number of closed blocks.
    pub(super) count: f64,
    /// Σ s over the closed blocks.
    pub(super) closed: Vec<f64>,
    /// The sums of the open block, those of one group of trajectories after the other.
    open: Vec<Lane>,
    /// Σ L h with the length L of a block, and then Σ R_k s, row by row; row k has the tracked functions and R_0 to R_k.
    products: Vec<f64>,
}

/// The place of row k of the products, where so many sums are tracked.
fn row(k: usize, tracked: usize) -> usize {
    (k + 1) * tracked + k * (k + 1) / 2
}

/// The length of the block that begins after so many samples.
fn length(samples: usize) -> usize {
    samples.saturating_mul(4).isqrt().max(1)
}

impl Blocks {
    /// Before the first sample of so many trajectories.
    pub(super) fn new(trajectories: usize, layout: &TallyLayout) -> Self {
        let (tracked, controls) = (layout.tracked(), layout.control_variates.len());
        if controls == 0 {
            return Blocks::default();
        }
        let width = tracked + controls;
        Blocks {
            trajectories,
            begun: 0,
            count: 0.0,
            closed: vec![0.0; width],
            open: vec![Lane::ZERO; trajectories.div_ceil(LANES) * width],
            products: vec![0.0; row(controls, tracked)],
        }
    }

    /// Adds one sample of each trajectory of group number `group`, and the passages since the one before.
    pub(super) fn add(
        &mut self,
        group: usize,
        x: &[Lane],
        record: &Record,
        layout: &TallyLayout,
        scene: (&Scheme<'_>, &Boundaries),
        images: &mut Images,
    ) {
        let width = self.closed.len();
        let sums = &mut self.open[group * width..][..width];
        images.add(layout, scene, x, sums);
        images.add_passages(layout, scene.1, record, sums);
    }

    /// Closes the block where it ends after so many samples of each trajectory.
    pub(super) fn close(&mut self, samples: usize, layout: &TallyLayout, arch: Arch, images: &mut Images) {
        if self.open.is_empty() || samples < self.begun + length(self.begun) {
            return;
        }
        self.begun = samples;
        self.count += self.trajectories as f64;
        let (tracked, width) = (layout.tracked(), self.closed.len());
        let rows = &mut images.rows;
        for (group, sums) in self.open.chunks_exact(width).enumerate() {
            let active = (self.trajectories - group * LANES).min(LANES);
            for (i, lanes) in sums.iter().enumerate() {
                for l in 0..active {
                    rows[l * width + i] = lanes[l];
                    self.closed[i] += lanes[l];
                }
            }
            let products = &mut self.products;
            arch.dispatch(AddProducts { rows: &rows[..active * width], width, tracked, products });
        }
        self.open.fill(Lane::ZERO);
    }

    /// Σ s over all samples.
    pub(super) fn total(&self) -> Vec<f64> {
        let width = self.closed.len().max(1);
        let mut total = self.closed.clone();
        for (group, sums) in self.open.chunks_exact(width).enumerate() {
            let active = (self.trajectories - group * LANES).min(LANES);
            for (total, lanes) in total.iter_mut().zip(sums) {
                *total += lanes.0[..active].iter().sum::<f64>();
            }
        }
        total
    }

    /// Adds the closed blocks of another batch.
    pub(super) fn join(&mut self, other: &Blocks) {
        self.count += other.count;
        let lists = [(&mut self.closed, &other.closed), (&mut self.products, &other.products)];
        for (sums, others) in lists {
            sums.iter_mut().zip(others).for_each(|(sum, other)| *sum += other);
        }
    }

    /// Σ L².
    pub(super) fn squared_lengths(&self) -> f64 {
        self.products[0]
    }

    /// The mean of number `i` of s over all samples in closed blocks. The first monomial is 1, so that its sums are lengths.
    pub(super) fn mean(&self, i: usize) -> f64 {
        self.closed[i] / self.closed[0]
    }

    /// Σ (R_k − L R̄_k)(h_l − L h̄_l).
    pub(super) fn mixed(&self, k: usize, l: usize, tracked: usize) -> f64 {
        let row = &self.products[row(k, tracked)..];
        let (r, h) = (self.mean(tracked + k), self.mean(l));
        row[l] - h * row[0] - r * self.products[l] + r * h * self.squared_lengths()
    }

    /// Σ (R_k − L R̄_k)(R_l − L R̄_l), l ≤ k.
    pub(super) fn square(&self, k: usize, l: usize, tracked: usize) -> f64 {
        let [first, second] = [k, l].map(|k| &self.products[row(k, tracked)..]);
        let [r, other] = [k, l].map(|k| self.mean(tracked + k));
        first[tracked + l] - other * first[0] - r * second[0] + r * other * self.squared_lengths()
    }
}

/// Adds Σ R s over some blocks, as a call that is compiled for every width of registers. Their width changes nothing but
/// the speed.
struct AddProducts<'a> {
    /// The sums s of one block after the other.
    rows: &'a [f64],
    width: usize,
    tracked: usize,
    products: &'a mut [f64],
}

impl NullaryFnOnce for AddProducts<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let AddProducts { rows, width, tracked, products } = self;
        for s in rows.chunks_exact(width) {
            let (lengths, mut left) = products.split_at_mut(tracked);
            add(lengths, s[0], s);
            for k in tracked..width {
                let (own, rest) = left.split_at_mut(k + 1);
                add(own, s[k], s);
                left = rest;
            }
        }
    }
}

/// Adds `factor` times the first of `s` to as many sums.
#[inline(always)]
fn add(sums: &mut [f64], factor: f64, s: &[f64]) {
    for (sum, s) in sums.iter_mut().zip(s) {
        *sum += factor * s;
    }
}
