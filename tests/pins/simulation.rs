//! The simulation: all that it measures, next to walls as well, and rare states by splitting.

use super::{Group, OPTIMA, Pins, SUMS};
use crate::common::{OrnsteinUhlenbeck, cubic_damping, problem};
use crate::simulation::walls::{Bodies, Room, with_walls};
use expoly::models::{Duffing, FilteredDuffing, Linear};
use expoly::statistics::Impacts;
use expoly::{
    Density, Estimate, Gaussian, Histogram, Problem, Result, SimulatedDensity, Simulation, Splitting, Start, Tolerance,
    Wall,
};
use nalgebra::{dmatrix, dvector};

pub(super) const GROUPS: &[Group] = &[
    ("simulation", calibrated),
    ("simulation by counting alone", by_counting),
    ("simulation of spectra and passages", of_spectra_and_passages),
    ("simulation of one state", of_one_state),
    ("simulation above a wall", above_a_wall),
    ("simulation between two bodies", between_two_bodies),
    ("simulation at rest", at_rest),
    ("simulation in time", in_time),
    ("simulation in parts", in_parts),
    ("simulation to a precision", to_a_precision),
    ("states of a simulation", states),
    ("splitting", splitting),
    ("splitting of one state", splitting_of_one_state),
];

/// As many as make twenty of each trajectory.
pub(super) fn small<'a>() -> Simulation<'a> {
    Simulation::new().samples(20_480).seed(3)
}

/// What every simulation of two states has.
pub(super) fn pin(pins: &mut Pins, found: &SimulatedDensity) -> Result<()> {
    pins.density("p", SUMS, found, [&[0.2, 0.3], &[0.6, -0.9]])?;
    pins.estimates("shape", SUMS, &[found.skewness(0)?, found.kurtosis(0)?, found.kurtosis(1)?]);
    pins.estimates("mixed", SUMS, &[found.mean(1)?, found.moment(&[1, 1])?, found.moment(&[2, 2])?]);
    pins.within("balance", SUMS, &found.energy_balance().iter().flat_map(|b| [b.value, b.error]).collect::<Vec<_>>());
    pins.all("drift", OPTIMA, &found.stationarity());
    Ok(())
}

/// The times that were chosen, and how calibration went.
fn chosen(pins: &mut Pins, found: &SimulatedDensity) {
    let made = found.provenance();
    pins.all("times", SUMS, &[made.time_step, made.burn_in, made.sampling_interval].map(Option::unwrap));
    let degree = made.calibration_degree.map_or(0.0, f64::from);
    pins.within("calibration", SUMS, &[degree, made.weight_deviation.unwrap_or(0.0)]);
    pins.within("steps", 0.0, &[made.path_steps.unwrap() as f64]);
}

fn calibrated(pins: &mut Pins) -> Result<()> {
    let found = small().levels([0.0, 1.0]).moments([[0, 6], [3, 2]]).bins(32).run(&problem(cubic_damping()))?;
    pin(pins, &found)?;
    chosen(pins, &found);
    pins.estimates("high moments", SUMS, &[found.moment(&[0, 6])?, found.moment(&[3, 2])?]);
    pins.estimates("crossings", SUMS, &[found.upcrossing_rate(0.0)?, found.upcrossing_rate(1.0)?]);
    histogram(pins, "displacement", found.histogram(0)?)?;
    let joint = found.joint([0, 1])?;
    pins.estimates("joint", SUMS, &[joint.cell(&[8, 7])?, joint.density_at(&[0.3, -0.4])?]);
    pins.estimates("mean of a function", SUMS, &[found.variance(0)?]);
    Ok(())
}

fn histogram(pins: &mut Pins, what: &str, histogram: &Histogram) -> Result<()> {
    let (bins, edges) = (histogram.len(), histogram.edges(0).collect::<Vec<_>>());
    pins.estimates(&format!("{what} bins"), SUMS, &[histogram.bin(bins / 3)?, histogram.bin(bins / 2)?]);
    pins.all(&format!("{what} range"), SUMS, &[edges[0], edges[bins]]);
    pins.within(&format!("{what} counts"), 0.0, &[histogram.samples() as f64, histogram.outliers() as f64]);
    Ok(())
}

