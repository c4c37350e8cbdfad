//! Does the grid resolve by itself what people bring, is its estimate right, and what does it cost?
//!
//! Plane systems from public code (`tests/cases/`) and some with a known answer, each at an accuracy: mesh and cost, and the estimate
//! against the distance from the solution of two degrees more and a tenth of the accuracy.

use crate::Outcome;
use clap::Args;
use expoly::{Density, Error, Grid, GridDensity, Problem, compare};
use std::time::Instant;
use support::text::shown;

/// The grid at stated accuracies, against finer solutions.
#[derive(Clone, Debug, Args)]
pub(crate) struct Options {
    /// Only the systems whose names contain this
    #[arg(long, default_value = "")]
    only: String,
    /// Leave out systems that take more than a few seconds
    #[arg(long)]
    quick: bool,
}

/// A system, the accuracy that is asked for, and moments that are known.
struct Case {
    name: &'static str,
    text: &'static str,
    accuracy: f64,
    /// Limits of the states, where they are not found.
    domain: Option<[[f64; 2]; 2]>,
    /// Whether a finer solution takes minutes.
    costly: bool,
    known: &'static [([u32; 2], f64)],
}

const DUFFING: &str = "states = ['x', 'v']\ndrift.x = 'v'\ndrift.v = '-0.5*v - x - 0.3*x^3'\nnoise.w.v = '1'";
const ABOVE: &str = "states = ['x', 'v']\ndrift.x = 'v'\ndrift.v = '-0.5*v - x'\nnoise.w.v = '1'\n\
    [[wall]]\nstate = 'x'\nabove = -0.5\nrestitution = 0.7";
const ELASTIC: &str = "states = ['x', 'v']\ndrift.x = 'v'\ndrift.v = '-0.5*v - x'\nnoise.w.v = '1'\n\
    [[wall]]\nstate = 'x'\nabove = -0.5\nrestitution = 1.0";
const CYCLE: &str = "states = ['x', 'v']\ndrift.x = 'v'\ndrift.v = '(1 - x^2)*v - x'\nnoise.w.v = 'sqrt(0.001)'";

macro_rules! case {
    ($name:literal) => {
        include_str!(concat!("../../../tests/cases/", $name, ".toml"))
    };
}

const SMOOTH: Case = Case {
    name: "Duffing",
    text: DUFFING,
    accuracy: 1e-5,
    domain: None,
    costly: false,
    known: &[([2, 0], 0.661_714_969_204)],
};

const STIFF: Case = Case {
    name: "cycle-stiff",
    text: case!("cycle-stiff"),
    accuracy: 1e-3,
    domain: None,
    costly: true,
    known: &[([2, 0], 2.409_646_599_39), ([0, 2], 2.409_646_599_39)],
};

const CASES: [Case; 13] = [
    SMOOTH,
    Case { accuracy: 1e-7, ..SMOOTH },
    Case { accuracy: 1e-8, ..SMOOTH },
    Case {
        name: "recharge",
        text: case!("recharge"),
        accuracy: 1e-5,
        domain: None,
        costly: false,
        known: &[([1, 0], -0.105_018_47), ([2, 0], 1.007_087_18), ([0, 2], 1.065_643_52)],
    },
    Case {
        name: "excitable",
        text: case!("excitable"),
        accuracy: 1e-5,
        domain: None,
        costly: false,
        known: &[([1, 0], 0.0), ([2, 0], 0.663_681_88), ([0, 2], 0.074_927_37)],
    },
    Case {
        name: "cycle-multiplicative",
        text: case!("cycle-multiplicative"),
        accuracy: 1e-5,
        domain: None,
        costly: false,
        known: &[([2, 0], 2.927_629_38), ([0, 2], 2.927_629_38)],
    },
    Case {
        name: "wells-weak-noise",
        text: case!("wells-weak-noise"),
        accuracy: 1e-5,
        domain: None,
        costly: false,
        known: &[([0, 2], 1.0 / 700.0), ([2, 0], 0.998_565_235)],
    },
    STIFF,
    Case { accuracy: 1e-5, ..STIFF },
    Case {
        name: "wall -0.5, r = 0.7",
        text: ABOVE,
        accuracy: 1e-5,
        domain: None,
        costly: false,
        known: &[([1, 0], 0.416_488_99), ([0, 2], 0.811_409_35)],
    },
    Case {
        name: "wall -0.5, r = 1",
        text: ELASTIC,
        accuracy: 1e-6,
        domain: None,
        costly: false,
        known: &[([1, 0], 0.509_160_43)],
    },
    Case {
        name: "van der Pol, D = 0.0005",
        text: CYCLE,
        accuracy: 1e-4,
        domain: None,
        costly: true,
        known: &[([2, 0], 2.059_602_5)],
    },
    // p ~ x⁻⁴ far out, on a ridge that narrows as x⁻³: moments are those of the domain.
    Case {
        name: "cycle-driven-displacement",
        text: case!("cycle-driven-displacement"),
        accuracy: 1e-2,
        domain: Some([[-9.5, 9.5], [-6.0, 6.0]]),
        costly: true,
        known: &[([0, 2], 0.091_343_97)],
    },
];

pub(crate) fn run(options: &Options) -> Outcome {
    println!(
        "{:>26} {:>8} {:>6} {:>8} {:>6} {:>9} {:>9} {:>6} {:>7} {:>7}",
        "", "accuracy", "cells", "unknowns", "rounds", "estimate", "distance", "ratio", "s", "pilot s"
    );
    let chosen = CASES.iter().filter(|case| case.name.contains(&options.only) && !(options.quick && case.costly));
    for case in chosen {
        let problem = Problem::from_toml(case.text)?;
        match solved(&problem, case, case.accuracy, None) {
            Ok((density, seconds)) => row(case, &problem, &density, seconds)?,
            Err(error) => println!("{:>26} {:>8e} {error}", case.name, case.accuracy),
        }
    }
    Ok(())
}

fn row(case: &Case, problem: &Problem, density: &GridDensity, seconds: f64) -> Outcome {
    let (made, estimate) = (density.provenance(), density.l1_estimate());
    let degree = made.degree.map(|degree| degree + 2);
    let (finer, _) = solved(problem, case, case.accuracy / 10.0, degree)?;
    let distance = compare::l1(density, &finer)?.value;
    let pilot = made.pilot_seconds.unwrap_or_default();
    println!(
        "{:>26} {:>8e} {:>6} {:>8} {:>6} {estimate:>9.1e} {distance:>9.1e} {:>6.1} {:>7.2} {pilot:>7.2}",
        case.name,
        case.accuracy,
        shown(made.cells),
        shown(made.unknowns),
        shown(made.iterations),
        estimate / distance,
        seconds - pilot,
    );
    for (powers, truth) in case.known {
        let moment = density.moment(powers)?;
        println!("{:>33} {powers:?} {:.11} off by {:.1e}", "E", moment.value, moment.value - truth);
    }
    if let Some(warning) = &made.warning {
        println!("{:>33} {warning}", "");
    }
    Ok(())
}

fn solved(problem: &Problem, case: &Case, accuracy: f64, degree: Option<usize>) -> Result<(GridDensity, f64), Error> {
    let begin = Instant::now();
    let mut grid = Grid::new().accuracy(accuracy);
    grid = degree.map_or(grid.clone(), |degree| grid.degree(degree));
    grid = case.domain.map_or(grid.clone(), |domain| grid.domain(domain));
    let density = grid.solve(problem)?;
    Ok((density, begin.elapsed().as_secs_f64()))
}
