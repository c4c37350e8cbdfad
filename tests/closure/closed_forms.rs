//! The classical closure where the truth is known: exact at the order that contains it and at every order above.

use crate::common::*;
use expoly::models::{Duffing, DuffingChain, Linear, Solved};
use expoly::statistics::energy_balance;
use expoly::{
    Closure, Crossing, Density, Drift, ExpPolynomial, Intensity, Oscillator, Polynomial, Scalar, Solution, System,
    Termination, compare,
};

/// Solves at `order`, and requires a root and a joint L¹ distance to the exact density below `l1`.
fn closes(name: &str, model: &impl Solved, order: u32, l1: f64) -> Solution {
    let solution = Closure::classical(order).solve(&model.problem().unwrap()).unwrap();
    assert_eq!(solution.termination(), Termination::Root, "{name} at order {order}");
    let distance = compare::l1(&solution.density().unwrap(), &model.exact().unwrap()).unwrap();
    println!("{name}, n = {order}: L1 = {:.1e}, condition {:.1e}", distance.value, condition(&solution));
    assert!(distance.value < l1, "{name} at order {order}: L1 = {distance}, condition {:.1e}", condition(&solution));
    solution
}

fn condition(solution: &Solution) -> f64 {
    solution.provenance().condition.unwrap()
}

/// The search that ended at the solution.
fn search(solution: &Solution) -> &str {
    solution.provenance().origin.as_deref().unwrap()
}

/// The density at an order.
fn density(model: &impl Solved, order: u32) -> ExpPolynomial {
    Closure::classical(order).solve(&model.problem().unwrap()).unwrap().density().unwrap()
}

/// Two states: the bound is L¹ ≤ 1e-10; measured are 1e-14 to 1e-12, κ ε for condition numbers up to 1e4.
#[test]
fn the_closure_is_exact_at_the_order_of_the_truth() {
    closes("linear", &linear(), 2, 1e-10);
    closes("Duffing", &duffing(), 4, 1e-10);
    closes("two wells", &bistable(), 4, 1e-10);
    closes("displacement noise", &displacement_noise(), 4, 1e-10);
    closes("velocity noise", &velocity_noise(), 4, 1e-10);
    closes("three wells", &three_wells(), 6, 1e-10);
    closes("energy damping", &energy_damping(), 8, 1e-10);
}

/// Four states, n = 4 with 69 unknowns; six with 209, where p = C exp(−E/T) is known by ∂Q/∂v_i = −v_i/T and
/// ∂Q/∂x_i = (f_i + c_i v_i)/T at more places than Q has coefficients.
#[test]
fn the_closure_is_exact_in_two_and_three_degrees_of_freedom() {
    closes("chain of 2", &chain_of_two(), 4, 1e-10);
    let (damping, temperature) = ([0.2, 0.4, 0.3], 0.8);
    let chain = DuffingChain::new(&damping, 1.0, 0.3, 0.5, temperature).unwrap();
    let solution = Closure::classical(4).solve(&chain.problem().unwrap()).unwrap();
    assert_eq!((solution.termination(), solution.provenance().unknowns), (Termination::Root, Some(209)));
    let slopes: Vec<Polynomial> = (0..6).map(|i| solution.log_polynomial().derivative(i)).collect();
    let mut worst = 0.0_f64;
    for place in 0..60 {
        // Places within two deviations or so, no two states alike.
        let x: [f64; 6] = std::array::from_fn(|i| 2.0 * (f64::from(7 * place + 1) * (1.3 + i as f64)).sin());
        let (slopes, drift) = (slopes.iter().map(|q| q.evaluate(&x)).collect::<Vec<f64>>(), chain.drift(&x));
        for i in 0..3 {
            let v = x[2 * i + 1];
            worst = worst.max((slopes[2 * i + 1] + v / temperature).abs());
            worst = worst.max((slopes[2 * i] - (drift[2 * i + 1] + damping[i] * v) / temperature).abs());
        }
    }
    println!("chain of 3: slopes of Q off by {worst:.1e}, condition {:.1e}", condition(&solution));
    // Slopes of some units, sums of 209 terms that carry κ ε of rounding with κ up to 1e4.
    assert!(worst < 1e-9, "{worst:e}");
}

