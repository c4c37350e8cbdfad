//! Parameters: problems at other values of them, and derivatives of the equations.

use crate::common::{chain_of_two, duffing, every_model};
use expoly::models::{Duffing, Solved};
use expoly::{Error, FokkerPlanck, Polynomial, Problem, Result, Wall};

/// All coefficients of drift and diffusion.
fn entries(operator: &FokkerPlanck) -> Vec<&Polynomial> {
    operator.drift().iter().chain(operator.diffusion().iter().flatten()).collect()
}

/// The largest coefficient of Σ c_k p_k over all entries of some operators.
fn largest(operators: &[(f64, &FokkerPlanck)]) -> f64 {
    let all: Vec<Vec<&Polynomial>> = operators.iter().map(|(_, operator)| entries(operator)).collect();
    let sum = |i: usize| {
        let terms = operators.iter().zip(&all).map(|((c, _), entries)| entries[i] * *c);
        terms.reduce(|sum, p| sum + p).unwrap().max_coefficient()
    };
    (0..all[0].len()).map(sum).fold(0.0, f64::max)
}

/// Every model, by every parameter: what dual numbers give against differences of the same operator at other values. Of second order,
/// they err by h²/6 of a third derivative and by rounding/h: with h = 1e-4 of the parameter 1e-8 of the derivatives.
#[test]
fn derivatives_are_the_limits_of_differences() -> Result<()> {
    for (name, problem) in every_model() {
        // Those of walls are none of the equations.
        let problem = problem.without_walls();
        let parameters = problem.parameters().to_vec();
        assert!(!parameters.is_empty(), "{name}");
        let at = |parameter: &str, value: f64| problem.with_parameter(parameter, value).unwrap();
        for (parameter, value) in &parameters {
            // A noise that is not there has no root to be differentiated, and its parameter leaves the equations.
            if *value == 0.0 && problem.derivative(parameter).is_err() {
                continue;
            }
            let derivative = problem.derivative(parameter)?;
            let size = largest(&[(1.0, &derivative)]);
            let h = 1e-4 * value.abs().max(0.1);
            let [high, low] = [h, -h].map(|h| at(parameter, value + h));
            let off = largest(&[(1.0, &derivative), (-0.5 / h, high.operator()), (0.5 / h, low.operator())]);
            assert!(off < 1e-7 * size, "{name} {parameter}: {off:e} of {size:e}");
        }
    }
    Ok(())
}

/// The same oscillator in a text, with a stiffness and a wall made of other parameters.
const TEXT: &str = r#"
states = ["x", "v"]
[parameters]
c = 0.2
omega = 2.0
k = "omega^2"
mu = 0.3
D = 0.2
gap = 0.5
[drift]
x = "v"
v = "-c*v - k*x - mu*x^3"
[noise.w]
v = "sqrt(2*D)"
[[wall]]
state = "x"
above = "-gap"
restitution = 0.9
"#;

/// A text has the derivatives of the same model, and those of parameters that others are made of by the chain rule.
#[test]
fn texts_have_the_derivatives_of_the_model() -> Result<()> {
    let text = Problem::from_toml(TEXT)?;
    let model = Duffing::new(0.2, 4.0, 0.3, 0.2)?.problem()?;
    let apart = |text: &str, model: &str, factor: f64, problems: [&Problem; 2]| {
        let [one, other] = [problems[0].derivative(text).unwrap(), problems[1].derivative(model).unwrap()];
        largest(&[(1.0, &one), (-factor, &other)])
    };
    for name in ["c", "k", "mu", "D"] {
        // The square of √(2D) is rounded.
        assert!(apart(name, name, 1.0, [&text, &model]) < 1e-15, "{name}");
    }
    assert!(apart("omega", "k", 4.0, [&text, &model]) < 1e-15);

    // At other values: of a parameter, of those made of it, and of the wall.
    let slow = text.with_parameter("omega", 1.0)?;
    assert_eq!(slow.drift()[1].text(slow.states()).to_string(), "- x - 0.2 v - 0.3 x^3");
    let wide = slow.with_parameter("gap", 0.8)?;
    assert_eq!((wide.walls()[0].offset(), wide.parameters()[1].1), (-0.8, 1.0));
    assert_eq!(wide.with_parameter("omega", 2.0)?.drift(), text.drift());
    // A wall that was set beside the text stays where it is.
    let other = text.without_walls().with_wall(Wall::above(-0.3, 0.8)?)?;
    assert_eq!(other.with_parameter("gap", 0.8)?.walls(), other.walls());
    let walled = duffing().problem()?.with_wall(Wall::above(-0.5, 0.9)?)?;
    assert_eq!(walled.with_parameter("mu", 0.5)?.walls(), walled.walls());
    Ok(())
}

