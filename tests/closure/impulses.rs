//! The closure under Poisson impulses, against closed forms, exact moments and simulations.

use crate::simulation::impulses::{laws, struck};
use expoly::{
    Amplitude, Closure, Density, Error, Gaussian, Grid, PoissonImpulses, Problem, Result, Simulation, Start, Wall,
    Weight, compare, statistics,
};
use nalgebra::{dmatrix, dvector};

/// dx = −x dt + dJ with exponential amplitudes of mean one: the Gamma density x^(λ−1) e^(−x)/Γ(λ) (D. R. Cox and V. Isham, 1986).
fn filtered(rate: f64) -> Problem {
    let text = format!(
        "states = [\"x\"]\n[drift]\nx = \"-x\"\n[impulse.a]\nrate = {rate}\namplitude = {{ exponential = {{ mean = 1 }} }}\nx = 1"
    );
    Problem::from_toml(&text).unwrap()
}

/// ∫ |p̃ − p| dx by the midpoint rule on cells of a hundredth, in which p changes by 1e-4 of itself on average.
fn distance_from_gamma(density: &dyn Density, rate: u32) -> f64 {
    let factorial: f64 = (1..rate).map(f64::from).product();
    let width = 0.01;
    let cell = |k: i32| {
        let x = (f64::from(k) + 0.5) * width;
        let exact = if x > 0.0 { x.powi(rate as i32 - 1) * (-x).exp() / factorial } else { 0.0 };
        (density.pdf(&[x]).unwrap().value - exact).abs() * width
    };
    (-500..6000).map(cell).sum()
}

/// The distance falls as the order rises, as far as a polynomial follows ln x at the end of the states that are reached: measured
/// 9e-2, 4e-2, 3e-2 for λ = 3; 6e-2, 2e-2, 1e-2 for 5; 3e-2, 7e-3, 3e-3 for 10; and it is at most 1.3 times the estimate.
#[test]
fn a_filter_has_the_gamma_density() -> Result<()> {
    for (rate, bounds) in [(3, [0.1, 0.05, 0.032]), (5, [0.067, 0.027, 0.012]), (10, [0.031, 0.0085, 0.003])] {
        for (order, bound) in [4, 6, 8].into_iter().zip(bounds) {
            let density = Closure::new(order).weight(Weight::Density).solve(&filtered(f64::from(rate)))?;
            let distance = distance_from_gamma(&density, rate);
            println!("λ = {rate}, n = {order}: {distance:.1e}, estimate {:.1e}", density.l1_estimate());
            assert!(distance < bound && distance < 1.3 * density.l1_estimate(), "{rate} {order}: {distance:e}");
        }
    }
    Ok(())
}

/// E v² − (E v)² = λE[Y²]/(2c) = 1 and E g(x) = λE[Y] for every law, at n = 6: measured off by 1e-4 to 4e-4 where λ/c = 25.
#[test]
fn every_law_has_its_energy() -> Result<()> {
    for impulses in laws(5.0, 0.2) {
        let density = Closure::new(6).solve(&struck(0.3, &[impulses]))?;
        let [square, x, cube] = [[0, 2], [1, 0], [3, 0]].map(|powers| density.moment(&powers).unwrap().value);
        let spring = x + 0.3 * cube - 5.0 * impulses.amplitude().moment(1);
        println!("{impulses:?}: {:+.1e} {spring:+.1e} estimate {:.1e}", square - 1.0, density.l1_estimate());
        assert!((square - 1.0).abs() < 2e-3 && spring.abs() < 4e-3, "{impulses:?}: {square} {spring}");
        assert!(density.l1_estimate() < 0.02 && density.warning().is_none(), "{impulses:?}");
    }
    Ok(())
}

/// E x² of Duffing's oscillator to five digits by a Kolmogorov-Feller solution on a grid (Strang splitting, Richardson): the closure
/// at n = 8.
#[test]
fn mean_squares_are_those_of_another_solution() -> Result<()> {
    let shape = Amplitude::Normal { mean: 0.0, deviation: 1.0 };
    for (rate, exact) in [(20.0, 0.661024), (5.0, 0.658951), (2.0, 0.654817), (1.0, 0.647972)] {
        let density = Closure::new(8).solve(&struck(0.3, &[PoissonImpulses::with_intensity(rate, shape, 0.2)?]))?;
        let found = density.moment(&[2, 0])?.value;
        println!("λ = {rate}: {found:.6} for {exact}, estimate {:.1e}", density.l1_estimate());
        // 5e-6 of the solution's own, and 3e-2 of what the density is off by.
        assert!((found - exact).abs() < 5e-5 + 0.03 * density.l1_estimate(), "{rate}: {found} for {exact}");
    }
    Ok(())
}

/// Few impulses in the time in which the motion dies out leave a density that no polynomial follows; said for every seed.
#[test]
fn rare_impulses_carry_a_warning() -> Result<()> {
    let shape = Amplitude::Normal { mean: 0.0, deviation: 1.0 };
    for rate in [0.1, 0.2] {
        let problem = struck(0.3, &[PoissonImpulses::with_intensity(rate, shape, 0.2)?]);
        for seed in 0..4 {
            match Closure::new(6).seed(seed).solve(&problem) {
                Ok(density) => assert!(density.warning().is_some(), "{rate} {seed}: {}", density.l1_estimate()),
                Err(error) => assert!(matches!(error, Error::NotClosed { .. }), "{error}"),
            }
        }
    }
    Ok(())
}

