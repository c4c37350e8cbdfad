//! The grid against closed forms, reference solutions, and its own estimates of the error.

use crate::common::*;
use expoly::models::{Duffing, Linear, Solved};
use expoly::statistics::energy_balance;
use expoly::{
    Crossing, Density, Drift, Error, Gaussian, Grid, GridDensity, GridProgress, Intensity, Oscillator, Polynomial,
    Problem, Scalar, Sensitivity, Simulation, Start, Wall,
};
use nalgebra::{dmatrix, dvector};
use std::ops::ControlFlow;
use std::sync::{Arc, Mutex};

/// The mesh is refined until the estimate is below the accuracy of 1e-7. The difference between two degrees is the error of the
/// lower one, so that it must not be below the true error.
fn check_smooth(name: &str, density: &GridDensity, system: &impl Solved, tolerance: f64) {
    let (made, estimate) = (density.provenance(), density.l1_estimate());
    let distance = l1_from(density, &system.exact().unwrap());
    println!("{name}: {distance:.1e}, estimate {estimate:.1e}");
    assert!(distance < tolerance, "{name}: {distance:e}");
    assert!(distance < estimate, "{name}: {distance:e} and an estimate of {estimate:e}");
    assert!(made.edge_level.unwrap() < 1e-10_f64.max(estimate) && made.residual.unwrap() < 1e-13, "{made:?}");
    assert!(made.leak.unwrap().abs() < 1e-8 && made.most_negative.unwrap() > -1e-6, "{made:?}");
    assert!(made.negative_mass.unwrap() < 1e-7, "{made:?}");
}

#[test]
fn smooth_densities_are_as_exact_as_was_asked_for() {
    fn check(name: &'static str, system: &impl Solved) {
        check_smooth(name, &on_grid(name, &system.problem().unwrap()), system, 1e-7);
    }
    check("Duffing", &duffing());
    check("displacement noise", &displacement_noise());
    check("velocity noise", &velocity_noise());
    check("linear", &linear());
    // Ridges and wells are narrower than the domain by more than a Gaussian is.
    check("two wells of Duffing", &bistable());
    check("van der Pol-Rayleigh", &van_der_pol_rayleigh());
    check("energy damping", &energy_damping());
}

/// Three wells far apart need more cells, which the refinement finds.
#[test]
fn three_wells_are_found() {
    check_smooth("three wells", &on_grid("three wells", &problem(three_wells())), &three_wells(), 1e-7);
}

/// Two wells that mix at a rate of 2e-8: what little is lost elsewhere moves probability from one to the other, in which two degrees
/// may agree. E x is 0, and so is its derivative; the errors are what a loss could change.
#[test]
fn what_moves_between_slowly_mixing_wells_is_in_the_errors() {
    let wells = Duffing::new(0.2, -1.0, 0.5, 0.006).unwrap().problem().unwrap();
    let density = Grid::new().solve(&wells).unwrap();
    let by = density.sensitivities(&["D"]).unwrap();
    let [mean, slope] = [density.moment(&[1, 0]).unwrap(), by[0].moment(&[1, 0]).unwrap()];
    println!("E x {mean}, by D {slope}, L1 {}", density.l1_estimate());
    for found in [mean, slope] {
        // Symmetry may make both exact: 1e-9 is allowed for rounding.
        assert!(found.value.abs() <= found.error + 1e-9, "{found}");
    }
    // What has no part in the mixing is as good as ever: E v² = D/c, and its derivative 1/c, on a finer mesh.
    let density = Grid::new().accuracy(1e-7).solve(&wells).unwrap();
    let by = density.sensitivities(&["D"]).unwrap();
    let [square, slope] = [density.moment(&[0, 2]).unwrap(), by[0].moment(&[0, 2]).unwrap()];
    assert!((square.value - 0.03).abs() < square.error && square.error < 1e-6, "{square}");
    assert!((slope.value - 5.0).abs() < slope.error && slope.error < 1e-4, "{slope}");
}

