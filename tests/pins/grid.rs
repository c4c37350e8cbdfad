//! The grid: stationary densities, their derivatives and modes, densities in time, and the survival of levels.

use super::{Group, HALVINGS, OPTIMA, Pins, SUMS};
use crate::common::moving::{Noisy, correlated, normal, two_wells};
use crate::common::{OrnsteinUhlenbeck, between, duffing, duffing_above, inelastic, problem, van_der_pol};
use expoly::models::{Linear, Solved};
use expoly::{Course, Density, Envelope, Estimate, Grid, GridDensity, Problem, Result, Sensitivity, Start, Transient};

pub(super) const GROUPS: &[Group] = &[
    ("grid between walls", between_walls),
    ("grid above a wall", above_a_wall),
    ("grid in time", in_time),
    ("grid under modulated noise", under_modulated_noise),
    ("survival", survival),
    ("survival above a wall", survival_above_a_wall),
    ("derivatives on a grid", derivatives),
    ("grid of a cycle", of_a_cycle),
    ("grid of a degree", of_a_degree),
    ("relaxation on a grid", relaxation),
    ("grid in one state", in_one_state),
    ("time and survival in one state", time_in_one_state),
];

const PLACES: [&[f64]; 2] = [&[0.2, 0.3], &[0.6, -0.9]];

fn grid() -> Grid {
    Grid::new().accuracy(1e-3)
}

fn pin(pins: &mut Pins, share: f64, density: &GridDensity) -> Result<()> {
    pins.density("p", share, density, PLACES)?;
    pins.estimates("crossings", share, &[density.upcrossing_rate(0.4)?]);
    itself(pins, share, density);
    Ok(())
}

/// What the grid says of itself.
fn itself(pins: &mut Pins, share: f64, density: &GridDensity) {
    pins.one("L1", 1e3 * share, density.l1_estimate());
    pins.one("cells", SUMS, density.provenance().cells.unwrap() as f64);
}

fn of_a_cycle(pins: &mut Pins) -> Result<()> {
    pin(pins, SUMS, &grid().solve(&problem(van_der_pol()))?)
}

/// A domain and a degree that are given.
fn of_a_degree(pins: &mut Pins) -> Result<()> {
    let grid = grid().degree(5).domain([[-3.9, 3.9], [-6.2, 6.2]]);
    pin(pins, SUMS, &grid.solve(&problem(duffing()))?)
}

fn above_a_wall(pins: &mut Pins) -> Result<()> {
    let density = grid().solve(&duffing_above(-0.5, 0.8))?;
    pin(pins, HALVINGS, &density)?;
    pins.estimates("impacts", HALVINGS, &[density.impact_rate().unwrap()]);
    answers(pins, HALVINGS, &density, &["D", "x.above.offset", "x.above.restitution"])
}

fn between_walls(pins: &mut Pins) -> Result<()> {
    let density = grid().solve(&between(inelastic()))?;
    pin(pins, HALVINGS, &density)?;
    pins.estimates("impacts", HALVINGS, &[density.impact_rate().unwrap()]);
    Ok(())
}

fn in_one_state(pins: &mut Pins) -> Result<()> {
    let wells = Problem::from_toml("states = ['x']\ndrift.x = '0.1 + x - x^3'\nnoise.w.x = '0.8 + 0.1*x'")?;
    let density = grid().solve(&wells)?;
    pins.density("p", SUMS, &density, [&[0.2], &[-0.6]])?;
    itself(pins, SUMS, &density);
    pins.all("rates", OPTIMA, &density.relaxation(3)?.iter().map(|mode| mode.rate).collect::<Vec<_>>());
    Ok(())
}

fn relaxation(pins: &mut Pins) -> Result<()> {
    for (name, problem) in [("two wells", two_wells()), ("above a wall", duffing_above(-0.5, 1.0))] {
        let modes = grid().solve(&problem)?.relaxation(3)?;
        let numbers: Vec<f64> = modes.iter().flat_map(|mode| [mode.rate, mode.frequency]).collect();
        pins.all(name, OPTIMA, &numbers);
    }
    Ok(())
}

fn moments(pins: &mut Pins, what: &str, found: &[Transient<GridDensity>]) -> Result<()> {
    for (k, found) in found.iter().enumerate() {
        let moments = [[1, 0], [0, 1], [2, 0], [0, 2]].map(|powers| found.moment(&powers));
        pins.estimates(&format!("{what} {k}"), OPTIMA, &moments.into_iter().collect::<Result<Vec<_>>>()?);
        pins.all(&format!("{what} {k} steps and L1"), OPTIMA, &[found.step_error, found.density.l1_estimate()]);
    }
    Ok(())
}

