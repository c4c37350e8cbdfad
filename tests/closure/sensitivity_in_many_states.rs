//! Derivatives by parameters in three states and more.

use crate::common::Shared;
use expoly::models::{Duffing, DuffingChain, FilteredDuffing, Solved};
use expoly::statistics::Impacts;
use expoly::{Closure, ClosureDensity, Density, Error, Estimate, Problem, Result, Sensitivity, Wall};
use std::sync::Arc;

const TEMPERATURE: f64 = 0.8;

fn chain() -> Problem {
    DuffingChain::new(&[0.2, 0.4], 1.0, 0.5, 0.5, TEMPERATURE).unwrap().problem().unwrap()
}

/// Its density, which is exact at order 4 and is found at order 2.
fn closed(order: u32) -> Arc<ClosureDensity> {
    static SOLVED: Shared<u32, ClosureDensity> = Shared::new();
    SOLVED.get(order, || Closure::new(order).solve(&chain()).unwrap())
}

/// ∂E/∂θ of the energy of two masses by k, μ and κ, and E itself.
fn energies(x: &[f64]) -> [f64; 4] {
    let squares = x[0] * x[0] + x[2] * x[2];
    let fourth = x[0].powi(4) + x[2].powi(4);
    let apart = (x[0] - x[2]).powi(2);
    let energy = 0.5 * (x[1] * x[1] + x[3] * x[3] + squares) + 0.125 * fourth + 0.25 * apart;
    [0.5 * squares, 0.25 * fourth, 0.5 * apart, energy]
}

/// p = C exp(−E/T) is exact at order 4: the equations hold on any nodes, so that ∂ ln p/∂θ is right to rounding, 3e-13 measured.
/// The damping has no effect, since the noise is tied to it.
#[test]
fn exact_densities_have_exact_derivatives() -> Result<()> {
    let density = closed(4);
    let found = density.sensitivities(&["k", "mu", "kappa", "T", "c1"])?;
    for x in [[0.5, -0.3, 0.2, 0.9], [-1.2, 0.4, 0.8, -0.1], [0.1, 1.4, -0.9, 0.3]] {
        let energies = energies(&x);
        for (j, by) in found.iter().enumerate() {
            let along = by.relative(&x)? - by.relative(&[0.0; 4])?;
            let truth = match j {
                0..=2 => -energies[j] / TEMPERATURE,
                3 => energies[3] / TEMPERATURE.powi(2),
                _ => 0.0,
            };
            assert!((along - truth).abs() < 1e-10, "{}: {along} and {truth}", by.parameter());
        }
    }
    Ok(())
}

/// At order 2 the same density is found on the pilot's states, where functions of degree 8 hold its derivatives. Of thirteen answers
/// with their standard errors the mean square deviation is 1 ± 0.6 for independent ones; and the errors are below a tenth.
#[test]
fn derivatives_on_states_are_within_their_errors() -> Result<()> {
    let exact = closed(4).sensitivities(&["k", "mu", "kappa", "T"])?;
    let found = closed(2).sensitivities(&["k", "mu", "kappa", "T", "c1"])?;
    let mut squares = Vec::new();
    for (by, exact) in found.iter().zip(&exact) {
        for powers in [[2, 0, 0, 0], [0, 2, 0, 0], [4, 0, 0, 0]] {
            let (own, truth) = (by.moment(&powers)?, exact.moment(&powers)?);
            println!("{} {powers:?}: {own}, exact {truth}", by.parameter());
            assert!(own.error < 0.1 * truth.value.abs().max(0.05), "{own}, exact {truth}");
            squares.push(((own.value - truth.value) / own.error.hypot(truth.error)).powi(2));
        }
    }
    let none = found[4].moment(&[2, 0, 0, 0])?;
    squares.push((none.value / none.error).powi(2));
    let mean = squares.iter().sum::<f64>() / squares.len() as f64;
    println!("mean square deviation {mean:.2}");
    assert!(mean < 3.0, "{squares:?}");
    // An order too low for the derivative is reported.
    assert!(found[1].warning().is_some() && found[1].l1_estimate() > 0.1 * found[1].size());
    Ok(())
}

/// Behind a filter no closed form is known. An exceedance, a marginal density and a rate are differences of those at other
/// parameters, by the same pilot, to the noise of these: the moment's alone is some 0.01.
#[test]
fn derivatives_behind_a_filter_are_slopes() -> Result<()> {
    let problem = FilteredDuffing::first_order(Duffing::new(0.2, 1.0, 0.5, 0.5)?, 1.0)?.problem()?;
    let closure = Closure::new(4);
    let by = closure.solve(&problem)?.sensitivity("c")?;
    let at = |c: f64| closure.solve(&problem.with_parameter("c", c)?);
    let (above, below) = (at(0.23)?, at(0.17)?);
    let slope = |of: &dyn Fn(&dyn Density) -> f64| (of(&above) - of(&below)) / 0.06;
    let square = slope(&|density| density.moment(&[2, 0, 0]).unwrap().value);
    let rate = slope(&|density| density.upcrossing_rate(0.5).unwrap().value);
    let peak = slope(&|density| density.marginal(0, 0.0).unwrap().value);
    let found = [by.moment(&[2, 0, 0])?, by.upcrossing_rate(0.5)?, by.marginal(0, 0.0)?];
    for (found, (slope, tolerance)) in found.iter().zip([(square, 0.03), (rate, 0.01), (peak, 0.03)]) {
        println!("{found}, difference {slope:.4}");
        assert!((found.value - slope).abs() < tolerance, "{found} and {slope}");
    }
    Ok(())
}

