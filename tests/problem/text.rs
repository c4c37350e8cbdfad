//! Problems as TOML: they come back to the same bits, have the same answers, and errors name line and entry.

use crate::common::*;
use expoly::models::Solved;
use expoly::{Closure, Density, Error, Grid, Interpretation, Problem, Result, Simulation, Wall};
use std::path::Path;

/// All public parts of a problem.
fn assert_same(name: &str, one: &Problem, other: &Problem) {
    assert_eq!((one.states(), one.parameters()), (other.states(), other.parameters()), "{name}");
    assert_eq!((one.drift(), one.noise()), (other.drift(), other.noise()), "{name}");
    assert_eq!((one.interpretation(), one.walls()), (other.interpretation(), other.walls()), "{name}");
    assert_eq!((one.operator(), one.displacements()), (other.operator(), other.displacements()), "{name}");
}

#[test]
fn every_model_comes_back_to_the_same_bits() -> Result<()> {
    let mut problems = every_model();
    let strip = duffing_above(-0.1 - 0.2, 0.9).with_wall(Wall::below(1.0 / 3.0, 2.0 / 3.0)?)?;
    problems.push(("between walls", strip));
    let chain = chain_of_three().problem()?.with_wall(Wall::below(0.7, 0.5)?.on(4))?;
    problems.push(("a wall on the third mass", chain));
    let pair = Wall::above(-1.0 / 3.0, 0.7)?.between([4, 0], [1.0 / 7.0, 2.0])?;
    problems.push(("walls between bodies", chain_of_three().problem()?.with_wall(pair)?));
    for (name, problem) in &problems {
        let text = problem.to_toml()?;
        let again = Problem::from_toml(&text)?;
        assert_same(name, problem, &again);
        assert_eq!(again.to_toml()?, text, "{name}");
    }
    assert!(problems.iter().any(|(_, problem)| problem.interpretation() == Interpretation::Stratonovich));
    Ok(())
}

const DUFFING: &str = r#"
states = ["x", "v"]
[parameters]
c = 0.2
k = 1
mu = 0.3
D = 0.2
[drift]
x = "v"
v = "-c*v - k*x - mu*x^3"
[noise.w]
v = "sqrt(2*D)"
"#;

const WALL: &str = "[[wall]]\nstate = \"x\"\nabove = -0.5\nrestitution = 0.9\n";

/// The text's field is the polynomials, the model's its own definition: they differ by rounding, and so do the answers.
#[test]
fn a_text_and_a_model_ask_for_the_same_answers() -> Result<()> {
    let (text, model) = (Problem::from_toml(DUFFING)?, duffing().problem().unwrap());
    assert_same("Duffing", &text, &model);
    let walled = Problem::from_toml(&format!("{DUFFING}{WALL}"))?;
    assert_same("above a wall", &walled, &duffing_above(-0.5, 0.9));
    let agree = |what: &str, one: &dyn Density, other: &dyn Density, tolerance: f64| {
        for powers in monomials(2, 4) {
            let (p, q) = (one.moment(&powers).unwrap().value, other.moment(&powers).unwrap().value);
            assert!((p - q).abs() <= tolerance * (1.0 + q.abs()), "{what}, {powers:?}: {p} and {q}");
        }
    };
    let closures = [&walled, &duffing_above(-0.5, 0.9)].map(|problem| Closure::new(4).solve(problem).unwrap());
    agree("closure", &closures[0], &closures[1], 1e-6);
    let classical = [&text, &model].map(|problem| Closure::classical(4).solve(problem).unwrap().density().unwrap());
    agree("classical closure", &classical[0], &classical[1], 0.0);
    let grids = [&text, &model].map(|problem| Grid::new().solve(problem).unwrap());
    agree("grid", &grids[0], &grids[1], 1e-6);
    let simulated = [&text, &model].map(|problem| Simulation::new().samples(50_000).run(problem).unwrap());
    agree("simulation", &simulated[0], &simulated[1], 1e-6);
    assert_eq!(simulated[0].provenance().samples, simulated[1].provenance().samples);
    Ok(())
}

