//! The pilot: a short simulation that finds where the density is, before anything is computed.

use super::gaussian_closure::gaussian_closure;
use super::symmetry::Symmetry;
use super::units::natural_units;
use crate::eigenvalues::eigenvalues;
use crate::{Barrier, Error, FokkerPlanck, Gaussian, PolynomialDrift, Result, Simulation};
use nalgebra::{SMatrix, SVector};

/// Path-steps are cheapest in multiples of this many trajectories.
const TRAJECTORIES: usize = 512;
/// Groups of trajectories, whose spread tells the error.
const GROUPS: usize = 32;
/// The time step times the fastest rate. A pilot need not be exact: its moments are off by some tenths of a percent.
const STEP: f64 = 0.4;
/// How often the burn-in is doubled while the samples still change, and the step halved after an explosion.
const DOUBLINGS: u32 = 5;
const HALVINGS: u32 = 3;
/// The two halves of the samples may differ by so many standard errors.
const DRIFTING: f64 = 6.0;

/// The states that a pilot has visited once stationary.
#[derive(Clone, Debug)]
pub(super) struct Pilot<const N: usize> {
    /// The states of all trajectories, without their mirror images.
    pub(super) states: Vec<[f64; N]>,
    /// The factor that the noise intensities were multiplied by.
    pub(super) inflation: f64,
    /// Whether the first and the second half of the samples agree.
    pub(super) stationary: bool,
}

/// How to run pilots of one system.
pub(super) struct Scout<'a, T, const N: usize, const M: usize> {
    system: &'a T,
    barrier: Option<Barrier>,
    seed: u64,
    step: f64,
    burn_in: f64,
    interval: f64,
}

impl<'a, T: PolynomialDrift<N, M> + Sync, const N: usize, const M: usize> Scout<'a, T, N, M> {
    /// Time step and burn-in from the rates of the linearised system.
    pub(super) fn new(system: &'a T, operator: &FokkerPlanck<N>, barrier: Option<Barrier>, seed: u64) -> Result<Self> {
        let gaussian = match gaussian_closure(operator) {
            Ok(gaussian) => gaussian,
            // Where the Gaussian closure does not settle the system may still be stable: the simulation will tell.
            Err(Error::NoStationaryDensity { .. }) => {
                let (frame, _) = natural_units(operator)?;
                let scale = frame.scale();
                Gaussian { mean: SVector::zeros(), covariance: scale * scale.transpose() }
            }
            Err(error) => return Err(error),
        };
        let (fastest, slowest) = rates(operator, &gaussian);
        let unit = fastest.recip();
        Ok(Scout {
            system,
            barrier,
            seed,
            step: STEP * unit,
            burn_in: (5.0 / slowest).clamp(60.0 * unit, 2000.0 * unit),
            interval: 4.0 * unit,
        })
    }

    /// About `count` states under intensities multiplied by `inflation`, or by less where that explodes.
    pub(super) fn pilot(&self, count: usize, inflation: f64) -> Result<Pilot<N>> {
        let mut inflation = inflation;
        loop {
            match self.at(count, inflation) {
                Err(Error::Exploded { .. }) if inflation > 1.0 => inflation = (inflation / 1.5).max(1.0),
                result => return result,
            }
        }
    }

    fn at(&self, count: usize, inflation: f64) -> Result<Pilot<N>> {
        let (mut step, mut burn_in) = (self.step, self.burn_in);
        let (mut halved, mut doubled) = (0, 0);
        loop {
            let mut simulation = Simulation::new(self.system)
                .amplified(inflation.sqrt())
                .trajectories(TRAJECTORIES)
                .samples(count)
                .time_step(step)
                .burn_in(burn_in)
                .sampling_interval(self.interval)
                .seed(self.seed);
            if let Some(barrier) = self.barrier {
                simulation = simulation.barrier(barrier);
            }
            match simulation.states() {
                Ok(states) => {
                    let stationary = stationary(&states);
                    if stationary || doubled == DOUBLINGS {
                        return Ok(Pilot { states, inflation, stationary });
                    }
                    (burn_in, doubled) = (2.0 * burn_in, doubled + 1);
                }
                Err(Error::Exploded { .. }) if halved < HALVINGS => (step, halved) = (step / 2.0, halved + 1),
                Err(error) => return Err(error),
            }
        }
    }
}

