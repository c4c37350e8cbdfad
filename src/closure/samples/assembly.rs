//! Means of products of functions over the pilot's states, block by block.

use super::products::{LANES, Lane, Products, Scratch, ZERO};
use super::sites::{Site, Sites};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use rayon::prelude::*;

/// States in a block: its tables stay in a core's cache.
const BLOCK: usize = 512;
/// Matrices that are summed side by side hold about so many numbers together.
const ROOM: usize = 30_000_000;

/// Functions at the sites.
#[derive(Clone, Copy, Debug)]
pub(super) struct Assembly<'a> {
    pub(super) products: &'a Products,
    pub(super) sites: &'a Sites,
}

impl Assembly<'_> {
    /// E[φ_k φ_l].
    pub(super) fn gram(&self) -> Mat<f64> {
        self.mean(self.sites.len(), &[Products::value], |_, _| ())
    }

    /// E[φ_k Aφ_l] for an operator A = b·∇ + ½ B:∇∇, whose b `first` leaves in the scratch room of a site.
    pub(super) fn images(&self, first: impl Fn(&Site, &mut Scratch) + Sync) -> Mat<f64> {
        self.mean(self.sites.len(), &[Products::value, Products::image], |site, scratch| {
            first(site, scratch);
            self.products.apply(&site.diffusion, &self.sites.coupled, scratch);
        })
    }

    /// Σ_i E[∂φ_k ∂φ_l] along the directions entered for a site, over the first `count` states.
    pub(super) fn slopes(
        &self,
        count: usize,
        directions: usize,
        direction: impl Fn(&Site, usize, &mut [Lane]) + Sync,
    ) -> Mat<f64> {
        let none = vec![ZERO; self.products.dimension().pow(2)];
        let mut sum = Mat::zeros(self.products.len(), self.products.len());
        for i in 0..directions {
            sum += self.mean(count, &[Products::image], |site, scratch| {
                scratch.first.fill(ZERO);
                direction(site, i, &mut scratch.first);
                self.products.apply(&none, &[], scratch);
            });
        }
        sum
    }

    /// E[½ B:∇∇φ_k] over the first `count` states, for a constant diagonal B.
    pub(super) fn curvatures(&self, count: usize, second: &[Lane]) -> Vec<f64> {
        let sites = &self.sites.groups[..count.min(self.sites.len()) / LANES];
        self.means_over(sites, self.products.len(), |site, scratch, sums| {
            self.products.place(&site.x, scratch);
            scratch.first.fill(ZERO);
            self.products.apply(second, &[], scratch);
            for (k, sum) in sums.iter_mut().enumerate() {
                *sum += self.products.image(scratch, k).iter().sum::<f64>();
            }
        })
    }

    /// E[g φ_k] for a function of the state.
    pub(super) fn means(&self, g: impl Fn(&[f64]) -> f64 + Sync) -> Vec<f64> {
        self.means_over(&self.sites.groups, self.products.len(), |site, scratch, sums| {
            self.products.place(&site.x, scratch);
            let g = std::array::from_fn(|l| g(&site.x.iter().map(|x| x[l]).collect::<Vec<_>>()));
            self.add_products(&g, scratch, sums);
        })
    }

    /// E[r φ_k] and E[r²] for the residual r of Q = Σ a_k φ_k.
    pub(super) fn residual(&self, a: &[f64]) -> (Vec<f64>, f64) {
        let size = self.products.len();
        let mut means = self.means_over(&self.sites.groups, size + 1, |site, scratch, sums| {
            let r = self.residual_at(a, site, scratch);
            self.add_products(&r, scratch, &mut sums[..size]);
            sums[size] += r.iter().map(|r| r * r).sum::<f64>();
        });
        let square = means.pop().unwrap_or_default();
        (means, square)
    }

    /// Adds g φ_k at the states of a site where the products are placed.
    fn add_products(&self, g: &Lane, scratch: &Scratch, sums: &mut [f64]) {
        for (k, sum) in sums.iter_mut().enumerate() {
            let value = self.products.value(scratch, k);
            *sum += (0..LANES).map(|l| g[l] * value[l]).sum::<f64>();
        }
    }

    /// The means over sites of what `add` adds to `size` sums at each; block by block, so that no thread makes a difference.
    fn means_over(
        &self,
        sites: &[Site],
        size: usize,
        add: impl Fn(&Site, &mut Scratch, &mut [f64]) + Sync,
    ) -> Vec<f64> {
        let parts: Vec<Vec<f64>> = sites
            .par_chunks(BLOCK / LANES)
            .map_init(
                || self.products.scratch(),
                |scratch, block| {
                    let mut sums = vec![0.0; size];
                    block.iter().for_each(|site| add(site, scratch, &mut sums));
                    sums
                },
            )
            .collect();
        total(&parts, sites.len() * LANES)
    }

    /// The residual at the states of a site; leaves them placed.
    fn residual_at(&self, a: &[f64], site: &Site, scratch: &mut Scratch) -> Lane {
        self.products.place(&site.x, scratch);
        scratch.first.copy_from_slice(&site.backward);
        self.products.apply(&site.diffusion, &self.sites.coupled, scratch);
        let mut r = site.source;
        for (k, a) in a.iter().enumerate() {
            let image = self.products.image(scratch, k);
            (0..LANES).for_each(|l| r[l] += a * image[l]);
        }
        self.products.gradient(a, scratch);
        let slope = &scratch.gradient;
        for &i in &self.sites.noisy {
            for &j in &self.sites.noisy {
                let b = &site.diffusion[i * slope.len() + j];
                (0..LANES).for_each(|l| r[l] += 0.5 * b[l] * slope[i][l] * slope[j][l]);
            }
        }
        r
    }

    /// The first-order part −f + ∂B + B∇Q of the linearised residual L′δ = (−f + ∂B + B∇Q)·∇δ + ½ B:∇∇δ at a site.
    pub(super) fn linearised(&self, a: &[f64], site: &Site, scratch: &mut Scratch) {
        self.products.gradient(a, scratch);
        scratch.first.copy_from_slice(&site.backward);
        let slope = &scratch.gradient;
        for &i in &self.sites.noisy {
            for &j in &self.sites.noisy {
                let b = &site.diffusion[i * slope.len() + j];
                (0..LANES).for_each(|l| scratch.first[i][l] += b[l] * slope[j][l]);
            }
        }
    }

    /// The mean over the first `count` states of left_k right_l, of two `tables` of the functions; of one with itself where
    /// there is only one. `prepare` finds the products placed.
    ///
    /// Every thread sums a stretch of blocks, and the stretches are summed in order. Their number depends on the problem
    /// alone, and so does each rounding.
    fn mean(&self, count: usize, tables: &[Entry], prepare: impl Fn(&Site, &mut Scratch) + Sync) -> Mat<f64> {
        let size = self.products.len();
        let sites = &self.sites.groups[..count.min(self.sites.len()) / LANES];
        let stretches = (ROOM / (size * size)).clamp(2, 64);
        let length = sites.len().div_ceil(stretches).max(1);
        let stretch = |stretch: &[Site]| {
            let mut sum = Mat::zeros(size, size);
            let mut scratch = self.products.scratch();
            let mut room = vec![Mat::<f64>::zeros(BLOCK, size); tables.len()];
            for block in stretch.chunks(BLOCK / LANES) {
                for (group, site) in block.iter().enumerate() {
                    self.products.place(&site.x, &mut scratch);
                    prepare(site, &mut scratch);
                    let rows = group * LANES..(group + 1) * LANES;
                    for (table, entry) in room.iter_mut().zip(tables) {
                        for k in 0..size {
                            table.col_as_slice_mut(k)[rows.clone()].copy_from_slice(entry(self.products, &scratch, k));
                        }
                    }
                }
                let used = block.len() * LANES;
                let (left, right) = (room[0].get(..used, ..), room[tables.len() - 1].get(..used, ..));
                matmul(sum.as_mut(), Accum::Add, left.transpose(), right, 1.0, Par::Seq);
            }
            sum
        };
        let parts: Vec<Mat<f64>> = sites.par_chunks(length).map(stretch).collect();
        let mut sum = Mat::zeros(size, size);
        parts.iter().for_each(|part| sum += part);
        faer::Scale(1.0 / (sites.len() * LANES) as f64) * sum
    }
}

/// What a table holds of a function, at eight states.
type Entry = for<'a> fn(&Products, &'a Scratch, usize) -> &'a Lane;

/// Sums in order, divided by the number of states.
fn total(parts: &[Vec<f64>], count: usize) -> Vec<f64> {
    let mut sums = vec![0.0; parts.first().map_or(0, Vec::len)];
    for part in parts {
        sums.iter_mut().zip(part).for_each(|(sum, part)| *sum += part / count as f64);
    }
    sums
}