#[test]
fn expressions_parameters_and_interpretations_are_understood() -> Result<()> {
    let problem = Problem::from_toml(
        r#"
        states = ["x", "v", "z"]
        interpretation = "stratonovich"
        [parameters]
        tau = 0.25
        a = "1/tau"              # made of the one above
        g = "sqrt(2)*cos(pi)"
        [drift]
        x = "v"
        v = "-(v - 0.1*x)*(1 + x^2) + z/2"
        z = "-a*z"
        [noise.first]
        z = "a*2"
        [noise.second]
        v = "g*x"
        z = 1
        "#,
    )?;
    assert_eq!(problem.interpretation(), Interpretation::Stratonovich);
    assert_eq!(problem.parameters()[1], (String::from("a"), 4.0));
    assert_eq!(problem.drift()[1].text(problem.states()).to_string(), "0.1 x - v + 0.5 z + 0.1 x^3 - x^2 v");
    assert_eq!((problem.noise()[2].len(), problem.noise()[2][0].evaluate(&[0.0; 3])), (2, 8.0));
    assert_eq!(problem.noise()[1][1].coefficient(&[1, 0, 0]), -(2.0_f64.sqrt()));
    assert_eq!(problem.displacements(), [(0, 1)]);
    assert_same("all of it", &problem, &Problem::from_toml(&problem.to_toml()?)?);
    Ok(())
}

