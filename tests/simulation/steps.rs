//! The simulation's time step: its order, its choice, and the error that is estimated from two steps.

use crate::common::{Shared, duffing_above, on_grid_above};
use expoly::models::{DisplacementNoise, Duffing, Linear, ParametricLinear, VelocityNoise};
use expoly::{Density, Error, Estimate, Interpretation, Problem, Result, SimulatedDensity, Simulation, Wall};
use std::sync::Arc;
use support::Shaken;

/// The simulation of a named problem with steps h and 2h along the same paths, without control variates, which would take the
/// bias of the time step away.
fn twins(name: &'static str, problem: &Problem, h: f64) -> Arc<SimulatedDensity> {
    static RUN: Shared<(&str, u64), SimulatedDensity> = Shared::new();
    let simulation = || Simulation::new().samples(800_000).sampling_interval(1.2).time_step(h).seed(1).two_steps();
    RUN.get((name, h.to_bits()), || simulation().control_variates(false).run(problem).unwrap())
}

/// E v² with both steps.
fn squares(name: &'static str, problem: &Problem, h: f64) -> Result<[f64; 2]> {
    let result = twins(name, problem, h);
    Ok([result.moment(&[0, 2])?.value, result.coarse().unwrap().moment(&[0, 2])?.value])
}

fn additive() -> Result<Problem> {
    Problem::of(Duffing::new(0.5, 1.0, 0.3, 0.5)?)
}

const SHAKEN: [(&str, Interpretation); 2] =
    [("linear, Itô", Interpretation::Ito), ("linear, Stratonovich", Interpretation::Stratonovich)];

#[test]
fn the_weak_order_is_two() -> Result<()> {
    // The change is 0.6 to 1.2 % from 0.1 to 0.2, and four times that from 0.2 to 0.4. Paths under the same noise stay
    // together, so that each is known to 2 %, and the slope to 0.05; for the two systems whose noise acts on the velocity
    // and whose energies have heavier tails, to 0.1. The next term of the bias adds 0.05 to 0.1.
    let mut problems = vec![
        ("E1, additive noise", additive()?),
        ("E6, noise by displacement", Problem::of(DisplacementNoise::new(0.5, 1.0, 0.3, 0.8, 0.5)?)?),
        ("E5, parametric noise", Problem::of(ParametricLinear::new(0.2, 1.0, 0.1, 0.2)?)?),
        ("E7, noise by velocity", Problem::of(VelocityNoise::new([0.5, 0.1], [1.0, 0.1], 1.0, 0.3)?)?),
    ];
    for (name, interpretation) in SHAKEN {
        problems.push((name, Problem::of(Shaken(interpretation))?));
    }
    for (name, problem) in &problems {
        let [short, long] = [squares(name, problem, 0.1)?, squares(name, problem, 0.2)?];
        let slope = ((long[1] - long[0]) / (short[1] - short[0])).log2();
        println!("{name}: {slope:.3}");
        assert!((slope - 2.0).abs() < 0.2, "{name}: slope {slope}");
    }
    Ok(())
}

#[test]
fn the_extrapolated_mean_is_the_exact_one() -> Result<()> {
    // E v² = D/c = 1. At h = 0.2 it is 1.5 % too large, 4 standard errors; a third of the change taken away leaves the
    // terms of fourth order, 0.1 %, and chance, here 4 standard errors of 0.25 %.
    let [fine, coarse] = squares("E1, additive noise", &additive()?, 0.2)?;
    assert!(fine > 1.005 && (fine - (coarse - fine) / 3.0 - 1.0).abs() < 0.015, "{fine} and {coarse}");
    // The linear system: 0 = −2c E v² + 0.16 E v² + 0.16 E x² + 1 with E x² = E v² and the Itô damping c, 1 or 0.92.
    for ((name, interpretation), damping) in SHAKEN.into_iter().zip([1.0, 0.92]) {
        let truth = 1.0 / (2.0 * damping - 0.32);
        let [fine, coarse] = squares(name, &Problem::of(Shaken(interpretation))?, 0.2)?;
        let mean = fine - (coarse - fine) / 3.0;
        println!("{name}: {fine} and {coarse}, extrapolated {mean}, exact {truth}");
        assert!((mean / truth - 1.0).abs() < 0.015, "{interpretation:?}: {mean} is not {truth}");
        // Without the extrapolation it is 1 % too large, which the stated error covers.
        let raw = fine / truth - 1.0;
        assert!(raw > 0.005 && (mean / truth - 1.0).abs() < raw / 2.0, "{interpretation:?}: {raw} before");
        let stated = twins(name, &Problem::of(Shaken(interpretation))?, 0.2).moment(&[0, 2])?;
        assert!(stated.deviation(truth) < 3.0, "{interpretation:?}: {stated} is not {truth}");
    }
    Ok(())
}

#[test]
fn errors_have_both_parts() -> Result<()> {
    let problem = additive()?;
    let simulation = || Simulation::new().samples(100_000).sampling_interval(1.2).time_step(0.2).seed(3);
    let (alone, both) = (simulation().run(&problem)?, simulation().two_steps().run(&problem)?);
    assert!(alone.coarse().is_none());
    for powers in [[2, 0], [0, 2], [4, 0]] {
        let (one, two) = (alone.moment(&powers)?, both.moment(&powers)?);
        let change = both.coarse().unwrap().moment(&powers)?.value - two.value;
        assert_eq!(one.value, two.value);
        assert!((two.error - one.error.hypot(change / 3.0)).abs() < 1e-12, "{powers:?}");
    }
    // A density's value as well, and a wall with losses counts the whole change.
    assert!(both.marginal(0, 0.0)?.error > alone.marginal(0, 0.0)?.error);
    let wall = problem.clone().with_wall(Wall::above(0.2, 0.8)?)?;
    let walled = Simulation::new().samples(50_000).time_step(0.1).two_steps().run(&wall)?;
    let rates = [walled.impact_rate(), walled.coarse().and_then(SimulatedDensity::impact_rate)];
    let [Some(fine), Some(coarse)] = rates else { unreachable!("a wall has impacts") };
    assert!(fine.error >= (coarse.value - fine.value).abs());
    // Parts merge with their twins.
    let part = |k| simulation().two_steps().part(k, 2).run(&problem);
    let merged = SimulatedDensity::merge([part(0)?, part(1)?])?;
    assert_eq!(merged.moment(&[0, 2])?, both.moment(&[0, 2])?);
    Ok(())
}

