//! What is asked of a density, whichever method it is of: statistics and comparisons.

use super::simulation::small;
use super::{Group, HALVINGS, OPTIMA, Pins, SUMS};
use crate::common::{chain_of_two, cubic_damping, duffing, duffing_above, problem, three_wells};
use expoly::models::Solved;
use expoly::statistics::{Crossings, Cumulants, Impacts, Marginal, energy_balance, entropy, modes, samples};
use expoly::{Closure, Crossing, Density, ExpPolynomial, Gaussian, Grid, Polynomial, Result, Support, compare};
use nalgebra::{dmatrix, dvector};

pub(super) const GROUPS: &[Group] = &[
    ("distances", distances),
    ("statistics of a grid", of_a_grid),
    ("statistics of an exact density", of_an_exact_density),
    ("statistics above a wall", above_a_wall),
    ("statistics of a simulation", of_a_simulation),
    ("statistics of a chain", of_a_chain),
    ("samples", drawn),
];

fn marginal(pins: &mut Pins, share: f64, density: &dyn Density) -> Result<()> {
    let marginal = Marginal::new(density, 0)?;
    pins.all("marginal", share, &[marginal.pdf(0.3)?.value, marginal.distribution(0.3)?.value]);
    pins.estimates("exceedance", share, &[marginal.exceedance(1.0)?]);
    // Where a level is exceeded so often, by a search on a curve.
    pins.all("quantiles", OPTIMA, &[marginal.quantile(0.3)?.value, marginal.upper_quantile(0.02)?.value]);
    pins.all("range", share, &marginal.range());
    Ok(())
}

fn cumulants(pins: &mut Pins, share: f64, density: &dyn Density) -> Result<()> {
    let found = Cumulants::new(density, 0)?;
    pins.all(
        "cumulants",
        share,
        &[found.mean, found.variance, found.third, found.fourth].map(|cumulant| cumulant.value),
    );
    pins.all("skewness and kurtosis", share, &[found.skewness().value, found.kurtosis().value]);
    Ok(())
}

fn crossings(pins: &mut Pins, share: f64, density: &dyn Density) -> Result<()> {
    let crossings = Crossings::new(density, [0, 1])?;
    pins.estimates("rates", share, &[crossings.rate(0.3)?, crossings.rate(1.2)?]);
    pins.all(
        "peaks and passages",
        share,
        &[crossings.peak_exceedance(1.2)?.value, crossings.first_passage(1.2, 5.0)?.value],
    );
    let maximum = crossings.maximum(5.0)?;
    let numbers = [maximum.exceedance(1.2)?, maximum.quantile(0.9)?, maximum.mean()].map(|number| number.value);
    pins.all("maximum", OPTIMA, &numbers);
    Ok(())
}

fn three_wells_exact() -> Result<ExpPolynomial> {
    three_wells().exact()
}

fn of_an_exact_density(pins: &mut Pins) -> Result<()> {
    let density = three_wells_exact()?;
    pins.density("p", SUMS, &density, [&[0.2, 0.3], &[0.6, -0.9]])?;
    marginal(pins, SUMS, &density)?;
    cumulants(pins, SUMS, &density)?;
    crossings(pins, SUMS, &density)?;
    let peaks = modes(&density)?;
    pins.all("modes", 1e-6, &peaks.iter().map(|(place, _)| place[0].abs()).collect::<Vec<_>>());
    pins.all("heights", OPTIMA, &peaks.iter().map(|(_, height)| *height).collect::<Vec<_>>());
    let humps = Marginal::new(&density, 0)?.modes();
    pins.all("humps", 1e-6, &humps.iter().map(|(place, _)| place.abs()).collect::<Vec<_>>());
    pins.all("entropy", SUMS, &[entropy(&density)?.value, density.log_mass().value]);
    let flux = Crossing { displacement: 0, velocity: 1, level: 0.5, upward: false };
    pins.all("flux", SUMS, &[density.flux(flux, 0)?.value, density.flux(flux, 2)?.value]);
    pins.within("balance", SUMS, &[energy_balance(&three_wells().problem()?, &density)?.value]);
    Ok(())
}

