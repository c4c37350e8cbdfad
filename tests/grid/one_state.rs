//! Systems of one state against closed forms: densities, derivatives, relaxation, transients and first passages.

use crate::common::{OrnsteinUhlenbeck, problem};
use expoly::{Density, Gaussian, Grid, Problem, Sensitivity, Start};
use nalgebra::{dmatrix, dvector};

/// dx = −x dt + √2 dW is normal with variance one, and with −x³ in place of −x the density is
/// exp(−x⁴/4) √2/Γ(1/4).
#[test]
fn densities_are_as_exact_as_was_asked_for() {
    let cubic = Problem::from_toml("states = ['x']\ndrift.x = '-x^3'\nnoise.w.x = 'sqrt(2)'").unwrap();
    let normal: fn(f64) -> f64 = |x| (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt();
    // ∫ exp(−x⁴/4) dx = Γ(1/4)/√2.
    let flat: fn(f64) -> f64 = |x| (-0.25 * x.powi(4)).exp() * std::f64::consts::SQRT_2 / 3.625_609_908_221_908;
    for (name, problem, exact) in [("normal", problem(OrnsteinUhlenbeck), normal), ("cubic", cubic, flat)] {
        for accuracy in [1e-4, 1e-9] {
            let density = Grid::new().accuracy(accuracy).solve(&problem).unwrap();
            let [low, high] = density.bounds()[0];
            // By the midpoint rule: h² of a second derivative of |p̃ − p| relative to itself.
            let (steps, mut distance) = (20_000, 0.0);
            let h = (high - low) / f64::from(steps);
            for k in 0..steps {
                let x = low + (f64::from(k) + 0.5) * h;
                distance += h * (density.pdf(&[x]).unwrap().value - exact(x)).abs();
            }
            let estimate = density.l1_estimate();
            println!("{name}, accuracy {accuracy:e}: {distance:.1e}, estimate {estimate:.1e}");
            assert!(distance < estimate && distance < accuracy, "{name}: {distance:e}, {estimate:e}");
        }
    }
}

/// dx = (x − x³) dt + s x dW: where the noise vanishes, at 0, nothing passes. By d ln|x|, E x² = 1 − s²/2 on either side, on which
/// p ~ |x|^(2/s² − 2) exp(−x²/s²).
#[test]
fn noise_that_vanishes_parts_the_line() {
    let text = |sign: &str, s: f64| {
        format!("states = ['x']\ndrift.x = 'x - x^3{sign}'\nnoise.w.x = '{s}*x'\ninterpretation = 'ito'")
    };
    for s in [0.5_f64, 0.8] {
        let density = Grid::new().solve(&Problem::from_toml(&text("", s)).unwrap()).unwrap();
        let ([low, high], square) = (density.bounds()[0], density.moment(&[2]).unwrap());
        println!("{low:e} to {high}, E x2 {square}, {:?}", density.provenance().warning);
        assert!(low * high > 0.0 && (square.value - (1.0 - s * s / 2.0)).abs() < 1e-9, "{square}");
        assert!(density.provenance().warning.as_ref().is_some_and(|warning| warning.contains("vanishes at 0.0")));
    }
    // From x = 0 on a constant force leads to the side above, and none comes back.
    let density = Grid::new().solve(&Problem::from_toml(&text(" + 0.1", 0.5)).unwrap()).unwrap();
    assert!(density.bounds()[0][0] > 0.0);
}

/// Of a low degree many cells hold the closed form, and of the lowest ones none would: it takes 6 in place of 3.
#[test]
fn a_low_degree_holds_the_closed_form() {
    let by = [3, 6].map(|degree| Grid::new().degree(degree).accuracy(4e-3).solve(&problem(OrnsteinUhlenbeck)).unwrap());
    let [low, least] = by.each_ref().map(|density| density.moment(&[2]).unwrap().value);
    assert!((low - 1.0).abs() < 1e-13 && low == least, "{low}, {least}");
}

/// Wells of 5800 temperatures, V = −49.8 x² + .328 x⁶/6 with T = .1: p is exp of a sum of that size and has the sum's rounding, at which
/// the mesh ends. E x² by the trapezoidal rule about a bottom, at 40 000 places.
#[test]
fn deep_wells_are_resolved_to_the_rounding_of_their_exponent() {
    let text = "states = ['x']\ndrift.x = '99.6*x - 0.328*x^5'\nnoise.w.x = 'sqrt(0.2)'";
    let density = Grid::new().solve(&Problem::from_toml(text).unwrap()).unwrap();
    let square = density.moment(&[2]).unwrap();
    println!("{square}, estimate {:.1e}, {} cells", density.l1_estimate(), density.cells().len());
    assert!((square.value / 17.42479672718384 - 1.0).abs() < 1e-12 && density.l1_estimate() < 1e-9, "{square}");
}

/// dx = −k x dt + √(2D) dW: E x² = D/k.
#[test]
fn derivatives_are_those_of_closed_forms() {
    let text = "states = ['x']\ndrift.x = '-k*x'\nnoise.w.x = 'sqrt(2*D)'\n[parameters]\nk = 2.0\nD = 0.6";
    let density = Grid::new().solve(&Problem::from_toml(text).unwrap()).unwrap();
    let by = density.sensitivities(&["k", "D"]).unwrap();
    for (by, exact) in by.iter().zip([-0.15, 0.5]) {
        let square = by.moment(&[2]).unwrap();
        println!("{square}, {exact}");
        assert!((square.value - exact).abs() < square.error.max(1e-13) && square.error < 1e-10, "{square} and {exact}");
    }
}

/// dx = −x dt + √2 dW relaxes with the rates 0, 1, 2, … of Hermite's polynomials, and a normal start stays normal with the mean
/// m e⁻ᵗ and the variance 1 + (s − 1) e⁻²ᵗ; s = 0 is a point.
#[test]
fn a_linear_system_relaxes_and_moves_as_it_should() {
    let density = Grid::new().accuracy(1e-8).solve(&problem(OrnsteinUhlenbeck)).unwrap();
    for (k, mode) in density.relaxation(4).unwrap().iter().enumerate() {
        println!("{mode:?}");
        // Rounding, on a mesh that holds the density to rounding: 2e-12.
        assert!((mode.rate - k as f64).abs() < 1e-11 && mode.frequency.abs() < 1e-11, "{mode:?}");
    }
    let normal = Start::Gaussian(Gaussian { mean: dvector![1.2], covariance: dmatrix![0.3] });
    for (start, m, s) in [(normal, 1.2, 0.3), (Start::Point(vec![-0.7]), -0.7, 0.0)] {
        let times = [0.3, 1.0, 3.0];
        for (later, t) in density.transient(&start, &times, 1e-5).unwrap().iter().zip(times) {
            let (mean, variance) = (m * (-t).exp(), 1.0 + (s - 1.0) * (-2.0 * t).exp());
            let [first, second] = [1, 2].map(|power| later.moment(&[power]).unwrap());
            println!("t = {t}: {:.1e}, {:.1e}", first.value - mean, second.value - variance - mean * mean);
            // A tenth of the accuracy: 3e-7 is the most of them.
            assert!((first.value - mean).abs() < 1e-6, "{first} and {mean}");
            assert!((second.value - variance - mean * mean).abs() < 1e-6, "{second}");
        }
    }
}

/// dx = −x dt + √2 dW first leaves a range between zeros of Hermite's polynomial of degree n with the rate n. From x on, above a
/// mirror or nothing at l, it is at b after ∫ exp(y²/2) ∫ exp(−z²/2) dz dy in the mean, y from x to b and z from l to y.
#[test]
fn first_passages_have_their_rates_and_mean_times() {
    let density = Grid::new().solve(&problem(OrnsteinUhlenbeck)).unwrap();
    for (within, exact) in [([0.0, f64::INFINITY], 1.0), ([-1.0, 1.0], 2.0), ([0.0, 3.0_f64.sqrt()], 3.0)] {
        let rate = density.survival(within).unwrap().rate().unwrap();
        println!("{within:?}: {rate}");
        assert!((rate.value - exact).abs() < rate.error.max(1e-12) && rate.error < 1e-9, "{rate} instead of {exact}");
    }
    // By the trapezoidal rule, whose error is of the order of the step's square: 1e-8.
    let mean_time = |from: f64, [x, b]: [f64; 2]| {
        let (h, mut inner, mut sum) = (1e-4, 0.0, 0.0);
        for k in 0..((b - from) / h).round() as usize {
            let [one, two] = [k, k + 1].map(|k| from + h * k as f64);
            let next = inner + 0.5 * h * ((-0.5 * one * one).exp() + (-0.5 * two * two).exp());
            if one > x - 0.5 * h {
                sum += 0.5 * h * (inner * (0.5 * one * one).exp() + next * (0.5 * two * two).exp());
            }
            inner = next;
        }
        sum
    };
    // Symmetry makes a mirror of the middle.
    for (within, x, from) in [([-1.5, 1.5], 0.0, 0.0), ([f64::NEG_INFINITY, 1.0], -0.5, -9.0)] {
        let found = density.survival(within).unwrap().mean_time(&Start::Point(vec![x])).unwrap();
        let exact = mean_time(from, [x, within[1]]);
        println!("{within:?} from {x}: {found}, {exact}");
        assert!((found.value - exact).abs() < found.error + 1e-8 && found.error < 1e-11, "{found} instead of {exact}");
    }
}
