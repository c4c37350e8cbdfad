//! The closure in time.

use crate::common::moving::{POWERS, correlated, linear_after, moments, normal, two_wells, van_der_pol};
use crate::common::*;
use expoly::models::Linear;
use expoly::{Closure, ClosureDensity, Density, Error, Gaussian, Grid, Origin, Result, Simulation, Start, compare};
use nalgebra::{DMatrix, Vector2, dmatrix, dvector};
use std::f64::consts::PI;
use std::sync::Arc;

/// A normal distribution stays normal, with known mean and covariance, to the rounding of the exponential of a matrix: measured are
/// 1e-14 of the density.
#[test]
fn a_linear_oscillator_keeps_its_gaussian() {
    let linear = problem(Linear::new(0.5, 1.0, 0.5).unwrap());
    for transient in Closure::new(2).transient(&linear, &correlated().0, &[0.1, 0.5, 2.0, 20.0]).unwrap() {
        let (mean, spread) = linear_after(transient.time);
        for (powers, truth) in POWERS.into_iter().zip(moments(mean, spread)) {
            let moment = transient.moment(&powers).unwrap();
            assert!((moment.value - truth).abs() < 1e-12, "t = {}, {powers:?}: {moment} and {truth}", transient.time);
        }
        let z = Vector2::new(0.7, -0.4);
        let volume = 2.0 * PI * spread.determinant().sqrt();
        let truth = (-0.5 * z.dot(&(spread.try_inverse().unwrap() * z))).exp() / volume;
        let found = transient.density.pdf(&[mean[0] + z[0], mean[1] + z[1]]).unwrap();
        let estimate = transient.density.l1_estimate();
        println!("t = {}: {found} and {truth}, estimate {estimate:.1e}", transient.time);
        assert!(
            (found.value / truth - 1.0).abs() < 1e-12 && estimate < 1e-12,
            "t = {}: {found} {truth}",
            transient.time
        );
    }
}

/// dx = −x dt + √2 dW from the point 1.5: N(1.5 e^−t, 1 − e^−2t) at all times, to rounding. The first one is narrower than the places of
/// the sum.
#[test]
fn one_state_starts_from_a_point() {
    let problem = problem(OrnsteinUhlenbeck);
    let found = Closure::new(2).transient(&problem, Start::Point(vec![1.5]), &[1e-5, 0.1, 0.7, 6.0]).unwrap();
    for transient in found.iter().skip(1) {
        let (mean, variance) = (1.5 * (-transient.time).exp(), 1.0 - (-2.0 * transient.time).exp());
        let [first, second] = [1, 2].map(|power| transient.moment(&[power]).unwrap());
        assert!((first.value - mean).abs() < 1e-12, "{}: {first}", transient.time);
        assert!((second.value - variance - mean * mean).abs() < 1e-12, "{}: {second}", transient.time);
        let pdf = |x: f64| (-(x - mean).powi(2) / (2.0 * variance)).exp() / (2.0 * PI * variance).sqrt();
        let distance: f64 = (0..2000)
            .map(|i| 0.005 * f64::from(i) - 5.0)
            .map(|x| 0.005 * (transient.density.pdf(&[x]).unwrap().value - pdf(x)).abs())
            .sum();
        let estimate = transient.density.l1_estimate();
        println!("t = {}: {distance:.1e}, estimate {estimate:.1e}", transient.time);
        assert!(distance < 1e-12 && estimate < 1e-12, "t = {}: {distance:e} and {estimate:e}", transient.time);
    }
    assert!(found.iter().all(|transient| transient.density.candidates()[0].origin == Origin::Exact));
}

