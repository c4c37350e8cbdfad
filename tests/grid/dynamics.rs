//! Relaxation rates and transient densities on the grid.

use crate::common::moving::{POWERS, correlated, linear_after, moments, normal};
use crate::common::{l1_from, problem};
use expoly::models::{Duffing, Linear, Solved};
use expoly::{Density, Drift, Error, Gaussian, Grid, GridDensity, Scalar, Start};
use nalgebra::{dmatrix, dvector};
use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};
use rand_distr::StandardNormal;
use std::sync::OnceLock;

/// Solved once for all tests.
fn linear() -> &'static GridDensity {
    static DENSITY: OnceLock<GridDensity> = OnceLock::new();
    DENSITY.get_or_init(|| {
        let grid = Grid::new().accuracy(1e-8).domain([[-6.5, 6.5], [-6.5, 6.5]]);
        grid.solve(&problem(Linear::new(0.5, 1.0, 0.5).unwrap())).unwrap()
    })
}

/// Solved once for all tests.
fn duffing() -> &'static GridDensity {
    static DENSITY: OnceLock<GridDensity> = OnceLock::new();
    DENSITY.get_or_init(|| {
        let grid = Grid::new().accuracy(1e-5).domain([[-3.9, 3.9], [-6.2, 6.2]]);
        grid.solve(&problem(crate::common::duffing())).unwrap()
    })
}

/// The eigenvalues of a linear oscillator's operator are sums n λ₊ + m λ₋ of its own, λ = c/2 ± i √(k − c²/4), n, m ≥ 0.
#[test]
fn a_linear_oscillator_relaxes_with_its_own_eigenvalues() {
    let modes = linear().relaxation(6).unwrap();
    let frequency = 0.9375_f64.sqrt();
    modes.iter().for_each(|mode| println!("{mode:?}"));
    // n + m = 0, 1, 2, 2, 3: rate (n + m)/4, frequency |n − m| times 0.968; |n − m| = 3 is not among the nearest to zero.
    for (rate, times) in [(0.0, 0.0), (0.25, 1.0), (0.5, 0.0), (0.5, 2.0), (0.75, 1.0)] {
        // Spectral accuracy: a mode of degree n + m is a polynomial of that degree times the density.
        let near = |m: &&expoly::Relaxation| (m.rate - rate).hypot(m.frequency - times * frequency) < 1e-4;
        let mode = modes.iter().find(near).unwrap();
        // The error is the change by a degree: 6e-8 at most on a mesh on which the density itself is right to 1e-8.
        assert!(mode.error < 2e-7, "{mode:?}");
    }
    assert!(modes[0].rate.abs() < 1e-7 && (modes[1].rate - 0.25).abs() < 1e-6);
}

/// A normal distribution stays normal, with known mean and covariance.
#[test]
fn a_linear_oscillator_keeps_its_gaussian() {
    let stationary = linear();
    let densities = stationary.transient(&correlated().0, &[0.5, 1.0, 2.0, 4.0], 1e-5).unwrap();
    for transient in &densities {
        let (mean, spread) = linear_after(transient.time);
        for (powers, truth) in POWERS.into_iter().zip(moments(mean, spread)) {
            let moment = transient.moment(&powers).unwrap();
            println!(
                "t = {}, {powers:?}: {:.1e} off, {:.1e} estimated",
                transient.time,
                moment.value - truth,
                moment.error
            );
            assert!((moment.value - truth).abs() < 1e-6, "t = {}, {powers:?}: {moment} and {truth}", transient.time);
        }
        // Mass is conserved but for what leaks through the edges.
        assert!((transient.moment(&[0, 0]).unwrap().value - 1.0).abs() < 1e-7);
    }
}

/// Mesh and steps follow the accuracy: one a hundred times finer gives an error a hundred times smaller, within a factor of ten for
/// cells and steps that are not always the largest ones. That of 1e-6 stands for the truth.
#[test]
fn a_finer_accuracy_gives_a_smaller_error() {
    let grid = Grid::new().accuracy(1e-3).domain([[-6.5, 6.5], [-6.5, 6.5]]);
    let stationary = grid.solve(&problem(Linear::new(0.5, 1.0, 0.5).unwrap())).unwrap();
    let start = Start::Gaussian(Gaussian { mean: dvector![0.8, -0.5], covariance: dmatrix![0.3, 0.05; 0.05, 0.4] });
    let at = |accuracy: f64| stationary.transient(&start, &[3.0], accuracy).unwrap().remove(0);
    let truth = at(1e-6).moment(&[1, 0]).unwrap().value;
    let errors = [1e-2, 1e-4].map(|accuracy| (at(accuracy).moment(&[1, 0]).unwrap().value - truth).abs());
    println!("{errors:?}");
    assert!(errors[1] < 0.1 * errors[0], "{errors:?}");
}