/// Two unlike wells, p ~ exp(−β(v²/2 + U)) with U = x⁴/4 − x²/2 and a tilt: the shares follow from what passes the barrier, whatever
/// the cells are like between which it passes. A well that coarse cells let out is not given up, and the way over the barrier is
/// resolved where e⁻²⁴ of the density is. Beyond 18 temperatures rounding leaves more of the shares open than the accuracy, which
/// estimate and warning say: 2e-5 at 20, 3e-6 at 24, where one well has nearly all, 3e-4 at 26, and all of them at 36.
#[test]
fn unlike_wells_have_their_shares() {
    for (damping, tilt, barrier, degree, accuracy, open) in [
        (0.2, 0.01, 15.0, 8, 1e-7, 0.0),
        (1.0, 0.01, 20.0, 10, 1e-7, 3e-5),
        (0.1, 0.03, 24.0, 6, 1e-5, 0.0),
        (0.1, 0.01, 26.0, 10, 1e-7, 5e-4),
        (1.0, 0.003, 36.0, 6, 1e-5, 2.001),
    ] {
        let beta = 4.0 * barrier;
        let sigma = (2.0_f64 * damping / beta).sqrt();
        let text = format!(
            "states = ['x', 'v']\ndrift.x = 'v'\ndrift.v = 'x - x^3 + {tilt} - {damping}*v'\nnoise.w.v = '{sigma}'"
        );
        // By the rule of midpoints, which is exact to rounding for what is smooth and ends.
        let weight = |x: f64| (-beta * (x.powi(4) / 4.0 - x * x / 2.0 - x * tilt + 0.25)).exp();
        let nodes = || (0..4000).map(|k| -3.0 + (f64::from(k) + 0.5) * 1.5e-3);
        let exact = nodes().map(|x| x * weight(x)).sum::<f64>() / nodes().map(weight).sum::<f64>();
        let density = Grid::new().degree(degree).accuracy(accuracy).solve(&Problem::from_toml(&text).unwrap()).unwrap();
        let mean = density.moment(&[1, 0]).unwrap();
        let (off, made) = ((mean.value - exact).abs(), density.provenance());
        println!(
            "{barrier} temperatures, degree {degree}, {accuracy:e}: {mean}, {off:.1e} off, {:?} cells",
            made.cells
        );
        assert!(off < mean.error && density.l1_estimate() < accuracy.max(open), "{mean} instead of {exact}");
        assert_eq!(made.warning.is_some(), density.l1_estimate() > accuracy, "{:?}", made.warning);
        // The wells are at ±1: what the shares leave open of the mean, they leave open of the density.
        assert!(mean.error < 2.0 * density.l1_estimate(), "{mean}, {:e}", density.l1_estimate());
    }
}

/// x′ = −k x + s₁ ξ₁ + s₂ x ξ₂ has the density (s₁² + s₂² x²)^−(1 + k/s₂²), whose tails are powers: what a domain cuts off is within the
/// errors of moments although nothing to speak of leaks there, and moments that do not exist have an infinite error.
#[test]
fn tails_that_fall_as_powers_are_within_the_errors() {
    let (k, first, second) = (1.5, 0.5_f64, 1.0_f64);
    let noise = format!("[noise]\na.x = '{first}'\nb.x = '{second}*x'");
    let alone = format!("states = ['x']\ndrift.x = '-{k}*x'\n{noise}");
    let beside = format!("states = ['x', 'y']\ndrift = {{ x = '-{k}*x', y = '-y' }}\n{noise}\nc.y = '1'");
    let truth = first.powi(2) / (2.0 * k - second.powi(2));
    for edge in [4.0, 8.0, 16.0] {
        for (text, domain) in [(&alone, vec![[-edge, edge]]), (&beside, vec![[-edge, edge], [-6.0, 6.0]])] {
            let problem = Problem::from_toml(text).unwrap();
            let density = Grid::new().accuracy(1e-6).domain(domain).solve(&problem).unwrap();
            let moment = |power: u32| {
                let powers: Vec<u32> =
                    (0..density.dimension()).map(|state| if state == 0 { power } else { 0 }).collect();
                density.moment(&powers).unwrap()
            };
            let (square, off) = (moment(2), (moment(2).value - truth).abs());
            println!("±{edge}: {square}, {off:.1e} off, {:.1e} in L1", density.l1_estimate());
            assert!(off < square.error && square.error < 4.0 * off, "±{edge}: {square} and {truth}");
            assert_eq!(moment(4).error, f64::INFINITY);
        }
    }
}

