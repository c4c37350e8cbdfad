//! The Gaussian closure: the normal distribution whose mean and covariance satisfy the moment equations.

use super::units::natural_units;
use crate::{Error, FokkerPlanck, Gaussian, Polynomial, Result};
use nalgebra::{DMatrix, DVector, SMatrix, SVector};

/// Pseudo-time steps before the closure gives up; ordinary systems need 10 to 40.
const MAX_STEPS: usize = 400;
/// A variance that has grown by this factor is taken to grow for ever.
const UNBOUNDED: f64 = 1e12;

/// The Gaussian closure of a system.
///
/// Stationarity of mean m and covariance S asks for 0 = E[f] and 0 = A S + S Aᵀ + E[B], A = E[∂f/∂x], all means taken
/// under N(m, S), exactly. The moments' own evolution in time is followed by implicit steps of growing length
/// (pseudo-transient continuation, C. T. Kelley and D. E. Keyes, 1998, doi:10.1137/S0036142996304796), which keeps S
/// positive definite, picks an attracting solution and ends as Newton's method. The exact Jacobian uses
/// ∂E[g]/∂m_k = E[∂_k g] and ∂E[g]/∂S_kl = ½ E[∂_k∂_l g]. It starts from unit variance in the system's natural units.
///
/// # Errors
/// [`Error::NoStationaryDensity`] if a variance grows without bound or does not settle.
pub(crate) fn gaussian_closure<const N: usize>(operator: &FokkerPlanck<N>) -> Result<Gaussian<N>> {
    let (units, time) = natural_units(operator)?;
    let found = in_natural_units(&operator.in_frame(&units).in_time(time))?;
    let scale = units.scale();
    Ok(Gaussian { mean: scale * found.mean, covariance: scale * found.covariance * scale.transpose() })
}

/// The closure of a system with coefficients of order one.
fn in_natural_units<const N: usize>(operator: &FokkerPlanck<N>) -> Result<Gaussian<N>> {
    let equations = MomentEquations::new(operator);
    let mut state = Gaussian { mean: SVector::zeros(), covariance: SMatrix::identity() };
    let mut rate = equations.rate(&state);
    let mut step = 0.1 / rate.norm().max(1e-3);
    for _ in 0..MAX_STEPS {
        let jacobian = equations.jacobian(&state);
        let size = equations.pack(&state).amax();
        // Converged when a whole Newton step no longer moves the moments.
        let newton = jacobian.clone().lu().solve(&-&rate);
        if let Some(newton) = &newton
            && newton.amax() <= 1e-13 * size
        {
            return Ok(state);
        }
        let shifted = DMatrix::from_diagonal_element(rate.len(), rate.len(), step.recip()) - &jacobian;
        let moved = shifted.lu().solve(&rate).map(|change| equations.moved(&state, &change));
        match moved.filter(|next| next.covariance.cholesky().is_some()) {
            Some(next) => {
                let next_rate = equations.rate(&next);
                let growth = if next_rate.norm() > 0.0 { rate.norm() / next_rate.norm() } else { 10.0 };
                // Rounding keeps the rate from falling for ever: a rate at the level of its own rounding is zero.
                if newton.is_some_and(|n| n.amax() <= 1e-11 * size) && growth < 2.0 {
                    return Ok(next);
                }
                step *= growth.clamp(0.3, 10.0).max(1.1_f64.min(growth * 2.0));
                (state, rate) = (next, next_rate);
            }
            None => step *= 0.25,
        }
        if let Some(i) = (0..N).find(|&i| state.covariance[(i, i)].is_nan() || state.covariance[(i, i)] >= UNBOUNDED) {
            return Err(Error::NoStationaryDensity { state: i, behaviour: "grows without bound" });
        }
    }
    let worst = (0..N).max_by(|&i, &j| state.covariance[(i, i)].total_cmp(&state.covariance[(j, j)]));
    Err(Error::NoStationaryDensity { state: worst.unwrap_or(0), behaviour: "does not settle" })
}

/// The drift, the diffusion and the derivatives of both that the moment equations need.
struct MomentEquations<const N: usize> {
    drift: [Polynomial<N>; N],
    slopes: [[Polynomial<N>; N]; N],
    diffusion: [[Polynomial<N>; N]; N],
}

impl<const N: usize> MomentEquations<N> {
    fn new(operator: &FokkerPlanck<N>) -> Self {
        let drift = operator.drift().clone();
        let slopes = std::array::from_fn(|i| std::array::from_fn(|j| drift[i].derivative(j)));
        MomentEquations { drift, slopes, diffusion: operator.diffusion().clone() }
    }

