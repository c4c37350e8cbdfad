//! The Fokker-Planck operator: exact densities as null vectors, its adjoint, equations as text; and Zhuravlev's plane.

use crate::common::*;
use expoly::models::{DuffingChain, Solved};
use expoly::{Gaussian, Oscillator, Polynomial, Wall};
use nalgebra::{DMatrix, DVector, dmatrix, dvector};
use num_dual::{Dual2_64, Dual64, DualNum, HyperDual64};

/// The residual of a model's exact ln p vanishes as a polynomial, coefficient by coefficient. The parameters enter
/// through products of up to three of them, so that 1e-14 times the largest coefficient is rounding.
fn exact_density_is_stationary(name: &str, model: &impl Solved) {
    let (problem, q) = (model.problem().unwrap(), model.log_polynomial().unwrap());
    let operator = problem.operator();
    let residual = operator.residual(&q);
    let scale =
        operator.drift().iter().map(Polynomial::max_coefficient).fold(1.0, f64::max) * (1.0 + q.max_coefficient());
    assert!(residual.max_coefficient() <= 1e-14 * scale * scale, "{name}: residual {residual}");
}

#[test]
fn exact_densities_solve_the_equation_identically() {
    exact_density_is_stationary("linear", &linear());
    exact_density_is_stationary("Duffing", &duffing());
    exact_density_is_stationary("two wells", &bistable());
    exact_density_is_stationary("three wells", &three_wells());
    exact_density_is_stationary("van der Pol-Rayleigh", &van_der_pol_rayleigh());
    exact_density_is_stationary("energy damping", &energy_damping());
    exact_density_is_stationary("displacement noise", &displacement_noise());
    exact_density_is_stationary("velocity noise", &velocity_noise());
    exact_density_is_stationary("chain of 2", &chain_of_two());
    exact_density_is_stationary(
        "chain of 5",
        &DuffingChain::new(&[0.2, 0.4, 0.1, 0.3, 0.5], 1.0, 0.3, 0.5, 0.8).unwrap(),
    );
}

/// (κ + v² + Ω²x²)^−δ is no exponential of a polynomial; its residual is checked at points, from ln p's own derivatives.
#[test]
fn the_power_law_solves_the_equation_at_every_point() {
    let (problem, exact) = (problem(parametric_linear()), parametric_linear().exact());
    let operator = problem.operator();
    let (divergence, spread) = (operator.divergence(), operator.diffusion_divergence());
    let log_density = |[x, v]: [HyperDual64; 2]| (v * v + x * x + exact.core()).ln() * -exact.exponent();
    let mut points = Points::new(3);
    for _ in 0..50 {
        let x: [f64; 2] = points.array(6.0);
        let second = |i: usize, j: usize| {
            let at = |k: usize| HyperDual64::new(x[k], f64::from(k == i), f64::from(k == j), 0.0);
            log_density([at(0), at(1)])
        };
        let gradient = [second(0, 0).eps1, second(1, 1).eps1];
        let hessian = [0, 1].map(|i| [0, 1].map(|j| second(i, j).eps1eps2));
        let mut residual = -divergence.evaluate(&x);
        for i in 0..2 {
            residual += (spread[i].evaluate(&x) - operator.drift()[i].evaluate(&x)) * gradient[i];
            residual += 0.5 * spread[i].derivative(i).evaluate(&x);
            for j in 0..2 {
                let curvature = hessian[i][j] + gradient[i] * gradient[j];
                residual += 0.5 * operator.diffusion()[i][j].evaluate(&x) * curvature;
            }
        }
        // Terms of order one; a hundred rounding errors.
        assert!(residual.abs() < 1e-13, "{residual:e} at {x:?}");
    }
}

/// ∂E[φ]/∂t = E[generator φ] is the adjoint of the equation: ∫ φ L p = ∫ p (generator φ). With a Gaussian p both sides are
/// exact moments.
#[test]
fn the_generator_is_the_adjoint_of_the_operator() {
    let problem = problem(displacement_noise());
    let operator = problem.operator();
    let gaussian = Gaussian { mean: dvector![0.3, -0.2], covariance: dmatrix![0.8, 0.1; 0.1, 1.3] };
    let inverse = gaussian.covariance.clone().try_inverse().unwrap();
    let [x, v] = [0, 1].map(|i| Polynomial::variable(2, i));
    let z = [&x + -0.3, &v + 0.2];
    let mut q = Polynomial::zero(2);
    for i in 0..2 {
        for j in 0..2 {
            q = q + &z[i] * &z[j] * (-0.5 * inverse[(i, j)]);
        }
    }
    let residual = operator.residual(&q);
    for phi in monomials(2, 5) {
        let statistic = Polynomial::from_terms(2, [(&phi, 1.0)]).unwrap();
        let (left, right) =
            (gaussian.expectation(&(&statistic * &residual)), gaussian.expectation(&operator.generator(&statistic)));
        // Moments up to order eleven, of sums of some fifty terms.
        assert!((left - right).abs() < 1e-11 * (1.0 + left.abs()), "{phi:?}: {left} and {right}");
    }
}

