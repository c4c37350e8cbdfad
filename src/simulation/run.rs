use super::{
    Simulation,
    ensemble::{Batch, Control, Ensemble, Stretches, deal},
    histogram::Axis,
    passage::Course,
    result::{Provenance, SimulatedDensity},
    scheme::Scheme,
    setup::Meter,
    tally::{Layout, Reach},
};
use crate::error::{finite, positive, state_index};
use crate::{Error, FokkerPlanck, Monomial, PolynomialDrift, Result};
use std::time::Instant;

/// A simulation holds all trajectories and all bins of every batch at once: at most about a third of a gigabyte each.
const MOST_TRAJECTORIES: usize = 1 << 20;
const MOST_BINS: usize = 1024;

/// The most levels whose crossings one simulation counts: each costs time in every step.
const MOST_LEVELS: usize = 64;

/// The stretches that a burn-in is divided into; the pilot looks at the states between them.
const BURN_IN_STRETCHES: usize = 64;

/// The noise of so many steps spreads the default start: enough to tell trajectories apart, too little to leave the rest.
const SPREAD_STEPS: f64 = 4.0;

impl<'a, T: PolynomialDrift<N, M> + Sync, const N: usize, const M: usize> Simulation<'a, T, N, M> {
    /// Runs the simulation.
    ///
    /// # Errors
    /// - [`Error::NotFinite`], [`Error::NoNoise`]: the system is not one, as [`FokkerPlanck::new`] says.
    /// - [`Error::NotADisplacement`]: a wall or a level for a state 0 that has no velocity.
    /// - [`Error::NoSamples`]: no samples, or fewer than two trajectories.
    /// - [`Error::OutOfRange`], [`Error::Dimension`]: an option without a meaning.
    /// - [`Error::Exploded`]: a state was not finite, or a million times larger than any in the second half of the
    ///   burn-in.
    /// - [`Error::Cancelled`]: the progress callback said so.
    pub fn run(mut self) -> Result<SimulatedDensity<N>> {
        let begin = Instant::now();
        let Prepared { operator, scheme, velocity, burn_in, sampling } = self.prepared()?;
        let path_steps = self.path_steps(&sampling);
        let meter = self.progress.take().map(|callback| Meter { done: 0, callback });
        let course = self.course(&scheme, velocity);
        let ensemble =
            Ensemble { scheme: &scheme, course: &course, velocity, control: Control::new(meter, path_steps) };

        let mut batches = self.batches(&operator, &scheme);
        let reach = ensemble.burn_in(&mut batches, burn_in)?;
        let layout = self.layout(&reach)?;
        let tallies = ensemble.sample(&mut batches, sampling, &layout, &bounds(&reach))?;

        let provenance = Provenance {
            seed: self.seed,
            trajectories: self.trajectories,
            samples: self.trajectories * sampling.count,
            path_steps,
            time_step: self.time_step,
            burn_in: sampling.before as f64 * self.time_step,
            sampling_interval: sampling.steps as f64 * self.time_step,
            seconds: begin.elapsed().as_secs_f64(),
        };
        Ok(SimulatedDensity::new(tallies, layout, self.barrier, self.levels, velocity, provenance))
    }

