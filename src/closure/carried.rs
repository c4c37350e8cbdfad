//! The way on the pilot's own states, in three of them and more: a run that is long enough, and the orders on it.

use super::density::ClosureDensity;
use super::method::{Closure, Order, Reference};
use super::pilot::PilotPlan;
use super::sampled::SampledSystem;
use super::samples::FunctionFamily;
use super::solve::{METHOD, is_rare, of_use};
use crate::closure::{HIGHEST_ORDER, LOW_DEGREE};
use crate::error::{Error, Result};
use crate::problem::{Problem, Symmetry};
use std::time::Instant;

/// The states of a pilot, without their mirror images, where they carry the density themselves. Halved or doubled, it makes the
/// standard error of E x² of an oscillator under filtered noise 1.8 or 0.44 times as large.
const CARRYING_STATES: usize = 102_400;
/// The states of a pilot that carry the density next to walls in three states and more, where functions with kinks have larger
/// variances: the L¹ distance of the displacement and its velocity from a long simulation, 5e-3, is 9e-3 with a quarter of
/// them.
const CARRYING_STATES_AT_WALLS: usize = 409_600;
/// Where more consecutive states of a trajectory than this are worth one independent state, the pilot's states are taken
/// farther apart.
const CORRELATED: f64 = 3.0;
/// The largest factor by which a pilot's states are taken farther apart: a bound on work.
const LONGER: f64 = 64.0;
/// Where so many consecutive states of a trajectory, taken farther apart, are still worth only one, the trajectories have not
/// left their starts.
const UNMIXED: f64 = 16.0;
/// Where this share of all states of a trajectory is worth only one, the trajectories have not left their starts: those of a
/// Brownian motion are all worth one.
const UNMIXED_SHARE: f64 = 0.75;
/// Why states have no density whose trajectories never leave the well where they began.
const STAYING: &str = "trajectories stay where they began, for longer than a pilot runs: the noise hardly takes them from well to well, \
    if it does at all, so take stronger noise, or a model of one well";

impl Closure {
    /// On the states of a pilot of a problem whose trajectories were shown to settle, or not.
    pub(super) fn on_states(&self, problem: &Problem, settles: bool, begin: Instant) -> Result<ClosureDensity> {
        let (dimension, walled) = (problem.dimension(), !problem.walls().is_empty());
        let referred = self.reference == Reference::Equations;
        if referred && (dimension > 4 || walled) {
            let what = if walled { "walls in three states and more on nodes" } else { "five states and more on nodes" };
            let remedy = "take the pilot's states, as is the default";
            return Err(Error::NotServed { method: METHOD, what, remedy });
        }
        let symmetry = if walled { Symmetry::none(dimension) } else { problem.symmetry() };
        let plan = PilotPlan::new(problem, self.seed, settles)?;
        let states = self.states.unwrap_or(if walled { CARRYING_STATES_AT_WALLS } else { CARRYING_STATES });
        let mut pilot = plan.pilot(states, 1.0)?;
        let mut slowness = pilot.slowness(&symmetry);
        let slower = if slowness > CORRELATED { plan.slower(slowness.min(LONGER), states, &pilot) } else { None };
        match slower.map(|plan| plan.pilot(states, 1.0)) {
            Some(Ok(longer)) => {
                pilot = longer;
                slowness = pilot.slowness(&symmetry);
            }
            Some(Err(error)) if !matches!(error, Error::Exploded { .. }) => return Err(error),
            // There is no time for shorter steps in a run that long.
            _ => {}
        }
        let samples = pilot.samples();
        pilot.stationary &= samples == 1 || slowness < unmixed(samples);
        let stayed = have_stayed(slowness, samples);
        let problem = problem.clone();
        let (seed, memory) = (self.seed, self.memory);
        let family = FunctionFamily::new(&problem, &pilot, &self.degrees, &symmetry).ok_or(Error::NotServed {
            method: METHOD,
            what: "noise on a gap at a wall that depends on the state there",
            remedy: "take the simulation",
        })?;
        let rare = is_rare(&problem, &pilot);
        let system = SampledSystem { problem, rare, family, pilot, referred, seed, memory, begin };
        let closed = |order| match self.order {
            // Where trajectories stayed, a low order shows in less time whether there is a density at all.
            Order::Fixed(_) if stayed && order > LOW_DEGREE => {
                system.closed(LOW_DEGREE).and_then(|_| system.best_up_to(order))
            }
            Order::Fixed(_) => system.best_up_to(order),
            Order::Adaptive(_) => system.closed(order),
        };
        let closed = self.at_order(HIGHEST_ORDER, true, |order| of_use(closed(order)?, order));
        closed.map_err(|error| match error {
            Error::NotClosed { order, .. } if stayed => Error::NotClosed { order, reason: STAYING },
            error => error,
        })
    }
}

/// The number of states worth one from which on trajectories of so many states have not left their starts.
fn unmixed(samples: usize) -> f64 {
    UNMIXED.min(UNMIXED_SHARE * samples as f64)
}

/// Whether trajectories of so many states have stayed where they began, as in wells that nothing leaves; of fewer than eight it shows
/// too little.
fn have_stayed(slowness: f64, samples: usize) -> bool {
    samples >= 8 && slowness > UNMIXED_SHARE * samples as f64
}