/// The error falls with the accuracy that is asked for, and is below it and below its own estimate, at every degree.
#[test]
fn the_error_falls_with_the_accuracy() {
    let exact = duffing().exact().unwrap();
    for (degree, accuracies) in [(3, [3e-2, 3e-3, 3e-4]), (5, [1e-2, 1e-4, 1e-5]), (8, [1e-3, 1e-5, 1e-7])] {
        let errors = accuracies.map(|accuracy| {
            let density = Grid::new().degree(degree).accuracy(accuracy).solve(&problem(duffing())).unwrap();
            let (distance, estimate) = (l1_from(&density, &exact), density.l1_estimate());
            println!("degree {degree}, accuracy {accuracy:e}: {distance:.1e}, estimate {estimate:.1e}");
            assert!(distance < estimate && distance < accuracy, "degree {degree}, accuracy {accuracy:e}: {distance:e}");
            assert_eq!(density.provenance().warning, None);
            distance
        });
        assert!(errors.windows(2).all(|pair| pair[1] < pair[0]), "degree {degree}: {errors:?}");
    }
}

/// Values, marginals, moments, rates: each within its own error of the closed form. The difference of two degrees may pass
/// through zero; 1e-9 of the value's size is allowed for that.
#[test]
fn every_statistic_is_right_within_its_own_error() {
    let (density, exact) = (on_grid("Duffing", &problem(duffing())), duffing().exact().unwrap());
    let check = |name: &str, found: expoly::Estimate, truth: f64| {
        assert!(
            (found.value - truth).abs() <= found.error + 1e-9 * truth.abs().max(1.0),
            "{name}: {found:.12} instead of {truth}"
        );
    };
    for m in monomials(2, 6) {
        check("moment", density.moment(&m).unwrap(), exact.moment(&m).unwrap().value);
    }
    for x in [-2.0, -0.3, 0.0, 1.1] {
        for state in 0..2 {
            let truth = exact.marginal(state, x).unwrap().value;
            let found = density.marginal(state, x).unwrap();
            // A difference of two degrees may pass through zero somewhere; the L¹ error bounds it elsewhere.
            assert!((found.value - truth).abs() < 1e-7, "{found:.12} instead of {truth}");
        }
        let (found, truth) = (density.pdf(&[x, 0.4]).unwrap().value, exact.pdf(&[x, 0.4]).unwrap().value);
        assert!((found - truth).abs() < 1e-7 && (density.log_pdf(&[x, 0.4]).unwrap() - truth.ln()).abs() < 1e-6);
        let truth = exact.upcrossing_rate(x).unwrap().value;
        assert!((density.upcrossing_rate(x).unwrap().value - truth).abs() < 1e-7);
    }
    check("variance", density.variance(0).unwrap(), exact.variance(0).unwrap().value);
    check("mass", density.moment(&[0, 0]).unwrap(), 1.0);
    let energy = |x: &[f64]| 0.5 * x[1] * x[1];
    check("kinetic energy", density.expectation(&energy).unwrap(), 0.5);
    assert_eq!(density.pdf(&[50.0, 0.0]).unwrap().value, 0.0);
    assert_eq!(density.log_pdf(&[50.0, 0.0]).unwrap(), f64::NEG_INFINITY);
    assert!(density.impact_rate().is_none() && density.marginal(2, 0.0).is_err());
    assert!(density.flux(Crossing { displacement: 1, ..Crossing::upward(0.0) }, 1).is_err());
}

/// Every moment equation E[f·∇φ + ½B:∇∇φ] = 0 up to degree 4, and the power balance, to the errors that the moments state.
#[test]
fn moment_equations_and_the_power_balance_hold_to_the_reported_error() {
    let check = |name: &'static str, problem: Problem| {
        let density = on_grid(name, &problem);
        for m in monomials(2, 4) {
            let statistic = Polynomial::from_terms(2, [(&m, 1.0)]).unwrap();
            let (mut sum, mut error, mut size) = (0.0, 0.0, 0.0);
            for (term, c) in problem.operator().generator(&statistic).terms() {
                let moment = density.moment(term).unwrap();
                (sum, error) = (sum + c * moment.value, error + c.abs() * moment.error);
                size += (c * moment.value).abs();
            }
            // The difference of two degrees may pass through zero: 1e-9 of the terms' size.
            println!("{m:?}: {sum:.1e} off, {error:.1e} reported");
            assert!(sum.abs() <= error + 1e-9 * size, "{m:?}: {sum:e}, {error:e}, {size:e}");
        }
        let balance = energy_balance(&problem, &*density).unwrap();
        assert!(balance.value.abs() <= balance.error + 1e-8, "{balance:.12}");
    };
    check("Duffing", problem(duffing()));
    check("van der Pol", problem(van_der_pol()));
    check("velocity noise", problem(velocity_noise()));
}

