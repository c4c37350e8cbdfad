use super::{
    ensemble::deal,
    histogram::Histogram,
    jackknife::{controlled, jackknife},
    passage::POWERS,
    plan::Plan,
    store::{Reader, Stored},
    tally::{Layout, Tally},
    timetable::BURN_IN_STRETCHES,
};
use crate::error::state_index;
use crate::{Barrier, Estimate, Monomial, Result};

/// What ended a simulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stopped {
    /// All samples that were asked for are there.
    Samples,
    /// Every estimate named in [`Simulation::until`](crate::Simulation::until) is as precise as asked.
    Precision,
    /// The time of [`Simulation::time_budget`](crate::Simulation::time_budget) was over.
    TimeBudget,
}

impl Stored for Stopped {
    fn write(&self, out: &mut Vec<u8>) {
        (*self as u8).write(out);
    }
    fn read(input: &mut Reader<'_>) -> Option<Self> {
        let code = u8::read(input)?;
        [Stopped::Samples, Stopped::Precision, Stopped::TimeBudget].into_iter().find(|s| *s as u8 == code)
    }
}

/// How a simulation was made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Provenance {
    /// The seed; trajectory i owns stream i. The lowest one where runs with several seeds are merged.
    pub seed: u64,
    /// The number of independent runs, each with a seed of its own: 1 unless runs with several seeds are merged.
    pub runs: usize,
    /// The number of independent trajectories.
    pub trajectories: usize,
    /// The number of samples in all.
    pub samples: usize,
    /// The number of time steps of all trajectories together, burn-in and pilot included.
    pub path_steps: u64,
    /// The time step h.
    pub time_step: f64,
    /// The rate ω that the time step was chosen by, or none where the time step was given.
    pub rate: Option<f64>,
    /// The time before the first sample, as rounded.
    pub burn_in: f64,
    /// The time between two samples of a trajectory, as rounded.
    pub sampling_interval: f64,
    /// The wall-clock time in seconds; of a resumed run, all its sessions; of merged parts, their sum.
    pub seconds: f64,
    /// What ended it.
    pub stopped: Stopped,
}

/// The stationary density as a simulation found it: every value with its standard error.
///
/// Errors come from the spread between independent batches of trajectories, those of [`statistics`](crate::statistics) as
/// well. They cover chance, and with [`Simulation::two_steps`](crate::Simulation::two_steps) the time step too, except in
/// histograms.
#[derive(Clone, Debug)]
pub struct SimulatedDensity<const N: usize> {
    pub(super) batches: Vec<Tally<N>>,
    pub(super) plan: Plan<N>,
    pub(super) layout: Layout<N>,
    marginals: [Histogram<1>; N],
    joint: Option<Histogram<2>>,
    pub(super) barrier: Option<Barrier>,
    pub(super) levels: Vec<f64>,
    /// The velocity of state 0.
    pub(super) velocity: Option<usize>,
    /// The same with twice the time step and the same noise.
    pub(super) coarse: Option<Box<Self>>,
    /// Whether the power balance is a control variate.
    balanced: bool,
    provenance: Provenance,
}

impl<const N: usize> SimulatedDensity<N> {
    pub(super) fn new(mut batches: Vec<Tally<N>>, plan: Plan<N>, seconds: f64, stopped: Stopped) -> Self {
        let layout = plan.layout();
        let provenance = provenance(&batches, &plan, seconds, stopped);
        let marginals = std::array::from_fn(|i| {
            let counts = batches.iter_mut().map(|b| std::mem::take(&mut b.marginals[i])).collect();
            Histogram::new([layout.axes[i]], counts)
        });
        let counts = batches.iter_mut().filter_map(|b| b.joint.take()).collect();
        let joint = layout.plane.map(|plane| Histogram::new(plane, counts));
        let (barrier, levels, velocity) = (plan.barrier, plan.levels.clone(), plan.velocity);
        SimulatedDensity {
            batches,
            plan,
            layout,
            marginals,
            joint,
            barrier,
            levels,
            velocity,
            coarse: None,
            balanced: false,
            provenance,
        }
    }

