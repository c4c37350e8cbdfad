use super::{
    SimulatedDensity,
    checkpoint::State,
    ensemble::deal,
    tally::{Origin, Tally},
};
use crate::{Error, Result, file};
use std::{io, path::Path};

impl<const N: usize> SimulatedDensity<N> {
    /// The result in a checkpoint of [`Simulation::checkpoint`](crate::Simulation::checkpoint) whose run is over. The
    /// system itself is not needed.
    ///
    /// # Errors
    /// [`Error::File`], [`Error::NotACheckpoint`], [`Error::OtherSimulation`] for a system of another dimension, and
    /// [`Error::Unfinished`] if the run has not ended.
    pub fn from_checkpoint(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let content = file::read(path)?;
        let content = content.ok_or_else(|| file::file_error("read", path, &io::ErrorKind::NotFound.into()))?;
        let state = State::<N>::from_file(path, &content)?;
        let name = || path.display().to_string();
        let stopped = state.stopped.ok_or_else(|| Error::Unfinished { path: name() })?;
        let problem = "its batches cannot be read";
        let batches = state.batches().ok_or_else(|| Error::NotACheckpoint { path: name(), problem })?;
        let tallies = batches.into_iter().map(|batch| batch.tally).collect();
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
    /// use expoly::{Density, SimulatedDensity, Simulation, models::Duffing};
    /// let oscillator = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
    /// let simulation = || Simulation::new(&oscillator).samples(20_000);
    /// let halves = [simulation().part(1, 2).run()?, simulation().part(0, 2).run()?];
    /// assert_eq!(SimulatedDensity::merge(halves)?.moment([2, 0]), simulation().run()?.moment([2, 0]));
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn merge(parts: impl IntoIterator<Item = Self>) -> Result<Self> {
        let mut parts: Vec<Self> = parts.into_iter().collect();
        // The coarse twins are merged as well, where every part has one.
        let twins = parts.iter_mut().map(|part| part.coarse.take().map(|twin| *twin)).collect::<Option<Vec<_>>>();
        let coarse = match twins {
            Some(twins) if !twins.is_empty() => Some(Box::new(SimulatedDensity::merge(twins)?)),
            _ => None,
        };
        let mut parts = parts.into_iter();
        let first = parts.next().ok_or(Error::NoSamples { what: "the number of parts", least: 1 })?;
        let (plan, mut seconds, stopped) = (first.plan.clone(), first.provenance().seconds, first.provenance().stopped);
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
        let mut merged = SimulatedDensity::new(tallies, plan, seconds, stopped);
        merged.coarse = coarse;
        Ok(merged)
    }
}

/// Refuses batches of one run that are not all there, or there twice, or of different lengths.
fn whole<const N: usize>(run: &[Tally<N>], trajectories: usize) -> Result<()> {
    let ranges = deal(trajectories);
    for [a, b] in run.windows(2).filter_map(|pair| <&[Tally<N>; 2]>::try_from(pair).ok()) {
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
