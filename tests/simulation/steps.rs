//! The simulation's time step: its order, its choice, and the error that is told from two steps.

#[path = "../../examples/support/shaken.rs"]
#[allow(unreachable_pub, reason = "the examples' own module")]
mod shaken;

use expoly::models::{DisplacementNoise, Duffing, Linear, ParametricLinear, VelocityNoise};
use expoly::{Barrier, Density, Grid, Interpretation, PolynomialDrift, Result, SimulatedDensity, Simulation};
use shaken::Shaken;

/// E v² with steps h and 2h along the same paths.
fn squares<T: PolynomialDrift<2, M> + Sync, const M: usize>(system: &T, h: f64) -> Result<[f64; 2]> {
    let simulation = Simulation::new(system).samples(800_000).sampling_interval(1.2).time_step(h).seed(1).two_steps();
    let result = simulation.run()?;
    let square = |density: &SimulatedDensity<2>| density.moment([0, 2]).value;
    Ok([square(&result), result.coarse().map_or(f64::NAN, square)])
}

/// The slope of the change of E v² from h to 2h over h, between h = 0.1 and 0.2.
fn slope<T: PolynomialDrift<2, M> + Sync, const M: usize>(system: &T) -> Result<f64> {
    let [short, long] = [squares(system, 0.1)?, squares(system, 0.2)?];
    Ok(((long[1] - long[0]) / (short[1] - short[0])).log2())
}

#[test]
fn the_weak_order_is_two() -> Result<()> {
    // The change is 0.6 to 1.2 % from 0.1 to 0.2, and four times that from 0.2 to 0.4. Paths under the same noise stay
    // together, so that each is known to 2 %, and the slope to 0.05; for the two systems whose noise acts on the velocity
    // and whose energies have heavier tails, to 0.1. The next term of the bias adds 0.05 to 0.1.
    let (ito, stratonovich) = (Interpretation::Ito, Interpretation::Stratonovich);
    let slopes = [
        ("E1, additive noise", slope(&Duffing::new(0.5, 1.0, 0.3, 0.5)?)?, 0.2),
        ("E6, noise by displacement", slope(&DisplacementNoise::new(0.5, 1.0, 0.3, 0.8, 0.5)?)?, 0.2),
        ("E5, parametric noise", slope(&ParametricLinear::new(0.2, 1.0, 0.1, 0.2)?)?, 0.2),
        ("E7, noise by velocity", slope(&VelocityNoise::new([0.5, 0.1], [1.0, 0.1], 1.0, 0.3)?)?, 0.2),
        ("linear, Itô", slope(&Shaken(ito))?, 0.2),
        ("linear, Stratonovich", slope(&Shaken(stratonovich))?, 0.2),
    ];
    for (name, slope, tolerance) in slopes {
        println!("{name}: {slope:.3}");
        assert!((slope - 2.0).abs() < tolerance, "{name}: slope {slope}");
    }
    Ok(())
}

#[test]
fn the_extrapolated_mean_is_the_exact_one() -> Result<()> {
    // E v² = D/c = 1. At h = 0.2 it is 1.5 % too large, 4 standard errors; a third of the change taken away leaves the
    // terms of fourth order, 0.1 %, and chance, here 4 standard errors of 0.25 %.
    let oscillator = Duffing::new(0.5, 1.0, 0.3, 0.5)?;
    let [fine, coarse] = squares(&oscillator, 0.2)?;
    assert!(fine > 1.005 && (fine - (coarse - fine) / 3.0 - 1.0).abs() < 0.015, "{fine} and {coarse}");
    // The linear system: 0 = −2c E v² + 0.16 E v² + 0.16 E x² + 1 with E x² = E v² and the Itô damping c, 1 or 0.92.
    for (interpretation, damping) in [(Interpretation::Ito, 1.0), (Interpretation::Stratonovich, 0.92)] {
        let truth = 1.0 / (2.0 * damping - 0.32);
        let [fine, coarse] = squares(&Shaken(interpretation), 0.2)?;
        let mean = fine - (coarse - fine) / 3.0;
        assert!((mean / truth - 1.0).abs() < 0.015, "{interpretation:?}: {mean} is not {truth}");
    }
    Ok(())
}

#[test]
fn errors_have_both_parts() -> Result<()> {
    let oscillator = Duffing::new(0.5, 1.0, 0.3, 0.5)?;
    let simulation = || Simulation::new(&oscillator).samples(100_000).sampling_interval(1.2).time_step(0.2).seed(3);
    let (alone, both) = (simulation().run()?, simulation().two_steps().run()?);
    assert!(alone.coarse().is_none());
    for powers in [[2, 0], [0, 2], [4, 0]] {
        let (one, two) = (alone.moment(powers), both.moment(powers));
        let change = both.coarse().map_or(f64::NAN, |twin| twin.moment(powers).value) - two.value;
        assert_eq!(one.value, two.value);
        assert!((two.error - one.error.hypot(change / 3.0)).abs() < 1e-12, "{powers:?}");
    }
    // A density's value as well, and a wall with losses counts the whole change.
    assert!(both.marginal(0, 0.0)?.error > alone.marginal(0, 0.0)?.error);
    let wall = Barrier::new(0.2, 0.8)?;
    let walled = Simulation::new(&oscillator).samples(50_000).time_step(0.1).barrier(wall).two_steps().run()?;
    let rates = [walled.impact_rate(), walled.coarse().and_then(SimulatedDensity::impact_rate)];
    let [Some(fine), Some(coarse)] = rates else { unreachable!("a wall has impacts") };
    assert!(fine.error >= (coarse.value - fine.value).abs());
    // Parts merge with their twins.
    let part = |k| simulation().two_steps().part(k, 2).run();
    let merged = SimulatedDensity::merge([part(0)?, part(1)?])?;
    assert_eq!(merged.moment([0, 2]), both.moment([0, 2]));
    Ok(())
}

