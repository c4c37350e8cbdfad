//! First passages on the grid: identities that hold exactly, other methods' numbers, and inputs without a meaning.

use crate::common::{duffing_above, problem, walls_at};
use expoly::models::Linear;
use expoly::{
    Crossing, Density, Drift, Error, Estimate, Gaussian, Grid, GridDensity, Scalar, Simulation, Start, Survival,
};
use nalgebra::{dmatrix, dvector};
use std::sync::OnceLock;

const NONE: f64 = f64::INFINITY;
/// The standard deviation of the displacement.
const SIGMA: f64 = 0.813_459;

/// Solved once for all tests.
fn duffing() -> &'static GridDensity {
    static DENSITY: OnceLock<GridDensity> = OnceLock::new();
    DENSITY.get_or_init(|| Grid::new().solve(&problem(crate::common::duffing())).unwrap())
}

fn below(level: f64) -> Survival {
    duffing().survival([-NONE, level]).unwrap()
}

fn stationary(survival: &Survival, times: &[f64]) -> Vec<Estimate> {
    survival.probability(&Start::Stationary, times, 1e-3).unwrap()
}

fn gaussian(x: f64, spread: f64) -> Start {
    Start::Gaussian(Gaussian { mean: dvector![x, 0.0], covariance: dmatrix![spread, 0.0; 0.0, spread] })
}

/// P(T > 0) = P(X < b), its first slope is minus Rice's rate of up-crossings, and it falls with time and rises with the level.
#[test]
fn survival_begins_as_rice_has_it_and_is_monotone() {
    let times = [0.0, 0.02, 0.04, 1.0, 3.0];
    let mut last = vec![0.0; times.len()];
    for level in [0.5, 1.5, 2.5].map(|share| share * SIGMA) {
        let found = stationary(&below(level), &times);
        let rate = duffing().flux(Crossing::upward(level), 1).unwrap().value;
        // Through 0, h and 2h: its error h² S‴/3, by a third derivative of order one, is 1e-4.
        let slope = (4.0 * found[1].value - 3.0 * found[0].value - found[2].value) / 0.04;
        println!("level {level:.3}: slope {slope:.6}, rate {rate:.6}, {found:?}");
        assert!((slope + rate).abs() < 2e-3 * rate.max(0.05), "{slope} and {rate}");
        assert!(found.windows(2).all(|pair| pair[1].value < pair[0].value), "{found:?}");
        assert!(found.iter().zip(&last).all(|(found, last)| found.value > *last), "{found:?} and {last:?}");
        last = found.iter().map(|found| found.value).collect();
    }
}

/// For large t the survival falls at the slowest rate, and the mean time is its integral: by Simpson's rule to t = 30 with the
/// rest at that rate. The next modes have died to e^-20 by then.
#[test]
fn survival_ends_at_the_slowest_rate_and_integrates_to_the_mean_time() {
    let survival = below(SIGMA);
    let (rate, start) = (survival.rate().unwrap(), gaussian(-0.6, 0.16));
    let times: Vec<f64> = (0..=120).map(|k| 0.25 * f64::from(k)).collect();
    let found = survival.probability(&start, &times, 1e-4).unwrap();
    let late = (found[80].value / found[120].value).ln() / 10.0;
    println!("rate {rate}, at last {late}");
    assert!(rate.error < 2e-5 * rate.value && (late / rate.value - 1.0).abs() < 1e-4, "{rate} and {late}");
    let weight = |k: usize| if k == 0 || k == 120 { 1.0 } else { 2.0 * (1 + k % 2) as f64 };
    let simpson: f64 = found.iter().enumerate().map(|(k, found)| weight(k) * 0.25 / 3.0 * found.value).sum();
    let (whole, mean) = (simpson + found[120].value / rate.value, survival.mean_time(&start).unwrap());
    println!("mean time {mean}, integrated {whole}");
    assert!((whole / mean.value - 1.0).abs() < 3e-4 && mean.error < 1e-4 * mean.value, "{mean} and {whole}");
}