fn by_counting(pins: &mut Pins) -> Result<()> {
    let found = small().control_variates(false).levels([0.5]).run(&problem(cubic_damping()))?;
    pin(pins, &found)?;
    chosen(pins, &found);
    pins.estimates("crossings", SUMS, &[found.upcrossing_rate(0.5)?]);
    Ok(())
}

fn of_spectra_and_passages(pins: &mut Pins) -> Result<()> {
    let simulation = small().trajectories(256).samples(256 * 80).sampling_interval(0.4).time_step(0.04).burn_in(5.0);
    let simulation = simulation.spectrum(0, 32).spectrum(1, 48).first_passage(0.8, 4.0, 2).first_passage(1.5, 8.0, 4);
    let found = simulation.run(&problem(Linear::new(0.5, 2.0, 0.3)?))?;
    for state in [0, 1] {
        let spectrum = found.spectrum(state)?;
        pins.estimates(&format!("density of {state}"), SUMS, &[spectrum.density(1)?, spectrum.density(3)?]);
        let lags = [spectrum.autocovariance(0)?, spectrum.autocovariance(4)?];
        pins.estimates(&format!("autocovariance of {state}"), SUMS, &lags);
        pins.one(&format!("frequencies of {state}"), SUMS, spectrum.frequencies().sum());
    }
    for level in [0.8, 1.5] {
        let passage = found.first_passage(level)?;
        let distribution: Vec<Estimate> = passage.distribution().into_iter().map(|(_, p)| p).take(3).collect();
        pins.estimates(&format!("passages of {level}"), SUMS, &distribution);
        pins.estimates(&format!("times to {level}"), SUMS, &[passage.restricted_mean(), passage.extrapolated_mean()]);
    }
    Ok(())
}

fn of_one_state(pins: &mut Pins) -> Result<()> {
    let found = small().run(&problem(OrnsteinUhlenbeck))?;
    pins.density("p", SUMS, &found, [&[0.2], &[-0.6]])?;
    pins.estimates("kurtosis", SUMS, &[found.kurtosis(0)?]);
    Ok(())
}

/// Impacts at each wall, and all of them together.
pub(super) fn impacts(pins: &mut Pins, found: &SimulatedDensity, problem: &Problem) -> Result<()> {
    pins.estimates("all impacts", SUMS, &[found.impact_rate().unwrap(), found.mean_impact_speed().unwrap()]);
    for wall in 0..problem.walls().len() {
        let impacts = Impacts::at(found, problem, wall)?;
        pins.estimates(&format!("impacts on {wall}"), SUMS, &[impacts.rate()]);
        pins.all(
            &format!("squares and power on {wall}"),
            SUMS,
            &[impacts.mean_square_speed().value, impacts.power().value],
        );
        pins.estimates(&format!("speeds on {wall}"), SUMS, &[impacts.speed_exceedance(1.0)?]);
    }
    Ok(())
}

fn above_a_wall(pins: &mut Pins) -> Result<()> {
    let problem = problem(cubic_damping()).with_wall(Wall::above(-0.5, 0.8)?)?.with_wall(Wall::below(1.5, 0.9)?)?;
    let found = small().levels([0.4]).run(&problem)?;
    pin(pins, &found)?;
    chosen(pins, &found);
    impacts(pins, &found, &problem)?;
    pins.estimates("crossings", SUMS, &[found.upcrossing_rate(0.4)?]);
    histogram(pins, "speeds", &found.impact_speeds().unwrap())
}

/// Walls on one of two bodies and between them.
fn between_two_bodies(pins: &mut Pins) -> Result<()> {
    let bodies = Bodies::UNLIKE;
    let room = Room { own: [[-0.3, 7.0], [-7.0, 7.0]], difference: [-0.5, 0.8] };
    let problem = with_walls(Problem::of(bodies)?, &room.walls(0.8, bodies.masses)?)?;
    let found = small().run(&problem)?;
    let moments = [[2, 0, 0, 0], [1, 1, 0, 0], [0, 0, 2, 0], [0, 0, 0, 2]].map(|powers| found.moment(&powers));
    pins.estimates("moments", SUMS, &moments.into_iter().collect::<Result<Vec<_>>>()?);
    pins.within("balance", SUMS, &found.energy_balance().iter().map(|balance| balance.value).collect::<Vec<_>>());
    impacts(pins, &found, &problem)
}

