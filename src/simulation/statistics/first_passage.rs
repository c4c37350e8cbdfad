//! The time that a stationary state takes to reach a level.

use super::{Sample, Statistic};
use crate::checks::{finite, positive, require};
use crate::error::{Error, Result};
use crate::estimate::Estimate;
use crate::simulation::{
    SimulatedDensity, Simulation,
    jackknife::jackknife,
    plan::{Plan, same_level},
    run::at_most,
};
use serde::{Deserialize, Serialize};

/// The most levels whose first passages one simulation measures.
const MOST_PASSAGES: usize = 16;

impl Simulation<'_> {
    /// Measures the time to the first passage of state 0 through `level` from below, in windows of the length `window`, each
    /// begun at a stationary state, and keeps its distribution at `bins` equal times in them.
    /// [`SimulatedDensity::first_passage`](crate::SimulatedDensity::first_passage) gives it.
    ///
    /// The path of a displacement is followed at all times, and its passages are located to a sampling interval; of any other
    /// state 0 only the samples are used. The window is rounded to whole sampling intervals for each of the `bins`.
    pub fn first_passage(mut self, level: f64, window: f64, bins: usize) -> Self {
        self.requests.passages.push(PassageRequest { level, length: window, bins });
        self
    }
}

impl SimulatedDensity {
    /// The time that a stationary path takes to pass a level from below.
    ///
    /// # Errors
    /// [`Error::NotKnown`] if it was not requested by [`Simulation::first_passage`](crate::Simulation::first_passage),
    /// [`Error::OutOfRange`] if the run was shorter than a window.
    pub fn first_passage(&self, level: f64) -> Result<FirstPassage> {
        let passages = &self.layout.recorders.passages;
        let place = passages.iter().position(|waiting| same_level(waiting.level, level));
        let place = place.ok_or_else(|| Error::NotKnown {
            what: format!("the first passage of the level {level}"),
            remedy: "request it by `Simulation::first_passage` before the run",
        })?;
        let tallies = self.batches.iter().map(|b| b.recordings.passages[place].clone()).collect();
        FirstPassage::new(passages[place].window, tallies)
    }
}

/// A level of state 0, the length of the windows in which its first passage is measured, and the number of times in one.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub(in crate::simulation) struct PassageRequest {
    level: f64,
    length: f64,
    bins: usize,
}

/// A level whose first passage is measured.
#[derive(Clone, Debug)]
pub(in crate::simulation) struct PassageRecorder {
    level: f64,
    /// Its place among the levels whose up-crossings are counted; none where state 0 is no displacement.
    crossing: Option<usize>,
    window: PassageWindow,
}

impl Statistic for PassageRecorder {
    type Request = PassageRequest;
    type Sums = PassageTally;
    type Path = PassageClock;

    fn check(requests: &[PassageRequest], _: usize, interval: f64) -> Result<()> {
        at_most("number of first passages", requests.len(), MOST_PASSAGES, "at most 16 can be measured")?;
        for (k, &PassageRequest { level, length, bins }) in requests.iter().enumerate() {
            finite("level", level)?;
            PassageWindow::new(length, interval, bins, false)?;
            let remedy = "its first passage is requested twice; one window can be given for each level";
            require(requests[..k].iter().all(|other| !same_level(other.level, level)), "level", level, remedy)?;
        }
        Ok(())
    }

    fn level(request: &PassageRequest) -> Option<f64> {
        Some(request.level)
    }

    fn of(&PassageRequest { level, length, bins }: &PassageRequest, plan: &Plan) -> Result<Self> {
        let crossing = plan.velocity().and_then(|_| plan.levels.iter().position(|&y| same_level(y, level)));
        let window = PassageWindow::new(length, plan.interval(), bins, crossing.is_some())?;
        Ok(PassageRecorder { level, crossing, window })
    }

    fn sums(&self) -> PassageTally {
        self.window.tally()
    }

    fn observe(&self, sums: &mut PassageTally, clock: &mut PassageClock, sample: &Sample<'_>) {
        let since = self.crossing.is_some_and(|k| sample.crossed[k] >> sample.lane & 1 == 1);
        sums.push(&self.window, clock, [sample.x[0] >= self.level, since]);
    }
}