/// A polynomial's value, gradient and Hessian against dual numbers run through the same polynomial.
#[test]
fn polynomial_derivatives_agree_with_dual_numbers() {
    let p = &problem(energy_damping()).operator().drift()[1].clone();
    // The scale of rounding: the sum of the terms without their signs.
    let absolute = Polynomial::from_terms(2, p.terms().map(|(alpha, c)| (alpha, c.abs()))).unwrap();
    let mut points = Points::new(5);
    for _ in 0..20 {
        let x: [f64; 2] = points.array(2.0);
        let (gradient, hessian) = (p.gradient(&x), p.hessian(&x));
        let size = absolute.evaluate(&x.map(f64::abs));
        for i in 0..2 {
            let first = p.evaluate(&[0, 1].map(|k| Dual64::new(x[k], f64::from(k == i))));
            let second = p.evaluate(&[0, 1].map(|k| Dual2_64::new(x[k], f64::from(k == i), 0.0)));
            assert!((first.eps - gradient[i]).abs() < 1e-13 * (1.0 + size) * 10.0);
            assert!((second.v2 - hessian[i][i]).abs() < 1e-13 * (1.0 + size) * 100.0);
        }
        assert_eq!(hessian[0][1], hessian[1][0]);
    }
}

/// E[p(m + Lz)] by exact moments of z equals that by exact moments of x.
#[test]
fn gaussian_moments_do_not_depend_on_the_coordinates() {
    let gaussian = Gaussian {
        mean: dvector![0.4, -0.1, 0.7],
        covariance: dmatrix![1.2, 0.3, -0.2; 0.3, 0.9, 0.1; -0.2, 0.1, 0.6],
    };
    let standard = Gaussian { mean: DVector::zeros(3), covariance: DMatrix::identity(3, 3) };
    let scale = gaussian.scale().unwrap();
    let z = Polynomial::variables(3);
    let x: [Polynomial; 3] = std::array::from_fn(|i| {
        (0..3).fold(Polynomial::constant(3, gaussian.mean[i]), |sum, j| sum + &z[j] * scale[(i, j)])
    });
    for m in monomials(3, 6) {
        let p = Polynomial::from_terms(3, [(&m, 1.0)]).unwrap();
        let (direct, scaled) = (gaussian.expectation(&p), standard.expectation(&p.compose(&x)));
        // The composition has up to 28 terms of alternating sign, each with its own rounding.
        assert!((direct - scaled).abs() < 1e-12 * (1.0 + direct.abs()), "{m:?}: {direct} and {scaled}");
    }
}

#[test]
fn equations_print_as_text_and_latex() {
    let problem = problem(displacement_noise());
    let (operator, names) = (problem.operator(), &["x", "v"]);
    assert_eq!(
        format!("{:.2}", operator.text(names)),
        "0 = - d/dx[(v) p] - d/dv[(- x - 0.50 v - 0.40 x^3 - 0.35 x^2 v) p] + d2/dv2[(0.50 + 0.35 x^2) p]"
    );
    let latex = format!("{:.2}", operator.latex(names));
    assert!(latex.starts_with(r"0 = - \frac{\partial}{\partial x}\left[\left(v\right) p\right]"), "{latex}");
    assert!(
        latex.ends_with(r"+ \frac{\partial^2}{\partial v^2}\left[\left(0.50 + 0.35\,x^{2}\right) p\right]"),
        "{latex}"
    );
}

/// The transformed oscillator's force sgn(x) h(|x| + b, sgn(x) x′), read back from the polynomial on the half plane.
#[test]
fn zhuravlevs_transformation_goes_there_and_back() {
    let wall = Wall::above(-0.3, 0.8).unwrap();
    let mut points = Points::new(13);
    for _ in 0..50 {
        let [x, slope] = points.array(2.0);
        let state = wall.unfolded_state([x, slope]);
        assert!(state[0] >= -0.3);
        // The two images differ by the reflection, and one of them is the point, up to the rounding of |x| + b − b.
        let images = wall.unfolded_points(state);
        assert_eq!(images[0].map(|c| -c), images[1]);
        let nearest = images.iter().map(|p| (p[0] - x).abs() + (p[1] - slope).abs()).fold(f64::MAX, f64::min);
        assert!(nearest < 1e-15);
        // Velocity and force transform with the same sign.
        let force = duffing().force(state[0], state[1]);
        let sign = x.signum();
        let transformed =
            0.2 * slope + (1.0 + 0.9 * 0.09) * x - 0.27 * x * x.abs() + 0.3 * x.powi(3) + (-0.3 - 0.3 * 0.027) * sign;
        assert!((sign * force - transformed).abs() < 1e-14 * 10.0);
    }
}

/// Nested dual numbers: the derivative of a derivative is the second derivative.
#[test]
fn a_drift_runs_on_dual_numbers_over_dual_numbers() {
    let nested = |x: f64| num_dual::Dual::new(Dual64::new(x, 1.0), Dual64::from_re(1.0));
    let constant = |v: f64| num_dual::Dual::from_re(Dual64::from_re(v));
    let force = duffing().force(nested(1.2), constant(0.7));
    assert!((force.eps.eps - 6.0 * 0.3 * 1.2).abs() < 1e-14);
}
