//! Sums over blocks of states, and the regression of means on moment equations by them.

use crate::numerics::{add_gram, regression, symmetric};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par, Scale};

/// Sums over blocks: their number, R = 𝓖ψ, φ, the lower triangle of RRᵀ, Rφᵀ and, of the first functions φ, the lower triangle
/// of φφᵀ.
#[derive(Clone)]
pub(in crate::closure) struct Sums {
    pub(in crate::closure) blocks: f64,
    pub(super) first: [Vec<f64>; 2],
    pub(super) square: Mat<f64>,
    pub(super) mixed: Mat<f64>,
    pub(super) own: Mat<f64>,
}

impl Sums {
    /// For so many tests, functions, and functions with covariances.
    pub(in crate::closure) fn new([tests, functions, covered]: [usize; 3]) -> Self {
        let (square, mixed) = (Mat::zeros(tests, tests), Mat::zeros(tests, functions));
        let own = Mat::zeros(covered, covered);
        Sums { blocks: 0.0, first: [vec![0.0; tests], vec![0.0; functions]], square, mixed, own }
    }

    /// Adds R and φ of some blocks, one row a block, and returns their sums.
    pub(in crate::closure) fn take(&mut self, r: &Mat<f64>, phi: &Mat<f64>) -> [Vec<f64>; 2] {
        add_gram(self.square.as_mut(), r.as_ref());
        matmul(self.mixed.as_mut(), Accum::Add, r.transpose(), phi.as_ref(), 1.0, Par::Seq);
        let covered = self.own.ncols();
        add_gram(self.own.as_mut(), phi.get(.., ..covered));
        let totals = [r, phi].map(|table| table.col_iter().map(|column| column.iter().sum()).collect::<Vec<f64>>());
        for (sum, total) in self.first.iter_mut().zip(&totals) {
            sum.iter_mut().zip(total).for_each(|(sum, total)| *sum += total);
        }
        self.blocks += r.nrows() as f64;
        totals
    }

    /// Adds others, or takes them off where `sign` is −1.
    pub(in crate::closure) fn add(&mut self, other: &Sums, sign: f64) {
        self.blocks += sign * other.blocks;
        for (sum, part) in self.first.iter_mut().zip(&other.first) {
            sum.iter_mut().zip(part).for_each(|(sum, part)| *sum += sign * part);
        }
        self.square += Scale(sign) * &other.square;
        self.mixed += Scale(sign) * &other.mixed;
        self.own += Scale(sign) * &other.own;
    }

    /// 1 + λ·R̄, the weight of a block being this less its λ·R.
    pub(in crate::closure) fn level(&self, lambda: &[f64]) -> f64 {
        let [r, _] = self.means();
        1.0 + r.iter().zip(lambda).map(|(r, l)| r * l).sum::<f64>()
    }

    pub(super) fn means(&self) -> [Vec<f64>; 2] {
        self.first.each_ref().map(|sums| sums.iter().map(|sum| sum / self.blocks).collect())
    }

    /// The regression on the first `tests` functions ψ. None where these are dependent on each other.
    pub(in crate::closure) fn regression(&self, tests: usize) -> Option<Regression> {
        let [r, phi] = self.means();
        let covariance = |k: usize, l: usize| self.square[(k, l)] / self.blocks - r[k] * r[l];
        let mixed = |k: usize, l: usize| {
            if l < phi.len() { self.mixed[(k, l)] / self.blocks - r[k] * phi[l] } else { r[k] }
        };
        let solved = regression([tests, phi.len() + 1], covariance, mixed)?;
        let beta = solved.get(.., ..phi.len()).to_owned();
        let lambda = solved.col(phi.len()).iter().copied().collect();
        Some(Regression { beta, lambda })
    }

    /// The calibrated means of φ.
    pub(super) fn calibrated(&self, Regression { beta, .. }: &Regression) -> Vec<f64> {
        let [r, phi] = self.means();
        let taken = |l: usize| (0..beta.nrows()).map(|k| beta[(k, l)] * r[k]).sum::<f64>();
        phi.iter().enumerate().map(|(l, mean)| mean - taken(l)).collect()
    }

    /// The covariance of the means of the first functions φ less their regression, by the spread between blocks.
    pub(super) fn covariance(&self, Regression { beta, .. }: &Regression) -> Mat<f64> {
        let [r, phi] = self.means();
        let (own, size) = (symmetric(&self.own), self.own.nrows());
        let mut left = Mat::from_fn(size, size, |k, l| own[(k, l)] / self.blocks - phi[k] * phi[l]);
        let mixed = Mat::from_fn(beta.nrows(), size, |k, l| self.mixed[(k, l)] / self.blocks - r[k] * phi[l]);
        matmul(left.as_mut(), Accum::Add, mixed.transpose(), beta.get(.., ..size), -1.0, Par::Seq);
        Mat::from_fn(size, size, |k, l| 0.5 * (left[(k, l)] + left[(l, k)]) / self.blocks)
    }
}

/// β, with a column for each φ, and λ = Cov(R)⁻¹ R̄.
pub(in crate::closure) struct Regression {
    pub(super) beta: Mat<f64>,
    pub(in crate::closure) lambda: Vec<f64>,
}
