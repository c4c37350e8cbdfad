//! The robust closure: exact where the truth is a polynomial, close to the grid where it is not, at every order.

use crate::common::*;
use expoly::models::{DuffingChain, DuffingVanDerPol, Solved};
use expoly::{
    Closure, ClosureDensity, Degrees, Density, Drift, Error, Estimate, GridDensity, Intensity, Origin, Problem,
    Reference, Scalar, Simulation, Weight, compare,
};

/// A density is exact to 1e-8 at each order; measured are 1e-12 to 5e-9, the errors of both quadratures.
fn exact(name: &str, model: &impl Solved, orders: &[u32]) {
    let (truth, problem) = (model.exact().unwrap(), model.problem().unwrap());
    for &order in orders {
        let density = Closure::new(order).solve(&problem).unwrap();
        let distance = compare::l1(&truth, &density).unwrap();
        println!("{name}, n = {order}: L1 = {:.1e}, {}", distance.value, density.candidates()[0].origin);
        assert!(distance.value < 1e-8, "{name} at order {order}: {distance:.3}");
        assert_eq!(density.candidates()[0].origin, Origin::Exact);
        assert!(density.is_root() && density.warning().is_none() && density.is_normalisable());
    }
}

#[test]
fn closed_forms_are_exact_at_their_order_and_above() {
    exact("linear", &linear(), &[2, 4, 12]);
    exact("Duffing", &duffing(), &[4, 5, 6, 8, 10, 12]);
    exact("two wells", &bistable(), &[4, 6, 8, 12]);
    exact("three wells", &three_wells(), &[6, 12]);
    exact("van der Pol-Rayleigh", &van_der_pol_rayleigh(), &[4, 8, 12]);
    exact("energy damping", &energy_damping(), &[8, 12]);
    exact("displacement noise", &displacement_noise(), &[4, 6, 12]);
    exact("velocity noise", &velocity_noise(), &[4, 12]);
}

/// Four and six states, on samples: the residual vanishes at every draw, so that chance leaves nothing, and few states do as
/// well as many. ln p to 1e-8 over five standard deviations.
#[test]
fn coupled_oscillators_in_equilibrium_are_exact() {
    let check = |chain: &DuffingChain, order: u32| {
        let problem = chain.problem().unwrap();
        let density = Closure::new(order).pilot_states(20_000).solve(&problem).unwrap();
        let (states, mut points) = (problem.dimension(), Points::new(5));
        let distance = |x: &[f64]| density.log_pdf(x).unwrap() - chain.log_density(x);
        for _ in 0..200 {
            let x = points.state(states, 1.2);
            let error = distance(&x) - distance(&vec![0.0; states]);
            assert!(error.abs() < 1e-8, "{error:e} at {x:?}");
        }
        let constant = distance(&vec![0.0; states]) + log_mass(chain, states / 2);
        println!("{states} states, n = {order}: the constant is off by {constant:.1e}");
        // Rounding on a lattice; on draws in six states the standard error of the integration.
        assert!(constant.abs() < if states > 4 { 1e-4 } else { 1e-11 }, "{constant}");
        assert!(density.warning().is_none(), "{:?}", density.warning());
    };
    check(&chain_of_two(), 4);
    check(&chain_of_two(), 6);
    check(&chain_of_three(), 4);
}

/// ln ∫ exp(−E/T): velocities are normal with the variance T = 0.8; the trapezoidal rule along the displacements, whose error
/// with these steps is far below rounding.
fn log_mass(chain: &DuffingChain, oscillators: usize) -> f64 {
    const SIDE: usize = 33;
    const STEP: f64 = 0.3;
    let place = |k: usize| STEP * (k as f64 - (SIDE / 2) as f64);
    let mut sum = 0.0;
    for node in 0..SIDE.pow(oscillators as u32) {
        let state = |i: usize| if i.is_multiple_of(2) { place(node / SIDE.pow(i as u32 / 2) % SIDE) } else { 0.0 };
        sum += chain.log_density(&(0..2 * oscillators).map(state).collect::<Vec<f64>>()).exp();
    }
    sum.ln() + oscillators as f64 * (STEP.ln() + 0.5 * (0.8 * std::f64::consts::TAU).ln())
}