#[derive(Debug)]
struct DampedBySpeed;

impl Drift<2, 1> for DampedBySpeed {
    fn drift<S: Scalar>(&self, [x, v]: [S; 2]) -> [S; 2] {
        [v, -x - v * 0.3 - v * v * v * 0.3]
    }
    fn noise<S: Scalar>(&self, _: [S; 2]) -> [[S; 1]; 2] {
        [[S::zero()], [S::from(1.0)]]
    }
}

/// What a point's Gaussian is off by under a damping that bends it is in the estimate: 4 to 5 times the distance from a finer one.
#[test]
fn the_gaussian_of_a_point_is_off_by_less_than_is_estimated() {
    let stationary = Grid::new().accuracy(1e-5).solve(&problem(DampedBySpeed)).unwrap();
    let start = Start::Point(vec![1.0, 0.5]);
    let [coarse, middle, fine] =
        [1e-1, 3e-2, 1e-2].map(|accuracy| stationary.transient(&start, &[0.3], accuracy).unwrap().remove(0).density);
    for density in [coarse, middle] {
        let (distance, estimate) = (l1_from(&fine, &density), density.l1_estimate());
        println!("{distance:.2e}, estimated {estimate:.2e}");
        assert!(distance < estimate && estimate < 8.0 * distance, "{distance:e} and {estimate:e}");
    }
}

/// Duffing's oscillator from rest at x = 1 against 200 000 trajectories at two times, within four standard errors.
#[test]
fn a_point_start_agrees_with_a_simulation() {
    const PATHS: usize = 200_000;
    const STEP: f64 = 0.032;
    let times = [0.8, 1.6];
    let densities = duffing().transient(Start::Point(vec![1.0, 0.0]), &times, 5e-5).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let mut sums = [[0.0; 10]; 2];
    let kick = (2.0 * 0.2 * STEP).sqrt();
    for _ in 0..PATHS {
        let (mut x, mut v) = (1.0_f64, 0.0_f64);
        let mut steps = 0;
        for (sum, time) in sums.iter_mut().zip(times) {
            while (steps as f64 + 0.5) * STEP < time {
                // Half a drift, a kick whose force is taken at the middle velocity, half a drift: of weak order 2. With a
                // squared frequency of 2 at most, h²ω²/8 of the amplitude and ωt h²ω²/24 of the phase are less than half of
                // a standard error.
                x += v * STEP / 2.0;
                let spring = x + 0.3 * x * x * x;
                let z: f64 = rng.sample(StandardNormal);
                v = ((1.0 - 0.1 * STEP) * v - STEP * spring + kick * z) / (1.0 + 0.1 * STEP);
                x += v * STEP / 2.0;
                steps += 1;
            }
            for (k, value) in [x, v, x * x, x * v, v * v].into_iter().enumerate() {
                sum[k] += value;
                sum[5 + k] += value * value;
            }
        }
    }
    for (transient, sum) in densities.iter().zip(&sums) {
        for (k, powers) in [[1, 0], [0, 1], [2, 0], [1, 1], [0, 2]].into_iter().enumerate() {
            let mean = sum[k] / PATHS as f64;
            let error = ((sum[5 + k] / PATHS as f64 - mean * mean) / PATHS as f64).sqrt();
            let moment = transient.moment(&powers).unwrap();
            let deviation = (moment.value - mean).abs() / error.hypot(moment.error);
            println!("t = {}, {powers:?}: {moment}, simulated {mean:.6} ± {error:.6}", transient.time);
            assert!(deviation < 4.0, "t = {}, {powers:?}: {moment} and {mean} ± {error}", transient.time);
            // The grid is the more precise of both: from a point, many short steps add up to 0.9 of the simulation's error at most.
            assert!(moment.error < error, "t = {}, {powers:?}: {moment} and ± {error}", transient.time);
        }
    }
}

/// After many relaxation times a transient is the stationary density, and on the way it decays at the slowest rate.
#[test]
fn a_transient_ends_in_the_stationary_density_at_the_slowest_rate() {
    let grid = Grid::new().accuracy(1e-5).domain([[-2.6, 2.6], [-2.6, 2.6]]);
    let bistable = grid.solve(&problem(Duffing::new(0.5, -1.0, 1.0, 0.1).unwrap())).unwrap();
    let rate = bistable.relaxation(2).unwrap()[1].rate;
    let start = Start::Gaussian(Gaussian { mean: dvector![1.0, 0.0], covariance: dmatrix![0.1, 0.0; 0.0, 0.2] });
    let times = [20.0, 30.0, 14.0 / rate];
    let densities = bistable.transient(&start, &times, 1e-4).unwrap();
    let [first, second] = [0, 1].map(|k| densities[k].moment(&[1, 0]).unwrap().value);
    let measured = (first / second).ln() / 10.0;
    println!("slowest rate {rate:.6}, E x decays with {measured:.6}");
    // The next mode is ten times as fast and has died by then.
    assert!((measured / rate - 1.0).abs() < 1e-3, "{measured} and {rate}");
    let distance = l1_from(&bistable, &densities[2].density);
    println!("at the end: L1 {distance:.1e}, steps {:.1e}", densities[2].step_error);
    // The rest of the slowest mode, e^−14 = 8e-7 times its size, besides the steps' error: twice the 3.4e-5 that was
    // measured, a tenth of what the steps' estimates add up to.
    assert!(distance < 7e-5 && distance < densities[2].step_error, "{distance:e}");
}

