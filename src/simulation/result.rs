use super::{
    histogram::Histogram,
    jackknife::jackknife,
    passage::POWERS,
    tally::{Layout, Tally},
};
use crate::error::state_index;
use crate::{Barrier, Estimate, Monomial, Result};

/// How a simulation was made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Provenance {
    /// The seed; trajectory i owns stream i.
    pub seed: u64,
    /// The number of independent trajectories.
    pub trajectories: usize,
    /// The number of samples in all.
    pub samples: usize,
    /// The number of time steps of all trajectories together, burn-in included.
    pub path_steps: u64,
    /// The time step h.
    pub time_step: f64,
    /// The time before the first sample, as rounded.
    pub burn_in: f64,
    /// The time between two samples of a trajectory, as rounded.
    pub sampling_interval: f64,
    /// The wall-clock time in seconds.
    pub seconds: f64,
}

/// The stationary density as a simulation found it: every value with its standard error.
///
/// Errors come from the spread between independent batches of trajectories. They cover chance, not the time step: for
/// that see [`Simulation::time_step`](crate::Simulation::time_step).
#[derive(Clone, Debug)]
pub struct SimulatedDensity<const N: usize> {
    pub(super) batches: Vec<Tally<N>>,
    pub(super) layout: Layout<N>,
    marginals: [Histogram<1>; N],
    joint: Option<Histogram<2>>,
    pub(super) barrier: Option<Barrier>,
    pub(super) levels: Vec<f64>,
    /// The velocity of state 0.
    pub(super) velocity: Option<usize>,
    provenance: Provenance,
}

impl<const N: usize> SimulatedDensity<N> {
    pub(super) fn new(
        mut batches: Vec<Tally<N>>,
        layout: Layout<N>,
        barrier: Option<Barrier>,
        levels: Vec<f64>,
        velocity: Option<usize>,
        provenance: Provenance,
    ) -> Self {
        let marginals = std::array::from_fn(|i| {
            let counts = batches.iter_mut().map(|b| std::mem::take(&mut b.marginals[i])).collect();
            Histogram::new([layout.axes[i]], counts)
        });
        let counts = batches.iter_mut().filter_map(|b| b.joint.take()).collect();
        let joint = layout.plane.map(|plane| Histogram::new(plane, counts));
        SimulatedDensity { batches, layout, marginals, joint, barrier, levels, velocity, provenance }
    }

    /// Seed, counts, times.
    pub fn provenance(&self) -> &Provenance {
        &self.provenance
    }

    /// The histogram of one state.
    ///
    /// # Errors
    /// [`Error::Dimension`](crate::Error::Dimension) if there is no such state; so for every statistic of one state.
    pub fn histogram(&self, state: usize) -> Result<&Histogram<1>> {
        Ok(&self.marginals[state_index::<N>("a state's index", state)?])
    }

    /// The joint histogram of states 0 and 1; none for a single state.
    pub fn joint(&self) -> Option<&Histogram<2>> {
        self.joint.as_ref()
    }

    /// The mean m of one state.
    ///
    /// # Errors
    /// As [`SimulatedDensity::histogram`].
    pub fn mean(&self, state: usize) -> Result<Estimate> {
        self.of_state(state, |[m, ..]| m)
    }

    /// The skewness about the mean, E(x − m)³ / (Var x)^(3/2).
    ///
    /// # Errors
    /// As [`SimulatedDensity::histogram`].
    pub fn skewness(&self, state: usize) -> Result<Estimate> {
        self.of_state(state, |raw| {
            let [variance, third, _] = central(raw);
            third / variance.powf(1.5)
        })
    }

    /// The kurtosis about the mean, E(x − m)⁴ / (Var x)²: 3 for a normal distribution.
    ///
    /// # Errors
    /// As [`SimulatedDensity::histogram`].
    pub fn kurtosis(&self, state: usize) -> Result<Estimate> {
        self.of_state(state, |raw| {
            let [variance, _, fourth] = central(raw);
            fourth / variance.powi(2)
        })
    }

    /// The skewness about zero, E x³ / (E x²)^(3/2): the better estimate for a velocity, whose mean is known to be zero.
    ///
    /// # Errors
    /// As [`SimulatedDensity::histogram`].
    pub fn skewness_about_zero(&self, state: usize) -> Result<Estimate> {
        self.of_state(state, |[_, m2, m3, _]| m3 / m2.powf(1.5))
    }