/// Impulses of every law, with an H that depends on the state and on a parameter: what dual numbers give of 𝓖ψ against differences of
/// 𝓖ψ itself, for monomials ψ up to degree 4, by each parameter; errors as above.
#[test]
fn impulses_have_the_derivatives_of_their_generator() -> Result<()> {
    let laws = [
        "normal = { mean = \"a\", deviation = \"b\" }",
        "exponential = { mean = \"a*b\" }",
        "uniform = { low = \"-a\", high = \"b\" }",
        "two_point = { a = \"a\", b = \"-b\" }",
        "laplace = { mean = \"a\", scale = \"b^2\" }",
    ];
    for law in laws {
        let problem = Problem::from_toml(&format!(
            "states = [\"x\", \"v\"]\n[parameters]\na = 0.3\nb = 0.5\nrho = 1.5\nh = 0.8\n[drift]\nx = \"v\"\nv = \"-h*v - x\"\n\
             [impulse.j]\nrate = \"2*rho^2\"\namplitude = {{ {law} }}\nx = \"0.1*x\"\nv = \"h^2*(1 + 0.5*x)\"\n"
        ))?;
        let statistics = [[1, 0], [0, 1], [1, 1], [0, 2], [3, 0], [2, 2], [0, 4]]
            .map(|powers| Polynomial::from_terms(2, [(&powers[..], 1.0)]).unwrap());
        let apart = |operators: &[(f64, &FokkerPlanck)], statistic: &Polynomial| {
            let terms = operators.iter().map(|(c, operator)| operator.generator(statistic) * *c);
            terms.reduce(|sum, p| sum + p).unwrap().max_coefficient()
        };
        for name in ["a", "b", "rho", "h"] {
            let value = problem.parameters().iter().find(|(other, _)| other == name).unwrap().1;
            let h = 1e-4 * value;
            let derivative = problem.derivative(name)?;
            let [high, low] = [1e-4, -1e-4].map(|share| problem.with_parameter(name, value * (1.0 + share)).unwrap());
            for psi in &statistics {
                let size = apart(&[(1.0, &derivative)], psi).max(1.0);
                let off = apart(&[(1.0, &derivative), (-0.5 / h, high.operator()), (0.5 / h, low.operator())], psi);
                assert!(off < 1e-7 * size, "{law} {name} {psi}: {off:e} of {size:e}");
            }
        }
    }
    Ok(())
}

/// Rates and laws without a meaning are refused where a system is used, and a derivative says what it is of.
#[test]
fn parameters_of_impulses_are_checked_and_shown() -> Result<()> {
    let text = "states = [\"v\"]\n[parameters]\nrho = 2\ns = 0.5\n[drift]\nv = \"-v\"\n[impulse.j]\nrate = \"rho\"\n\
                amplitude = { normal = { mean = 0, deviation = \"s\" } }\nv = 1\n";
    let problem = Problem::from_toml(text)?;
    for (name, value) in [("rho", 0.0), ("rho", -1.0), ("s", -0.1), ("s", 0.0), ("s", f64::INFINITY)] {
        assert!(problem.with_parameter(name, value).is_err(), "{name} {value}");
    }
    let shown = problem.derivative("rho")?.text(problem.states()).to_string();
    assert_eq!(shown, "0 = - d/dv[(0) p] + d/dtheta [2 (E[p(v - Y)] - p)]");
    assert!(problem.derivative("s")?.impulses().is_empty());
    assert_ne!(problem.derivative("s")?, problem.derivative("rho")?);
    Ok(())
}

