use super::newton::{Secant, constrained, limited, stepped};
use super::{moved, values};
use crate::checks::{finite, positive, require};
use crate::closure::{Closure, ClosureDensity, Sensitivity};
use crate::density::Density;
use crate::error::{Error, Result};
use crate::estimate::Estimate;
use crate::problem::Problem;
use crate::statistics::Marginal;
use nalgebra::{DMatrix, DVector};
use num_dual::HyperDual64;
use std::fmt;

/// The largest change of a parameter in a step, relative to itself.
const LONGEST: f64 = 0.5;
/// The order by which the order rises, and the highest.
const RISE: u32 = 2;
/// See [`RISE`].
const HIGHEST: u32 = 16;
/// The most solutions.
const MOST: usize = 20;
/// The largest distance of the cost's slope from a multiple of the answer's, relative to the former.
const STATIONARY: f64 = 1e-3;

/// The answer that a design must give.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Demand {
    /// P(x_i > level) of a state i.
    Exceedance {
        /// The state i.
        state: usize,
        /// The level.
        level: f64,
    },
    /// The mean rate of up-crossings of a level by the displacement, state 0.
    UpcrossingRate {
        /// The level.
        level: f64,
    },
    /// A raw moment E\[x₁^p₁ ⋯ x_n^p_n\], which must be positive.
    Moment {
        /// The powers p.
        powers: Vec<u32>,
    },
}

impl Demand {
    fn answer(&self, density: &ClosureDensity) -> Result<Estimate> {
        match self {
            Demand::Exceedance { state, level } => Marginal::new(density, *state)?.exceedance(*level),
            Demand::UpcrossingRate { level } => density.upcrossing_rate(*level),
            Demand::Moment { powers } => density.moment(powers),
        }
    }

    fn slope(&self, by: &Sensitivity) -> Result<f64> {
        let found = match self {
            Demand::Exceedance { state, level } => by.exceedance(*state, *level),
            Demand::UpcrossingRate { level } => by.upcrossing_rate(*level),
            Demand::Moment { powers } => by.moment(powers),
        };
        Ok(found?.value)
    }
}

type Cost<'a> = Box<dyn Fn(&[HyperDual64]) -> HyperDual64 + 'a>;

/// The parameters of least cost at which an answer has the value demanded of it.
///
/// Newton's method on the conditions of Lagrange, cost′ + λ (ln A)′ = 0 and ln A = ln A₀, with the exact derivatives of the answer A
/// and secants of them in the place of its second ones. The order rises while the closure's own error of A is above the accuracy: an
/// optimum at too low an order is one of another system.
///
/// # Reference
/// J. Nocedal and S. J. Wright, Numerical Optimization, 2nd ed., Springer 2006, chapter 18, doi:10.1007/978-0-387-40065-5.
///
/// ```
/// use expoly::{inverse::{Demand, Design}, models::{Duffing, Solved}};
/// // The damping and the cubic stiffness for P(x > 2.5) = 1e-4, at the least sum of squares.
/// let problem = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?;
/// let demand = Demand::Exceedance { state: 0, level: 2.5 };
/// let found = Design::new(&problem, &["c", "mu"], demand, 1e-4, |x| {
///     let [c, mu] = [x[0] / 0.2, x[1] / 0.3];
///     c * c + mu * mu
/// })
/// .run()?;
/// assert!((found.answer().value / 1e-4 - 1.0).abs() < 1e-3 && found.solves() <= 6);
/// # Ok::<(), expoly::Error>(())
/// ```
#[must_use = "options return the value with the option; nothing happens before it is used"]
pub struct Design<'a> {
    problem: Problem,
    names: Vec<String>,
    demand: Demand,
    value: f64,
    cost: Cost<'a>,
    closure: Closure,
    order: u32,
    accuracy: f64,
}

impl fmt::Debug for Design<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Design").field("names", &self.names).field("demand", &self.demand).finish_non_exhaustive()
    }
}

impl<'a> Design<'a> {
    /// A design of these parameters, from their values in the problem on, for an answer `value` above zero, at the least `cost`: a
    /// function of the parameters in this order, written on dual numbers, [`num_dual::HyperDual64`].
    pub fn new(
        problem: &Problem,
        parameters: &[&str],
        demand: Demand,
        value: f64,
        cost: impl Fn(&[HyperDual64]) -> HyperDual64 + 'a,
    ) -> Self {
        let names = parameters.iter().map(|name| (*name).to_owned()).collect();
        let (problem, cost) = (problem.clone(), Box::new(cost));
        Design { problem, names, demand, value, cost, closure: Closure::new(8), order: 8, accuracy: 0.02 }
    }

    /// The order to begin at, 8 by default; it rises by two where the accuracy demands it.
    pub fn order(self, order: u32) -> Self {
        Design { order, ..self }
    }

    /// The seed of the closure's pilot, 0 by default.
    pub fn seed(self, seed: u64) -> Self {
        Design { closure: self.closure.seed(seed), ..self }
    }

    /// The closure's own relative error of the answer that is small enough, 0.02 by default.
    pub fn accuracy(self, accuracy: f64) -> Self {
        Design { accuracy, ..self }
    }

