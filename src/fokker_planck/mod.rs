//! The Fokker-Planck operator of a system, by two independent routes.
//!
//! 0 = L p = −∂_i(f_i p) + ½ ∂_i∂_j(B_ij p), B = G Gᵀ, is the equation of the stationary density p. For p = exp(Q) it
//! divides by p and becomes the *residual*
//!
//! r(x; Q) = −∇·f − f·∇Q + ½ [ ∂_i∂_jB_ij + 2 (∂_jB_ij) ∂_iQ + B_ij (∂_i∂_jQ + ∂_iQ ∂_jQ) ],
//!
//! which is quadratic in the coefficients of Q. [`FokkerPlanck`] holds the operator as polynomials: exact degrees, exact
//! Gaussian moments, an equation to print. [`LocalOperator`] is the operator at one point, by dual numbers, from the same
//! generic definition. The two agree to rounding on every system.

mod local;
mod text;

pub use local::LocalOperator;
pub(crate) use local::{drift_along_noise, ito_drift};
pub use text::OperatorText;

use crate::{Arena, Error, Frame, Gaussian, Interpretation, Polynomial, PolynomialDrift, Result, Symbol};
use nalgebra::{SMatrix, SVector};

/// The Fokker-Planck operator as polynomials: the Itô drift f and the diffusion matrix B = G Gᵀ.
#[derive(Clone, Debug, PartialEq)]
pub struct FokkerPlanck<const N: usize> {
    drift: [Polynomial<N>; N],
    diffusion: [[Polynomial<N>; N]; N],
}

impl<const N: usize> FokkerPlanck<N> {
    /// The operator of `system`. A Stratonovich system's drift is converted to Itô's, f_i += ½ Σ_jk G_jk ∂_j G_ik.
    ///
    /// # Errors
    /// [`Error::NotFinite`] if a coefficient is NaN or infinite, [`Error::NoNoise`] if B vanishes identically.
    ///
    /// ```
    /// use expoly::{FokkerPlanck, models::Duffing};
    /// let operator = FokkerPlanck::new(&Duffing::new(0.2, 1.0, 0.3, 0.2)?)?;
    /// assert_eq!(
    ///     operator.text(["x", "v"]).to_string(),
    ///     "0 = - d/dx[(v) p] - d/dv[(- x - 0.2 v - 0.3 x^3) p] + d2/dv2[(0.2) p]"
    /// );
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn new<T: PolynomialDrift<N, M>, const M: usize>(system: &T) -> Result<Self> {
        let arena = Arena::new();
        let mut drift = system.drift(arena.variables()).map(Symbol::polynomial);
        let noise = system.noise(arena.variables()).map(|row| row.map(Symbol::polynomial));
        for i in 0..N {
            all_finite("drift", i, &drift[i])?;
            for entry in &noise[i] {
                all_finite("noise", i, entry)?;
            }
        }
        if system.interpretation() == Interpretation::Stratonovich {
            for (i, correction) in noise_induced_drift(&noise).into_iter().enumerate() {
                drift[i] = &drift[i] + &correction;
            }
        }
        let diffusion: [[Polynomial<N>; N]; N] = std::array::from_fn(|i| {
            std::array::from_fn(|j| (0..M).fold(Polynomial::zero(), |sum, k| sum + &noise[i][k] * &noise[j][k]))
        });
        if diffusion.iter().flatten().all(Polynomial::is_zero) {
            return Err(Error::NoNoise);
        }
        Ok(FokkerPlanck { drift, diffusion })
    }

    /// The Itô drift f.
    pub fn drift(&self) -> &[Polynomial<N>; N] {
        &self.drift
    }

    /// The diffusion matrix B = G Gᵀ.
    pub fn diffusion(&self) -> &[[Polynomial<N>; N]; N] {
        &self.diffusion
    }

    /// The highest total degree among drift and diffusion.
    pub fn degree(&self) -> u32 {
        self.drift.iter().chain(self.diffusion.iter().flatten()).map(Polynomial::degree).max().unwrap_or(0)
    }

    /// The divergence ∇·f of the drift.
    pub fn divergence(&self) -> Polynomial<N> {
        (0..N).fold(Polynomial::zero(), |sum, i| sum + self.drift[i].derivative(i))
    }

    /// The vector Σ_j ∂_jB_ij.
    pub fn diffusion_divergence(&self) -> [Polynomial<N>; N] {
        std::array::from_fn(|i| (0..N).fold(Polynomial::zero(), |sum, j| sum + self.diffusion[i][j].derivative(j)))
    }

    /// The residual r(x; Q) = L exp(Q) / exp(Q) as a polynomial. It vanishes identically if exp(Q) is stationary.
    ///
    /// ```
    /// use expoly::{FokkerPlanck, Polynomial, models::Linear};
    /// let operator = FokkerPlanck::new(&Linear::new(0.5, 1.0, 0.5)?)?;
    /// let [x, v] = Polynomial::<2>::variables();
    /// let q = &x * &x * -0.5 + &v * &v * -0.5; // −(c/D)(v² + k x²)/2
    /// assert!(operator.residual(&q).is_zero());
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn residual(&self, q: &Polynomial<N>) -> Polynomial<N> {
        let gradient: [Polynomial<N>; N] = std::array::from_fn(|i| q.derivative(i));
        let spread = self.diffusion_divergence();
        let mut r = &self.divergence() * -1.0;
        for i in 0..N {
            r = r + &(&spread[i] - &self.drift[i]) * &gradient[i] + spread[i].derivative(i) * 0.5;
            for j in 0..N {
                let curvature = gradient[i].derivative(j) + &gradient[i] * &gradient[j];
                r = r + &self.diffusion[i][j] * &curvature * 0.5;
            }
        }
        r
    }

