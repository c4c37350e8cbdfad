//! The Gaussian closure: the normal distribution whose mean and covariance satisfy the moment equations.

use super::units::natural_units;
use crate::error::{Error, Result};
use crate::fokker_planck::FokkerPlanck;
use crate::numerics::{propagated, runge_kutta};
use crate::polynomial::{Gaussian, Polynomial};
use faer::Mat;
use nalgebra::{DMatrix, DVector};
use std::convert::Infallible;

/// Pseudo-time steps before the closure gives up; ordinary systems need 10 to 40.
const MAX_STEPS: usize = 400;
/// The variances from which it starts, one after the other until it settles: under a wide Gaussian the mean of an exponential hides all
/// else.
const STARTS: [f64; 4] = [1.0, 0.1, 1e-2, 1e-3];
/// Solutions of a linear system, the first one and those for what it leaves.
const REFINED: usize = 4;
/// A variance that has grown by this factor is taken to grow for ever.
const UNBOUNDED: f64 = 1e12;

/// The Gaussian closure of a system.
///
/// Stationarity of mean m and covariance S means 0 = E\[f\] and 0 = A S + S Aᵀ + E\[B\], A = E\[∂f/∂x\], all means taken under N(m,
/// S), exactly. The moments' own evolution in time is followed by implicit steps of growing length (pseudo-transient
/// continuation, C. T. Kelley and D. E. Keyes, 1998, doi:10.1137/S0036142996304796), which keeps S positive definite, picks
/// an attracting solution and ends as Newton's method. The exact Jacobian uses ∂E\[g\]/∂m_k = E\[∂_k g\] and ∂E\[g\]/∂S_kl = ½
/// E[∂_k∂_l g]. It starts from unit variance in the system's natural units.
///
/// # Errors
/// [`Error::NoDensity`] if a variance grows without bound or does not settle.
pub(super) fn gaussian_closure(operator: &FokkerPlanck) -> Result<Gaussian> {
    // Impulses enter equations of first and second order by their mean and their mean square.
    let operator = operator.diffusive();
    let (units, time) = natural_units(&operator)?;
    let scaled = operator.in_frame(&units).in_time(time);
    let starts = if scaled.is_polynomial() { &STARTS[..1] } else { &STARTS[..] };
    let from = |variance: &f64| in_natural_units(&scaled, *variance);
    let found = starts[1..].iter().fold(from(&starts[0]), |found, variance| found.or_else(|_| from(variance)))?;
    let scale = units.scale();
    Ok(Gaussian { mean: scale * found.mean, covariance: scale * found.covariance * scale.transpose() })
}

/// The closure of a system with coefficients of order one, from a variance of all states.
fn in_natural_units(operator: &FokkerPlanck, variance: f64) -> Result<Gaussian> {
    let n = operator.dimension();
    let equations = MomentEquations::new(operator);
    if operator.is_linear() {
        // One step of Newton's method is all, however far apart its rates are; from 0, so that no small variance is lost in a large one.
        let point = Gaussian::point(&vec![0.0; n]);
        let change = equilibrated(&equations.jacobian(&point), &-equations.rate(&point));
        let found = change.map(|change| equations.moved(&point, &change));
        if let Some(found) = found.filter(|found| found.covariance.clone().cholesky().is_some()) {
            return Ok(found);
        }
    }
    let mut state = Gaussian { mean: DVector::zeros(n), covariance: DMatrix::identity(n, n) * variance };
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
        match moved.filter(|next| next.covariance.clone().cholesky().is_some()) {
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
        if let Some(i) = (0..n).find(|&i| state.covariance[(i, i)].is_nan() || state.covariance[(i, i)] >= UNBOUNDED) {
            return Err(unbounded(i, "grows without bound"));
        }
    }
    let worst = (0..n).max_by(|&i, &j| state.covariance[(i, i)].total_cmp(&state.covariance[(j, j)]));
    Err(unbounded(worst.unwrap_or(0), "does not settle"))
}

