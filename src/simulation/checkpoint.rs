use super::{
    batch::{Batch, deal},
    plan::Plan,
    tally::{Origin, Tally},
    timetable::samples,
};
use crate::error::{Error, Result};
use crate::file;
use crate::provenance::Stopped;
use crate::record::checksum;
use serde::{Deserialize, Serialize};
use std::{path::Path, path::PathBuf, time::Duration};

/// The first bytes of a file: the version of the library, since another version may compute other bits, and that of the
/// format.
const MAGIC: &[u8] = concat!("expoly ", env!("CARGO_PKG_VERSION"), " simulation 3\n").as_bytes();

/// The file that holds the state of a run, and the time between two writes.
#[derive(Clone, Debug)]
pub(super) struct Checkpoint {
    pub(super) path: PathBuf,
    pub(super) every: Duration,
}

/// The state of a run.
#[derive(Debug, Deserialize, Serialize)]
pub(super) struct State {
    pub(super) plan: Plan,
    /// The time that the run has taken so far, in seconds.
    pub(super) seconds: f64,
    /// None for a run that is not over.
    pub(super) stopped: Option<Stopped>,
    /// In order.
    pub(super) batches: Vec<Batch>,
}

impl State {
    /// Reads the content of a file, of which `path` is the name for errors.
    pub(super) fn from_file(path: &Path, content: &[u8]) -> Result<Self> {
        let spoiled = |problem| Error::NotACheckpoint { path: path.display().to_string(), problem };
        let strange = spoiled("it does not begin like a state of this version of the library");
        let content = content.strip_prefix(MAGIC).ok_or(strange)?;
        let (sum, body) = content.split_first_chunk().ok_or(spoiled("it is cut off"))?;
        if checksum(body) != u64::from_le_bytes(*sum) {
            return Err(spoiled("its content does not agree with its checksum, so it was cut off or altered"));
        }
        match postcard::take_from_bytes::<State>(body) {
            Ok((state, [])) if state.holds() => Ok(state),
            _ => Err(spoiled("its content cannot be read")),
        }
    }

    /// Writes the file, whole or not at all.
    pub(super) fn to_file(&self, path: &Path) -> Result<()> {
        let unwritten = |error: postcard::Error| {
            let (path, reason) = (path.display().to_string(), error.to_string());
            Error::File { action: "write", path, reason }
        };
        let body = postcard::to_stdvec(self).map_err(unwritten)?;
        file::write(path, &[MAGIC, &checksum(&body).to_le_bytes(), &body].concat())
    }

    /// Whether a state that was read is one that can go on: its batches have the sizes of the plan.
    fn holds(&self) -> bool {
        if !self.plan.holds() {
            return false;
        }
        let layout = self.plan.layout();
        let ranges = deal(self.plan.trajectories);
        let timetable = &self.plan.timetable;
        self.batches.iter().all(|batch| {
            let origin = Origin { seed: self.plan.seed, batch: batch.index };
            let taken = samples(batch.done);
            (batch.tally.origin, batch.tally.samples) == (origin, taken)
                && timetable.holds(self.plan.trajectories, taken)
                && ranges.get(batch.index).is_some_and(|range| {
                    let trajectories = (range.end - range.start) as usize;
                    let empty = Tally::new(origin, trajectories, &layout, self.plan.passages());
                    batch.tally.is_like(&empty) && batch.fits(range, &layout)
                })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::density::{Density, Sampled};
    use crate::models::Duffing;
    use crate::problem::{Problem, Wall};
    use crate::simulation::{SimulatedDensity, Simulation};

    /// A state with any bytes and a right checksum is refused, or its numbers can be computed without a panic.
    #[test]
    fn altered_states_with_a_right_checksum_do_no_harm() -> Result<()> {
        let problem = Problem::of(Duffing::new(0.2, 1.0, 0.3, 0.2)?)?;
        harmless(&problem.clone().with_wall(Wall::above(-0.5, 0.9)?)?, false)?;
        harmless(&problem, true)
    }

    fn harmless(problem: &Problem, calibrated: bool) -> Result<()> {
        let path = std::env::temp_dir().join(format!("expoly-altered-{calibrated}-{}", std::process::id()));
        let simulation = Simulation::new().trajectories(2).samples(24).burn_in(1.0).bins(3).levels([0.5]);
        let simulation = simulation.control_variates(calibrated);
        let simulation = simulation.spectrum(0, 8).first_passage(1.0, 3.0, 2);
        simulation.checkpoint(&path, Duration::from_secs(60)).run(problem)?;
        let content = file::read(&path)?.unwrap_or_default();
        let _ = std::fs::remove_file(&path);
        let begin = MAGIC.len() + size_of::<u64>();
        let mut refused = 0;
        for place in begin..content.len() {
            for value in [0x00, 0x03, 0x7f, 0x80, 0xff] {
                let mut altered = content.clone();
                altered[place] = value;
                let sum = checksum(&altered[begin..]).to_le_bytes();
                altered[MAGIC.len()..begin].copy_from_slice(&sum);
                let Ok(state) = State::from_file(&path, &altered) else {
                    refused += 1;
                    continue;
                };
                let tallies = state.batches.into_iter().map(|batch| batch.tally).collect();
                let found = SimulatedDensity::new(tallies, state.plan, state.seconds, Stopped::Samples);
                found.pdf(&[0.3, 0.1])?;
                let _ = (found.moment(&[2, 0]), found.spectrum(0), found.first_passage(1.0));
                let _ = (found.stationarity(), found.distribution(0), found.impact_speeds(), found.provenance());
            }
        }
        assert!(refused > 100, "{refused}");
        Ok(())
    }
}
