//! Does the closure give a density for every system, and is its estimate of the error right?
//!
//! Answer: of the 499 among 500 random oscillators whose wells the grid finds to exchange, all had one at n = 4 and 8, and every
//! density without a warning was within three times its estimate, or 1e-4, of the grid's; so were those above 150 random walls. The
//! estimate was 0.8 to 3 times the distance, or below 1e-4, for all but one.
//!
//! 500 random oscillators are closed at several orders, and each density is compared with the solution of the Fokker-Planck
//! equation on a grid; `--walls` does the same above 150 random walls, `--lattice` above 40 walls in order, where the
//! literature's closure stands beside it, `--exact` for systems of three to six states whose density is known, and `--known` for
//! wells and linear systems, which have a density of order two or four. `--grid` compares the grid on the 500 with finer
//! solutions. The tables go to `out/campaign/`, after each system: a campaign that was
//! interrupted goes on from its table. `--part 2/16` closes a sixteenth of the systems, as the tasks of an array job do, each with a
//! folder of its own: the tables one behind another are the whole one. The seed and its index determine a system: `--only 17`
//! repeats one.
//! Tables of seed 1 are kept in `examples/measure/tables/`, with seconds that were measured beside other work.

mod exact;
mod grid;
mod known;
mod plane;
mod runner;
pub(crate) mod statistics;
mod systems;
pub(crate) mod walls;

use crate::Outcome;
use clap::Args;
use runner::Campaign;
use std::path::PathBuf;
use support::dealt::Dealt;

/// The closure on random systems, against the grid.
#[derive(Clone, Debug, Args)]
pub(crate) struct Options {
    /// How many systems [default: 500, with --walls 150, with --lattice all 40, with --exact 60, with --few 100, with --known 300]
    #[arg(long)]
    count: Option<usize>,
    /// Seed of the systems' parameters
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Orders, separated by commas [default: 4,8, with --walls alone 8]
    #[arg(long, value_delimiter = ',')]
    orders: Vec<u32>,
    /// Random walls instead of the whole plane
    #[arg(long)]
    walls: bool,
    /// Walls on a lattice of offsets, restitutions and cubic stiffnesses (c = 0.2, k = 1, D = 0.2)
    #[arg(long)]
    lattice: bool,
    /// The grid on the random oscillators, against finer solutions [default degree, as --orders: 8]
    #[arg(long)]
    grid: bool,
    /// Random systems of three to six states whose density is known [default orders: 2,4]
    #[arg(long)]
    exact: bool,
    /// Random wells, linear systems and wells beside linear states, whose density is exp of a polynomial [default order: 4]
    #[arg(long)]
    known: bool,
    /// With --exact, systems of three and four states alone
    #[arg(long, requires = "exact")]
    few: bool,
    /// The system of this index alone
    #[arg(long)]
    only: Option<usize>,
    #[command(flatten)]
    dealt: Dealt,
    /// Folder for the table
    #[arg(long, default_value = "out/campaign")]
    out: PathBuf,
}

impl Options {
    fn indices(&self, usual: usize) -> std::ops::Range<usize> {
        self.only.map_or(0..self.count.unwrap_or(usual), |only| only..only + 1)
    }

    /// The campaign with the table of this name, of so many systems by default.
    fn campaign(&self, table: &str, usual: usize, orders: &[u32]) -> Campaign {
        let (path, indices) = (self.out.join(table), self.indices(usual));
        Campaign { path, seed: self.seed, indices, orders: orders.to_vec(), dealt: self.dealt }
    }

    fn orders(&self, usual: &[u32]) -> Vec<u32> {
        if self.orders.is_empty() { usual.to_vec() } else { self.orders.clone() }
    }
}

pub(crate) fn run(options: &Options) -> Outcome {
    match () {
        () if options.exact => exact::run(options),
        () if options.grid => grid::run(options),
        () if options.known => known::run(options),
        () if options.walls || options.lattice => walls::run(options),
        () => plane::run(options),
    }
}
