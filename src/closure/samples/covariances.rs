//! Covariances of functions under exp(Q), and what parts of its nodes leave open of its means.

use super::likelihood::{BLOCK, Likelihood, ROOM, ROWS, lane, run_of};
use crate::closure::samples::{FEWER, MANY};
use crate::functions::Scratch;
use crate::numerics::{EIGHT, Eight, Number, add_gram, definite, symmetric};
use crate::parallel;
use faer::linalg::solvers::Llt;
use faer::{Mat, MatRef};

/// Draws whose triangle is made at a time.
const STRETCH: usize = 8 * BLOCK;

/// Over a part of the nodes Σ p, and Σ p (φ_k − E φ_k) and Σ p (φ_k − E φ_k)² for each function.
pub(super) struct PartSums {
    pub(super) mass: f64,
    sums: Vec<f64>,
    squares: Vec<f64>,
}

impl Likelihood<'_> {
    /// The largest difference of a mean by one part of the nodes from the mean by all, in standard deviations.
    ///
    /// On a lattice also the square of what a spacing twice as wide along one axis makes. The two parts, which are like the black and the
    /// white fields of a chessboard, have an error where the density varies along all axes alike, and none where it is narrow along a
    /// single one. A halved spacing squares the error at least where a density is analytic (L. N. Trefethen and J. A. C. Weideman, 2014,
    /// doi:10.1137/130932132).
    pub(super) fn unevenness(&self, masses: &[f64]) -> f64 {
        let means = self.means(masses);
        let parts = self.parts(masses, &means);
        let count = parts.len() as f64;
        let deviations: Vec<f64> =
            (0..means.len()).map(|k| parts.iter().map(|part| part.squares[k]).sum::<f64>().sqrt()).collect();
        let off = |part: &PartSums| {
            let of_means = part.sums.iter().zip(&deviations).map(|(sum, deviation)| count * sum.abs() / deviation);
            of_means.fold((count * part.mass - 1.0).abs(), f64::max)
        };
        let along = |axis: usize| {
            let even = self.nodes.even(axis, masses);
            let mass: f64 = even.iter().sum();
            let found = self.means(&even).into_iter().zip(&means).zip(&deviations);
            found.fold((mass - 1.0).abs(), |most, ((found, mean), deviation)| {
                most.max((found - mass * mean).abs() / deviation)
            })
        };
        let squares = self.nodes.axes().map(|axis| along(axis).powi(2));
        parts.iter().map(off).chain(squares).fold(0.0, f64::max)
    }

    /// The variance of each E φ_k by the spread between the parts of the nodes.
    pub(super) fn variances(&self, masses: &[f64], means: &[f64]) -> Vec<f64> {
        let parts = self.parts(masses, means);
        let count = parts.len() as f64;
        let square = |k: usize| parts.iter().map(|part| part.sums[k] * part.sums[k]).sum::<f64>();
        (0..means.len()).map(|k| square(k) * count / (count - 1.0)).collect()
    }

    pub(super) fn parts(&self, masses: &[f64], means: &[f64]) -> Vec<PartSums> {
        let ends = &self.nodes.parts;
        let starts = std::iter::once(0).chain(ends.iter().copied());
        let part = |(start, end): (usize, usize)| {
            let [sums, squares] = [(); 2].map(|()| vec![0.0; means.len()]);
            let mut part = PartSums { mass: 0.0, sums, squares };
            let mut scratch = Scratch::default();
            self.each(start, end - start, &mut scratch, |at, count, scratch| {
                let p = &masses[start + at..start + at + count];
                part.mass += p.iter().sum::<f64>();
                for (k, mean) in means.iter().enumerate() {
                    let value = self.space.value(scratch, k + 1);
                    for l in 0..count {
                        let off = value[l] - mean;
                        part.sums[k] += p[l] * off;
                        part.squares[k] += p[l] * off * off;
                    }
                }
            });
            part
        };
        parallel::map_into(starts.zip(ends.iter().copied()).collect(), |_, ends| part(ends))
    }

    /// The factors of Cov φ.
    pub(super) fn curvature(&self, masses: &[f64], means: &[f64]) -> Option<Llt<f64>> {
        definite(self.covariance(masses, means))
    }

    /// Cov φ.
    pub(super) fn covariance(&self, masses: &[f64], means: &[f64]) -> Mat<f64> {
        self.covariance_of(masses, means, None)
    }

    /// The covariance of Tᵀφ, where T is given, and of φ otherwise.
    pub(super) fn covariance_of(&self, masses: &[f64], means: &[f64], transform: Option<MatRef<'_, f64>>) -> Mat<f64> {
        let size = transform.map_or(means.len(), |transform| transform.ncols());
        let every = if size > MANY { FEWER } else { 1 };
        let blocks: Vec<usize> = (0..masses.len().div_ceil(BLOCK)).step_by(every).collect();
        let stretches = (ROOM / (size * size)).clamp(2, 64);
        let stretch = |blocks: &[usize]| {
            let mut sum = Mat::zeros(size, size);
            let mut scratch = Scratch::default();
            let mut table = Mat::<f64>::zeros(ROWS, means.len());
            let mut mass = 0.0;
            for &block in blocks {
                let p = &masses[block * BLOCK..((block + 1) * BLOCK).min(masses.len())];
                mass += p.iter().sum::<f64>();
                self.centred(block * BLOCK, p, means, &mut scratch, &mut table);
                let used = table.get(..p.len(), ..);
                match transform {
                    Some(transform) => add_gram(sum.as_mut(), (used * transform).as_ref()),
                    None => add_gram(sum.as_mut(), used),
                }
            }
            (sum, mass)
        };
        let runs: Vec<&[usize]> = blocks.chunks(blocks.len().div_ceil(stretches).max(1)).collect();
        let parts = parallel::map(runs.len(), |run| stretch(runs[run]));
        let (mut sum, mut mass) = (Mat::<f64>::zeros(size, size), 0.0);
        for (part, m) in &parts {
            sum += part;
            mass += m;
        }
        symmetric(&(sum / mass))
    }

    /// An upper triangle R with RᵀR = Cov φ, by orthogonal transformations of the functions' table, which keep the digits that
    /// the covariance loses.
    pub(super) fn triangle(&self, masses: &[f64], means: &[f64]) -> Mat<f64> {
        let stretch = |stretch: usize| {
            let p = run_of(masses, STRETCH, stretch);
            let mut table = Mat::<f64>::zeros(p.len() + EIGHT, means.len());
            self.centred(stretch * STRETCH, p, means, &mut Scratch::default(), &mut table);
            table.get(..p.len(), ..).qr().thin_R().to_owned()
        };
        let parts: Vec<Mat<f64>> = parallel::map(masses.len().div_ceil(STRETCH), stretch);
        let stacked = |above: Mat<f64>, part: Mat<f64>| {
            let rows = above.nrows();
            let both = Mat::from_fn(rows + part.nrows(), means.len(), |i, k| {
                if i < rows { above[(i, k)] } else { part[(i - rows, k)] }
            });
            both.qr().thin_R().to_owned()
        };
        parts.into_iter().reduce(stacked).unwrap_or_else(|| Mat::zeros(0, means.len()))
    }

    /// Fills a table with √p (φ − Eφ) at the draws from `first` on, a row each.
    fn centred(&self, first: usize, p: &[f64], means: &[f64], scratch: &mut Scratch<Eight>, table: &mut Mat<f64>) {
        self.each(first, p.len(), scratch, |at, count, scratch| {
            let root = lane(&p[at..at + count]).map(f64::sqrt);
            for (k, mean) in means.iter().enumerate() {
                let value = self.space.value(scratch, k + 1);
                let column = &mut table.col_as_slice_mut(k)[at..at + EIGHT];
                (0..EIGHT).for_each(|l| column[l] = root[l] * (value[l] - mean));
            }
        });
    }
}