impl<const N: usize> Pilot<N> {
    /// The largest kurtosis E z⁴/(E z²)² of the states about 0.
    pub(super) fn kurtosis(&self) -> f64 {
        let mean =
            |i: usize, power: i32| self.states.iter().map(|x| x[i].powi(power)).sum::<f64>() / self.states.len() as f64;
        (0..N).map(|i| mean(i, 4) / mean(i, 2).powi(2)).fold(0.0, f64::max)
    }

    /// Centre and standard deviations of the states and their mirror images.
    pub(super) fn spread(&self, symmetry: &Symmetry<N>) -> ([f64; N], [f64; N]) {
        let count = self.states.len() as f64;
        let mean: [f64; N] = std::array::from_fn(|i| {
            if symmetry.flips(i) { 0.0 } else { self.states.iter().map(|x| x[i]).sum::<f64>() / count }
        });
        let deviation =
            std::array::from_fn(|i| (self.states.iter().map(|x| (x[i] - mean[i]).powi(2)).sum::<f64>() / count).sqrt());
        (mean, deviation)
    }
}

/// The fastest and the slowest rate of the system near the Gaussian: bounds on its Jacobian's eigenvalues, in units of
/// the standard deviations, at points one and two deviations away; and the slowest decay of the linearised system.
fn rates<const N: usize>(operator: &FokkerPlanck<N>, gaussian: &Gaussian<N>) -> (f64, f64) {
    let deviation: [f64; N] = std::array::from_fn(|i| gaussian.covariance[(i, i)].sqrt());
    let mean: [f64; N] = gaussian.mean.into();
    let mut fastest = 0.0_f64;
    for reach in [0.0, 1.0, 2.0] {
        for i in 0..N {
            for sign in [-1.0, 1.0] {
                let mut x = mean;
                x[i] += sign * reach * deviation[i];
                for a in 0..N {
                    let slopes = operator.drift()[a].gradient(&x);
                    let row: f64 = (0..N).map(|b| slopes[b].abs() * deviation[b] / deviation[a]).sum();
                    fastest = fastest.max(row);
                }
            }
        }
    }
    let slopes = SMatrix::<f64, N, N>::from_fn(|i, j| gaussian.expectation(&operator.drift()[i].derivative(j)));
    let slopes = nalgebra::DMatrix::from_fn(N, N, |i, j| slopes[(i, j)]);
    let slowest = eigenvalues(slopes).iter().map(|l| l.re.abs()).fold(f64::INFINITY, f64::min);
    (fastest.max(f64::MIN_POSITIVE), slowest.max(1e-3 * fastest))
}

/// Whether means of squares agree between the earlier and the later half of each trajectory's samples.
fn stationary<const N: usize>(states: &[[f64; N]]) -> bool {
    let samples = states.len() / TRAJECTORIES;
    let group = TRAJECTORIES / GROUPS * samples;
    (0..N).all(|i| {
        let square = |part: &[[f64; N]]| part.iter().map(|x| x[i] * x[i]).sum::<f64>() / part.len() as f64;
        let differences: Vec<f64> = (0..GROUPS)
            .map(|g| {
                let trajectories = states[g * group..(g + 1) * group].chunks_exact(samples);
                let change = trajectories.map(|trajectory| {
                    let (early, late) = trajectory.split_at(samples / 2);
                    square(late) - square(early)
                });
                change.sum::<f64>() * GROUPS as f64 / TRAJECTORIES as f64
            })
            .collect();
        let mean = differences.iter().sum::<f64>() / GROUPS as f64;
        let variance = differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (GROUPS * GROUPS) as f64;
        let level = states.iter().map(|x| x[i] * x[i]).sum::<f64>() / states.len() as f64;
        // A change below a hundredth matters to no pilot.
        mean.abs() <= DRIFTING * variance.sqrt() || mean.abs() <= 0.01 * level
    })
}