    /// The state that is the velocity of state `i`: j where the drift of x_i is x_j alone and no noise drives x_i.
    pub fn velocity_of(&self, i: usize) -> Option<usize> {
        let quiet = self.diffusion[i].iter().all(Polynomial::is_zero);
        let variables = Polynomial::variables();
        quiet.then(|| (0..N).find(|&j| j != i && self.drift[i] == variables[j])).flatten()
    }

    /// The same operator for the scaled coordinates z of x = m + L z: drift L⁻¹f and diffusion L⁻¹B L⁻ᵀ.
    pub(crate) fn in_frame(&self, frame: &Frame<N>) -> Self {
        let arena = Arena::new();
        let state = frame.state_polynomials().map(|p| arena.symbol(p));
        let inverse = frame.inverse();
        let in_z = |p: &Polynomial<N>| p.evaluate(&state).polynomial();
        let drift = self.drift.each_ref().map(in_z);
        let diffusion = self.diffusion.each_ref().map(|row| row.each_ref().map(in_z));
        // Σ_j L⁻¹_ij p_j, leaving out what is zero anyway.
        let combined = |factors: [f64; N], parts: [&Polynomial<N>; N]| {
            let used = (0..N).filter(|&j| factors[j] != 0.0 && !parts[j].is_zero());
            used.fold(Polynomial::zero(), |sum, j| sum + parts[j] * factors[j])
        };
        let row = |i: usize| std::array::from_fn(|j| inverse[(i, j)]);
        let half: [[Polynomial<N>; N]; N] =
            std::array::from_fn(|i| std::array::from_fn(|q| combined(row(i), diffusion.each_ref().map(|r| &r[q]))));
        FokkerPlanck {
            drift: std::array::from_fn(|i| combined(row(i), drift.each_ref())),
            diffusion: std::array::from_fn(|i| std::array::from_fn(|j| combined(row(j), half[i].each_ref()))),
        }
    }

    /// The same operator for the time t/`unit`.
    pub(crate) fn in_time(&self, unit: f64) -> Self {
        FokkerPlanck {
            drift: self.drift.each_ref().map(|p| p * unit),
            diffusion: self.diffusion.each_ref().map(|row| row.each_ref().map(|p| p * unit)),
        }
    }

    /// The linear system with the drift `slopes`·(x − `centre`) and the constant diffusion `diffusion`.
    pub(crate) fn linear(
        slopes: &SMatrix<f64, N, N>,
        centre: &SVector<f64, N>,
        diffusion: &SMatrix<f64, N, N>,
    ) -> Self {
        let variables: [Polynomial<N>; N] = Polynomial::variables();
        let drift = std::array::from_fn(|i| {
            (0..N).fold(Polynomial::zero(), |sum, j| sum + (&variables[j] + -centre[j]) * slopes[(i, j)])
        });
        let diffusion = std::array::from_fn(|i| std::array::from_fn(|j| Polynomial::constant(diffusion[(i, j)])));
        FokkerPlanck { drift, diffusion }
    }

    /// The linear system that has the same mean drift, slopes and diffusion under `gaussian`: statistical linearisation.
    pub(crate) fn linearised(&self, gaussian: &Gaussian<N>) -> Self {
        let slopes = SMatrix::from_fn(|i, j| gaussian.expectation(&self.drift[i].derivative(j)));
        let diffusion = SMatrix::from_fn(|i, j| gaussian.expectation(&self.diffusion[i][j]));
        Self::linear(&slopes, &gaussian.mean, &diffusion)
    }

    /// The rate of change of the mean of `statistic` as a polynomial: f·∇φ + ½ B:∇∇φ. Its stationary mean is zero,
    /// which makes every polynomial a check of a density: a *moment equation*.
    pub fn generator(&self, statistic: &Polynomial<N>) -> Polynomial<N> {
        let mut rate = Polynomial::zero();
        for i in 0..N {
            let slope = statistic.derivative(i);
            rate = rate + &self.drift[i] * &slope;
            for j in 0..N {
                rate = rate + &self.diffusion[i][j] * &slope.derivative(j) * 0.5;
            }
        }
        rate
    }
}

/// ½ Σ_jk G_jk ∂_j G_ik, what Stratonovich's mean rate of change has beyond the drift.
pub(crate) fn noise_induced_drift<const N: usize, const M: usize>(
    noise: &[[Polynomial<N>; M]; N],
) -> [Polynomial<N>; N] {
    std::array::from_fn(|i| {
        let mut sum = Polynomial::zero();
        for k in 0..M {
            for j in 0..N {
                sum = sum + &noise[j][k] * &noise[i][k].derivative(j) * 0.5;
            }
        }
        sum
    })
}

fn all_finite<const N: usize>(part: &'static str, state: usize, polynomial: &Polynomial<N>) -> Result<()> {
    match polynomial.terms().find(|(_, c)| !c.is_finite()) {
        None => Ok(()),
        Some((m, value)) => Err(Error::NotFinite { part, state, exponents: m.0.to_vec(), value }),
    }
}
