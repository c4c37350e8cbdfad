//! Rare states against closed forms, the grid, and themselves.

use crate::common::{OrnsteinUhlenbeck, duffing, duffing_above, on_grid_above, threads_of};
use expoly::{
    Density, Drift, Error, Estimate, Problem, Result, Scalar, Splitting, Tails, Wall,
    models::{ParametricLinear, Solved},
};
use std::ops::ControlFlow;

/// Values beyond four standard errors do not happen by chance: one in some thousand, with 64 replicas.
const LIMIT: f64 = 4.0;

/// Within four standard errors of the truth, and precise to 20 %.
fn assert_close(what: &str, estimate: Estimate, truth: f64) {
    println!("{what}: {:.3e} ± {:.1e}, truth {truth:.3e}", estimate.value, estimate.error);
    assert!(estimate.error < 0.2 * truth, "{what}: {} ± {} is not precise", estimate.value, estimate.error);
    assert!(estimate.deviation(truth) < LIMIT, "{what}: {} ± {} is not {truth}", estimate.value, estimate.error);
}

/// Density and up-crossings at all levels, the density at the last of which is at most `share` of that at the first.
fn assert_tail(tails: &Tails, truth: &dyn Density, levels: &[f64], share: f64) -> Result<()> {
    let density = |y: f64| truth.marginal(0, y).map(|p| p.value);
    assert!(density(levels[levels.len() - 1])? < share * density(levels[0])?);
    for &y in levels {
        assert_close(&format!("p({y})"), tails.marginal(0, y)?, density(y)?);
        assert_close(&format!("rate of {y}"), tails.upcrossing_rate(y)?, truth.upcrossing_rate(y)?.value);
    }
    println!("stationarity {:.1}, {:.1} s", tails.stationarity(), tails.provenance().seconds);
    // The largest of some forty deviations.
    assert!(tails.stationarity().abs() < 4.0);
    Ok(())
}

/// At the time step 0.02 the density at y = 3.5 is half a percent low, a tenth of the standard error allowed here.
#[test]
fn a_duffing_oscillator_has_its_gibbs_density() -> Result<()> {
    let levels = [0.0, 2.0, 3.0, 3.6];
    let splitting = Splitting::new().levels(levels).levels_of(1, [5.0]);
    let tails = splitting.particles(8).relaxation(30.0).duration(30.0).seed(1).run(&duffing().problem()?)?;
    assert_tail(&tails, &duffing().exact()?, &levels, 1e-8)?;
    // The velocity is normal with variance 1: P(v ≥ 5) = erfc(5/√2)/2.
    assert_close("P(v ≥ 5)", tails.exceedance(1, 5.0)?, 2.866_515_719e-7);
    assert_close("P(x ≥ 0)", tails.exceedance(0, 0.0)?, 0.5);
    assert_close("P(x < 0)", tails.non_exceedance(0, 0.0)?, 0.5);
    Ok(())
}

#[test]
fn multiplicative_noise_has_a_power_tail() -> Result<()> {
    let oscillator = ParametricLinear::new(0.1, 1.0, 0.5, 0.2)?;
    let levels = [0.0, 6.0, 20.0];
    let splitting = Splitting::new().levels(levels).particles(8).rarest(1e-9).relaxation(30.0).duration(25.0);
    let tails = splitting.replicas(48).seed(1).run(&Problem::of(oscillator)?)?;
    assert_tail(&tails, &oscillator.exact(), &levels, 1e-8)
}

#[test]
fn an_elastic_wall_cuts_the_density_off() -> Result<()> {
    let levels = [0.6, 2.0, 3.6];
    let splitting = Splitting::new().levels(levels).particles(8);
    let tails = splitting.relaxation(30.0).duration(30.0).run(&duffing_above(0.5, 1.0))?;
    assert_tail(&tails, &duffing().exact_above(0.5)?, &levels, 1e-8)
}