/// tests/reference/smooth.csv to 1e-6: two meshes of the reference agree to 1e-8, and its domain ends at 1e-6 of the
/// density at the origin, which affects its moments.
#[test]
fn the_smooth_reference_table_is_reproduced() {
    let rows = reference("smooth.csv");
    let check = |row: &[f64], density: &GridDensity| {
        let moments = [[1, 0], [2, 0], [4, 0], [0, 2], [0, 4]].map(|powers| density.moment(&powers).unwrap().value);
        let found = moments
            .into_iter()
            .chain([density.pdf(&[0.0; 2]).unwrap().value, density.upcrossing_rate(0.0).unwrap().value]);
        for (k, found) in found.enumerate() {
            let truth = row[3 + k];
            assert!((found - truth).abs() < 1e-6 * truth.abs().max(1.0), "{row:?}, column {}: {found}", 3 + k);
        }
    };
    check(&rows[0], &on_grid("cubic damping", &problem(cubic_damping())));
    check(&rows[3], &on_grid("Rayleigh", &problem(rayleigh())));
    check(&rows[1], &on_grid("van der Pol", &problem(van_der_pol())));
    check(&rows[2], &on_grid("two wells", &bistable_damping()));
    check(&rows[4], &on_grid("Duffing-van der Pol", &duffing_van_der_pol()));
}

/// A system that is no oscillator: every state has a drift and a noise of its own, and the noises are correlated. A linear
/// one is normal, with AS + SAᵀ + B = 0.
#[test]
fn a_system_with_noise_in_both_states_is_normal() {
    struct Gradient;
    impl Drift<2, 2> for Gradient {
        fn drift<S: Scalar>(&self, [x, y]: [S; 2]) -> [S; 2] {
            [-x - y * 0.5, x * 0.25 - y * 2.0]
        }
        fn noise<S: Scalar>(&self, _: [S; 2]) -> [[S; 2]; 2] {
            [[S::from(1.0), S::from(0.0)], [S::from(0.6), S::from(0.8)]]
        }
    }
    let density = Grid::new().accuracy(1e-8).solve(&problem(Gradient)).unwrap();
    let [xx, xy, yy] = [[2, 0], [1, 1], [0, 2]].map(|powers| density.moment(&powers).unwrap().value);
    let balance = [-2.0 * xx - xy + 1.0, -3.0 * xy + 0.25 * xx - 0.5 * yy + 0.6, 0.5 * xy - 4.0 * yy + 1.0];
    assert!(balance.iter().all(|b| b.abs() < 1e-8), "{balance:?}");
    let fourth = density.moment(&[2, 2]).unwrap().value;
    assert!((fourth - xx * yy - 2.0 * xy * xy).abs() < 1e-7);
}

/// The unit of time is the user's: at a hundred thousand oscillations in one, and at one in a hundred thousand, the domain is
/// found as quickly, and E v² = D/c to ten times the accuracy, since v² is large in the tails.
#[test]
fn the_domain_is_found_in_every_unit_of_time() {
    for rate in [1e5, 1e-5_f64] {
        let system = Linear::new(0.4 * rate, rate * rate, 0.4 * rate.powi(3)).unwrap();
        let density = Grid::new().accuracy(1e-5).solve(&problem(system)).unwrap();
        let square = density.moment(&[0, 2]).unwrap().value / (rate * rate);
        println!("rate {rate:e}: E v^2 off by {:.1e}, {:.2} s", square - 1.0, density.provenance().seconds);
        assert!((square - 1.0).abs() < 1e-4, "rate {rate:e}: {square}");
    }
}

struct Unstable(f64);

impl Oscillator for Unstable {
    fn force<S: Scalar>(&self, x: S, v: S) -> S {
        v * self.0 + x
    }
    fn intensity(&self) -> Intensity {
        Intensity::new(0.1).unwrap()
    }
}

/// What the grid does not resolve is refused, or comes with a warning.
fn warned_or_not_resolved(what: &str, found: expoly::Result<GridDensity>) {
    match found {
        Ok(density) => {
            let (estimate, warning) = (density.l1_estimate(), density.provenance().warning.as_ref());
            println!("{what}: estimate {estimate:.1e}, {warning:?}");
            assert!(warning.is_some() && estimate > 1e-6, "{what}: {estimate:e}, {warning:?}");
        }
        Err(error) => {
            let known = matches!(error, Error::NotResolved { .. } | Error::NoDensity { .. });
            assert!(known, "{what}: {error}");
        }
    }
}