/// The five systems for which no polynomial is exact, with the joint L¹ error that each order may have.
struct Case {
    name: &'static str,
    problem: Problem,
    limits: [f64; 5],
    /// The largest |log₁₀| distance down to 1e-5 of the peak at n = 12.
    tail: f64,
}

const ORDERS: [u32; 5] = [4, 6, 8, 10, 12];

/// The largest |log₁₀| distance down to 1e-5 of the peak, on a lattice over the closure's box.
fn tail(density: &ClosureDensity, truth: &GridDensity) -> f64 {
    const SIDE: usize = 150;
    let bounds = density.bounds();
    let at = |k: usize, [low, high]: [f64; 2]| low + (high - low) * (k as f64 + 0.5) / SIDE as f64;
    let points: Vec<[f64; 2]> = (0..SIDE * SIDE).map(|k| [at(k / SIDE, bounds[0]), at(k % SIDE, bounds[1])]).collect();
    let logs: Vec<f64> = points.iter().map(|x| truth.log_pdf(x).unwrap()).collect();
    let least = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max) + 1e-5_f64.ln();
    let pairs = points.iter().zip(&logs).filter(|(_, log)| **log > least);
    pairs.map(|(x, log)| (density.log_pdf(x).unwrap() - log).abs() / std::f64::consts::LN_10).fold(0.0, f64::max)
}

impl Case {
    fn check(&self) {
        let truth = on_grid(self.name, &self.problem);
        for seed in [0, 1] {
            let mut best = f64::INFINITY;
            for (order, limit) in ORDERS.into_iter().zip(self.limits) {
                let density = closed(self.name, &self.problem, order, seed);
                let (l1, estimate) = (l1_from(&truth, &*density), density.l1_estimate());
                println!(
                    "{}, seed {seed}, n = {order}: L1 {l1:.2e} (estimate {estimate:.2e}, eta {:.1e})",
                    self.name,
                    density.indicator()
                );
                assert!(l1 <= limit, "{}, seed {seed}, n = {order}: {l1:.3e} > {limit:.3e}", self.name);
                // Measured: 0.98 to 1.5, the most where the error is 5e-5.
                assert!(estimate > 0.9 * l1 && estimate < 2.0 * l1, "{}: {estimate:.2e} for {l1:.2e}", self.name);
                // No order is worse than the best lower one.
                assert!(l1 < best, "{}, n = {order}: {l1:.3e} after {best:.3e}", self.name);
                assert!(density.warning().is_none(), "{:?}", density.warning());
                best = l1;
                // 0.25 decades are the bound. Van der Pol's oscillator misses it for some seeds, with up to 0.28: the
                // reference that the choice rests on is itself off by a tenth of a decade there.
                if [4, 12].contains(&order) {
                    let tail = tail(&density, &truth);
                    println!("{}, seed {seed}, n = {order}: tail {tail:.2}", self.name);
                    assert!(order == 4 || tail <= self.tail, "{}, seed {seed}: {tail}", self.name);
                    // The density's own statement about its tails, where they are not close to the bound.
                    let right = density.tails_are_accurate();
                    assert!(if right { tail < 0.3 } else { tail > 0.2 }, "{}, n = {order}: {tail}", self.name);
                }
            }
        }
    }
}

#[test]
fn every_order_is_close_to_the_best_polynomial() {
    Case {
        name: "cubic damping",
        problem: problem(cubic_damping()),
        limits: [2.7e-2, 1.9e-3, 5e-4, 1.6e-4, 6e-5],
        tail: 0.25,
    }
    .check();
    Case {
        name: "Duffing-van der Pol",
        problem: duffing_van_der_pol(),
        limits: [0.11, 3.8e-2, 2.7e-2, 1.7e-2, 6.1e-3],
        tail: 0.25,
    }
    .check();
    let limits = [9.5e-2, 5.5e-2, 2.3e-2, 1.5e-2, 9e-3];
    Case { name: "Rayleigh", problem: problem(rayleigh()), limits, tail: 0.25 }.check();
}