/// Oscillators in one well, in two and on a limit cycle, order 6, against a finer grid: the distance is at most 1.3 times that of the
/// best polynomial of the order, with the 1e-4 of the grid that it is closest to; the truth itself, projected, gave the best ones.
/// The estimate is 0.8 to 1.5 times the distance, and moments are right within their errors.
#[test]
fn densities_spread_as_on_a_grid() {
    let [start, rest] = [&normal([1.0, 0.0], 0.2), &normal([0.0, 0.0], 0.2)];
    let cases = [
        (problem(duffing()), start, [[-3.9, 3.9], [-6.2, 6.2]], vec![(2.0, 1.0e-3), (4.0, 4.7e-3)]),
        (two_wells(), start, [[-2.9, 2.9], [-5.0, 5.0]], vec![(0.5, 1.2e-4), (1.0, 4.9e-4), (2.0, 2.9e-2)]),
        (van_der_pol(), rest, [[-5.0, 5.0], [-6.5, 6.5]], vec![(2.0, 1.2e-3)]),
    ];
    // The early densities of the second case are narrow for a mesh.
    for ((problem, start, domain, best), accuracy) in cases.into_iter().zip([1e-5, 1e-6, 1e-5]) {
        let times: Vec<f64> = best.iter().map(|(time, _)| *time).collect();
        let grid = Grid::new().accuracy(accuracy).domain(domain);
        let truth = grid.solve(&problem).unwrap().transient(start, &times, 3e-4).unwrap();
        let found = Closure::new(6).transient(&problem, start, &times).unwrap();
        for ((found, truth), (time, best)) in found.iter().zip(&truth).zip(best) {
            let most = 1.3 * best + 1e-4;
            let (distance, estimate) = (l1_from(&truth.density, &found.density), found.density.l1_estimate());
            let origin = found.density.candidates()[0].origin;
            println!("t = {time}: {distance:.1e} of {most:.1e}, estimate {estimate:.1e}, {origin}");
            assert!(distance < most, "t = {time}: {distance:e}, {estimate:e}");
            assert!((0.8..1.5).contains(&(estimate / distance)), "t = {time}: {distance:e}, {estimate:e}");
            for powers in [[1, 0], [0, 1], [2, 0], [0, 2]] {
                let [own, known] = [found.moment(&powers).unwrap(), truth.moment(&powers).unwrap()];
                let apart = (own.value - known.value).abs();
                println!("   {powers:?}: {own}, {apart:.1e} off, grid {:.1e}", known.error);
                assert!(apart < own.error + known.error, "{powers:?}: {own} and {known}");
            }
        }
    }
}

/// Above an elastic wall and above one that takes energy, against a grid, and against trajectories, which share nothing with it: when
/// the density has just met the wall, and later.
#[test]
fn walls_are_met_in_time() {
    // Measured are 8.3e-4 and 9.5e-3, 1.3e-3 and 4.2e-3.
    for (restitution, most) in [(1.0, [1.0e-3, 1.2e-2]), (0.8, [1.6e-3, 5e-3])] {
        let problem = duffing_above(-0.5, restitution);
        let start = normal([1.0, 0.0], 0.2);
        let times = [1.0, 4.0];
        let stationary = Grid::new().accuracy(1e-4).solve(&problem).unwrap();
        let truth = stationary.transient(&start, &times, 1e-3).unwrap();
        let simulated = Simulation::new().trajectories(1 << 16).seed(1).transient(&problem, &start, &times).unwrap();
        let closed = Closure::new(6).transient(&problem, &start, &times).unwrap();
        for (((found, truth), simulated), most) in closed.iter().zip(&truth).zip(&simulated).zip(most) {
            let histogram = simulated.density.histogram(0).unwrap();
            let marginal = compare::with_histogram(&found.density, 0, histogram).unwrap();
            assert!(marginal.l1 < found.density.l1_estimate() + 1.2 * marginal.noise, "{marginal:?}");
            let (distance, estimate) = (l1_from(&truth.density, &found.density), found.density.l1_estimate());
            println!("r = {restitution}, t = {}: {distance:.1e}, estimate {estimate:.1e}", found.time);
            let mesh = truth.density.l1_estimate();
            assert!(
                distance < most + mesh && distance < 1.1 * estimate + mesh,
                "{distance:e} and {estimate:e} ± {mesh:e}"
            );
            assert!(estimate < 1.5 * distance + mesh, "{distance:e} and {estimate:e} ± {mesh:e}");
        }
    }
}

/// The stationary density stays as it is, and p(t₁ + t₂) from the start is p(t₂) from p(t₁), to the distance of p(t₁)'s
/// polynomial.
#[test]
fn densities_are_starts_too() -> Result<()> {
    let (problem, closure) = (two_wells(), Closure::new(8));
    let stationary: Arc<ClosureDensity> = Arc::new(closure.solve(&problem)?);
    let still = closure.transient(&problem, Start::Density(stationary.clone()), &[0.3, 3.0])?;
    for transient in &still {
        let distance = compare::l1(&transient.density, &*stationary)?;
        println!("t = {}: {distance}, estimate {:.1e}", transient.time, transient.density.l1_estimate());
        assert!(distance.value < 1e-4);
    }
    let mut from_start = closure.transient(&problem, normal([1.0, 0.0], 0.4), &[6.0, 10.0])?;
    let end = from_start.pop().unwrap().density;
    let middle = from_start.pop().unwrap().density;
    let near = middle.l1_estimate();
    let again = closure.transient(&problem, Start::Density(Arc::new(middle)), &[4.0])?.remove(0).density;
    let distance = compare::l1(&again, &end)?;
    println!("in two parts: {distance}, the first of them {near:.1e}");
    assert!(distance.value < near);
    Ok(())
}