fn in_time(pins: &mut Pins) -> Result<()> {
    let stationary = grid().solve(&problem(duffing()))?;
    moments(pins, "from a Gaussian", &stationary.transient(normal([1.0, 0.0], 0.3), &[0.5, 2.0], 1e-2)?)?;
    moments(pins, "from a point", &stationary.transient(Start::Point(vec![0.8, -0.5]), &[2.0], 1e-2)?)?;
    let above = grid().solve(&duffing_above(-0.5, 1.0))?;
    moments(pins, "above a wall", &above.transient(normal([1.0, 0.0], 0.3), &[1.0], 1e-2)?)
}

fn under_modulated_noise(pins: &mut Pins) -> Result<()> {
    let stationary = grid().domain([[-6.5, 6.5], [-6.5, 6.5]]).solve(&problem(Noisy { a: 0.2 }))?;
    let envelopes = [
        ("exponentials", Envelope::exponentials(1.3, 0.09, 1.49)?),
        ("table", Envelope::table([(0.0, 0.2), (1.0, 1.0), (2.5, 0.4)])?),
        ("steps", Envelope::steps([(0.0, 1.0), (0.5, 0.3)])?),
    ];
    for (name, envelope) in &envelopes {
        pins.all(&format!("{name} envelope"), SUMS, &[envelope.value(0.7), envelope.peak()]);
        moments(
            pins,
            name,
            &stationary.transient(Course::from(&correlated().0).under(envelope.clone()), &[1.0], 1e-2)?,
        )?;
    }
    Ok(())
}

fn survival(pins: &mut Pins) -> Result<()> {
    let stationary = grid().accuracy(1e-2).solve(&problem(duffing()))?;
    let below = stationary.survival([f64::NEG_INFINITY, 0.8])?;
    let rest = normal([-0.5, 0.0], 0.4);
    pins.estimates("rate", OPTIMA, &[below.rate()?]);
    pins.estimates("mean time", OPTIMA, &[below.mean_time(&rest)?, below.mean_time(&Start::Stationary)?]);
    pins.estimates("from the stationary density", OPTIMA, &below.probability(&Start::Stationary, &[0.0, 2.0], 1e-2)?);
    pins.estimates("from a Gaussian", OPTIMA, &below.probability(&rest, &[1.0], 1e-2)?);
    let fading = Envelope::steps([(0.0, 1.0), (0.5, 0.3)])?;
    pins.estimates("under fading noise", OPTIMA, &below.probability(Course::from(&rest).under(fading), &[1.0], 1e-2)?);
    Ok(())
}

fn survival_above_a_wall(pins: &mut Pins) -> Result<()> {
    let below = grid().solve(&duffing_above(-0.5, 1.0))?.survival([f64::NEG_INFINITY, 1.0])?;
    pins.estimates("rate", OPTIMA, &[below.rate()?]);
    pins.estimates("probability", OPTIMA, &below.probability(&Start::Stationary, &[0.0, 1.0], 1e-2)?);
    Ok(())
}

fn time_in_one_state(pins: &mut Pins) -> Result<()> {
    let density = grid().solve(&problem(OrnsteinUhlenbeck))?;
    let found = density.transient(Start::Point(vec![1.5]), &[0.5, 2.0], 1e-3)?;
    let moments: Vec<Estimate> = found.iter().map(|found| found.moment(&[2])).collect::<Result<_>>()?;
    pins.estimates("square", OPTIMA, &moments);
    let below = density.survival([f64::NEG_INFINITY, 1.0])?;
    pins.estimates("survival", OPTIMA, &[below.rate()?, below.mean_time(&Start::Stationary)?]);
    Ok(())
}

fn answers(pins: &mut Pins, share: f64, density: &GridDensity, names: &[&str]) -> Result<()> {
    for by in density.sensitivities(names)? {
        let name = by.parameter();
        pins.estimates(
            &format!("by {name} moments"),
            share,
            &[by.moment(&[1, 0])?, by.moment(&[2, 0])?, by.moment(&[0, 2])?],
        );
        let others = [by.exceedance(0, 0.5)?, by.marginal(0, 0.5)?, by.upcrossing_rate(0.4)?, by.pdf(PLACES[0])?];
        pins.all(&format!("by {name} answers"), share, &others.map(|answer| answer.value));
        pins.all(&format!("by {name} size"), share, &[by.relative(PLACES[0])?, by.size(), by.l1_estimate()]);
        if let Some(rate) = by.impact_rate() {
            pins.estimates(&format!("by {name} impacts"), share, &[rate]);
        }
    }
    Ok(())
}

fn derivatives(pins: &mut Pins) -> Result<()> {
    answers(pins, OPTIMA, &grid().solve(&duffing().problem()?)?, &["c", "mu", "D"])?;
    let line = grid().solve(&Problem::parametric(Linear::new(0.5, 1.0, 0.5)?)?)?;
    pins.all("linear", OPTIMA, &[line.sensitivities(&["k"])?[0].moment(&[2, 0])?.value]);
    Ok(())
}
