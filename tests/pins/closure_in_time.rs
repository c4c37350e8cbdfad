//! The closure in time: densities after a start, modes of relaxation, autocovariance and spectral density.

use super::{EDGES, Group, OPTIMA, Pins, power_of};
use crate::common::moving::{correlated, normal, van_der_pol};
use crate::common::{OrnsteinUhlenbeck, duffing, duffing_above, problem};
use expoly::models::FilteredDuffing;
use expoly::{Closure, ClosureDensity, Density, Gaussian, Problem, Result, Start, Transient};
use nalgebra::{DMatrix, dvector};

pub(super) const GROUPS: &[Group] = &[
    ("closure in time in three states", in_three_states),
    ("closure in time from a point", from_a_point),
    ("closure in time from a Gaussian", from_a_gaussian),
    ("closure in time above a wall", above_a_wall),
    ("relaxation of a closure", relaxation),
];

const STATES: usize = 5120;
const TRAJECTORIES: usize = 2048;

fn pin(pins: &mut Pins, share: f64, found: &[Transient<ClosureDensity>], place: &[f64]) -> Result<()> {
    for Transient { time, density, .. } in found {
        let n = density.dimension();
        let moments = [(0, 1), (1, 1), (0, 2), (1, 2)].map(|(state, power)| density.moment(&power_of(n, state, power)));
        let moments = moments.into_iter().collect::<Result<Vec<_>>>()?;
        pins.estimates(&format!("t = {time} moments"), share, &moments);
        pins.one(&format!("t = {time} ln p"), share, density.log_pdf(place)?);
        pins.one(&format!("t = {time} L1"), 1e2 * share, density.l1_estimate());
    }
    Ok(())
}

fn closure(order: u32) -> Closure {
    Closure::new(order).pilot_states(STATES)
}

fn filtered() -> Result<Problem> {
    FilteredDuffing::first_order(duffing(), 2.0)?.problem()
}

fn from_a_point(pins: &mut Pins) -> Result<()> {
    let wells = Problem::from_toml("states = ['x']\ndrift.x = 'x - x^3'\nnoise.w.x = '1'")?;
    for found in &closure(4).transient(&wells, Start::Point(vec![0.5]), &[1.0])? {
        let moments = [1, 2].map(|power| found.moment(&[power]).unwrap());
        pins.estimates("wells", OPTIMA, &moments);
        pins.all("wells ln p", OPTIMA, &[found.density.log_pdf(&[0.3])?]);
        pins.one("wells L1", 1e2 * OPTIMA, found.density.l1_estimate());
    }
    let line = closure(2).transient(&problem(OrnsteinUhlenbeck), Start::Point(vec![1.5]), &[0.1, 2.0])?;
    for found in &line {
        let [first, second] = [1, 2].map(|power| found.moment(&[power]).unwrap());
        pins.estimates(&format!("one state t = {}", found.time), OPTIMA, &[first, second]);
    }
    Ok(())
}

fn from_a_gaussian(pins: &mut Pins) -> Result<()> {
    pin(pins, EDGES, &closure(4).transient(&problem(duffing()), &correlated().0, &[0.5])?, &[0.3, 0.1])
}

fn above_a_wall(pins: &mut Pins) -> Result<()> {
    let found = closure(4).transient(&duffing_above(-0.5, 1.0), normal([0.5, 0.0], 0.3), &[0.5])?;
    pin(pins, EDGES, &found, &[0.3, 0.1])
}

/// A normal distribution about x = 1.
fn in_three_states(pins: &mut Pins) -> Result<()> {
    let closure = Closure::new(2).pilot_states(TRAJECTORIES);
    let start = Gaussian { mean: dvector![1.0, 0.0, 0.0], covariance: DMatrix::identity(3, 3) * 0.04 };
    pin(pins, OPTIMA, &closure.transient(&filtered()?, Start::Gaussian(start), &[1.0])?, &[0.3, 0.1, 0.1])
}

/// How the stationary response forgets.
fn relaxation(pins: &mut Pins) -> Result<()> {
    let density = closure(4).solve(&van_der_pol())?;
    pins.all("autocovariance", EDGES, &values(&density.autocovariance(0, &[0.0, 0.7, 3.0])?));
    pins.all("spectral density", EDGES, &values(&density.spectral_density(0, &[0.0, 1.0, 3.0])?));
    let modes = density.relaxation(4)?;
    let [rates, frequencies] =
        [0, 1].map(|k| modes.iter().map(|mode| [mode.rate, mode.frequency][k]).collect::<Vec<_>>());
    pins.all("rates", EDGES, &rates);
    pins.all("frequencies", EDGES, &frequencies);
    Ok(())
}

fn values(estimates: &[expoly::Estimate]) -> Vec<f64> {
    estimates.iter().map(|estimate| estimate.value).collect()
}