/// The windows of equal length that a stationary path is cut into, each of which has a first passage or none.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PassageWindow {
    /// Observations in a window.
    count: usize,
    interval: f64,
    bins: usize,
    /// Whether passages between observations count too.
    continuous: bool,
}

/// The place of one trajectory in its window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub(in crate::simulation) struct PassageClock {
    observed: usize,
    /// The observation by which it had passed the level. It is counted when the window ends, so that windows which have not ended
    /// count for nothing.
    passed: Option<usize>,
}

/// The counts of one batch of trajectories.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub(in crate::simulation) struct PassageTally {
    /// Windows that have ended.
    windows: f64,
    /// Σ min(T, W).
    waited: f64,
    /// Passages after the k-th share of a window; the first are those of windows that began beyond the level.
    passages: Vec<f64>,
}

impl PassageWindow {
    /// Windows of the length `length`, observed after each `interval`, with the distribution function at `bins` times that
    /// divide it equally.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless length and interval are finite and positive, and there
    /// are from 1 to 4096 bins, none shorter than an interval.
    fn new(length: f64, interval: f64, bins: usize, continuous: bool) -> Result<Self> {
        let remedy = "it must be finite and above zero";
        let count = positive("length of a window", length, remedy)? / positive("interval", interval, remedy)?;
        let holds = (1..=4096).contains(&bins) && count.round() >= bins as f64 && count <= 2.0_f64.powi(53);
        let remedy = "there must be from 1 to 4096, each at least as long as the interval between observations";
        require(holds, "number of bins", bins as f64, remedy)?;
        // Whole observations in each bin.
        let each = (count / bins as f64).round();
        Ok(PassageWindow { count: each as usize * bins, interval, bins, continuous })
    }

    /// The length W, rounded to whole observations in each bin.
    fn length(&self) -> f64 {
        self.count as f64 * self.interval
    }

    /// An empty tally.
    fn tally(&self) -> PassageTally {
        PassageTally { windows: 0.0, waited: 0.0, passages: vec![0.0; self.bins + 1] }
    }
}

impl PassageTally {
    /// Takes one observation of a trajectory: whether it is beyond the level, and whether it has passed it since the last
    /// one. The first observation of a window is its beginning; each trajectory has its own clock.
    fn push(&mut self, window: &PassageWindow, clock: &mut PassageClock, [beyond, since]: [bool; 2]) {
        if beyond || since && clock.observed > 0 {
            clock.passed = clock.passed.or(Some(clock.observed));
        }
        if clock.observed < window.count {
            clock.observed += 1;
            return;
        }
        match clock.passed {
            Some(passed) => {
                self.passages[passed.div_ceil(window.count / window.bins)] += 1.0;
                // A passage between two observations happened half an interval before the second, in the mean.
                let ahead = if window.continuous && passed > 0 { 0.5 } else { 0.0 };
                self.waited += (passed as f64 - ahead) * window.interval;
            }
            None => self.waited += window.length(),
        }
        self.windows += 1.0;
        *clock = PassageClock::default();
    }
}

/// The time T that a stationary path takes to pass a level from below, with standard errors from batches of independent
/// trajectories.
///
/// Each window begins at a stationary state: T is zero if that lies beyond the level already. A window of the length W that
/// ends without a passage means T > W. All windows have the same length, so that times are censored at W alone: the
/// distribution function is unbiased up to W, and not known beyond. Windows of one trajectory follow each other and are
/// correlated; batches are not. Errors cover chance, not the time step.
#[derive(Clone, Debug)]
pub struct FirstPassage {
    window: PassageWindow,
    batches: Vec<PassageTally>,
}

impl FirstPassage {
    /// From the tallies of batches that are independent of each other.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) if fewer than two batches have a window that has ended.
    fn new(window: PassageWindow, mut batches: Vec<PassageTally>) -> Result<Self> {
        batches.retain(|batch| batch.windows > 0.0);
        let remedy = "too few trajectories ran for so long; take more samples or a shorter window";
        require(batches.len() >= 2, "window of a first passage", window.length(), remedy)?;
        Ok(FirstPassage { window, batches })
    }