/// A domain that cuts the density off: what is missing is in the estimate, and the warning says so.
#[test]
fn a_domain_that_cuts_the_density_is_warned_of() {
    let grid = Grid::new().accuracy(1e-4).domain([[-1.5, 4.0], [-7.0, 7.0]]);
    let density = grid.solve(&duffing().problem().unwrap()).unwrap();
    let (distance, estimate) = (l1_from(&density, &duffing().exact().unwrap()), density.l1_estimate());
    println!("{distance:.1e}, estimate {estimate:.1e}, {:?}", density.provenance().warning);
    assert!(distance < estimate && estimate < 1.0, "{distance:e}, {estimate:e}");
    assert!(density.provenance().warning.as_ref().is_some_and(|warning| warning.contains("edges")));
    // The derivative of a probability is off by no more than that of the density, by two rules to a tenth.
    let by = &density.sensitivities(&["D"]).unwrap()[0];
    let share = by.expectation(&|x| if x[0] * x[0] + x[1] * x[1] < 1.5 { 1.0 } else { -1.0 });
    println!("{share}, {:.1e}", by.l1_estimate());
    assert!(share.error < 1.1 * by.l1_estimate(), "{share}, {:e}", by.l1_estimate());
}

/// A callback sees the linear systems and the estimate, and stops the grid.
#[test]
fn a_callback_stops_the_grid() {
    let stopped = Grid::new().progress(|_| ControlFlow::Break(())).solve(&problem(duffing())).map(|_| ());
    assert!(matches!(stopped, Err(Error::Cancelled { done: 1, unit: "linear systems" })), "{stopped:?}");
    let seen = Arc::new(Mutex::new(Vec::new()));
    let callback = {
        let seen = seen.clone();
        move |progress: GridProgress| {
            seen.lock().unwrap().push(progress);
            ControlFlow::Continue(())
        }
    };
    let density = Grid::new().accuracy(1e-4).progress(callback).solve(&problem(duffing())).unwrap();
    let seen = seen.lock().unwrap();
    let last = seen.last().unwrap();
    assert_eq!((Some(last.rounds), Some(last.cells)), (density.provenance().iterations, density.provenance().cells));
    assert!(last.estimate.is_some_and(|estimate| estimate <= 1e-4), "{last:?}");
}

/// A callback sees the steps of a transient and of a survival, and stops them.
#[test]
fn a_callback_stops_a_density_on_its_way() {
    let callback = |progress: GridProgress| match progress.time {
        Some(time) if time > 0.5 => ControlFlow::Break(()),
        _ => ControlFlow::Continue(()),
    };
    let density = Grid::new().accuracy(1e-3).progress(callback).solve(&problem(duffing())).unwrap();
    let near = Start::Gaussian(Gaussian { mean: dvector![0.5, 0.0], covariance: dmatrix![0.1, 0.0; 0.0, 0.1] });
    assert!(density.transient(near.clone(), &[0.2], 1e-3).is_ok());
    let transient = density.transient(near.clone(), &[0.2, 1.0], 1e-3).map(|_| ());
    assert!(matches!(transient, Err(Error::Cancelled { .. })), "{transient:?}");
    let survival = density.survival([-2.0, 2.0]).unwrap().probability(near, &[1.0], 1e-3);
    assert!(matches!(survival, Err(Error::Cancelled { .. })), "{survival:?}");
}

