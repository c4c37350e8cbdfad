//! The examples as a user runs them: JSON objects, errors that name the value, files whole or not at all.
//!
//! `cargo test` builds the examples beside this test; `cargo test --test examples` alone does not, and takes those that
//! `cargo build --examples` left.

#![allow(clippy::unwrap_used, reason = "a value that is missing should fail the test")]

use expoly::Estimate;
use expoly::models::{Duffing, Solved};
use expoly::statistics::Marginal;
use serde_json::Value;
use std::path::PathBuf;
use std::process::{Command, Output};
use support::commands::{self, Program};
use support::{file, json};

fn executable(example: &str) -> PathBuf {
    std::env::current_exe().unwrap().parent().unwrap().parent().unwrap().join("examples").join(example)
}

fn run(example: &str, arguments: &[&str]) -> Output {
    Command::new(executable(example)).args(arguments).output().unwrap()
}

fn scratch(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    folder
}

#[test]
fn json_is_one_object_with_the_promised_fields() {
    let arguments = ["--json", "--offset", "-0.5", "--restitution", "0.95", "--order", "4", "--basis", "folded"];
    let output = run(
        "vibro_impact",
        &[&arguments[..], &["--samples", "50000", "--seed", "7", "--accuracy", "1e-4", "--at", "-0.4,0.5"]].concat(),
    );
    assert!(output.status.success());
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(answer["parameters"]["offset"], -0.5);
    let (closure, simulation, grid) = (&answer["closure"], &answer["simulation"], &answer["grid"]);
    assert_eq!((closure["order"].as_u64(), closure["unknowns"].as_u64()), (Some(4), Some(14)));
    assert_eq!((closure["method"].as_str(), closure["basis"].as_str()), (Some("classical"), Some("folded")));
    assert_eq!(closure["termination"], "root");
    // A method without estimates of its own error has nulls.
    for field in ["indicator", "l1_estimate", "least_residual", "warning", "refusal"] {
        assert!(closure[field].is_null(), "{field}: {closure}");
    }
    assert_eq!(simulation["seed"], 7);
    for field in ["mean_displacement", "variance_displacement", "mean_square_velocity", "impact_rate"] {
        let (value, error) = (&simulation[field]["value"], &simulation[field]["standard_error"]);
        let distance = (closure[field].as_f64().unwrap() - value.as_f64().unwrap()).abs();
        // This closure's own error is below 1 %; 50 000 samples are a sample of 1 % or so.
        assert!(distance < 0.01 + 5.0 * error.as_f64().unwrap(), "{field}: {closure} and {simulation}");
        // At degree 4 the grid has three digits.
        let distance = (grid[field].as_f64().unwrap() - value.as_f64().unwrap()).abs();
        assert!(distance < 1e-3 + 5.0 * error.as_f64().unwrap(), "{field}: {grid} and {simulation}");
    }
    for field in ["error_estimate", "unknowns", "seconds", "energy_balance"] {
        assert!(grid[field].is_number(), "{field}: {grid}");
    }
    for field in ["iterations", "seconds", "residual", "condition", "energy_balance"] {
        assert!(closure[field].is_number(), "{field}: {closure}");
    }
    assert!(simulation["path_steps"].is_u64() && simulation["time_step"].is_number(), "{simulation}");
    for (k, field) in [(0, "displacement_pdf"), (1, "displacement_pdf")] {
        let estimate = &simulation[field][k];
        let distance = (closure[field][k].as_f64().unwrap() - estimate["value"].as_f64().unwrap()).abs();
        assert!(distance < 0.02 + 5.0 * estimate["standard_error"].as_f64().unwrap());
    }
}