#[test]
fn limit_cycles_and_wells_too() {
    let limits = [0.16, 6.5e-2, 5.2e-2, 3.1e-2, 1.7e-2];
    Case { name: "van der Pol", problem: problem(van_der_pol()), limits, tail: 0.3 }.check();
    let limits = [4.1e-2, 2.4e-2, 1e-2, 4.7e-3, 3.4e-3];
    Case { name: "two wells", problem: bistable_damping(), limits, tail: 0.25 }.check();
}

/// E x² and E v² of the reference table: within 1 % at n = 8, 0.3 % at n = 12.
#[test]
fn second_moments_of_the_reference_table() {
    let check = |name: &'static str, problem: Problem, row: &[f64]| {
        for (order, tolerance) in [(8, 1e-2), (12, 3e-3)] {
            let density = closed(name, &problem, order, 0);
            for (powers, value) in [([2, 0], row[4]), ([0, 2], row[6])] {
                let moment = density.moment(&powers).unwrap();
                println!("{name}, n = {order}, {powers:?}: {moment:.6} and {value}");
                assert!((moment.value / value - 1.0).abs() < tolerance, "{name}: {moment} and {value}");
            }
        }
    };
    let rows = reference("smooth.csv");
    check("cubic damping", problem(cubic_damping()), &rows[0]);
    check("van der Pol", problem(van_der_pol()), &rows[1]);
    check("two wells", bistable_damping(), &rows[2]);
    check("Rayleigh", problem(rayleigh()), &rows[3]);
    check("Duffing-van der Pol", duffing_van_der_pol(), &rows[4]);
}

/// Parametric noise makes a power tail, which no exponential polynomial has: the answers are those closest to a grid's, on p > 1e-6 of the
/// peak, or on p > 1e-3 where they are nearer, and the estimate is the distance.
#[test]
fn a_power_tail_has_its_distance() {
    let (exact, problem) = (parametric_linear().exact(), problem(parametric_linear()));
    let mut last = f64::INFINITY;
    // Measured: 0.130, 0.038, 0.012, 0.0063. With the tail order 4 is 0.108 off, order 8 0.022.
    for (order, limit) in [(2, 0.15), (4, 0.045), (6, 0.015), (8, 0.008)] {
        let density = Closure::new(order).solve(&problem).unwrap();
        let (l1, estimate) = (compare::l1(&density, &exact).unwrap().value, density.l1_estimate());
        println!("n = {order}: L1 {l1:.2e}, estimate {estimate:.2e}, {:?}", density.warning());
        assert!((estimate / l1 - 1.0).abs() < 0.1, "n = {order}: {l1:e}, estimate {estimate:e}");
        assert!(l1 < limit && estimate < last, "n = {order}: {l1:e}, estimate {estimate:e}");
        last = estimate;
    }
}

/// The same seed gives the same bits on one thread and on two, on Gauss nodes and on states; another seed
/// gives another pilot, and the same density within its error.
#[test]
fn seeds_decide_and_threads_do_not() {
    let problem = problem(cubic_damping());
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    for reference in [Reference::Equations, Reference::States] {
        let solve = |seed| Closure::new(6).reference(reference).seed(seed).solve(&problem).unwrap();
        let (one, two) = (pool(1).install(|| solve(3)), pool(2).install(|| solve(3)));
        assert_eq!(one.coefficients(), two.coefficients());
        assert_eq!(one.moment(&[2, 2]).unwrap(), two.moment(&[2, 2]).unwrap());
        let other = solve(4);
        assert_ne!(one.coefficients(), other.coefficients());
        let (a, b) = (one.moment(&[0, 2]).unwrap().value, other.moment(&[0, 2]).unwrap().value);
        assert!((a / b - 1.0).abs() < 5e-3, "{a} and {b}");
    }
}