fn of_a_grid(pins: &mut Pins) -> Result<()> {
    let problem = problem(cubic_damping());
    let density = Grid::new().accuracy(1e-3).solve(&problem)?;
    marginal(pins, SUMS, &density)?;
    cumulants(pins, SUMS, &density)?;
    crossings(pins, SUMS, &density)?;
    pins.all("entropy", SUMS, &[entropy(&density)?.value]);
    pins.within("balance", OPTIMA, &[energy_balance(&problem, &density)?.value]);
    Ok(())
}

fn above_a_wall(pins: &mut Pins) -> Result<()> {
    let (problem, density) = (duffing_above(-0.5, 1.0), duffing().exact_above(-0.5)?);
    let impacts = Impacts::new(&density, &problem)?;
    pins.all("impacts", SUMS, &[impacts.rate().value, impacts.mean_speed().value, impacts.mean_square_speed().value]);
    pins.all("speeds", SUMS, &[impacts.speed_pdf(0.6)?.value, impacts.speed_exceedance(1.0)?.value]);
    let lossy = Impacts::new(&density, &duffing_above(-0.5, 0.8))?;
    pins.all("losses", SUMS, &[lossy.energy_loss().value, lossy.power().value]);
    marginal(pins, SUMS, &density)
}

fn of_a_simulation(pins: &mut Pins) -> Result<()> {
    let found = small().levels([0.3, 1.2]).run(&problem(cubic_damping()))?;
    cumulants(pins, SUMS, &found)?;
    let marginal = Marginal::new(&found, 0)?;
    pins.estimates("distribution", SUMS, &[marginal.distribution(0.3)?, marginal.exceedance(1.0)?]);
    pins.estimates("quantile", OPTIMA, &[marginal.quantile(0.3)?]);
    pins.one("entropy", SUMS, entropy(&found)?.value);
    pins.one("histogram", SUMS, compare::with_histogram(&duffing().exact()?, 0, found.histogram(0)?)?.l1);
    Ok(())
}

fn of_a_chain(pins: &mut Pins) -> Result<()> {
    let exact = chain_of_two().exact()?;
    cumulants(pins, SUMS, &exact)?;
    let pair = exact.joint_marginal([0, 2], [0.2, 0.1])?.value;
    pins.all("pair and marginal", SUMS, &[pair, exact.marginal(1, 0.3)?.value, exact.upcrossing_rate(0.4)?.value]);
    Ok(())
}

/// Of a density without a symmetry, whose cells are halved in an order that no rounding changes.
fn drawn(pins: &mut Pins) -> Result<()> {
    let terms = [([2, 0], -0.5), ([1, 1], -0.3), ([0, 2], -0.7), ([1, 0], 0.4), ([0, 1], 0.1), ([4, 0], -0.1)];
    let scale = Gaussian { mean: dvector![0.3, 0.0], covariance: dmatrix![0.7, 0.0; 0.0, 0.7] };
    let density = ExpPolynomial::from_states(&Polynomial::from_terms(2, terms)?, &scale, Support::WholeSpace)?;
    let (states, share) = samples(&density, 2000, 5)?;
    pins.one("sum of squares", OPTIMA, states.values().iter().map(|x| x * x).sum());
    pins.all("first", OPTIMA, &states[0]);
    pins.within("share", OPTIMA, &[share.unwrap_or(1.0)]);
    Ok(())
}

fn distances(pins: &mut Pins) -> Result<()> {
    let (exact, other) = (duffing().exact()?, Closure::classical(4).solve(&problem(cubic_damping()))?.density()?);
    let found = compare::distances(&other, &exact)?;
    pins.all("exact", HALVINGS, &[found.l1.value, found.hellinger.value, found.kullback_leibler.value]);
    pins.estimates("decades", HALVINGS, &[compare::log_ratio(&other, &exact, 1e-3)?]);
    let grid = Grid::new().accuracy(1e-3).solve(&problem(cubic_damping()))?;
    pins.one("from a grid", HALVINGS, compare::l1(&other, &grid)?.value);
    let states = small().trajectories(128).samples(2560).states(&problem(cubic_damping()))?;
    pins.estimates("at least", SUMS, &[compare::l1_at_least(&other, &grid, &states, 128)?]);
    Ok(())
}