/// Of p = C exp(−E/T) above an elastic wall at x₁ = b: E x₁, E x₁², E x₂², P(x₁ > 1) and the impact rate √(T/2π) p(b), by the
/// trapezoidal rule across x₂ and Simpson's in x₁, with errors below 1e-9.
fn above_elastic([k, mu, kappa, temperature, b]: [f64; 5]) -> [f64; 5] {
    const STEPS: i32 = 400;
    const END: f64 = 6.0;
    let p = |x: f64, y: f64| {
        let energy = 0.5 * k * (x * x + y * y) + 0.25 * mu * (x.powi(4) + y.powi(4)) + 0.5 * kappa * (x - y).powi(2);
        (-energy / temperature).exp()
    };
    let across = |x: f64, power: i32| -> f64 {
        let step = 2.0 * END / f64::from(STEPS);
        let at = |j: i32| -END + step * f64::from(j);
        (0..=STEPS).map(|j| step * at(j).powi(power) * p(x, at(j))).sum()
    };
    let above = |from: f64, power: i32, other: i32| -> f64 {
        let step = (END - from) / f64::from(STEPS);
        let weight = |i: i32| {
            if i == 0 || i == STEPS {
                1.0
            } else if i % 2 == 1 {
                4.0
            } else {
                2.0
            }
        };
        let part = |i: i32| {
            let x = from + step * f64::from(i);
            weight(i) * step / 3.0 * x.powi(power) * across(x, other)
        };
        (0..=STEPS).map(part).sum()
    };
    let whole = above(b, 0, 0);
    let rate = (temperature / std::f64::consts::TAU).sqrt() * across(b, 0);
    [above(b, 1, 0), above(b, 2, 0), above(b, 0, 2), above(1.0, 0, 0), rate].map(|value| value / whole)
}

const OFFSET: &str = "x1.above.offset";

/// On an eighth of the states that are taken next to walls by default.
fn next_to_walls(order: u32) -> Closure {
    Closure::new(order).pilot_states(100_000)
}

/// Above an elastic wall differences of the closed form are the truth, to 1e-7. Of 25 answers, which share the states' noise, the
/// mean square deviation is 1 ± 0.5 or so in units of their standard errors.
#[test]
fn derivatives_above_an_elastic_wall_are_within_their_errors() -> Result<()> {
    let density = next_to_walls(4).solve(&chain().with_wall(Wall::above(-0.5, 1.0)?)?)?;
    let names = ["k", "mu", "kappa", "T", OFFSET];
    let mut squares = Vec::new();
    for (j, by) in density.sensitivities(&names)?.iter().enumerate() {
        let moved = |sign: f64| {
            let mut values = [1.0, 0.5, 0.5, TEMPERATURE, -0.5];
            values[j] += sign * 1e-3;
            above_elastic(values)
        };
        let (above, below) = (moved(1.0), moved(-1.0));
        let moments = [[1, 0, 0, 0], [2, 0, 0, 0], [0, 0, 2, 0]].map(|powers| by.moment(&powers));
        let found = moments.into_iter().chain([by.exceedance(0, 1.0)]).collect::<Result<Vec<_>>>()?;
        for (i, found) in found.into_iter().chain(by.impact_rate()).enumerate() {
            let truth = (above[i] - below[i]) / 2e-3;
            println!("{} {i}: {found}, exact {truth:.5}", names[j]);
            assert!(found.error < 0.1 * truth.abs().max(0.1), "{found}, exact {truth}");
            squares.push(((found.value - truth) / found.error).powi(2));
        }
    }
    let mean = squares.iter().sum::<f64>() / squares.len() as f64;
    println!("mean square deviation {mean:.2}");
    assert!(mean < 3.0, "{squares:?}");
    Ok(())
}