/// A symmetric oscillator passes −b as it passes b, and ±b as the one above an elastic wall at its middle passes b.
#[test]
fn mirror_images_survive_alike() {
    let level = 1.5 * SIGMA;
    let rates = [[-NONE, level], [-level, NONE]].map(|within| duffing().survival(within).unwrap().rate().unwrap());
    println!("{rates:?}");
    assert!((rates[0].value - rates[1].value).abs() < rates[0].error + rates[1].error, "{rates:?}");
    let folded = Grid::new().accuracy(1e-5).solve(&duffing_above(0.0, 1.0)).unwrap();
    let two = duffing().survival([-level, level]).unwrap();
    let one = folded.survival([-NONE, level]).unwrap();
    let rates = [&two, &one].map(|survival| survival.rate().unwrap());
    println!("{rates:?}");
    assert!((rates[0].value - rates[1].value).abs() < rates[0].error + rates[1].error, "{rates:?}");
    for (two, one) in stationary(&two, &[0.0, 1.0, 6.0]).iter().zip(stationary(&one, &[0.0, 1.0, 6.0])) {
        assert!((two.value - one.value).abs() < two.error + one.error + 1e-6, "{two} and {one}");
    }
}

/// Beyond the domain nothing is passed; up to there a high level is passed at less than its rate of up-crossings, since those
/// come in clumps, and on both sides at less than twice the rate of one, since a clump passes both.
#[test]
fn high_levels_are_passed_rarely_and_farther_ones_never() {
    let level = 3.5 * SIGMA;
    let crossings = duffing().flux(Crossing::upward(level), 1).unwrap().value;
    let [one, two] =
        [[-NONE, level], [-level, level]].map(|within| duffing().survival(within).unwrap().rate().unwrap());
    println!("{one}, {two}, up-crossings {crossings}");
    assert!(one.value < crossings && one.value > 0.9 * crossings, "{one} and {crossings}");
    assert!(two.value < 1.8 * one.value && two.value > 1.6 * one.value, "{one} and {two}");
    // To 1e-6 in L¹ the density itself is known to a hundredth there.
    assert!(one.error < 2e-2 * one.value && two.error < 3e-2 * two.value, "{one} and {two}");
    // A mesh for 1e-4 leaks 6e-9 through the edges in the whole time, one for 1e-3 1e-6.
    let never = below(50.0).probability(&Start::Stationary, &[0.0, 10.0, 50.0], 1e-4).unwrap();
    assert!(never.iter().all(|never| (never.value - 1.0).abs() < never.error.max(1e-7)), "{never:?}");
}

/// The error of the survival falls with the accuracy that is asked for, and is below its own bound.
#[test]
fn survival_converges_with_the_accuracy() {
    let at = |accuracy: f64| {
        let density = Grid::new().accuracy(accuracy).solve(&problem(crate::common::duffing())).unwrap();
        density.survival([-NONE, 1.5 * SIGMA]).unwrap().rate().unwrap()
    };
    let (finest, found) = (at(1e-8), [1e-2, 1e-5].map(at));
    let off = found.map(|found| (found.value - finest.value).abs());
    println!("off by {off:?}, finest {finest}, found {found:?}");
    assert!(off[1] < off[0] / 3.0, "{off:?}");
    assert!(found.iter().zip(off).all(|(found, off)| off < found.error), "{off:?}");
}

/// The grid against the simulation's count of first passages, within three of its standard errors at all times: without a wall,
/// and above one that takes energy.
#[test]
fn survival_agrees_with_a_count() {
    for (walled, level) in [(None, 1.5 * SIGMA), (Some(0.8), 1.5)] {
        let problem = walled.map_or_else(|| problem(crate::common::duffing()), |r| duffing_above(-0.2, r));
        let solve = || Grid::new().accuracy(1e-4).solve(&problem).unwrap();
        let density = if walled.is_some() { &solve() } else { duffing() };
        // 6 whole windows of 121 observations on each of 1000 trajectories.
        let simulation = Simulation::new().sampling_interval(0.1).trajectories(1000).samples(1000 * 121 * 6).seed(3);
        let counted = simulation.first_passage(level, 12.0, 6).run(&problem).unwrap();
        let counted = counted.first_passage(level).unwrap().distribution();
        let times: Vec<f64> = counted.iter().map(|(time, _)| *time).collect();
        let found = stationary(&density.survival([-NONE, level]).unwrap(), &times);
        for ((time, passed), found) in counted.iter().zip(found) {
            let deviation = (1.0 - passed.value - found.value).abs() / passed.error.hypot(found.error);
            println!("t = {time}: {found}, counted {:.6} ± {:.6}", 1.0 - passed.value, passed.error);
            assert!(deviation < 3.0, "t = {time}: {found} and 1 − {passed}");
            assert!(found.error < 0.1 * passed.error, "t = {time}: {found} and {passed}");
        }
    }
}

