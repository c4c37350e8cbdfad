//! How accurate is the grid in three states, and what does it take?
//!
//! An oscillator and a Duffing oscillator under filtered noise, the system of Lorenz with noise on each state, two wells under filtered
//! noise, and a harvester whose density is a thin sheet, flat or curved. The distance in L¹ is that from a Gaussian where the system is linear,
//! and otherwise from a grid of a third of the accuracy or less; moments are those of long simulations or by other grids.

use crate::Outcome;
use crate::draw::Draw;
use clap::Args;
use expoly::{Closure, Density, Grid, GridDensity, Problem, Simulation, compare};
use std::ops::ControlFlow;
use std::time::Instant;
use support::text::{aligned, short};

/// The grid in three states.
#[derive(Clone, Debug, Args)]
pub(crate) struct Options {
    /// Only the systems whose names contain this
    #[arg(long, default_value = "")]
    only: String,
    /// Accuracies in L¹, separated by commas; by default those of each system
    #[arg(long, value_delimiter = ',')]
    accuracies: Vec<f64>,
    /// Without the distance from a finer grid
    #[arg(long)]
    quick: bool,
    /// A line for each linear system
    #[arg(long)]
    progress: bool,
    /// So many random systems instead, against simulations, and the closure's estimate against its distance from the grid
    #[arg(long, default_value_t = 0)]
    random: usize,
    /// The first of them
    #[arg(long, default_value_t = 0)]
    first: usize,
    /// Samples of each simulation
    #[arg(long, default_value_t = 1_000_000)]
    samples: usize,
    /// The memory limit in GiB
    #[arg(long, default_value_t = 8.0)]
    memory: f64,
}

pub(crate) struct System {
    pub(crate) name: &'static str,
    text: &'static str,
    linear: bool,
    /// Accuracies, each with that of the grid for comparison.
    pub(crate) accuracies: &'static [[f64; 2]],
    /// E x², E v² and E y², about a middle, with an error.
    known: &'static [([u32; 3], f64, f64)],
}

pub(crate) const SYSTEMS: [System; 6] = [
    System {
        name: "linear, filtered noise",
        text: "states = ['x', 'v', 'y']\ndrift = { x = 'v', v = '-0.5*v - x + y', y = '-y' }\nnoise.w.y = '1'",
        linear: true,
        accuracies: &[[1e-2, 0.0], [1e-3, 0.0], [1e-4, 0.0]],
        known: &[([2, 0, 0], 0.6, 0.0), ([0, 0, 2], 0.5, 0.0)],
    },
    System {
        name: "Duffing, filtered noise",
        text: "states = ['x', 'v', 'y']\ndrift = { x = 'v', v = '-0.5*v - x - 0.3*x^3 + y', y = '-2*y' }\nnoise.w.y = '2'",
        linear: false,
        accuracies: &[[1e-2, 1e-3], [1e-3, 1e-4], [1e-4, 3e-5]],
        known: &[([2, 0, 0], 0.5448, 1e-4), ([0, 2, 0], 0.6189, 1e-4), ([0, 0, 2], 1.0, 0.0)],
    },
    System {
        name: "two wells, filtered noise",
        text: "states = ['x', 'v', 'y']\ndrift = { x = 'v', v = '-0.5*v + x - x^3 + y', y = '-2*y' }\nnoise.w.y = '0.7'",
        linear: false,
        accuracies: &[[1e-2, 1e-3], [1e-3, 1e-4]],
        known: &[([0, 0, 2], 0.1225, 0.0)],
    },
    System {
        name: "Lorenz, noise 4",
        text: "states = ['x', 'y', 'z']\ndrift = { x = '10*(y - x)', y = 'x*(28 - z) - y', z = 'x*y - 8*z/3' }\n\
               noise = { a.x = '4', b.y = '4', c.z = '4' }",
        linear: false,
        accuracies: &[[3e-2, 1e-2]],
        known: &[([2, 0, 0], 65.99, 0.02), ([0, 2, 0], 81.46, 0.02)],
    },
    System {
        name: "harvester, linear spring",
        text: include_str!("../../../tests/cases/harvester-linear.toml"),
        linear: true,
        accuracies: &[[1e-2, 0.0], [1e-3, 0.0]],
        known: &[([2, 0, 0], 0.952_155_4, 0.0), ([0, 0, 2], 0.473_709_1, 0.0)],
    },
    System {
        name: "harvester, two wells",
        text: include_str!("../../../tests/cases/harvester-bistable.toml"),
        linear: false,
        accuracies: &[[0.1, 0.0]],
        known: &[],
    },
];

