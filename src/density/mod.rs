//! Densities, whichever method made them.

mod balance;
mod exp_polynomial;
mod frame;
mod leading_form;
mod support;
mod tensor;

pub use balance::energy_balance;
pub use exp_polynomial::ExpPolynomial;
pub use frame::Frame;
pub(crate) use leading_form::escape_direction;
pub use support::Support;

use crate::error::state_index;
use crate::{Error, Estimate, Result};

/// A stationary probability density on R^N, or on a part of it.
///
/// The states are those of the system, in its order. Values that were sampled carry their standard error, values that
/// were integrated their quadrature's error estimate.
pub trait Density<const N: usize> {
    /// The density at `x`; 0 outside the support. Unit: one over the product of the states' units.
    fn pdf(&self, x: &[f64; N]) -> Estimate;

    /// ln p at `x`; −∞ outside the support.
    fn log_pdf(&self, x: &[f64; N]) -> f64 {
        self.pdf(x).value.ln()
    }

    /// The density of one state alone: the integral of p over all others, at x_`state` = `x`.
    ///
    /// # Errors
    /// [`Error::Dimension`](crate::Error::Dimension) if there is no such state.
    fn marginal(&self, state: usize, x: f64) -> Result<Estimate>;

    /// The raw moment E[x₁^p₁ ⋯ x_N^p_N].
    fn moment(&self, powers: [u32; N]) -> Estimate;

    /// The flux moment ∫ |v|^`power` p(level, v) dv over v > 0 or v < 0, all other states integrated out.
    ///
    /// # Errors
    /// As [`Crossing`] says; [`Error::LevelNotCounted`](crate::Error::LevelNotCounted) where a simulation was not asked
    /// to watch the level.
    fn flux(&self, crossing: Crossing, power: u32) -> Result<Estimate>;

    /// The variance of one state.
    ///
    /// # Errors
    /// [`Error::Dimension`](crate::Error::Dimension) if there is no such state.
    fn variance(&self, state: usize) -> Result<Estimate>;

    /// The mean number of up-crossings of `level` by the displacement (state 0, its velocity state 1) per unit time:
    /// ν⁺ = ∫₀^∞ v p(level, v) dv (S. O. Rice, 1944, doi:10.1002/j.1538-7305.1944.tb00874.x).
    ///
    /// # Errors
    /// As [`Density::flux`].
    fn upcrossing_rate(&self, level: f64) -> Result<Estimate> {
        self.flux(Crossing::upward(level), 1)
    }
}

/// A passage of a displacement through a level, in one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// The state that crosses.
    pub displacement: usize,
    /// The state that is its velocity.
    pub velocity: usize,
    /// The level, in the unit of the displacement.
    pub level: f64,
    /// Whether the velocity is positive.
    pub upward: bool,
}

impl Crossing {
    /// State 0 going up through `level`, state 1 its velocity.
    pub fn upward(level: f64) -> Self {
        Crossing { displacement: 0, velocity: 1, level, upward: true }
    }

    /// The two states, refused if they do not exist or are one.
    pub(crate) fn states<const N: usize>(&self) -> Result<[usize; 2]> {
        let displacement = state_index::<N>("the displacement of a crossing", self.displacement)?;
        let velocity = state_index::<N>("the velocity of a crossing", self.velocity)?;
        if displacement == velocity {
            return Err(Error::Dimension { what: "a crossing of a state by itself", expected: N, found: velocity });
        }
        Ok([displacement, velocity])
    }

    /// State 0 going down through `level`, state 1 its velocity: at a wall, an impact.
    pub fn downward(level: f64) -> Self {
        Crossing { upward: false, ..Self::upward(level) }
    }
}