fn unbounded(state: usize, behaviour: &str) -> Error {
    Error::no_density(format!(
        "under the Gaussian closure the variance of state {state} {behaviour}; the drift must bring every trajectory back, so check the \
         signs of damping and leading stiffness"
    ))
}

/// The solution of linear equations whose rows and columns are of very different sizes. None where there is none.
fn equilibrated(matrix: &DMatrix<f64>, right: &DVector<f64>) -> Option<DVector<f64>> {
    let n = matrix.nrows();
    let inverse = |size: f64| if size > 0.0 { size.recip() } else { 1.0 };
    let columns = DVector::from_fn(n, |k, _| inverse(matrix.column(k).amax()));
    let mut scaled = DMatrix::from_fn(n, n, |i, k| matrix[(i, k)] * columns[k]);
    let rows = DVector::from_fn(n, |i, _| inverse(scaled.row(i).amax()));
    (0..n).for_each(|i| scaled.row_mut(i).scale_mut(rows[i]));
    let factors = scaled.lu();
    let mut solution = DVector::zeros(n);
    // The first solution, and steps that take off what its rounding leaves of the equations.
    for _ in 0..REFINED {
        let open = right - matrix * &solution;
        solution += factors.solve(&open.component_mul(&rows))?.component_mul(&columns);
    }
    Some(solution)
}

/// The drift, the diffusion and the derivatives of both that the moment equations need.
struct MomentEquations {
    drift: Vec<Polynomial>,
    slopes: Vec<Vec<Polynomial>>,
    diffusion: Vec<Vec<Polynomial>>,
    /// Where it has functions, which are polynomials near a Gaussian alone.
    whole: Option<FokkerPlanck>,
}

impl MomentEquations {
    fn new(operator: &FokkerPlanck) -> Self {
        let whole = (!operator.is_polynomial()).then(|| operator.clone());
        MomentEquations { whole, ..MomentEquations::of_polynomials(operator) }
    }

    fn of_polynomials(operator: &FokkerPlanck) -> Self {
        let n = operator.dimension();
        let slopes = |f: &Polynomial| (0..n).map(|j| f.derivative(j)).collect();
        MomentEquations {
            drift: operator.drift().to_vec(),
            slopes: operator.drift().iter().map(slopes).collect(),
            diffusion: operator.diffusion().to_vec(),
            whole: None,
        }
    }

    /// Those that hold near a Gaussian.
    fn near(&self, state: &Gaussian) -> Option<Self> {
        self.whole.as_ref().map(|whole| MomentEquations::of_polynomials(&whole.near(state)))
    }

    fn dimension(&self) -> usize {
        self.drift.len()
    }

    /// The unknowns in a vector: the mean, then the covariance's lower triangle row by row.
    fn pack(&self, state: &Gaussian) -> DVector<f64> {
        let triangle = pairs(self.dimension()).map(|(i, j)| state.covariance[(i, j)]);
        DVector::from_vec(state.mean.iter().copied().chain(triangle).collect())
    }

    fn moved(&self, state: &Gaussian, change: &DVector<f64>) -> Gaussian {
        let n = self.dimension();
        let mut next = state.clone();
        for i in 0..n {
            next.mean[i] += change[i];
        }
        for (k, (i, j)) in pairs(n).enumerate() {
            next.covariance[(i, j)] += change[n + k];
            next.covariance[(j, i)] = next.covariance[(i, j)];
        }
        next
    }

    fn rate(&self, state: &Gaussian) -> DVector<f64> {
        if let Some(near) = self.near(state) {
            return near.rate(state);
        }
        let n = self.dimension();
        let slopes = DMatrix::from_fn(n, n, |i, j| state.expectation(&self.slopes[i][j]));
        let half = slopes * &state.covariance;
        let mean = self.drift.iter().map(|f| state.expectation(f));
        let spread = |(i, j): (usize, usize)| half[(i, j)] + half[(j, i)] + state.expectation(&self.diffusion[i][j]);
        DVector::from_vec(mean.chain(pairs(n).map(spread)).collect())
    }