/// Newton's method from the Gaussian misses the limit cycle; the homotopy from the linearised system finds it, and is the
/// solution's origin.
#[test]
fn the_homotopy_finds_what_newton_does_not() {
    for order in [4, 5, 6] {
        let solution = closes("van der Pol-Rayleigh", &van_der_pol_rayleigh(), order, 1e-10);
        assert!(search(&solution).contains("homotopy"), "{}", search(&solution));
    }
    assert!(search(&closes("energy damping", &energy_damping(), 8, 1e-10)).contains("homotopy"));
}

/// Order n + 1 and n + 2 reproduce order n where the truth has order n: the same coefficients in the states, the new ones
/// zero. The coefficients carry κ ε of rounding, κ up to 1e5 here: 1e-9 relative to the largest is its upper end.
#[test]
fn higher_orders_reproduce_the_order_of_the_truth() {
    fn check(name: &str, model: &impl Solved, exact_order: u32) {
        let base = Closure::classical(exact_order).solve(&model.problem().unwrap()).unwrap().log_polynomial();
        for order in exact_order + 1..=exact_order + 4 {
            let solution = closes(name, model, order, 1e-9);
            let difference = &solution.log_polynomial() - &base;
            let relative = difference.max_coefficient() / base.max_coefficient();
            assert!(relative < 1e-9, "{name} at order {order}: {relative:e}, condition {:.1e}", condition(&solution));
        }
    }
    check("linear", &linear(), 2);
    check("Duffing", &duffing(), 4);
    check("two wells", &bistable(), 4);
    check("displacement noise", &displacement_noise(), 4);
}

/// The numbers of the closed forms, computed by one-dimensional quadrature of exp(−G/T) elsewhere.
#[test]
fn moments_have_their_known_values() {
    let near = |density: &dyn Density, powers: [u32; 2], value: f64| {
        let moment = density.moment(&powers).unwrap();
        // The tables carry twelve digits.
        assert!((moment.value / value - 1.0).abs() < 1e-11, "{powers:?}: {moment:.15} instead of {value}");
    };
    let e1 = density(&duffing(), 4);
    near(&e1, [2, 0], 0.661714969204);
    near(&e1, [4, 0], 1.12761676932);
    let e2 = density(&bistable(), 4);
    near(&e2, [2, 0], 0.840546465231);
    near(&e2, [4, 0], 1.14054646523);
    near(&density(&three_wells(), 6), [2, 0], 1.13676678784);
    let e3 = density(&van_der_pol_rayleigh(), 4);
    near(&e3, [2, 0], 0.521360652674);
    near(&e3, [4, 0], 0.503520489506);
    let e4 = density(&energy_damping(), 8);
    near(&e4, [2, 0], 0.697729334502);
    near(&e4, [0, 2], 0.993314738104);
}

/// A density that no polynomial holds: the outcome of every order is reported, and every returned result is a density.
#[test]
fn the_power_law_is_reported_as_what_it_is() {
    let system = parametric_linear();
    let exact = system.exact();
    let mut usable = 0;
    for order in 2..=8 {
        let solution = Closure::classical(order).solve(&problem(system)).unwrap();
        match solution.termination() {
            Termination::Root => {
                let density = solution.density().unwrap();
                let distance = compare::l1(&density, &exact).unwrap();
                assert!(distance.value > 1e-3 && distance.value < 1.0, "order {order}: {distance}");
                usable += 1;
            }
            _ => assert!(solution.density().is_err(), "order {order}: {}", solution.termination()),
        }
    }
    assert!(usable > 0);
}

/// The power law's own statistics: its marginals integrate to one, its moments agree with its marginals.
#[test]
fn the_power_law_is_consistent() {
    let exact = parametric_linear().exact();
    for state in [0, 1] {
        // Trapezoidal sums in x = sinh s, for which the algebraic tail becomes exponential.
        let (mut mass, mut square) = (0.0, 0.0);
        for k in -400..=400 {
            let s = f64::from(k) * 0.03;
            let weight = 0.03 * s.cosh() * exact.marginal(state, s.sinh()).unwrap().value;
            mass += weight;
            square += weight * s.sinh().powi(2);
        }
        assert!((mass - 1.0).abs() < 1e-12, "{mass}");
        // The tail beyond sinh 12 holds (1e5)^−8.
        assert!((square - exact.moment(&[2, 0]).unwrap().value).abs() < 1e-11, "{square}");
    }
    let crossing = exact.upcrossing_rate(0.7).unwrap().value;
    let sum: f64 =
        (0..4000).map(|k| (f64::from(k) + 0.5) * 0.02).map(|v| 0.02 * v * exact.pdf(&[0.7, v]).unwrap().value).sum();
    // Midpoint sums of step 0.02 over a smooth integrand whose slope at v = 0 is p(0.7, 0) ≈ 0.1: h²/24 of that.
    assert!((crossing - sum).abs() < 1e-5, "{crossing} and {sum}");
    assert_eq!(exact.moment(&[10, 0]).unwrap().value, f64::INFINITY);
}

