//! Where the density is: states of trajectories, before anything is computed.

use super::shape::{MOST, Place};
use crate::error::Result;
use crate::polynomial::Gaussian;
use crate::problem::{Problem, TimeScales};
use crate::simulation::{Simulation, settled};
use crate::states::States;
use crate::transient::Start;
use nalgebra::{DMatrix, DVector};

/// Trajectories of the pilot's main run, which starts near rest.
const TRAJECTORIES: usize = 64;
/// States of the pilot's main run. With 20 000 to 100 000 the meshes that follow have as many cells.
const STATES: usize = 20_480;
/// Trajectories of the pilot's run from farther starts, which finds wells that the main run misses.
const SCATTERED: usize = 16;
/// States of each trajectory in the pilot's run from farther starts.
const EACH: usize = 60;
/// The standard deviation of the pilot's farther starts over the distance of the outermost state of its main run from the
/// middle. The time step from there is shorter by the same factor.
const FARTHER: f64 = 5.0;
/// The time step of the pilot's run from farther starts, in the shortest of the system's times, before it is shortened for the
/// steeper forces there.
const STEP: f64 = 0.4;
/// The time between states in the pilot's run from farther starts, in the shortest of the system's times.
const INTERVAL: f64 = 4.0;

/// States that trajectories have visited, with their mirror images.
#[derive(Clone, Debug)]
pub(super) struct GridPilot {
    pub(super) states: States,
    /// Whether trajectories were shown to settle.
    pub(super) settles: bool,
}

impl GridPilot {
    /// From near 0, and from starts that are scattered over more than what these have reached, so that no well is missed.
    ///
    /// # Errors
    /// [`Error::Exploded`](crate::Error::Exploded) with every time step that was tried, [`Error::NoDensity`](crate::Error::NoDensity)
    /// where trajectories keep growing or end at a point.
    pub(super) fn new(problem: &Problem) -> Result<Self> {
        let (states, settles) = settled(problem, [TRAJECTORIES, STATES])?;
        let mut pilot = GridPilot { states, settles };
        let (reach, middle, states) = (pilot.reach(), pilot.middle(), problem.dimension());
        let deviation = |axis: usize| FARTHER * (reach[axis][1] - middle[axis]).max(middle[axis] - reach[axis][0]);
        let covariance = DMatrix::from_fn(states, states, |i, j| if i == j { deviation(i).powi(2) } else { 0.0 });
        let start = Gaussian { mean: DVector::from_fn(states, |axis, _| middle[axis]), covariance };
        // From too far trajectories may explode with any step.
        if let Ok(more) = scattered(problem, start) {
            more.iter().for_each(|x| pilot.states.push(x));
        }
        let own = pilot.states.clone();
        for flip in &problem.symmetry().changes()[1..] {
            for x in &own {
                let image: Vec<f64> = x.iter().zip(flip).map(|(x, flips)| if *flips { -x } else { *x }).collect();
                pilot.states.push(&image);
            }
        }
        Ok(pilot)
    }

    /// The lowest and the highest value of each state.
    pub(super) fn reach(&self) -> [[f64; 2]; MOST] {
        std::array::from_fn(|axis| {
            let values = self.states.iter().filter_map(|x| x.get(axis));
            values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(*x), high.max(*x)])
        })
    }

    pub(super) fn middle(&self) -> Place {
        std::array::from_fn(|axis| {
            self.states.iter().filter_map(|x| x.get(axis)).sum::<f64>() / self.states.len() as f64
        })
    }

    /// The standard deviation of a state.
    pub(super) fn deviation(&self, axis: usize) -> f64 {
        self.states.deviations().get(axis).copied().unwrap_or_default()
    }

    /// Where most states are: the state in the middle, by its first coordinate, of the fullest of a few thousand boxes.
    pub(super) fn peak(&self) -> Vec<f64> {
        const BOXES: f64 = 60.0;
        let reach = self.reach();
        let index = |x: &[f64]| -> Vec<usize> {
            let of =
                |(axis, x): (usize, &f64)| ((x - reach[axis][0]) / (reach[axis][1] - reach[axis][0]) * BOXES) as usize;
            x.iter().enumerate().map(of).collect()
        };
        let mut counts = std::collections::BTreeMap::new();
        for x in &self.states {
            counts.entry(index(x)).or_insert_with(Vec::new).push(x);
        }
        let fullest = counts.into_values().max_by_key(Vec::len).unwrap_or_default();
        fullest.get(fullest.len() / 2).map_or_else(Vec::new, |x| x.to_vec())
    }
}

/// States of trajectories from farther starts, where forces are steeper, and steps shorter.
fn scattered(problem: &Problem, start: Gaussian) -> Result<States> {
    let scales = TimeScales::of(problem)?;
    Simulation::new()
        .trajectories(SCATTERED)
        .samples(EACH * SCATTERED)
        .start(Start::Gaussian(start))
        .time_step(scales.short(STEP) / FARTHER)
        .sampling_interval(scales.short(INTERVAL))
        .states(problem)
}
