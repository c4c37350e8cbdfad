//! Densities, made by any method.

mod cell;
mod evidence;
mod exp_polynomial;
mod leading_form;
mod summary;
mod support;
mod tensor;

pub(crate) use cell::{Cell, lines as cell_lines};
pub(crate) use evidence::{Counted, CountedImpacts, Evidence, Sampled, Values, central};
pub use exp_polynomial::ExpPolynomial;
pub(crate) use leading_form::escape_direction;
pub(crate) use summary::summary;
pub use support::Support;

use crate::checks::{coordinate, dimension, finite, require, state_index};
use crate::error::{Error, Result};
use crate::estimate::Estimate;
use crate::polynomial::{Polynomial, power};
use crate::provenance::Provenance;

/// A stationary probability density on R^n, or on a part of it.
///
/// The states are those of the problem, in its order. Values that were sampled carry their standard error, values that
/// were integrated their quadrature's error estimate. A state, or a list of powers, has one number for each state;
/// another length is [`Error::Dimension`]. A value that a density does not have, such as a moment that a simulation did not
/// sum up, is [`Error::NotKnown`].
pub trait Density: Send + Sync {
    /// The number of states n.
    fn dimension(&self) -> usize;

    /// How the density was made, with the estimates that its method makes of itself.
    fn provenance(&self) -> &Provenance;

    /// The estimate of the distance ∫ |p̃ − p| dx from the true density, between 0 and 2: 2 where the method makes none, as a
    /// simulation, whose values have standard errors instead.
    fn l1_estimate(&self) -> f64 {
        self.provenance().l1_estimate.unwrap_or(2.0)
    }

    /// Why the density should not be relied on, if there is a reason.
    fn warning(&self) -> Option<&str> {
        self.provenance().warning.as_deref()
    }

    /// The mean number of impacts per unit time, at all walls together; none without a wall.
    /// [`Impacts`](crate::statistics::Impacts) has it for each wall.
    fn impact_rate(&self) -> Option<Estimate> {
        None
    }

    /// What the density was made from.
    #[doc(hidden)]
    fn evidence(&self) -> &dyn Evidence {
        &Values
    }

    /// The density at `x`; 0 outside the support. Unit: one over the product of the states' units.
    ///
    /// # Errors
    /// [`Error::Dimension`], [`Error::NotKnown`]; the same holds for all methods.
    fn pdf(&self, x: &[f64]) -> Result<Estimate>;

    /// ln p at `x`; −∞ outside the support.
    fn log_pdf(&self, x: &[f64]) -> Result<f64> {
        Ok(self.pdf(x)?.value.ln())
    }

    /// The density of one state alone: the integral of p over all others, at x_`state` = `x`.
    fn marginal(&self, state: usize, x: f64) -> Result<Estimate>;

    /// The box, as lower and upper limits of each state, outside of which the mass is negligible or unknown to the density's
    /// method. A wall is a side of it.
    fn bounds(&self) -> Vec<[f64; 2]>;

    /// Boxes without a common part, as lower and upper limits of each state, that hold all of [`Density::bounds`] and on each of which
    /// the density is smooth: the cells of a grid. By default it is a single one.
    fn cells(&self) -> Vec<Vec<[f64; 2]>> {
        vec![self.bounds()]
    }

    /// E[g(X)]. g should be smooth for the error to be sharp.
    fn expectation(&self, g: &(dyn Fn(&[f64]) -> f64 + Sync)) -> Result<Estimate>;

    /// The density of two states: the integral of p over all others, at `x`. In two states that is p itself.
    ///
    /// # Errors
    /// [`Error::Dimension`] also where the two states are one.
    fn joint_marginal(&self, states: [usize; 2], x: [f64; 2]) -> Result<Estimate> {
        let states = pair(states, x, self.dimension())?;
        if self.dimension() > 2 {
            let remedy =
                "a simulation has it for the pair of states that its options name; take that pair, or another method";
            return Err(Error::NotKnown { what: "the joint density of these two states".into(), remedy });
        }
        self.pdf(&placed(states, x, self.dimension()))
    }