/// No white noise drives the oscillator off its wall.
fn at_rest(pins: &mut Pins) -> Result<()> {
    let filtered = FilteredDuffing::first_order(Duffing::new(0.2, 1.0, 0.3, 0.3)?, 2.0)?.problem()?;
    let problem = filtered.with_wall(Wall::above(0.5, 0.6)?)?;
    let found = small().samples(5120).burn_in(10.0).run(&problem)?;
    pins.estimates("rest and chatters", SUMS, &[found.time_at_rest(0)?, found.complete_chatters(0)?]);
    pins.estimates("moments", SUMS, &[found.mean(0)?, found.moment(&[0, 2, 0])?]);
    impacts(pins, &found, &problem)
}

fn in_time(pins: &mut Pins) -> Result<()> {
    let start = Gaussian { mean: dvector![0.8, 0.0], covariance: dmatrix![0.1, 0.02; 0.02, 0.2] };
    for (name, start) in [("point", Start::Point(vec![0.8, 0.1])), ("Gaussian", Start::Gaussian(start))] {
        let found = small().trajectories(4096).transient(&problem(cubic_damping()), start, &[2.0])?.remove(0);
        let moments = [[1, 0], [0, 1], [2, 0], [0, 2]].map(|powers| found.moment(&powers));
        pins.estimates(name, SUMS, &moments.into_iter().collect::<Result<Vec<_>>>()?);
    }
    Ok(())
}

fn in_parts(pins: &mut Pins) -> Result<()> {
    let part = |k: usize| small().part(k + 1, 2).run(&problem(cubic_damping()));
    let (first, second) = (part(0)?, part(1)?);
    pins.estimates("first part", SUMS, &[first.moment(&[2, 0])?]);
    pins.estimates("both", SUMS, &[SimulatedDensity::merge([second, first])?.moment(&[2, 0])?]);
    Ok(())
}

fn to_a_precision(pins: &mut Pins) -> Result<()> {
    let simulation = small().control_variates(false).until(Tolerance::Relative(0.03), |found| found.moment(&[2, 0]));
    let found = simulation.run(&problem(cubic_damping()))?;
    pins.within("samples", 0.0, &[found.provenance().samples.unwrap() as f64]);
    pins.estimates("square", SUMS, &[found.moment(&[2, 0])?]);
    Ok(())
}

fn states(pins: &mut Pins) -> Result<()> {
    let states = small().trajectories(100).samples(2000).states(&problem(cubic_damping()))?;
    pins.within("count", 0.0, &[states.len() as f64]);
    pins.all("last", SUMS, &states[states.len() - 1]);
    pins.one("sum of squares", SUMS, states.values().iter().map(|x| x * x).sum());
    Ok(())
}

fn splitting(pins: &mut Pins) -> Result<()> {
    let splitting = Splitting::new().levels([0.0, 2.0, 3.0]).levels_of(1, [3.0]).particles(4).replicas(16).seed(1);
    let tails = splitting.relaxation(10.0).duration(5.0).time_step(0.05).run(&problem(cubic_damping()))?;
    for level in [0.0, 2.0, 3.0] {
        pins.estimates(&format!("density at {level}"), SUMS, &[tails.marginal(0, level)?]);
        pins.estimates(&format!("crossings of {level}"), SUMS, &[tails.upcrossing_rate(level)?]);
    }
    pins.estimates("beyond", SUMS, &[tails.exceedance(1, 3.0)?, tails.non_exceedance(0, 0.0)?]);
    pins.one("stationarity", OPTIMA, tails.stationarity());
    Ok(())
}

fn splitting_of_one_state(pins: &mut Pins) -> Result<()> {
    let splitting = Splitting::new().importance(|x| x[0]).levels([0.0, 3.0]).particles(4).replicas(16).rarest(1e-4);
    let tails = splitting.relaxation(5.0).duration(5.0).resampling_interval(0.05).run(&problem(OrnsteinUhlenbeck))?;
    pins.estimates("density", SUMS, &[tails.marginal(0, 0.0)?, tails.marginal(0, 3.0)?]);
    pins.estimates("beyond", SUMS, &[tails.exceedance(0, 3.0)?]);
    Ok(())
}
