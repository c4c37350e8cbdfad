//! Transients from a start.

use super::served;
use crate::closure::density::ClosureDensity;
use crate::closure::method::Closure;
use crate::closure::{GRID_MEMORY, HIGHEST_ORDER, HIGHEST_ORDER_AT_WALLS};
use crate::error::Result;
use crate::grid::{Grid, GridDensity};
use crate::parallel;
use crate::problem::Problem;
use crate::transient::{Course, Transient, check_times};

/// The accuracy of the grid's densities in time: early, where an order follows a density well, 3e-4 doubles its distance, and 3e-5 takes
/// twice the time.
const ACCURACY: f64 = 1e-4;
/// The most unknowns that all steps of a grid together solve for: a bound on work, of a quarter of a minute and, on the
/// largest meshes, half of one. Densities of an oscillator up to the time at which the start is forgotten take two fifths of it, or less.
const MOST_SPENT: f64 = 8e6;

impl Closure {
    /// The densities of a problem at rising `times` after a start, each closed by this order.
    ///
    /// In one state and two they are the exponential polynomials closest to the densities of a grid in time ([`Closure::fit`] of
    /// [`GridDensity::transient`](crate::GridDensity::transient)): also next to walls, under noise that rises and fades, and from a point
    /// or a narrow Gaussian on. The estimate at each time is the distance with the grid's own error, below 1e-4. A linear system has its
    /// exact densities where it starts from a point or a Gaussian.
    ///
    /// In three states and more, and under impulses in any number, trajectories from the start
    /// ([`Simulation::transient`](crate::Simulation::transient)), 262 144 or [`Closure::pilot_states`], find where the density is at
    /// each time. Its means are theirs; under steady noise they are corrected by those of the moment equations as far as these are more accurate: to some 1e-6 of the
    /// low moments early, before the equations of finite degree fail, and again where the start is forgotten. Q is the most likely
    /// density with these means. Under an envelope the noise of 262 144 trajectories is a part of every answer and of its estimate.
    ///
    /// # Errors
    /// Those of the grid, of its transients and of [`Closure::fit`], and where trajectories carry the density those of [`Closure::solve`]
    /// and [`Error::NotServed`](crate::Error::NotServed) next to walls or if the start is a density;
    /// [`Error::Dimension`](crate::Error::Dimension) for the start of another number of states,
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) if times do not rise from 0 on, for a start outside of the domain, for a time at
    /// which a point has no density yet, and for one that takes too many steps: fit a grid's transient of a larger accuracy then.
    ///
    /// ```
    /// use expoly::{Closure, Density, Gaussian, models::{Linear, Solved}};
    /// use nalgebra::{dmatrix, dvector};
    /// // A linear oscillator at rest at x = 0.8: its mean is the free motion's.
    /// let problem = Linear::new(0.5, 1.0, 0.5)?.problem()?;
    /// let start = Gaussian { mean: dvector![0.8, 0.0], covariance: dmatrix![0.2, 0.0; 0.0, 0.2] };
    /// let at = Closure::new(2).transient(&problem, start, &[1.0, 3.0])?;
    /// let omega = 0.9375_f64.sqrt();
    /// let mean = |t: f64| 0.8 * (-0.25 * t).exp() * ((omega * t).cos() + 0.25 / omega * (omega * t).sin());
    /// assert!((at[1].moment(&[1, 0])?.value - mean(3.0)).abs() < 1e-7);
    /// assert!(at[1].density.l1_estimate() < 1e-7);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn transient(
        &self,
        problem: &Problem,
        course: impl Into<Course>,
        times: &[f64],
    ) -> Result<Vec<Transient<ClosureDensity>>> {
        self.evolved(problem, &course.into(), times)
    }

    fn evolved(&self, problem: &Problem, course: &Course, times: &[f64]) -> Result<Vec<Transient<ClosureDensity>>> {
        course.start.check(problem.dimension())?;
        let carried = problem.dimension() > 2 || !problem.impulses().is_empty();
        served(carried, problem)?;
        check_times(times, 0.0, "it is counted from the start on")?;
        let highest = if problem.walls().is_empty() { HIGHEST_ORDER } else { HIGHEST_ORDER_AT_WALLS };
        self.check(problem.dimension(), highest)?;
        if !problem.walls().is_empty() {
            self.require_complete_degrees()?;
        }
        if carried {
            return self.carried_transient(problem, course, times);
        }
        match self.normal_transient(problem, course, times) {
            Some(exact) => Ok(exact),
            None => self.transient_by_grid(problem, course, times),
        }
    }

    fn transient_by_grid(
        &self,
        problem: &Problem,
        course: &Course,
        times: &[f64],
    ) -> Result<Vec<Transient<ClosureDensity>>> {
        let memory = self.memory.at_most(GRID_MEMORY[problem.dimension() - 1]);
        let stationary = Grid::new().accuracy(ACCURACY).within(memory).solve(problem)?;
        let closest = |_, Transient { time, density, step_error }: Transient<GridDensity>| {
            Ok(Transient { time, density: self.fit(&density)?, step_error })
        };
        parallel::map_into(stationary.evolved(course, times, (ACCURACY, MOST_SPENT))?, closest).into_iter().collect()
    }
}