/// Where two bodies hit each other and lose energy no closed form is known, but the system has units: with lengths times 1 + ε E x₁²
/// grows by 2ε, and with times E x₁² does not change and the impact rate falls by ε. The parameters' derivatives make these up to their
/// errors. Those by the wall of one body are slopes (below).
#[test]
fn derivatives_next_to_lossy_walls_have_the_right_units() -> Result<()> {
    let problem = chain().with_wall(Wall::above(-0.5, 0.8)?.between([0, 2], [1.0, 0.5])?)?;
    let offset = "x1-x2.above.offset";
    let density = next_to_walls(2).solve(&problem)?;
    let names = ["k", "mu", "kappa", "T", "c1", "c2", offset];
    let values = [1.0, 0.5, 0.5, TEMPERATURE, 0.2, 0.4, -0.5];
    // The powers of length and of time in each parameter.
    let units = [[0.0, -2.0], [-2.0, -2.0], [0.0, -2.0], [2.0, -2.0], [0.0, -1.0], [0.0, -1.0], [1.0, 0.0]];
    let found = density.sensitivities(&names)?;
    let square = density.moment(&[2, 0, 0, 0])?;
    let rate = Impacts::new(&density, &problem)?.rate();
    let squares = found.iter().map(|by| by.moment(&[2, 0, 0, 0])).collect::<Result<Vec<_>>>()?;
    let rates: Vec<Estimate> = found.iter().filter_map(Sensitivity::impact_rate).collect();
    for (list, [length, time], truth) in [(&squares, [2.0_f64, 0.0], square), (&rates, [0.0, -1.0], rate)] {
        for (unit, power) in [(0, length), (1, time)] {
            let terms: Vec<Estimate> =
                list.iter().zip(values).zip(units).map(|((by, value), units)| by.scaled(value * units[unit])).collect();
            let sum: f64 = terms.iter().map(|term| term.value).sum();
            let error = terms.iter().map(|term| term.error.powi(2)).sum::<f64>().sqrt() + power.abs() * truth.error;
            println!("{offset}: {sum:.5} ± {error:.5} of {:.5}", power * truth.value);
            // The deviation of one answer, of which errors are correlated.
            assert!((sum - power * truth.value).abs() < 4.0 * error && error < 0.05 * truth.value, "{terms:?}");
        }
    }
    Ok(())
}

/// A filter beside white noise, without which trajectories would come to rest on the wall.
const COLOURED: &str = r#"
states = ["x", "v", "z"]
[drift]
x = "v"
v = "z - 0.2*v - x - 0.5*x^3"
z = "-z"
[noise.w]
z = 1
[noise.u]
v = 0.4
"#;

/// Behind a filter the means of the derivatives at two offsets and at two restitutions are the differences of the densities by the same
/// pilot seed, to the noise of these, 0.4 % of moments over a step of 0.1.
#[test]
fn derivatives_by_a_wall_behind_a_filter_are_slopes() -> Result<()> {
    let problem = Problem::from_toml(COLOURED)?;
    let names = ["x.above.offset", "x.above.restitution"];
    let at = |offset: f64, r: f64| {
        let density =
            next_to_walls(2).pilot_states(50_000).solve(&problem.clone().with_wall(Wall::above(offset, r)?)?)?;
        Ok::<_, Error>((density.sensitivities(&names)?, density))
    };
    let (found, density) = at(-0.3, 0.8)?;
    for (j, (found_there, there)) in [at(-0.2, 0.8)?, at(-0.3, 0.9)?].iter().enumerate() {
        for powers in [[1, 0, 0], [2, 0, 0], [0, 2, 0]] {
            let slope = (there.moment(&powers)?.value - density.moment(&powers)?.value) / 0.1;
            let [found, found_there] = [found[j].moment(&powers)?, found_there[j].moment(&powers)?];
            println!("{} {powers:?}: {found}, {found_there}, difference {slope:.4}", names[j]);
            let mean = 0.5 * (found.value + found_there.value);
            assert!((mean - slope).abs() < 0.04, "{mean} and {slope}");
        }
        // Of the impact rate: within twice its errors, and those of the two rates over the step.
        let [rate, rate_there] = [density.impact_rate().unwrap(), there.impact_rate().unwrap()];
        let slope = Estimate::new((rate_there.value - rate.value) / 0.1, rate_there.error.hypot(rate.error) / 0.1);
        let [found, found_there] = [found[j].impact_rate().unwrap(), found_there[j].impact_rate().unwrap()];
        println!("{} impact rate: {found}, {found_there}, difference {slope}", names[j]);
        let mean = Estimate::new(0.5 * (found.value + found_there.value), 0.5 * (found.error + found_there.error));
        assert!((mean.value - slope.value).abs() < 2.0 * mean.error.hypot(slope.error), "{mean} and {slope}");
    }
    Ok(())
}

#[test]
fn what_is_not_served_is_refused() -> Result<()> {
    let density = closed(2);
    assert!(matches!(density.sensitivity("no such"), Err(Error::NotAName { .. })));
    let walled = Closure::new(2).pilot_states(1 << 14).solve(&chain().with_wall(Wall::above(-0.5, 0.9)?)?)?;
    assert!(matches!(walled.sensitivity("no such"), Err(Error::NotAName { .. })));
    Ok(())
}
