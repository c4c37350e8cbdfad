//! The moments of a narrow Gaussian under modulated noise.

use super::Problem;
use crate::envelope::Piece;
use crate::numerics::runge_kutta;
use crate::polynomial::{Gaussian, Polynomial};
use nalgebra::{DMatrix, DVector};
use std::convert::Infallible;

/// The equations m′ = E f and S′ = A S + S Aᵀ + e² E B, A = E ∂f/∂x, of the Gaussian closure, f = f₀ + e² f₁ with the drift f₁
/// that noise induces.
#[derive(Debug)]
pub(crate) struct ModulatedMoments {
    /// f₀ and f₁.
    drifts: [Vec<Polynomial>; 2],
    diffusion: Vec<Vec<Polynomial>>,
}

impl ModulatedMoments {
    pub(crate) fn new(problem: &Problem) -> Self {
        let operator = problem.operator();
        let induced = problem.induced_drift();
        let still = operator.drift().iter().zip(&induced).map(|(f, induced)| f - induced).collect();
        ModulatedMoments { drifts: [still, induced], diffusion: operator.diffusion().to_vec() }
    }

    /// The Gaussian after a stretch of time on which the envelope is smooth, by the classical Runge-Kutta method.
    pub(crate) fn after(&self, start: &Gaussian, piece: &Piece, [from, to]: [f64; 2]) -> Gaussian {
        const STEPS: usize = 8;
        let h = (to - from) / STEPS as f64;
        let moved = |state: &Gaussian, rate: &Gaussian, h: f64| Gaussian {
            mean: &state.mean + &rate.mean * h,
            covariance: &state.covariance + &rate.covariance * h,
        };
        (0..STEPS).fold(start.clone(), |state, n| {
            let rate = |state: &Gaussian, part: f64| {
                Ok::<_, Infallible>(self.rate(state, piece.squared(from + h * (n as f64 + part))[0]))
            };
            let Ok(first) = rate(&state, 0.0);
            let Ok(next) = runge_kutta(&state, &first, h, rate, moved);
            next
        })
    }

    /// The rates of change of mean and covariance.
    fn rate(&self, state: &Gaussian, squared: f64) -> Gaussian {
        let mean = |of: &dyn Fn(&Polynomial) -> Polynomial, i: usize| {
            let [still, induced] = self.drifts.each_ref().map(|drift| state.expectation(&of(&drift[i])));
            still + squared * induced
        };
        let n = state.mean.len();
        let slopes = DMatrix::from_fn(n, n, |i, j| mean(&|f| f.derivative(j), i));
        let half = slopes * &state.covariance;
        let noise = DMatrix::from_fn(n, n, |i, j| squared * state.expectation(&self.diffusion[i][j]));
        Gaussian {
            mean: DVector::from_fn(n, |i, _| mean(&Polynomial::clone, i)),
            covariance: &half + half.transpose() + noise,
        }
    }
}
