//! The tests of whether a run still depends on its start, and whether it has a stationary density.

use super::{calibration::Calibration, jackknife::jackknife, layout::TallyLayout, plan::Plan, tally::Tally};
use crate::simulation::UNEVEN_WEIGHTS;
use crate::walls::{COLLAPSE, Wall};

/// The mean square of a state that changes by more standard errors from one half of a run to the other has not become
/// stationary.
const DRIFTING: f64 = 4.0;
/// The fewest batches whose spread shows the correlation times of states: from so many it is known to about a third.
const LEAST_BATCHES: usize = 32;
/// The fewest samples of a trajectory whose two halves are compared; fewer are compared with states late in the burn-in.
const LEAST_TREND: usize = 16;

/// As [`SimulatedDensity::stationarity`](super::SimulatedDensity::stationarity).
pub(super) fn drifts(batches: &[Tally], states: usize) -> Vec<f64> {
    let of_state = |i: usize| {
        let sums = |b: &Tally| {
            let [(n1, first), (n2, second)] = b.trend.halves(i, b.samples);
            if b.samples < LEAST_TREND {
                [b.before[0], b.before[i + 1], n1 + n2, first + second]
            } else {
                [n1, first, n2, second]
            }
        };
        let change = jackknife(batches, sums, |[n1, s1, n2, s2]| s2 / n2 - s1 / n1);
        change.value / change.error
    };
    (0..states).map(of_state).collect()
}

/// The state with the longest correlation time ∫₀^∞ R(τ) dτ/R(0) of x_i or x_i², and that time: by the spread of its means
/// over batches relative to that of independent samples. None where batches are too few for it.
fn slowest(batches: &[Tally], layout: &TallyLayout, interval: f64) -> Option<(usize, f64)> {
    if batches.len() < LEAST_BATCHES {
        return None;
    }
    let states = layout.axes.len();
    let count: f64 = batches.iter().map(|b| b.moments[0]).sum();
    let time = |i: usize, power: u32| -> Option<f64> {
        let (own, square) = (layout.power(i, power)?, layout.power(i, 2 * power)?);
        let mean = |k: usize| batches.iter().map(|b| b.moments[k]).sum::<f64>() / count;
        let apart = |b: &Tally| b.moments[0] * (b.moments[own] / b.moments[0] - mean(own)).powi(2);
        let between = batches.iter().map(apart).sum::<f64>() / (batches.len() - 1) as f64;
        Some(0.5 * interval * between / (mean(square) - mean(own).powi(2)))
    };
    let all = (0..states).flat_map(|i| [1, 2].map(|power| (i, time(i, power).unwrap_or(0.0))));
    all.filter(|(_, time)| time.is_finite()).max_by(|a, b| a.1.total_cmp(&b.1))
}

/// The warning for walls that trajectories come to rest on.
const CHATTER: &str = "no white noise acts on the velocity at a wall that takes energy, and trajectories come to rest on it after \
    infinitely many impacts: the impact rate is infinite, and what is found of it is that of flights longer than 1/4096 of a \
    time step; the time at rest, moments and the power that the impacts take are not affected";

/// Why a run should not be relied on, if there is a reason.
pub(super) fn warning(
    batches: &[Tally],
    layout: &TallyLayout,
    plan: &Plan,
    missed: Option<&Calibration>,
) -> Option<String> {
    let slowest = slowest(batches, layout, plan.interval());
    if let Some((state, time)) = slowest.filter(|(_, time)| *time > plan.burn_in()) {
        return Some(format!(
            "not mixed: state {state} is correlated over a time of {time:.0}, which is longer than the burn-in; the answer \
             depends on where trajectories began"
        ));
    }
    let drifts = drifts(batches, layout.axes.len());
    if let Some((state, drift)) = drifts.iter().enumerate().find(|(_, drift)| drift.abs() > DRIFTING) {
        return Some(format!(
            "not stationary: the mean square of state {state} still changes, by {drift:.1} standard errors; take a longer \
             burn-in, if there is a stationary density at all"
        ));
    }
    if plan.walls.iter().any(Wall::collapses) {
        return Some(COLLAPSE.to_owned());
    }
    if batches.iter().flat_map(|b| &b.passages.rests).any(|[time, _]| *time > 0.0) {
        return Some(CHATTER.to_owned());
    }
    missed.map(|Calibration { degree, weight_deviation, .. }| {
        if *weight_deviation > UNEVEN_WEIGHTS {
            format!(
                "the samples do not satisfy the moment equations of degree {degree}: they need weights 1 ± {weight_deviation:.2}; \
                 take a longer burn-in, more samples or a shorter time step, if there is a stationary density with such moments at all"
            )
        } else {
            format!(
                "the moment equations of degree {degree} make a mean fourth power smaller than the mean square allows: moments of this \
                 degree do not exist, or take a longer burn-in and more samples"
            )
        }
    })
}
