use super::{
    batch::deal,
    bins::Counts,
    calibration::{Calibration, Calibrations},
    histogram::Histogram,
    jackknife::jackknife,
    layout::TallyLayout,
    passage::POWERS,
    plan::{Plan, same_level},
    stationarity::{drifts, warning},
    tally::Tally,
};
use crate::checks::state_index;
use crate::density::{CountedImpacts, Sampled, central};
use crate::error::{Error, Result};
use crate::estimate::Estimate;
use crate::provenance::{Provenance, Stopped};

/// The relative error of the correction that calibration makes: the ridge of the regression, and the rounding of its sums.
const ROUNDING: f64 = 1e-8;

/// The stationary density by a simulation: every value with its standard error.
///
/// Errors come from the spread between independent batches of trajectories, those of [`statistics`](crate::statistics) as
/// well. Moments and rates are calibrated ([`Simulation::control_variates`](crate::Simulation::control_variates)), so that
/// these errors are smaller than those of plain means, of moments many times. They cover chance.
#[derive(Clone, Debug)]
pub struct SimulatedDensity {
    pub(super) batches: Vec<Tally>,
    pub(super) plan: Plan,
    pub(super) layout: TallyLayout,
    /// Of each state alone, and of states 0 and 1 together.
    pub(super) histograms: Vec<Histogram>,
    calibrations: Calibrations,
    pub(super) provenance: Provenance,
}

impl SimulatedDensity {
    pub(super) fn new(mut batches: Vec<Tally>, plan: Plan, seconds: f64, stopped: Stopped) -> Self {
        let layout = plan.layout();
        let mut provenance = provenance(&batches, &plan, seconds, stopped);
        let calibrations = Calibrations::new(&batches, &layout);
        provenance.calibration_degree = calibrations.best.as_ref().map(|c| c.degree);
        provenance.weight_deviation = calibrations.best.as_ref().map(|c| c.weight_deviation);
        provenance.warning = warning(&batches, &layout, &plan, calibrations.missed.as_ref());
        let histogram =
            |(k, axes)| Histogram::new(axes, batches.iter_mut().map(|b| std::mem::take(&mut b.counts[k])).collect());
        let histograms = layout.histograms().enumerate().map(histogram).collect();
        SimulatedDensity { batches, plan, layout, histograms, calibrations, provenance }
    }

    /// The batches' tallies as they were before their counts went into the histograms.
    pub(super) fn into_tallies(self) -> Vec<Tally> {
        let SimulatedDensity { mut batches, histograms, .. } = self;
        for (k, histogram) in histograms.into_iter().enumerate() {
            batches.iter_mut().zip(histogram.into_batches()).for_each(|(b, counts)| b.counts[k] = counts);
        }
        batches
    }

    /// A function of sums over all batches, with its standard error.
    pub(super) fn estimate<const K: usize>(
        &self,
        sums: impl Fn(&Tally) -> [f64; K],
        value: impl Fn([f64; K]) -> f64,
    ) -> Estimate {
        jackknife(&self.batches, &sums, &value)
    }

    /// A function of the tracked sums with these places, of which the first is the number of samples, with its standard
    /// error. Sums of several places are added, those of none are not a number.
    ///
    /// Where the samples do not satisfy the moment equations of a degree, what these would change is a part of the error.
    pub(super) fn of_tracked<const K: usize>(
        &self,
        places: [&[usize]; K],
        value: impl Fn([f64; K]) -> f64,
    ) -> Estimate {
        let sum = |tracked: &[f64], places: &[usize]| match places {
            [] => f64::NAN,
            places => places.iter().map(|&k| tracked[k]).sum(),
        };
        let sums = |tracked: &[f64]| places.map(|places| sum(tracked, places));
        let plain = jackknife(&self.batches, |b| sums(&b.tracked(&self.layout)), &value);
        let by = |calibration: &Calibration| jackknife(&calibration.sums, |tracked| sums(tracked), &value);
        let Calibrations { best, missed } = &self.calibrations;
        let calibrated = best.as_ref().map_or(plain, by);
        let rounding = ROUNDING * (calibrated.value - plain.value);
        let missed = missed.as_ref().map_or(0.0, |missed| by(missed).value - calibrated.value);
        Estimate::new(calibrated.value, calibrated.error.hypot(rounding).hypot(missed))
    }

    /// The histogram of one state.
    ///
    /// # Errors
    /// [`Error::Dimension`] if there is no such state; the same holds for every statistic of one
    /// state.
    pub fn histogram(&self, state: usize) -> Result<&Histogram> {
        Ok(&self.histograms[state_index("a state's index", state, self.layout.axes.len())?])
    }