/// A point survives until the mesh resolves it, and a start beyond the level does not.
#[test]
fn starts_of_every_kind_survive() {
    let survival = below(2.0 * SIGMA);
    let found = survival.probability(Start::Point(vec![0.0, 0.0]), &[0.0, 0.1, 5.0, 10.0], 1e-3).unwrap();
    println!("{found:?}");
    // The projected Gaussian has this mass to 1e-5.
    assert!((found[0].value - 1.0).abs() < 1e-4 && found[0].value == found[1].value);
    assert!(found[3].value < found[2].value && found[2].value < 1.0);
    let cut = survival.probability(gaussian(2.0 * SIGMA, 0.2), &[0.0], 1e-3).unwrap();
    println!("{cut:?}");
    assert!((cut[0].value - 0.5).abs() < 1e-4, "{cut:?}");
    let beyond = survival.probability(gaussian(9.0 * SIGMA, 0.2), &[0.0], 1e-3).unwrap();
    assert!(beyond[0].value.abs() < 1e-6, "{beyond:?}");
}

/// dx = −x dt + dW₁, dy = −2y dt + dW₂.
#[derive(Debug)]
struct TwoFilters;

impl Drift<2, 2> for TwoFilters {
    fn drift<S: Scalar>(&self, [x, y]: [S; 2]) -> [S; 2] {
        [-x, y * -2.0]
    }
    fn noise<S: Scalar>(&self, _: [S; 2]) -> [[S; 2]; 2] {
        [[S::from(1.0), S::zero()], [S::zero(), S::from(1.0)]]
    }
}

#[test]
fn survivals_without_a_meaning_are_refused() {
    for within in [[f64::NAN, 1.0], [1.0, -1.0], [1.0, 1.0], [NONE, NONE], [700.0, 800.0], [-NONE, -700.0]] {
        let refused = duffing().survival(within).map(|survival| survival.within());
        assert!(matches!(refused, Err(Error::OutOfRange { .. })), "{refused:?}");
    }
    let survival = below(1.0);
    let asked = |start: &Start, times: &[f64], accuracy: f64| survival.probability(start, times, accuracy).unwrap_err();
    for error in [
        asked(&Start::Stationary, &[-1.0], 1e-3),
        asked(&Start::Stationary, &[1.0, 1.0], 1e-3),
        asked(&Start::Stationary, &[f64::NAN], 1e-3),
        asked(&Start::Stationary, &[0.0, NONE], 1e-3),
        asked(&Start::Stationary, &[1.0], 0.0),
        asked(&Start::Point(vec![f64::NAN, 0.0]), &[1.0], 1e-3),
        asked(&gaussian(0.0, 1e-20), &[1.0], 1e-3),
    ] {
        assert!(matches!(error, Error::OutOfRange { .. }), "{error}");
    }
    // No state of these two is the velocity of the other.
    let refused = Grid::new().accuracy(1e-3).solve(&problem(TwoFilters)).unwrap().survival([-1.0, 1.0]).map(|_| ());
    assert!(matches!(refused, Err(Error::NotADisplacement { state: 0 })), "{refused:?}");
    let room = problem(Linear::new(0.5, 1.0, 0.5).unwrap());
    let [lower, upper] = walls_at([-0.5, 0.5], [1.0, 1.0]);
    let between = Grid::new().accuracy(1e-3).solve(&room.with_wall(lower).unwrap().with_wall(upper).unwrap());
    // Behind a wall there is no room either; a level there is none.
    assert!(between.as_ref().unwrap().survival([0.6, 1.0]).is_err());
    assert_eq!(between.unwrap().survival([-1.0, 0.3]).unwrap().within(), [-1.0, 0.3]);
}

/// What leaks through the edges of a domain that is too small is in the error: 6 % are lost, and to the first order in time the leak
/// of the density bounds that from above, whatever part of it is lost.
#[test]
fn a_leak_is_in_the_error() {
    let grid = Grid::new().accuracy(1e-4).domain([[-1.5, 4.0], [-7.0, 7.0]]);
    let cut = grid.solve(&problem(crate::common::duffing())).unwrap();
    let found = stationary(&cut.survival([-NONE, 50.0]).unwrap(), &[2.0])[0];
    println!("{found}");
    assert!(1.0 - found.value > 1e-2 && 1.0 - found.value < found.error, "{found}");
}