/// Two oscillators without coupling: ln p is a sum, so that no coefficient mixes them.
#[test]
fn zero_coupling_gives_the_product() {
    let uncoupled = |damping: &[f64]| {
        let chain = DuffingChain::new(damping, 1.0, 0.3, 0.0, 0.8).unwrap();
        Closure::classical(4).solve(&chain.problem().unwrap()).unwrap().log_polynomial()
    };
    let (pair, single) = (uncoupled(&[0.2, 0.4]), uncoupled(&[0.2]));
    assert!(!single.is_zero());
    for (m, c) in pair.terms() {
        let expected = match (&m[..2], &m[2..]) {
            (own, [0, 0]) | ([0, 0], own) => single.coefficient(own),
            _ => 0.0,
        };
        // Condition numbers of a hundred: κ ε is 1e-14.
        assert!((c - expected).abs() < 1e-12, "{m:?}: {c} instead of {expected}");
    }
}

/// A pair of systems that is not in equilibrium, coupled to nothing: the closure of the product is the product of the
/// closures, though neither is exact.
#[test]
fn zero_coupling_gives_the_product_of_inexact_closures() {
    struct Pair;
    impl Drift<4, 2> for Pair {
        fn drift<S: Scalar>(&self, [x, u, y, v]: [S; 4]) -> [S; 4] {
            [u, -(u * 0.1 + u.powi(3) * 0.3 + x + x.powi(3)), v, -(v * 0.3 + y + y.powi(3) * 0.2)]
        }
        fn noise<S: Scalar>(&self, _: [S; 4]) -> [[S; 2]; 4] {
            let [o, a, b] = [0.0, 1.0, 0.7].map(S::from);
            [[o, o], [a, o], [o, o], [o, b]]
        }
    }
    struct First;
    impl Oscillator for First {
        fn force<S: Scalar>(&self, x: S, v: S) -> S {
            v * 0.1 + v.powi(3) * 0.3 + x + x.powi(3)
        }
        fn intensity(&self) -> Intensity {
            Intensity::from_sigma(1.0).unwrap()
        }
    }
    let pair = Closure::classical(4).solve(&problem(Pair)).unwrap();
    let first = Closure::classical(4).solve(&problem(First)).unwrap();
    assert_eq!((pair.termination(), first.termination()), (Termination::Root, Termination::Root));
    let (pair, first) = (pair.log_polynomial(), first.log_polynomial());
    for (m, c) in pair.terms() {
        let (own, other) = m.split_at(2);
        if other == [0, 0] {
            assert!((c - first.coefficient(own)).abs() < 1e-12, "{m:?}");
        } else if own != [0, 0] {
            assert!(c.abs() < 1e-12, "{m:?}: {c}");
        }
    }
}

/// The mean up-crossing rate of a linear oscillator is Rice's formula, that of Duffing's p(x) √(D/2πc).
#[test]
fn crossing_rates_have_their_closed_form() {
    let closed = density(&linear(), 2);
    let (sx, sv) = (0.45 / (0.3 * 2.0_f64), 0.45 / 0.3_f64);
    for level in [0.0, 0.5, 2.0] {
        let rice = (sv / sx).sqrt() / std::f64::consts::TAU * (-level * level / (2.0 * sx)).exp();
        let rate = closed.upcrossing_rate(level).unwrap();
        assert!((rate.value / rice - 1.0).abs() < 1e-12, "{rate} and {rice}");
    }
    let closed = density(&chain_of_two(), 4);
    let crossing = Crossing { displacement: 2, velocity: 3, level: 0.4, upward: true };
    let expected = closed.marginal(2, 0.4).unwrap().value * (0.8 / std::f64::consts::TAU).sqrt();
    assert!((closed.flux(crossing, 1).unwrap().value / expected - 1.0).abs() < 1e-9);
}

