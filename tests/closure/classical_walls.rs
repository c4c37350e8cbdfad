//! The closure above a wall: closed forms for r = 1, the reference solution for r < 1, and the limits of the method.
//!
//! `reference/vibro_impact_displacement_pdf.csv` holds p_Y at Gauss nodes with their weights, so that a weighted sum of
//! |p − p_Y| is an L¹ distance; it is accurate to about 1e-6 near the peak and 1e-3 at the wall.

use crate::common::*;
use expoly::models::{Duffing, Solved, VibroImpactDuffing};
use expoly::statistics::energy_balance;
use expoly::{Basis, Closure, Crossing, Density, Error, ExpPolynomial, Problem, Solution, Termination, Wall, compare};
use support::walls;

fn solve(order: u32, basis: Basis, offset: f64, restitution: f64) -> Solution {
    Closure::classical(order).basis(basis).solve(&duffing_above(offset, restitution)).unwrap()
}

/// L¹ distance of p_Y to the reference; in the range that the reference covers.
fn l1_to_reference(density: &ExpPolynomial, offset: f64, restitution: f64) -> f64 {
    let rows = reference("vibro_impact_displacement_pdf.csv");
    let rows = rows.iter().filter(|row| row[3] == offset && row[4] == restitution);
    let distance = rows.map(|row| row[7] * (density.marginal(0, row[6]).unwrap().value - row[8]).abs()).sum();
    println!("b = {offset}, r = {restitution}: L1 of p_Y = {distance:.2e}");
    distance
}

/// r = 1 in the folded basis is exact wherever the wall stands; the bound is L¹ ≤ 1e-9, measured are 1e-14 to 1e-12.
#[test]
fn an_elastic_wall_is_exact_in_the_folded_basis() {
    for offset in [-0.5, 0.0, 0.2, 0.5] {
        for order in [4, 6] {
            let solution = solve(order, Basis::Folded, offset, 1.0);
            assert_eq!(solution.termination(), Termination::Root);
            let density = solution.density().unwrap();
            let exact = duffing().exact_above(offset).unwrap();
            let distance = compare::l1(&density, &exact).unwrap();
            println!("folded, n = {order}, b = {offset}, r = 1: joint L1 = {:.1e}", distance.value);
            assert!(distance.value < 1e-9, "b = {offset}, n = {order}: {:e}", distance.value);
            // Impacts at the rate p_Y(b) √(D/2πc), D = c here.
            let rate = density.flux(Crossing::downward(offset), 1).unwrap();
            let expected = exact.marginal(0, offset).unwrap().value / std::f64::consts::TAU.sqrt();
            assert!((rate.value / expected - 1.0).abs() < 1e-9, "{rate} and {expected}");
        }
    }
}

/// At b = 0 the classical basis is exact too: for Duffing, for two wells, and with noise in the displacement.
#[test]
fn an_elastic_wall_at_the_rest_position_is_exact_in_the_classical_basis() {
    fn check(system: &impl Solved) {
        let problem = system.problem().unwrap().with_wall(Wall::above(0.0, 1.0).unwrap()).unwrap();
        for basis in [Basis::Classical, Basis::Folded] {
            let solution = Closure::classical(4).basis(basis).solve(&problem).unwrap();
            let density = solution.density().unwrap();
            let distance = compare::l1(&density, &system.exact_above(0.0).unwrap()).unwrap();
            println!("{basis}, n = 4, b = 0, r = 1: joint L1 = {:.1e}", distance.value);
            assert!(distance.value < 1e-10, "{basis}: {:e}", distance.value);
        }
    }
    check(&duffing());
    check(&bistable());
    check(&displacement_noise());
}

/// Classical basis, n = 4, against the reference. The values are this method's own error, pinned to 3 %: the quadrature
/// and the reference are better than 1e-5.
#[test]
fn the_classical_closure_has_its_known_error() {
    for (offset, restitution, expected) in
        [(0.0, 0.98, 3.12e-3), (0.0, 0.95, 6.92e-3), (-0.5, 0.98, 3.39e-2), (-0.5, 0.95, 3.08e-2), (-0.5, 0.9, 2.95e-2)]
    {
        let density = solve(4, Basis::Classical, offset, restitution).density().unwrap();
        print!("classical n = 4, ");
        let distance = l1_to_reference(&density, offset, restitution);
        assert!((distance / expected - 1.0).abs() < 0.03, "b = {offset}, r = {restitution}: {distance:e}");
    }
}

