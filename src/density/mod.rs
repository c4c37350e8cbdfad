//! Densities, whichever method made them.

mod balance;
mod cell;
mod exp_polynomial;
mod frame;
mod leading_form;
mod record;
mod support;
mod tensor;

pub use balance::energy_balance;
pub(crate) use cell::{Cell, lines as cell_lines};
pub use exp_polynomial::ExpPolynomial;
pub use frame::Frame;
pub(crate) use leading_form::escape_direction;
pub(crate) use record::{ExpRecord, SupportRecord};
pub use support::Support;

use crate::error::state_index;
use crate::{Error, Estimate, Monomial, Result, SimulatedDensity};

/// A stationary probability density on R^N, or on a part of it.
///
/// The states are those of the system, in its order. Values that were sampled carry their standard error, values that
/// were integrated their quadrature's error estimate.
///
/// What a density cannot tell at all, as a simulation a moment that it did not sum up, is not a number with an infinite
/// error, or a typed error.
pub trait Density<const N: usize>: Sync {
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

    /// The box, as lower and upper limits of each state, outside of which there is no mass worth speaking of, or of which
    /// the density knows nothing. A wall is a side of it.
    fn bounds(&self) -> [[f64; 2]; N];

    /// E[g(X)]. g should be smooth for the error to be sharp.
    fn expectation(&self, g: &(dyn Fn(&[f64; N]) -> f64 + Sync)) -> Estimate;

    /// The density of two states: the integral of p over all others, at `x`. In two states that is p itself.
    ///
    /// # Errors
    /// [`Error::Dimension`] if there are no such states, or they are one; [`Error::NotKnown`] where the density does not
    /// know how these two go together.
    fn joint_marginal(&self, states: [usize; 2], x: [f64; 2]) -> Result<Estimate> {
        let states = pair::<N>(states)?;
        if N > 2 {
            let remedy = "ask for the pair of states that it was made to watch, or ask another method";
            return Err(Error::NotKnown { what: "the joint density of these two states", remedy });
        }
        Ok(self.pdf(&placed(states, x)))
    }

    /// States with weights whose weighted means are the density's means, if it was made of such. The effective number of
    /// independent ones among them is (Σw)²/Σw².
    fn weighted_states(&self) -> Option<Vec<([f64; N], f64)>> {
        None
    }

    /// The simulation itself, if it is one. Values that were sampled together vary together:
    /// [`statistics`](crate::statistics) take the standard error of what combines several of them from the simulation's
    /// batches, and not from the error of each.
    fn simulation(&self) -> Option<&SimulatedDensity<N>> {
        None
    }

    /// The raw moment E[x₁^p₁ ⋯ x_N^p_N].
    fn moment(&self, powers: [u32; N]) -> Estimate {
        let monomial = Monomial(powers);
        self.expectation(&|x| monomial.evaluate(x))
    }

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
    fn variance(&self, state: usize) -> Result<Estimate> {
        state_index::<N>("the state of a variance", state)?;
        let mean = self.expectation(&|x| x[state]).value;
        Ok(self.expectation(&|x| (x[state] - mean).powi(2)))
    }

    /// The mean number of up-crossings of `level` by the displacement (state 0, its velocity state 1) per unit time:
    /// ν⁺ = ∫₀^∞ v p(level, v) dv (S. O. Rice, 1944, doi:10.1002/j.1538-7305.1944.tb00874.x).
    ///
    /// # Errors
    /// As [`Density::flux`].
    fn upcrossing_rate(&self, level: f64) -> Result<Estimate> {
        self.flux(Crossing::upward(level), 1)
    }
}

/// What a density does not know.
pub(crate) const UNKNOWN: Estimate = Estimate { value: f64::NAN, error: f64::INFINITY };

/// Two states, refused if they do not exist or are one.
pub(crate) fn pair<const N: usize>(states: [usize; 2]) -> Result<[usize; 2]> {
    for state in states {
        state_index::<N>("a state of a pair", state)?;
    }
    if states[0] == states[1] {
        return Err(Error::Dimension { what: "a pair of a state and itself", expected: N, found: states[1] });
    }
    Ok(states)
}

/// The point whose states `states` are `x`; all others are 0.
pub(crate) fn placed<const N: usize>(states: [usize; 2], x: [f64; 2]) -> [f64; N] {
    let mut point = [0.0; N];
    states.iter().zip(x).for_each(|(&state, x)| point[state] = x);
    point
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
