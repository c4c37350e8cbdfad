//! The program `expoly` as a user runs it: answers as JSON and as text, tables, figures, and errors that name the value.

#![allow(clippy::unwrap_used, reason = "a value that is missing should fail the test")]

use serde_json::Value;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use support::commands::{self, Program};

/// x″ + c x′ + x = ξ.
const LINEAR: &str = "states = ['x', 'v']\nparameters = { c = 0.5, D = 0.5 }\ndrift = { x = 'v', v = '-x - c*v' }\n\
    noise.w.v = 'sqrt(2*D)'";

fn run(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_expoly")).args(arguments).output().unwrap()
}

/// What a command that fails says.
fn run_text(arguments: &[&str]) -> String {
    let output = run(arguments);
    assert!(!output.status.success());
    String::from_utf8(output.stderr).unwrap()
}

fn scratch(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    folder
}

fn written(folder: &Path, name: &str, text: &str) -> String {
    std::fs::create_dir_all(folder).unwrap();
    std::fs::write(folder.join(name), text).unwrap();
    folder.join(name).into_os_string().into_string().unwrap()
}

fn system(name: &str) -> String {
    format!("{}/examples/systems/{name}.toml", env!("CARGO_MANIFEST_DIR"))
}

/// The answer of a command as JSON.
fn answer(arguments: &[&str]) -> Value {
    let output = run(&[arguments, &["--json"]].concat());
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn solve(file: &str, options: &[&str]) -> Value {
    answer(&[&["solve", &system(file)][..], options].concat())
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

/// The documented fields, for every method; a field that a method does not have is null.
#[test]
fn a_file_is_solved_by_every_method_with_the_promised_fields() {
    let asked = ["--moments", "x^2,v^2,x^2*v^2", "--at", "-0.3,0.2;0.3,0.4", "--marginal", "x=0.5,1.0"];
    // E x², E v² and the impact rate by the grid.
    let known = |answer: &Value, tolerance: f64| {
        for (name, truth) in [("x^2", 0.415_668), ("v^2", 0.824_55)] {
            let moment = &answer["moments"][name];
            let (value, error) = (moment["value"].as_f64().unwrap(), moment["error"].as_f64().unwrap());
            assert!((value - truth).abs() < tolerance * truth + 4.0 * error, "{name}: {answer}");
        }
        let rate = answer["impact_rate"]["value"].as_f64().unwrap();
        assert!((rate - 0.212_25).abs() < 0.02 * 0.212_25, "{answer}");
    };
    for (method, options, name, tolerance) in [
        ("closure", &["--order", "6"][..], "closure", 1e-3),
        ("grid", &[], "grid", 1e-4),
        ("simulation", &["--samples", "200000", "--seed", "3"], "simulation", 1e-3),
    ] {
        let answer = solve("duffing", &[&asked[..], &["--method", method], options].concat());
        let object = answer.as_object().unwrap();
        for field in [
            "method",
            "reason",
            "beside",
            "states",
            "order",
            "unknowns",
            "moments",
            "pdf",
            "marginal",
            "exceedance",
            "crossing",
            "impact_rate",
            "sensitivity",
            "parameters",
            "time",
            "l1_estimate",
            "warning",
            "termination",
            "seconds",
        ] {
            assert!(object.contains_key(field), "{method} has no {field}: {answer}");
        }
        assert_eq!((&answer["method"], &answer["states"]), (&name.into(), &serde_json::json!(["x", "v"])));
        assert_eq!(answer["moments"].as_object().unwrap().len(), 3);
        known(&answer, tolerance);
        let pdf = answer["pdf"].as_array().unwrap();
        assert_eq!((pdf.len(), &pdf[1]["x"]), (2, &serde_json::json!([0.3, 0.4])));
        assert!(pdf.iter().all(|p| p["value"].as_f64().unwrap() > 0.05 && p["error"].is_number()), "{answer}");
        let marginal = answer["marginal"].as_array().unwrap();
        assert_eq!((marginal.len(), &marginal[1]["state"], &marginal[1]["at"]), (2, &"x".into(), &1.0.into()));
        assert!(marginal.iter().all(|p| p["value"].as_f64().unwrap() > 0.1 && p["error"].is_number()), "{answer}");
        assert!(answer["seconds"].as_f64().unwrap() > 0.0 && answer["warning"].is_null());
        assert_eq!(answer["order"].is_u64(), method == "closure");
        assert_eq!(answer["l1_estimate"].is_number(), method != "simulation", "{answer}");
        assert_eq!(answer["unknowns"].is_u64(), method != "simulation", "{answer}");
        assert_eq!(answer["termination"].is_string(), method == "closure", "{answer}");
    }
    // The classical closure of this wall at order 6 has no root: the object has the termination, and no values.
    let classical = solve("duffing", &["--method", "classical", "--order", "6"]);
    assert_eq!((&classical["termination"], &classical["impact_rate"]), (&"no root".into(), &Value::Null));
    assert!(classical["moments"].as_object().unwrap().is_empty());
    // Splitting has densities and exceedances at levels, and no moments.
    let options = ["--method", "splitting", "--marginal", "x=1.0", "--exceedance", "x=2.5"];
    let tails = solve("duffing", &options);
    let exceedance = &tails["exceedance"][0];
    // By the closure, README has 2.95e-5.
    let [beyond, error] = ["value", "error"].map(|name| number(&exceedance[name]));
    assert!((beyond - 2.95e-5).abs() < 4.0 * error && error < 0.2 * beyond, "{tails}");
    assert!(tails["moments"].as_object().unwrap().is_empty() && tails["marginal"][0]["value"].is_number(), "{tails}");
}

/// Without a method the answer is that of the one that serves, and says why: the closure that is exact, the grid where no exponential
/// polynomial is near, and in three states the closure with a simulation beside it.
#[test]
fn the_method_that_serves_is_found() {
    let folder = scratch("serving");
    std::fs::create_dir_all(&folder).unwrap();
    let solved = |name: &str, text: &str, options: &[&str]| -> Value {
        let path = folder.join(name);
        std::fs::write(&path, text).unwrap();
        answer(&[&["solve", path.to_str().unwrap()][..], options].concat())
    };
    let oscillator = "states = ['x', 'v']\ndrift = { x = 'v', v = '-x - 0.5*v' }\nnoise.w.v = '1'";
    let exact = solved("linear.toml", oscillator, &[]);
    assert_eq!((&exact["method"], &exact["beside"]), (&"closure".into(), &Value::Null), "{exact}");
    let narrow = include_str!("cases/recharge.toml");
    let answer = solved("recharge.toml", narrow, &[]);
    let reason = answer["reason"].as_str().unwrap();
    assert!(answer["method"] == "grid" && reason.contains("the closure"), "{answer}");
    assert!(answer["l1_estimate"].as_f64().unwrap() < 1e-5 && answer["warning"].is_null(), "{answer}");
    let filtered =
        "states = ['x', 'v', 'z']\ndrift = { x = 'v', v = '-x^3 + x - 0.2*v + z', z = '-z' }\nnoise.w.z = '0.5'";
    let doubted = solved("filtered.toml", filtered, &["--order", "2", "--samples", "100000"]);
    assert_eq!(
        (&doubted["method"], &doubted["beside"]["method"]),
        (&"closure".into(), &"simulation".into()),
        "{doubted}"
    );
    // What the closure's estimate must be below to stand alone.
    assert!(doubted["l1_estimate"].as_f64().unwrap() > 1e-2, "{doubted}");
}

/// Several orders are an array, one object for each; as text a table with a column for each.
#[test]
fn several_orders_of_a_file_are_an_array_or_a_table() {
    let answers = solve("filtered", &["--orders", "2,4", "--moments", "x^2,z^2"]);
    let answers = answers.as_array().unwrap();
    assert_eq!(answers.iter().map(|a| a["order"].as_u64().unwrap()).collect::<Vec<_>>(), [2, 4]);
    assert!(answers[0]["unknowns"].as_u64().unwrap() < answers[1]["unknowns"].as_u64().unwrap());
    for answer in answers {
        // The filter's own variance is a D.
        assert!((answer["moments"]["z^2"]["value"].as_f64().unwrap() / 0.8 - 1.0).abs() < 0.02, "{answer}");
        assert!(answer["impact_rate"].is_null() && answer["states"].as_array().unwrap().len() == 3);
    }
    let output = run(&["solve", &system("duffing"), "--orders", "2,4", "--moments", "x^2"]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.starts_with("states = [\"x\", \"v\"]"), "{text}");
    for word in ["method", "E x^2", "impacts per unit time", "estimated L1 error", "seconds"] {
        assert!(text.lines().any(|line| line.starts_with(word)), "{word}: {text}");
    }
}

#[test]
fn wrong_files_and_questions_name_the_value() {
    let folder = scratch("systems");
    let text = std::fs::read_to_string(system("duffing")).unwrap();
    let misspelt = written(&folder, "misspelt.toml", &text.replace("- k*x", "- q*x"));
    let nowhere = folder.join("none.toml").into_os_string().into_string().unwrap();
    let duffing = system("duffing");
    for (arguments, expected) in [
        (&[&nowhere[..]][..], &["cannot read", "none.toml"][..]),
        (&[&misspelt], &["misspelt.toml", "line 13", "\"q\" is neither a state nor a parameter"]),
        (&[&duffing, "--moments", "y^2"], &["--moments", "\"y\""]),
        (&[&duffing, "--moments", "x^a"], &["\"a\" is no whole power"]),
        (&[&duffing, "--at", "0.1"], &["--at", "1 numbers for 2 states"]),
        (&[&duffing, "--at", "0.1,inf"], &["\"inf\" is no finite number"]),
        (&[&duffing, "--marginal", "0.5"], &["write STATE=VALUE"]),
        (&[&duffing, "--order", "0"], &["order of the closure = 0"]),
        (&[&duffing, "--orders", "4,99"], &["order of the closure = 99"]),
        (&[&duffing, "--method", "oracle"], &["oracle"]),
        (&[&system("absorber"), "--method", "grid"], &["the grid does not serve"]),
        (&[&duffing, "--set", "q=0.1"], &["--set", "\"q\""]),
        (&[&duffing, "--set", "c"], &["write NAME=VALUE"]),
        (&[&duffing, "--set", "c=0.1,0.2", "--figure", "out.svg"], &["--figure", "one value of each parameter"]),
        (&[&duffing, "--sensitivity", "q"], &["\"q\" is no parameter; there are c, k, mu, D"]),
        (&[&duffing, "--sensitivity", "c", "--method", "simulation"], &["--sensitivity", "closure and grid"]),
        (&[&duffing, "--crossing", "v=1"], &["no state is the velocity of v"]),
    ] {
        let output = run(&[&["solve"][..], arguments, &["--json"]].concat());
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(!output.status.success() && output.stdout.is_empty(), "{arguments:?}");
        assert!(message.starts_with("error: ") && !message.contains("panicked"), "{arguments:?}: {message}");
        assert!(expected.iter().all(|word| message.contains(word)), "{arguments:?}: {message}");
    }
}

/// A list of values is a table, one answer for each system and order; a linear oscillator has E x'² = D/c.
#[test]
fn values_of_parameters_make_a_table() {
    let folder = scratch("tables");
    let linear = written(&folder, "linear.toml", LINEAR);
    let answers = answer(&["solve", &linear, "--set", "c=0.5,1", "--set", "D=0.25", "--orders", "2,4"]);
    let answers = answers.as_array().unwrap();
    let found: Vec<[f64; 3]> = answers
        .iter()
        .map(|a| [&a["parameters"]["c"], &a["parameters"]["order"], &a["moments"]["v^2"]["value"]].map(number))
        .collect();
    let expected = [[0.5, 2.0, 0.5], [0.5, 4.0, 0.5], [1.0, 2.0, 0.25], [1.0, 4.0, 0.25]];
    for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
        assert!((found - expected).abs() < 1e-9, "{answers:?}");
    }
    let output = run(&["solve", &linear, "--set", "c=0.5,1"]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("c = 0.5") && text.contains("c = 1"), "{text}");
}

/// p = C exp(−(c/D)(x'²/2 + x²/2)): derivatives of E x'² = D/c, of the rate √k/2π exp(−a²/2σ²) of a level a, and of P(x > a).
#[test]
fn derivatives_and_crossings_are_those_of_a_normal_density() {
    let linear = written(&scratch("derivatives"), "linear.toml", LINEAR);
    for method in ["closure", "grid"] {
        let asked = ["--crossing", "x=1", "--exceedance", "x=1", "--sensitivity", "D,c", "--method", method];
        let found = answer(&[&["solve", &linear][..], &asked].concat());
        // σ² = D/c = 1 here.
        let (rate, density) =
            ((-0.5_f64).exp() / std::f64::consts::TAU, (-0.5_f64).exp() / std::f64::consts::TAU.sqrt());
        assert!((number(&found["crossing"][0]["value"]) / rate - 1.0).abs() < 1e-6, "{found}");
        let by = &found["sensitivity"][0];
        assert_eq!(by["parameter"], "D");
        // dσ²/dD = 1/c = 2, d ln ν/dσ² = a²/2σ⁴, dP/dσ² = a p(a)/2σ².
        for (value, truth) in [
            (&by["moments"]["v^2"], 2.0),
            (&by["crossing"][0], rate),
            (&by["exceedance"][0], density),
            (&found["sensitivity"][1]["moments"]["v^2"], -2.0),
        ] {
            assert!((number(&value["value"]) - truth).abs() < 1e-4, "{method}: {truth} and {value}");
        }
    }
}

/// A linear oscillator from a normal density by all methods: the closure is exact, and the grid off by 5e-7 where its steps may be off by
/// 1e-4; a simulation by its own errors. While an envelope is 0 the motion is that without noise.
#[test]
fn transients_are_followed_by_every_method() {
    let linear = written(&scratch("transients"), "linear.toml", LINEAR);
    let run = |method: &str, more: &[&str]| {
        let options = ["--times", "1,2", "--method", method, "--moments", "x^2,v^2", "--samples", "20480"];
        answer(&[&["transient", &linear][..], &options, more].concat())
    };
    let grid = run("grid", &["--spread", "x=0.3,v=0.3"]);
    for method in ["closure", "simulation"] {
        let other = run(method, &["--spread", "x=0.3,v=0.3"]);
        for (k, name) in [(0, "x^2"), (0, "v^2"), (1, "x^2"), (1, "v^2")] {
            assert_eq!(other[k]["time"], [1.0, 2.0][k]);
            let [a, b] = [&grid, &other].map(|answer| number(&answer[k]["moments"][name]["value"]));
            let error = number(&other[k]["moments"][name]["error"]);
            assert!((a - b).abs() < 1e-6 + 4.0 * error, "{method} {name}: {a} and {b} ± {error}");
        }
    }
    let still = run("simulation", &["--start", "x=1", "--envelope", "0:0,2:0,3:1"]);
    // x = e^(−ct/2) (cos ω t + c/2ω sin ω t) at t = 1.
    let (omega, decay) = (0.9375_f64.sqrt(), (-0.25_f64).exp());
    let x = decay * (omega.cos() + 0.25 / omega * omega.sin());
    // The steps' own error is 8e-9.
    assert!((number(&still[0]["moments"]["x^2"]["value"]) - x * x).abs() < 2e-8, "{still}");
}

/// Survival below a level by grid and simulation, with the rate and the mean time that a grid has.
#[test]
fn first_passages_agree() {
    let linear = written(&scratch("passages"), "linear.toml", LINEAR);
    let run = |method: &str| {
        answer(&["survive", &linear, "--below", "1.5", "--times", "1,5", "--method", method, "--samples", "40960"])
    };
    let (grid, simulation) = (run("grid"), run("simulation"));
    for k in 0..2 {
        let [a, b] = [&grid, &simulation].map(|answer| number(&answer["survival"][k]["value"]));
        let error = number(&simulation["survival"][k]["error"]);
        // The grid's error is below 1e-5.
        assert!((a - b).abs() < 4.0 * error, "{a} and {b} ± {error}");
    }
    let [rate, mean] = ["rate", "mean_time"].map(|name| number(&grid[name]["value"]));
    // Of the stationary start a part has passed at once, and the rest passes at about the rate.
    assert!(rate > 0.0 && mean < 1.0 / rate && mean > 0.7 / rate, "{grid}");
    assert!(simulation["rate"].is_null());
    let output = run_text(&["survive", &linear, "--times", "1"]);
    assert!(output.contains("--below"), "{output}");
}

/// A study of orders is resumed from its table, and has the closure's errors against the grid.
#[test]
fn orders_are_a_study_that_goes_on_from_its_table() {
    let folder = scratch("orders");
    let rows = folder.join("rows.csv");
    let run = |orders: &str| {
        answer(&[
            "orders",
            &system("duffing"),
            "--orders",
            orders,
            "--accuracy",
            "1e-3",
            "--out",
            rows.to_str().unwrap(),
        ])
    };
    std::fs::create_dir_all(&folder).unwrap();
    let first = run("2")["rows"][0]["l1"].clone();
    let all = run("2,4");
    assert_eq!(all["rows"][0]["l1"], first);
    assert!(number(&all["rows"][1]["l1"]) < number(&first), "{all}");
}

/// The figure is a drawing with its numbers beside it.
#[test]
fn a_figure_is_drawn_with_its_numbers() {
    let folder = scratch("figures");
    let (linear, path) = (written(&folder, "linear.toml", LINEAR), folder.join("density.svg"));
    let output = run(&["solve", &linear, "--figure", path.to_str().unwrap()]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let drawing = std::fs::read_to_string(&path).unwrap();
    assert!(drawing.contains("c = 0.5") && drawing.contains("estimated L¹ error"), "no caption");
    let table = std::fs::read_to_string(folder.join("density.svg.csv")).unwrap();
    // Two states alone, and both together.
    assert!(["p(x)", "p(v)", "p(x, v)"].iter().all(|name| table.contains(name)), "{}", &table[..200]);
}

/// A system from standard input.
#[test]
fn standard_input_is_a_file_as_well() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_expoly"));
    command.args(["solve", "-", "--json"]).stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut child = command.spawn().unwrap();
    child.stdin.take().unwrap().write_all(LINEAR.as_bytes()).unwrap();
    let answer: Value = serde_json::from_slice(&child.wait_with_output().unwrap().stdout).unwrap();
    assert!((number(&answer["moments"]["v^2"]["value"]) - 1.0).abs() < 1e-9, "{answer}");
}

/// The commands of README and guide, their options read before `--help` ends the program; files that they name are there.
#[test]
fn commands_of_the_documents_are_understood() {
    let all = commands::commands().unwrap();
    let own: Vec<_> = all.iter().filter(|command| command.program == Program::Expoly).collect();
    for command in &own {
        for argument in command.arguments.iter().filter(|argument| argument.ends_with(".toml")) {
            assert!(commands::root().join(argument).exists(), "{}: there is no {argument}", command.place);
        }
        let arguments: Vec<&str> = command.arguments.iter().map(String::as_str).chain(["--help"]).collect();
        let output = run(&arguments);
        assert!(output.status.success(), "{}: {}", command.place, String::from_utf8_lossy(&output.stderr));
    }
    assert!(own.len() >= 4, "{} commands", own.len());
}

/// What README shows of an answer is printed, line by line; the example's file is its system.
#[test]
fn readme_shows_what_is_printed() {
    let readme = std::fs::read_to_string(commands::root().join("README.md")).unwrap();
    let asked = ["--exceedance", "x=2.5", "--crossing", "x=2", "--sensitivity", "c"];
    let output = run(&[&["solve", &system("duffing")][..], &asked].concat());
    let printed = String::from_utf8(output.stdout).unwrap();
    assert!(readme.contains(&format!("expoly solve examples/systems/duffing.toml {}", asked.join(" "))));
    let shown: Vec<&str> =
        readme.lines().filter(|line| line.contains(" ± ") || line.starts_with("estimated")).collect();
    for line in &shown {
        assert!(printed.lines().any(|other| other == *line), "{line} is not in\n{printed}");
    }
    assert_eq!(shown.len(), 6);
}