/// On samples the smooth system's error falls with the order as it does on Gauss nodes, until the number of states limits it;
/// the limits are twice what was measured.
#[test]
fn samples_do_as_well_where_the_density_is_smooth() {
    let problem = problem(cubic_damping());
    let truth = on_grid("cubic damping", &problem);
    for (order, limit) in [(4, 4.6e-2), (6, 3.6e-3), (8, 1.03e-3)] {
        let density = Closure::new(order).reference(Reference::States).solve(&problem).unwrap();
        let l1 = l1_from(&truth, &density);
        println!("n = {order}: L1 {l1:.2e}, estimate {:.2e}", density.l1_estimate());
        assert!(l1 < limit, "n = {order}: {l1:e}");
        assert!(density.effective_draws().unwrap() > 1e5);
    }
}

/// The adaptive closure stops at the lowest order that meets the target, and where none does, its estimate is the least that
/// was reached.
#[test]
fn the_order_adapts_to_the_target() {
    let density = Closure::adaptive(1e-3).solve(&problem(cubic_damping())).unwrap();
    assert_eq!(density.provenance().order, Some(8));
    assert!(density.l1_estimate() <= 1e-3);
    let hard = Closure::adaptive(1e-9).solve(&problem(van_der_pol())).unwrap();
    assert!(hard.l1_estimate() > 1e-9 && hard.l1_estimate() < 2e-2, "{}", hard.l1_estimate());
    let easy = Closure::adaptive(1e-6).solve(&problem(duffing())).unwrap();
    // What the rules of its integrals differ by is rounding: 1e-14.
    assert!(easy.provenance().order == Some(4) && easy.l1_estimate() < 1e-13, "{}", easy.l1_estimate());
}

/// More weight for the tails costs accuracy in the middle and buys it outside.
#[test]
fn the_weight_trades_the_middle_for_the_tails() {
    let problem = problem(van_der_pol());
    let truth = on_grid("van der Pol", &problem);
    let solve = |weight| Closure::new(8).weight(weight).solve(&problem).unwrap();
    let (middle, tails) = (solve(Weight::Density), solve(Weight::Tails(0.2)));
    let l1 = |density: &ClosureDensity| l1_from(&truth, density);
    assert!(l1(&middle) < l1(&tails) && l1(&tails) < 2.0 * l1(&middle));
    let near_the_peak = |density: &ClosureDensity| {
        // Where the middle's weight lets go: between 1e-3 and 1e-4 of the peak on the displacement's axis.
        [3.0, 3.1, 3.2]
            .map(|x| (density.log_pdf(&[x, 0.0]).unwrap() - truth.log_pdf(&[x, 0.0]).unwrap()).abs())
            .into_iter()
            .sum::<f64>()
    };
    assert!(near_the_peak(&tails) < near_the_peak(&middle));
    // λ = 0 gives the moments of the reference up to the order; they are right to the reference's error.
    assert!(middle.moment(&[2, 0]).unwrap().deviation(2.20474833) < 1.0);
    assert!((middle.moment(&[2, 0]).unwrap().value / 2.20474833 - 1.0).abs() < 2e-3);
}

/// Outside its trust domain a density is 0; the mass there is its `truncated_mass`.
#[test]
fn a_density_knows_where_it_ends() {
    let problem = problem(van_der_pol());
    let density = closed("van der Pol", &problem, 6, 0);
    assert!(!density.is_normalisable(), "the best sextic of van der Pol's density turns up");
    let far = [0.0, 30.0];
    assert!(!density.contains(&far).unwrap() && density.contains(&[0.0, 0.0]).unwrap());
    assert_eq!(density.log_pdf(&far).unwrap(), f64::NEG_INFINITY);
    let unseen = density.truncated_mass();
    assert!(unseen > 0.0 && unseen < 1e-3, "{unseen}");
    let mass = density.expectation(&|_| 1.0).unwrap().value;
    assert!((mass - 1.0).abs() < 1e-12);
}

