//! A density that is easy to draw from and close to the pilot's.

use crate::closure::pilot::Pilot;
use crate::closure::symmetry::Symmetry;
use nalgebra::{Cholesky, DMatrix, SMatrix};

/// Normal scores between which a state is a linear function of its score.
pub(super) const KNOTS: usize = 13;
pub(super) const SPACING: f64 = 0.5;
/// The variance of the draws relative to the pilot's.
const WIDENED: f64 = 1.1;
/// The farthest a draw is trusted, relative to the farthest of the pilot's states.
const TRUSTED: f64 = 1.1;

/// Normal scores with the pilot's correlations, stretched state by state to the pilot's quantiles: a Gaussian copula.
#[derive(Clone, Debug)]
pub(super) struct Proposal<const N: usize> {
    pub(super) warps: [Warp; N],
    /// The covariance of the scores.
    pub(super) covariance: SMatrix<f64, N, N>,
    /// L⁻¹ of it, for distances.
    pub(super) inverse: SMatrix<f64, N, N>,
    /// The square of the farthest trusted distance.
    pub(super) farthest: f64,
}

/// A monotone function of the score, linear between knots and beyond them.
#[derive(Clone, Debug)]
pub(super) struct Warp {
    pub(super) values: [f64; KNOTS],
}

impl Warp {
    fn score(k: usize) -> f64 {
        (k as f64 - (KNOTS - 1) as f64 / 2.0) * SPACING
    }

    /// The state at a score, and the slope there.
    fn at(&self, score: f64) -> (f64, f64) {
        let piece = ((score - Self::score(0)) / SPACING).floor().clamp(0.0, (KNOTS - 2) as f64) as usize;
        let slope = (self.values[piece + 1] - self.values[piece]) / SPACING;
        (self.values[piece] + slope * (score - Self::score(piece)), slope)
    }

    /// The score of a state, and the slope there.
    fn score_of(&self, x: f64) -> (f64, f64) {
        let piece = self.values[1..KNOTS - 1].partition_point(|v| *v <= x);
        let slope = (self.values[piece + 1] - self.values[piece]) / SPACING;
        (Self::score(piece) + (x - self.values[piece]) / slope, slope)
    }
}

/// Draws with some states held fast.
#[derive(Clone, Debug)]
pub(super) struct Sampler<'a, const N: usize> {
    proposal: &'a Proposal<N>,
    /// The states in the order in which they are drawn.
    order: [usize; N],
    lower: SMatrix<f64, N, N>,
    /// The states held, as the first normal numbers, and themselves.
    held: Vec<(f64, f64)>,
}

impl<const N: usize> Proposal<N> {
    /// `None` where the states lie on a surface.
    pub(super) fn new(pilot: &Pilot<N>, symmetry: &Symmetry<N>) -> Option<Self> {
        let warps: [Warp; N] = std::array::from_fn(|i| {
            let mut all: Vec<f64> = pilot.states.iter().flat_map(|x| symmetry.images(*x)).map(|x| x[i]).collect();
            all.sort_by(f64::total_cmp);
            let quantile = |p: f64| all[((p * all.len() as f64) as usize).min(all.len() - 1)];
            Warp { values: std::array::from_fn(|k| quantile(normal_distribution(Warp::score(k)))) }
        });
        if warps
            .iter()
            .any(|w| w.values.windows(2).any(|pair| pair[0].partial_cmp(&pair[1]) != Some(std::cmp::Ordering::Less)))
        {
            return None;
        }
        let scores = |x: &[f64; N]| nalgebra::SVector::<f64, N>::from_fn(|i, _| warps[i].score_of(x[i]).0);
        let mut covariance = SMatrix::<f64, N, N>::zeros();
        let mut count = 0.0;
        for x in pilot.states.iter().flat_map(|x| symmetry.images(*x)) {
            let z = scores(&x);
            covariance += z * z.transpose();
            count += 1.0;
        }
        covariance *= WIDENED / count;
        let inverse = Cholesky::new(covariance)?.l().try_inverse()?;
        let farthest = pilot.states.iter().map(|x| (inverse * scores(x)).norm_squared()).fold(0.0, f64::max);
        Some(Proposal { warps, covariance, inverse, farthest: farthest * TRUSTED * TRUSTED })
    }

    /// Draws of all states but those given, which are held at their values.
    pub(super) fn sampler(&self, given: &[(usize, f64)]) -> Option<Sampler<'_, N>> {
        let mut order: [usize; N] = std::array::from_fn(|i| i);
        for (place, (state, _)) in given.iter().enumerate() {
            let from = order.iter().position(|i| i == state)?;
            order.swap(place, from);
        }
        let permuted = DMatrix::from_fn(N, N, |i, j| self.covariance[(order[i], order[j])]);
        let dynamic = Cholesky::new(permuted)?.l();
        let lower = SMatrix::from_fn(|i, j| dynamic[(i, j)]);
        let mut held: Vec<(f64, f64)> = Vec::with_capacity(given.len());
        for (i, &(state, x)) in given.iter().enumerate() {
            let known: f64 = held.iter().enumerate().map(|(j, (u, _))| dynamic[(i, j)] * u).sum();
            held.push(((self.warps[state].score_of(x).0 - known) / dynamic[(i, i)], x));
        }
        Some(Sampler { proposal: self, order, lower, held })
    }

    /// Whether a state lies where the pilot has been, or a little farther out.
    pub(super) fn trusts(&self, x: &[f64; N]) -> bool {
        let z = nalgebra::SVector::<f64, N>::from_fn(|i, _| self.warps[i].score_of(x[i]).0);
        (self.inverse * z).norm_squared() <= self.farthest
    }
}

impl<const N: usize> Sampler<'_, N> {
    /// A state from normal numbers, and the logarithm of the density with which it is drawn. `None` where no state is
    /// trusted: the density there is zero.
    pub(super) fn draw(&self, mut u: [f64; N]) -> Option<([f64; N], f64)> {
        u.iter_mut().zip(&self.held).for_each(|(u, (held, _))| *u = *held);
        // Distances do not depend on the order of the states.
        let distance: f64 = u.iter().map(|u| u * u).sum();
        if distance > self.proposal.farthest {
            return None;
        }
        let mut x = [0.0; N];
        let mut logarithm = 0.0;
        for i in 0..N {
            let score: f64 = (0..=i).map(|j| self.lower[(i, j)] * u[j]).sum();
            let (value, slope) = self.proposal.warps[self.order[i]].at(score);
            x[self.order[i]] = value;
            if i >= self.held.len() {
                logarithm -= 0.5 * u[i] * u[i] + (self.lower[(i, i)] * slope).ln() + 0.5 * std::f64::consts::TAU.ln();
            }
        }
        self.order.iter().zip(&self.held).for_each(|(&state, (_, held))| x[state] = *held);
        Some((x, logarithm))
    }
}

/// Φ(z), by Zelen and Severo's rational approximation: seven digits, which no quantile of a sample needs.
fn normal_distribution(z: f64) -> f64 {
    let t = 1.0 / (1.0 + 0.231_641_9 * z.abs());
    let series =
        t * (0.319_381_530 + t * (-0.356_563_782 + t * (1.781_477_937 + t * (-1.821_255_978 + t * 1.330_274_429))));
    let tail = (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt() * series;
    if z > 0.0 { 1.0 - tail } else { tail }
}