    /// The joint histogram of states 0 and 1; none for a single state.
    pub(super) fn plane(&self) -> Option<&Histogram> {
        self.histograms.get(self.layout.axes.len())
    }

    /// The mean m of one state.
    ///
    /// # Errors
    /// As [`SimulatedDensity::histogram`].
    pub fn mean(&self, state: usize) -> Result<Estimate> {
        self.of_moments(state, &|raw| raw[1])
    }

    /// The skewness about the mean, E(x − m)³ / (Var x)^(3/2).
    ///
    /// # Errors
    /// As [`SimulatedDensity::histogram`].
    pub fn skewness(&self, state: usize) -> Result<Estimate> {
        self.of_moments(state, &|raw| {
            let [variance, third, _] = central(raw);
            third / variance.powf(1.5)
        })
    }

    /// The kurtosis about the mean, E(x − m)⁴ / (Var x)²: 3 for a normal distribution.
    ///
    /// # Errors
    /// As [`SimulatedDensity::histogram`].
    pub fn kurtosis(&self, state: usize) -> Result<Estimate> {
        self.of_moments(state, &|raw| {
            let [variance, _, fourth] = central(raw);
            fourth / variance.powi(2)
        })
    }

    /// The mean speed of approach at an impact; none without a wall.
    pub fn mean_impact_speed(&self) -> Option<Estimate> {
        CountedImpacts::mean_impact_speed(self, &self.walls(), 1)
    }

    /// The distribution of the speed of approach at an impact, at all walls together; none without a wall. Its range is that
    /// of the velocities' histograms, and its bins are as many.
    pub fn impact_speeds(&self) -> Option<Histogram> {
        self.speeds_at(&(0..self.plan.walls.len()).collect::<Vec<_>>())
    }

    /// The same at some of the walls.
    pub(super) fn speeds_at(&self, walls: &[usize]) -> Option<Histogram> {
        let axis = self.plan.impact_speeds()?;
        let counts = |b: &Tally| {
            let mut counts = Counts::new(&[axis]);
            walls.iter().filter_map(|&wall| b.passages.speeds.get(wall)).for_each(|own| counts.join(own));
            counts
        };
        Some(Histogram::new(&[axis], self.batches.iter().map(counts).collect()))
    }

