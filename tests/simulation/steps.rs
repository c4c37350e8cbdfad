//! The simulation's time step: its order and its choice.

use crate::common::{duffing_above, on_grid_above};
use expoly::models::{Duffing, Linear};
use expoly::{Density, Error, Estimate, Grid, Interpretation, Problem, Result, SimulatedDensity, Simulation};
use support::Shaken;

/// How far E v² is off with a time step, relative to the grid's, without control variates, which would take the bias away.
fn bias(problem: &Problem, truth: f64, h: f64) -> Result<Estimate> {
    let simulation = Simulation::new().samples(8_000_000).sampling_interval(1.2).time_step(h).seed(1);
    let square = simulation.control_variates(false).run(problem)?.moment(&[0, 2])?;
    Ok(Estimate { value: square.value / truth - 1.0, error: square.error / truth })
}

fn additive() -> Result<Problem> {
    Problem::of(Duffing::new(0.5, 1.0, 0.3, 0.5)?)
}

/// The bias of E v² is 0.4 h² of the one and 0.2 h² of the other: 1 % and 4 %, each known to 0.07 %. The slope then is known to 0.1,
/// which three times over tells the order two from one and three; that of a single step is sharp (`simulation/scheme.rs`). With
/// h = 0.4 trajectories of the first explode.
#[test]
fn the_weak_order_is_two() -> Result<()> {
    let shaken = Problem::of(Shaken(Interpretation::Ito))?;
    for (name, problem, h) in [("additive", additive()?, 0.15), ("three noises", shaken, 0.25)] {
        let truth = Grid::new().accuracy(1e-5).solve(&problem)?.moment(&[0, 2])?.value;
        let [short, long] = [bias(&problem, truth, h)?, bias(&problem, truth, 2.0 * h)?];
        let slope = (long.value / short.value).log2();
        let error = (short.error / short.value).hypot(long.error / long.value) / 2.0_f64.ln();
        println!("{name}: {short} and {long}, slope {slope:.3} ± {error:.3}");
        assert!(error < 0.15 && (slope - 2.0).abs() < 3.0 * error, "{name}: slope {slope} ± {error}");
    }
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