/// Errors name the line, the entry, and the text to write instead.
#[test]
fn errors_name_the_line_and_the_entry() {
    let lines: Vec<&str> = DUFFING.trim_start().lines().collect();
    // The text with one line replaced; its number, from 1; the entry and the words that the error must have.
    for (number, line, entry, words) in [
        (1, "states = \"x\"", "states", "list the states' names"),
        (1, "states = [\"x\", \"x\"]", "x", "two states"),
        (1, "states = [\"x\", \"2v\"]", "2v", "a name is"),
        (1, "states = [\"x\", \"pi\"]", "pi", "none of sqrt"),
        (1, "states = []", "states", "list the states' names"),
        (3, "x = 0.2", "x", "a state has this name"),
        (3, "c = true", "c", "it must be a number"),
        (3, "c = \"2*q\"", "c", "\"q\" is neither a state nor a parameter; there are"),
        (3, "c = \"x\"", "c", "\"x\" is neither"),
        (3, "sin = 0.2", "sin", "a name is"),
        (8, "y = \"v\"", "y", "the drift has no such entry; there are x, v"),
        (8, "", "x", "write 0 where it does not move"),
        (9, "v = \"-c*v - k*x - nu*x^3\"", "v", "\"nu\" is neither"),
        (9, "v = \"x/0\"", "v", "division by zero"),
        (9, "v = \"x^v\"", "v", "may not be an exponent"),
        (9, "v = \"sin(x, v)\"", "v", "one argument"),
        (9, "v = \"max(x)\"", "v", "two arguments"),
        (9, "v = \"heaviside(x)\"", "v", "write step"),
        (9, "v = \"-c*v -\"", "v", "a number or a name is missing"),
        (9, "v = \"-c*(v\"", "v", "not closed"),
        (9, "v = [1]", "v", "in quotes"),
        (10, "[noises.w]", "noises", "a problem has no such entry"),
        (11, "w = 1", "w", "noise.w has no such entry"),
        (11, "v = \"sqrt(2*D", "the text", "no TOML"),
    ] {
        let mut lines = lines.clone();
        lines[number - 1] = line;
        let error = Problem::from_toml(&lines.join("\n")).unwrap_err();
        let Error::NotAProblem { line: found, column, name, problem } = &error else { panic!("{line}: {error}") };
        // A table without an entry is named where the table begins.
        let expected = if line.is_empty() { number - 1 } else { number };
        assert!((*found, &name[..]) == (expected, entry) && problem.contains(words), "{line}: {error}");
        assert!(error.to_string().starts_with(&format!("line {expected}, column {column}: {entry}: ")), "{error}");
    }
    // The column is that of the character within an expression, whatever it is quoted in; of an escaped one where it begins.
    for (drift, expected) in [
        ("v = \"-c*v - floor(x)\"", 13),
        ("v =   '-c*v - floor(x)'", 15),
        ("v = '''-c*v - floor(x)'''", 15),
        ("v = \"\\u002dc*v - floor(x)\"", 5),
    ] {
        let mut lines = lines.clone();
        lines[8] = drift;
        let error = Problem::from_toml(&lines.join("\n")).unwrap_err();
        assert!(matches!(error, Error::NotAProblem { line: 9, column, .. } if column == expected), "{drift}: {error}");
    }
    let first_of_wall = DUFFING.lines().count() + 1;
    for (from, to, words) in [
        ("above", "left", "there are state, between, masses, above, below, restitution"),
        ("restitution", "bounce", "no such entry"),
        ("0.9", "1.9", "0 < r ≤ 1"),
        ("\"x\"", "\"y\"", "name its state"),
        ("\"x\"", "\"v\"", "no displacement"),
        ("above = -0.5\n", "", "give one of the two"),
        ("restitution = 0.9\n", "", "it has no restitution"),
        ("above = -0.5\n", "above = -0.5\nbelow = 0.5\n", "give one of the two"),
        ("state = \"x\"", "between = [\"x\", \"y\"]", "between = "),
        ("state = \"x\"", "between = [\"x\"]", "between = "),
        ("state = \"x\"", "between = [\"x\", \"x\"]", "does not hit itself"),
        ("state = \"x\"", "state = \"x\"\nmasses = [1, 2]", "masses are those of two bodies"),
        ("state = \"x\"", "between = [\"x\", \"v\"]\nmasses = [1]", "give two masses"),
    ] {
        let error = Problem::from_toml(&format!("{DUFFING}{}", WALL.replace(from, to))).unwrap_err();
        let Error::NotAProblem { line, problem, .. } = &error else { panic!("{to}: {error}") };
        assert!((first_of_wall..first_of_wall + 4).contains(line) && problem.contains(words), "{to}: {error}");
    }
    let twice = Problem::from_toml(&format!("{DUFFING}{WALL}{WALL}")).unwrap_err();
    assert!(matches!(twice, Error::NotAProblem { line, .. } if line >= first_of_wall + 4), "{twice}");
    // A system that is none is the same error as from a model.
    let silent = DUFFING.replace("sqrt(2*D)", "0*D");
    assert!(matches!(Problem::from_toml(&silent), Err(Error::NoDensity { .. })));
    for text in ["", "drift = 1", "states = [\"x\"]", "\u{0}", "[[wall]]\n"] {
        assert!(matches!(Problem::from_toml(text), Err(Error::NotAProblem { .. })), "{text:?}");
    }
    // No name that could not be read back is written.
    struct Primed;
    impl expoly::Drift<1, 1> for Primed {
        fn drift<S: expoly::Scalar>(&self, [x]: [S; 1]) -> [S; 1] {
            [-x]
        }
        fn noise<S: expoly::Scalar>(&self, _: [S; 1]) -> [[S; 1]; 1] {
            [[S::from(1.0)]]
        }
        fn names(&self) -> Vec<String> {
            vec![String::from("x'")]
        }
    }
    assert!(matches!(problem(Primed).to_toml(), Err(Error::NotAName { name, .. }) if name == "x'"));
}

#[test]
fn the_files_of_the_example_are_problems() -> Result<()> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/systems");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "toml") {
            let problem = Problem::from_toml(&std::fs::read_to_string(&path).unwrap())?;
            assert_same(&path.display().to_string(), &problem, &Problem::from_toml(&problem.to_toml()?)?);
            count += 1;
        }
    }
    assert!(count >= 2, "{count}");
    let file = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/systems/duffing.toml"));
    assert_same("Duffing", &Problem::from_toml(&file.unwrap())?, &duffing_above(-0.5, 0.9));
    Ok(())
}

/// What people bring from outside of the class is refused by its place, its name and what to write.
#[test]
fn what_is_outside_of_the_class_is_named() {
    // An end reflects without loss.
    let lossy = include_str!("../cases/outside-reflecting.toml").replacen("restitution = 1", "restitution = 0.9", 1);
    for (text, place, words) in
        [(include_str!("../cases/outside-periodic.toml"), [5, 57], "has no time"), (&lossy, [7, 1], "no displacement")]
    {
        let error = Problem::from_toml(text).unwrap_err();
        let Error::NotAProblem { line, column, problem, .. } = &error else { panic!("{error}") };
        assert!([*line, *column] == place && problem.contains(words), "{error}");
    }
}