/// Every moment equation E[generator φ] = 0 up to degree 4 under the closed density, for an exact and for an inexact one,
/// in which those of degree 1 and 2 hold only as well as the closure.
#[test]
fn moment_equations_hold_where_the_closure_is_exact() {
    let (problem, closed) = (problem(duffing()), density(&duffing(), 4));
    for m in monomials(2, 4).into_iter().skip(1) {
        let rate = problem.operator().generator(&Polynomial::from_terms(2, [(&m, 1.0)]).unwrap());
        let mean = closed.expectation(&|x| rate.evaluate(x)).unwrap();
        assert!(mean.value.abs() < 1e-11, "{m:?}: {mean:e}", mean = mean.value);
    }
}

/// The reported quadrature error covers the true one, which the closed forms give. The estimate stops at 1e-14 of a sum's
/// size, so that a factor of ten remains for a sum's own rounding.
#[test]
fn error_estimates_cover_the_error() {
    for damping in [0.1, 1.0] {
        let density = Linear::new(damping, 4.0, damping * 0.5).unwrap().exact().unwrap();
        for (powers, truth) in [([2, 0], 0.125), ([0, 2], 0.5), ([4, 0], 3.0 * 0.125 * 0.125), ([0, 4], 0.75)] {
            let moment = density.moment(&powers).unwrap();
            assert!((moment.value - truth).abs() <= 10.0 * moment.error, "{powers:?}: {:e}", moment.value - truth);
        }
    }
}

/// Termination, search, unknowns and iterations are pinned, so that a changed algorithm cannot hide.
#[test]
fn counts_are_pinned() {
    let problem = problem(duffing());
    for (order, unknowns, iterations) in [(2, 5, 1), (3, 9, 1), (4, 14, 2), (6, 27, 2)] {
        let solution = Closure::classical(order).solve(&problem).unwrap();
        let counts = (solution.provenance().unknowns, solution.provenance().iterations);
        assert_eq!((counts, solution.termination()), ((Some(unknowns), Some(iterations)), Termination::Root));
        assert!(search(&solution).contains("Newton"), "{}", search(&solution));
    }
    assert_eq!(Closure::classical(1).solve(&problem).unwrap().termination(), Termination::NotNormalisable);
}

/// The literature's method has no usable density for van der Pol's oscillator: no root at order 6, and at order 4 a root
/// that is a density, but not this oscillator's: it dissipates many times the power that the noise injects.
#[test]
fn a_spurious_root_shows_in_the_power_balance() {
    let problem = problem(van_der_pol());
    let solution = Closure::classical(4).solve(&problem).unwrap();
    let balance = energy_balance(&problem, &solution.density().unwrap()).unwrap();
    assert!(balance.value.abs() > 0.5, "{balance}");
    assert_eq!(Closure::classical(6).solve(&problem).unwrap().termination(), Termination::NoRoot);
}

/// Units do not matter: x = αX, t = βT turns c, k, μ, D into c/β, k/β², μ/(α²β²), Dα²/β³, and the closure finds the same
/// density in every unit. L¹ carries the rounding of the density's own quadrature, 1e-14, times what the scales cost.
#[test]
fn the_closure_does_not_depend_on_units() {
    for alpha in [1e-6, 1e-2, 1.0, 1e3, 1e6] {
        for beta in [1e-4, 1.0, 1e3] {
            let [c, k, mu, d] = [
                0.2 / beta,
                1.0 / (beta * beta),
                0.3 / (alpha * alpha * beta * beta),
                0.2 * alpha * alpha / (beta * beta * beta),
            ];
            let system = Duffing::new(c, k, mu, d).unwrap();
            let solution = closes(&format!("α = {alpha}, β = {beta}"), &system, 4, 1e-10);
            let square = solution.density().unwrap().moment(&[2, 0]).unwrap().value / (alpha * alpha);
            assert!((square / 0.661714969204 - 1.0).abs() < 1e-10, "α = {alpha}, β = {beta}: {square}");
        }
    }
}
