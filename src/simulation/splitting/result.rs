use super::tally::{Levels, ReplicaTally};
use crate::error::{Error, Result};
use crate::estimate::Estimate;
use crate::provenance::Provenance;
use crate::simulation::{jackknife::jackknife, plan::same_level};

/// The fewest replicas with a count for what is measured that give it a standard error: with fewer it is unreliable.
const LEAST_MET: usize = 8;

/// The tails of a stationary density: every value with its standard error.
///
/// Errors come from the spread between independent replicas. They cover chance, not the time step. A value that fewer than
/// eight replicas have met has an infinite error, and so does one that none has met, which is 0; a relative error above one
/// half is hardly more informative. Smaller probabilities are reached by [`Splitting::rarest`](crate::Splitting::rarest).
#[derive(Clone, Debug)]
pub struct Tails {
    replicas: Vec<ReplicaTally>,
    watched: Vec<Levels>,
    /// The levels whose up-crossings were counted.
    crossings: Vec<f64>,
    provenance: Provenance,
}

impl Tails {
    pub(super) fn new(
        replicas: Vec<ReplicaTally>,
        watched: Vec<Levels>,
        crossings: Vec<f64>,
        provenance: Provenance,
    ) -> Self {
        Tails { replicas, watched, crossings, provenance }
    }

    /// Seed, counts, times, thresholds. On top of the path-steps come the burn-in of 128 starting states for each replica,
    /// and the pilot, which is as long as one replica at most.
    pub fn provenance(&self) -> &Provenance {
        &self.provenance
    }

    /// P(X ≥ y) for a state X and one of its levels y.
    ///
    /// # Errors
    /// [`Error::NotKnown`] if the level was not named before the run; the same holds for every value at a level.
    pub fn exceedance(&self, state: usize, level: f64) -> Result<Estimate> {
        let (k, (level, _)) = self.find(state, level)?;
        Ok(self.mean(|tally| tally.above(k, &self.watched, level)))
    }

    /// P(X < y), for the lower tail.
    ///
    /// # Errors
    /// As [`Tails::exceedance`].
    pub fn non_exceedance(&self, state: usize, level: f64) -> Result<Estimate> {
        let (k, (level, _)) = self.find(state, level)?;
        Ok(self.mean(|tally| tally.below(k, &self.watched, level)))
    }

    /// The density of a state X at one of its levels.
    ///
    /// It is measured in three cells about the level, whose width is a third of the mean excess E(X − y | X > y), or of the
    /// mean deficit if that is smaller; next to a wall they are narrower. A parabola through the three leaves a relative error
    /// near 10⁻⁴.
    ///
    /// # Errors
    /// As [`Tails::exceedance`]; also where the pilot never came near the level, so that no scale of the tail is known.
    pub fn marginal(&self, state: usize, level: f64) -> Result<Estimate> {
        let (k, (level, width)) = self.find(state, level)?;
        if width <= 0.0 {
            let what = format!("the density at {level}, since the pilot never came there");
            let remedy = "take more particles, a longer relaxation, or a level that is met";
            return Err(Error::NotKnown { what, remedy });
        }
        Ok(self.mean(|tally| tally.density(k, &self.watched, (level, width))))
    }

    /// The number of up-crossings of a level by state 0 per unit time, by direct count.
    ///
    /// # Errors
    /// As [`Tails::exceedance`].
    pub fn upcrossing_rate(&self, level: f64) -> Result<Estimate> {
        let k = self.crossings.iter().position(|&y| same_level(y, level)).ok_or_else(|| unnamed(level))?;
        Ok(self.mean(|tally| tally.crossings[k] / tally.time))
    }

    /// The change of the bins from the first half of the measuring time to the second, in their probabilities and in the time
    /// for which they were occupied, in units of the standard error of the change; the largest of all. Beyond ±4 the
    /// relaxation or the burn-in was too short.
    pub fn stationarity(&self) -> f64 {
        let change = |bin: usize, what: usize| {
            let change = |tally: &ReplicaTally| [tally.halves[1][bin][what] - tally.halves[0][bin][what], 1.0];
            let change = jackknife(&self.replicas, change, |[sum, count]| sum / count);
            if change.error > 0.0 { change.value / change.error } else { 0.0 }
        };
        let bins = self.replicas.first().map_or(0, |tally| tally.halves[0].len());
        let changes = (0..bins).flat_map(|bin| [change(bin, 0), change(bin, 1)]);
        changes.fold(0.0, |worst: f64, t| if t.abs() > worst.abs() { t } else { worst })
    }

    /// The mean over the replicas, which all had the same time.
    fn mean(&self, value: impl Fn(&ReplicaTally) -> f64) -> Estimate {
        let mean = jackknife(&self.replicas, |tally| [value(tally), 1.0], |[sum, count]| sum / count);
        let met = self.replicas.iter().filter(|&tally| value(tally) != 0.0).count();
        if met < LEAST_MET { Estimate::new(mean.value, f64::INFINITY) } else { mean }
    }

    /// The place of a state's levels, the level as it was named, and the width of its cells.
    fn find(&self, state: usize, level: f64) -> Result<(usize, (f64, f64))> {
        let at = |(k, levels): (usize, &Levels)| {
            let known = levels.levels.iter().find(|&&(y, _)| levels.state == state && same_level(y, level))?;
            Some((k, *known))
        };
        self.watched.iter().enumerate().find_map(at).ok_or_else(|| unnamed(level))
    }
}

fn unnamed(level: f64) -> Error {
    Error::NotKnown { what: format!("the level {level}"), remedy: "name it before the run, by `Splitting::levels`" }
}