impl System {
    /// The density to an accuracy, and its distance from the Gaussian, or from a grid of another accuracy if that is not 0.
    pub(crate) fn solved(
        &self,
        [accuracy, finer]: [f64; 2],
        grid: &dyn Fn(f64) -> Grid,
    ) -> expoly::Result<(GridDensity, Option<f64>)> {
        let problem = Problem::from_toml(self.text)?;
        let found = grid(accuracy).solve(&problem)?;
        let l1 = if self.linear {
            Some(compare::l1(&found, &Closure::classical(2).solve(&problem)?.density()?)?.value)
        } else if finer > 0.0 {
            Some(compare::l1(&found, &grid(finer).solve(&problem)?)?.value)
        } else {
            None
        };
        Ok((found, l1))
    }
}

/// A random system of one of five kinds: a Duffing oscillator under filtered noise; one with a state of the first order that takes energy
/// from it; noise on three states, correlated; two wells under filtered noise; and under filtered noise with white noise on the velocity
/// above a wall.
fn random(number: usize) -> String {
    let mut draw = Draw::new(48, number);
    let mut within = |low: f64, high: f64| draw.within(low, high);
    let [c, k, mu, a, d] = [within(0.3, 1.0), within(0.5, 2.0), within(0.0, 1.0), within(0.8, 3.0), within(0.2, 0.8)];
    let (b, r, share) = (within(-0.6, 0.3), within(0.75, 1.0), within(0.3, 1.0));
    let filter = format!("z = '-{a}*z'");
    let noise = format!("noise.w.z = '{a}*sqrt(2*{d})'");
    match number % 5 {
        0 => format!(
            "states = ['x', 'v', 'z']\ndrift = {{ x = 'v', v = '-{c}*v - {k}*x - {mu}*x^3 + z', {filter} }}\n{noise}"
        ),
        1 => format!(
            "states = ['x', 'v', 'z']\ndrift = {{ x = 'v', v = '-{c}*v - {k}*x - {mu}*x^3 - {share}*z', z = 'v - {a}*z' }}\n\
             noise.w.v = 'sqrt(2*{d})'"
        ),
        2 => format!(
            "states = ['x', 'y', 'z']\ndrift = {{ x = '-{c}*x + {k}*y - {mu}*x^3', y = '-{k}*x - {c}*y + {share}*z', \
             z = '-{a}*z - {share}*y' }}\nnoise = {{ p = {{ x = '{d}', y = '{share}' }}, q.y = '0.5', s.z = '{d}' }}"
        ),
        3 => format!(
            "states = ['x', 'v', 'z']\ndrift = {{ x = 'v', v = '-{c}*v + x - {k}*x^3 + z', {filter} }}\n{noise}"
        ),
        _ => format!(
            "states = ['x', 'v', 'z']\ndrift = {{ x = 'v', v = '-{c}*v - {k}*x - {mu}*x^3 + z', {filter} }}\n{noise}\n\
             noise.s.v = '{share}'\n[[wall]]\nstate = 'x'\nabove = {b}\nrestitution = {r}"
        ),
    }
}

