use super::Simulation;
use crate::problem::{Problem, Wall};
use crate::simulation::tuning;

/// Where trajectories begin.
#[derive(Debug)]
pub(super) struct Start {
    fixed: Option<Vec<f64>>,
    spread: Vec<f64>,
    wall: Option<Wall>,
}

impl Start {
    /// The start given to the simulation, or near 0, or near the wall if that stands above 0; each state spreads as far as
    /// the noise at 0 takes it in four steps.
    pub(super) fn new(simulation: &Simulation<'_>, problem: &Problem, wall: Option<Wall>, step: f64) -> Self {
        let time = tuning::timetable::SPREAD_STEPS * step;
        let variance = |i: usize| {
            let at_rest = problem.noise().iter().map(|column| column[i].constant_term() * simulation.amplitude);
            at_rest.map(|g| g * g).sum::<f64>() * time
        };
        let deviation = |variance: f64| if variance > 0.0 { variance.sqrt() } else { 0.1 };
        let mut spread: Vec<f64> = (0..problem.dimension()).map(|i| deviation(variance(i))).collect();
        for &(i, j) in problem.displacements() {
            spread[i] = spread[j] * time;
        }
        Start { fixed: simulation.start.clone(), spread, wall }
    }

    /// The number of states.
    pub(super) fn states(&self) -> usize {
        self.spread.len()
    }

    /// Turns standard normal numbers into the state that a trajectory begins at.
    pub(super) fn place(&self, x: &mut [f64]) {
        if let Some(fixed) = &self.fixed {
            return x.copy_from_slice(fixed);
        }
        for (x, spread) in x.iter_mut().zip(&self.spread) {
            *x *= spread;
        }
        if let Some(b) = self.wall.map(|wall| wall.offset()) {
            x[0] = b + (b.max(0.0) - b + x[0]).abs();
        }
    }
}