    /// The kurtosis about zero, E x⁴ / (E x²)².
    ///
    /// # Errors
    /// As [`SimulatedDensity::histogram`].
    pub fn kurtosis_about_zero(&self, state: usize) -> Result<Estimate> {
        self.of_state(state, |[_, m2, _, m4]| m4 / m2.powi(2))
    }

    /// The number of impacts per unit time; none without a wall.
    pub fn impact_rate(&self) -> Option<Estimate> {
        self.barrier.map(|_| self.rate(1, |b| b.passages.impacts))
    }

    /// The mean speed of approach at an impact; none without a wall.
    pub fn mean_impact_speed(&self) -> Option<Estimate> {
        let sums = |b: &Tally<N>| [b.passages.impacts[0], b.passages.impacts[1]];
        self.barrier.map(|_| jackknife(&self.batches, sums, |[count, speed]| speed / count))
    }

    /// What is missing in the power balance of the velocity v of state 0, relative to the power put in by noise:
    ///
    /// 1 − { ½(1 − r²) ν E(v₋²) − E(v f_v) } / E(½B_vv),
    ///
    /// with the Itô drift f, the impact rate ν and the speed v₋ of approach. Zero for the true stationary density. None
    /// where state 0 is no displacement.
    pub fn energy_balance(&self) -> Option<Estimate> {
        self.velocity?;
        let loss = self.barrier.map_or(0.0, |wall| (1.0 - wall.restitution().powi(2)) / 2.0);
        let sums = |b: &Tally<N>| [b.moments[0], b.power[0], b.power[1], loss * b.passages.impacts[2], b.time];
        Some(jackknife(&self.batches, sums, |[count, injected, drift, impacts, time]| {
            1.0 - (drift / count + impacts / time) * count / injected
        }))
    }

    /// The drift of E x_i² from the first half of the samples to the second, in units of its standard error, for each
    /// state: beyond ±4 the burn-in was too short. Not a number where a half is empty.
    pub fn stationarity(&self) -> [f64; N] {
        std::array::from_fn(|i| {
            let sums = |b: &Tally<N>| {
                let [(n1, first), (n2, second)] = b.halves;
                [n1, first[i], n2, second[i]]
            };
            let change = jackknife(&self.batches, sums, |[n1, s1, n2, s2]| s2 / n2 - s1 / n1);
            change.value / change.error
        })
    }

    /// A function of the raw moments 1 to 4 of one state.
    pub(super) fn of_state(&self, state: usize, value: impl Fn([f64; 4]) -> f64) -> Result<Estimate> {
        let state = state_index::<N>("a state's index", state)?;
        let power = |p: u32| self.tracked(std::array::from_fn(|i| if i == state { p } else { 0 }));
        let places: [Option<usize>; 4] = std::array::from_fn(|k| power(k as u32 + 1));
        let sums = |b: &Tally<N>| {
            let raw = places.map(|place| place.map_or(f64::NAN, |k| b.moments[k]));
            [b.moments[0], raw[0], raw[1], raw[2], raw[3]]
        };
        Ok(jackknife(&self.batches, sums, |[n, s1, s2, s3, s4]| value([s1 / n, s2 / n, s3 / n, s4 / n])))
    }

    /// The place of a monomial among the tracked ones.
    pub(super) fn tracked(&self, powers: [u32; N]) -> Option<usize> {
        self.layout.monomials.iter().position(|m| *m == Monomial(powers))
    }

    /// A flux moment Σ|v|^(power − 1) per unit time. What was never met has the error of one passage at unit speed.
    pub(super) fn rate(&self, power: usize, passages: impl Fn(&Tally<N>) -> [f64; POWERS]) -> Estimate {
        let sums = |b: &Tally<N>| [passages(b)[power - 1], b.time];
        let rate = jackknife(&self.batches, sums, |[sum, time]| sum / time);
        let time: f64 = self.batches.iter().map(|b| b.time).sum();
        if rate.value == 0.0 { Estimate::new(0.0, time.recip()) } else { rate }
    }
}

/// The central moments 2, 3, 4 from the raw moments 1 to 4.
pub(super) fn central([m, m2, m3, m4]: [f64; 4]) -> [f64; 3] {
    let variance = m2 - m * m;
    let third = m3 - 3.0 * m * m2 + 2.0 * m.powi(3);
    let fourth = m4 - 4.0 * m * m3 + 6.0 * m * m * m2 - 3.0 * m.powi(4);
    [variance, third, fourth]
}
