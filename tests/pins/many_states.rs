//! The closure in three states and four, on the pilot's states and by equations on a lattice; next to walls; its derivatives.

use super::closure::derivative;
use super::{Group, OPTIMA, Pins};
use crate::closure::walls_in_many_states::BODIES;
use crate::common::{chain_of_two, duffing};
use crate::simulation::walls::{Room, with_walls};
use expoly::models::{FilteredDuffing, Solved};
use expoly::statistics::Impacts;
use expoly::{Closure, ClosureDensity, Density, Problem, Reference, Result, Sensitivity, Wall, compare};

pub(super) const GROUPS: &[Group] = &[
    ("closure by a reference in three states", by_a_reference),
    ("closure on a thin sheet", on_a_thin_sheet),
    ("closure with a wall between two bodies", between_two_bodies),
    ("closure behind a filter above a wall", behind_a_filter_above_a_wall),
    ("closure of a chain", of_a_chain),
    ("closure behind a filter", behind_a_filter),
];

const STATES: usize = 2048;
const THREE: [&[f64]; 2] = [&[0.2, 0.3, -0.1], &[0.6, -0.9, 0.2]];
const FOUR: [&[f64]; 2] = [&[0.2, 0.3, -0.1, 0.2], &[0.6, -0.5, 0.4, 0.1]];

fn closure(order: u32) -> Closure {
    Closure::new(order).pilot_states(STATES)
}

fn filtered() -> Result<Problem> {
    FilteredDuffing::first_order(duffing(), 2.0)?.problem()
}

fn pin(pins: &mut Pins, density: &ClosureDensity, places: [&[f64]; 2]) -> Result<()> {
    pins.density("p", OPTIMA, density, places)?;
    pins.one("L1", OPTIMA, density.l1_estimate());
    pins.all(
        "crossings and pair",
        OPTIMA,
        &[density.upcrossing_rate(0.4)?.value, density.joint_marginal([0, 2], [0.2, 0.1])?.value],
    );
    Ok(())
}

fn behind_a_filter(pins: &mut Pins) -> Result<()> {
    let problem = filtered()?;
    let [low, high] = [2, 4].map(|order| closure(order).solve(&problem));
    let (low, high) = (low?, high?);
    pin(pins, &low, THREE)?;
    pins.density("order 4", OPTIMA, &high, THREE)?;
    pins.all("distance", OPTIMA, &[compare::l1(&low, &high)?.value, compare::log_ratio(&low, &high, 1e-2)?.value]);
    derivative(pins, OPTIMA, &low.sensitivity("D")?)
}

fn of_a_chain(pins: &mut Pins) -> Result<()> {
    pin(pins, &closure(2).solve(&chain_of_two().problem()?)?, FOUR)
}

/// A hardening spring in a bath with memory, whose equations are solved on a lattice.
fn by_a_reference(pins: &mut Pins) -> Result<()> {
    let drift = "drift.x = 'v'\ndrift.v = '-x - 0.2*x^3 + z'\ndrift.z = '-v - z'\nnoise.w.z = '1'";
    let problem = Problem::from_toml(&format!("states = ['x', 'v', 'z']\n{drift}"))?;
    let density = closure(2).reference(Reference::Equations).solve(&problem)?;
    pin(pins, &density, THREE)
}

/// A voltage that nearly follows displacement and velocity.
fn on_a_thin_sheet(pins: &mut Pins) -> Result<()> {
    let problem = Problem::from_toml(include_str!("../cases/harvester-bistable.toml"))?;
    let density = closure(2).solve(&problem)?;
    pins.density("p", OPTIMA, &density, [&[0.2, 3.0, 0.1], &[0.5, -5.0, -0.3]])?;
    pins.one("L1", OPTIMA, density.l1_estimate());
    Ok(())
}

fn impacts(pins: &mut Pins, density: &ClosureDensity, problem: &Problem) -> Result<()> {
    for wall in 0..problem.walls().len() {
        let impacts = Impacts::at(density, problem, wall)?;
        pins.estimates(&format!("impacts on {wall}"), OPTIMA, &[impacts.rate(), impacts.mean_speed(), impacts.power()]);
    }
    Ok(())
}

/// With white noise beside that of the filter.
fn coloured() -> Result<Problem> {
    let drift = "drift.x = 'v'\ndrift.v = 'z - c*v - x - 0.5*x^3'\ndrift.z = '-z'\nnoise.w.z = '1'\nnoise.u.v = '0.4'";
    let problem = Problem::from_toml(&format!("states = ['x', 'v', 'z']\n{drift}\nparameters.c = 0.2"))?;
    problem.with_wall(Wall::above(-0.3, 0.8)?)
}

fn behind_a_filter_above_a_wall(pins: &mut Pins) -> Result<()> {
    let problem = coloured()?;
    let density = closure(2).solve(&problem)?;
    pin(pins, &density, THREE)?;
    impacts(pins, &density, &problem)?;
    let by = density.sensitivity("x.above.restitution")?;
    derivative(pins, OPTIMA, &by)?;
    pins.estimates("derivative of the impacts", OPTIMA, &[by.impact_rate().unwrap()]);
    Ok(())
}

/// Two bodies that hit each other.
fn between_two_bodies(pins: &mut Pins) -> Result<()> {
    let open = Room { own: [Room::OPEN; 2], difference: Room::OPEN };
    let against_each_other = Room { difference: [-0.4, Room::OPEN[1]], ..open };
    let problem = with_walls(Problem::of(BODIES)?, &against_each_other.walls(0.8, BODIES.masses)?)?;
    let density = closure(2).solve(&problem)?;
    pins.density("p", OPTIMA, &density, FOUR)?;
    impacts(pins, &density, &problem)
}
