use super::{
    SimulatedDensity,
    batch::deal,
    checkpoint::State,
    tally::{Origin, Tally},
};
use crate::density::Density;
use crate::error::{Error, Result};
use crate::file;
use crate::provenance::Stopped;
use std::{io, path::Path};

impl SimulatedDensity {
    /// The result in a checkpoint of [`Simulation::checkpoint`](crate::Simulation::checkpoint) whose run is over. The
    /// problem itself is not needed.
    ///
    /// # Errors
    /// [`Error::File`], [`Error::NotACheckpoint`], and [`Error::Unfinished`] if the run has not ended.
    pub fn from_checkpoint(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let content = file::read(path)?;
        let content = content.ok_or_else(|| file::file_error("read", path, &io::ErrorKind::NotFound.into()))?;
        let state = State::from_file(path, &content)?;
        let stopped = state.stopped.ok_or_else(|| Error::Unfinished { path: path.display().to_string() })?;
        let tallies = state.batches.into_iter().map(|batch| batch.tally).collect();
        Ok(SimulatedDensity::new(tallies, state.plan, state.seconds, stopped))
    }

    /// The union of results of the same system with the same options.
    ///
    /// All parts ([`Simulation::part`](crate::Simulation::part)) of a simulation, in any order, give the result of the
    /// single run, bit for bit. Whole runs with different seeds are independent of one another: their union is one
    /// simulation with more trajectories. For that they need the same time step and the same histograms: set them by
    /// [`Simulation::time_step`](crate::Simulation::time_step) and
    /// [`Simulation::histogram_range`](crate::Simulation::histogram_range).
    ///
    /// # Errors
    /// [`Error::NoSamples`] for no parts, [`Error::OtherSimulation`] naming the first option in which two of them differ,
    /// [`Error::MissingPart`], [`Error::RepeatedPart`].
    ///
    /// ```
    /// use expoly::{Density, SimulatedDensity, Simulation, models::{Duffing, Solved}};
    /// let problem = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?;
    /// let simulation = || Simulation::new().samples(20_000);
    /// let halves = [simulation().part(1, 2).run(&problem)?, simulation().part(0, 2).run(&problem)?];
    /// assert_eq!(SimulatedDensity::merge(halves)?.moment(&[2, 0])?, simulation().run(&problem)?.moment(&[2, 0])?);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn merge(parts: impl IntoIterator<Item = Self>) -> Result<Self> {
        let mut parts = parts.into_iter();
        let first = parts.next().ok_or(Error::NoSamples { what: "the number of parts", least: 1 })?;
        let (plan, mut seconds) = (first.plan.clone(), first.provenance().seconds);
        let stopped = first.provenance().stopped.unwrap_or(Stopped::Samples);
        let mut tallies = first.into_tallies();
        for part in parts {
            plan.same_as(&part.plan, true)?;
            seconds += part.provenance().seconds;
            tallies.extend(part.into_tallies());
        }
        tallies.sort_by_key(|t| t.origin);
        for run in tallies.chunk_by(|a, b| a.origin.seed == b.origin.seed) {
            whole(run, plan.trajectories)?;
        }
        Ok(SimulatedDensity::new(tallies, plan, seconds, stopped))
    }
}

/// Refuses batches of one run that are not all there, or there twice, or of different lengths.
fn whole(run: &[Tally], trajectories: usize) -> Result<()> {
    let ranges = deal(trajectories);
    for [a, b] in run.windows(2).filter_map(|pair| <&[Tally; 2]>::try_from(pair).ok()) {
        if a.origin == b.origin {
            let Origin { seed, batch } = a.origin;
            let trajectories = ranges.get(batch).cloned().unwrap_or_default();
            return Err(Error::RepeatedPart { seed, trajectories });
        }
        if a.samples != b.samples {
            let [found, expected] = [b, a].map(|t| t.samples.to_string());
            return Err(Error::OtherSimulation { what: "number of samples per trajectory", found, expected });
        }
    }
    let missing = (0..ranges.len()).find(|&k| run.get(k).is_none_or(|t| t.origin.batch != k));
    match (missing, run) {
        (Some(k), [any, ..]) => Err(Error::MissingPart { seed: any.origin.seed, trajectories: ranges[k].clone() }),
        _ => Ok(()),
    }
}
