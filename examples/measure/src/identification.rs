//! How often do intervals of identified parameters hold the true ones?
//!
//! k, μ, c and e of x″ + c x′ + e x² x′ + 0.1 x′³ + k x + μ x³ = ξ, D = 0.3 known, from states 20 apart and from one record of states
//! 0.5 apart; each repetition is a trajectory of its own. The search starts 15 to 33 % off.

use crate::Outcome;
use clap::Args;
use expoly::inverse::{Identification, Identified};
use expoly::{Closure, Problem, Result, Simulation, States};

/// Coverage of intervals of identified parameters.
#[derive(Clone, Debug, Args)]
pub(crate) struct Options {
    /// Order of the closure
    #[arg(long, default_value_t = 6)]
    order: u32,
    /// How many records of either kind
    #[arg(long, default_value_t = 100)]
    repetitions: usize,
    /// Seed of the records
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

const SYSTEM: &str = r#"
states = ["x", "v"]
[parameters]
k = 1
mu = 0.3
c = 0.2
e = 0.3
D = 0.3
[drift]
x = "v"
v = "-c*v - e*x^2*v - 0.1*v^3 - k*x - mu*x^3"
[noise.w]
v = "sqrt(2*D)"
"#;
/// The names with where the search starts.
const UNKNOWN: [(&str, f64); 4] = [("k", 1.15), ("mu", 0.4), ("c", 0.25), ("e", 0.22)];
/// A name, the time between states, and their number.
const RECORDS: [(&str, f64, usize); 2] = [("states 20 apart", 20.0, 2000), ("states 0.5 apart", 0.5, 8000)];

pub(crate) fn run(options: &Options) -> Outcome {
    let problem = Problem::from_toml(SYSTEM)?;
    let start = UNKNOWN.iter().try_fold(problem.clone(), |start, (name, value)| start.with_parameter(name, *value))?;
    let names = UNKNOWN.map(|(name, _)| name);
    for (kind, interval, count) in RECORDS {
        let trajectories = options.repetitions.max(2);
        let simulation = Simulation::new().trajectories(trajectories).samples(trajectories * count);
        let all = simulation.sampling_interval(interval).seed(options.seed).states(&problem)?;
        let identified = |k: usize| {
            let mut states = States::new(2);
            all.iter().skip(k * count).take(count).for_each(|x| states.push(x));
            Identification::new(&start, &names).closure(Closure::new(options.order)).run(&states)
        };
        let found: Vec<Result<Identified>> = (0..options.repetitions).map(identified).collect();
        let failed: Vec<String> =
            found.iter().filter_map(|found| found.as_ref().err()).map(ToString::to_string).collect();
        let found: Vec<&Identified> = found.iter().flatten().collect();
        let converged = found.iter().filter(|found| found.converged()).count();
        let solves = found.iter().map(|found| found.solves() as f64).sum::<f64>() / found.len() as f64;
        println!(
            "{kind}, {count} of each of {} records: {converged} converged, {} failed, {solves:.1} solutions",
            options.repetitions,
            failed.len()
        );
        failed.iter().take(3).for_each(|error| println!("  {error}"));
        for (j, name) in names.iter().enumerate() {
            let truth = problem.parameters().iter().find(|(other, _)| other == name).map_or(0.0, |(_, value)| *value);
            let off: Vec<f64> = found.iter().map(|found| found.parameters()[j].1.value - truth).collect();
            let mean = off.iter().sum::<f64>() / off.len() as f64;
            let spread = (off.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (off.len() as f64 - 1.0)).sqrt();
            let held = found.iter().filter(|found| {
                let [low, high] = found.intervals()[j].1;
                (low..=high).contains(&truth)
            });
            let by_fisher = |found: &&&Identified| found.fisher_covariance()[(j, j)].sqrt();
            let naive = found.iter().zip(&off).filter(|(found, off)| off.abs() <= 1.96 * by_fisher(found)).count();
            let mean_of =
                |of: &dyn Fn(&&&Identified) -> f64| found.iter().map(|one| of(&one)).sum::<f64>() / found.len() as f64;
            println!(
                "  {name:2}: bias {mean:+.4} ± {:.4}, spread {spread:.4}, sandwich {:.4}, Fisher {:.4}; 95 % intervals hold {} and {naive} times",
                spread / (off.len() as f64).sqrt(),
                mean_of(&|one| one.parameters()[j].1.error),
                mean_of(&by_fisher),
                held.count(),
            );
        }
    }
    Ok(())
}