    /// P(T ≤ t) at the times t that divide a window equally, from t = 0 to W. For other states than displacements, T is the
    /// time of the first sample beyond the level.
    pub fn distribution(&self) -> Vec<(f64, Estimate)> {
        let bin = self.window.length() / self.window.bins as f64;
        let until = |k: usize| {
            let sums = |b: &PassageTally| [b.windows, b.passages[..=k].iter().sum()];
            (k as f64 * bin, jackknife(&self.batches, sums, |[windows, passed]: [f64; 2]| passed / windows))
        };
        (0..=self.window.bins).map(until).collect()
    }

    /// The restricted mean E min(T, W), which is ∫ P(T > t) dt over the window. Where passages between samples count, each
    /// counts in the middle of its sampling interval Δ, which leaves an error of order Δ².
    pub fn restricted_mean(&self) -> Estimate {
        jackknife(&self.batches, |b| [b.windows, b.waited], |[windows, waited]| waited / windows)
    }

    /// The mean E T as it would be if passages went on at a constant rate, P(T > t) = P₀ exp(−λt) with P₀ = P(T > 0):
    /// the mean P₀/λ, with λ passages per unit time of waiting. Exact for no oscillator; close where the level is high,
    /// so that passages are rare and do not depend on the start. [`FirstPassage::distribution`] shows whether the rate is
    /// constant.
    pub fn extrapolated_mean(&self) -> Estimate {
        let sums = |b: &PassageTally| [b.windows, b.waited, b.passages[0], b.passages[1..].iter().sum()];
        jackknife(&self.batches, sums, |[windows, waited, at_once, later]| (1.0 - at_once / windows) * waited / later)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Windows of four intervals in two bins. The first passes at its second interval, the second never, the third at once.
    #[test]
    fn windows_count_their_first_passage() -> Result<()> {
        let window = PassageWindow::new(2.0, 0.5, 2, false)?;
        let (mut tally, mut clock) = (window.tally(), PassageClock::default());
        for beyond in [0, 0, 1, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0] {
            tally.push(&window, &mut clock, [beyond == 1, false]);
        }
        assert_eq!(clock, PassageClock::default());
        assert_eq!((tally.windows, tally.waited), (3.0, 1.0 + 2.0));
        assert_eq!(tally.passages, [1.0, 1.0, 0.0]);
        let passage = FirstPassage::new(window, vec![tally.clone(), tally])?;
        assert_eq!(passage.restricted_mean(), Estimate::new(1.0, 0.0));
        let distribution = passage.distribution();
        assert_eq!(distribution.iter().map(|d| d.0).collect::<Vec<_>>(), [0.0, 1.0, 2.0]);
        assert!((distribution[1].1.value - 2.0 / 3.0).abs() < 1e-15);
        Ok(())
    }

    /// A passage between two observations belongs to the interval before the second; one before the window does not count.
    #[test]
    fn a_watched_path_passes_between_observations() -> Result<()> {
        let window = PassageWindow::new(2.0, 0.5, 2, true)?;
        let (mut tally, mut clock) = (window.tally(), PassageClock::default());
        for since in [true, false, false, true, false] {
            tally.push(&window, &mut clock, [false, since]);
        }
        assert_eq!((tally.windows, tally.waited, tally.passages), (1.0, 1.25, vec![0.0, 0.0, 1.0]));
        Ok(())
    }

    /// A passage in a window that has not ended would be one of no window.
    #[test]
    fn windows_count_once_they_have_ended() -> Result<()> {
        let window = PassageWindow::new(2.0, 0.5, 2, true)?;
        let (mut tally, mut clock) = (window.tally(), PassageClock::default());
        for since in [false, false, false, false, false, false, true, false] {
            tally.push(&window, &mut clock, [false, since]);
        }
        assert_eq!((tally.windows, tally.waited, tally.passages), (1.0, 2.0, vec![0.0; 3]));
        assert_eq!(clock.passed, Some(1));
        Ok(())
    }

    #[test]
    fn windows_without_a_meaning_are_refused() {
        assert!(PassageWindow::new(0.0, 0.5, 1, true).is_err() && PassageWindow::new(1.0, f64::NAN, 1, true).is_err());
        assert!(PassageWindow::new(1.0, 0.5, 0, true).is_err() && PassageWindow::new(1.0, 0.5, 3, true).is_err());
    }
}