    fn jacobian(&self, state: &Gaussian) -> DMatrix<f64> {
        if let Some(near) = self.near(state) {
            return near.jacobian(state);
        }
        let n = self.dimension();
        let size = n + n * (n + 1) / 2;
        let mean = |p: &Polynomial| if p.is_zero() { 0.0 } else { state.expectation(p) };
        let slopes = DMatrix::from_fn(n, n, |i, j| mean(&self.slopes[i][j]));
        let mut jacobian = DMatrix::zeros(size, size);
        // Each unknown changes the mean of g by the mean of a derivative of g.
        let unknowns = (0..n).map(|k| (k, None)).chain(pairs(n).map(|(k, l)| (k, Some(l))));
        for (column, (k, l)) in unknowns.enumerate() {
            let change = |g: &Polynomial| match l {
                None => mean(&g.derivative(k)),
                // An off-diagonal unknown stands for two equal entries of S.
                Some(l) => mean(&g.derivative(k).derivative(l)) * if k == l { 0.5 } else { 1.0 },
            };
            let mut ds = DMatrix::zeros(n, n);
            if let Some(l) = l {
                (ds[(k, l)], ds[(l, k)]) = (1.0, 1.0);
            }
            let da = DMatrix::from_fn(n, n, |i, j| change(&self.slopes[i][j]));
            let half = da * &state.covariance + &slopes * ds;
            for i in 0..n {
                jacobian[(i, column)] = change(&self.drift[i]);
            }
            for (row, (i, j)) in pairs(n).enumerate() {
                jacobian[(n + row, column)] = half[(i, j)] + half[(j, i)] + change(&self.diffusion[i][j]);
            }
        }
        jacobian
    }
}

/// The index pairs of a lower triangle, row by row.
fn pairs(n: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..n).flat_map(|i| (0..=i).map(move |j| (i, j)))
}

/// The moments of a linear system at some times after `start`: its moment equations are linear, and solved exactly.
pub(crate) fn linear_after(operator: &FokkerPlanck, start: &Gaussian, times: &[f64]) -> Vec<Gaussian> {
    let (equations, origin) = (MomentEquations::new(operator), Gaussian::point(&vec![0.0; operator.dimension()]));
    let (constant, jacobian) = (equations.rate(&origin), equations.jacobian(&origin));
    // The first entry is 1.
    let matrix = Mat::from_fn(1 + constant.len(), 1 + constant.len(), |i, j| match (i, j) {
        (0, _) => 0.0,
        (i, 0) => constant[i - 1],
        (i, j) => jacobian[(i - 1, j - 1)],
    });
    let from: Vec<f64> = std::iter::once(1.0).chain(equations.pack(start).iter().copied()).collect();
    let found = propagated(matrix.as_ref(), &from, times);
    let at = |time: usize| equations.moved(&origin, &DVector::from_fn(constant.len(), |k, _| found[(1 + k, time)]));
    (0..times.len()).map(at).collect()
}

/// The Gaussian closure's moments at a time after `start`, by the classical Runge-Kutta method; a covariance of zero is a
/// point. The moments of a linear system are exact, those of another system as long as the Gaussian is narrow.
pub(crate) fn gaussian_after(operator: &FokkerPlanck, start: &Gaussian, time: f64) -> Gaussian {
    const STEPS: usize = 64;
    let equations = MomentEquations::new(&operator.diffusive());
    let h = time / STEPS as f64;
    let rate = |state: &Gaussian, _: f64| Ok::<_, Infallible>(equations.rate(state));
    (0..STEPS).fold(start.clone(), |state, _| {
        let moved = |state: &Gaussian, rate: &DVector<f64>, time: f64| equations.moved(state, &(rate * time));
        let Ok(next) = runge_kutta(&state, &equations.rate(&state), h, rate, moved);
        next
    })
}
