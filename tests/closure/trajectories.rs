//! Densities in time in three states and more, where trajectories carry them.

use crate::common::l1_over_draws;
use expoly::{
    Closure, Density, Error, Gaussian, Problem, Simulation, Start, Wall,
    models::{DuffingChain, Solved},
};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3, matrix, vector};

/// x″ + x′/2 + x = z, z′ = −z + ξ with D = ½.
fn filtered_linear() -> Problem {
    let drift = "[drift]\nx = \"v\"\nv = \"-x - 0.5*v + z\"\nz = \"-z\"\n";
    Problem::from_toml(&format!("states = [\"x\", \"v\", \"z\"]\n{drift}[noise.w]\nz = \"1\"\n")).unwrap()
}

const RATES: Matrix3<f64> = matrix![0.0, 1.0, 0.0; -1.0, -0.5, 1.0; 0.0, 0.0, -1.0];
/// That of the stationary density, from A S + S Aᵀ + B = 0.
const SPREAD: Matrix3<f64> = matrix![0.6, 0.0, 0.2; 0.0, 0.4, 0.2; 0.2, 0.2, 0.5];

/// Two Duffing oscillators at the same temperature 0.45.
fn system() -> DuffingChain {
    DuffingChain::new(&[0.4, 0.4], 1.0, 0.5, 0.5, 0.45).unwrap()
}

fn chain() -> Problem {
    system().problem().unwrap()
}

/// A normal distribution about x₁ = 1, of deviation 0.2 in every state.
fn normal(states: usize) -> Gaussian {
    let mean = DVector::from_fn(states, |i, _| if i == 0 { 1.0 } else { 0.0 });
    Gaussian { mean, covariance: DMatrix::identity(states, states) * 0.04 }
}

/// Mean and covariance are those of the matrix exponential at all times: the equations of first and second degree close, and the
/// trajectories, whose own errors are 2e-3, add nothing to them.
#[test]
fn a_filtered_linear_oscillator_keeps_its_gaussian() {
    let lyapunov = RATES * SPREAD + SPREAD * RATES.transpose() + Matrix3::from_diagonal(&vector![0.0, 0.0, 1.0]);
    assert!(lyapunov.norm() < 1e-12);
    let start = Start::Gaussian(normal(3));
    let closure = Closure::new(2).pilot_states(65_536);
    for found in closure.transient(&filtered_linear(), &start, &[0.5, 2.0, 9.0]).unwrap() {
        let flow = (RATES * found.time).exp();
        let mean = flow * Vector3::new(1.0, 0.0, 0.0);
        let spread = SPREAD + flow * (Matrix3::identity() * 0.04 - SPREAD) * flow.transpose();
        for (i, j) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)] {
            let mut powers = [0; 3];
            powers[i] += 1;
            powers[j] += 1;
            let (moment, truth) = (found.moment(&powers).unwrap(), spread[(i, j)] + mean[i] * mean[j]);
            println!("t = {}, {powers:?}: {moment}, {:.1e} off", found.time, moment.value - truth);
            assert!(
                (moment.value - truth).abs() < 4.0 * moment.error + 2e-7,
                "t = {}, {powers:?}: {moment} and {truth}",
                found.time
            );
        }
        let estimate = found.density.l1_estimate();
        println!("t = {}: estimate {estimate:.1e}", found.time);
        // Measured are 2.9e-3, 1.0e-4 and 4.6e-5: what the edge of the domain may make of high degrees is least known early.
        assert!(estimate < if found.time < 1.0 { 4e-3 } else { 2e-4 });
        // The density is a rule on draws, with an error of its own.
        let (peak, truth) =
            (found.density.pdf(mean.as_slice()).unwrap(), 1.0 / (spread * std::f64::consts::TAU).determinant().sqrt());
        assert!((peak.value / truth - 1.0).abs() < 3e-3, "{peak} and {truth}");
    }
}

/// Its rates are sums of its eigenvalues, c/2 ± i √(k − c²/4) and 1, its autocovariance the exponential's.
#[test]
fn a_filtered_linear_oscillator_relaxes_with_its_own_eigenvalues() {
    let density = Closure::new(2).pilot_states(65_536).solve(&filtered_linear()).unwrap();
    let modes = density.relaxation(5).unwrap();
    let omega = 0.9375_f64.sqrt();
    for (mode, truth) in modes.iter().zip([[0.0, 0.0], [0.25, omega], [0.5, 0.0], [0.75, omega]]) {
        println!("{mode:?}");
        assert!((mode.rate - truth[0]).abs() < 1e-8 && mode.error < 1e-8, "{mode:?}");
        assert!(mode.frequency == 0.0 || (mode.frequency - truth[1]).abs() < 1e-8, "{mode:?}");
    }
    let lags = [0.0, 0.7, 3.0];
    for (found, lag) in density.autocovariance(0, &lags).unwrap().iter().zip(lags) {
        let truth = ((RATES * lag).exp() * SPREAD)[(0, 0)];
        println!("R({lag}) = {found}, {:.1e} off", found.value - truth);
        // The stationary density is cut off where no state of the pilot has been, and its error has that.
        let off = (found.value - truth).abs();
        assert!(off < 1.5 * found.error + 1e-8 && found.error < 2e-6, "{found} and {truth}");
    }
}