/// At (0, 0.9) and (0.2, 0.95) the classical root of order 4 has a leading form with a positive direction: no density.
/// Cut off where the figures of the literature end, exp(Q) is close to p_Y all the same.
#[test]
fn a_root_that_turns_upwards_is_no_density_but_can_be_cut_off() {
    for (offset, restitution, expected) in [(0.0, 0.9, 1.24e-2), (0.2, 0.95, 2.17e-2)] {
        let solution = solve(4, Basis::Classical, offset, restitution);
        assert_eq!(solution.termination(), Termination::NotNormalisable);
        assert!(matches!(solution.density(), Err(Error::NotNormalisable { order: 4, .. })));
        let region = [[offset, offset + 3.5], [-4.5, 4.5]];
        let cut = ExpPolynomial::cut_off(&solution.log_polynomial(), &region).unwrap();
        print!("classical n = 4, cut off, ");
        let distance = l1_to_reference(&cut, offset, restitution);
        assert!((distance / expected - 1.0).abs() < 0.03, "b = {offset}, r = {restitution}: {distance:e}");
    }
}

/// The folded basis follows the kink at a wall below the rest position: ten times closer at the same order.
#[test]
fn the_folded_closure_has_its_known_error() {
    for (restitution, expected) in [(0.98, 1.05e-3), (0.95, 2.62e-3), (0.9, 5.12e-3)] {
        let density = solve(4, Basis::Folded, -0.5, restitution).density().unwrap();
        print!("folded n = 4, ");
        let distance = l1_to_reference(&density, -0.5, restitution);
        assert!((distance / expected - 1.0).abs() < 0.03, "r = {restitution}: {distance:e}");
    }
}

/// Order 6 of the literature's method, r = 0.9: no usable density at any wall, and the solution has the reason.
#[test]
fn the_classical_order_six_has_no_usable_density() {
    for offset in [0.0, 0.2, -0.5] {
        let solution = solve(6, Basis::Classical, offset, 0.9);
        assert_eq!(solution.termination(), Termination::NoRoot, "b = {offset}");
        let error = solution.density().unwrap_err();
        assert!(matches!(error, Error::NotClosed { order: 6, .. }) && error.to_string().contains("no root"), "{error}");
        assert!(solution.provenance().residual.unwrap() > 1e-4, "the last iterate is kept");
        assert_eq!(solution.log_polynomial().degree(), 6);
    }
}

/// Across the wall's line the classical Q is smooth and even, so that approach and rebound are alike; the folded one
/// distinguishes them by the wall condition p(0, w) = r⁻² p(0, −w/r).
#[test]
fn the_bases_differ_at_the_wall_as_they_should() {
    let classical = solve(4, Basis::Classical, 0.0, 0.95).density().unwrap();
    let folded = solve(4, Basis::Folded, -0.5, 0.95).density().unwrap();
    for speed in [0.3, 1.0, 2.0] {
        let [out, back] = [speed, -speed].map(|v| classical.pdf(&[0.0, v]).unwrap().value);
        assert!((out / back - 1.0).abs() < 1e-10, "{out} and {back}");
    }
    // A polynomial meets the condition in the mean over the impacts: exactly near their typical speed, 1 here, and off by
    // up to 9 % elsewhere, against the 11 % that an elastic wall would be off.
    let ratio = |speed: f64| {
        folded.pdf(&[-0.5, speed]).unwrap().value / folded.pdf(&[-0.5, -speed / 0.95]).unwrap().value * 0.95 * 0.95
    };
    assert!((ratio(1.0) - 1.0).abs() < 0.01, "{}", ratio(1.0));
    assert!(ratio(0.3) < 0.95 && ratio(2.0) > 1.05, "{} and {}", ratio(0.3), ratio(2.0));
}

