//! What the impacts of a pilot give.

use crate::density::Counted;
use crate::estimate::Estimate;
use crate::record::{Read, positive};
use serde::{Deserialize, Serialize};

/// The powers 0, 1, 2 of the speed come first in a list of statistics; the counts in bins follow them.
pub(super) const POWERS: usize = 3;

/// What the pilot's calibrated impacts on a wall give per unit time: Σ 1, Σ |w| and Σ w² of the speeds w of approach, and the
/// numbers of impacts in bins of |w|.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct WallImpacts {
    means: Vec<f64>,
    /// For each group of trajectories what its means differ by.
    groups: Vec<Vec<f64>>,
    /// The width of a bin.
    bin: f64,
    /// The rate by the density itself, and its standard error.
    own_rate: [f64; 2],
}

impl WallImpacts {
    pub(in crate::closure) fn new(means: Vec<f64>, groups: Vec<Vec<f64>>, bin: f64) -> Self {
        WallImpacts { means, groups, bin, own_rate: [0.0; 2] }
    }

    /// The same with the rate that the density itself has at the wall.
    pub(in crate::closure) fn beside(self, own_rate: Estimate) -> Self {
        WallImpacts { own_rate: [own_rate.value, own_rate.error], ..self }
    }

    /// Whether the density's own rate is farther from that of the pilot than chance and a share that does not matter.
    pub(in crate::closure) fn contradicts(&self, errors: f64, share: f64) -> bool {
        let rate = Combination::of(std::slice::from_ref(self)).estimate(&[(0, 1.0)]);
        let [own, error] = self.own_rate;
        (own - rate.value).abs() > errors * rate.error.hypot(error) + share * rate.value
    }

    /// Refuses numbers without a meaning, such as those of a damaged file.
    pub(super) fn checked(self) -> Read<Self> {
        let same = self.groups.iter().all(|group| group.len() == self.means.len());
        let finite = self.means.iter().chain(self.groups.iter().flatten()).all(|value| value.is_finite());
        positive("the width of a bin of impact speeds", self.bin)?;
        if self.means.len() <= POWERS || self.groups.len() < 3 || !same || !finite {
            return Err(String::from("its statistics of impacts are not those of a wall"));
        }
        Ok(self)
    }
}

/// The statistics of some walls together.
#[derive(Clone, Debug)]
pub(super) struct Combination {
    means: Vec<f64>,
    groups: Vec<Vec<f64>>,
    bin: f64,
}

impl Combination {
    pub(super) fn of(walls: &[WallImpacts]) -> Self {
        let sum = |lists: &mut dyn Iterator<Item = &Vec<f64>>| -> Vec<f64> {
            let mut sum: Vec<f64> = Vec::new();
            for list in lists {
                sum.resize(list.len(), 0.0);
                sum.iter_mut().zip(list).for_each(|(sum, value)| *sum += value);
            }
            sum
        };
        let groups = walls.first().map_or(0, |wall| wall.groups.len());
        Combination {
            means: sum(&mut walls.iter().map(|wall| &wall.means)),
            groups: (0..groups).map(|g| sum(&mut walls.iter().filter_map(|wall| wall.groups.get(g)))).collect(),
            bin: walls.first().map_or(1.0, |wall| wall.bin),
        }
    }

    /// Σ c_k mean_k.
    pub(super) fn estimate(&self, c: &[(usize, f64)]) -> Estimate {
        let along = |list: &[f64]| c.iter().map(|&(k, c)| c * list[k]).sum::<f64>();
        let square: f64 = self.groups.iter().map(|group| along(group).powi(2)).sum();
        let count = self.groups.len() as f64;
        // Two means have been taken off.
        Estimate::new(along(&self.means), (square / (count - 2.0) / count).sqrt())
    }

    /// Σ c_k mean_k over the rate.
    pub(super) fn of_one_impact(&self, c: &[(usize, f64)]) -> Estimate {
        let (value, rate) = (self.estimate(c).value, self.means[0]);
        let ratio = value / rate;
        let linear: Vec<(usize, f64)> = c.iter().map(|&(k, c)| (k, c / rate)).chain([(0, -ratio / rate)]).collect();
        Estimate::new(ratio, self.estimate(&linear).error)
    }

    fn bins(&self) -> usize {
        self.means.len() - POWERS
    }
}

impl Counted for Combination {
    /// By the bin that holds the speed.
    fn density(&self, x: f64) -> Estimate {
        match (0..self.bins()).find(|&k| (k as f64..(k + 1) as f64).contains(&(x / self.bin))) {
            Some(k) => self.of_one_impact(&[(POWERS + k, self.bin.recip())]),
            None => Estimate::new(0.0, 0.0),
        }
    }

    fn below(&self, x: f64) -> Estimate {
        let place = x / self.bin;
        let share = |k: usize| (place - k as f64).clamp(0.0, 1.0);
        let all: Vec<(usize, f64)> = (0..self.bins()).map(|k| (POWERS + k, share(k))).collect();
        self.of_one_impact(&all)
    }

    fn above(&self, x: f64) -> Estimate {
        let below = self.below(x);
        Estimate::new(1.0 - below.value, below.error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};
    use rand_distr::StandardNormal;

    /// Groups in two halves, each less its own mean: the mean of all over its error is Student's t of 30 degrees of freedom, whose
    /// root mean square 1.035 a thousand repetitions have to 2.3 %.
    #[test]
    fn standard_errors_are_those_of_the_mean() {
        let mut stream = ChaCha8Rng::seed_from_u64(1);
        let (groups, repetitions, mut square) = (32_usize, 1000, 0.0);
        for _ in 0..repetitions {
            let values: Vec<f64> = (0..groups).map(|_| stream.sample(StandardNormal)).collect();
            let means = [0, 1].map(|k| values.iter().skip(k).step_by(2).sum::<f64>() / (groups / 2) as f64);
            let residuals = values.iter().enumerate().map(|(k, v)| vec![v - means[k % 2], 0.0, 0.0, 0.0]).collect();
            let wall = WallImpacts::new(vec![(means[0] + means[1]) / 2.0, 0.0, 0.0, 0.0], residuals, 1.0);
            let rate = Combination::of(&[wall]).estimate(&[(0, 1.0)]);
            square += (rate.value / rate.error).powi(2) / f64::from(repetitions);
        }
        assert!((square.sqrt() - 1.035).abs() < 0.1, "{}", square.sqrt());
    }
}