/// Without a basis the closure is the robust one, of order 8, which estimates its own error.
#[test]
fn the_closure_by_default_estimates_its_error() {
    let run_with = |more: &[&str]| -> Value {
        let fixed = ["--json", "--offset", "-0.5", "--restitution", "0.9", "--at", "-0.5,0.2"];
        let output = run("vibro_impact", &[&fixed[..], more].concat());
        assert!(output.status.success(), "{more:?}: {}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let answer = run_with(&["--method", "closure", "--seed", "3"]);
    assert!(answer.get("simulation").is_none() && answer.get("grid").is_none());
    let closure = &answer["closure"];
    assert_eq!((closure["method"].as_str(), closure["order"].as_u64()), (Some("robust"), Some(8)));
    assert_eq!(closure["seed"], 3);
    assert!(closure["l1_estimate"].as_f64().unwrap() < 1e-3, "{closure}");
    assert!(closure["indicator"].as_f64().unwrap() < 1e-2, "{closure}");
    assert_eq!((&closure["least_residual"], &closure["termination"]), (&true.into(), &"least residual".into()));
    assert!(closure["origin"].as_str().unwrap().starts_with("moment equations") && closure["warning"].is_null());
    // E y′² and the impact rate by the grid: 0.82455 and 0.21225.
    assert!((closure["mean_square_velocity"].as_f64().unwrap() / 0.82455 - 1.0).abs() < 1e-3);
    assert!((closure["impact_rate"].as_f64().unwrap() / 0.21225 - 1.0).abs() < 1e-3);
    assert_eq!(closure["displacement_pdf"].as_array().unwrap().len(), 2);
    // The weight is the fit's: all for the middle, or half for the tails.
    let origin =
        |weight| run_with(&["--method", "closure", "--order", "4", "--weight", weight])["closure"]["origin"].clone();
    assert_eq!(origin("density"), "moment equations, tails 0.000");
    assert_eq!(origin("0.5"), "moment equations, tails 0.500");
    let classical = run_with(&["--method", "classical"]);
    assert_eq!((&classical["closure"]["basis"], &classical["closure"]["order"]), (&"classical".into(), &4.into()));
}

/// The same seed prints the same simulation; another one another.
#[test]
fn a_seed_fixes_the_answer() {
    let values = |seed: &str| {
        let output = run("vibro_impact", &["--json", "--method", "simulation", "--samples", "20000", "--seed", seed]);
        let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert!(answer.get("closure").is_none());
        answer["simulation"]["mean_displacement"].clone()
    };
    assert_eq!(values("3"), values("3"));
    assert_ne!(values("3"), values("4"));
}

/// A closure without a density has statistics that are null beside the reason, not instead of it.
#[test]
fn a_missing_density_is_explained() {
    let arguments = ["--json", "--method", "classical", "--restitution", "0.9", "--order", "6", "--at", "0.1"];
    let output = run("vibro_impact", &arguments);
    assert!(output.status.success());
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(answer["closure"]["termination"], "no root");
    assert!(answer["closure"]["refusal"].as_str().unwrap().contains("no root"));
    assert_eq!(answer["closure"]["mean_displacement"], Value::Null);
}

#[test]
fn wrong_options_name_the_value_on_standard_error() {
    for (arguments, expected) in [
        (&["--restitution", "1.5"][..], "1.5"),
        (&["--restitution", "0"], "0 < r ≤ 1"),
        (&["--intensity", "-0.2"], "-0.2"),
        (&["--damping", "nan"], "NaN"),
        (&["--damping", "-0.3", "--restitution", "1"], "no stationary density"),
        (&["--order", "0"], "order"),
        (&["--order", "11"], "11"),
        (&["--order", "0", "--basis", "folded"], "order"),
        (&["--weight", "1.5"], "1.5"),
        (&["--weight", "nan"], "NaN"),
        (&["--weight", "heavy"], "heavy"),
        (&["--method", "simulation", "--samples", "0"], "samples"),
        (&["--at", "0.1,inf"], "inf"),
        (&["--method", "grid", "--accuracy", "0"], "accuracy"),
        (&["--method", "grid", "--accuracy", "1e-2", "--domain", "0", "-0.5", "-6", "6"], "-0.5"),
    ] {
        // Where the option is not about samples there are few of them.
        let few = if arguments.contains(&"--samples") { &[][..] } else { &["--samples", "1000"] };
        let output = run("vibro_impact", &[&["--json"], arguments, few].concat());
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(!output.status.success() && output.stdout.is_empty(), "{arguments:?}");
        assert!(message.starts_with("error: ") && message.contains(expected), "{arguments:?}: {message}");
        assert!(!message.contains("panicked"), "{message}");
    }
}

/// A folder that cannot be made, because a file stands there: the error names it, and nothing is left behind.
#[test]
fn an_output_folder_that_cannot_be_written_is_named() {
    let folder = scratch("blocked");
    std::fs::create_dir_all(&folder).unwrap();
    let blocked = folder.join("file");
    std::fs::write(&blocked, "in the way").unwrap();
    let out = blocked.join("deeper");
    let output = run(
        "vibro_impact",
        &["--samples", "2000", "--accuracy", "1e-2", "--out", out.to_str().unwrap(), "--order", "2"],
    );
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(!output.status.success() && message.contains("cannot write"), "{message}");
    assert!(message.contains(blocked.to_str().unwrap()), "{message}");
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1);
}

/// A run leaves the figure and its numbers, and no temporary file.
#[test]
fn a_run_leaves_its_figure_and_the_numbers_behind_it() {
    let out = scratch("figures");
    let output = run(
        "vibro_impact",
        &[
            "--samples",
            "20000",
            "--accuracy",
            "1e-3",
            "--offset",
            "0.2",
            "--order",
            "2",
            "--out",
            out.to_str().unwrap(),
        ],
    );
    assert!(output.status.success());
    let mut names: Vec<String> =
        std::fs::read_dir(&out).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    assert!(names.iter().all(|name| !name.ends_with(".tmp")), "{names:?}");
    assert_eq!(names, ["b0.2_r0.98.svg", "b0.2_r0.98.svg.csv"]);
    let svg = std::fs::read_to_string(out.join(&names[0])).unwrap();
    assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>") && svg.contains("seed 1"));
    let mut table = csv::Reader::from_path(out.join(&names[1])).unwrap();
    let columns: Vec<String> = table.headers().unwrap().iter().map(str::to_owned).collect();
    assert_eq!(columns[..5], ["title", "abscissa", "ordinate", "series", "x"]);
    let mut series = std::collections::BTreeSet::new();
    for record in table.records() {
        let record = record.unwrap();
        series.insert(record[3].to_owned());
        assert!(record.iter().skip(4).all(|field| field.is_empty() || field.parse::<f64>().is_ok_and(f64::is_finite)));
    }
    for name in ["grid", "simulation", "robust n = 2"] {
        assert!(series.iter().any(|one| one.starts_with(name)), "{name}: {series:?}");
    }
}

/// JSON has no NaN: a number that would become `null` is an error that names it.
#[test]
fn a_json_value_that_would_be_nan_is_an_error() {
    for value in [f64::NAN, f64::INFINITY] {
        let error = serde_json::to_string(&json::Number::new("impact_rate", value)).unwrap_err().to_string();
        assert!(error.contains("impact_rate") && error.contains(&value.to_string()), "{error}");
        let estimate = Estimate { value: 1.0, error: value };
        assert!(serde_json::to_string(&json::Sampled::new("energy_balance", estimate)).is_err());
    }
    assert_eq!(serde_json::to_string(&json::Number::new("x", 0.1)).unwrap(), "0.1");
}

#[test]
fn tables_keep_every_digit() {
    let path = scratch("digits").join("deep/table.csv");
    let row = vec![0.1 + 0.2, 1e-300, std::f64::consts::PI];
    file::write_csv(&path, &["a", "b", "c"].map(String::from), std::slice::from_ref(&row)).unwrap();
    let mut reader = csv::Reader::from_path(&path).unwrap();
    let back: Vec<f64> = reader.records().next().unwrap().unwrap().iter().map(|f| f.parse().unwrap()).collect();
    assert_eq!(back, row);
}

fn order_study(arguments: &[&str]) -> Value {
    let output = run("order_convergence", &[arguments, &["--json"]].concat());
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn an_order_study_has_one_row_an_order() {
    let answer = order_study(&["--model", "duffing", "--orders", "2,4,6", "--method", "robust"]);
    let rows = answer["rows"].as_array().unwrap();
    assert_eq!(rows.iter().map(|row| row["order"].as_u64().unwrap()).collect::<Vec<_>>(), [2, 4, 6]);
    assert!(rows[0]["l1"].as_f64().unwrap() > 0.01 && rows[1]["l1"].as_f64().unwrap() < 1e-10);
    assert_eq!((&rows[0]["termination"], &rows[1]["termination"]), (&"least residual".into(), &"root".into()));
    let estimate = rows[0]["l1_estimate"].as_f64().unwrap();
    assert!((0.5..2.0).contains(&(rows[0]["l1"].as_f64().unwrap() / estimate)), "{}", rows[0]);
    assert_eq!((&rows[1]["origin"], &rows[1]["truth"]), (&"exact".into(), &"exact density".into()));
    assert!(rows.iter().all(|row| row["method"] == "robust" && row["indicator"].is_number()));
}

/// Where the literature's closure has no root, the robust one has a density, and both rows stand beside each other.
#[test]
fn an_order_study_sets_the_classical_closure_beside_the_robust_one() {
    let options = ["--model", "van_der_pol", "--orders", "6", "--weight", "density", "--seed", "2"];
    let answer = order_study(&options);
    let [robust, classical] = answer["rows"].as_array().unwrap().as_slice() else { panic!("{answer}") };
    assert!(robust["l1"].as_f64().unwrap() < 0.1 && robust["seed"] == 2, "{robust}");
    assert_eq!(robust["origin"], "moment equations, tails 0.000");
    assert!(classical["l1"].is_null() && classical["termination"] == "not closed", "{classical}");
    assert!(classical["refusal"].as_str().unwrap().contains("no root"));
    let alone = order_study(&["--model", "duffing", "--orders", "4", "--method", "classical"]);
    assert_eq!(alone["rows"].as_array().unwrap().len(), 1);
}

/// Four states, on samples: no number is NaN, which JSON does not have.
#[test]
fn an_order_study_takes_more_than_two_states() {
    let options =
        ["--model", "two_degrees_of_freedom", "--orders", "2", "--closest-to", "states", "--method", "robust"];
    let row = &order_study(&options)["rows"][0];
    assert!((0.02..0.15).contains(&row["l1"].as_f64().unwrap()), "{row}");
    assert!(row["origin"].as_str().unwrap() == "maximum likelihood" && row["l1_estimate"].is_number());
}

/// A run leaves its table, its figure and the numbers in it; another begins anew unless it is told to go on.
#[test]
fn an_order_study_goes_on_where_it_is_told_to() {
    let out = scratch("orders");
    let run = |orders: &str, more: &[&str]| {
        let fixed = ["--model", "linear", "--orders", orders, "--out", out.to_str().unwrap()];
        let output = run("order_convergence", &[&fixed[..], more].concat());
        (output.status.success(), String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap())
    };
    let (succeeded, text, _) = run("2,4", &[]);
    assert!(succeeded && text.contains("c = 0.2, k = 1, D = 0.2; against the exact density"), "{text}");
    let table = std::fs::read_to_string(out.join("linear.csv")).unwrap();
    assert_eq!(table.lines().count(), 1 + 4);
    assert!(out.join("linear.svg").exists() && out.join("linear.svg.csv").exists());
    assert!(run("2,4", &["--resume"]).0 && std::fs::read_to_string(out.join("linear.csv")).unwrap() == table);
    let (succeeded, _, message) = run("2,4", &["--resume", "--seed", "2"]);
    assert!(!succeeded && message.contains("linear.csv"), "{message}");
    // An order is added; a study that begins anew has its own rows alone.
    assert!(run("2,4,6", &["--resume"]).0);
    let longer = std::fs::read_to_string(out.join("linear.csv")).unwrap();
    assert!(longer.starts_with(&table) && longer.lines().count() == 1 + 6, "{longer}");
    assert!(run("2", &[]).0 && std::fs::read_to_string(out.join("linear.csv")).unwrap().lines().count() == 1 + 2);
}

/// At the optimum the closed form has the probability demanded, and the slopes of cost and P, by differences, are parallel: both to
/// 1e-6, by the digits that are printed, where a search might end at 1e-4 of the cost and so at a hundredth of the parameters.
#[test]
fn a_design_is_optimal_by_the_closed_form() {
    let output = run("design", &["--accuracy", "0"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    let value = |name: &str| -> f64 {
        let line = text.lines().find(|line| line.trim_start().starts_with(name)).unwrap();
        line.rsplit(' ').next().unwrap().parse().unwrap()
    };
    let (c, mu) = (value("c ="), value("mu ="));
    let exceedance = |c: f64, mu: f64| {
        let exact = Duffing::new(c, 1.0, mu, 0.2).unwrap().exact().unwrap();
        Marginal::new(&exact, 0).unwrap().exceedance(2.5).unwrap().value
    };
    assert!((exceedance(c, mu) / 1e-4 - 1.0).abs() < 1e-5, "{text}");
    let h = 1e-4;
    let slope = [exceedance(c + h, mu) - exceedance(c - h, mu), exceedance(c, mu + h) - exceedance(c, mu - h)];
    let cost = [2.0 * c / 0.04, 2.0 * mu / 0.09];
    let sine = (slope[0] * cost[1] - slope[1] * cost[0]) / (slope[0].hypot(slope[1]) * cost[0].hypot(cost[1]));
    assert!(sine.abs() < 1e-4, "{sine:e}");
    assert!(!text.contains("not converged"), "{text}");
}

#[test]
fn wrong_options_of_an_order_study_are_named() {
    for (arguments, expected) in [
        (&["--model", "nonsense"][..], "there are linear"),
        (&["--model", "linear", "--orders", "2,0"], "order"),
        (&["--model", "linear", "--orders", "17"], "17"),
        (&["--model", "linear", "--weight", "-0.5"], "-0.5"),
        (&["--weight", "tails"], "tails"),
        (&["--closest-to", "some"], "some"),
        (&["--model", "two_degrees_of_freedom", "--reference", "grid"], "its exact density"),
        (&["--model", "van_der_pol", "--reference", "exact"], "no exact density"),
    ] {
        let out = scratch("refused");
        let output = run("order_convergence", &[arguments, &["--out", out.to_str().unwrap()]].concat());
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(!output.status.success() && output.stdout.is_empty(), "{arguments:?}");
        assert!(message.starts_with("error: ") && message.contains(expected), "{arguments:?}: {message}");
        assert!(!message.contains("panicked"), "{message}");
    }
}

/// Three states: the closure's moments agree with the simulation's.
#[test]
fn coloured_noise_prints_moments_beside_a_simulation() {
    let out = scratch("coloured_noise");
    let output = run("coloured_noise", &["--bandwidths", "2", "--samples", "20000", "--out", out.to_str().unwrap()]);
    let text = String::from_utf8(output.stdout).unwrap();
    let row = text.lines().find(|line| line.trim_start().starts_with("2 ")).unwrap();
    let numbers: Vec<f64> = row.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    // Second and fourth moments with their standard errors, both calibrated: 20 000 samples give them to 0.17 %, the
    // closure's pilot has more of them and is two to five times as precise. Before them stands the second moment by the
    // reference, of which the closure's is within its own standard error and a few.
    let [exactly, reference_error] = [numbers[1], numbers[2]];
    assert!((exactly - numbers[3]).abs() < 4.0 * numbers[4] && reference_error < 1e-5 * exactly, "{text}");
    for moment in [&numbers[3..7], &numbers[7..11]] {
        let [closed, error, sampled, spread] = [0, 1, 2, 3].map(|k| moment[k]);
        let apart = (closed - sampled).abs() / error.hypot(spread);
        assert!(apart < 4.0 && error < spread && spread < 0.004 * sampled, "{text}");
    }
    // The figure's numbers are beside it.
    let table = std::fs::read_to_string(out.join("bandwidth.svg.csv")).unwrap();
    assert!(table.starts_with("title,abscissa,ordinate,series,x,y,low,high,value\n") && table.contains("a = 2,"));
}

/// A density of three states: moments of the grid beside a simulation's, both with their errors, and a figure.
#[test]
fn three_states_print_moments_beside_a_simulation() {
    let out = scratch("three_states");
    let arguments = ["--accuracy", "1e-2", "--samples", "20000", "--out", out.to_str().unwrap()];
    let text = String::from_utf8(run("three_states", &arguments).stdout).unwrap();
    let rows: Vec<&str> = text.lines().filter(|line| line.starts_with("E [")).collect();
    assert_eq!(rows.len(), 5, "{text}");
    for row in rows {
        let numbers: Vec<f64> =
            row.split(": ").nth(1).unwrap().split_whitespace().filter_map(|word| word.parse().ok()).collect();
        let [found, own, sampled, error] = numbers[..] else { panic!("{row}") };
        assert!((found - sampled).abs() < own + 4.0 * error, "{row}");
    }
    assert!(out.join("density.svg").exists());
}

/// Where the motion crosses between the wells, more than twice the linear harvester's share: by the closure, and by a
/// simulation within four of its standard errors.
#[test]
fn a_harvester_with_two_wells_delivers_more_than_a_linear_one() {
    let out = scratch("harvester_power");
    let output =
        run("harvester_power", &["--intensities", "0.04", "--samples", "20000", "--out", out.to_str().unwrap()]);
    let text = String::from_utf8(output.stdout).unwrap();
    // 0.25 / (0.25 + 0.1 (0.1 + 0.2 + 2.25/0.2)).
    assert!(text.starts_with("a linear harvester of the wells' frequency takes 17.79 % of"), "{text}");
    let row = text.lines().find(|line| line.trim_start().starts_with("0.04 ")).unwrap();
    let numbers: Vec<f64> = row.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    let [power, error, sampled, spread, share, ratio] = [1, 2, 3, 4, 5, 6].map(|k| numbers[k]);
    assert!((power - sampled).abs() < 4.0 * spread && error < 0.2 * spread, "{text}");
    // The share from a simulation of 20 million samples is 41.0 %.
    assert!((share - 41.0).abs() < 0.5 && (ratio - 2.31).abs() < 0.03, "{text}");
    let table = std::fs::read_to_string(out.join("power.svg.csv")).unwrap();
    assert!(
        table.starts_with("title,abscissa,ordinate,series,x,y,low,high,value\n") && table.contains(",closure,0.04,")
    );
}

#[test]
fn many_states_takes_a_chain_of_any_length() {
    let output = run("many_states", &["--oscillators", "5", "--order", "2", "--samples", "20000"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let output = run("many_states", &["--oscillators", "1"]);
    assert!(!output.status.success() && String::from_utf8(output.stderr).unwrap().contains("two at least"));
}

/// The short table of README is of numbers that the measured page on accuracy has.
#[test]
fn the_readme_quotes_the_page_on_accuracy() {
    let read = |name: &str| std::fs::read_to_string(commands::root().join(name)).unwrap();
    let (readme, page) = (read("README.md"), read("src/guide/accuracy.md"));
    let table = readme.lines().skip_while(|line| !line.starts_with("| system | error")).skip(2);
    let mut quoted = 0;
    for row in table.take_while(|line| line.starts_with('|')) {
        let words = row.split(|c: char| !(c.is_ascii_digit() || ".e-".contains(c)));
        for number in words.filter(|word| word.contains(['.', 'e']) && word.parse::<f64>().is_ok()) {
            quoted += 1;
            assert!(page.contains(number), "the page on accuracy does not have the {number} of {row}");
        }
    }
    assert!(quoted > 10, "{quoted} numbers");
}

/// The commands of README and guide, their options read before `--help` ends the program; files that they name are there. What
/// takes no options is not run. Every example is among them.
#[test]
fn commands_of_the_documents_are_understood() {
    let mut named = std::collections::BTreeSet::new();
    for command in commands::commands().unwrap() {
        let Program::Example(example) = &command.program else { continue };
        assert!(executable(example).exists(), "{}: there is no example {example}", command.place);
        for argument in command.arguments.iter().filter(|argument| argument.ends_with(".toml")) {
            assert!(commands::root().join(argument).exists(), "{}: there is no {argument}", command.place);
        }
        if !command.arguments.is_empty() {
            let arguments: Vec<&str> = command.arguments.iter().map(String::as_str).chain(["--help"]).collect();
            let output = run(example, &arguments);
            assert!(output.status.success(), "{}: {}", command.place, String::from_utf8_lossy(&output.stderr));
        }
        named.insert(example.clone());
    }
    let folder = commands::root().join("examples").read_dir().unwrap();
    for path in folder.map(|entry| entry.unwrap().path()) {
        let example = path.file_stem().unwrap().to_str().unwrap();
        if path.extension().is_some_and(|end| end == "rs") || path.join("main.rs").exists() {
            assert!(named.contains(example), "no document names the example {example}");
        }
    }
}
