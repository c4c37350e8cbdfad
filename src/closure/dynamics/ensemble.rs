//! Transients in three states and more, and under impulses: trajectories from the start find where the density is at a time, and its
//! means are theirs and, under steady noise, those of the moment equations.

use super::Dynamics;
use super::moment_system::{Law, MomentSystem};
use super::start::{Weighted, beginning};
use crate::checks::{positive, require};
use crate::closure::HIGHEST_ORDER;
use crate::closure::density::ClosureDensity;
use crate::closure::method::{Closure, Order};
use crate::closure::pilot::Pilot;
use crate::closure::sampled::SampledSystem;
use crate::closure::samples::FunctionFamily;
use crate::error::{Error, Result};
use crate::numerics::propagated;
use crate::problem::{Problem, Symmetry, TimeScales};
use crate::simulation::Simulation;
use crate::states::States;
use crate::transient::{Course, Start, Transient};
use faer::Mat;
use std::time::Instant;

/// The least order of the stationary density under which the moment equations of a transient are taken.
const CARRIED_BASE: u32 = 4;
/// The highest order of the stationary density under which the moment equations of a transient are taken.
const CARRIED_MOST: u32 = 6;
/// The trajectories of a transient, unless their number is given.
const ENSEMBLE: usize = 1 << 18;
/// The latest time of a transient that trajectories carry, in the shortest of the system's times: as long as the longest burn-in, a
/// bound on work.
const LONGEST: f64 = 2e3;

impl Closure {
    /// The densities at some times, where trajectories carry them.
    pub(super) fn carried_transient(
        &self,
        problem: &Problem,
        course: &Course,
        times: &[f64],
    ) -> Result<Vec<Transient<ClosureDensity>>> {
        let Course { start, envelope } = course;
        let steady = envelope.is_none();
        let begin = Instant::now();
        let at = |time: f64, density| Transient { time, density, step_error: 0.0 };
        self.check(problem.dimension(), HIGHEST_ORDER)?;
        match start {
            Start::Stationary if steady => {
                let density = self.solve(problem)?;
                return Ok(times.iter().map(|time| at(*time, density.clone())).collect());
            }
            Start::Density(_) => {
                let what = "a density as the start where trajectories carry it";
                return Err(Error::NotServed {
                    method: "closure",
                    what,
                    remedy: "take a point or a normal distribution",
                });
            }
            Start::Point(_) | Start::Gaussian(_) | Start::Stationary => {}
        }
        require_carried(problem, times)?;
        // The equations have means up to their own degree, whatever the order of their weight.
        let order = Order::Fixed(self.highest().clamp(CARRIED_BASE, CARRIED_MOST));
        let base = if steady { Some(Closure { order, ..self.clone() }.solve(problem)?) } else { None };
        let dynamics = base.as_ref().and_then(|base| base.dynamics.as_ref());
        let solved = dynamics.and_then(|dynamics| SolvedMoments::new(dynamics, start, times));
        let simulation = Simulation::new().trajectories(self.states.unwrap_or(ENSEMBLE));
        let states = simulation.seed(self.seed).states_at(problem, course, times)?;
        let closed = |(k, (time, states)): (usize, (f64, States))| {
            let pilot = Pilot::of(states, time);
            let symmetry = Symmetry::none(problem.dimension());
            let family = FunctionFamily::new(problem, &pilot, &self.degrees, &symmetry);
            let reason = "the trajectories lie on a surface: take a later time";
            let sampled = SampledSystem {
                problem: problem.clone(),
                family: family.ok_or(Error::NotClosed { order: self.lowest(), reason })?,
                pilot,
                rare: false,
                referred: false,
                seed: self.seed,
                memory: self.memory,
                begin,
            };
            let law = solved.as_ref().and_then(|solved| solved.law(k));
            let equations = law.as_ref().map(|law| (&law.points, law.masses.each_ref().map(Vec::as_slice)));
            let highest = HIGHEST_ORDER;
            // What no impulse has met is where the start was taken without, apart from the rest; of two parts the smaller one is missed.
            let unmet = (-time * problem.impulses().iter().map(|impulse| impulse.process().rate()).sum::<f64>()).exp();
            let missed = unmet.min(1.0 - unmet);
            Ok(at(time, self.at_order(highest, true, |order| sampled.at_time(order, equations, missed))?))
        };
        times.iter().copied().zip(states).enumerate().map(closed).collect()
    }
}

/// Refuses rising times that trajectories do not go to.
fn require_carried(problem: &Problem, times: &[f64]) -> Result<()> {
    if let Some(first) = times.first() {
        let remedy = "where trajectories carry the density the start itself is no answer";
        positive("first time of a transient", *first, remedy)?;
    }
    if let Some(&last) = times.last() {
        let longest = TimeScales::of(problem)?.short(LONGEST);
        let remedy = "trajectories go there step by step, and long before it the density is the stationary one";
        require(last <= longest, "last time of a transient", last, remedy)?;
    }
    Ok(())
}

/// The moment equations' solutions of two degrees at some times.
struct SolvedMoments<'a> {
    system: &'a MomentSystem,
    means: [Mat<f64>; 2],
}

impl<'a> SolvedMoments<'a> {
    /// None where a mode grows at every degree, or the start lies outside of the domain.
    fn new(dynamics: &'a Dynamics, start: &Start, times: &[f64]) -> Option<Self> {
        let system = dynamics.system()?;
        let weighted = Weighted::of(start, system).ok()?;
        let start = beginning(&weighted, system, &dynamics.domain).ok()?;
        let means = [false, true].map(|lower| {
            let matrix = system.matrix(lower);
            propagated(matrix, &start[..matrix.ncols()], times)
        });
        Some(SolvedMoments { system, means })
    }

    fn law(&self, time: usize) -> Option<Law> {
        self.system.law(self.means.each_ref().map(|means| means.col_as_slice(time)))
    }
}