/// Two coupled Duffing oscillators in four states from a narrow start: moments within four joint standard errors of independent
/// trajectories, eight of them for each time; the density's marginal within its estimate; and in the end the exact density.
#[test]
fn a_chain_is_as_its_trajectories_are() {
    let chain = chain();
    let (start, times) = (normal(4), [0.5, 6.0]);
    let found = Closure::new(4).pilot_states(1 << 17).transient(&chain, start.clone(), &times).unwrap();
    let simulated = Simulation::new().trajectories(1 << 17).seed(3).transient(&chain, start, &times).unwrap();
    for (found, simulated) in found.iter().zip(simulated) {
        let simulated = simulated.density;
        let estimate = found.density.l1_estimate();
        println!("t = {}: estimate {estimate:.1e}, {}", found.time, found.density.candidates()[0].origin);
        assert!(found.density.warning().is_none() && estimate < 0.05);
        for powers in [
            [1, 0, 0, 0],
            [0, 1, 0, 0],
            [0, 0, 1, 0],
            [2, 0, 0, 0],
            [1, 1, 0, 0],
            [1, 0, 1, 0],
            [0, 2, 0, 0],
            [0, 0, 0, 2],
        ] {
            let [own, other] = [found.moment(&powers).unwrap(), simulated.moment(&powers).unwrap()];
            println!("   {powers:?}: {own}, simulated {other}");
            let joint = own.error.hypot(other.error);
            assert!((own.value - other.value).abs() < 4.0 * joint, "t = {}, {powers:?}: {own}, {other}", found.time);
        }
        // Some 96 bins of 2^17 trajectories are off by √(2/π) Σ √(p_b/N), 2e-2 at most.
        let histogram = simulated.histogram(0).unwrap();
        let step = 0.04;
        let apart: f64 = (-100..100)
            .map(|k| step * (f64::from(k) + 0.5))
            .map(|x| {
                let own = found.density.marginal(0, x).unwrap().value;
                step * (own - histogram.density_at(&[x]).unwrap().value).abs()
            })
            .sum();
        println!("   marginal: {apart:.1e} apart");
        assert!(apart < estimate + 2e-2, "t = {}: {apart:e}, {estimate:e}", found.time);
    }
}

/// The stationary density stays, and is what is left of any start: 0.45 is E v² of the chain at rest with its surroundings. A quadratic
/// cannot hold its quartic, and says how far it is.
#[test]
fn the_start_is_forgotten() {
    let system = system();
    let chain = system.problem().unwrap();
    let start = Start::Point(vec![0.5, 0.0, 0.0, 0.0]);
    let closure = |order| Closure::new(order).pilot_states(65_536);
    let late = closure(2).transient(&chain, start, &[60.0]).unwrap().remove(0);
    let (distance, estimate) = (l1_over_draws(|x| system.log_density(x), &late.density), late.density.l1_estimate());
    println!("order 2: {distance:.3}, estimate {estimate:.3}");
    assert!((0.9..1.1).contains(&(estimate / distance)), "{distance} and {estimate}");
    let kept = closure(4).transient(&chain, &Start::Stationary, &[1.0]).unwrap().remove(0);
    for transient in [late, kept] {
        let square = transient.moment(&[0, 2, 0, 0]).unwrap();
        println!("t = {}: {square}", transient.time);
        assert!((square.value - 0.45).abs() < 1e-4, "{square}");
    }
}

#[test]
fn what_trajectories_cannot_carry_is_refused() {
    let chain = chain();
    let closure = Closure::new(2).pilot_states(4000);
    let point = Start::Point(vec![0.0; 4]);
    let refused =
        |problem: &Problem, start: &Start, times: &[f64]| closure.transient(problem, start, times).unwrap_err();
    assert!(matches!(refused(&chain, &point, &[0.0]), Error::OutOfRange { .. }));
    assert!(matches!(refused(&chain, &point, &[1.0, 1e6]), Error::OutOfRange { .. }));
    assert!(matches!(refused(&chain, &Start::Point(vec![0.0; 3]), &[1.0]), Error::Dimension { .. }));
    let density = Start::Density(std::sync::Arc::new(closure.solve(&chain).unwrap()));
    assert!(matches!(refused(&chain, &density, &[1.0]), Error::NotServed { .. }));
    // Noise has hardly reached the displacements.
    let moved = Start::Point(vec![1.0, 0.0, 0.0, 0.0]);
    assert!(matches!(refused(&chain, &moved, &[1e-12]), Error::NotClosed { .. }));
    let walled = chain.clone().with_wall(Wall::above(-0.5, 0.8).unwrap()).unwrap();
    assert!(matches!(refused(&walled, &point, &[1.0]), Error::NotServed { .. }));
}
