//! Problems at other values of their parameters, and the derivatives of their equations.

use super::{Motion, Problem};
use crate::elementary::Elementary;
use crate::error::{Error, Result};
use crate::fokker_planck::{FokkerPlanck, Impulse};
use crate::polynomial::{FunctionOf, Polynomial, is_real};
use crate::walls::Wall;
use num_dual::Dual64;

/// What makes the problems of a system for any values of its parameters.
pub(super) trait Family: Send + Sync {
    /// The problem with `value(name, present value)` for each parameter.
    fn at(&self, value: &dyn Fn(&str, f64) -> f64) -> Result<Problem>;

    /// The system with dual numbers for the parameters, a + b ε.
    fn lifted(&self, value: &dyn Fn(&str, f64) -> Dual64) -> Result<Lifted>;

    /// The walls that the definition itself contains.
    fn walls(&self) -> &[Wall] {
        &[]
    }
}

/// A system with dual numbers for its parameters.
#[derive(Debug)]
pub struct Lifted {
    /// ε is one more state, which does not move.
    pub(super) operator: FokkerPlanck,
    /// Those of the operator with the dual numbers of rates and laws.
    pub(super) impulses: Vec<Impulse<Dual64>>,
    /// Offset and restitution of the walls that the definition itself contains.
    pub(super) walls: Vec<[Dual64; 2]>,
}

impl Lifted {
    /// The coefficient of ε in the operator.
    ///
    /// # Errors
    /// [`Error::NotServed`] where a jump moves with ε: the derivative of the drift is infinite there.
    fn derivative(&self) -> Result<FokkerPlanck> {
        let n = self.operator.dimension() - 1;
        let jumps = |of: &&FunctionOf| matches!(of.function, Elementary::Sign | Elementary::PositivePower(0.0));
        let all = self.operator.drift().iter().flat_map(Polynomial::all_functions).filter(jumps);
        if all.into_iter().any(|of| of.argument.contains(n)) {
            let (method, what) =
                ("automatic differentiation", "derivatives by a parameter that moves a jump of the drift");
            return Err(Error::NotServed {
                method,
                what,
                remedy: "take differences of two densities, at `Problem::with_parameter`",
            });
        }
        Ok(self.operator.derivative(&self.impulses))
    }
}

impl Problem {
    /// The same problem with another value of a parameter.
    ///
    /// The walls that a text itself contains follow its parameters. Offsets and restitutions that were set beside the definition
    /// stay.
    ///
    /// # Errors
    /// [`Error::NotAName`] if no parameter has the name, [`Error::NotKnown`] where it is none of a wall and the system is not
    /// [`Parametric`](crate::Parametric) and does not come from a text; those of the system's own definition at that value, and
    /// those of [`Problem::with_wall`].
    ///
    /// ```
    /// use expoly::models::{Duffing, Solved};
    /// let problem = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?.with_parameter("mu", 0.5)?;
    /// assert_eq!(problem.drift()[1].text(problem.states()).to_string(), "- x - 0.2 v - 0.5 x^3");
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn with_parameter(&self, name: &str, value: f64) -> Result<Self> {
        let index = self.index_of_parameter(name)?;
        let (made, walls) = match self.number_of_wall(index) {
            Some((changed, number)) => {
                let mut numbers = self.walls[changed].numbers();
                numbers[number] = value;
                let wall = |(i, wall): (usize, &Wall)| if i == changed { wall.with_numbers(numbers) } else { *wall };
                (self.clone(), self.walls.iter().enumerate().map(wall).collect())
            }
            None => {
                let family = self.family()?;
                let made = family.at(&|other, present| if other == name { value } else { present })?;
                let wall = |(i, wall): (usize, &Wall)| {
                    let (follows, numbers) = (self.follows(family, i), wall.numbers());
                    let new = made.walls.get(i).map_or(numbers, Wall::numbers);
                    wall.with_numbers([0, 1].map(|k| if follows[k] { new[k] } else { numbers[k] }))
                };
                let walls = self.walls.iter().enumerate().map(wall).collect::<Vec<_>>();
                (made, walls)
            }
        };
        walls.into_iter().chain(self.ends.iter().copied()).try_fold(made.without_walls(), Self::with_wall)
    }

