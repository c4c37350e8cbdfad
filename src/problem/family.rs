//! Problems at other values of their parameters, and the derivatives of their equations.

use super::{Problem, Wall};
use crate::error::{Error, Result};
use crate::fokker_planck::FokkerPlanck;
use num_dual::HyperDual64;

/// The step by which impulses are seen to depend on a parameter.
const STEP: f64 = 1e-6;

/// What makes the problems of a system for any values of its parameters.
pub(super) trait Family: Send + Sync {
    /// The problem with `value(name, present value)` for each parameter.
    fn at(&self, value: &dyn Fn(&str, f64) -> f64) -> Result<Problem>;

    /// The operator with dual numbers for the parameters, a + b ε₁ + c ε₂ + d ε₁ε₂: ε₁ and ε₂ are two more states, which do not
    /// move.
    fn lifted(&self, value: &dyn Fn(&str, f64) -> HyperDual64) -> Result<FokkerPlanck>;

    /// The walls that the definition itself contains.
    fn walls(&self) -> &[Wall] {
        &[]
    }
}

impl Problem {
    /// The same problem with another value of a parameter. Walls that were set beside the definition stay.
    ///
    /// # Errors
    /// [`Error::NotAName`] if no parameter has the name, [`Error::NotKnown`] where the system is not
    /// [`Parametric`](crate::Parametric) and does not come from a text; those of the system's own definition at that value.
    ///
    /// ```
    /// use expoly::models::{Duffing, Solved};
    /// let problem = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?.with_parameter("mu", 0.5)?;
    /// assert_eq!(problem.drift()[1].text(problem.states()).to_string(), "- x - 0.2 v - 0.5 x^3");
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn with_parameter(&self, name: &str, value: f64) -> Result<Self> {
        self.index_of_parameter(name)?;
        let family = self.family()?;
        let made = family.at(&|other, present| if other == name { value } else { present })?;
        if self.walls == family.walls() {
            return Ok(made);
        }
        self.walls.iter().try_fold(made.without_walls(), |made, wall| made.with_wall(*wall))
    }

    /// The derivative of the Fokker-Planck operator by one parameter, ∂f/∂θ and ∂B/∂θ of the Itô drift f and of B = G Gᵀ, or by
    /// two, which may be the same. It is exact: the definition runs on dual numbers.
    ///
    /// The stationary density's derivative p′ solves L p′ = −L′p with it.
    ///
    /// # Errors
    /// [`Error::NotAName`] if no parameter has the name, [`Error::OutOfRange`] unless there are one or two names; [`Error::NotKnown`]
    /// where the system is not [`Parametric`](crate::Parametric) and does not come from a text, or does not contain the
    /// parameter; [`Error::NotServed`] for a parameter of impulses.
    ///
    /// ```
    /// use expoly::models::{Duffing, Solved};
    /// let problem = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?;
    /// let (by_damping, by_noise) = (problem.derivative(&["c"])?, problem.derivative(&["D"])?);
    /// assert_eq!(by_damping.drift()[1].text(problem.states()).to_string(), "- v");
    /// assert!((by_noise.diffusion()[1][1].coefficient(&[0, 0]) - 2.0).abs() < 1e-15); // B = 2D
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn derivative(&self, parameters: &[&str]) -> Result<FokkerPlanck> {
        for name in parameters {
            self.index_of_parameter(name)?;
        }
        let (first, second) = match *parameters {
            [first] => (first, None),
            [first, second] => (first, Some(second)),
            _ => {
                let remedy = "a derivative is by one parameter, or by two";
                return Err(Error::OutOfRange { name: "number of parameters", value: parameters.len() as f64, remedy });
            }
        };
        let seed = |name: &str, present: f64| {
            let [first, second] = [Some(first), second].map(|by| f64::from(u8::from(by == Some(name))));
            HyperDual64::new(present, first, second, 0.0)
        };
        let family = self.family()?;
        let lifted = family.lifted(&seed)?;
        // Impulses have no part in drift and diffusion, and no derivative here.
        let beside = |name: &str, present: f64| {
            if parameters.contains(&name) { present + STEP * (1.0 + present.abs()) } else { present }
        };
        if !self.impulses().is_empty() && family.at(&beside)?.impulses() != self.impulses() {
            let (method, what) = ("automatic differentiation", "derivatives by parameters of impulses");
            return Err(Error::NotServed { method, what, remedy: "take differences of two problems" });
        }
        let zero = |powers: [u32; 2]| lifted.coefficient(powers).is_zero();
        if zero([1, 0]) || second.is_some() && zero([0, 1]) {
            let name = if zero([1, 0]) { first } else { second.unwrap_or(first) };
            let remedy = "its expressions must contain the parameter, and not its value";
            return Err(Error::NotKnown { what: format!("how the equations depend on {name}"), remedy });
        }
        Ok(lifted.coefficient([1, u32::from(second.is_some())]))
    }

    fn index_of_parameter(&self, name: &str) -> Result<usize> {
        let unknown = || Error::NotAName { name: name.to_owned(), problem: "no parameter has it" };
        self.parameters().iter().position(|(parameter, _)| parameter == name).ok_or_else(unknown)
    }

    fn family(&self) -> Result<&dyn Family> {
        let remedy = "make the problem by `Problem::parametric`, or from a text";
        let unknown = Error::NotKnown { what: "the system at other values of its parameters".into(), remedy };
        self.equations.family.as_deref().ok_or(unknown)
    }
}
