//! Derivatives of answers that follow from others.

use super::Sensitivity;
use crate::checks::positive;
use crate::density::Density;
use crate::error::Result;
use crate::estimate::Estimate;
use crate::statistics::Marginal;

impl Sensitivity {
    /// The derivative of the level that a state exceeds with the probability `q`, x_q with P(X > x_q) = q:
    /// ∂x_q/∂θ = (∂P(X > x)/∂θ)/p(x) at x_q.
    ///
    /// # Errors
    /// Those of [`Marginal::upper_quantile`] and [`Sensitivity::exceedance`].
    ///
    /// ```
    /// use expoly::{Closure, models::{Linear, Solved}};
    /// let density = Closure::new(2).solve(&Linear::new(0.5, 1.0, 0.5)?.problem()?)?;
    /// // A normal variable of the variance D/(ck) = 1: x_q = σ Φ⁻¹(1 − q) and dσ/dD = σ/(2D).
    /// let by_noise = density.sensitivity("D")?.upper_quantile(0, 1e-3)?;
    /// assert!((by_noise.value - 3.090232306167813).abs() < 1e-6);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn upper_quantile(&self, state: usize, q: f64) -> Result<Estimate> {
        let marginal = Marginal::new(self.density(), state)?;
        let level = marginal.upper_quantile(q)?.value;
        Ok(self.exceedance(state, level)?.scaled(marginal.pdf(level)?.value.recip()))
    }

    /// The derivative of the probability that the displacement, state 0 with the velocity state 1, exceeds `level` within
    /// `duration`, 1 − P₀ exp(−ν⁺ T), as [`Crossings::first_passage`](crate::statistics::Crossings::first_passage) has it.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless the duration is finite and positive; those of
    /// [`Sensitivity::exceedance`] and [`Sensitivity::upcrossing_rate`].
    pub fn first_passage(&self, level: f64, duration: f64) -> Result<Estimate> {
        positive("duration", duration, "it must be finite and above zero")?;
        let rate = self.density().upcrossing_rate(level)?.value;
        let below = 1.0 - Marginal::new(self.density(), 0)?.exceedance(level)?.value;
        let stays = (-rate * duration).exp();
        let (by_rate, by_start) = (self.upcrossing_rate(level)?, self.exceedance(0, level)?);
        Ok(by_rate.scaled(below * stays * duration).plus(by_start.scaled(stays)))
    }
}
