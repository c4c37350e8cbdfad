//! What do the methods answer, by their defaults, on systems from public code?
//!
//! Each system of `tests/cases/` by the closure of orders 4 and 8, the grid in one and two states, and the simulation: the worst error of
//! its known moments, over the truth and over the error that is stated and that of the truth, the estimate, and the seconds. Some have no density, or are
//! outside of what the library serves: their rows are the refusals.

use crate::Outcome;
use clap::Args;
use expoly::{Closure, Density, Grid, Problem, Result, Simulation};
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};
use support::text::shown;

/// Systems from public code by every method.
#[derive(Clone, Debug, Args)]
pub(crate) struct Options {
    /// Only the systems whose names contain this
    #[arg(long, default_value = "")]
    only: String,
    /// Only the methods whose names contain this: closure 4, closure 8, grid, simulation
    #[arg(long, default_value = "")]
    method: String,
    /// Seconds after which a method has no answer
    #[arg(long, default_value_t = 120)]
    limit: u64,
}

macro_rules! case {
    ($name:literal) => {
        ($name, include_str!(concat!("../../../tests/cases/", $name, ".toml")))
    };
}

/// What is known: a system, a state, a power, the moment's value, and what that may be off by. By quadrature, closed forms and solutions on
/// finer grids; the bistable harvester's by a calibrated simulation, Lorenz's system's by 60 paths of Euler and Maruyama with steps of 1e-3
/// from starts of 1e-6, 1 and 10.
const KNOWN: &str = include_str!("../../../tests/cases/known.csv");

/// A moment that is known.
pub(crate) struct Known {
    state: &'static str,
    power: u32,
    value: f64,
    off: f64,
}

/// The moments of a system that are known.
pub(crate) fn known(system: &str) -> Vec<Known> {
    let row = |line: &'static str| {
        let [name, state, power, value, off] = line.split(',').collect::<Vec<_>>().try_into().ok()?;
        let known = Known { state, power: power.parse().ok()?, value: value.parse().ok()?, off: off.parse().ok()? };
        (name == system).then_some(known)
    };
    KNOWN.lines().filter_map(row).collect()
}

/// The systems and their texts.
pub(crate) const CASES: [(&str, &str); 26] = [
    case!("recharge"),
    case!("excitable"),
    case!("cycle-multiplicative"),
    case!("cycle-stiff"),
    case!("cycle-driven-displacement"),
    case!("wells-weak-noise"),
    case!("cubic-fat"),
    case!("cubic-ito"),
    case!("cubic-bimodal"),
    case!("harvester-bistable"),
    case!("harvester-linear"),
    case!("frame-of-two"),
    case!("wells-four-states"),
    case!("trap-si"),
    case!("two-oscillators-frozen"),
    case!("lorenz-multiplicative"),
    case!("undamped"),
    case!("outside-boucwen"),
    case!("outside-dry-friction"),
    case!("outside-periodic"),
    case!("outside-reflecting"),
    case!("outside-square-root"),
    case!("outside-stommel"),
    case!("outside-swing"),
    case!("outside-toggle"),
    case!("ten-wells"),
];

/// What a method says.
pub(crate) struct Said {
    /// Of the known moments the worst error, over the truth and over the stated error.
    pub(crate) off: Option<[f64; 2]>,
    pub(crate) estimate: Option<f64>,
    pub(crate) warning: Option<String>,
}

#[derive(Clone, Copy, Debug)]
pub(crate) enum Method {
    Closure(u32),
    Grid,
    Simulation,
}

const METHODS: [(&str, Method); 4] = [
    ("closure 4", Method::Closure(4)),
    ("closure 8", Method::Closure(8)),
    ("grid", Method::Grid),
    ("simulation", Method::Simulation),
];

#[allow(clippy::print_stdout, reason = "an example prints its answer")]
pub(crate) fn run(options: &Options) -> Outcome {
    println!(
        "{:>26} {:>10} {:>9} {:>8} {:>9} {:>7}  warning or refusal",
        "system", "method", "off", "of error", "estimate", "s"
    );
    for (system, text) in CASES.iter().filter(|(system, _)| system.contains(&options.only)) {
        let problem = match Problem::from_toml(text) {
            Ok(problem) => problem,
            Err(error) => {
                println!("{system:>26} {error}");
                continue;
            }
        };
        for (name, method) in METHODS.iter().filter(|(name, _)| name.contains(&options.method)) {
            if matches!(method, Method::Grid) && problem.dimension() > 3 {
                continue;
            }
            let begin = Instant::now();
            let said = within(options.limit, &problem, *method, known(system));
            let seconds = begin.elapsed().as_secs_f64();
            print!("{system:>26} {name:>10} ");
            match said {
                None => println!("{:>9} {:>8} {:>9} {seconds:>7.1}  no answer", "-", "-", "-"),
                Some(Err(error)) => println!("{:>9} {:>8} {:>9} {seconds:>7.1}  {error}", "-", "-", "-"),
                Some(Ok(Said { off, estimate, warning })) => println!(
                    "{:>9} {:>8} {:>9} {seconds:>7.1}  {}",
                    shown(off.map(|off| format!("{:.1e}", off[0]))),
                    shown(off.map(|off| format!("{:.1}", off[1]))),
                    shown(estimate.map(|estimate| format!("{estimate:.1e}"))),
                    warning.unwrap_or_default()
                ),
            }
        }
    }
    Ok(())
}

/// The answer of a method if it comes within some seconds; else its thread is left to itself.
fn within(seconds: u64, problem: &Problem, method: Method, known: Vec<Known>) -> Option<Result<Said>> {
    let (sender, receiver) = channel();
    let problem = problem.clone();
    std::thread::spawn(move || sender.send(said(&problem, method, &known)));
    receiver.recv_timeout(Duration::from_secs(seconds)).ok()
}

pub(crate) fn said(problem: &Problem, method: Method, known: &[Known]) -> Result<Said> {
    let powers: Vec<Vec<u32>> = known
        .iter()
        .map(|known| problem.states().iter().map(|state| if state == known.state { known.power } else { 0 }).collect())
        .collect();
    let answered = |density: &dyn Density, estimate: Option<f64>, warning: Option<String>| -> Result<Said> {
        let mut off: Option<[f64; 2]> = None;
        for (powers, Known { value: truth, off: open, .. }) in powers.iter().zip(known) {
            let moment = density.moment(powers)?;
            let apart = (moment.value - truth).abs();
            let [relative, stated] = off.unwrap_or_default();
            off = Some([relative.max(apart / truth.abs()), stated.max(apart / (moment.error + open))]);
        }
        Ok(Said { off, estimate, warning })
    };
    match method {
        Method::Closure(order) => {
            let density = Closure::new(order).solve(problem)?;
            answered(&density, Some(density.l1_estimate()), density.warning().map(str::to_owned))
        }
        Method::Grid => {
            let density = Grid::new().solve(problem)?;
            answered(&density, Some(density.l1_estimate()), density.provenance().warning.clone())
        }
        Method::Simulation => {
            let density = Simulation::new().samples(1_000_000).moments(&powers).run(problem)?;
            answered(&density, None, density.provenance().warning.clone())
        }
    }
}
