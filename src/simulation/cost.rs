//! What a time step costs, for bounds on work.

use crate::problem::Problem;

/// An impulse costs as much as so many time steps of a trajectory.
const ALONE: f64 = 16.0;

/// What a time step of a trajectory costs, relative to that under constant noise: noise that depends on the state makes it slower, in
/// proportion to its terms, and so do impulses, at each of which a trajectory goes on alone.
pub(crate) fn step_cost(problem: &Problem, step: f64) -> f64 {
    1.0 + problem.operator().varying_noise() as f64 + ALONE * problem.impulse_rate() * step
}
