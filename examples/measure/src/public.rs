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
use support::shown;

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

/// A state, a power, the moment's value, and what that may be off by.
type Known = (&'static str, u32, f64, f64);

/// A system, and moments that are known.
struct Case {
    name: &'static str,
    text: &'static str,
    known: &'static [Known],
}

macro_rules! case {
    ($name:literal, $known:expr) => {
        Case { name: $name, text: include_str!(concat!("../../../tests/cases/", $name, ".toml")), known: &$known }
    };
}

/// By quadrature, closed forms and solutions on finer grids; the bistable harvester's by a calibrated simulation.
const CASES: [Case; 26] = [
    case!("recharge", [("T", 1, -0.105_018_47, 5e-9), ("T", 2, 1.007_087_18, 5e-9), ("h", 2, 1.065_643_52, 5e-9)]),
    case!("excitable", [("x", 2, 0.663_681_88, 5e-9), ("y", 2, 0.074_927_37, 5e-9)]),
    case!("cycle-multiplicative", [("x", 2, 2.927_629_38, 5e-9), ("v", 2, 2.927_629_38, 5e-9)]),
    case!("cycle-stiff", [("x", 2, 2.409_646_6, 5e-8), ("y", 2, 2.409_646_6, 5e-8)]),
    case!("cycle-driven-displacement", [("v", 2, 0.091_08, 6e-5)]),
    case!("wells-weak-noise", [("x", 2, 0.998_565_235, 5e-10), ("v", 2, 1.0 / 700.0, 1e-15)]),
    case!("cubic-fat", [("x", 1, -0.103_408_47, 5e-9), ("x", 2, 0.230_283_06, 5e-9), ("x", 4, 0.206_371_28, 5e-9)]),
    case!("cubic-ito", [("x", 2, 0.715_377_74, 5e-9), ("x", 4, 1.715_377_74, 5e-9)]),
    case!("cubic-bimodal", [("x", 1, 1.475_905_80, 5e-9), ("x", 2, 6.105_473_29, 5e-9)]),
    case!("harvester-bistable", [("v", 2, 97.159, 1e-3), ("x", 2, 0.4915, 4e-4), ("y", 2, 0.2841, 1e-4)]),
    case!("harvester-linear", [("v", 2, 95.263, 5e-4), ("x", 2, 0.952_16, 5e-6), ("y", 2, 0.473_71, 5e-6)]),
    case!("frame-of-two", [("u", 2, 0.539_11, 5e-6), ("v", 2, 0.587_38, 5e-6), ("x", 2, 0.786_89, 5e-6)]),
    case!(
        "wells-four-states",
        [("x1", 2, 0.889_294_016, 5e-10), ("x1", 4, 0.972_627_349, 5e-10), ("x2", 2, 5.0 / 9.0, 1e-15)]
    ),
    // k_B T over G² k, and over m G².
    case!("trap-si", [("x", 2, 4.315976358e-12, 5e-22), ("v", 2, 4.259697925e-01, 5e-11)]),
    case!("two-oscillators-frozen", []),
    // By 60 paths of Euler and Maruyama with steps of 1e-3, from starts of 1e-6, 1 and 10.
    case!("lorenz-multiplicative", [("x", 2, 34.4, 0.3)]),
    case!("undamped", []),
    case!("outside-boucwen", []),
    case!("outside-dry-friction", []),
    case!("outside-periodic", []),
    case!("outside-reflecting", []),
    case!("outside-square-root", []),
    case!("outside-stommel", []),
    case!("outside-swing", []),
    case!("outside-toggle", []),
    case!("ten-wells", [("x1", 2, 0.889_294_016, 5e-10), ("x2", 2, 5.0 / 9.0, 1e-15)]),
];

/// What a method says.
struct Said {
    /// Of the known moments the worst error, over the truth and over the stated error.
    off: Option<[f64; 2]>,
    estimate: Option<f64>,
    warning: Option<String>,
}

#[derive(Clone, Copy, Debug)]
enum Method {
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
    for case in CASES.iter().filter(|case| case.name.contains(&options.only)) {
        let problem = match Problem::from_toml(case.text) {
            Ok(problem) => problem,
            Err(error) => {
                println!("{:>26} {error}", case.name);
                continue;
            }
        };
        for (name, method) in METHODS.iter().filter(|(name, _)| name.contains(&options.method)) {
            if matches!(method, Method::Grid) && problem.dimension() > 2 {
                continue;
            }
            let begin = Instant::now();
            let said = within(options.limit, &problem, *method, case.known);
            let seconds = begin.elapsed().as_secs_f64();
            print!("{:>26} {name:>10} ", case.name);
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
fn within(seconds: u64, problem: &Problem, method: Method, known: &'static [Known]) -> Option<Result<Said>> {
    let (sender, receiver) = channel();
    let problem = problem.clone();
    std::thread::spawn(move || sender.send(said(&problem, method, known)));
    receiver.recv_timeout(Duration::from_secs(seconds)).ok()
}

fn said(problem: &Problem, method: Method, known: &[Known]) -> Result<Said> {
    let powers: Vec<Vec<u32>> = known
        .iter()
        .map(|(name, power, ..)| problem.states().iter().map(|state| if state == name { *power } else { 0 }).collect())
        .collect();
    let answered = |density: &dyn Density, estimate: Option<f64>, warning: Option<String>| -> Result<Said> {
        let mut off: Option<[f64; 2]> = None;
        for (powers, (_, _, truth, open)) in powers.iter().zip(known) {
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