#[test]
fn the_step_follows_the_systems_time_scale() -> Result<()> {
    // A linear oscillator has the rate √k everywhere, exactly; all else scales with it.
    for k in [0.01, 1.0, 400.0] {
        let c = 0.2 * f64::sqrt(k);
        let time = 1.0 / f64::sqrt(k);
        let oscillator = Linear::new(c, k, 0.2)?;
        let simulation = Simulation::new(&oscillator).samples(20_000).burn_in(30.0 * time).sampling_interval(time);
        let provenance = *simulation.run()?.provenance();
        assert!(provenance.rate.is_some_and(|rate| (rate * time - 1.0).abs() < 1e-6), "{provenance:?}");
        let step = provenance.time_step / time;
        assert!((0.036..=0.04).contains(&step), "{step}");
    }
    // Stiff springs that the start does not feel: k + 3μ E x² counts, with E x² = 0.04 for μ = 1000 and D/c = 1.
    let stiff = Duffing::new(0.5, 1.0, 1000.0, 0.5)?;
    let result = Simulation::new(&stiff).samples(20_000).run()?;
    assert!(result.provenance().time_step < 0.01, "{:?}", result.provenance());
    // E v² = D/c = 1, to 4 standard errors.
    assert!(result.moment([0, 2]).deviation(1.0) < 4.0);
    // A wall that is hit often is a time scale, and a given step is not touched.
    let oscillator = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
    let step = |b: f64| -> Result<f64> {
        let wall = Barrier::new(b, 0.9)?;
        Ok(Simulation::new(&oscillator).barrier(wall).samples(1024).run()?.provenance().time_step)
    };
    assert!(step(1.0)? < step(0.5)? && step(0.5)? < step(-0.5)?);
    let given = Simulation::new(&oscillator).time_step(0.05).samples(1024).run()?;
    assert_eq!((given.provenance().time_step, given.provenance().rate), (0.05, None));
    Ok(())
}

#[test]
fn the_power_balance_takes_errors_away() -> Result<()> {
    let oscillator = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
    let wall = Barrier::new(0.0, 0.95)?;
    let result = Simulation::new(&oscillator).barrier(wall).samples(800_000).seed(2).run()?;
    let (plain, balanced) = (result.moment([0, 2]), result.balanced());
    let square = balanced.moment([0, 2]);
    // From the reference table; the error falls by a third at least.
    assert!(square.deviation(0.84624171) < 4.0 && 1.5 * square.error < plain.error, "{plain} and {square}");
    assert!(balanced.mean(0)?.deviation(0.62107942) < 4.0);
    assert!(balanced.impact_rate().is_some_and(|rate| rate.deviation(0.35969161) < 4.0));
    Ok(())
}

#[test]
fn chattering_ends_and_leaves_no_bias() -> Result<()> {
    // A wall pressed against, far above the rest position, and one with strong losses: the impact rate does not change with
    // the step. Of the impacts at h = 0.04 those in shorter steps are a tenth; plain steps would miss 2 to 5 % of all.
    // 0.8 % is what the remainder of first order may make.
    let oscillator = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
    for (b, r) in [(0.5, 0.5), (1.0, 0.5), (1.0, 0.3)] {
        let wall = Barrier::new(b, r)?;
        let rate = |h: f64, samples: usize| -> Result<expoly::Estimate> {
            let simulation = Simulation::new(&oscillator).barrier(wall).samples(samples).time_step(h).burn_in(20.0);
            let rate = simulation.sampling_interval(0.4).seed(4).run()?.impact_rate();
            rate.ok_or(expoly::Error::NoSamples { what: "impacts", least: 1 })
        };
        let (coarse, fine) = (rate(0.04, 1_400_000)?, rate(0.01, 700_000)?);
        println!("b = {b}, r = {r}: {coarse} and {fine}");
        assert!(coarse.error.hypot(fine.error) < 4e-3 * fine.value, "{coarse} and {fine}");
        assert!((coarse.value - fine.value).abs() < 8e-3 * fine.value + 3.0 * coarse.error.hypot(fine.error));
    }
    Ok(())
}

/// A wall that the force at rest presses onto, above the grid's own rate and energy, which have four digits there.
#[test]
fn a_pressed_wall_agrees_with_the_grid() -> Result<()> {
    let oscillator = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
    let wall = Barrier::new(1.5, 0.7)?;
    let grid = Grid::new().solve_with_wall(&oscillator, wall)?;
    let found = Simulation::new(&oscillator).barrier(wall).samples(1_500_000).burn_in(20.0).seed(1).run()?.balanced();
    let missing = expoly::Error::NoSamples { what: "impacts", least: 1 };
    let [rate, truth] = [found.impact_rate(), grid.impact_rate()].map(|rate| rate.ok_or(missing.clone()));
    for (what, found, truth) in [("impact rate", rate?, truth?), ("E v^2", found.moment([0, 2]), grid.moment([0, 2]))] {
        println!("{what}: {found} and {truth} by the grid");
        // Precise to a few tenths of a percent; the time step may make a twentieth of a percent of that.
        assert!(found.error < 3e-3 * truth.value && truth.error.abs() < 1e-3 * truth.value);
        let allowed = 4.0 * found.error + truth.error.abs() + 5e-4 * truth.value;
        assert!((found.value - truth.value).abs() < allowed, "{what}: {found} and {truth}");
    }
    Ok(())
}