    /// Runs the simulation and returns the sampled states themselves, in the order of the trajectories and, within each,
    /// of time. Histograms and levels are left out.
    ///
    /// # Errors
    /// As [`Simulation::run`].
    ///
    /// ```
    /// use expoly::{Simulation, models::Duffing};
    /// let oscillator = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
    /// let states = Simulation::new(&oscillator).trajectories(64).samples(640).states()?;
    /// assert_eq!(states.len(), 640);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn states(mut self) -> Result<Vec<[f64; N]>> {
        let Prepared { operator, scheme, velocity, burn_in, sampling } = self.prepared()?;
        let meter = self.progress.take().map(|callback| Meter { done: 0, callback });
        let course = self.course(&scheme, velocity);
        let control = Control::new(meter, self.path_steps(&sampling));
        let ensemble = Ensemble { scheme: &scheme, course: &course, velocity, control };
        let mut batches = self.batches(&operator, &scheme);
        let reach = ensemble.burn_in(&mut batches, burn_in)?;
        ensemble.collect(&mut batches, sampling, &bounds(&reach))
    }

    /// The scheme and the plan, after all options have been looked at.
    fn prepared(&self) -> Result<Prepared<'a, T, N, M>> {
        let operator = FokkerPlanck::new(self.system)?;
        let scheme = Scheme::new(
            self.system,
            &operator,
            positive("time step", self.time_step, "it must be finite and above zero")?,
        );
        let velocity = scheme.pairs.iter().find(|&&(i, _)| i == 0).map(|&(_, j)| j);
        self.validate(velocity)?;
        let (burn_in, sampling) = self.stretches()?;
        Ok(Prepared { operator, scheme, velocity, burn_in, sampling })
    }

    fn path_steps(&self, sampling: &Stretches) -> u64 {
        self.trajectories as u64 * (sampling.before + sampling.count * sampling.steps) as u64
    }

    fn batches(&self, operator: &FokkerPlanck<N>, scheme: &Scheme<'_, T, N, M>) -> Vec<Batch<N>> {
        let start = self.starts(operator, &scheme.pairs);
        let ranges = deal(self.trajectories).into_iter().enumerate();
        ranges.map(|(b, range)| Batch::new(b, range, self.seed, &start)).collect()
    }

    fn course(&self, scheme: &Scheme<'_, T, N, M>, velocity: Option<usize>) -> Course {
        let mut at_rest = [0.0; N];
        at_rest[0] = self.barrier.map_or(0.0, |b| b.offset());
        let diffusion = velocity.map_or(0.0, |v| scheme.power(v, at_rest)[0]);
        Course::new(scheme.pairs.clone(), self.barrier, self.levels.clone(), diffusion, self.time_step)
    }

    fn validate(&self, velocity: Option<usize>) -> Result<()> {
        if (self.barrier.is_some() || !self.levels.is_empty()) && velocity.is_none() {
            return Err(Error::NotADisplacement { velocity: 1 });
        }
        if self.trajectories < 2 {
            return Err(Error::NoSamples { what: "the number of trajectories", least: 2 });
        }
        if self.samples == 0 {
            return Err(Error::NoSamples { what: "the number of samples", least: 1 });
        }
        at_most("number of levels", self.levels.len(), MOST_LEVELS, "at most 64 levels can be watched at once")?;
        at_most("number of trajectories", self.trajectories, MOST_TRAJECTORIES, "at most 2^20 fit into memory")?;
        at_most("number of bins", self.bins, MOST_BINS, "at most 1024 keep the joint histogram in memory")?;
        self.levels.iter().try_for_each(|&level| finite("level", level).map(|_| ()))?;
        for x in self.start.iter().flatten() {
            finite("start", *x)?;
        }
        if let (Some(start), Some(wall)) = (&self.start, &self.barrier)
            && start[0] < wall.offset()
        {
            let remedy = "a trajectory must start above the wall";
            return Err(Error::OutOfRange { name: "start of state 0", value: start[0], remedy });
        }
        Ok(())
    }

    /// Burn-in and sampling in whole steps.
    fn stretches(&self) -> Result<(Stretches, Stretches)> {
        if !(self.burn_in.is_finite() && self.burn_in >= 0.0) {
            let remedy = "it must be finite and not negative";
            return Err(Error::OutOfRange { name: "burn-in", value: self.burn_in, remedy });
        }
        positive("sampling interval", self.sampling_interval, "it must be finite and above zero")?;
        let count = self.samples.div_ceil(self.trajectories);
        let burn_in = (self.burn_in / self.time_step / BURN_IN_STRETCHES as f64).ceil().max(1.0);
        let interval = (self.sampling_interval / self.time_step).round().max(1.0);
        let path = self.trajectories as f64 * (burn_in * BURN_IN_STRETCHES as f64 + interval * count as f64);
        // Beyond 2⁵³ steps are no longer counted exactly; at a billion a second that is a hundred days.
        if path > 2.0_f64.powi(53) {
            let remedy =
                "a simulation of more than 2^53 path-steps never ends: take a longer time step or fewer samples";
            return Err(Error::OutOfRange { name: "number of path-steps", value: path, remedy });
        }
        let burn_in = Stretches { count: BURN_IN_STRETCHES, steps: burn_in as usize, before: 0 };
        Ok((burn_in, Stretches { count, steps: interval as usize, before: burn_in.count * burn_in.steps }))
    }

    /// The start of a trajectory from its standard normal numbers.
    fn starts(
        &self,
        operator: &FokkerPlanck<N>,
        pairs: &[(usize, usize)],
    ) -> impl Fn([f64; N]) -> [f64; N] + use<'a, T, N, M> {
        let time = SPREAD_STEPS * self.time_step;
        let mut spread: [f64; N] = std::array::from_fn(|i| {
            let variance = operator.diffusion()[i][i].coefficient(&Monomial::one()) * time;
            if variance > 0.0 { variance.sqrt() } else { 0.1 }
        });
        for &(i, j) in pairs {
            spread[i] = spread[j] * time;
        }
        let (fixed, floor) = (self.start, self.barrier.map(|b| b.offset()));
        move |z| {
            let mut x = std::array::from_fn(|i| spread[i] * z[i]);
            if let Some(b) = floor {
                x[0] = b + (b.max(0.0) - b + x[0]).abs();
            }
            fixed.unwrap_or(x)
        }
    }

    /// The bins, from the states that the pilot has met.
    fn layout(&self, reach: &[Reach; N]) -> Result<Layout<N>> {
        let mut ends = reach.map(|r| r.interval());
        if let Some(wall) = self.barrier {
            ends[0].0 = wall.offset();
        }
        for &(state, lo, hi) in &self.ranges {
            ends[state_index::<N>("the state of a histogram's range", state)?] = (lo, hi);
        }
        let axis = |i: usize, bins: usize| Axis::new(ends[i].0, ends[i].1, bins);
        let axes: Vec<Axis> = (0..N).map(|i| axis(i, self.bins)).collect::<Result<_>>()?;
        let joint = (self.bins / 2).max(3);
        let plane = if N >= 2 { Some([axis(0, joint)?, axis(1, joint)?]) } else { None };
        Ok(Layout::new(std::array::from_fn(|i| axes[i]), plane))
    }
}

/// What a run needs besides its options.
struct Prepared<'a, T, const N: usize, const M: usize> {
    operator: FokkerPlanck<N>,
    scheme: Scheme<'a, T, N, M>,
    /// The velocity of state 0.
    velocity: Option<usize>,
    burn_in: Stretches,
    sampling: Stretches,
}

/// A state a million times larger than any in the second half of the burn-in has exploded.
fn bounds<const N: usize>(reach: &[Reach; N]) -> [f64; N] {
    reach.map(|r| 1e6 * r.largest())
}

fn at_most(name: &'static str, number: usize, most: usize, remedy: &'static str) -> Result<()> {
    if number <= most { Ok(()) } else { Err(Error::OutOfRange { name, value: number as f64, remedy }) }
}