/// The grid has the density to 10⁻³ at 10⁻⁶ of the peak.
#[test]
fn a_wall_that_takes_energy_has_the_tail_of_the_grid() -> Result<()> {
    let levels = [0.6, 1.5, 2.0, 2.4];
    let splitting = Splitting::new().levels(levels).particles(8);
    let splitting = splitting.rarest(1e-9).relaxation(30.0).duration(30.0).seed(1);
    assert_tail(&splitting.run(&duffing_above(0.5, 0.7))?, &*on_grid_above(0.5, 0.7), &levels, 2e-6)
}

/// One state is no oscillator: the importance function is its distance from the mean. The midpoint rule's variance is off by
/// h²/6 or less, which changes the density at 6 by 0.1 %.
#[test]
fn a_first_order_system_has_both_its_tails() -> Result<()> {
    let problem = Problem::of(OrnsteinUhlenbeck)?;
    let splitting = Splitting::new().levels([-6.0, 0.0, 6.0]).burn_in(10.0).relaxation(10.0);
    let tails = splitting.duration(20.0).resampling_interval(0.02).seed(1).run(&problem)?;
    let normal = |x: f64| (-x * x / 2.0).exp() / std::f64::consts::TAU.sqrt();
    for y in [-6.0, 0.0, 6.0] {
        assert_close(&format!("p({y})"), tails.marginal(0, y)?, normal(y));
    }
    assert_close("P(x ≥ 6)", tails.exceedance(0, 6.0)?, 9.865_876_450e-10);
    assert_close("P(x < −6)", tails.non_exceedance(0, -6.0)?, 9.865_876_450e-10);
    assert!(matches!(tails.upcrossing_rate(6.0), Err(Error::NotKnown { .. })));
    Ok(())
}

/// The displacement is a poor importance function, which costs precision and nothing else.
#[test]
fn no_importance_function_biases_the_tail() -> Result<()> {
    let splitting = Splitting::new().importance(|x| x[0].abs()).rarest(1e-4).levels([2.5]);
    let tails = splitting.relaxation(20.0).seed(1).run(&duffing().problem()?)?;
    assert_close("p(2.5)", tails.marginal(0, 2.5)?, duffing().exact()?.marginal(0, 2.5)?.value);
    Ok(())
}

/// Particles that are still climbing show in `stationarity`. Measured for this case: 9 to 15.
#[test]
fn a_relaxation_too_short_is_seen() -> Result<()> {
    let tails = Splitting::new().particles(8).relaxation(1.0).duration(10.0).run(&duffing().problem()?)?;
    println!("stationarity {:.1}", tails.stationarity());
    assert!(tails.stationarity() > 4.0);
    Ok(())
}

#[test]
fn the_number_of_threads_changes_nothing() -> Result<()> {
    let problem = duffing_above(0.2, 0.8);
    let run = |threads: usize| -> Result<Vec<u64>> {
        let small = Splitting::new().levels([1.0, 2.0]).particles(8);
        let small = small.replicas(16).burn_in(5.0).relaxation(5.0).duration(5.0).rarest(1e-4).seed(3);
        let tails = threads_of(threads).install(|| small.run(&problem))?;
        let found = [tails.marginal(0, 1.0)?, tails.exceedance(0, 2.0)?, tails.upcrossing_rate(2.0)?];
        Ok(found.iter().flat_map(|e| [e.value.to_bits(), e.error.to_bits()]).collect())
    };
    let one = run(1)?;
    assert_eq!(one, run(2)?);
    assert_eq!(one, run(7)?);
    Ok(())
}

/// x″ + x′ + x − x³ = ξ leaves its well sooner or later, and never comes back.
struct Escaping;

impl Drift<2, 1> for Escaping {
    fn drift<S: Scalar>(&self, [x, v]: [S; 2]) -> [S; 2] {
        [v, x.powi(3) - x - v]
    }
    fn noise<S: Scalar>(&self, _: [S; 2]) -> [[S; 1]; 2] {
        [[S::from(0.0)], [S::from(0.3)]]
    }
}