#[test]
fn what_has_no_answer_is_refused_with_the_reason() {
    let problem = problem(duffing());
    let solve = |grid: Grid| grid.solve(&problem).map(|_| ());
    for grid in [
        Grid::new().degree(0),
        Grid::new().degree(1),
        Grid::new().degree(1000),
        Grid::new().degree(25),
        Grid::new().accuracy(0.0),
        Grid::new().accuracy(1.0),
        Grid::new().accuracy(-1e-6),
        Grid::new().accuracy(1e-12),
        Grid::new().accuracy(f64::NAN),
        Grid::new().accuracy(f64::INFINITY),
        Grid::new().domain([[-1.0, f64::NAN], [-1.0, 1.0]]),
        Grid::new().domain([[1.0, -1.0], [-1.0, 1.0]]),
    ] {
        let error = solve(grid.clone()).unwrap_err();
        assert!(matches!(error, Error::OutOfRange { .. }), "{grid:?}: {error}");
    }
    // Speeds about 0.5 alone, above a lossy wall: nothing grazes there, and a mesh graded from the speed 0 would have a
    // million lines.
    let fast = Grid::new().memory_limit(0.05).domain([[0.0, 3.0], [0.5, 0.500_001]]);
    warned_or_not_resolved("fast", fast.solve(&duffing_above(0.0, 0.5)));
    // Noise that does not move y: all its mass is at 0, and no mesh within the memory resolves it.
    let deaf = "states = ['x', 'y']\ndrift = { x = '-x', y = '-y - y*x^2' }\nnoise.w = { x = '1' }";
    let grid = Grid::new().memory_limit(0.2).domain([[-5.0, 5.0], [-1.0, 1.0]]);
    warned_or_not_resolved("deaf", grid.solve(&Problem::from_toml(deaf).unwrap()));
    // Energy that grows fast is an explosion of the pilot; with energy that grows slowly no domain suffices.
    for damping in [-2.0, -0.02] {
        let found = Grid::new().memory_limit(0.05).solve(&Problem::of(Unstable(damping)).unwrap());
        if !matches!(found, Err(Error::Exploded { .. })) {
            warned_or_not_resolved(&format!("damping {damping}"), found);
        }
    }
    let unstable = Problem::of(Unstable(-0.5)).unwrap();
    let found = Grid::new().memory_limit(0.05).domain([[-5.0, 5.0], [-5.0, 5.0]]).solve(&unstable);
    if !matches!(found, Err(Error::Exploded { .. })) {
        warned_or_not_resolved("unstable", found);
    }
    let error = Problem::of(Duffing::new(f64::NAN, 1.0, 0.3, 0.2).unwrap()).unwrap_err();
    assert!(matches!(error, Error::NotFinite { .. }), "{error}");
    let [lower, upper] = walls_at([0.5, -0.5], [1.0, 1.0]);
    let error = problem.clone().with_wall(lower).unwrap().with_wall(upper).unwrap_err();
    assert!(matches!(error, Error::OutOfRange { .. }), "{error}");
    // Four states have no grid.
    let error = Grid::new().solve(&chain_of_two().problem().unwrap()).unwrap_err();
    assert!(matches!(error, Error::NotServed { method: "grid", .. }), "{error}");
    // A domain has as many sides as the problem has states.
    let error = Grid::new().domain([[-5.0, 5.0]]).solve(&problem).map(|_| ()).unwrap_err();
    assert!(matches!(error, Error::Dimension { expected: 2, found: 1, .. }), "{error}");
}

struct Planar {
    noise: f64,
}

impl Drift<2, 1> for Planar {
    fn drift<S: Scalar>(&self, [x, y]: [S; 2]) -> [S; 2] {
        [-x, -y]
    }
    fn noise<S: Scalar>(&self, _: [S; 2]) -> [[S; 1]; 2] {
        [[S::from(self.noise)], [S::from(0.0)]]
    }
}

#[test]
fn a_system_without_noise_or_velocity_is_refused() {
    assert!(matches!(Problem::of(Planar { noise: 0.0 }), Err(Error::NoDensity { .. })));
    let error = problem(Planar { noise: 1.0 }).with_wall(Wall::above(0.0, 0.9).unwrap()).unwrap_err();
    assert_eq!(error, Error::NotADisplacement { state: 0 });
}

/// The grid and the library's own simulation, which shares nothing with it, on a system without a closed form.
#[test]
fn the_grid_agrees_with_the_simulation() {
    let problem = problem(van_der_pol());
    let density = on_grid("van der Pol", &problem);
    let simulated = Simulation::new().samples(500_000).seed(3).run(&problem).unwrap();
    for powers in monomials(2, 4).into_iter().skip(1) {
        // Moments such as E xv are exact in the simulation, and known to the grid's own error.
        let (sampled, gridded) = (simulated.moment(&powers).unwrap(), density.moment(&powers).unwrap());
        let z = (sampled.value - gridded.value).abs() / sampled.error.hypot(gridded.error);
        println!("{powers:?}: {sampled}, by the grid {gridded}");
        // The largest of fourteen: 4 standard errors.
        assert!(z < 4.0, "{powers:?}: {z}");
    }
}