    /// The raw moment E[x₁^p₁ ⋯ x_n^p_n].
    fn moment(&self, powers: &[u32]) -> Result<Estimate> {
        dimension("a list of powers", powers.len(), self.dimension())?;
        self.expectation(&|x| power(x, powers))
    }

    /// The mean E[q(X)] of a polynomial q: the sum of its moments. Its error is the sum of theirs, which holds however they are
    /// correlated.
    ///
    /// ```
    /// use expoly::{Closure, Density, models::{Duffing, Solved}};
    /// let problem = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?;
    /// let density = Closure::new(4).solve(&problem)?;
    /// let (force, velocity) = (&problem.drift()[1], &problem.drift()[0]);
    /// assert!((density.mean(&(force * velocity))?.value + 0.2).abs() < 1e-9);  // the power of the noise, D
    /// # Ok::<(), expoly::Error>(())
    /// ```
    fn mean(&self, polynomial: &Polynomial) -> Result<Estimate> {
        dimension("the states of a polynomial", polynomial.dimension(), self.dimension())?;
        polynomial.terms().try_fold(Estimate::exact(0.0), |sum, (powers, c)| {
            let moment = self.moment(powers)?;
            Ok(Estimate::new(sum.value + c * moment.value, sum.error + c.abs() * moment.error))
        })
    }

    /// The flux moment ∫ |v|^`power` p(level, v) dv over v > 0 or v < 0, all other states integrated out.
    ///
    /// # Errors
    /// [`Error::Dimension`] for states that do not exist or are one, [`Error::OutOfRange`] for a level that is not finite and a
    /// power above 200; [`Error::NotKnown`] for a level that a simulation did not count.
    fn flux(&self, crossing: Crossing, power: u32) -> Result<Estimate>;

    /// The variance of one state, never below zero.
    fn variance(&self, state: usize) -> Result<Estimate> {
        state_index("the state of a variance", state, self.dimension())?;
        let mean = self.expectation(&|x| x[state])?.value;
        let found = self.expectation(&|x| (x[state] - mean).powi(2))?;
        // A solution on a grid may be below zero where there is next to nothing.
        Ok(Estimate::new(found.value.max(0.0), found.error.max(-found.value)))
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

/// The power of a velocity, refused if it is so high that the integral depends on the last digits of the density.
pub(crate) fn moderate(power: u32) -> Result<i32> {
    const HIGHEST: u32 = 200;
    require(power <= HIGHEST, "power of a flux", f64::from(power), "it must be at most 200").map(|_| power as i32)
}

/// Two states, refused if they do not exist or are the same.
pub(crate) fn pair(states: [usize; 2], x: [f64; 2], dimension: usize) -> Result<[usize; 2]> {
    for (state, x) in states.into_iter().zip(x) {
        coordinate("a state of a pair", state, x, dimension)?;
    }
    if states[0] == states[1] {
        return Err(Error::Dimension { what: "a pair of a state and itself", expected: dimension, found: states[1] });
    }
    Ok(states)
}

/// The point whose states `states` are `x`; all others are 0.
pub(crate) fn placed(states: [usize; 2], x: [f64; 2], dimension: usize) -> Vec<f64> {
    let mut point = vec![0.0; dimension];
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

    /// State 0 going down through `level`, state 1 its velocity: at a wall, an impact.
    pub fn downward(level: f64) -> Self {
        Crossing { upward: false, ..Self::upward(level) }
    }

    /// The two states, refused if they do not exist or are the same, or if the level is not finite.
    pub(crate) fn states(&self, dimension: usize) -> Result<[usize; 2]> {
        finite("level of a crossing", self.level)?;
        let displacement = state_index("the displacement of a crossing", self.displacement, dimension)?;
        let velocity = state_index("the velocity of a crossing", self.velocity, dimension)?;
        if displacement == velocity {
            let what = "a crossing of a state by itself";
            return Err(Error::Dimension { what, expected: dimension, found: velocity });
        }
        Ok([displacement, velocity])
    }
}