/// Two linear masses with impulses on the first, of mean zero and not: second moments are those of the Gaussian closure, exactly, and
/// those of fourth degree the calibrated simulation's; so is how likely it is that x is beyond two deviations, to 2 %.
#[test]
fn impulses_in_four_states_have_their_moments() -> Result<()> {
    for mean in [0.0, 0.1] {
        let problem = Problem::from_toml(&format!(
            "states = [\"x\", \"v\", \"y\", \"w\"]\n[drift]\nx = \"v\"\nv = \"-0.4*v - x - 0.5*(x - y)\"\ny = \"w\"\n\
             w = \"-0.3*w - y + 0.5*(x - y)\"\n[impulse.j]\nrate = 6\namplitude = {{ normal = {{ mean = {mean}, deviation = 0.3 }} }}\n\
             v = 1"
        ))?;
        let density = Closure::new(4).solve(&problem)?;
        let simulated = Simulation::new().samples(400_000).run(&problem)?;
        let gaussian = problem.gaussian()?;
        for (i, powers) in [[2, 0, 0, 0], [0, 2, 0, 0], [0, 0, 2, 0], [0, 0, 0, 2]].iter().enumerate() {
            let exact = gaussian.covariance[(i, i)] + gaussian.mean[i].powi(2);
            let found = density.moment(powers)?;
            println!("{mean} {powers:?}: {found} for {exact}");
            assert!((found.value / exact - 1.0).abs() < 1e-8, "{powers:?}: {found} for {exact}");
        }
        for powers in [[4, 0, 0, 0], [0, 0, 4, 0], [0, 4, 0, 0]] {
            let [p, q] = [density.moment(&powers)?, simulated.moment(&powers)?];
            assert!((p.value / q.value - 1.0).abs() < 1e-7, "{powers:?}: {p} and {q}");
        }
        let far = gaussian.mean[0] + 2.0 * gaussian.covariance[(0, 0)].sqrt();
        let [p, q] = [&density as &dyn Density, &simulated]
            .map(|density| statistics::Marginal::new(density, 0).unwrap().exceedance(far).unwrap());
        println!("{p} and {q}, estimate {:.1e}", density.l1_estimate());
        assert!((p.value - q.value).abs() < 4.0 * q.error + 0.02 * q.value, "{p} and {q}");
        assert!(density.l1_estimate() < 0.1 && density.warning().is_none(), "{:?}", density.warning());
    }
    Ok(())
}

/// The power balance counts what impulses bring.
#[test]
fn the_power_balance_includes_impulses() -> Result<()> {
    let problem = struck(0.3, &[laws(5.0, 0.2)[1]]);
    let closure = Closure::new(6).solve(&problem)?;
    let simulated = Simulation::new().samples(100_000).run(&problem)?;
    let [p, q] = [statistics::energy_balance(&problem, &closure)?, statistics::energy_balance(&problem, &simulated)?];
    assert!(p.value.abs() < 2e-3 && q.value.abs() < 1e-6, "{p} {q}");
    Ok(())
}

#[test]
fn methods_that_serve_no_impulses_say_so() -> Result<()> {
    let problem = struck(0.3, &[laws(5.0, 0.2)[0]]);
    assert!(matches!(Grid::new().solve(&problem), Err(Error::NotServed { .. })));
    assert!(matches!(Closure::classical(4).solve(&problem), Err(Error::NotServed { .. })));
    let walled = problem.with_wall(Wall::above(-0.5, 0.8)?)?;
    assert!(matches!(Closure::new(4).solve(&walled), Err(Error::NotServed { .. })));
    Ok(())
}

/// An oscillator from a narrow start under impulses alone: its second moment within four joint standard errors of 2^17 trajectories,
/// and its marginal within the estimate, or the noise. With λ = 1 modes grow under the weight of order 8, which a lower one replaces.
#[test]
fn impulses_are_followed_in_time() -> Result<()> {
    for (rate, order) in [(5.0, 4), (1.0, 8)] {
        let amplitude = Amplitude::Normal { mean: 0.0, deviation: (0.4_f64 / rate).sqrt() };
        let problem = struck(0.3, &[PoissonImpulses::new(rate, amplitude)?]);
        let start = Gaussian { mean: dvector![1.0, 0.0], covariance: dmatrix![0.1225, 0.0; 0.0, 0.1225] };
        for found in Closure::new(order).transient(&problem, Start::Gaussian(start.clone()), &[4.0])? {
            let simulation = Simulation::new().trajectories(1 << 17);
            let simulated = simulation.transient(&problem, start.clone(), &[found.time])?.remove(0).density;
            let [own, other] = [found.moment(&[2, 0])?, simulated.moment(&[2, 0])?];
            let marginal = compare::with_histogram(&found.density, 0, simulated.histogram(0)?)?;
            let estimate = found.density.l1_estimate();
            println!(
                "λ = {rate}, t = {}: {own}, simulated {other}; {:.1e} of {:.1e} by noise, estimate {estimate:.1e}",
                found.time, marginal.l1, marginal.noise
            );
            assert!((own.value - other.value).abs() < 4.0 * own.error.hypot(other.error), "{own} and {other}");
            assert!(marginal.l1 < estimate + 1.2 * marginal.noise && estimate < 0.6, "{marginal:?} {estimate:e}");
        }
        // So early that e^−λt of all paths have met no impulse: the smaller part of the two, 0.39, is missed.
        let early = Closure::new(2).pilot_states(8192).transient(&problem, Start::Gaussian(start), &[0.5 / rate])?;
        let estimate = early[0].density.l1_estimate();
        println!("early: {estimate}");
        assert!((1.0 - (-0.5_f64).exp()..0.5).contains(&estimate), "{estimate}");
    }
    Ok(())
}
