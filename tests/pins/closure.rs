//! The closure in one state and two: stationary densities, derivatives, the literature's closure.

use super::{EDGES, Group, OPTIMA, Pins, SUMS};
use crate::common::{
    OrnsteinUhlenbeck, between, bistable, cubic_damping, duffing, duffing_above, inelastic, problem, van_der_pol,
};
use expoly::models::Solved;
use expoly::statistics::Impacts;
use expoly::{Basis, Closure, ClosureDensity, Density, Grid, Problem, Reference, Result, Sensitivity, Wall, Weight};

pub(super) const GROUPS: &[Group] = &[
    ("closure by a grid", by_a_grid),
    ("closure between walls", between_walls),
    ("closure above a wall", above_a_wall),
    ("closure below an elastic wall", below_an_elastic_wall),
    ("closure of a cycle", of_a_cycle),
    ("closure by equations", by_equations),
    ("closure by states", by_states),
    ("closure of an exact density", of_an_exact_density),
    ("closure of low order", of_low_order),
    ("closure with options", with_options),
    ("closure in one state", in_one_state),
    ("closure of a closed form", of_a_closed_form),
    ("closure fitted", fitted),
    ("derivatives of a closure", derivatives),
    ("derivatives of an exact closure", exact_derivatives),
    ("classical closure", classical),
    ("classical closure above a wall", classical_above_a_wall),
];

/// Few states, which are quickly simulated.
const STATES: usize = 5120;
const PLACES: [&[f64]; 2] = [&[0.2, 0.3], &[0.6, -0.9]];

fn pin(pins: &mut Pins, share: f64, density: &ClosureDensity) -> Result<()> {
    pins.density("p", share, density, PLACES)?;
    pins.estimates("crossings", share, &[density.upcrossing_rate(0.4)?]);
    judged(pins, share, density);
    Ok(())
}

/// What the closure says of itself; what is beyond an edge that may be a step farther is known to a factor of two.
fn judged(pins: &mut Pins, share: f64, density: &ClosureDensity) {
    pins.one("L1", 1e2 * share, density.l1_estimate());
    pins.one("indicator", 1e2 * share, density.indicator());
    pins.one("truncated", 1e4 * share, density.truncated_mass());
}

fn impacts(pins: &mut Pins, density: &ClosureDensity, problem: &Problem) -> Result<()> {
    let impacts = Impacts::at(density, problem, 0)?;
    pins.estimates("impacts", EDGES, &[density.impact_rate().unwrap(), impacts.mean_speed()]);
    pins.all("power and fast impacts", EDGES, &[impacts.power().value, impacts.speed_exceedance(0.7)?.value]);
    Ok(())
}

fn closure(order: u32) -> Closure {
    Closure::new(order).pilot_states(STATES)
}

fn of_low_order(pins: &mut Pins) -> Result<()> {
    pin(pins, OPTIMA, &closure(2).solve(&duffing().problem()?)?)
}

fn of_an_exact_density(pins: &mut Pins) -> Result<()> {
    let density = closure(6).solve(&problem(bistable()))?;
    pins.density("p", OPTIMA, &density, PLACES)?;
    pins.within("L1 and unknowns", OPTIMA, &[density.l1_estimate(), density.provenance().unknowns.unwrap() as f64]);
    Ok(())
}

fn of_a_cycle(pins: &mut Pins) -> Result<()> {
    pin(pins, EDGES, &closure(6).seed(1).solve(&problem(van_der_pol()))?)
}

fn by_equations(pins: &mut Pins) -> Result<()> {
    pin(pins, EDGES, &closure(4).reference(Reference::Equations).solve(&problem(cubic_damping()))?)
}

fn by_a_grid(pins: &mut Pins) -> Result<()> {
    pin(pins, OPTIMA, &closure(4).reference(Reference::Grid).solve(&problem(cubic_damping()))?)
}

fn by_states(pins: &mut Pins) -> Result<()> {
    let density = closure(4).reference(Reference::States).solve(&problem(cubic_damping()))?;
    pins.density("p", OPTIMA, &density, PLACES)?;
    pins.one("L1", OPTIMA, density.l1_estimate());
    Ok(())
}

/// The order that is needed, a similar density to start from, a weight without tails.
fn with_options(pins: &mut Pins) -> Result<()> {
    let problem = problem(cubic_damping());
    let needed = Closure::adaptive(0.01).pilot_states(STATES).solve(&problem)?;
    pins.all("needed order", EDGES, &[needed.l1_estimate(), needed.log_pdf(PLACES[0])?]);
    let warm = closure(4).starting_from(&needed).solve(&problem)?;
    pins.all("warm start", EDGES, &[warm.l1_estimate(), warm.log_pdf(PLACES[0])?]);
    let plain = closure(4).weight(Weight::Density).solve(&problem)?;
    pins.all("weight", EDGES, &[plain.l1_estimate(), plain.log_pdf(PLACES[0])?]);
    Ok(())
}

fn in_one_state(pins: &mut Pins) -> Result<()> {
    let wells = Problem::from_toml("states = ['x']\ndrift.x = '0.1 + x - x^3'\nnoise.w.x = '0.8'")?;
    for order in [2, 4] {
        let density = closure(order).solve(&wells)?;
        pins.density(&format!("order {order}"), OPTIMA, &density, [&[0.2], &[-0.6]])?;
        pins.within(&format!("order {order} L1"), 1e-10, &[density.l1_estimate()]);
    }
    let normal = closure(2).solve(&problem(OrnsteinUhlenbeck))?;
    pins.all("normal", OPTIMA, &[normal.moment(&[2])?.value, normal.log_pdf(&[0.5])?]);
    Ok(())
}

