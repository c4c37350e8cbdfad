//! How much energy do collisions carry from a driven mass to another, and what do they cost?
//!
//! Two masses on springs of their own hit each other: one with the mass 1 is driven by noise, D = 0.2, and another one with the
//! mass 0.5 by nothing but the collisions, y₁ ≤ y₂ + g. Answer, by `cargo run --release --example two_masses`: elastic
//! collisions carry half of the power to the other mass's damper, from 56 % where the springs press the masses on each other
//! (g = −0.5) to 16 % at g = 2.5. With r = 0.7 they carry 33 % and take 30 % themselves at g = −0.5, and 11 % and 5 % at
//! g = 2.5: seldom and fast collisions cost least for what they carry. The program simulates gaps and restitutions, prints where the
//! power goes, and writes a figure to `out/two_masses/`. A closure has the same powers, from its pilot's calibrated impacts, although
//! a quartic is far from this density.

#![allow(clippy::print_stdout, reason = "an example prints its answer")]

use clap::Parser;
use expoly::{Closure, Density, Estimate, PolynomialDrift, Problem, Scalar, Simulation, Wall, statistics::Impacts};
use std::path::PathBuf;
use support::figure::{Panel, Scale, Style, View, curve, error_bars, write_figure};

/// A driven mass that hits another one, at several restitutions and gaps.
#[derive(Clone, Debug, Parser)]
struct Options {
    /// Gaps between the masses at rest, separated by commas; below zero they press on each other
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true, default_value = "-0.5,0,0.5,1,1.5,2,2.5")]
    gaps: Vec<f64>,
    /// Restitutions, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "1,0.9,0.7,0.5")]
    restitutions: Vec<f64>,
    /// Samples of each simulation
    #[arg(long, default_value_t = 200_000)]
    samples: usize,
    /// Order of the closure that the first gap is solved by as well, with the last restitution; none for 0
    #[arg(long, default_value_t = 4)]
    order: u32,
    /// Folder for the figure and its numbers
    #[arg(long, default_value = "out/two_masses")]
    out: PathBuf,
}

/// y₁″ + 0.1 y₁′ + y₁ = ξ and m y₂″ + 0.1 y₂′ + k₂ y₂ = 0 between collisions; the states are y₁, y₂, y₁′, y₂′.
#[derive(Clone, Copy, Debug)]
struct TwoMasses;

/// D of the noise on the first mass, c of both dampers, m and k₂ of the second mass.
const INTENSITY: f64 = 0.2;
const DAMPING: [f64; 2] = [0.1, 0.1];
const MASS: f64 = 0.5;
const STIFFNESS: f64 = 1.0;

impl PolynomialDrift<4, 1> for TwoMasses {
    fn drift<S: Scalar>(&self, [y1, y2, v1, v2]: [S; 4]) -> [S; 4] {
        let driven = -(v1 * DAMPING[0]) - y1;
        let other = -(v2 * (DAMPING[1] / MASS)) - y2 * (STIFFNESS / MASS);
        [v1, v2, driven, other]
    }

    fn noise<S: Scalar>(&self, _: [S; 4]) -> [[S; 1]; 4] {
        let zero = S::from(0.0);
        [[zero], [zero], [S::from((2.0 * INTENSITY).sqrt())], [zero]]
    }

    fn names(&self) -> Vec<String> {
        ["y1", "y2", "v1", "v2"].map(str::to_owned).to_vec()
    }
}

/// The masses with the gap g between them at rest: y₁ ≤ y₂ + g.
fn problem(gap: f64, restitution: f64) -> expoly::Result<Problem> {
    Problem::of(TwoMasses)?.with_wall(Wall::below(gap, restitution)?.between([0, 1], [1.0, MASS])?)
}

/// Where the power of the noise goes, in parts of D, and how often the masses meet.
#[derive(Clone, Copy)]
struct Flow {
    /// The dampers of the driven mass and of the other one.
    dampers: [Estimate; 2],
    collisions: Estimate,
    rate: Estimate,
}

impl Flow {
    /// From a density by any method that serves walls between two bodies.
    fn of(density: &dyn Density, problem: &Problem) -> expoly::Result<Self> {
        let impacts = Impacts::new(density, problem)?;
        let squares = [density.moment(&[0, 0, 2, 0])?, density.moment(&[0, 0, 0, 2])?];
        let dampers = [0, 1].map(|k| squares[k].scaled(DAMPING[k] / INTENSITY));
        Ok(Flow { dampers, collisions: impacts.power().scaled(1.0 / INTENSITY), rate: impacts.rate() })
    }

    /// The shares of the two dampers and of the collisions, and the rate.
    fn parts(&self) -> [Estimate; 4] {
        [self.dampers[0], self.dampers[1], self.collisions, self.rate]
    }
}

fn run(options: &Options) -> Result<(), Box<dyn std::error::Error>> {
    let cell = |estimate: Estimate| format!("{:>20}", format!("{estimate:.4}"));
    let names = ["driven", "other", "collisions", "collisions per time", "balance of driven", "balance of other"];
    println!("{:>6}{:>6}{}", "r", "gap", names.map(|name| format!("{name:>20}")).concat());
    let mut lines = [const { Vec::new() }; 4];
    for (colour, &r) in options.restitutions.iter().enumerate() {
        let mut along: [Vec<[f64; 3]>; 4] = Default::default();
        for &gap in &options.gaps {
            let problem = problem(gap, r)?;
            let result = Simulation::new().samples(options.samples).seed(1).run(&problem)?;
            let flow = Flow::of(&result, &problem)?;
            let balance: String = result.energy_balance().into_iter().map(cell).collect();
            println!("{r:6}{gap:6}{}{balance}", flow.parts().map(cell).concat());
            for (points, part) in along.iter_mut().zip(flow.parts()) {
                points.push([gap, part.value, part.error]);
            }
        }
        for (lines, points) in lines.iter_mut().zip(&along) {
            lines.push(curve(&format!("r = {r}"), Style::Solid, colour, points));
            lines.push(error_bars(colour, points));
        }
    }
    if options.order > 0
        && let (Some(gap), Some(r)) = (options.gaps.first(), options.restitutions.last())
    {
        let problem = problem(*gap, *r)?;
        let density = Closure::new(options.order).solve(&problem)?;
        println!("By the closure of order {}, estimated L1 error {:.2}:", options.order, density.l1_estimate());
        println!("{r:6}{gap:6}{}", Flow::of(&density, &problem)?.parts().map(cell).concat());
    }
    let ordinates = [
        "share of the driven mass's damper",
        "share of the other mass's damper",
        "share of the collisions",
        "collisions per unit time [1/T]",
    ];
    let panel = |(lines, ordinate)| View::Curves(Panel::new(["gap g [L]", ordinate], Scale::Linear, lines));
    let views: Vec<View> = lines.into_iter().zip(ordinates).map(panel).collect();
    let caption = format!(
        "y₁″ + {} y₁′ + y₁ = ξ, D = {INTENSITY}, E[ξ(t)ξ(t+τ)] = 2D δ(τ); {MASS} y₂″ + {} y₂′ + {STIFFNESS} y₂ = 0; y₁ ≤ y₂ + g. Shares of \
         the noise's power; simulation, seed 1",
        DAMPING[0], DAMPING[1]
    );
    write_figure(&options.out.join("power.svg"), &caption, 2, &views)?;
    println!("figure: {}", options.out.join("power.svg").display());
    Ok(())
}

fn main() -> std::process::ExitCode {
    support::exit_code(run(&Options::parse()))
}
