//! Derivatives of densities by parameters, made by any method.

use crate::checks::positive;
use crate::density::Density;
use crate::error::Result;
use crate::estimate::Estimate;
use crate::statistics::Marginal;

/// The derivative ∂p/∂θ of a stationary density by a parameter θ, and of every answer that it gives.
///
/// [`ClosureDensity::sensitivities`](crate::ClosureDensity::sensitivities) and
/// [`GridDensity::sensitivities`](crate::GridDensity::sensitivities) make it. Units are those of the answers over that of θ. Errors are the
/// method's estimates, as of its density.
pub trait Sensitivity {
    /// The name of the parameter.
    fn parameter(&self) -> &str;

    /// The density that this is a derivative of.
    fn density(&self) -> &dyn Density;

    /// (∂p/∂θ)/p at a state, which is ∂ ln p/∂θ. Its mean under p is zero; by the offset of a wall it is the density there, which
    /// the wall takes from the motion or leaves to it. It is not a number outside a grid's domain.
    ///
    /// # Errors
    /// [`Error::Dimension`](crate::Error::Dimension) if it is no state of the problem.
    fn relative(&self, x: &[f64]) -> Result<f64>;

    /// ∂p/∂θ at a state.
    ///
    /// # Errors
    /// As [`Sensitivity::relative`].
    fn pdf(&self, x: &[f64]) -> Result<Estimate>;

    /// ∫ |∂p/∂θ| dx. By the offset of a wall with r ≤ 0.5 it is infinite, and the value that of the nodes or of the smallest cell:
    /// ∂p/∂x ~ u^(g − 1) within |v| ~ u^(1/3) of the grazing point, with g ≤ −1/3. Moments, tails and rates are finite all the same.
    fn size(&self) -> f64;

    /// The estimate of ∫ |∂p̃/∂θ − ∂p/∂θ| dx, to be compared with [`Sensitivity::size`].
    fn l1_estimate(&self) -> f64;

    /// Why the derivative should not be relied on, if there is a reason.
    fn warning(&self) -> Option<&str>;

    /// dE g/dθ for a continuous g.
    fn expectation(&self, g: &(dyn Fn(&[f64]) -> f64 + Sync)) -> Estimate;

    /// The derivative of a raw moment, dE\[x₁^p₁ ⋯ x_n^p_n\]/dθ.
    ///
    /// # Errors
    /// [`Error::Dimension`](crate::Error::Dimension) unless there is a power for each state;
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) on a grid for powers above 200.
    fn moment(&self, powers: &[u32]) -> Result<Estimate>;

    /// The derivative of P(x_i > `level`) for a state i.
    ///
    /// # Errors
    /// [`Error::Dimension`](crate::Error::Dimension) if there is no such state, [`Error::OutOfRange`](crate::Error::OutOfRange) for
    /// a level that is not finite.
    fn exceedance(&self, state: usize, level: f64) -> Result<Estimate>;

    /// The derivative of the marginal density of a state.
    ///
    /// # Errors
    /// As [`Sensitivity::exceedance`].
    fn marginal(&self, state: usize, x: f64) -> Result<Estimate>;

    /// The derivative of the mean rate at which the displacement, state 0 with the velocity state 1, crosses a level upwards.
    ///
    /// # Errors
    /// [`Error::Dimension`](crate::Error::Dimension) in one state, [`Error::OutOfRange`](crate::Error::OutOfRange) for a level that
    /// is not finite.
    fn upcrossing_rate(&self, level: f64) -> Result<Estimate>;

    /// The derivative of the mean number of impacts per unit time, at all walls together, wherever they move; none without a wall.
    fn impact_rate(&self) -> Option<Estimate>;

    /// The derivative of the level that a state exceeds with the probability `q`, x_q with P(X > x_q) = q:
    /// ∂x_q/∂θ = (∂P(X > x)/∂θ)/p(x) at x_q.
    ///
    /// # Errors
    /// Those of [`Marginal::upper_quantile`] and [`Sensitivity::exceedance`].
    ///
    /// ```
    /// use expoly::{Closure, Sensitivity, models::{Linear, Solved}};
    /// let density = Closure::new(2).solve(&Linear::new(0.5, 1.0, 0.5)?.problem()?)?;
    /// // A normal variable of the variance D/(ck) = 1: x_q = σ Φ⁻¹(1 − q) and dσ/dD = σ/(2D).
    /// let by_noise = density.sensitivity("D")?.upper_quantile(0, 1e-3)?;
    /// assert!((by_noise.value - 3.090232306167813).abs() < 1e-6);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    fn upper_quantile(&self, state: usize, q: f64) -> Result<Estimate> {
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
    fn first_passage(&self, level: f64, duration: f64) -> Result<Estimate> {
        positive("duration", duration, "it must be finite and above zero")?;
        let rate = self.density().upcrossing_rate(level)?.value;
        let below = 1.0 - Marginal::new(self.density(), 0)?.exceedance(level)?.value;
        let stays = (-rate * duration).exp();
        let (by_rate, by_start) = (self.upcrossing_rate(level)?, self.exceedance(0, level)?);
        Ok(by_rate.scaled(below * stays * duration).plus(by_start.scaled(stays)))
    }
}
