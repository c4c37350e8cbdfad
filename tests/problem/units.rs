//! A change of units, x = αX and t = βT, changes nothing but the units, by any method and over twelve decades.

use expoly::models::{Duffing, Solved};
use expoly::{Closure, Crossing, Density, Estimate, Grid, Problem, Result, Simulation, Splitting, Wall};

/// The units α of length and β of time.
const UNITS: [[f64; 2]; 4] = [[1e6, 1.0], [1e-6, 1.0], [1.0, 1e6], [1e-6, 1e-6]];

/// x″ + c x′ + k x + μ x³ = ξ in other units: c β, k β², μ α²β², D β³/α².
fn duffing([length, time]: [f64; 2]) -> Result<Problem> {
    let (c, k, mu, d) = (0.2, 1.0, 0.3, 0.2);
    let square = time * time;
    Duffing::new(c * time, k * square, mu * length * length * square, d * time * square / (length * length))?.problem()
}

fn above(problem: Problem, [length, _]: [f64; 2]) -> Result<Problem> {
    problem.with_wall(Wall::above(-0.5 / length, 0.8)?)
}

/// Moments, a density and a rate, in the units of α = β = 1.
fn answers(density: &dyn Density, [length, time]: [f64; 2]) -> Result<[Estimate; 4]> {
    let speed = length / time;
    Ok([
        density.moment(&[2, 0])?.scaled(length * length),
        density.moment(&[0, 4])?.scaled(speed.powi(4)),
        density.marginal(0, 0.3 / length)?.scaled(1.0 / length),
        density.flux(Crossing::upward(0.7 / length), 1)?.scaled(1.0 / time),
    ])
}

type Answer = Result<Box<dyn Density>>;

/// The largest relative change of any of them.
fn change(method: &dyn Fn(&Problem, [f64; 2]) -> Answer, walled: bool) -> Result<f64> {
    let found = |units: [f64; 2]| {
        let problem = duffing(units)?;
        let problem = if walled { above(problem, units)? } else { problem };
        answers(&*method(&problem, units)?, units)
    };
    let plain = found([1.0; 2])?;
    let mut largest = 0.0_f64;
    for units in UNITS {
        for (other, one) in found(units)?.iter().zip(&plain) {
            largest = largest.max((other.value / one.value - 1.0).abs());
        }
    }
    Ok(largest)
}

#[test]
fn a_closure_is_the_same_in_all_units() -> Result<()> {
    let closure = |problem: &Problem, _| Ok(Box::new(Closure::new(4).solve(problem)?) as Box<dyn Density>);
    // Measured: 1e-14, and 3e-9 above a wall, where the equations are ill-conditioned.
    for (walled, most) in [(false, 1e-12), (true, 2e-8)] {
        let change = change(&closure, walled)?;
        println!("wall {walled}: {change:.1e}");
        assert!(change < most, "{change}");
    }
    Ok(())
}

#[test]
fn a_grid_is_the_same_in_all_units() -> Result<()> {
    let grid = |problem: &Problem, _| Ok(Box::new(Grid::new().accuracy(1e-4).solve(problem)?) as Box<dyn Density>);
    let change = change(&grid, false)?;
    println!("grid: {change:.1e}");
    assert!(change < 1e-12, "{change}");
    Ok(())
}

#[test]
fn a_simulation_is_the_same_in_all_units() -> Result<()> {
    let simulation = |problem: &Problem, [length, _]: [f64; 2]| {
        let simulation = Simulation::new().samples(20_000).levels([0.7 / length]);
        Ok(Box::new(simulation.run(problem)?) as Box<dyn Density>)
    };
    for walled in [false, true] {
        let change = change(&simulation, walled)?;
        println!("simulation, wall {walled}: {change:.1e}");
        assert!(change < 1e-11, "{change}");
    }
    Ok(())
}

#[test]
fn tails_are_the_same_in_all_units() -> Result<()> {
    let found = |units: [f64; 2]| {
        let splitting = Splitting::new().levels([2.5 / units[0]]).rarest(1e-4).particles(8).replicas(16);
        let tails = splitting.run(&duffing(units)?)?;
        Ok::<_, expoly::Error>([tails.marginal(0, 2.5 / units[0])?.value / units[0], tails.stationarity()])
    };
    let plain = found([1.0; 2])?;
    for units in UNITS {
        let other = found(units)?;
        println!("{units:?}: {plain:?} and {other:?}");
        assert!((other[0] / plain[0] - 1.0).abs() < 1e-12);
    }
    Ok(())
}
