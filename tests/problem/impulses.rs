//! Poisson impulses as a part of a problem: as text, in the printed equation, and in moment equations.

use crate::simulation::impulses::{laws, struck};
use expoly::{Error, Polynomial, Problem, Result};

const TEXT: &str = r#"states = ["x", "v"]
[parameters]
s = 0.3
[drift]
x = "v"
v = "-0.2*v - x"
[impulse.hail]
rate = 2
amplitude = { normal = { mean = 0, deviation = "2*s" } }
v = "1 + x"
[impulse.gusts]
rate = "1/s"
amplitude = { laplace = { mean = 0.1, scale = 0.2 } }
v = 1
"#;

#[test]
fn impulses_come_back_to_the_same_bits() -> Result<()> {
    let mut problems: Vec<Problem> = laws(1.0 / 3.0, 0.2).iter().map(|impulses| struck(0.3, &[*impulses])).collect();
    problems.push(struck(0.3, &laws(0.7, 0.1)));
    problems.push(Problem::from_toml(TEXT)?);
    for problem in problems {
        let text = problem.to_toml()?;
        let again = Problem::from_toml(&text)?;
        assert_eq!((again.impulses(), again.operator()), (problem.impulses(), problem.operator()), "{text}");
        assert_eq!(again.to_toml()?, text);
    }
    Ok(())
}

/// Kolmogorov's and Feller's equation; where H depends on the state the transition stands in it.
#[test]
fn the_equation_shows_impulses() -> Result<()> {
    let problem = struck(0.0, &[laws(2.0, 0.2)[0]]);
    assert_eq!(
        problem.operator().text(problem.states()).to_string(),
        "0 = - d/dx[(v) p] - d/dv[(- x - 0.2 v) p] + 2 (E[p(x, v - Y)] - p)"
    );
    assert!(
        problem
            .operator()
            .latex(problem.states())
            .to_string()
            .ends_with(r"+ 2 \left(\mathrm{E}[p(x, v - Y)] - p\right)")
    );
    let problem = Problem::from_toml(TEXT)?;
    let text = problem.operator().text(problem.states()).to_string();
    assert!(
        text.contains("+ 2 (E[p(before x, v -> x, v + (1 + x) Y1)] - p)") && text.contains("(E[p(x, v - Y2)] - p)"),
        "{text}"
    );
    Ok(())
}

/// 𝓖v² = −0.4 v² − 2xv + λ (E[Y²] H² + 2 E[Y] H v), summed over the sources.
#[test]
fn moment_equations_include_impulses() -> Result<()> {
    let problem = Problem::from_toml(TEXT)?;
    let [x, v] = [0, 1].map(|i| Polynomial::variable(2, i));
    let rate = problem.operator().generator(&(&v * &v));
    let h = &x + 1.0;
    let exact = &v * &v * -0.4 + &x * &v * -2.0 + &h * &h * (2.0 * 0.36) + &v * (2.0 * 0.1 / 0.3) + (0.01 + 0.08) / 0.3;
    assert!((rate - exact).max_coefficient() < 1e-14);
    // With additive impulses E v² − (E v)² = λE[Y²]/(2c) and E x = λE[Y] for a linear oscillator.
    for impulses in laws(2.0, 0.2) {
        let gaussian = struck(0.0, &[impulses]).gaussian()?;
        assert!((gaussian.covariance[(1, 1)] - 1.0).abs() < 1e-12);
        assert!((gaussian.mean[0] - 2.0 * impulses.amplitude().moment(1)).abs() < 1e-12);
    }
    Ok(())
}

/// Errors name the line, the entry, and the text to write instead.
#[test]
fn errors_of_impulses_name_the_line() {
    for (from, to, line, words) in [
        ("rate = 2\n", "", 7, "rate = 2.0"),
        ("rate = 2\n", "rate = -2\n", 7, "above zero"),
        ("amplitude = { normal = { mean = 0, deviation = \"2*s\" } }\n", "", 7, "give one law"),
        ("{ normal", "{ gamma", 9, "give one law"),
        ("deviation = \"2*s\"", "scale = 1", 9, "there are mean, deviation"),
        ("mean = 0, ", "", 9, "give one law"),
        ("deviation = \"2*s\"", "deviation = 0", 7, "above zero"),
        ("v = \"1 + x\"", "y = 1", 10, "there are rate, amplitude, x, v"),
        ("v = \"1 + x\"", "v = \"1/0\"", 10, "division by zero"),
    ] {
        let error = Problem::from_toml(&TEXT.replacen(from, to, 1)).unwrap_err();
        let Error::NotAProblem { line: found, problem, .. } = &error else { panic!("{to}: {error}") };
        assert!(*found == line && problem.contains(words), "{to}: {error}");
    }
    // Impulses that change no state are no noise.
    let silent = TEXT.replace("v = \"1 + x\"\n", "").replace("v = 1\n", "");
    assert!(matches!(Problem::from_toml(&silent), Err(Error::NoDensity { .. })));
}