/// Other times change no more than the steps of the grid between them; the first time may be the start itself.
#[test]
fn a_time_does_not_depend_on_the_others() -> Result<()> {
    let (problem, closure, start) = (problem(duffing()), Closure::new(4), normal([0.5, 0.0], 0.5));
    let all = closure.transient(&problem, &start, &[0.0, 1.0, 3.0, 7.0])?;
    let one = closure.transient(&problem, &start, &[3.0])?;
    let apart = compare::l1(&all[2].density, &one[0].density)?.value;
    println!("{apart:.1e}");
    assert!(apart < 0.1 * one[0].density.l1_estimate());
    let target = Closure::adaptive(0.02).transient(&problem, &start, &[7.0])?.remove(0).density;
    assert!(target.l1_estimate() < 0.02 && target.provenance().order < Some(8), "{:?}", target.provenance());
    assert!(closure.transient(&problem, &start, &[])?.is_empty());
    Ok(())
}

#[test]
fn questions_of_time_without_a_meaning_are_refused() {
    let oscillator = problem(duffing());
    let refused = |start: &Start, times: &[f64]| Closure::new(4).transient(&oscillator, start, times).unwrap_err();
    let wide = normal([0.0, 0.0], 0.5);
    let flat = Start::Gaussian(Gaussian { mean: dvector![0.0, 0.0], covariance: DMatrix::zeros(2, 2) });
    for error in [
        refused(&wide, &[1.0, 0.5]),
        refused(&wide, &[1.0, 1.0]),
        refused(&wide, &[-1.0]),
        refused(&wide, &[f64::NAN]),
        refused(&wide, &[1.0, f64::INFINITY]),
        refused(&flat, &[1.0]),
        refused(&normal([f64::NAN, 0.0], 0.5), &[1.0]),
        refused(&normal([9.0, 0.0], 0.5), &[1.0]),
        refused(&Start::Point(vec![f64::NAN, 0.0]), &[1.0]),
    ] {
        assert!(matches!(error, Error::OutOfRange { .. }), "{error}");
    }
    // So late what the stationary density loses by the edges of its domain is all that there is.
    assert!(matches!(refused(&wide, &[1e9]), Error::OutOfRange { name: "mass of a transient in the domain", .. }));
    for start in [Start::Point(vec![0.0]), Start::Gaussian(Gaussian { mean: dvector![0.0], covariance: dmatrix![1.0] })]
    {
        assert!(matches!(refused(&start, &[1.0]), Error::Dimension { expected: 2, found: 1, .. }));
    }
    let density = Closure::new(4).solve(&oscillator).unwrap();
    assert!(matches!(density.autocovariance(2, &[0.0]), Err(Error::Dimension { .. })));
    assert!(matches!(density.autocovariance(0, &[-1.0]), Err(Error::OutOfRange { .. })));
    assert!(matches!(density.spectral_density(0, &[f64::NAN]), Err(Error::OutOfRange { .. })));
    assert!(density.relaxation(0).unwrap().is_empty() && density.relaxation(usize::MAX).is_ok());
    // A document holds the density and not its equation.
    let saved: ClosureDensity = serde_json::from_str(&serde_json::to_string(&density).unwrap()).unwrap();
    assert!(matches!(saved.relaxation(2), Err(Error::NotKnown { .. })));
    // So does that of a time, and it is the same to the bit.
    let moving = Closure::new(4).transient(&oscillator, &wide, &[0.5]).unwrap().remove(0).density;
    let saved: ClosureDensity = serde_json::from_str(&serde_json::to_string(&moving).unwrap()).unwrap();
    assert_eq!(saved.pdf(&[0.3, 0.1]).unwrap(), moving.pdf(&[0.3, 0.1]).unwrap());
}