    /// The batches' tallies as they were before their counts went into the histograms.
    pub(super) fn into_tallies(self) -> Vec<Tally<N>> {
        let SimulatedDensity { mut batches, marginals, joint, .. } = self;
        for (i, histogram) in marginals.into_iter().enumerate() {
            batches.iter_mut().zip(histogram.into_batches()).for_each(|(b, counts)| b.marginals[i] = counts);
        }
        let counts = joint.into_iter().flat_map(Histogram::into_batches);
        batches.iter_mut().zip(counts).for_each(|(b, counts)| b.joint = Some(counts));
        batches
    }

    /// The same simulation with twice the time step and the same noise, if
    /// [`Simulation::two_steps`](crate::Simulation::two_steps) was asked for.
    pub fn coarse(&self) -> Option<&Self> {
        self.coarse.as_deref()
    }

    /// A function of sums over all batches, with both parts of its error.
    pub(super) fn estimate<const K: usize>(
        &self,
        sums: impl Fn(&Tally<N>) -> [f64; K],
        value: impl Fn([f64; K]) -> f64,
    ) -> Estimate {
        self.with_both_errors(|density| {
            if density.balanced {
                controlled(&density.batches, (&sums, &value), (|b: &Tally<N>| density.power_sums(b), missing_power))
            } else {
                jackknife(&density.batches, &sums, &value)
            }
        })
    }

    /// The estimate, with the error of the time step added to its standard error if there is a coarse twin to tell it.
    ///
    /// The bias is of order h², so that it is a third of the change from h to 2h. Beside a wall with r < 1 the impact rate
    /// has a remainder of first order, which is the whole change.
    pub(super) fn with_both_errors(&self, of: impl Fn(&Self) -> Estimate) -> Estimate {
        let fine = of(self);
        let Some(coarse) = &self.coarse else { return fine };
        Estimate::new(fine.value, fine.error.hypot(self.bias_share() * (of(coarse).value - fine.value)))
    }

    /// The share of the change from h to 2h that is counted as an error.
    pub(super) fn bias_share(&self) -> f64 {
        if self.barrier.is_some_and(|wall| wall.restitution() < 1.0) { 1.0 } else { 3.0_f64.recip() }
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
        self.barrier.map(|_| self.mean_of_impact_speeds(1))
    }

    /// The mean of a power of the speed of approach, 1 or 2.
    pub(crate) fn mean_of_impact_speeds(&self, power: usize) -> Estimate {
        let sums = |b: &Tally<N>| [b.passages.impacts[0], b.passages.impacts[power]];
        self.estimate(sums, |[count, speeds]| speeds / count)
    }

    /// What is missing in the power balance of the velocity v of state 0, relative to the power put in by noise:
    ///
    /// 1 − { ½(1 − r²) ν E(v₋²) − E(v f_v) } / E(½B_vv),
    ///
    /// with the Itô drift f, the impact rate ν and the speed v₋ of approach. Zero for the true stationary density. None
    /// where state 0 is no displacement.
    pub fn energy_balance(&self) -> Option<Estimate> {
        self.velocity?;
        Some(self.with_both_errors(|d| jackknife(&d.batches, |b| d.power_sums(b), missing_power)))
    }

    /// What [`missing_power`] is made of.
    fn power_sums(&self, b: &Tally<N>) -> [f64; 5] {
        let loss = self.barrier.map_or(0.0, |wall| (1.0 - wall.restitution().powi(2)) / 2.0);
        [b.moments[0], b.power[0], b.power[1], loss * b.passages.impacts[2], b.time]
    }

    /// The same result with the power balance as a control variate of every moment, rate and function of them.
    ///
    /// In a weakly damped oscillator the energy wanders slowly, and all estimates with it. What is missing in the power
    /// balance ([`SimulatedDensity::energy_balance`]) wanders along, but is known to be zero in the mean: a part of each
    /// estimate can be told from it and taken away. For c = D = 0.2 and r = 1 nothing is left of the error of E v², for
    /// r = 0.9 a fraction. The time step has a share of order h² in the balance as well, so that biases of that order
    /// change. No change where state 0 is no displacement.
    #[must_use]
    pub fn balanced(mut self) -> Self {
        self.balanced = self.velocity.is_some();
        self.coarse = self.coarse.map(|twin| Box::new(twin.balanced()));
        self
    }