/// Walls have their parameters beside those of the equations, whatever these are.
#[test]
fn offsets_and_restitutions_are_parameters() -> Result<()> {
    let names = |problem: &Problem| problem.parameters().iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
    let walls = [Wall::above(-0.5, 0.9)?, Wall::below(1.0, 0.8)?];
    let plain = walls.into_iter().try_fold(Problem::of(duffing())?, Problem::with_wall)?;
    let all = ["x.above.offset", "x.above.restitution", "x.below.offset", "x.below.restitution"];
    assert_eq!(names(&plain), all);
    assert_eq!(plain.parameters().iter().map(|(_, value)| *value).collect::<Vec<_>>(), [-0.5, 0.9, 1.0, 0.8]);
    let moved = plain.with_parameter(all[2], 1.2)?.with_parameter(all[1], 0.7)?;
    assert_eq!(moved.walls(), [Wall::above(-0.5, 0.7)?, Wall::below(1.2, 0.8)?]);
    assert_eq!((moved.operator(), moved.parameters()[1].1), (plain.operator(), 0.7));
    assert!(plain.without_walls().parameters().is_empty());
    assert_eq!(names(&duffing().problem()?.with_wall(walls[0])?), ["c", "k", "mu", "D", all[0], all[1]]);
    // Between two bodies.
    let chain = chain_of_two().problem()?.with_wall(Wall::below(0.3, 0.9)?.between([0, 2], [1.0, 2.0])?)?;
    assert_eq!(
        chain.parameters().last(),
        Some(&(format!("{}-{}.below.restitution", chain.states()[0], chain.states()[2]), 0.9))
    );
    let offset = &chain.parameters()[chain.parameters().len() - 2].0;
    assert_eq!(chain.with_parameter(offset, 0.4)?.walls()[0].offset(), 0.4);

    // No such wall, none with this number, and no derivative of the equations.
    assert!(matches!(plain.with_parameter("v.above.offset", 0.0), Err(Error::NotAName { .. })));
    assert!(matches!(plain.with_parameter(all[1], 1.1), Err(Error::OutOfRange { name: "restitution r", .. })));
    assert!(matches!(plain.with_parameter(all[0], 1.5), Err(Error::OutOfRange { name: "offset of the wall", .. })));
    assert!(matches!(plain.with_parameter(all[0], f64::NAN), Err(Error::OutOfRange { .. })));
    assert!(matches!(plain.derivative(all[0]), Err(Error::NotServed { .. })));

    // In a text: a number that was set stays, the other one follows.
    let text = Problem::from_toml(TEXT)?;
    let set = text.with_parameter("x.above.restitution", 0.7)?.with_parameter("gap", 0.8)?;
    assert_eq!(set.walls(), [Wall::above(-0.8, 0.7)?]);
    assert_eq!(text.with_parameter("x.above.offset", -0.4)?.with_parameter("gap", 0.8)?.walls()[0].offset(), -0.4);
    assert_eq!(names(&Problem::from_toml(&text.to_toml()?)?), names(&text));
    Ok(())
}

#[test]
fn derivatives_that_are_not_known_are_refused() -> Result<()> {
    let text = Problem::from_toml(TEXT)?;
    assert!(matches!(text.derivative("nu"), Err(Error::NotAName { name, .. }) if name == "nu"));
    assert!(matches!(text.with_parameter("nu", 1.0), Err(Error::NotAName { .. })));
    // The equations do not contain the wall.
    assert!(matches!(text.derivative("gap"), Err(Error::NotServed { .. })));
    // Beside impulses the wall is refused as well, and what they do not contain is as without them.
    let struck = TEXT.replace(
        "[[wall]]",
        "[impulse.a]\nrate = 2\namplitude = { normal = { mean = 0, deviation = 0.3 } }\nv = \"mu\"\n[[wall]]",
    );
    let struck = Problem::from_toml(&struck)?;
    assert!(matches!(struck.derivative("gap"), Err(Error::NotServed { .. })));
    assert_ne!(struck.derivative("mu")?, text.derivative("mu")?);
    assert_eq!(struck.derivative("c")?, text.derivative("c")?);
    // A saved problem has its parameters' values in the equations.
    let saved = Problem::from_toml(&text.to_toml()?)?;
    assert!(matches!(saved.derivative("c"), Err(Error::NotKnown { what, .. }) if what.contains('c')));
    // Values that are refused where the system is made.
    for (name, value) in [("D", -0.1), ("c", f64::NAN), ("mu", f64::INFINITY)] {
        assert!(text.with_parameter(name, value).is_err(), "{name}");
        assert!(duffing().problem()?.with_parameter(name, value).is_err(), "{name}");
    }
    let plain = Problem::of(duffing())?;
    assert!(plain.parameters().is_empty() && matches!(plain.derivative("c"), Err(Error::NotAName { .. })));
    Ok(())
}