    /// The derivative of the Fokker-Planck operator by a parameter, ∂f/∂θ and ∂B/∂θ of the Itô drift f and of B = G Gᵀ. It is exact:
    /// the definition runs on dual numbers. Of Poisson impulses it has ∂(λ E\[ψ(x + H Y) − ψ(x)\])/∂θ, which its
    /// [`FokkerPlanck::generator`] contains.
    ///
    /// The stationary density's derivative p′ solves L p′ = −L′p with it.
    ///
    /// # Errors
    /// [`Error::NotAName`] if no parameter has the name; [`Error::NotKnown`] where the system is not
    /// [`Parametric`](crate::Parametric) and does not come from a text, or does not contain the parameter; [`Error::NotServed`] for a parameter of walls, on which the operator does not act.
    ///
    /// ```
    /// use expoly::models::{Duffing, Solved};
    /// let problem = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?;
    /// let (by_damping, by_noise) = (problem.derivative("c")?, problem.derivative("D")?);
    /// assert_eq!(by_damping.drift()[1].text(problem.states()).to_string(), "- v");
    /// assert!((by_noise.diffusion()[1][1].coefficient(&[0, 0]) - 2.0).abs() < 1e-15); // B = 2D
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn derivative(&self, parameter: &str) -> Result<FokkerPlanck> {
        let of_walls = self.number_of_wall(self.index_of_parameter(parameter)?).is_some();
        let lifted = if of_walls { None } else { Some(self.lifted(parameter)?) };
        let Some(lifted) = lifted.filter(|lifted| lifted.walls.iter().flatten().all(|number| is_real(*number))) else {
            let (method, what) = ("a derivative of the equations", "a parameter of walls, which are none of them");
            let remedy =
                "take the derivative of a density: `GridDensity::sensitivities` or `ClosureDensity::sensitivity`";
            return Err(Error::NotServed { method, what, remedy });
        };
        let derivative = lifted.derivative()?;
        if derivative.is_zero() { Err(independent(parameter)) } else { Ok(derivative) }
    }

    /// What of the problem moves with a parameter, whatever it is one of.
    ///
    /// # Errors
    /// As [`Problem::derivative`], but for those of walls.
    pub(crate) fn motion(&self, parameter: &str) -> Result<Motion> {
        let index = self.index_of_parameter(parameter)?;
        let mut walls = vec![[0.0; 2]; self.walls.len()];
        if let Some((wall, number)) = self.number_of_wall(index) {
            walls[wall][number] = 1.0;
            return Ok(Motion { operator: FokkerPlanck::zero(self.dimension()), walls });
        }
        let (family, lifted) = (self.family()?, self.lifted(parameter)?);
        for (wall, (rates, numbers)) in walls.iter_mut().zip(&lifted.walls).enumerate() {
            let follows = self.follows(family, wall);
            *rates = [0, 1].map(|k| if follows[k] { numbers[k].eps } else { 0.0 });
        }
        let motion = Motion { operator: lifted.derivative()?, walls };
        let fixed = motion.operator.is_zero() && motion.walls.iter().flatten().all(|rate| *rate == 0.0);
        if fixed { Err(independent(parameter)) } else { Ok(motion) }
    }

    /// The system with dual numbers for one parameter.
    fn lifted(&self, parameter: &str) -> Result<Lifted> {
        let seed = |name: &str, present: f64| Dual64::new(present, f64::from(u8::from(name == parameter)));
        self.family()?.lifted(&seed)
    }

    /// Which numbers of a wall, offset and restitution, are the definition's own.
    fn follows(&self, family: &dyn Family, wall: usize) -> [bool; 2] {
        family.walls().get(wall).map_or([false; 2], |own| own.shared(&self.walls[wall]))
    }

    /// The wall that a parameter is one of, and which of its numbers it is.
    fn number_of_wall(&self, index: usize) -> Option<(usize, usize)> {
        index.checked_sub(self.equations.parameters.len()).map(|beyond| (beyond / 2, beyond % 2))
    }

    fn index_of_parameter(&self, name: &str) -> Result<usize> {
        let unknown = || Error::not_a_name(name, "no parameter has it");
        self.parameters().iter().position(|(parameter, _)| parameter == name).ok_or_else(unknown)
    }

    fn family(&self) -> Result<&dyn Family> {
        let remedy = "make the problem by `Problem::parametric`, or from a text";
        let unknown = Error::NotKnown { what: "the system at other values of its parameters".into(), remedy };
        self.equations.family.as_deref().ok_or(unknown)
    }
}

fn independent(name: &str) -> Error {
    let remedy = "its expressions must contain the parameter, and not its value";
    Error::NotKnown { what: format!("how the equations depend on {name}"), remedy }
}
