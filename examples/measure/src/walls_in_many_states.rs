//! The closure above lossy walls in three and four states, against long simulations.
//!
//! - `first`: two masses, y″ + 0.2 y′ + y + 0.3 y³ + 0.5 (y − Y) = ξ and Y″ + 0.1 Y′ + 0.5 Y + 0.2 Y³ + 0.5 (Y − y) = 0, D = 0.3,
//!   with a wall below the first;
//! - `between`: the same two against each other, y − Y ≥ b;
//! - `filtered`: y″ + 0.2 y′ + y + 0.3 y³ = z + ξ₀ above a wall, z′ = 2 (ξ − z), D = 0.3, D₀ = 0.05.
//!
//! For each statistic the deviation from the simulation in percent, with its standard error and the simulation's in brackets.
//! The impact rate has both the answer, by the pilot's calibrated impacts, and the density's own. The L¹ distance of the joint
//! density of y and y′, for the first seed, is one over 20 × 20 cells; the simulation's states alone make 2e-3 of it.

use crate::Outcome;
use crate::cells::Cells;
use clap::{Args, ValueEnum};
use expoly::models::{ColouredVibroImpact, Duffing};
use expoly::statistics::Impacts;
use expoly::{Closure, Crossing, Density, Estimate, Problem, Result, SimulatedDensity, Simulation, Wall};
use std::time::Instant;

/// The closure above lossy walls in three and four states.
#[derive(Clone, Debug, Args)]
pub(crate) struct Options {
    /// Systems, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "first,between,filtered")]
    systems: Vec<System>,
    /// A single wall, as in `--wall -0.3,0.8` for an offset and a restitution
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true)]
    wall: Vec<f64>,
    /// Orders, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "6")]
    orders: Vec<u32>,
    /// How many seeds
    #[arg(long, default_value_t = 3)]
    seeds: u64,
    /// Samples of each simulation
    #[arg(long, default_value_t = 3_000_000)]
    samples: usize,
    /// Millions of states for the joint density of y and y′; none leaves it out
    #[arg(long, default_value_t = 12)]
    states: u64,
    /// States of the closure's pilot; its own number by default
    #[arg(long)]
    pilot: Option<usize>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum System {
    First,
    Between,
    Filtered,
}

const TWO_MASSES: &str = r#"
states = ["y", "v", "Y", "V"]
[drift]
y = "v"
v = "-0.2*v - y - 0.3*y^3 - 0.5*(y - Y)"
Y = "V"
V = "-0.1*V - 0.5*Y - 0.2*Y^3 + 0.5*(y - Y)"
[noise.w]
v = "sqrt(0.6)"
"#;

/// The moments by the powers of y, v and, in four states, Y and V.
const MOMENTS: [(&str, [u32; 4]); 7] = [
    ("E y", [1, 0, 0, 0]),
    ("E y2", [2, 0, 0, 0]),
    ("E v2", [0, 2, 0, 0]),
    ("E v4", [0, 4, 0, 0]),
    ("E yY", [1, 0, 1, 0]),
    ("E Y2", [0, 0, 2, 0]),
    ("E V2", [0, 0, 0, 2]),
];
/// Cells along y and along y′.
const CELLS: usize = 20;

impl System {
    fn walls(self) -> Vec<[f64; 2]> {
        match self {
            System::First => vec![[-0.3, 0.8], [-0.3, 0.6], [0.3, 0.8], [0.3, 0.6]],
            System::Between => vec![[-0.5, 0.8]],
            System::Filtered => [0.5, 0.0, -0.5].iter().flat_map(|b| [0.95, 0.8, 0.6].map(|r| [*b, r])).collect(),
        }
    }

    fn problem(self, [offset, restitution]: [f64; 2]) -> Result<Problem> {
        let wall = Wall::above(offset, restitution)?;
        match self {
            System::First => Problem::from_toml(TWO_MASSES)?.with_wall(wall),
            System::Between => Problem::from_toml(TWO_MASSES)?.with_wall(wall.between([0, 2], [1.0, 1.0])?),
            System::Filtered => {
                let duffing = Duffing::new(0.2, 1.0, 0.3, 0.3)?;
                ColouredVibroImpact::new(duffing, 2.0, 0.05, [offset, restitution])?.problem()
            }
        }
    }
}

/// A list of moments that the system has.
fn moments(states: usize) -> impl Iterator<Item = (&'static str, &'static [u32])> {
    let own = move |powers: &[u32; 4]| powers[states..].iter().all(|power| *power == 0);
    MOMENTS.iter().filter(move |(_, powers)| own(powers)).map(move |(name, powers)| (*name, &powers[..states]))
}

fn beside(name: &str, found: Estimate, truth: Estimate) -> String {
    let percent = |x: f64| 100.0 * x / truth.value.abs();
    let [off, own, its] = [found.value - truth.value, found.error, truth.error].map(percent);
    format!(" {name} {off:+.2} ({own:.2}, {its:.2})")
}

fn line(problem: &Problem, truth: &SimulatedDensity, cells: Option<&Cells>, closure: &Closure) -> Outcome {
    let begin = Instant::now();
    let density = match closure.solve(problem) {
        Ok(density) => density,
        Err(error) => {
            println!("    {error}");
            return Ok(());
        }
    };
    let seconds = begin.elapsed().as_secs_f64();
    let mut text = String::new();
    for (name, powers) in moments(problem.dimension()) {
        text += &beside(name, density.moment(powers)?, truth.moment(powers)?);
    }
    let [found, counted] = [Impacts::new(&density, problem)?, Impacts::new(truth, problem)?];
    text += &beside("rate", found.rate(), counted.rate());
    text += &beside("speed", found.mean_speed(), counted.mean_speed());
    text += &beside("power", found.power(), counted.power());
    if let [wall] = problem.walls()
        && wall.other().is_none()
    {
        let own = density.flux(Crossing::downward(wall.offset()), 1)?;
        text += &format!(" own rate {:+.2}", 100.0 * (own.value / counted.rate().value - 1.0));
    }
    if let Some(cells) = cells {
        text += &format!(" L1(y, v) {:.1e}", cells.distance(&density)?);
    }
    let warning = density.warning().map_or("", |_| ", warned");
    println!("   {text} estimate {:.1e}{warning}, {seconds:.1} s", density.l1_estimate());
    Ok(())
}

pub(crate) fn run(options: &Options) -> Outcome {
    for &system in &options.systems {
        let walls = match options.wall[..] {
            [offset, restitution] => vec![[offset, restitution]],
            _ => system.walls(),
        };
        for wall in walls {
            let problem = system.problem(wall)?;
            let truth = Simulation::new().samples(options.samples).time_step(0.005).seed(99).run(&problem)?;
            let cells = (options.states > 0).then(|| Cells::new(&problem, CELLS, 0.01, options.states)).transpose()?;
            for &order in &options.orders {
                println!("{system:?}, b = {}, r = {}, n = {order}; deviations in percent:", wall[0], wall[1]);
                for seed in 0..options.seeds {
                    let closure = Closure::new(order).seed(seed);
                    let closure = options.pilot.into_iter().fold(closure, Closure::pilot_states);
                    // The distance takes longer than the closure.
                    line(&problem, &truth, cells.as_ref().filter(|_| seed == 0), &closure)?;
                }
            }
        }
    }
    Ok(())
}