/// One state: x′ = x − x³ + ξ, p ∝ exp((x²/2 − x⁴/4)/D), and x′ = −x|x| as a cubic that no quartic is exact for.
#[test]
fn one_state_is_exact_and_approached() {
    struct Overdamped {
        cubic: f64,
        quintic: f64,
    }
    impl Drift<1, 1> for Overdamped {
        fn drift<S: Scalar>(&self, [x]: [S; 1]) -> [S; 1] {
            [x - x.powi(3) * self.cubic - x.powi(5) * self.quintic]
        }
        fn noise<S: Scalar>(&self, _: [S; 1]) -> [[S; 1]; 1] {
            [[S::from(Intensity::new(0.4).unwrap().amplitude())]]
        }
    }
    let density = Closure::new(4).solve(&problem(Overdamped { cubic: 1.0, quintic: 0.0 })).unwrap();
    let shape = |x: f64| ((x * x / 2.0 - x.powi(4) / 4.0) / 0.4).exp();
    let ratio = |x: f64| density.pdf(&[x]).unwrap().value / shape(x);
    assert!((ratio(1.3) / ratio(0.1) - 1.0).abs() < 1e-8);
    assert_eq!(density.candidates()[0].origin, Origin::Exact);
    // A sextic potential needs n = 6; the estimate is large at n = 4, and 0 but for rounding at n = 6.
    let sextic = problem(Overdamped { cubic: 0.5, quintic: 0.3 });
    assert!(Closure::new(4).solve(&sextic).unwrap().l1_estimate() > 1e-3);
    assert_eq!(Closure::new(6).solve(&sextic).unwrap().candidates()[0].origin, Origin::Exact);
}

/// Moments up to the order, by the closure and by a simulation: both calibrated, each to a thousandth (measured are 7e-4 and
/// 3e-4 at most), and within four of their standard errors, or the rounding of a moment that the equations give exactly.
fn same(p: Estimate, q: Estimate, powers: &[u32]) {
    assert!(p.error < 1e-3 * p.value && q.error < 1e-3 * q.value, "{powers:?}: {p} and {q}");
    assert!((p.value - q.value).abs() < 4.0 * p.error.hypot(q.error) + 1e-9, "{powers:?}: {p} and {q}");
}

/// Coloured noise: an oscillator driven by a filtered noise has three states; moments against a simulation. A filter's powers
/// can be limited.
#[test]
fn coloured_noise_through_a_filter() {
    struct Filtered;
    impl Drift<3, 1> for Filtered {
        fn drift<S: Scalar>(&self, [x, v, f]: [S; 3]) -> [S; 3] {
            [v, f - v * 0.3 - v.powi(3) * 0.2 - x - x.powi(3), -(f * 2.0)]
        }
        fn noise<S: Scalar>(&self, _: [S; 3]) -> [[S; 1]; 3] {
            let zero = S::from(0.0);
            [[zero], [zero], [S::from(2.0 * Intensity::new(0.5).unwrap().amplitude())]]
        }
    }
    let problem = problem(Filtered);
    let truth = Simulation::new().samples(400_000).seed(7).run(&problem).unwrap();
    let check = |density: &ClosureDensity| {
        for powers in [[2, 0, 0], [0, 2, 0], [0, 0, 2], [4, 0, 0], [0, 4, 0]] {
            let (p, q) = (density.moment(&powers).unwrap(), truth.moment(&powers).unwrap());
            println!("{powers:?}: {p:.5} and {q:.5}");
            same(p, q, &powers);
        }
        assert!(density.warning().is_none(), "{:?}", density.warning());
    };
    let whole = Closure::new(6).solve(&problem).unwrap();
    check(&whole);
    let density = Closure::new(6).degrees(Degrees::complete().at_most(2, 2)).solve(&problem).unwrap();
    assert!(density.provenance().unknowns < whole.provenance().unknowns);
    check(&density);
}