/// Noise that grows with the state, whose equations have no good solution.
fn of_a_closed_form(pins: &mut Pins) -> Result<()> {
    let problem = Problem::from_toml(include_str!("../cases/cubic-fat.toml"))?;
    let density = closure(4).solve(&problem)?;
    pins.density("p", OPTIMA, &density, [&[0.2], &[-0.6]])?;
    judged(pins, OPTIMA, &density);
    Ok(())
}

fn above_a_wall(pins: &mut Pins) -> Result<()> {
    let problem = duffing_above(-0.5, 0.8);
    let density = closure(4).solve(&problem)?;
    pin(pins, EDGES, &density)?;
    impacts(pins, &density, &problem)?;
    derivatives_at_a_wall(pins, &density)
}

fn below_an_elastic_wall(pins: &mut Pins) -> Result<()> {
    let problem = problem(cubic_damping()).with_wall(Wall::below(0.8, 1.0)?)?;
    let density = closure(4).solve(&problem)?;
    pin(pins, EDGES, &density)?;
    impacts(pins, &density, &problem)
}

fn between_walls(pins: &mut Pins) -> Result<()> {
    let problem = between(inelastic());
    let density = closure(2).solve(&problem)?;
    pin(pins, EDGES, &density)?;
    impacts(pins, &density, &problem)
}

fn fitted(pins: &mut Pins) -> Result<()> {
    let grid = Grid::new().accuracy(1e-3).solve(&problem(cubic_damping()))?;
    let density = Closure::new(4).fit(&grid)?;
    pins.density("p", OPTIMA, &density, PLACES)?;
    pins.one("L1", OPTIMA, density.l1_estimate());
    let line = Closure::new(4).fit(&Grid::new().accuracy(1e-3).solve(&problem(OrnsteinUhlenbeck))?)?;
    pins.all("in one state", OPTIMA, &[line.moment(&[2])?.value, line.log_pdf(&[0.5])?]);
    Ok(())
}

/// The derivatives of what is asked of a density.
pub(super) fn derivative(pins: &mut Pins, share: f64, by: &dyn Sensitivity) -> Result<()> {
    let n = by.density().dimension();
    let squares = [0, 1].map(|state| by.moment(&super::power_of(n, state, 2)).unwrap());
    let name = by.parameter();
    pins.estimates(&format!("by {name} squares"), share, &squares);
    let place = [0.2, 0.3, -0.1, 0.2];
    let others = [by.exceedance(0, 0.5)?, by.marginal(0, 0.5)?, by.upcrossing_rate(0.4)?].map(|answer| answer.value);
    pins.all(&format!("by {name} answers"), share, &others);
    pins.all(&format!("by {name} slope and size"), share, &[by.relative(&place[..n])?, by.size()]);
    Ok(())
}

fn derivatives(pins: &mut Pins) -> Result<()> {
    let model = "states = ['x', 'v']\ndrift.x = 'v'\ndrift.v = '-x - c*v - g*v^3 - x^3'\nnoise.w.v = 'sqrt(2*D)'\n";
    let problem = Problem::from_toml(&format!("{model}[parameters]\nc = 0.1\ng = 0.3\nD = 0.5"))?;
    for by in closure(4).solve(&problem)?.sensitivities(&["g", "D"])? {
        derivative(pins, EDGES, &by)?;
        pins.one(&format!("by {} L1", by.parameter()), 100.0 * EDGES, by.l1_estimate());
        let far = [by.upper_quantile(0, 0.01)?, by.first_passage(1.5, 10.0)?].map(|answer| answer.value);
        pins.all(&format!("by {} far", by.parameter()), EDGES, &far);
    }
    Ok(())
}

fn exact_derivatives(pins: &mut Pins) -> Result<()> {
    derivative(pins, OPTIMA, &closure(4).solve(&duffing().problem()?)?.sensitivity("mu")?)
}

fn derivatives_at_a_wall(pins: &mut Pins, density: &ClosureDensity) -> Result<()> {
    for by in density.sensitivities(&["D", "x.above.offset", "x.above.restitution"])? {
        derivative(pins, EDGES, &by)?;
        pins.estimates(&format!("by {} impacts", by.parameter()), EDGES, &[by.impact_rate().unwrap()]);
    }
    Ok(())
}

/// A root that is exact, and one that is not.
fn classical(pins: &mut Pins) -> Result<()> {
    for (name, problem) in [("exact", duffing().problem()?), ("cubic damping", problem(cubic_damping()))] {
        let solution = Closure::classical(4).solve(&problem)?;
        let root = solution.log_polynomial();
        pins.all(&format!("{name} root"), OPTIMA, &root.terms().map(|(_, c)| c).take(6).collect::<Vec<_>>());
        pins.density(name, OPTIMA, &solution.density()?, PLACES)?;
    }
    let none = Closure::classical(6).solve(&problem(van_der_pol()))?;
    pins.one("unknowns", SUMS, none.provenance().unknowns.unwrap() as f64);
    pins.within("without a root", 0.0, &[f64::from(u8::from(none.density().is_err()))]);
    Ok(())
}

fn classical_above_a_wall(pins: &mut Pins) -> Result<()> {
    for (name, basis, offset) in [("classical", Basis::Classical, -0.5), ("folded", Basis::Folded, -0.5)] {
        let density = Closure::classical(4).basis(basis).solve(&duffing_above(offset, 0.9))?.density()?;
        pins.density(name, OPTIMA, &density, PLACES)?;
        pins.estimates(&format!("{name} crossings"), OPTIMA, &[density.upcrossing_rate(0.4)?]);
    }
    Ok(())
}
