use super::tally::{Levels, Tally};
use crate::simulation::jackknife::jackknife;
use crate::{Error, Estimate, Result};

/// A standard error from fewer replicas that saw anything is a guess.
const LEAST_REPLICAS: usize = 8;

/// How tails were found.
#[derive(Clone, Debug, PartialEq)]
pub struct SplittingProvenance {
    /// The seed.
    pub seed: u64,
    /// The number of independent replicas.
    pub replicas: usize,
    /// The number of particles in each bin, as rounded.
    pub particles: usize,
    /// The edges of the bins: values of the importance function.
    pub thresholds: Vec<f64>,
    /// The number of time steps of all particles of the replicas together. On top come the burn-in of 128 starting states for
    /// each, and the pilot, which is as long as one replica at most.
    pub path_steps: u64,
    /// The time step h.
    pub time_step: f64,
    /// The time between two resamplings, as rounded.
    pub resampling_interval: f64,
    /// The time before measuring, as rounded.
    pub relaxation: f64,
    /// The time of measuring, as rounded.
    pub duration: f64,
    /// The wall-clock time in seconds.
    pub seconds: f64,
}

/// The tails of a stationary density: every value with its standard error.
///
/// Errors come from the spread between independent replicas. They cover chance, not the time step. What fewer than eight
/// replicas have met gets an infinite error, and so does what none has met, whose value is 0; a relative error above one
/// half says little more. Ask for smaller probabilities by [`Splitting::rarest`](crate::Splitting::rarest).
#[derive(Clone, Debug)]
pub struct Tails {
    replicas: Vec<Tally>,
    watched: Vec<Levels>,
    /// The levels whose up-crossings were counted.
    crossings: Vec<f64>,
    provenance: SplittingProvenance,
}

impl Tails {
    pub(super) fn new(
        replicas: Vec<Tally>,
        watched: Vec<Levels>,
        crossings: Vec<f64>,
        provenance: SplittingProvenance,
    ) -> Self {
        Tails { replicas, watched, crossings, provenance }
    }

    /// Seed, counts, times, thresholds.
    pub fn provenance(&self) -> &SplittingProvenance {
        &self.provenance
    }

    /// P(X ≥ y) for a state X and one of its levels y.
    ///
    /// # Errors
    /// [`Error::LevelNotCounted`] if the level was not named before the run; so for every question about a level.
    pub fn exceedance(&self, state: usize, level: f64) -> Result<Estimate> {
        let (k, _) = self.find(state, level)?;
        Ok(self.mean(|tally| tally.above(k, &self.watched, level)))
    }

    /// P(X < y), for the lower tail.
    ///
    /// # Errors
    /// As [`Tails::exceedance`].
    pub fn non_exceedance(&self, state: usize, level: f64) -> Result<Estimate> {
        let (k, _) = self.find(state, level)?;
        Ok(self.mean(|tally| tally.below(k, &self.watched, level)))
    }

    /// The density of a state X at one of its levels.
    ///
    /// It is measured in three cells about the level, whose width is a third of the mean excess E(X − y | X > y), or of the
    /// mean deficit if that is smaller; next to a wall they are narrower. A parabola through the three leaves a relative error
    /// near 10⁻⁴.
    ///
    /// # Errors
    /// As [`Tails::exceedance`].
    pub fn marginal(&self, state: usize, level: f64) -> Result<Estimate> {
        let (k, width) = self.find(state, level)?;
        if width <= 0.0 {
            // The pilot never came here, so that no scale of the tail is known.
            return Ok(Estimate::new(f64::NAN, f64::INFINITY));
        }
        Ok(self.mean(|tally| tally.density(k, &self.watched, (level, width))))
    }

    /// The number of up-crossings of a level by state 0 per unit time, by direct count.
    ///
    /// # Errors
    /// As [`Tails::exceedance`].
    pub fn upcrossing_rate(&self, level: f64) -> Result<Estimate> {
        let k = self.crossings.iter().position(|&y| y == level).ok_or(Error::LevelNotCounted { level })?;
        Ok(self.mean(|tally| tally.crossings[k] / tally.time))
    }

    /// How far the bins changed from the first half of the measuring time to the second: their probabilities, and how often
    /// they were occupied, in units of the standard error of the change; the largest of all. Beyond ±4 the relaxation or the
    /// burn-in was too short.
    pub fn stationarity(&self) -> f64 {
        let change = |bin: usize, what: usize| {
            let change = |tally: &Tally| [tally.halves[1][bin][what] - tally.halves[0][bin][what], 1.0];
            let change = jackknife(&self.replicas, change, |[sum, count]| sum / count);
            if change.error > 0.0 { change.value / change.error } else { 0.0 }
        };
        let changes = (0..=self.provenance.thresholds.len()).flat_map(|bin| [change(bin, 0), change(bin, 1)]);
        changes.fold(0.0, |worst: f64, t| if t.abs() > worst.abs() { t } else { worst })
    }

    /// The mean over the replicas, which all had the same time.
    fn mean(&self, value: impl Fn(&Tally) -> f64) -> Estimate {
        let mean = jackknife(&self.replicas, |tally| [value(tally), 1.0], |[sum, count]| sum / count);
        let met = self.replicas.iter().filter(|&tally| value(tally) != 0.0).count();
        if met < LEAST_REPLICAS { Estimate::new(mean.value, f64::INFINITY) } else { mean }
    }

    /// The place of a state's levels, and the width of the cells.
    fn find(&self, state: usize, level: f64) -> Result<(usize, f64)> {
        let at = |(k, levels): (usize, &Levels)| {
            let known = levels.levels.iter().find(|&&(y, _)| levels.state == state && y == level)?;
            Some((k, known.1))
        };
        self.watched.iter().enumerate().find_map(at).ok_or(Error::LevelNotCounted { level })
    }
}