    /// The unknowns in a vector: the mean, then the covariance's lower triangle row by row.
    fn pack(&self, state: &Gaussian<N>) -> DVector<f64> {
        let triangle = pairs::<N>().map(|(i, j)| state.covariance[(i, j)]);
        DVector::from_iterator(N + N * (N + 1) / 2, state.mean.iter().copied().chain(triangle))
    }

    fn moved(&self, state: &Gaussian<N>, change: &DVector<f64>) -> Gaussian<N> {
        let mut next = state.clone();
        for i in 0..N {
            next.mean[i] += change[i];
        }
        for (k, (i, j)) in pairs::<N>().enumerate() {
            next.covariance[(i, j)] += change[N + k];
            next.covariance[(j, i)] = next.covariance[(i, j)];
        }
        next
    }

    fn rate(&self, state: &Gaussian<N>) -> DVector<f64> {
        let slopes = SMatrix::<f64, N, N>::from_fn(|i, j| state.expectation(&self.slopes[i][j]));
        let half = slopes * state.covariance;
        let mean = self.drift.iter().map(|f| state.expectation(f)).collect::<Vec<_>>();
        let covariance =
            pairs::<N>().map(|(i, j)| half[(i, j)] + half[(j, i)] + state.expectation(&self.diffusion[i][j]));
        DVector::from_iterator(N + N * (N + 1) / 2, mean.into_iter().chain(covariance))
    }

    fn jacobian(&self, state: &Gaussian<N>) -> DMatrix<f64> {
        let size = N + N * (N + 1) / 2;
        let mean = |p: &Polynomial<N>| if p.is_zero() { 0.0 } else { state.expectation(p) };
        let slopes = SMatrix::<f64, N, N>::from_fn(|i, j| mean(&self.slopes[i][j]));
        let mut jacobian = DMatrix::zeros(size, size);
        // Each unknown changes the mean of g by the mean of a derivative of g.
        let unknowns = (0..N).map(|k| (k, None)).chain(pairs::<N>().map(|(k, l)| (k, Some(l))));
        for (column, (k, l)) in unknowns.enumerate() {
            let change = |g: &Polynomial<N>| match l {
                None => mean(&g.derivative(k)),
                // An off-diagonal unknown stands for two equal entries of S.
                Some(l) => mean(&g.derivative(k).derivative(l)) * if k == l { 0.5 } else { 1.0 },
            };
            let mut ds = SMatrix::<f64, N, N>::zeros();
            if let Some(l) = l {
                (ds[(k, l)], ds[(l, k)]) = (1.0, 1.0);
            }
            let da = SMatrix::<f64, N, N>::from_fn(|i, j| change(&self.slopes[i][j]));
            let half = da * state.covariance + slopes * ds;
            for i in 0..N {
                jacobian[(i, column)] = change(&self.drift[i]);
            }
            for (row, (i, j)) in pairs::<N>().enumerate() {
                jacobian[(N + row, column)] = half[(i, j)] + half[(j, i)] + change(&self.diffusion[i][j]);
            }
        }
        jacobian
    }
}

/// The index pairs of a lower triangle, row by row.
fn pairs<const N: usize>() -> impl Iterator<Item = (usize, usize)> {
    (0..N).flat_map(|i| (0..=i).map(move |j| (i, j)))
}

/// The Gaussian closure's moments at a time after `start`, by the classical Runge-Kutta method; a covariance of zero is a
/// point. The moments of a linear system are exact, those of another system as long as the Gaussian is narrow.
pub(crate) fn gaussian_after<const N: usize>(
    operator: &FokkerPlanck<N>,
    start: &Gaussian<N>,
    time: f64,
) -> Gaussian<N> {
    const STEPS: usize = 64;
    let equations = MomentEquations::new(operator);
    let h = time / STEPS as f64;
    (0..STEPS).fold(start.clone(), |state, _| {
        let k1 = equations.rate(&state);
        let k2 = equations.rate(&equations.moved(&state, &(&k1 * (h / 2.0))));
        let k3 = equations.rate(&equations.moved(&state, &(&k2 * (h / 2.0))));
        let k4 = equations.rate(&equations.moved(&state, &(&k3 * h)));
        equations.moved(&state, &((k1 + (k2 + k3) * 2.0 + k4) * (h / 6.0)))
    })
}
