//! What all methods have in common.

use crate::closure::{ClassicalClosure, Closure};
use crate::density::Density;
use crate::error::Result;
use crate::grid::Grid;
use crate::problem::Problem;

/// A way from a problem to its density, for programs that are written once for several of them.
///
/// [`Closure`], [`ClassicalClosure`] and [`Grid`] are methods, and so is every function from a problem to a density: one that has it in
/// closed form, or that runs a [`Simulation`](crate::Simulation). A method's own `solve` gives the density as what it is, with all that it
/// has beyond a [`Density`].
///
/// ```
/// use expoly::{Closure, Density, Grid, Method, Problem, models::{Duffing, Solved}};
/// let duffing = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
/// let exact = |_: &Problem| duffing.exact();
/// let methods: [&dyn Method; 3] = [&Closure::new(4), &Grid::new(), &exact];
/// for method in methods {
///     let density = method.density(&duffing.problem()?)?;
///     assert!((density.moment(&[0, 2])?.value - 1.0).abs() < 1e-6);  // D/c
/// }
/// # Ok::<(), expoly::Error>(())
/// ```
pub trait Method {
    /// The stationary density of a problem.
    ///
    /// # Errors
    /// Those of the method.
    fn density(&self, problem: &Problem) -> Result<Box<dyn Density>>;
}

impl Method for Closure {
    fn density(&self, problem: &Problem) -> Result<Box<dyn Density>> {
        Ok(Box::new(self.solve(problem)?))
    }
}

impl Method for ClassicalClosure {
    fn density(&self, problem: &Problem) -> Result<Box<dyn Density>> {
        Ok(Box::new(self.solve(problem)?.density()?))
    }
}

impl Method for Grid {
    fn density(&self, problem: &Problem) -> Result<Box<dyn Density>> {
        Ok(Box::new(self.solve(problem)?))
    }
}

impl<F: Fn(&Problem) -> Result<D>, D: Density + 'static> Method for F {
    fn density(&self, problem: &Problem) -> Result<Box<dyn Density>> {
        Ok(Box::new(self(problem)?))
    }
}
