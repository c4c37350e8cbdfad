//! Derivatives of densities by parameters: against closed forms, differences on a grid, and refusals.

use crate::common::*;
use expoly::models::{DisplacementNoise, Duffing, Solved};
use expoly::statistics::{Crossings, Marginal};
use expoly::{
    Closure, ClosureDensity, Crossing, Density, Error, ExpPolynomial, Grid, Intensity, Oscillator, Parameter, Problem,
    Result, Scalar, Sensitivity, Weight, parametric,
};

/// The differences of an answer of second order at h and 2h, extrapolated: h⁴ of a fifth derivative, and rounding over h.
fn slope(at: impl Fn(f64) -> f64, h: f64) -> f64 {
    (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h)
}

/// ∫ from a level on of the marginal density, by Simpson's rule on 800 intervals of 0.005: 1e-10.
fn beyond(density: &dyn Density, level: f64) -> f64 {
    let p = |k: u32| density.marginal(0, level + 0.005 * f64::from(k)).unwrap().value;
    let inner = |first: u32| (first..800).step_by(2).map(p).sum::<f64>();
    (p(0) + 4.0 * inner(1) + 2.0 * inner(2) + p(800)) * 0.005 / 3.0
}

/// By every parameter of an exact density: ∂ ln p/∂θ in the mean under p, the moments' derivatives, those of an exceedance and of
/// the up-crossings are those of the closed form to 1e-8, at orders above the exact one as well. Measured are 1e-13 to 4e-10.
fn closed_form(
    name: &str,
    parameters: &[(&str, f64)],
    exact: impl Fn(&[f64]) -> ExpPolynomial,
    problem: &Problem,
) -> Result<()> {
    let values: Vec<f64> = parameters.iter().map(|(_, value)| *value).collect();
    let at = |j: usize, h: f64| {
        let mut moved = values.clone();
        moved[j] += h;
        exact(&moved)
    };
    for order in [4, 6, 8] {
        let density = Closure::new(order).solve(problem)?;
        let names: Vec<&str> = parameters.iter().map(|(name, _)| *name).collect();
        for (j, found) in density.sensitivities(&names)?.iter().enumerate() {
            let h = 2e-3 * values[j].abs();
            let around: Vec<ExpPolynomial> = [-2.0, -1.0, 1.0, 2.0].map(|k| at(j, k * h)).into();
            let of = |answer: &dyn Fn(&ExpPolynomial) -> f64| {
                let answers: Vec<f64> = around.iter().map(answer).collect();
                (8.0 * (answers[2] - answers[1]) - (answers[3] - answers[0])) / (12.0 * h)
            };
            let log = |x: &[f64]| of(&|density| density.log_pdf(x).unwrap());
            let off = density.expectation(&|x| (found.relative(x).unwrap() - log(x)).abs())?.value;
            let size = found.size();
            println!("{name} n = {order}, {}: {off:.1e} off, size {size:.2}", found.parameter());
            assert_eq!(found.parameter(), names[j]);
            assert!(off < 1e-8 * size.max(1.0), "{name} {order} {}: {off:e}", found.parameter());
            for powers in [[2, 0], [0, 2], [4, 0], [2, 2]] {
                let truth = of(&|density| density.moment(&powers).unwrap().value);
                let moment = found.moment(&powers)?;
                assert!((moment.value - truth).abs() < 1e-8 * truth.abs().max(1.0), "{moment} and {truth}");
            }
            let truth = of(&|density| beyond(density, 1.5));
            // Simpson's rule is right to some 1e-11.
            let tail = found.exceedance(0, 1.5)?;
            assert!((tail.value - truth).abs() < 1e-8 * truth.abs().max(1e-2), "{tail} and {truth}");
            let truth = of(&|density| density.flux(Crossing::upward(1.5), 1).unwrap().value);
            let crossings = found.upcrossing_rate(1.5)?;
            assert!((crossings.value - truth).abs() < 1e-8 * truth.abs().max(1e-2), "{crossings} and {truth}");
        }
    }
    Ok(())
}

#[test]
fn derivatives_of_exact_densities_are_exact() -> Result<()> {
    let duffing = |p: &[f64]| Duffing::new(p[0], p[1], p[2], p[3]).unwrap();
    for (name, values) in [("Duffing", [0.2, 1.0, 0.3, 0.2]), ("two wells", [0.5, -1.0, 1.0, 0.3])] {
        let parameters = [("c", values[0]), ("k", values[1]), ("mu", values[2]), ("D", values[3])];
        closed_form(name, &parameters, |p| duffing(p).exact().unwrap(), &duffing(&values).problem()?)?;
    }
    // g does not appear in the density: its derivative is zero.
    let noisy = |p: &[f64]| DisplacementNoise::new(p[0], p[1], p[2], p[3], p[4]).unwrap();
    let parameters = [("c", 0.5), ("k", 1.0), ("mu", 0.3), ("g", 0.8), ("D", 0.5)];
    let problem = noisy(&parameters.map(|(_, value)| value)).problem()?;
    closed_form("displacement noise", &parameters, |p| noisy(p).exact().unwrap(), &problem)
}

