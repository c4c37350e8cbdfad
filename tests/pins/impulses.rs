//! Poisson impulses: simulation, closures and their derivatives.

use super::{Group, OPTIMA, Pins, SUMS, simulation};
use crate::simulation::impulses::{laws, struck};
use expoly::{Closure, Density, Gaussian, Problem, Result, Sensitivity, Start, Wall};
use nalgebra::{dmatrix, dvector};

pub(super) const GROUPS: &[Group] = &[
    ("closure under impulses", closure),
    ("derivatives under impulses", derivatives),
    ("simulation under impulses", simulated),
    ("simulation under weak impulses", weak),
    ("simulation of walls under impulses", walls),
];

fn closure(pins: &mut Pins) -> Result<()> {
    let [_, normal, exponential, ..] = laws(5.0, 0.2);
    for (name, impulses) in [("normal", normal), ("exponential", exponential)] {
        let density = Closure::new(4).pilot_states(5120).solve(&struck(0.3, &[impulses]))?;
        pins.density(name, OPTIMA, &density, [&[0.2, 0.3], &[0.6, -0.9]])?;
        pins.one(&format!("{name} L1"), OPTIMA, density.l1_estimate());
    }
    let start = Gaussian { mean: dvector![0.5, 0.0], covariance: dmatrix![0.2, 0.0; 0.0, 0.2] };
    let found =
        Closure::new(4).pilot_states(5120).transient(&struck(0.3, &[normal]), Start::Gaussian(start), &[2.0])?;
    pins.estimates("in time", OPTIMA, &[found[0].moment(&[2, 0])?, found[0].moment(&[0, 2])?]);
    Ok(())
}

fn derivatives(pins: &mut Pins) -> Result<()> {
    let text = "states = ['x', 'v']\ndrift.x = 'v'\ndrift.v = '-x - c*v - 0.3*x^3'\nnoise.w.v = '0.3'\n\
        [parameters]\nc = 0.2\nl = 5.0\ns = 0.3\n[impulse.hail]\nrate = \"l\"\namplitude = { normal = { mean = 0.0, deviation = \"s\" } }\nv = 1\n";
    let problem = Problem::from_toml(text)?;
    let density = Closure::new(4).pilot_states(5120).solve(&problem)?;
    let names: Vec<&str> = problem.parameters().iter().map(|(name, _)| name.as_str()).collect();
    for by in density.sensitivities(&names)? {
        let name = by.parameter();
        pins.estimates(&format!("by {name}"), OPTIMA, &[by.moment(&[2, 0])?, by.moment(&[0, 2])?]);
    }
    Ok(())
}

/// Two laws at once.
fn simulated(pins: &mut Pins) -> Result<()> {
    let [_, _, exponential, _, two_point, _] = laws(1.0, 0.2);
    simulation::pin(pins, &simulation::small().run(&struck(0.3, &[exponential, two_point]))?)
}

/// Many in a time step.
fn weak(pins: &mut Pins) -> Result<()> {
    let [normal, _, _, uniform, _, laplace] = laws(20.0, 0.1);
    let found = simulation::small().run(&struck(0.3, &[normal, uniform, laplace]))?;
    pins.estimates("moments", SUMS, &[found.mean(0)?, found.moment(&[2, 0])?, found.moment(&[0, 2])?]);
    Ok(())
}

fn walls(pins: &mut Pins) -> Result<()> {
    let problem = struck(0.3, &laws(2.0, 0.1)[4..5]).with_wall(Wall::above(-0.5, 0.9)?)?;
    let found = simulation::small().run(&problem)?;
    pins.estimates("moments", SUMS, &[found.mean(0)?, found.moment(&[2, 0])?, found.moment(&[0, 2])?]);
    simulation::impacts(pins, &found, &problem)
}