    /// The share of the time that is spent at rest on a wall.
    ///
    /// Where no white noise acts on the relative velocity, a chatter of ever shorter flights ends after a finite time with
    /// r < 1, and the motion rests on the wall until its acceleration points away from it. Zero for any other wall.
    ///
    /// # Errors
    /// [`Error::Dimension`] if there is no such wall.
    ///
    /// ```
    /// use expoly::{Simulation, Wall, models::{Duffing, FilteredDuffing}};
    /// // Pressed onto the wall by its spring, behind a filter.
    /// let filtered = FilteredDuffing::first_order(Duffing::new(0.2, 1.0, 0.3, 0.3)?, 2.0)?.problem()?;
    /// let result = Simulation::new().samples(100_000).run(&filtered.with_wall(Wall::above(0.5, 0.6)?)?)?;
    /// assert!((result.time_at_rest(0)?.value - 0.229).abs() < 0.01);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn time_at_rest(&self, wall: usize) -> Result<Estimate> {
        let wall = self.wall_index(wall)?;
        Ok(self.estimate(|b| [b.passages.rests[wall][0], b.time], |[rest, time]| rest / time))
    }

    /// The number of complete chatters per unit time: how often the motion comes to rest on a wall.
    ///
    /// # Errors
    /// As [`SimulatedDensity::time_at_rest`].
    pub fn complete_chatters(&self, wall: usize) -> Result<Estimate> {
        let wall = self.wall_index(wall)?;
        Ok(self.estimate(|b| [b.passages.rests[wall][1], b.time], |[count, time]| count / time))
    }

    fn wall_index(&self, wall: usize) -> Result<usize> {
        state_index("the number of a wall", wall, self.plan.walls.len())
    }

    /// The numbers of all walls.
    pub(super) fn walls(&self) -> Vec<usize> {
        (0..self.plan.walls.len()).collect()
    }

    /// The power missing in the balance of each displacement's velocity v, in the problem's order, relative to the power P that
    /// noise puts into all of them:
    ///
    /// { E(½B_vv + v f_v) − Σ ½(v₋² − v₊²)/T } / P, P = Σ E ½B_vv,
    ///
    /// with the Itô drift f and the change of v² at the impacts in the time T. Zero for the true stationary density; not a number at a
    /// time of a transient, whose power is not counted.
    pub fn energy_balance(&self) -> Vec<Estimate> {
        let velocities = self.plan.displacements.iter().enumerate();
        let balance = |(place, &(_, v)): (usize, &(usize, usize))| {
            let sums = |b: &Tally| {
                let all: f64 = b.power.iter().map(|[injected, _]| injected).sum();
                [b.moments[0], all, b.power[place][0] - b.power[place][1], b.passages.taken[v], b.time]
            };
            let missing = |[count, all, left, taken, time]: [f64; 5]| (left / count - taken / time) * count / all;
            self.estimate(sums, |sums| if sums[1] > 0.0 { missing(sums) } else { f64::NAN })
        };
        velocities.map(balance).collect()
    }

    /// The drift of E x_i² from the first half of the samples to the second, in units of its standard error, for each
    /// state: beyond ±4 the burn-in was too short, or there is no stationary density, and [`Provenance::warning`] is set.
    /// Where trajectories have fewer than sixteen samples, the drift to these from the states at three quarters of the
    /// burn-in. Not a number where the result is of a single batch.
    ///
    /// ```
    /// use expoly::{Density, Problem, Simulation, models::Linear};
    /// let growing = Problem::of(Linear::new(-0.02, 1.0, 0.2)?)?; // damping below zero
    /// let result = Simulation::new().samples(100_000).run(&growing)?;
    /// assert!(result.stationarity().iter().all(|drift| *drift > 4.0));
    /// assert!(result.provenance().warning.is_some());
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn stationarity(&self) -> Vec<f64> {
        drifts(&self.batches, self.layout.axes.len())
    }

    /// The place of a monomial among the tracked ones.
    pub(super) fn tracked(&self, powers: &[u32]) -> Option<usize> {
        self.layout.monomials.iter().position(|m| m == powers)
    }

    /// The place of a level among those whose up-crossings were counted.
    pub(super) fn level(&self, level: f64) -> Result<usize> {
        self.plan.levels.iter().position(|&counted| same_level(counted, level)).ok_or_else(|| Error::NotKnown {
            what: format!("the crossings of the level {level}"),
            remedy: "name it in `Simulation::levels` before the run",
        })
    }

    /// The place of the sum of |v|^(power − 1) over the passages of a level or, with a number after theirs, of a wall.
    pub(super) fn passages(&self, gate: usize, power: usize) -> usize {
        self.layout.monomials.len() + POWERS * gate + power - 1
    }

    /// A flux moment Σ|v|^(power − 1) per unit time of some gates together. A rate without any passage has the error of one
    /// passage at unit speed.
    pub(super) fn rate(&self, gates: &[usize], power: usize) -> Estimate {
        let interval = self.plan.interval();
        let places: Vec<usize> = gates.iter().map(|&gate| self.passages(gate, power)).collect();
        let rate = self.of_tracked([&[0], &places], |[count, sum]| sum / (count * interval));
        let count: f64 = self.batches.iter().map(|b| b.moments[0]).sum();
        if rate.value == 0.0 { Estimate::new(0.0, (count * interval).recip()) } else { rate }
    }

    /// The places of some walls among the gates.
    pub(super) fn gates(&self, walls: &[usize]) -> Vec<usize> {
        walls.iter().map(|wall| self.plan.levels.len() + wall).collect()
    }
}

fn provenance(batches: &[Tally], plan: &Plan, seconds: f64, stopped: Stopped) -> Provenance {
    let ranges = deal(plan.trajectories);
    let size = |b: &Tally| ranges.get(b.batch).map_or(0, |range| (range.end - range.start) as usize);
    let own = |b: &Tally| plan.path_steps(size(b), b.samples) - plan.pilot_steps();
    Provenance {
        method: String::from("simulation"),
        seed: Some(plan.seed),
        trajectories: Some(batches.iter().map(size).sum()),
        samples: Some(batches.iter().map(|b| size(b) * b.samples).sum()),
        path_steps: Some(plan.pilot_steps() + batches.iter().map(own).sum::<u64>()),
        time_step: Some(plan.time_step),
        rate: plan.rate,
        burn_in: Some(plan.burn_in()),
        sampling_interval: Some(plan.interval()),
        stopped: Some(stopped),
        seconds,
        ..Provenance::default()
    }
}