/// Statistics of the folded closure at order 4 against the reference: its largest error is the 0.7 % of E Y′², to which a
/// distance of 2.6e-3 in p_Y belongs; and its power balance.
#[test]
fn the_folded_closure_has_the_right_statistics() {
    let row = walls::table().unwrap().into_iter().find(|row| [row.b, row.r] == [-0.5, 0.95]).unwrap();
    let density = solve(4, Basis::Folded, -0.5, 0.95).density().unwrap();
    let close = |name: &str, value: f64, truth: f64| {
        assert!((value / truth - 1.0).abs() < 1e-2, "{name}: {value} instead of {truth}");
    };
    close("E Y", density.moment(&[1, 0]).unwrap().value, row.mean);
    close("Var Y", density.variance(0).unwrap().value, row.variance);
    close("E Y'^2", density.moment(&[0, 2]).unwrap().value, row.square);
    close("impact rate", density.flux(Crossing::downward(-0.5), 1).unwrap().value, row.impact_rate);
    let balance = energy_balance(&duffing_above(-0.5, 0.95), &density).unwrap();
    assert!(balance.value.abs() < 1e-2, "{balance}");
    assert!(density.moment(&[0, 1]).unwrap().value.abs() < 1e-2);
}

/// The back-transformation adds the two images: the density on the plane is symmetric, holds half of p_Y on each side,
/// and comes back as it was.
#[test]
fn the_back_transformation_inverts_the_forward_one() {
    let model = VibroImpactDuffing::new(duffing(), 0.2, 0.98).unwrap();
    let density = Closure::classical(2).solve(&model.problem().unwrap()).unwrap().density().unwrap();
    let wall = model.wall();
    let plane = |point: [f64; 2]| wall.unfolded_density(|state| density.pdf(&state).unwrap().value, point);
    let mut points = Points::new(17);
    for _ in 0..20 {
        let point = points.array(1.5);
        assert_eq!(plane(point), plane(point.map(|c| -c)));
        let state = wall.unfolded_state(point);
        let p = density.pdf(&state).unwrap().value;
        assert!((wall.folded_density(plane, state) / p - 1.0).abs() < 1e-12);
    }
    assert_eq!(wall.folded_density(plane, [0.1, 0.3]), 0.0);
}

/// The values of a density are consistent: marginals integrate to one and to the moments.
#[test]
fn marginals_moments_and_flux_fit_together() {
    let density = solve(4, Basis::Folded, -0.5, 0.9).density().unwrap();
    let (mut mass, mut mean, mut velocity_mass) = (0.0, 0.0, 0.0);
    let step = 0.01;
    for k in 0..600 {
        let y = -0.5 + (f64::from(k) + 0.5) * step;
        let p = density.marginal(0, y).unwrap().value;
        (mass, mean) = (mass + step * p, mean + step * p * y);
        velocity_mass += step * 2.0 * density.marginal(1, -6.0 + 2.0 * (f64::from(k) + 0.5) * step).unwrap().value;
    }
    // The midpoint rule is off by h²/24 times the jump of the slope at the wall, about 0.5: 2e-6.
    assert!((mass - 1.0).abs() < 1e-5, "{mass}");
    assert!((mean - density.moment(&[1, 0]).unwrap().value).abs() < 1e-5);
    assert!((velocity_mass - 1.0).abs() < 1e-9, "{velocity_mass}");
    assert_eq!(density.marginal(0, -0.6).unwrap().value, 0.0);
    assert_eq!(density.log_pdf(&[-0.6, 0.0]).unwrap(), f64::NEG_INFINITY);
}

/// Units do not matter above a wall either: y = αY, t = βT.
#[test]
fn the_closure_above_a_wall_does_not_depend_on_units() {
    for basis in [Basis::Classical, Basis::Folded] {
        let reference = solve(4, basis, -0.5, 0.95).density().unwrap();
        for (alpha, beta) in [(1e-5, 1e3), (1e4, 1e-2)] {
            let (a2, b2) = (alpha * alpha, beta * beta);
            let system = Duffing::new(0.2 / beta, 1.0 / b2, 0.3 / (a2 * b2), 0.2 * a2 / (b2 * beta)).unwrap();
            let wall = Wall::above(-0.5 * alpha, 0.95).unwrap();
            let problem = Problem::of(system).unwrap().with_wall(wall).unwrap();
            let density = Closure::classical(4).basis(basis).solve(&problem).unwrap().density().unwrap();
            // The weight is iterated to 1e-12 and the closure's condition number is a hundred.
            for (powers, unit) in [([1, 0], alpha), ([2, 0], a2), ([0, 2], a2 / b2)] {
                let (here, there) =
                    (density.moment(&powers).unwrap().value / unit, reference.moment(&powers).unwrap().value);
                assert!((here / there - 1.0).abs() < 1e-9, "{basis}, α = {alpha}: {here} and {there}");
            }
        }
    }
}
