use super::{
    importance::Importance,
    population::{ParticleMotion, Particles, Population},
    tally::Levels,
};
use crate::numerics::sort_by_number;
use crate::{error::Result, simulation::boundaries::Boundaries};
use std::f64::consts::E;

/// A threshold is set only if at least this share of the weight beyond the last one lies beyond it.
const SEEN: f64 = 0.1;
/// The least number of starting states beyond the last threshold that is set from them.
const LEAST_STATES: f64 = 30.0;
/// The number of thresholds between bins at which no more are set, for any importance function.
const MOST_BINS: usize = 200;
/// So many rounds may pass without a new threshold before the importance function counts as exhausted.
const PATIENCE: usize = 10;
/// The rounds of the pilot that the scale of the tail at each level is taken from.
const CELL_ROUNDS: usize = 4;
/// The width δ of a cell about a level, as a share of the mean excess E(X − y | X > y), which is the scale of the tail there.
/// For an exponential tail the cells then err by 6·10⁻⁵ of the density.
const CELL: f64 = 1.0 / 3.0;
/// The fewest particles beyond a level from which the mean excess there is taken.
const LEAST_SEEN: f64 = 50.0;

/// The run that finds the thresholds, before the measurement.
pub(super) struct SplittingPilot<'a> {
    pub(super) motion: &'a ParticleMotion<'a>,
    pub(super) boundaries: &'a Boundaries,
    /// Cycles of one round.
    pub(super) cycles: usize,
    /// The share of the weight beyond the last threshold at which it stops.
    pub(super) rarest: f64,
    /// Where walls leave each state.
    pub(super) walls: &'a [[f64; 2]],
}

/// Sums over the states beyond one level and below it: Σ1, Σw and Σw|x − y|.
#[derive(Clone, Copy, Default)]
struct Excess {
    above: [f64; 3],
    below: [f64; 3],
}

impl SplittingPilot<'_> {
    /// Thresholds that each leave a share of e⁻¹ beyond them. In a round of some cycles particles pass a little beyond the
    /// last threshold, and the next ones are set from them.
    pub(super) fn thresholds(&self, population: &mut Population, states: &Particles) -> Result<Vec<f64>> {
        let least = LEAST_STATES / states.len() as f64;
        let mut thresholds = quantiles(values(self.motion.importance, states)?, least, f64::NEG_INFINITY);
        population.set_thresholds(&thresholds);
        population.place(self.motion.importance, states)?;
        let mut idle = 0;
        while thresholds.len() < MOST_BINS && idle < PATIENCE {
            let (mut beyond, mut share) = (Vec::new(), 0.0);
            for cycle in 0..self.cycles {
                let states = population.advance(self.motion, self.boundaries, &mut [])?;
                population.place(self.motion.importance, &states)?;
                if 2 * cycle >= self.cycles {
                    let last = population.last(self.motion.scheme.states);
                    share += last.iter().map(|(_, w)| w).sum::<f64>();
                    beyond.extend(values(self.motion.importance, &last)?);
                }
            }
            idle += 1;
            if !beyond.is_empty() {
                if share / (self.cycles - self.cycles / 2) as f64 <= self.rarest {
                    break;
                }
                let more = quantiles(beyond, SEEN, thresholds.last().copied().unwrap_or(f64::NEG_INFINITY));
                idle = if more.is_empty() { idle } else { 0 };
                thresholds.extend(more);
                population.set_thresholds(&thresholds);
            }
        }
        Ok(thresholds)
    }

    /// The widths of the cells about the levels of each state.
    pub(super) fn cells(&self, population: &mut Population, requested: &[(usize, Vec<f64>)]) -> Result<Vec<Levels>> {
        let mut seen: Vec<Vec<Excess>> = requested.iter().map(|(_, y)| vec![Excess::default(); y.len()]).collect();
        for _ in 0..CELL_ROUNDS * self.cycles {
            let states = population.advance(self.motion, self.boundaries, &mut [])?;
            for ((state, levels), seen) in requested.iter().zip(&mut seen) {
                for (y, excess) in levels.iter().zip(seen) {
                    states.iter().for_each(|(x, weight)| excess.add(x[*state] - y, weight));
                }
            }
            population.place(self.motion.importance, &states)?;
        }
        let watched = requested.iter().zip(seen).map(|((state, levels), seen)| {
            let [low, high] = self.walls[*state];
            let scales = scales(&seen);
            let room = |y: f64| (y - low).min(high - y);
            let width = |(&y, scale): (&f64, f64)| (y, (CELL * scale).min(room(y) / 1.5));
            Levels::new(*state, levels.iter().zip(scales).map(width).collect())
        });
        Ok(watched.collect())
    }
}

