//! Means of products of functions over the pilot's states, block by block.

use super::products::{LANES, Lane, Products, Scratch, Symbols, ZERO};
use super::sites::{Site, Sites};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, Par};
use rayon::prelude::*;

/// States in a block: its tables stay in a core's cache.
const BLOCK: usize = 512;
/// Matrices that are summed side by side hold about so many numbers together.
const ROOM: usize = 30_000_000;

/// Functions at the sites.
#[derive(Clone, Copy, Debug)]
pub(super) struct Assembly<'a, const N: usize> {
    pub(super) products: &'a Products<N>,
    pub(super) sites: &'a Sites<N>,
}

impl<const N: usize> Assembly<'_, N> {
    /// E[φ_k φ_l].
    pub(super) fn gram(&self) -> Mat<f64> {
        self.mean(self.sites.len(), 1, |site, scratch, mut rows| {
            self.products.place(&site.x, scratch);
            self.values(scratch, &mut rows[0]);
        })
    }

    /// E[φ_k Aφ_l] for an operator A = b·∇ + ½ B:∇∇ by its coefficients at a site.
    pub(super) fn images(&self, operator: impl Fn(&Site<N>, &mut Scratch) -> Symbols<N> + Sync) -> Mat<f64> {
        self.mean(self.sites.len(), 2, |site, scratch, mut rows| {
            self.products.place(&site.x, scratch);
            self.values(scratch, &mut rows[0]);
            let symbols = operator(site, scratch);
            self.products.apply(&symbols, &self.sites.coupled, scratch);
            for k in 0..self.products.len() {
                rows[1].column(k).copy_from_slice(self.products.image(scratch, k));
            }
        })
    }

    /// Σ_i E[∂φ_k ∂φ_l] along the directions given at a site, over the first `count` states.
    pub(super) fn slopes(
        &self,
        count: usize,
        directions: usize,
        direction: impl Fn(&Site<N>, usize) -> [Lane; N] + Sync,
    ) -> Mat<f64> {
        let mut sum = Mat::zeros(self.products.len(), self.products.len());
        for i in 0..directions {
            sum += self.mean(count, 1, |site, scratch, mut rows| {
                self.products.place(&site.x, scratch);
                let symbols = Symbols { first: direction(site, i), second: [[ZERO; N]; N] };
                self.products.apply(&symbols, &[], scratch);
                for k in 0..self.products.len() {
                    rows[0].column(k).copy_from_slice(self.products.image(scratch, k));
                }
            });
        }
        sum
    }

    /// E[A φ_k] over the first `count` states.
    pub(super) fn mean_images(&self, count: usize, operator: impl Fn(&Site<N>) -> Symbols<N> + Sync) -> Vec<f64> {
        let sites = &self.sites.groups[..count.min(self.sites.len()) / LANES];
        self.means_over(sites, self.products.len(), |site, scratch, sums| {
            self.products.place(&site.x, scratch);
            self.products.apply(&operator(site), &self.sites.coupled, scratch);
            for (k, sum) in sums.iter_mut().enumerate() {
                *sum += self.products.image(scratch, k).iter().sum::<f64>();
            }
        })
    }

    /// E[g φ_k] for a function of the state.
    pub(super) fn means(&self, g: impl Fn(&[f64; N]) -> f64 + Sync) -> Vec<f64> {
        self.means_over(&self.sites.groups, self.products.len(), |site, scratch, sums| {
            self.products.place(&site.x, scratch);
            let g = std::array::from_fn(|l| g(&site.x.each_ref().map(|x| x[l])));
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
        sites: &[Site<N>],
        size: usize,
        add: impl Fn(&Site<N>, &mut Scratch, &mut [f64]) + Sync,
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
    fn residual_at(&self, a: &[f64], site: &Site<N>, scratch: &mut Scratch) -> Lane {
        self.products.place(&site.x, scratch);
        let linear = Symbols { first: site.backward, second: site.generator.second };
        self.products.apply(&linear, &self.sites.coupled, scratch);
        let mut r = site.source;
        for (k, a) in a.iter().enumerate() {
            let image = self.products.image(scratch, k);
            (0..LANES).for_each(|l| r[l] += a * image[l]);
        }
        let slope = self.products.gradient(a, scratch);
        for &i in &self.sites.noisy {
            for &j in &self.sites.noisy {
                let b = &site.generator.second[i][j];
                (0..LANES).for_each(|l| r[l] += 0.5 * b[l] * slope[i][l] * slope[j][l]);
            }
        }
        r
    }

    /// The linearised residual L′δ = (−f + ∂B + B∇Q)·∇δ + ½ B:∇∇δ at a site.
    pub(super) fn linearised(&self, a: &[f64], site: &Site<N>, scratch: &mut Scratch) -> Symbols<N> {
        let slope = self.products.gradient(a, scratch);
        let mut first = site.backward;
        for &i in &self.sites.noisy {
            for &j in &self.sites.noisy {
                (0..LANES).for_each(|l| first[i][l] += site.generator.second[i][j][l] * slope[j][l]);
            }
        }
        Symbols { first, second: site.generator.second }
    }

    fn values(&self, scratch: &Scratch, rows: &mut Rows<'_>) {
        for k in 0..self.products.len() {
            rows.column(k).copy_from_slice(self.products.value(scratch, k));
        }
    }

    /// The mean over the first `count` states of left_k right_l, of two tables that `fill` writes for eight states at a
    /// time; of one with itself where there is only one.
    ///
    /// Every thread sums a stretch of blocks, and the stretches are summed in order. Their number depends on the problem
    /// alone, and so does each rounding.
    fn mean(
        &self,
        count: usize,
        tables: usize,
        fill: impl Fn(&Site<N>, &mut Scratch, Vec<Rows<'_>>) + Sync,
    ) -> Mat<f64> {
        let size = self.products.len();
        let sites = &self.sites.groups[..count.min(self.sites.len()) / LANES];
        let stretches = (ROOM / (size * size)).clamp(2, 64);
        let length = sites.len().div_ceil(stretches).max(1);
        let parts: Vec<Mat<f64>> = sites
            .par_chunks(length)
            .map(|stretch| {
                let mut sum = Mat::zeros(size, size);
                let mut scratch = self.products.scratch();
                let mut room = vec![Mat::<f64>::zeros(BLOCK, size); tables];
                for block in stretch.chunks(BLOCK / LANES) {
                    for (group, site) in block.iter().enumerate() {
                        let rows = room.iter_mut().map(|m| Rows { matrix: m.as_mut(), at: group * LANES }).collect();
                        fill(site, &mut scratch, rows);
                    }
                    let used = block.len() * LANES;
                    let (left, right) = (room[0].get(..used, ..), room[tables - 1].get(..used, ..));
                    matmul(sum.as_mut(), Accum::Add, left.transpose(), right, 1.0, Par::Seq);
                }
                sum
            })
            .collect();
        let mut sum = Mat::zeros(size, size);
        parts.iter().for_each(|part| sum += part);
        faer::Scale(1.0 / (sites.len() * LANES) as f64) * sum
    }
}

/// Eight rows of a table.
struct Rows<'a> {
    matrix: MatMut<'a, f64>,
    at: usize,
}

impl Rows<'_> {
    fn column(&mut self, k: usize) -> &mut [f64] {
        match self.matrix.as_mut().col_mut(k).try_as_col_major_mut() {
            Some(column) => &mut column.as_slice_mut()[self.at..self.at + LANES],
            // Columns of a matrix that owns its numbers are contiguous.
            None => &mut [],
        }
    }
}

/// Sums in order, divided by the number of states.
fn total(parts: &[Vec<f64>], count: usize) -> Vec<f64> {
    let mut sums = vec![0.0; parts.first().map_or(0, Vec::len)];
    for part in parts {
        sums.iter_mut().zip(part).for_each(|(sum, part)| *sum += part / count as f64);
    }
    sums
}
