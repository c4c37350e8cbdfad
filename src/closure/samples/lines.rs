//! Where a density has its mass on lines along one state.

use crate::closure::density::exponent::Exponent;
use crate::numerics::exponentials;
use crate::parallel;
use crate::states::States;
use nalgebra::{Cholesky, DMatrix, DVector};

/// Lines along a thin state reach out so many of its standard deviations on them, in which the pilot's farthest states lie. At
/// a quality factor of 1000 the search ran to the edge with 7; with 24 exp(Q) rose again at some ends.
const REACH: f64 = 14.0;
/// Lines along a thin state are laid once more where the density on them is wider or narrower by this share in the mean.
const WIDER: f64 = 0.1;
/// Lines along a thin state are laid once more where the density on them is shifted by so many standard deviations in the mean.
const SHIFTED: f64 = 0.15;

/// Places on a line at which exp(Q) is tabulated.
const PLACES: usize = 121;

/// Lines along one state through points of the others, with the mean and the standard deviation of a density on each.
#[derive(Clone, Debug)]
pub(super) struct Lines {
    state: usize,
    /// States, of which each line has all entries but that of its own state.
    pub(super) points: States,
    pub(super) centre: Vec<f64>,
    pub(super) width: Vec<f64>,
}

impl Lines {
    /// Lines about the regression of a state on the others, by some states. None where these lie on a surface.
    pub(super) fn regressed(state: usize, points: States, states: &States) -> Option<Self> {
        let n = states.dimension();
        let count = states.len() as f64;
        let mean = DVector::from_fn(n, |i, _| states.iter().map(|x| x[i]).sum::<f64>() / count);
        let mut covariance = DMatrix::zeros(n, n);
        for x in states {
            let off = DVector::from_column_slice(x) - &mean;
            covariance.ger(1.0 / count, &off, &off, 1.0);
        }
        // A row of the inverse is that of the regression.
        let precision = Cholesky::new(covariance)?.inverse();
        let own = precision[(state, state)];
        let along = |x: &[f64]| {
            let others = (0..n).filter(|i| *i != state);
            mean[state] - others.map(|i| precision[(state, i)] * (x[i] - mean[i])).sum::<f64>() / own
        };
        let centre = points.iter().map(along).collect();
        let width = vec![own.sqrt().recip(); points.len()];
        Some(Lines { state, points, centre, width })
    }

    /// The ends of each line: so many widths about its centre as it reaches out, within a range.
    pub(super) fn ends(&self, [low, high]: [f64; 2]) -> Vec<[f64; 2]> {
        let ends = |(centre, width): (&f64, &f64)| {
            let (centre, half) = (centre.clamp(low, high), REACH * width.min(high - low));
            [low.max(centre - half), high.min(centre + half)]
        };
        self.centre.iter().zip(&self.width).map(ends).collect()
    }

    /// The same lines with the means and deviations of exp(Q) between some ends, and then between those that are as many of these
    /// deviations away as lines reach.
    ///
    /// Beyond the ends exp(Q) means nothing, and may rise again.
    pub(super) fn following(&self, exponent: &Exponent, ends: &[[f64; 2]]) -> Self {
        let first = self.tabulated(exponent, ends);
        let inner = first.ends([f64::MIN, f64::MAX]);
        first.tabulated(exponent, &within(&inner, ends))
    }

    fn tabulated(&self, exponent: &Exponent, ends: &[[f64; 2]]) -> Self {
        // On a line Q is a polynomial, which few values determine.
        let exponents = exponent.space.polynomials().map_or(&[][..], |own| own.exponents());
        let degree = exponents.iter().map(|alpha| alpha[self.state]).max().unwrap_or(0) as usize;
        let knots: Vec<f64> =
            (0..=degree).map(|j| (std::f64::consts::PI * (j as f64 + 0.5) / (degree + 1) as f64).cos()).collect();
        let place = |k: usize| 2.0 * k as f64 / (PLACES - 1) as f64 - 1.0;
        let share = |t: f64, j: usize| -> f64 {
            let others = (0..=degree).filter(|l| *l != j);
            others.map(|l| (t - knots[l]) / (knots[j] - knots[l])).product()
        };
        let shares: Vec<Vec<f64>> = (0..PLACES).map(|k| (0..=degree).map(|j| share(place(k), j)).collect()).collect();
        let mut points = States::with_capacity(self.points.dimension(), ends.len() * knots.len());
        for (x, [low, high]) in self.points.iter().zip(ends) {
            let mut x = x.to_vec();
            for t in &knots {
                x[self.state] = 0.5 * (low + high) + 0.5 * (high - low) * t;
                points.push(&x);
            }
        }
        let values = exponent.values(&points);
        let moments = |line: usize| {
            let (q, [low, high]) = (&values[line * knots.len()..(line + 1) * knots.len()], ends[line]);
            let along = |shares: &Vec<f64>| shares.iter().zip(q).map(|(share, q)| share * q).sum::<f64>();
            let mut p: Vec<f64> = shares.iter().map(along).collect();
            let top = p.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            p.iter_mut().for_each(|q| *q -= top);
            exponentials(&mut p);
            let mass: f64 = p.iter().sum();
            let mean = p.iter().enumerate().map(|(k, p)| p * place(k)).sum::<f64>() / mass;
            let square = p.iter().enumerate().map(|(k, p)| p * (place(k) - mean).powi(2)).sum::<f64>() / mass;
            let half = 0.5 * (high - low);
            // No narrower than half the distance of two places.
            let width = half * square.sqrt().max((PLACES as f64).recip());
            (0.5 * (low + high) + half * mean, width)
        };
        let (centre, width) = parallel::map(ends.len(), moments).into_iter().unzip();
        Lines { state: self.state, points: self.points.clone(), centre, width }
    }

    /// Whether other means and deviations on the same lines are nearly these, in the mean under some masses of the lines.
    pub(super) fn are_nearly(&self, other: &Lines, masses: &[f64]) -> bool {
        let [mut wider, mut shifted] = [0.0; 2];
        for (k, p) in masses.iter().enumerate() {
            wider += p * (other.width[k] / self.width[k] - 1.0).abs();
            shifted += p * (other.centre[k] - self.centre[k]).abs() / self.width[k];
        }
        wider < WIDER && shifted < SHIFTED
    }
}

/// The part of some ends that lies between others.
pub(super) fn within(inner: &[[f64; 2]], outer: &[[f64; 2]]) -> Vec<[f64; 2]> {
    inner.iter().zip(outer).map(|(own, given)| [own[0].max(given[0]), own[1].min(given[1])]).collect()
}
