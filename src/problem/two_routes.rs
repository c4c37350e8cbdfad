//! Dual numbers through the definition against algebra on its polynomials: both are the same operator, to rounding.

use super::Problem;
use crate::error::Result;
use crate::field::{LANES, Lane};
use crate::fokker_planck::{Local, noise_induced_drift};
use crate::models::{
    BistableHarvester, CubicDamping, DisplacementNoise, Duffing, DuffingChain, DuffingVanDerPol, EnergyDamping,
    FilteredDuffing, Linear, NonlinearEnergySink, ParametricLinear, QuinticDuffing, Solved, TunedAbsorber,
    VanDerPolRayleigh, VelocityNoise, VibroImpactDuffing, ViscoelasticIsolator,
};
use crate::numerics::Lanes;
use crate::polynomial::{Polynomial, monomials, power};
use crate::scalar::Scalar;
use crate::system::{Drift, Interpretation};
use pulp::Arch;
use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

/// Three states, two noises that drive every state and depend on all of them.
#[derive(Clone, Copy)]
struct Dense(Interpretation);

impl Drift<3, 2> for Dense {
    fn drift<S: Scalar>(&self, [x, y, z]: [S; 3]) -> [S; 3] {
        [(y - x) * 10.0, x * 28.0 - y - x * z, x * y - z * (8.0 / 3.0)]
    }

    fn noise<S: Scalar>(&self, [x, y, z]: [S; 3]) -> [[S; 2]; 3] {
        [[x * y + 1.0, z * 0.5], [z * z, S::from(0.3) - x], [y * 0.2, x * y * z]]
    }

    fn interpretation(&self) -> Interpretation {
        self.0
    }
}

/// Functions of the states in drift and noise, with kinks and without.
struct Functional(Interpretation);

impl Drift<2, 1> for Functional {
    fn drift<S: Scalar>(&self, [x, v]: [S; 2]) -> [S; 2] {
        let spring = x * ((x.powi(2) + 0.3).sqrt() - 1.0) / (x.powi(2) + 1.0) + (x - 0.5).positive_power(1.5);
        [v, -(v.abs() * v * 0.2 + v.tanh() * 0.3 + v.sign() * 0.1 + spring + (x * 2.0).sin())]
    }

    fn noise<S: Scalar>(&self, [x, _]: [S; 2]) -> [[S; 1]; 2] {
        [[S::from(0.1)], [x.cos() * 0.3 + (-(x.powi(2))).exp()]]
    }

    fn interpretation(&self) -> Interpretation {
        self.0
    }
}

/// Every model, and systems with all the features that no model has.
fn problems() -> Result<Vec<Problem>> {
    let duffing = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
    Ok(vec![
        Problem::of(Linear::new(0.3, 2.0, 0.45)?)?,
        Problem::of(duffing)?,
        Problem::of(QuinticDuffing::new(1.0, 1.0, -1.8, 0.6, 0.3)?)?,
        Problem::of(VanDerPolRayleigh::new(1.0, 0.15)?)?,
        Problem::of(EnergyDamping::new(0.2, 0.3, 0.3, 0.2)?)?,
        Problem::of(ParametricLinear::new(0.1, 1.0, 0.5, 0.2)?)?,
        Problem::of(DisplacementNoise::new(0.5, 1.0, 0.4, 0.7, 0.5)?)?,
        Problem::of(VelocityNoise::new([0.7, 0.3], [0.8, 0.0], 1.0, 0.4)?)?,
        Problem::of(DuffingVanDerPol::van_der_pol(0.5, 0.3)?)?,
        Problem::of(CubicDamping::rayleigh(1.0, 0.2)?)?,
        DuffingChain::new(&[0.2, 0.4, 0.3], 1.0, 0.3, 0.5, 0.8)?.problem()?,
        VibroImpactDuffing::standard([-0.5, 0.9])?.problem()?,
        BistableHarvester::new(Duffing::new(0.1, -1.0, 1.0, 0.04)?, [0.5, 0.8], 0.2)?.problem()?,
        ViscoelasticIsolator::new(duffing, 0.5, 2.0)?.problem()?,
        TunedAbsorber::new(duffing, 0.1, 0.09, 0.03)?.problem()?,
        NonlinearEnergySink::new(duffing, 0.15, 0.4, 0.05)?.problem()?,
        FilteredDuffing::first_order(duffing, 4.0)?.problem()?,
        FilteredDuffing::second_order(duffing, 1.5, 0.2)?.problem()?,
        Problem::of(Dense(Interpretation::Ito))?,
        Problem::of(Dense(Interpretation::Stratonovich))?,
        Problem::of(Functional(Interpretation::Ito))?,
        Problem::of(Functional(Interpretation::Stratonovich))?,
    ])
}

/// A value against a polynomial's at a point. Both are sums of at most a few dozen products in another order: 1e-13 of the
/// terms' size is a few hundred rounding errors.
fn check(what: &str, p: &Polynomial, x: &[f64], value: f64) {
    let size: f64 = p.terms().map(|(alpha, c)| (c * power(x, alpha)).abs()).sum();
    let distance = (p.evaluate(x) - value).abs();
    assert!(distance <= 1e-13 * (1.0 + size), "{what} at {x:?}: off by {distance:e}");
}

