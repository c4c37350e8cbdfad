//! How much does an absorber with stops take from its structure, against the gap between the stops?
//!
//! A lightly damped structure, x″ + 0.04 x′ + x + s = ξ, D = 0.03, carries a tenth of its mass by a spring that is tuned to it and
//! hardly damped, between stops on the structure with r = 0.6. Answer, by `cargo run --release --example impact_absorber`: 38 % of the
//! noise's power at gaps between 1 and 1.4, where the absorber alone takes 21 % without stops; narrow gaps lock it to the
//! structure and are worse than none. The program simulates gaps from 0.1 to 3, prints what each of the two dampers and the
//! stops take, and writes a figure to `out/impact_absorber/`.

#![allow(clippy::print_stdout, reason = "an example prints its answer")]

use clap::Parser;
use expoly::models::{Duffing, ImpactAbsorber, TunedAbsorber};
use expoly::{Density, Estimate, Problem, Simulation, statistics::Impacts};
use std::path::PathBuf;
use support::figure::{Panel, Scale, Style, View, curve, error_bars, write_figure};

/// An absorber between stops, at several gaps.
#[derive(Clone, Debug, Parser)]
struct Options {
    /// Gaps to each side, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "0.1,0.2,0.3,0.5,0.7,1,1.4,2,3")]
    gaps: Vec<f64>,
    /// Restitution of the stops
    #[arg(long, default_value_t = 0.6)]
    restitution: f64,
    /// Samples of each simulation
    #[arg(long, default_value_t = 400_000)]
    samples: usize,
    /// Folder for the figure and its numbers
    #[arg(long, default_value = "out/impact_absorber")]
    out: PathBuf,
}

/// c and D of the structure; m, κ and γ of the absorber.
const DAMPING: f64 = 0.04;
const INTENSITY: f64 = 0.03;
const ABSORBER: [f64; 3] = [0.1, 0.09, 0.001];

fn run(options: &Options) -> Result<(), Box<dyn std::error::Error>> {
    let structure = Duffing::new(DAMPING, 1.0, 0.0, INTENSITY)?;
    let simulated = |problem: &Problem| Simulation::new().samples(options.samples).seed(1).run(problem);
    let share = |power: Estimate| power.scaled(1.0 / INTENSITY);
    let [mass, stiffness, damping] = ABSORBER;
    let free = TunedAbsorber::new(structure, mass, stiffness, damping)?;
    let without = simulated(&free.problem()?)?;
    let names = ["gap", "E x^2", "structure", "damper", "stops", "impacts per time"];
    println!("{}", names.map(|name| format!("{name:>20}")).concat());
    let cell = |estimate: Estimate| format!("{:>20}", format!("{estimate:.4}"));
    let own = |density: &dyn Density| Ok::<_, expoly::Error>(share(density.moment(&[0, 0, 2, 0])?.scaled(DAMPING)));
    let mut rows: Vec<(f64, [Estimate; 5])> = Vec::new();
    for &gap in &options.gaps {
        let absorber = ImpactAbsorber::new(structure, ABSORBER, gap, options.restitution)?;
        let problem = absorber.problem()?;
        let result = simulated(&problem)?;
        let stops = Impacts::new(&result, &problem)?;
        let taken = [own(&result)?, share(absorber.damped_power(&result)?), share(stops.power())];
        let row = [result.moment(&[2, 0, 0, 0])?, taken[0], taken[1], taken[2], stops.rate()];
        println!("{gap:20}{}", row.map(cell).concat());
        rows.push((gap, row));
    }
    let row = [without.moment(&[2, 0, 0, 0])?, own(&without)?, share(free.absorbed_power(&without)?)];
    println!("{:>20}{}", "none", row.map(cell).concat());

    let along =
        |k: usize| -> Vec<[f64; 3]> { rows.iter().map(|(gap, row)| [*gap, row[k].value, row[k].error]).collect() };
    let lines = |list: &[(usize, &str)]| {
        let both = |(colour, &(k, name)): (usize, &(usize, &str))| {
            [curve(name, Style::Solid, colour, &along(k)), error_bars(colour, &along(k))]
        };
        list.iter().enumerate().flat_map(both).collect::<Vec<_>>()
    };
    let gap = "gap g to each side [L]";
    let views = [
        Panel::new(
            [gap, "share of the noise's power"],
            Scale::Linear,
            lines(&[(1, "the structure's damper"), (2, "the absorber's damper"), (3, "the stops")]),
        ),
        Panel::new([gap, "mean square of the structure's displacement [L²]"], Scale::Linear, lines(&[(0, "")])),
        Panel::new([gap, "impacts per unit time [1/T]"], Scale::Linear, lines(&[(4, "")])),
    ];
    let caption = format!(
        "x″ + {DAMPING} x′ + x + s = ξ, {mass} y″ = s = {stiffness} (x − y) + {damping} (x′ − y′), |y − x| ≤ g, r = {}, D = {INTENSITY}, \
         E[ξ(t)ξ(t+τ)] = 2D δ(τ); simulation, seed 1",
        options.restitution
    );
    write_figure(&options.out.join("power.svg"), &caption, 3, &views.map(View::Curves))?;
    println!("figure: {}", options.out.join("power.svg").display());
    Ok(())
}

fn main() -> std::process::ExitCode {
    support::exit_code(run(&Options::parse()))
}
