//! Densities that move and whose moments of first and second order are known.

use super::problem;
use expoly::models::Duffing;
use expoly::{Drift, Envelope, Gaussian, Interpretation, Problem, Scalar, Start};
use nalgebra::{DMatrix, Matrix2, Vector2, dmatrix, dvector, matrix};

/// Those of first and second order.
pub(crate) const POWERS: [[u32; 2]; 5] = [[1, 0], [0, 1], [2, 0], [1, 1], [0, 2]];

/// A normal distribution whose states are correlated, with its moments.
pub(crate) fn correlated() -> (Start, [f64; 5]) {
    let gaussian = Gaussian { mean: dvector![0.8, -0.5], covariance: dmatrix![0.3, 0.05; 0.05, 0.4] };
    (Start::Gaussian(gaussian), [0.8, -0.5, 0.3 + 0.64, 0.05 - 0.4, 0.4 + 0.25])
}

/// The mean and the covariance of x″ + x′/2 + x = ξ, D = ½, at a time after [`correlated`]: m(t) = e^At m₀, S(t) = S∞ + e^At (S₀ − S∞)
/// e^Aᵀt.
pub(crate) fn linear_after(time: f64) -> (Vector2<f64>, Matrix2<f64>) {
    let flow = (matrix![0.0, 1.0; -1.0, -0.5] * time).exp();
    let limit = Matrix2::identity();
    (flow * Vector2::new(0.8, -0.5), limit + flow * (matrix![0.3, 0.05; 0.05, 0.4] - limit) * flow.transpose())
}

/// The moments of a mean and a covariance.
pub(crate) fn moments(mean: Vector2<f64>, spread: Matrix2<f64>) -> [f64; 5] {
    let raw = spread + mean * mean.transpose();
    [mean[0], mean[1], raw[(0, 0)], raw[(0, 1)], raw[(1, 1)]]
}

/// x″ + x′/2 + x = ξ₁ + a x′ ξ₂ in Stratonovich's sense, both noises of intensity ½.
#[derive(Debug)]
pub(crate) struct Noisy {
    pub(crate) a: f64,
}

impl Drift<2, 2> for Noisy {
    fn drift<S: Scalar>(&self, [x, v]: [S; 2]) -> [S; 2] {
        [v, v * -0.5 - x]
    }
    fn noise<S: Scalar>(&self, [_, v]: [S; 2]) -> [[S; 2]; 2] {
        [[S::zero(), S::zero()], [S::from(1.0), v * self.a]]
    }
    fn interpretation(&self) -> Interpretation {
        Interpretation::Stratonovich
    }
}

impl Noisy {
    /// E x, E v, E x², E xv, E v² after `time`, by the classical Runge-Kutta method with steps that end at all kinks: h⁴ = 1e-12.
    pub(crate) fn moments(&self, envelope: &Envelope, start: [f64; 5], time: f64) -> [f64; 5] {
        let steps = (time / 1e-3).round() as usize;
        let rate = |[x, v, xx, xv, vv]: [f64; 5], t: f64| {
            let squared = envelope.value(t).powi(2);
            let damping = 0.5 - 0.5 * self.a * self.a * squared;
            [
                v,
                -x - damping * v,
                2.0 * xv,
                vv - xx - damping * xv,
                -2.0 * xv - 2.0 * damping * vv + squared * (1.0 + self.a * self.a * vv),
            ]
        };
        let h = time / steps as f64;
        (0..steps).fold(start, |y, n| {
            // Within the step on both sides of a jump.
            let at = |place: f64| h * (n as f64 + place.clamp(1e-9, 1.0 - 1e-9));
            let moved = |k: [f64; 5], h: f64| std::array::from_fn(|i| y[i] + h * k[i]);
            let k1 = rate(y, at(0.0));
            let k2 = rate(moved(k1, h / 2.0), at(0.5));
            let k3 = rate(moved(k2, h / 2.0), at(0.5));
            let k4 = rate(moved(k3, h), at(1.0));
            std::array::from_fn(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]))
        })
    }
}

/// A normal distribution of two states, of one deviation in both.
pub(crate) fn normal(mean: [f64; 2], deviation: f64) -> Start {
    let covariance = DMatrix::from_diagonal_element(2, 2, deviation * deviation);
    Start::Gaussian(Gaussian { mean: dvector![mean[0], mean[1]], covariance })
}

/// x″ − ½(1 − x²)x′ + x = ξ with D = 0.3.
pub(crate) fn van_der_pol() -> Problem {
    let text = "states = [\"x\", \"v\"]\n[drift]\nx = \"v\"\nv = \"0.5*(1 - x^2)*v - x\"\n[noise.w]\nv = \"sqrt(0.6)\"";
    Problem::from_toml(text).unwrap()
}

/// A Duffing oscillator with two wells.
pub(crate) fn two_wells() -> Problem {
    problem(Duffing::new(0.5, -1.0, 1.0, 0.3).unwrap())
}