    /// The design.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless the value demanded and the accuracy are finite and above zero; [`Error::NotAName`] for a parameter
    /// that the problem does not have; [`Error::NotKnown`] where no parameter changes the answer; those of [`Closure::solve`] and
    /// [`ClosureDensity::sensitivities`].
    pub fn run(&self) -> Result<Designed> {
        positive("value of the answer", self.value, "it must be finite and above zero")?;
        positive("accuracy of the answer", self.accuracy, "it must be finite and above zero; 0.02 is a usual choice")?;
        require(!self.names.is_empty(), "number of parameters", 0.0, "name at least one that can be chosen")?;
        let mut parameters = values(&self.problem, &self.names)?;
        let mut order = self.order;
        let mut at = self.solved(&self.problem, order, None)?;
        let mut secant = Secant::new(parameters.len());
        let mut solves = 1;
        loop {
            let (cost, slope, curvature) = self.cost_at(&parameters)?;
            let multiplier = -slope.dot(&at.slope) / at.slope.norm_squared();
            let stationary = (&slope + multiplier * &at.slope).amax() <= STATIONARY * slope.amax();
            let accurate = at.answer.error <= self.accuracy * at.answer.value;
            // The answer is met to a tenth of what is known of it.
            let met = at.log.abs() <= 0.1 * self.accuracy.min(STATIONARY);
            let converged = met && stationary;
            if converged && accurate || solves >= MOST || converged && order >= HIGHEST {
                return Ok(Designed {
                    problem: moved(&self.problem, &self.names, &parameters)?,
                    names: self.names.clone(),
                    values: parameters,
                    answer: at.answer,
                    cost,
                    order,
                    solves,
                    converged,
                    accurate,
                    density: at.density,
                });
            }
            // Where the answer is as near as it is known, a higher order says more than a step.
            if !accurate && at.log.abs() <= at.answer.error / at.answer.value && order < HIGHEST {
                order += RISE;
            }
            let second = secant.updated(&parameters, &at.slope);
            let step = constrained([&slope, &at.slope], &(curvature + multiplier * second), at.log);
            let factor = limited(&parameters, step.as_slice(), LONGEST);
            let step: Vec<f64> = step.iter().map(|step| factor * step).collect();
            let solve =
                |values: &[f64]| self.solved(&moved(&self.problem, &self.names, values)?, order, Some(&at.density));
            let (next, found, tried) = stepped(&parameters, &step, solve)?;
            (parameters, at) = (next, found);
            solves += tried;
        }
    }

    /// The cost with its first and second derivatives.
    fn cost_at(&self, values: &[f64]) -> Result<(f64, DVector<f64>, DMatrix<f64>)> {
        let count = values.len();
        let seeded = |k: usize, l: usize| {
            let number = |(i, value): (usize, &f64)| {
                HyperDual64::new(*value, f64::from(u8::from(i == k)), f64::from(u8::from(i == l)), 0.0)
            };
            (self.cost)(&values.iter().enumerate().map(number).collect::<Vec<_>>())
        };
        let slope = DVector::from_fn(count, |k, _| seeded(k, k).eps1);
        let curvature = DMatrix::from_fn(count, count, |k, l| seeded(k, l).eps1eps2);
        for value in slope.iter().chain(curvature.iter()) {
            finite("derivative of the cost", *value)?;
        }
        Ok((finite("cost", seeded(0, 0).re)?, slope, curvature))
    }

    fn solved(&self, problem: &Problem, order: u32, similar: Option<&ClosureDensity>) -> Result<Solved> {
        let density = self.closure.clone().of_order(order).starting_from(similar).solve(problem)?;
        let answer = self.demand.answer(&density)?;
        positive("answer at some parameters", answer.value, "its logarithm is met; start where it is above zero")?;
        let names: Vec<&str> = self.names.iter().map(String::as_str).collect();
        let derivatives = density.sensitivities(&names)?;
        let slopes =
            derivatives.iter().map(|by| Ok(self.demand.slope(by)? / answer.value)).collect::<Result<Vec<_>>>()?;
        let slope = DVector::from_vec(slopes);
        if slope.amax() == 0.0 {
            let remedy = "choose one that acts on the drift or the noise";
            return Err(Error::NotKnown { what: "parameters that change the demand".into(), remedy });
        }
        Ok(Solved { log: (answer.value / self.value).ln(), density, answer, slope })
    }
}

/// A density and its answer, with the slope of ln A, and ln A − ln A₀.
struct Solved {
    density: ClosureDensity,
    answer: Estimate,
    log: f64,
    slope: DVector<f64>,
}

/// A design that was found.
#[derive(Clone, Debug)]
pub struct Designed {
    problem: Problem,
    names: Vec<String>,
    values: Vec<f64>,
    answer: Estimate,
    cost: f64,
    order: u32,
    solves: usize,
    converged: bool,
    accurate: bool,
    density: ClosureDensity,
}

impl Designed {
    /// The problem at the parameters chosen.
    pub fn problem(&self) -> &Problem {
        &self.problem
    }

    /// The parameters chosen.
    pub fn parameters(&self) -> Vec<(&str, f64)> {
        self.names.iter().map(String::as_str).zip(self.values.iter().copied()).collect()
    }

    /// The density there.
    pub fn density(&self) -> &ClosureDensity {
        &self.density
    }

    /// The answer, with the closure's own error.
    pub fn answer(&self) -> Estimate {
        self.answer
    }

    /// The cost.
    pub fn cost(&self) -> f64 {
        self.cost
    }

    /// The order of the closure that was accurate enough, or the highest tried.
    pub fn order(&self) -> u32 {
        self.order
    }

    /// The number of densities that were solved for.
    pub fn solves(&self) -> usize {
        self.solves
    }

    /// Whether the conditions of Lagrange hold, the demand to a tenth of a thousandth and the slope of the cost to a thousandth.
    pub fn converged(&self) -> bool {
        self.converged
    }

    /// Whether the closure's own error of the answer is as small as was asked for.
    pub fn is_accurate(&self) -> bool {
        self.accurate
    }
}
