use super::{SimulatedDensity, batch::deal, checkpoint::State, tally::Tally};
use crate::density::Density;
use crate::error::{Error, Result};
use crate::file;
use crate::numerics::sort_by_number;
use crate::provenance::Stopped;
use std::{io, path::Path};

const UNFINISHED: &str =
    "it has no result yet: run the simulation again with the same options, and it goes on from there";

impl SimulatedDensity {
    /// The result in a checkpoint of [`Simulation::checkpoint`](crate::Simulation::checkpoint) whose run is over. The
    /// problem itself is not needed.
    ///
    /// # Errors
    /// [`Error::File`], and [`Error::NotThisRun`] also if the run has not ended.
    pub fn from_checkpoint(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let content = file::read(path)?;
        let content = content.ok_or_else(|| file::file_error("read", path, io::ErrorKind::NotFound.into()))?;
        let state = State::from_file(path, &content)?;
        let stopped = state.stopped.ok_or_else(|| file::not_this_run(path, UNFINISHED))?;
        let tallies = state.batches.into_iter().map(|batch| batch.tally).collect();
        Ok(SimulatedDensity::new(tallies, state.plan, state.seconds, stopped))
    }

    /// The result of the single run, bit for bit, from all of its parts ([`Simulation::part`](crate::Simulation::part)) in any
    /// order.
    ///
    /// # Errors
    /// [`Error::NotTheParts`] for none, for those of different simulations, and where one is missing
    /// or there twice.
    ///
    /// ```
    /// use expoly::{Density, SimulatedDensity, Simulation, models::{Duffing, Solved}};
    /// let problem = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?;
    /// let simulation = || Simulation::new().samples(20_000);
    /// let halves = [simulation().part(2, 2).run(&problem)?, simulation().part(1, 2).run(&problem)?];
    /// assert_eq!(SimulatedDensity::merge(halves)?.moment(&[2, 0])?, simulation().run(&problem)?.moment(&[2, 0])?);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn merge(parts: impl IntoIterator<Item = Self>) -> Result<Self> {
        let mut parts = parts.into_iter();
        let first = parts.next().ok_or(Error::NotTheParts { problem: "there are none".into() })?;
        let (plan, mut seconds) = (first.plan.clone(), first.provenance().seconds);
        let stopped = first.provenance().stopped.unwrap_or(Stopped::Samples);
        let mut tallies = first.into_tallies();
        for part in parts {
            if let Some(what) = plan.difference(&part.plan) {
                return Err(Error::NotTheParts { problem: format!("of one {what} in the first; make it the same") });
            }
            seconds += part.provenance().seconds;
            tallies.extend(part.into_tallies());
        }
        sort_by_number(&mut tallies, |tally| tally.batch as f64);
        whole(&tallies, plan.trajectories)?;
        Ok(SimulatedDensity::new(tallies, plan, seconds, stopped))
    }
}

/// Refuses batches that are not all there, or there twice, or of different lengths.
fn whole(tallies: &[Tally], trajectories: usize) -> Result<()> {
    let first = tallies.first().map_or(0, |tally| tally.samples);
    if let Some(other) = tallies.iter().map(|tally| tally.samples).find(|samples| *samples != first) {
        let problem =
            format!("their trajectories have {first} and {other} samples; make the number of samples the same");
        return Err(Error::NotTheParts { problem });
    }
    for (batch, range) in deal(trajectories).into_iter().enumerate() {
        let there = match tallies.iter().filter(|tally| tally.batch == batch).count() {
            0 => "missing",
            1 => continue,
            _ => "there twice",
        };
        let problem = format!("trajectories {range:?} are {there}; merge all parts together, each once");
        return Err(Error::NotTheParts { problem });
    }
    Ok(())
}