/// x″ + c x′ + x + μ x³ = F + ξ, whose force F makes the symmetric density of F = 0 lean.
struct Pushed<P = f64> {
    force: P,
    damping: P,
}

impl<P: Parameter> Oscillator<P> for Pushed<P> {
    fn force<S: Scalar<P>>(&self, x: S, v: S) -> S {
        v * self.damping + x + x.powi(3) * 0.3 - self.force
    }
    fn intensity(&self) -> Intensity<P> {
        Intensity::of(P::from(0.2))
    }
}

parametric!(Pushed { force: "F", damping: "c" });

/// p = C exp(−(c/D)(H − F x)): ∂ ln p/∂F = (c/D) x, although the closure's own functions are even.
#[test]
fn a_parameter_may_break_the_symmetry() -> Result<()> {
    let density = Closure::new(4).solve(&Problem::parametric(Pushed { force: 0.0, damping: 0.2 })?)?;
    let found = density.sensitivity("F")?;
    for x in [[0.5, 0.3], [-1.2, 0.8], [1.7, -1.0]] {
        assert!((found.relative(&x)? - x[0]).abs() < 1e-9, "{x:?}: {}", found.relative(&x)?);
    }
    assert!((found.moment(&[1, 0])?.value - density.moment(&[2, 0])?.value).abs() < 1e-9);
    Ok(())
}

const CUBIC: &str = r#"
states = ["x", "v"]
[parameters]
e = 0.3
D = 0.3
mu = 0.3
[drift]
x = "v"
v = "-0.2*v - e*x^2*v - 0.1*v^3 - x - mu*x^3"
[noise.w]
v = "sqrt(2*D)"
"#;

/// Without a closed form, against differences of a grid: ∫ |p̃′ − p′| is within a factor of two of its own estimate, 9e-2 to 5e-4 of
/// ∫ |p′|, and the moments' derivatives are right to 2e-4 at every order.
#[test]
fn derivatives_without_a_closed_form_have_their_estimated_errors() -> Result<()> {
    let problem = Problem::from_toml(CUBIC)?;
    let densities = [4, 6, 8].map(|order| Closure::new(order).solve(&problem).unwrap());
    for name in ["e", "D"] {
        let h = 0.015;
        let grids = [-2.0, -1.0, 1.0, 2.0].map(|k| {
            let moved = problem.with_parameter(name, 0.3 + k * h).unwrap();
            Grid::new().accuracy(1e-7).solve(&moved).unwrap()
        });
        let of = |answer: &dyn Fn(&dyn Density) -> f64| {
            let answers = grids.each_ref().map(|grid| answer(grid));
            (8.0 * (answers[2] - answers[1]) - (answers[3] - answers[0])) / (12.0 * h)
        };
        for density in &densities {
            let found = density.sensitivity(name)?;
            let (mut apart, mut size) = (0.0, 0.0);
            let [width, height] = [0, 1].map(|i| (density.bounds()[i][1] - density.bounds()[i][0]) / 48.0);
            for i in 0..48 * 48 {
                let x = [0, 1].map(|k| {
                    let place = if k == 0 { i % 48 } else { i / 48 };
                    density.bounds()[k][0] + (f64::from(place) + 0.5) * [width, height][k]
                });
                let truth = of(&|density| density.pdf(&x).unwrap().value);
                apart += (density.pdf(&x)?.value * found.relative(&x)? - truth).abs() * width * height;
                size += truth.abs() * width * height;
            }
            let estimate = found.l1_estimate();
            println!("{name}: {apart:.2e} off of {size:.3}, estimated {estimate:.2e}");
            assert!(apart < 2.0 * estimate && estimate < 2.0 * apart && apart < 0.1 * size, "{name}: {apart:e}");
            for powers in [[2, 0], [0, 2], [4, 0], [0, 4]] {
                let (truth, moment) = (of(&|density| density.moment(&powers).unwrap().value), found.moment(&powers)?);
                println!("   {powers:?}: {moment} and {truth:.6}");
                assert!((moment.value / truth - 1.0).abs() < 2e-4, "{name} {powers:?}: {moment} and {truth}");
            }
        }
    }
    Ok(())
}