impl Excess {
    fn add(&mut self, away: f64, weight: f64) {
        let side = if away >= 0.0 { &mut self.above } else { &mut self.below };
        *side = [side[0] + 1.0, side[1] + weight, side[2] + weight * away.abs()];
    }

    /// The smaller of the mean excess and the mean deficit; none where one of them is not known.
    fn scale(&self) -> Option<f64> {
        let mean = |[count, weight, sum]: [f64; 3]| (count >= LEAST_SEEN).then_some(sum / weight);
        Some(mean(self.above)?.min(mean(self.below)?))
    }
}

/// The scale at each of some rising levels. Those that too few states reach take the scale of the nearest that is known; if
/// there is none, it is zero.
fn scales(seen: &[Excess]) -> Vec<f64> {
    let known: Vec<(usize, f64)> = seen.iter().enumerate().filter_map(|(k, e)| Some((k, e.scale()?))).collect();
    let nearest = |k: usize| known.iter().min_by_key(|&&(other, _)| other.abs_diff(k)).map_or(0.0, |&(_, scale)| scale);
    (0..seen.len()).map(nearest).collect()
}

fn values(importance: &Importance<'_>, states: &Particles) -> Result<Vec<(f64, f64)>> {
    states.iter().map(|(x, w)| Ok((importance.at(x)?, w))).collect()
}

/// The values above `above` that leave the shares e⁻¹, e⁻², ... ≥ `least` of the weight beyond them, rising.
fn quantiles(mut values: Vec<(f64, f64)>, least: f64, above: f64) -> Vec<f64> {
    sort_by_number(&mut values, |(value, _)| -value);
    let total: f64 = values.iter().map(|&(_, w)| w).sum();
    // A threshold with no state below it would not divide the states.
    let above = values.last().map_or(above, |&(lowest, _)| above.max(lowest));
    let shares = std::iter::successors(Some(1.0 / E), |share| Some(share / E)).take_while(|&share| share >= least);
    let mut found = Vec::new();
    for share in shares {
        let mut sum = 0.0;
        let beyond = |&&(_, w): &&(f64, f64)| {
            sum += w;
            sum >= share * total
        };
        if let Some(&(xi, _)) = values.iter().find(beyond)
            && xi.is_finite()
            && found.last().is_none_or(|&last| xi > last)
            && xi > above
        {
            found.push(xi);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of the weights 1 at 1, 2, ..., 100 the shares 1/e and 1/e² are reached at the 37th and the 14th from above.
    #[test]
    fn quantiles_leave_powers_of_one_over_e_beyond() {
        let values: Vec<(f64, f64)> = (1..=100).map(|k| (f64::from(k), 1.0)).collect();
        assert_eq!(quantiles(values.clone(), 0.1, 0.0), [64.0, 87.0]);
        assert_eq!(quantiles(values, 0.1, 70.0), [87.0]);
        assert!(quantiles(vec![(3.0, 0.5), (3.0, 0.5)], 0.1, 3.0).is_empty());
        assert!(quantiles(Vec::new(), 0.1, 0.0).is_empty());
    }
}