fn both_routes_agree(problem: &Problem) -> Result<()> {
    let (n, operator) = (problem.dimension(), problem.operator());
    let spread = operator.diffusion_divergence();
    let curvature = (0..n).fold(Polynomial::zero(n), |sum, i| sum + spread[i].derivative(i));
    let slope = |g: &Polynomial, j: usize| g.derivative(j);
    let squares = problem.columns().iter().flatten().flat_map(|g| (0..n).map(move |j| slope(g, j)));
    let squares = squares.fold(Polynomial::zero(n), |sum, slope| sum + &slope * &slope);
    // An arbitrary quartic.
    let mut stream = ChaCha8Rng::seed_from_u64(7);
    let terms = monomials(n, 4).into_iter().skip(1).map(|alpha| (alpha, stream.random_range(-0.1..0.1)));
    let q = Polynomial::from_terms(n, terms.collect::<Vec<_>>())?;
    let residual = operator.residual(&q);
    let (mut local, mut jacobian) = (Local::new(n), vec![0.0; n * n]);
    let (mut drift, mut diffusion) = (vec![0.0; n], vec![0.0; n * n]);
    for _ in 0..20 {
        let x: Vec<f64> = (0..n).map(|_| stream.random_range(-2.5..2.5)).collect();
        problem.local(&x, &mut local);
        problem.point(&x, &mut drift, &mut diffusion);
        assert_eq!((&drift, &diffusion), (&local.drift, &local.diffusion));
        check("divergence", &operator.divergence(), &x, local.divergence);
        check("curvature", &curvature, &x, local.diffusion_curvature);
        check("slopes of the noise", &squares, &x, problem.field().slopes(&x, &mut jacobian));
        for i in 0..n {
            check("drift", &operator.drift()[i], &x, local.drift[i]);
            check("spread", &spread[i], &x, local.diffusion_divergence[i]);
            for j in 0..n {
                check("diffusion", &operator.diffusion()[i][j], &x, local.diffusion[i * n + j]);
                check("slope of the drift", &operator.drift()[i].derivative(j), &x, jacobian[i * n + j]);
            }
        }
        let (slope, bend) = (q.gradient(&x), q.hessian(&x).concat());
        let of_slopes: f64 = (0..n).map(|i| local.backward(i) * slope[i]).sum();
        let bent = |ij: usize| 0.5 * local.diffusion[ij] * (bend[ij] + slope[ij / n] * slope[ij % n]);
        check("residual", &residual, &x, local.source() + of_slopes + (0..n * n).map(bent).sum::<f64>());
    }
    lanes_agree(problem, &mut stream);
    Ok(())
}

/// The evaluations of a simulation: the noise, and short flows of the drift and of the noise, at many states at once.
fn lanes_agree(problem: &Problem, stream: &mut ChaCha8Rng) {
    let (n, field, arch, tau) = (problem.dimension(), problem.field(), Arch::new(), 0.01);
    let x: Vec<Lane> = (0..n).map(|_| Lanes(std::array::from_fn(|_| stream.random_range(-2.5..2.5)))).collect();
    let mut found = vec![Lanes([f64::NAN; LANES]); n];
    let at = |polynomials: &[Polynomial], x: &[f64]| polynomials.iter().map(|p| p.evaluate(x)).collect::<Vec<_>>();
    let ahead = |x: &[f64], slope: &[f64], tau: f64| x.iter().zip(slope).map(|(x, f)| x + tau * f).collect::<Vec<_>>();
    let check = |what: &str, expected: &dyn Fn(&[f64]) -> Vec<f64>, found: &[Lane]| {
        for l in 0..LANES {
            let state: Vec<f64> = x.iter().map(|lane| lane[l]).collect();
            for (i, value) in expected(&state).into_iter().enumerate() {
                let distance = (found[i][l] - value).abs();
                assert!(distance <= 1e-11 * (1.0 + value.abs()), "{what} at {state:?}: off by {distance:e}");
            }
        }
    };
    for (k, column) in problem.columns().iter().enumerate() {
        field.noise(arch, k, &x, &mut found);
        check("noise", &|x| at(column, x), &found);
        field.noise_flow(arch, k, &x, &Lanes([tau; LANES]), &mut found);
        let flow = |x: &[f64]| {
            let first = at(column, x);
            let second = at(column, &ahead(x, &first, tau / 2.0));
            let third = at(column, &ahead(x, &second, tau / 2.0));
            let fourth = at(column, &ahead(x, &third, tau));
            (0..n).map(|i| x[i] + tau / 6.0 * (first[i] + 2.0 * (second[i] + third[i]) + fourth[i])).collect()
        };
        check("flow of the noise", &flow, &found);
    }
    let induced = noise_induced_drift(problem.columns(), n);
    for times in [0.0, -1.0] {
        field.drift_flow(arch, &x, tau, &vec![1.0; n], times, &mut found);
        let drift = |x: &[f64]| ahead(&at(problem.drift(), x), &at(&induced, x), times);
        let flow = |x: &[f64]| ahead(x, &drift(&ahead(x, &drift(x), tau / 2.0)), tau);
        check("flow of the drift", &flow, &found);
    }
}

/// Each as it was defined, and once more from its text: systems of fixed size and of any.
#[test]
fn dual_numbers_and_polynomials_give_the_same_operator_on_every_model() -> Result<()> {
    for problem in problems()? {
        both_routes_agree(&problem)?;
        both_routes_agree(&Problem::from_toml(&problem.to_toml()?)?)?;
    }
    Ok(())
}
