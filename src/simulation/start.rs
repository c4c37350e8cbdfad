use super::Simulation;
use crate::problem::{Contact, Problem, reflect};
use crate::simulation::tuning;

/// Where trajectories begin.
#[derive(Debug)]
pub(super) struct Start {
    fixed: Option<Vec<f64>>,
    spread: Vec<f64>,
    /// The state of rest that no wall excludes.
    centre: Vec<f64>,
    contacts: Vec<Contact>,
}

impl Start {
    /// The start given to the simulation, or near 0, or beside the walls that exclude 0; each state spreads as far as the
    /// noise at 0 takes it in four steps.
    pub(super) fn new(simulation: &Simulation<'_>, problem: &Problem, step: f64) -> Self {
        let time = tuning::timetable::SPREAD_STEPS * step;
        let variance = |i: usize| {
            let at_rest = problem.noise().iter().map(|column| column[i].constant_term() * simulation.amplitude);
            let impulses = problem.impulses().iter().map(|impulse| {
                let struck = impulse.field()[i].constant_term() * simulation.amplitude;
                2.0 * impulse.jumps().intensity() * struck * struck
            });
            (at_rest.map(|g| g * g).sum::<f64>() + impulses.sum::<f64>()) * time
        };
        let deviation = |variance: f64| if variance > 0.0 { variance.sqrt() } else { 0.1 };
        let mut spread: Vec<f64> = (0..problem.dimension()).map(|i| deviation(variance(i))).collect();
        for &(i, j) in problem.displacements() {
            spread[i] = spread[j] * time;
        }
        Start { fixed: simulation.start.clone(), spread, centre: problem.still(), contacts: problem.contacts() }
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
        for ((x, spread), centre) in x.iter_mut().zip(&self.spread).zip(&self.centre) {
            *x = centre + *x * spread;
        }
        reflect(&self.contacts, x);
    }
}