#[test]
fn hostile_input_gets_typed_errors() -> Result<()> {
    let problem = duffing().problem()?;
    let small = || Splitting::new().burn_in(5.0).relaxation(5.0).duration(5.0).particles(8).replicas(16);
    let out_of_range = |splitting: Splitting<'_>| matches!(splitting.run(&problem), Err(Error::OutOfRange { .. }));
    assert!(out_of_range(small().levels([f64::NAN])) && out_of_range(small().levels([f64::INFINITY])));
    assert!(out_of_range(small().importance(|x| x[0].sqrt())));
    let on_the_wall = small().levels([0.5]).run(&duffing_above(0.5, 0.9));
    assert!(matches!(on_the_wall, Err(Error::OutOfRange { .. })));
    assert!(out_of_range(small().levels((0..65).map(f64::from))));
    assert!(out_of_range(small().rarest(0.0)) && out_of_range(small().rarest(f64::NAN)));
    assert!(out_of_range(small().time_step(0.0)) && out_of_range(small().duration(-1.0)));
    assert!(out_of_range(small().relaxation(f64::INFINITY)) && out_of_range(small().burn_in(f64::NAN)));
    assert!(out_of_range(small().resampling_interval(0.0)) && out_of_range(small().replicas(5000)));
    assert!(out_of_range(small().duration(1e15)));
    assert!(matches!(small().levels_of(2, [1.0]).run(&problem), Err(Error::Dimension { found: 2, .. })));
    assert!(matches!(small().particles(0).run(&problem), Err(Error::OutOfRange { .. })));
    assert!(matches!(small().replicas(15).run(&problem), Err(Error::OutOfRange { .. })));
    let stopped = small().progress(|_| ControlFlow::Break(())).run(&problem);
    assert!(matches!(stopped, Err(Error::Cancelled { .. })));
    let behind = small().levels([1.0]).run(&problem.clone().with_wall(Wall::below(1.0, 0.9)?)?);
    assert!(matches!(behind, Err(Error::OutOfRange { name: "level", .. })));
    let escaped = Splitting::new().levels([3.0]).run(&Problem::of(Escaping)?);
    assert!(matches!(escaped, Err(Error::Exploded { .. })), "{:?}", escaped.map(|t| t.provenance().clone()));
    Ok(())
}

/// A level below all states, one in the bulk, one far beyond all states; an importance function that is constant, or
/// infinite.
#[test]
fn odd_levels_and_importance_functions_have_sensible_answers() -> Result<()> {
    let problem = duffing().problem()?;
    let small = || Splitting::new().burn_in(20.0).relaxation(5.0).duration(10.0).particles(8).rarest(1e-3);
    let tails = small().levels([-50.0, 0.0, 0.0, 50.0]).run(&problem)?;
    let certain = tails.exceedance(0, -50.0)?;
    // The weights have the sum 1 up to rounding: some 10⁵ additions of parts of it.
    assert!((certain.value - 1.0).abs() < 1e-10);
    assert_close("P(x ≥ 0)", tails.exceedance(0, 0.0)?, 0.5);
    let never = tails.exceedance(0, 50.0)?;
    assert!(never.value == 0.0 && never.error == f64::INFINITY);
    assert!(matches!(tails.marginal(0, 1.0), Err(Error::NotKnown { .. })));
    assert!(matches!(tails.marginal(1, 0.0), Err(Error::NotKnown { .. })));
    let constant = small().importance(|_| 1.0).levels([0.0]).run(&problem)?;
    assert_eq!(constant.provenance().thresholds, Some(Vec::new()));
    let barred = |x: &[f64]| if x[0].abs() > 1.0 { f64::INFINITY } else { x[0].abs() };
    let barred = small().importance(barred).levels([1.0]).run(&problem)?;
    let exact = duffing().exact()?.marginal(0, 1.0)?.value;
    assert_close("p(1)", barred.marginal(0, 1.0)?, exact);
    Ok(())
}