/// A chain of two oscillators with cubic damping and unequal intensities: no Gibbs density.
#[test]
fn a_chain_out_of_equilibrium() {
    struct Chain;
    impl Drift<4, 2> for Chain {
        fn drift<S: Scalar>(&self, [x, y, u, v]: [S; 4]) -> [S; 4] {
            let spring = (x - y) * 0.5;
            let force = |x: S, v: S| v * 0.1 + v.powi(3) * 0.3 + x + x.powi(3);
            [u, v, -force(x, u) - spring, -force(y, v) + spring]
        }
        fn noise<S: Scalar>(&self, _: [S; 4]) -> [[S; 2]; 4] {
            let [a, b] = [0.3, 0.6].map(|d| S::from(Intensity::new(d).unwrap().amplitude()));
            let zero = S::from(0.0);
            [[zero, zero], [zero, zero], [a, zero], [zero, b]]
        }
    }
    let problem = problem(Chain);
    let density = Closure::new(4).solve(&problem).unwrap();
    assert_eq!(density.provenance().unknowns, Some(45));
    let truth = Simulation::new().samples(1_000_000).seed(3).run(&problem).unwrap();
    for state in 0..4 {
        for power in [2, 4] {
            let mut powers = [0; 4];
            powers[state] = power;
            let (p, q) = (density.moment(&powers).unwrap(), truth.moment(&powers).unwrap());
            println!("{powers:?}: {p:.5} and {q:.5}");
            same(p, q, &powers);
        }
    }
    assert!(density.warning().is_none() && density.l1_estimate() < 0.2, "{}", density.l1_estimate());
}

/// Options without a meaning, and systems without a density.
#[test]
fn bad_input_is_refused_by_name() {
    let system = problem(duffing());
    let refused = |closure: Closure| match closure.solve(&system) {
        Err(Error::OutOfRange { name, .. }) => name,
        other => panic!("{other:?}"),
    };
    assert_eq!(refused(Closure::new(0)), "order of the closure");
    assert_eq!(refused(Closure::new(17)), "order of the closure");
    assert_eq!(refused(Closure::adaptive(f64::NAN)), "target of the L1 error");
    assert_eq!(refused(Closure::new(4).pilot_states(0)), "number of the pilot's states");
    // Five million functions of ten states.
    let chain = DuffingChain::new(&[0.3; 5], 1.0, 0.3, 0.5, 0.8).unwrap().problem().unwrap();
    let many = Closure::new(16).pilot_states(5120).solve(&chain);
    assert!(matches!(many, Err(Error::NotClosed { order: 16, .. })), "{many:?}");
    // Every function of order 1 is odd, and the chain is symmetric.
    let odd = Closure::new(1).pilot_states(5120).solve(&chain);
    assert!(matches!(odd, Err(Error::NotClosed { order: 1, .. })), "{odd:?}");
    assert_eq!(refused(Closure::new(4).inflation(0.5)), "inflation of the pilot's intensity");
    assert_eq!(refused(Closure::new(4).weight(Weight::Tails(1.5))), "share of the tails");
    assert_eq!(refused(Closure::new(4).degrees(Degrees::complete().weighted(0, 0.0))), "weight of a degree");
    let third = Closure::new(4).degrees(Degrees::complete().at_most(2, 1)).solve(&system);
    assert!(matches!(third, Err(Error::Dimension { .. })), "{third:?}");
    // Negative damping without bound, and a potential without a bottom: no trajectory stays.
    let unstable = |damping, stiffness, cubic| DuffingVanDerPol::new(damping, stiffness, cubic, 0.5).unwrap();
    for system in [unstable([-0.5, 0.0], 1.0, 1.0), unstable([0.5, 0.0], -1.0, -1.0)] {
        assert!(matches!(Closure::new(4).solve(&problem(system)), Err(Error::Exploded { .. })));
    }
    let chain = Closure::new(4).reference(Reference::Equations).solve(&chain_of_three().problem().unwrap());
    assert!(matches!(chain, Err(Error::NotServed { method: "closure", .. })), "{chain:?}");
    // A start from a density of another number of states.
    let near = closed_chain();
    let start = Closure::new(4).starting_from(&*near).solve(&system);
    assert!(matches!(start, Err(Error::Dimension { .. })), "{start:?}");
}
