//! Densities at given times after a start, and first passages.

use super::walk::Walk;
use super::{SimulatedDensity, Simulation};
use crate::checks::positive;
use crate::error::{Error, Result};
use crate::estimate::Estimate;
use crate::problem::Problem;
use crate::states::States;
use crate::transient::{Course, Transient, check_limits};
use std::time::Instant;

impl Simulation<'_> {
    /// The densities at rising `times` of a transient: each of the trajectories is observed once at each time. Errors are those of
    /// chance; trajectories are independent, and so are the batches that errors come from.
    ///
    /// White noise may rise and fade: in each step all columns of G are multiplied by e(t) at its middle, which is right to O(h²) as
    /// the step itself is, and a step ends wherever e(t) jumps or bends. Impulses are as they stand. From the stationary density
    /// trajectories first go through a burn-in. Where a density was asked for, impacts are those of the last time step.
    ///
    /// It is made with the trajectories, time step, seed, bins, further moments, memory limit, time budget and progress of the
    /// simulation. All that belongs to a stationary path is left out.
    ///
    /// # Errors
    /// Those of [`Simulation::run`]; [`Error::OutOfRange`] if times do not rise, or the first is not above zero;
    /// [`Error::NotServed`] if the start is a density; [`Error::OutOfTime`] where the budget is over.
    ///
    /// ```
    /// use expoly::{Course, Density, Envelope, Simulation, models::{Linear, Solved}};
    /// // From rest under noise of D = 0.5 for one time unit, and none from then on.
    /// let problem = Linear::new(0.5, 1.0, 0.5)?.problem()?;
    /// let burst = Course::from([0.0, 0.0]).under(Envelope::steps([(0.0, 1.0), (1.0, 0.0)])?);
    /// let at = Simulation::new().trajectories(20_480).transient(&problem, burst, &[1.0, 2.0])?;
    /// // 2D ∫ g(t − s)² ds over the burst, with the displacement g after a unit blow.
    /// assert!(at[0].moment(&[2, 0])?.deviation(0.192324) < 4.0);
    /// assert!(at[1].moment(&[2, 0])?.deviation(0.460460) < 4.0);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn transient(
        self,
        problem: &Problem,
        course: impl Into<Course>,
        times: &[f64],
    ) -> Result<Vec<Transient<SimulatedDensity>>> {
        if let Some(first) = times.first() {
            positive("first time of a transient", *first, "the start itself is known: take a later time")?;
        }
        let (course, begin) = (course.into(), Instant::now());
        let mut walk = Walk::new(self, problem, &course, (times, None))?;
        let at = |&time: &f64| {
            let mut density = walk.density(time)?;
            density.provenance.seconds = begin.elapsed().as_secs_f64();
            Ok(Transient { time, density, step_error: 0.0 })
        };
        times.iter().map(at).collect()
    }

    /// P(T > t) at rising `times` for the time T at which the displacement first leaves the interval between a lower and an upper
    /// level; an infinite one is none. It is the share of the trajectories that have not left; options are those of
    /// [`Simulation::transient`].
    ///
    /// # Errors
    /// Those of [`Simulation::transient`]; [`Error::NotADisplacement`] unless state 0 has a velocity; [`Error::OutOfRange`] for levels
    /// that are not numbers or leave no room.
    ///
    /// ```
    /// use expoly::{Simulation, Start, models::{Duffing, Solved}};
    /// let problem = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?;
    /// let below = [f64::NEG_INFINITY, 1.6269];
    /// let found = Simulation::new().trajectories(20_480).survival(&problem, below, Start::Stationary, &[20.0])?;
    /// assert!(found[0].deviation(0.60285) < 4.0); // the grid's
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn survival(
        self,
        problem: &Problem,
        within: [f64; 2],
        course: impl Into<Course>,
        times: &[f64],
    ) -> Result<Vec<Estimate>> {
        if problem.velocity_of(0).is_none() {
            return Err(Error::NotADisplacement { state: 0 });
        }
        check_limits(within)?;
        let course = course.into();
        let mut walk = Walk::new(self, problem, &course, (times, Some(within)))?;
        times.iter().map(|&time| walk.advance(time).map(|()| walk.survival())).collect()
    }

    /// The states of all trajectories at rising times.
    pub(crate) fn states_at(self, problem: &Problem, course: &Course, times: &[f64]) -> Result<Vec<States>> {
        let mut walk = Walk::new(self, problem, course, (times, None))?;
        times.iter().map(|&time| walk.advance(time).map(|()| walk.states())).collect()
    }
}