/// Second moments by the grid against the simulation's, the closure's estimate against its distance from the grid.
fn random_systems(options: &Options) -> Outcome {
    let heads = [
        "number",
        "cells",
        "estimate",
        "s",
        "E x_i^2 off by",
        "in errors",
        "closure, n = 4: L1 to the grid",
        "estimate",
        "ratio",
    ];
    let mut rows = vec![heads.map(String::from).to_vec()];
    let accuracy = options.accuracies.first().copied().unwrap_or(1e-2);
    for number in options.first..options.first + options.random {
        let problem = Problem::from_toml(&random(number))?;
        let grid = match Grid::new().accuracy(accuracy).memory_limit(options.memory).solve(&problem) {
            Ok(grid) => grid,
            Err(error) => {
                println!("{number}: {error}");
                continue;
            }
        };
        let sampled = Simulation::new().samples(options.samples).seed(1).run(&problem)?;
        let (mut off, mut errors): (f64, f64) = (0.0, 0.0);
        for state in 0..3 {
            let powers: Vec<u32> = (0..3).map(|other| if other == state { 2 } else { 0 }).collect();
            let [ours, theirs] = [grid.moment(&powers)?, sampled.moment(&powers)?];
            let apart = (ours.value - theirs.value).abs();
            off = off.max(apart / theirs.value);
            // A moment that its own equation gives has an error of rounding.
            errors = errors.max(apart / (ours.error + theirs.error));
        }
        let closed = Closure::new(4).solve(&problem)?;
        let distance = compare::l1(&closed, &grid)?.value;
        rows.push(vec![
            number.to_string(),
            grid.provenance().cells.unwrap_or_default().to_string(),
            short(Some(grid.l1_estimate())),
            format!("{:.1}", grid.provenance().seconds),
            short(Some(off)),
            format!("{errors:.1}"),
            short(Some(distance)),
            short(Some(closed.l1_estimate())),
            format!("{:.1}", closed.l1_estimate() / distance),
        ]);
        println!("{}", aligned(&rows[rows.len() - 1..], 1).trim_end());
        if let Some(warning) = grid.warning() {
            println!("  {warning}");
        }
    }
    println!("\n{}", aligned(&rows, 1));
    Ok(())
}

pub(crate) fn run(options: &Options) -> Outcome {
    if options.random > 0 {
        return random_systems(options);
    }
    let heads = [
        "system",
        "accuracy",
        "degree",
        "cells",
        "unknowns",
        "systems",
        "estimate",
        "L1",
        "ratio",
        "worst moment",
        "s",
        "of the pilot",
    ];
    let mut rows = vec![heads.map(String::from).to_vec()];
    for system in SYSTEMS.iter().filter(|system| system.name.contains(&options.only)) {
        let own: Vec<[f64; 2]> = match &options.accuracies[..] {
            [] => system.accuracies.to_vec(),
            given => given.iter().map(|accuracy| [*accuracy, accuracy / 10.0]).collect(),
        };
        for [accuracy, finer] in own {
            let grid = |accuracy: f64| {
                let (begin, tells) = (Instant::now(), options.progress);
                Grid::new().accuracy(accuracy).memory_limit(options.memory).progress(move |at| {
                    if tells {
                        let estimate = at.estimate.map_or_else(String::new, |estimate| format!("{estimate:.1e}"));
                        let seconds = begin.elapsed().as_secs_f64();
                        println!(
                            "    {:6} cells, in the highest degree {:.1e}  {estimate}  {seconds:.1} s",
                            at.cells, at.indicator
                        );
                    }
                    ControlFlow::Continue(())
                })
            };
            let finer = if options.quick { 0.0 } else { finer };
            let (found, l1) = match system.solved([accuracy, finer], &grid) {
                Ok(found) => found,
                Err(error) => {
                    println!("{}, {accuracy}: {error}", system.name);
                    continue;
                }
            };
            rows.push(row(system, accuracy, &found, l1)?);
            println!("{}", aligned(&rows[rows.len() - 1..], 1).trim_end());
            if let Some(warning) = found.warning() {
                println!("  {warning}");
            }
        }
    }
    println!("\n{}", aligned(&rows, 1));
    Ok(())
}

fn row(system: &System, accuracy: f64, found: &GridDensity, l1: Option<f64>) -> expoly::Result<Vec<String>> {
    let made = found.provenance();
    let mut worst: f64 = 0.0;
    for (powers, truth, error) in system.known {
        let off = (found.moment(powers)?.value - truth).abs();
        worst = worst.max((off - error).max(0.0) / truth);
    }
    let count = |number: Option<usize>| number.map_or_else(String::new, |number| number.to_string());
    Ok(vec![
        system.name.to_owned(),
        short(Some(accuracy)),
        count(made.degree),
        count(made.cells),
        count(made.unknowns),
        count(made.iterations),
        short(made.l1_estimate),
        short(l1),
        l1.map_or_else(String::new, |l1| format!("{:.1}", found.l1_estimate() / l1)),
        short(Some(worst)),
        format!("{:.1}", made.seconds - made.pilot_seconds.unwrap_or(0.0)),
        format!("{:.1}", made.pilot_seconds.unwrap_or(0.0)),
    ])
}
