//! Identification: parameters of simulated records within their errors, what cannot be found, hostile input.

use expoly::inverse::{Identification, uncertainty};
use expoly::models::{Duffing, Solved};
use expoly::{Closure, ClosureSensitivity, Error, Problem, Result, Sensitivity, Simulation, States};

fn problem() -> Problem {
    Duffing::new(0.2, 1.0, 0.3, 0.2).unwrap().problem().unwrap()
}

/// Records of so many states, an interval apart, one for each trajectory.
fn records(count: usize, each: usize, interval: f64) -> Vec<States> {
    let simulation = Simulation::new().trajectories(count).samples(count * each).sampling_interval(interval);
    let all = simulation.seed(7).states(&problem()).unwrap();
    let record = |k: usize| {
        let mut states = States::new(2);
        all.iter().skip(k * each).take(each).for_each(|x| states.push(x));
        states
    };
    (0..count).map(record).collect()
}

/// k, μ and c from five records of correlated states. The deviations over the stated errors have the mean square 1 ± 0.4 for
/// independent ones, and those by the information alone are off where the states are correlated.
#[test]
fn parameters_of_records_are_within_their_errors() -> Result<()> {
    let truth = [("k", 1.0), ("mu", 0.3), ("c", 0.2)];
    let start = [("k", 1.2), ("mu", 0.4), ("c", 0.25)];
    let start = start.iter().try_fold(problem(), |problem, (name, value)| problem.with_parameter(name, *value))?;
    let mut squares = Vec::new();
    for states in records(5, 4000, 1.0) {
        let identification = Identification::new(&start, &["k", "mu", "c"]).closure(Closure::new(4));
        let found = identification.run(&states)?;
        assert!(found.converged() && found.solves() <= 6, "{} solutions", found.solves());
        for ((name, value), (other, truth)) in found.parameters().iter().zip(truth) {
            assert_eq!(*name, other);
            squares.push(value.deviation(truth).powi(2));
        }
        let intervals = found.intervals();
        let (width, error) = (intervals[0].1[1] - intervals[0].1[0], found.parameters()[0].1.error);
        // Student's distribution of 30 batches.
        assert!((width / (2.0 * error) - 2.04).abs() < 0.01, "{}", width / (2.0 * error));
        assert_eq!(found.problem().parameters()[0].1, found.parameters()[2].1.value);
        // √(gᵀVg) of an answer.
        let square = |by: &ClosureSensitivity| by.moment(&[2, 0]);
        let made = uncertainty(found.sensitivities(), found.covariance(), square)?;
        let g: Vec<f64> = found.sensitivities().iter().map(|by| square(by).unwrap().value).collect();
        let sum: f64 = (0..9).map(|k| g[k / 3] * found.covariance()[(k / 3, k % 3)] * g[k % 3]).sum();
        assert!((made / sum.sqrt() - 1.0).abs() < 1e-12, "{made} and {sum}");
    }
    let mean = squares.iter().sum::<f64>() / squares.len() as f64;
    println!("mean square deviation {mean:.2}");
    assert!((0.4..2.2).contains(&mean), "{squares:?}");
    Ok(())
}

/// p depends on D/c alone: the combination that leaves it as it is, δc/c = δD/D, is named.
#[test]
fn the_combination_that_cannot_be_found_is_named() -> Result<()> {
    let states = &records(2, 1000, 2.0)[0];
    let Err(Error::Unidentifiable { combination }) = Identification::new(&problem(), &["k", "c", "D"]).run(states)
    else {
        panic!("c and D cannot both be found");
    };
    let share = |name: &str| combination.iter().find(|(other, _)| other == name).map_or(0.0, |(_, share)| *share);
    assert!(share("k") == 0.0 && (share("c") / share("D") - 1.0).abs() < 1e-3, "{combination:?}");
    Ok(())
}

#[test]
fn bad_input_is_refused() -> Result<()> {
    let states = &records(2, 1000, 2.0)[0];
    let of = |names: &[&str]| Identification::new(&problem(), names);
    assert!(matches!(of(&["no such"]).run(states), Err(Error::NotAName { .. })));
    assert!(matches!(of(&[]).run(states), Err(Error::OutOfRange { .. })));
    assert!(matches!(of(&["k"]).batch(500).run(states), Err(Error::OutOfRange { .. })));
    assert!(matches!(of(&["k"]).run(&States::new(2)), Err(Error::OutOfRange { .. })));
    assert!(matches!(of(&["k"]).run(&States::new(3)), Err(Error::Dimension { .. })));
    let mut spoilt = states.clone();
    spoilt.push(&[f64::NAN, 0.0]);
    assert!(matches!(of(&["k"]).run(&spoilt), Err(Error::OutOfRange { .. })));
    Ok(())
}

/// Columns are found by their names; what is missing or no number is an error that names it.
#[test]
fn tables_of_states_are_read() -> Result<()> {
    let path = std::env::temp_dir().join(format!("expoly-states-{}.csv", std::process::id()));
    let read = |text: &str| {
        std::fs::write(&path, text).unwrap();
        States::from_csv(&path, problem().states())
    };
    let states = read("t, v, x\n0, 1.5, -2\n0.1, 1e-3, 4\n")?;
    assert_eq!((&states[0], &states[1]), (&[-2.0, 1.5][..], &[4.0, 1e-3][..]));
    assert!(matches!(read("t,x\n0,1\n"), Err(Error::NotAName { name, .. }) if name == "v"));
    for text in ["x,v\n1,2\n1,nan\n", "x,v\n1,2\n1,two\n", "x,v\n1,2\n1\n"] {
        let error = read(text).unwrap_err();
        assert!(matches!(error, Error::File { .. }) && error.to_string().contains('3'), "{error}");
    }
    std::fs::remove_file(&path).unwrap();
    assert!(matches!(read_missing(), Err(Error::File { .. })));
    Ok(())
}

fn read_missing() -> Result<States> {
    States::from_csv("no such file", problem().states())
}
