//! What the moment equations say of the stationary response: modes of relaxation, autocovariance, spectral density.

use crate::common::moving::{two_wells, van_der_pol};
use crate::common::*;
use expoly::models::Linear;
use expoly::{Closure, Grid, Relaxation, Result, Simulation};
use nalgebra::matrix;
use std::f64::consts::PI;

/// The eigenvalues of a linear system's operator are sums n λ₊ + m λ₋ of its own, λ = c/2 ± i √(k − c²/4): the polynomials of
/// each degree are mapped to themselves, so that only rounding is left, 1e-13 of the largest entry of the matrix. Required are
/// 1e-8.
#[test]
fn a_linear_oscillator_relaxes_with_its_own_eigenvalues() {
    let modes = Closure::new(4).solve(&problem(Linear::new(0.5, 1.0, 0.5).unwrap())).unwrap().relaxation(6).unwrap();
    let frequency = 0.9375_f64.sqrt();
    for (rate, times) in [(0.0, 0.0), (0.25, 1.0), (0.5, 0.0), (0.5, 2.0), (0.75, 1.0)] {
        let near = |m: &&Relaxation| (m.rate - rate).hypot(m.frequency - times * frequency) < 1e-10;
        let mode = modes.iter().find(near).unwrap();
        println!("{mode:?}");
        assert!(mode.error < 1e-10, "{mode:?}");
    }
    let filter = Closure::new(2).solve(&problem(OrnsteinUhlenbeck)).unwrap().relaxation(5).unwrap();
    assert!((0..5).all(|n| (filter[n].rate - n as f64).abs() < 1e-10 && filter[n].frequency == 0.0), "{filter:?}");
}

/// The slowest modes of three systems are among the grid's to four digits, and within their own error by a factor of ten,
/// which compares two degrees. An elastic wall makes ridges of the modes with a frequency, of which polynomials hold two
/// digits.
#[test]
fn relaxation_rates_agree_with_those_of_a_grid() {
    let cases = [
        ("two wells", two_wells(), 2),
        ("van der Pol", van_der_pol(), 3),
        ("Duffing above a wall", duffing_above(-0.5, 0.8), 3),
    ];
    for (name, problem, count) in cases {
        // At an accuracy of 1e-6 the rates are right to 1e-6.
        let truth = Grid::new().solve(&problem).unwrap().relaxation(2 * count + 2).unwrap();
        let found = Closure::new(6).solve(&problem).unwrap().relaxation(count + 1).unwrap();
        for found in found.iter().skip(1) {
            let from = |truth: &Relaxation| (found.rate - truth.rate).hypot(found.frequency - truth.frequency);
            let truth = truth.iter().min_by(|a, b| from(a).total_cmp(&from(b))).unwrap();
            let apart = from(truth);
            println!("{name}: {:.8} {:.8}, {apart:.1e} off, {:.1e}", found.rate, found.frequency, found.error);
            assert!(apart < 2e-4 * found.rate.hypot(found.frequency), "{name}: {found:?} and {truth:?}");
            assert!(apart < 10.0 * found.error + 1e-6, "{name}: {found:?} and {truth:?}");
        }
    }
}

/// S = (D/π)/((k − ω²)² + c²ω²) and its transform, for weak, critical and strong damping; at critical damping two modes are one.
/// The stationary density is cut off where it has fallen to e^−18: measured are 2e-7 of the variance.
#[test]
fn a_linear_oscillator_has_its_spectrum() -> Result<()> {
    for c in [0.3_f64, 2.0, 5.0] {
        let (k, d) = (1.0, 0.7);
        let density = Closure::new(2).solve(&problem(Linear::new(c, k, d)?))?;
        let (omegas, lags) = ([0.0, 0.5, 1.0, 3.0, 30.0], [0.0, 0.4, 2.0, 9.0]);
        for (omega, found) in omegas.iter().zip(density.spectral_density(0, &omegas)?) {
            let truth = d / PI / ((k - omega * omega).powi(2) + (c * omega).powi(2));
            assert!((found.value - truth).abs() < 1e-6 * (d / c), "c = {c}, S({omega}): {found} and {truth}");
        }
        let flow = |t: f64| (matrix![0.0, 1.0; -k, -c] * t).exp();
        for (t, found) in lags.iter().zip(density.autocovariance(0, &lags)?) {
            let truth = d / (c * k) * flow(*t)[(0, 0)];
            assert!((found.value - truth).abs() < 1e-6 * (d / c), "c = {c}, R({t}): {found} and {truth}");
        }
    }
    Ok(())
}

/// Autocovariance and spectral density of a Duffing oscillator, of displacement and velocity, against a simulation of 1.6e5 time
/// units: within four standard errors, which are half a percent of the variance. The window of the simulation's spectrum smooths
/// S by ⅔ (π/T)² S″ = 1e-4 of it.
#[test]
fn the_spectrum_of_a_simulation_is_met() -> Result<()> {
    let (interval, length) = (0.2, 1024);
    let problem = problem(duffing());
    let density = Closure::new(4).solve(&problem)?;
    let simulation = Simulation::new().trajectories(512).samples(1024 * length).time_step(0.02).seed(3);
    let simulation = simulation.sampling_interval(interval).spectrum(0, length).spectrum(1, length);
    let result = simulation.run(&problem)?;
    for state in [0, 1] {
        let spectrum = result.spectrum(state)?;
        let frequencies: Vec<f64> = spectrum.frequencies().collect();
        let chosen = [8, 20, 32, 36, 40, 50, 70, 110];
        let found = density.spectral_density(state, &chosen.map(|j| frequencies[j]))?;
        for (j, found) in chosen.into_iter().zip(found) {
            let counted = spectrum.density(j)?;
            println!("S_{state}({:.3}): {found}, simulated {counted}", frequencies[j]);
            assert!(
                (counted.value - found.value).abs() < 4.0 * counted.error + found.error,
                "{j}: {found} and {counted}"
            );
        }
        let lags = [0, 3, 10, 25, 60, 150];
        let found = density.autocovariance(state, &lags.map(|k| interval * k as f64))?;
        for (k, found) in lags.into_iter().zip(found) {
            let counted = spectrum.autocovariance(k)?;
            println!("R_{state}({:.1}): {found}, simulated {counted}", interval * k as f64);
            assert!(
                (counted.value - found.value).abs() < 4.0 * counted.error + found.error,
                "{k}: {found} and {counted}"
            );
        }
    }
    Ok(())
}