#[test]
fn transients_without_a_meaning_are_refused() {
    let stationary = duffing();
    let refused =
        |start: Start, times: &[f64], accuracy: f64| stationary.transient(&start, times, accuracy).unwrap_err();
    let wide = Gaussian { mean: dvector![0.0, 0.0], covariance: dmatrix![0.3, 0.0; 0.0, 0.4] };
    let flat = Gaussian { mean: dvector![0.0, 0.0], covariance: dmatrix![0.0, 0.0; 0.0, 0.0] };
    let nowhere = Gaussian { mean: dvector![0.0, 0.0], covariance: dmatrix![f64::NAN, 0.0; 0.0, 0.4] };
    let far = Gaussian { mean: dvector![9.0, 0.0], covariance: dmatrix![0.3, 0.0; 0.0, 0.4] };
    for error in [
        refused(Start::Gaussian(wide.clone()), &[1.0], 0.0),
        refused(Start::Gaussian(wide.clone()), &[1.0], f64::NAN),
        refused(Start::Gaussian(wide.clone()), &[1.0], 1e-300),
        refused(Start::Gaussian(wide.clone()), &[f64::INFINITY], 1e-3),
        refused(Start::Gaussian(nowhere), &[1.0], 1e-3),
        refused(Start::Gaussian(wide.clone()), &[1.0, 0.5], 1e-3),
        refused(Start::Gaussian(wide), &[-1.0], 1e-3),
        refused(Start::Gaussian(flat), &[1.0], 1e-3),
        refused(Start::Gaussian(far), &[1.0], 1e-3),
        refused(Start::Point(vec![f64::NAN, 0.0]), &[1.0], 1e-3),
        refused(Start::Point(vec![1.0, 0.0]), &[1e-9], 1e-3),
    ] {
        assert!(matches!(error, Error::OutOfRange { .. }), "{error}");
    }
    let three = Gaussian { mean: dvector![0.0, 0.0, 0.0], covariance: nalgebra::DMatrix::identity(3, 3) };
    let error = refused(Start::Gaussian(three), &[1.0], 1e-3);
    assert!(matches!(error, Error::Dimension { expected: 2, found: 3, .. }), "{error}");
}

/// The stationary density as a start stays: what is off is the mesh, which the distance of the two degrees bounds: 2.8e-5
/// by an estimate of 1.5e-4.
#[test]
fn the_error_of_the_mesh_is_in_the_estimate() {
    let exact = Linear::new(0.5, 1.0, 0.5).unwrap().exact().unwrap();
    let found = linear().transient(normal([0.0, 0.0], 1.0), &[1.0], 1e-3).unwrap().remove(0);
    let (distance, estimate) = (l1_from(&found.density, &exact), found.density.l1_estimate());
    println!("{distance:.1e}, estimate {estimate:.1e}");
    assert!(distance > 1e-7 && distance < estimate, "{distance:e} and {estimate:e}");
}

/// Where next to nothing is, cells have modes that grow, in the lower degree first: the mesh of an accuracy of 1e-3 would make that
/// degree's distance 0.13 at t = 32, where the density itself is right to 2.3e-4. Where cells are divided for the lower degree too it
/// is 6.3e-3.
#[test]
fn modes_of_cells_do_not_grow_in_the_lower_degree() {
    let text = "states = ['x', 'v']\ndrift = { x = 'v', v = '0.5*(1 - x^2)*v - x' }\nnoise.w.v = 'sqrt(0.4)'";
    let problem = expoly::Problem::from_toml(text).unwrap();
    let start = || Gaussian { mean: dvector![1.0, 0.0], covariance: dmatrix![0.04, 0.0; 0.0, 0.04] };
    let at = |accuracy: f64| {
        let stationary = Grid::new().accuracy(1e-3).solve(&problem).unwrap();
        stationary.transient(start(), &[16.0, 32.0], accuracy).unwrap().remove(1).density
    };
    let (found, truth) = (at(1e-3), at(1e-4));
    let off = l1_from(&truth, &found);
    println!("{off:.1e} off, {:.1e} estimated", found.l1_estimate());
    assert!(off < 4e-4 && (0.8 * off..8e-3).contains(&found.l1_estimate()));
}