/// A density of its own at another value lies on the tangent, to second order.
#[test]
fn the_tangent_touches_the_densities_nearby() -> Result<()> {
    let problem = Problem::from_toml(CUBIC)?;
    let at = |value: f64| -> Result<ClosureDensity> { Closure::new(8).solve(&problem.with_parameter("mu", value)?) };
    let found = at(0.3)?.sensitivity("mu")?;
    let variance = |h: f64| at(0.3 + h).unwrap().moment(&[2, 0]).unwrap().value;
    let differences = slope(variance, 0.05);
    let tangent = found.moment(&[2, 0])?;
    println!("{differences} and {tangent}");
    // Measured is 7e-5: the differences' own h⁴, and the edges of five domains.
    assert!((tangent.value / differences - 1.0).abs() < 2e-4, "{differences} and {tangent}");
    assert_eq!((found.density().dimension(), found.marginal(0, 9.0)?.value), (2, 0.0));

    // Pointwise, by a fit with a share for the tails, whose weight moves as well.
    let at =
        |value: f64| Closure::new(6).weight(Weight::Tails(0.1)).solve(&problem.with_parameter("D", value).unwrap());
    let (found, beside) = (at(0.3)?.sensitivity("D")?, [at(0.27)?, at(0.33)?]);
    for x in [[0.0, 0.0], [0.8, -0.5], [-1.1, 0.9], [1.4, 1.0]] {
        let differences = (beside[1].log_pdf(&x)? - beside[0].log_pdf(&x)?) / 0.06;
        println!("{x:?}: {} and {differences}", found.relative(&x)?);
        // The differences err by h²/6 of a third derivative, some 6/D² of the first: 1e-2, as measured.
        assert!((found.relative(&x)? - differences).abs() < 0.02 * found.relative(&x)?.abs().max(1.0), "{x:?}");
    }
    Ok(())
}

#[test]
fn derivatives_that_the_closure_has_not_are_refused() -> Result<()> {
    let duffing = duffing().problem()?;
    let density = Closure::new(4).solve(&duffing)?;
    assert!(matches!(density.sensitivity("nu"), Err(Error::NotAName { .. })));
    let document: ClosureDensity = serde_json::from_str(&serde_json::to_string(&density).unwrap()).unwrap();
    assert!(matches!(document.sensitivity("c"), Err(Error::NotKnown { .. })));
    let moving = Closure::new(4).transient(&duffing, [0.5, 0.0], &[2.0])?.remove(0);
    assert!(moving.density.sensitivity("c").is_err());
    let found = density.sensitivity("c")?;
    assert!(matches!(found.moment(&[2]), Err(Error::Dimension { .. })));
    assert!(matches!(found.relative(&[0.0]), Err(Error::Dimension { .. })));
    assert!(matches!(found.exceedance(2, 0.0), Err(Error::Dimension { .. })));
    assert!(matches!(found.upcrossing_rate(f64::NAN), Err(Error::OutOfRange { .. })));
    assert!(density.sensitivities(&[])?.is_empty());
    Ok(())
}

/// A quantile and the probability of a first passage, against extrapolated differences of those at other parameters: the tables of
/// distributions and rates are right to some 1e-9, over a step of 2e-3. Measured are 1e-7 or less.
#[test]
fn quantiles_and_first_passages_have_derivatives() -> Result<()> {
    let problem = duffing().problem()?;
    let density = Closure::new(4).solve(&problem)?;
    for name in ["c", "mu", "D"] {
        let value = problem.parameters().iter().find(|(other, _)| other == name).unwrap().1;
        let at = |h: f64| Closure::new(4).solve(&problem.with_parameter(name, value + h).unwrap()).unwrap();
        let around: Vec<ClosureDensity> = [-4e-3, -2e-3, 2e-3, 4e-3].map(at).into();
        let of = |answer: &dyn Fn(&ClosureDensity) -> f64| {
            let answers: Vec<f64> = around.iter().map(answer).collect();
            (8.0 * (answers[2] - answers[1]) - (answers[3] - answers[0])) / (12.0 * 2e-3)
        };
        let by = density.sensitivity(name)?;
        let quantile = of(&|density| Marginal::new(density, 0).unwrap().upper_quantile(1e-3).unwrap().value);
        let passage = of(&|density| Crossings::new(density, [0, 1]).unwrap().first_passage(1.5, 10.0).unwrap().value);
        let (found, truth) = ([by.upper_quantile(0, 1e-3)?, by.first_passage(1.5, 10.0)?], [quantile, passage]);
        for (found, truth) in found.iter().zip(truth) {
            println!("{name}: {found} and {truth}");
            assert!((found.value - truth).abs() < 1e-6 * truth.abs().max(1.0), "{name}: {found} and {truth}");
        }
    }
    assert!(matches!(density.sensitivity("c")?.upper_quantile(0, 1.5), Err(Error::OutOfRange { .. })));
    assert!(matches!(density.sensitivity("c")?.first_passage(1.0, -1.0), Err(Error::OutOfRange { .. })));
    Ok(())
}