    /// The drift of E x_i² from the first half of the samples to the second, in units of its standard error, for each
    /// state: beyond ±4 the burn-in was too short. Not a number where a half is empty.
    pub fn stationarity(&self) -> [f64; N] {
        std::array::from_fn(|i| {
            let sums = |b: &Tally<N>| {
                let [(n1, first), (n2, second)] = b.trend.halves(i, b.samples);
                [n1, first, n2, second]
            };
            let change = jackknife(&self.batches, sums, |[n1, s1, n2, s2]| s2 / n2 - s1 / n1);
            change.value / change.error
        })
    }

    /// A function of the raw moments 1 to 4 of one state.
    pub(crate) fn of_state(&self, state: usize, value: impl Fn([f64; 4]) -> f64) -> Result<Estimate> {
        let state = state_index::<N>("a state's index", state)?;
        let power = |p: u32| self.tracked(std::array::from_fn(|i| if i == state { p } else { 0 }));
        let places: [Option<usize>; 4] = std::array::from_fn(|k| power(k as u32 + 1));
        let sums = |b: &Tally<N>| {
            let raw = places.map(|place| place.map_or(f64::NAN, |k| b.moments[k]));
            [b.moments[0], raw[0], raw[1], raw[2], raw[3]]
        };
        Ok(self.estimate(sums, |[n, s1, s2, s3, s4]| value([s1 / n, s2 / n, s3 / n, s4 / n])))
    }

    /// The place of a monomial among the tracked ones.
    pub(super) fn tracked(&self, powers: [u32; N]) -> Option<usize> {
        self.layout.monomials.iter().position(|m| *m == Monomial(powers))
    }

    /// A flux moment Σ|v|^(power − 1) per unit time. What was never met has the error of one passage at unit speed.
    pub(super) fn rate(&self, power: usize, passages: impl Fn(&Tally<N>) -> [f64; POWERS]) -> Estimate {
        let sums = |b: &Tally<N>| [passages(b)[power - 1], b.time];
        let rate = self.estimate(sums, |[sum, time]| sum / time);
        let time: f64 = self.batches.iter().map(|b| b.time).sum();
        if rate.value == 0.0 { Estimate::new(0.0, time.recip()) } else { rate }
    }
}

fn provenance<const N: usize>(batches: &[Tally<N>], plan: &Plan<N>, seconds: f64, stopped: Stopped) -> Provenance {
    let ranges = deal(plan.trajectories);
    let size = |b: &Tally<N>| ranges.get(b.origin.batch).map_or(0, |range| (range.end - range.start) as usize);
    let mut seeds: Vec<u64> = batches.iter().map(|b| b.origin.seed).collect();
    seeds.sort_unstable();
    seeds.dedup();
    let own = |b: &Tally<N>| plan.path_steps(size(b), b.samples) - plan.pilot_steps();
    Provenance {
        seed: seeds.first().copied().unwrap_or(plan.seed),
        runs: seeds.len(),
        trajectories: batches.iter().map(size).sum(),
        samples: batches.iter().map(|b| size(b) * b.samples).sum(),
        path_steps: plan.pilot_steps() * seeds.len() as u64 + batches.iter().map(own).sum::<u64>(),
        time_step: plan.time_step,
        rate: plan.rate,
        burn_in: plan.timetable.steps(BURN_IN_STRETCHES) as f64 * plan.time_step,
        sampling_interval: plan.timetable.interval_steps as f64 * plan.time_step,
        seconds,
        stopped,
    }
}

/// 1 − (power taken by the drift and by impacts)/(power put in).
fn missing_power([count, injected, drift, impacts, time]: [f64; 5]) -> f64 {
    1.0 - (drift / count + impacts / time) * count / injected
}

/// The central moments 2, 3, 4 from the raw moments 1 to 4.
pub(crate) fn central([m, m2, m3, m4]: [f64; 4]) -> [f64; 3] {
    let variance = m2 - m * m;
    let third = m3 - 3.0 * m * m2 + 2.0 * m.powi(3);
    let fourth = m4 - 4.0 * m * m3 + 6.0 * m * m * m2 - 3.0 * m.powi(4);
    [variance, third, fourth]
}
