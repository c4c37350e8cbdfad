//! The closure by a reference in three states and four: the moment equations of a higher degree on a lattice.

use super::many_states::Lorenz;
use expoly::models::{Duffing, FilteredDuffing};
use expoly::{Closure, ClosureDensity, Density, Origin, Problem, Reference};
use support::exact::Exact;

fn by_reference(order: u32, problem: &Problem) -> ClosureDensity {
    let density = Closure::new(order).reference(Reference::Equations).solve(problem).unwrap();
    assert!(matches!(density.candidates()[0].origin, Origin::MomentEquations { .. } | Origin::Exact));
    density
}

/// All exponents of even degree up to `degree` in three states.
fn even(degree: u32) -> Vec<[u32; 3]> {
    let all = (0..=degree).flat_map(|i| (0..=degree).flat_map(move |j| (0..=degree).map(move |k| [i, j, k])));
    all.filter(|powers| [2, 4].iter().any(|even| powers.iter().sum::<u32>() == *even && even <= &degree)).collect()
}

/// Means under exp(`log`) by the trapezoidal rule, whose error at this spacing is far below rounding for a density that is as
/// smooth as a polynomial of degree 8 makes it.
fn means(log: &dyn Fn(&[f64]) -> f64, reach: f64, powers: &[[u32; 3]]) -> Vec<f64> {
    let places: Vec<f64> = (-40..=40).map(|k| f64::from(k) / 40.0 * reach).collect();
    let (mut sums, mut mass) = (vec![0.0; powers.len()], 0.0);
    for &x in &places {
        for &y in &places {
            for &z in &places {
                let p = log(&[x, y, z]).exp();
                mass += p;
                for (sum, powers) in sums.iter_mut().zip(powers) {
                    *sum += p * x.powi(powers[0] as i32) * y.powi(powers[1] as i32) * z.powi(powers[2] as i32);
                }
            }
        }
    }
    sums.into_iter().map(|sum| sum / mass).collect()
}

/// A double well in a bath with memory: x″ = x − x³ + z, z′ = −x′ − z + ξ, noise on the third state alone. Its density is known,
/// and a quartic: exact at n = 4 up to the residual of the root, 6e-10 at most.
#[test]
fn a_double_well_in_a_bath_with_memory() {
    let text = r#"
        states = ["x", "v", "z"]
        [drift]
        x = "v"
        v = "x - x^3 + z"
        z = "-v - z"
        [noise.w]
        z = "1"
    "#;
    let problem = Problem::from_toml(text).unwrap();
    let log = |x: &[f64]| -2.0 * (0.5 * x[1] * x[1] - 0.5 * x[0] * x[0] + 0.25 * x[0].powi(4) + 0.5 * x[2] * x[2]);
    let density = Closure::new(4).reference(Reference::States).solve(&problem).unwrap();
    let powers = even(4);
    for (powers, truth) in powers.iter().zip(means(&log, 6.0, &powers)) {
        let found = density.moment(powers).unwrap();
        println!("{powers:?}: {:.1e} (error {:.1e})", found.value - truth, found.error);
        assert!((found.value - truth).abs() < 1e-8 * (1.0 + truth), "{powers:?}: {found} and {truth}");
        assert!((found.value - truth).abs() < 4.0 * found.error + 1e-9, "{powers:?}: {found} and {truth}");
    }
}

/// A random system whose density is exp of a polynomial of degree 6: at n = 4 the reference's moments are right within their own
/// errors (7e-9 at most), and the estimate is the distance.
#[test]
fn a_reference_has_the_moments_of_exact_densities() {
    let system = Exact::random(1, 12);
    let density = by_reference(4, &Problem::of(system.clone()).unwrap());
    let powers = even(4);
    let mut worst = 0.0_f64;
    for (powers, truth) in powers.iter().zip(means(&|x| system.log_density(x), 5.0, &powers)) {
        let found = density.moment(powers).unwrap();
        worst = worst.max((found.value - truth).abs());
        println!("{system}, {powers:?}: {:.1e} (error {:.1e})", found.value - truth, found.error);
        assert!((found.value - truth).abs() < 4.0 * found.error + 1e-8, "{powers:?}: {found} and {truth}");
    }
    assert!(worst < 2e-8);
    let (l1, estimate) = (system.l1(&density, &system.truth(4_000, 1)).unwrap(), density.l1_estimate());
    println!("{system}: worst moment {worst:.1e}, L1 {l1:.5}, estimate {estimate:.5}");
    assert!((estimate / l1 - 1.0).abs() < 0.02, "{estimate} and {l1}");
}

/// Noise behind a filter, without a known closed form: the moments by the equations of degree 10 and of degree 12 are the
/// same to six digits.
#[test]
fn moments_under_filtered_noise_are_known_to_six_digits() {
    let duffing = Duffing::new(0.5, 1.0, 1.0, 0.5).unwrap();
    let problem = FilteredDuffing::first_order(duffing, 1.0).unwrap().problem().unwrap();
    let densities = [2, 4].map(|order| by_reference(order, &problem));
    for powers in even(2) {
        let [coarse, fine] = densities.each_ref().map(|density| density.moment(&powers).unwrap());
        println!(
            "{powers:?}: {:.8} and {:.8}, errors {:.1e} and {:.1e}",
            coarse.value, fine.value, coarse.error, fine.error
        );
        let apart = (coarse.value - fine.value).abs();
        assert!(apart < 1e-6 * (1.0 + fine.value.abs()), "{powers:?}: {coarse} and {fine}");
        assert!(apart < 4.0 * coarse.error.hypot(fine.error) + 1e-9, "{powers:?}: {coarse} and {fine}");
    }
}

/// Two masses with noise on the first: the power D = 0.6 of the noise is what the dampers of both take, 0.1 v² + 0.3 v⁴ each. The
/// reference's error of that is a few ten-thousandths, the sum of eight moments' errors.
#[test]
fn four_states_have_a_reference_too() {
    let text = r#"
        states = ["x", "y", "u", "v"]
        [drift]
        x = "u"
        y = "v"
        u = "-0.1*u - 0.3*u^3 - x - x^3 - 0.5*(x - y)"
        v = "-0.1*v - 0.3*v^3 - y - y^3 - 0.5*(y - x)"
        [noise.w]
        u = "sqrt(1.2)"
    "#;
    let density = by_reference(4, &Problem::from_toml(text).unwrap());
    let (mut power, mut error) = (0.0, 0.0);
    for (powers, damping) in [([0, 0, 2, 0], 0.1), ([0, 0, 0, 2], 0.1), ([0, 0, 4, 0], 0.3), ([0, 0, 0, 4], 0.3)] {
        let moment = density.moment(&powers).unwrap();
        power += damping * moment.value;
        error += damping * moment.error;
    }
    println!("power {power:.6} ± {error:.1e}, L1 {:.4}", density.l1_estimate());
    assert!((power - 0.6).abs() < 4.0 * error && error < 1e-4, "{power} ± {error}");
    assert!((density.l1_estimate() - 0.14).abs() < 0.02 && density.warning().is_none());
}

/// Where the equations have no good solution the answer is that of the samples.
#[test]
fn what_no_reference_serves_is_left_to_the_samples() {
    let lorenz = Closure::new(2).reference(Reference::Equations).solve(&Problem::of(Lorenz).unwrap()).unwrap();
    assert_eq!(lorenz.candidates()[0].origin, Origin::MaximumLikelihood);
    assert!(lorenz.provenance().without_reference.as_ref().is_some_and(|reason| reason.contains("no good solution")));
}