#[test]
fn the_step_follows_the_systems_time_scale() -> Result<()> {
    // A linear oscillator has the rate √k everywhere, exactly; all else scales with it.
    for k in [0.01, 1.0, 400.0] {
        let c = 0.2 * f64::sqrt(k);
        let time = 1.0 / f64::sqrt(k);
        let simulation = Simulation::new().samples(20_000).burn_in(30.0 * time).sampling_interval(time);
        let result = simulation.run(&Problem::of(Linear::new(c, k, 0.2)?)?)?;
        let provenance = result.provenance();
        assert!(provenance.rate.is_some_and(|rate| (rate * time - 1.0).abs() < 1e-6), "{provenance:?}");
        let step = time_step(&result) / time;
        assert!((0.036..=0.04).contains(&step), "{step}");
    }
    // Stiff springs without effect at the start: k + 3μ E x² counts, with E x² = 0.04 for μ = 1000 and D/c = 1.
    let stiff = Problem::of(Duffing::new(0.5, 1.0, 1000.0, 0.5)?)?;
    let result = Simulation::new().samples(20_000).run(&stiff)?;
    assert!(time_step(&result) < 0.01, "{:?}", result.provenance());
    // E v² = D/c = 1, to 4 standard errors.
    assert!(result.moment(&[0, 2])?.deviation(1.0) < 4.0);
    // A wall that is hit often is a time scale, and a given step is not touched.
    let step = |b: f64| Ok::<_, Error>(time_step(&Simulation::new().samples(1024).run(&duffing_above(b, 0.9))?));
    assert!(step(1.0)? < step(0.5)? && step(0.5)? < step(-0.5)?);
    let free = duffing_above(0.0, 1.0).without_walls();
    let given = Simulation::new().time_step(0.05).samples(1024).run(&free)?;
    assert_eq!((given.provenance().time_step, given.provenance().rate), (Some(0.05), None));
    Ok(())
}

fn time_step(result: &SimulatedDensity) -> f64 {
    result.provenance().time_step.unwrap()
}

#[test]
fn chattering_ends_and_leaves_no_bias() -> Result<()> {
    // A wall pressed against, and one far above the rest position with strong losses: the impact rate does not change with the
    // step. Of the impacts at h = 0.04 those in shorter steps are a tenth; plain steps would miss 2 to 5 % of all.
    // 0.8 % is what the remainder of first order may make.
    for (b, r) in [(0.5, 0.5), (1.0, 0.3)] {
        let problem = duffing_above(b, r);
        let rate = |h: f64, samples: usize| -> Result<Estimate> {
            let simulation = Simulation::new().samples(samples).time_step(h).burn_in(20.0);
            Ok(simulation.sampling_interval(0.4).seed(4).run(&problem)?.impact_rate().unwrap())
        };
        let (coarse, fine) = (rate(0.04, 400_000)?, rate(0.01, 200_000)?);
        println!("b = {b}, r = {r}: {coarse} and {fine}");
        assert!(coarse.error.hypot(fine.error) < 4e-3 * fine.value, "{coarse} and {fine}");
        assert!((coarse.value - fine.value).abs() < 8e-3 * fine.value + 3.0 * coarse.error.hypot(fine.error));
        // Where the grid is at hand, each is its rate: plain steps would be eight standard errors of the coarse rate away.
        if b == 0.5 {
            let truth = on_grid_above(b, r).impact_rate().unwrap();
            println!("by the grid: {truth}");
            assert!(truth.error.abs() < 1e-3 * truth.value, "{truth}");
            for found in [coarse, fine] {
                assert!((found.value - truth.value).abs() < 4.0 * found.error + 1e-3 * truth.value, "{found} {truth}");
            }
        }
    }
    Ok(())
}

/// A wall that the force at rest presses onto, above the grid's own rate and energy, which have four digits there.
#[test]
fn a_pressed_wall_agrees_with_the_grid() -> Result<()> {
    let grid = on_grid_above(1.5, 0.7);
    let simulation = Simulation::new().samples(500_000).sampling_interval(0.5).burn_in(20.0).seed(1);
    let found = simulation.run(&duffing_above(1.5, 0.7))?;
    let [rate, truth] = [found.impact_rate(), grid.impact_rate()].map(Option::unwrap);
    for (what, found, truth) in [("impact rate", rate, truth), ("E v^2", found.moment(&[0, 2])?, grid.moment(&[0, 2])?)]
    {
        println!("{what}: {found} and {truth} by the grid");
        // Precise to a tenth of a percent; the time step may make a twentieth of a percent of that.
        assert!(found.error < 2e-3 * truth.value && truth.error.abs() < 1e-3 * truth.value);
        let allowed = 4.0 * found.error + truth.error.abs() + 5e-4 * truth.value;
        assert!((found.value - truth.value).abs() < allowed, "{what}: {found} and {truth}");
    }
    Ok(())
}
