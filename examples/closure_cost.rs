//! What does a closure cost?
//!
//! `cargo run --release --example closure_cost` times the closure, pilot included, over its order, over the number of nodes
//! and over the number of states, prints the tables, and draws them; figure and CSV go to `out/closure_cost/`.

#![allow(clippy::print_stdout)]

#[path = "support/mod.rs"]
mod support;

use clap::Parser;
use expoly::models::{CubicDamping, Duffing};
use expoly::{Barrier, Closure, ClosureDensity};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;
use support::chain::Chain;
use support::figure::{Curve, Panel, Scale, Style, View, write_figure};
use support::file::write_csv;

/// The cost of a closure over its order, its nodes and its states.
#[derive(Clone, Debug, Parser)]
struct Options {
    /// Highest order in two states; walls end at 10, chains at 6
    #[arg(long, default_value_t = 16)]
    highest: u32,
    /// Longest chain of oscillators, up to 5
    #[arg(long, default_value_t = 5)]
    longest: usize,
    /// How often each closure is timed; the least time counts
    #[arg(long, default_value_t = 3)]
    repeats: usize,
    /// Folder for the figure and the table
    #[arg(long, default_value = "out/closure_cost")]
    out: PathBuf,
}

/// One closure: order, states, nodes, unknowns, seconds.
type Row = [f64; 5];

fn main() -> ExitCode {
    support::exit_code(run(&Options::parse()))
}

fn run(options: &Options) -> Result<(), Box<dyn std::error::Error>> {
    println!("{:>22} {:>6} {:>7} {:>9} {:>9} {:>9}", "", "order", "states", "nodes", "unknowns", "seconds");
    let (plane, duffing) = (CubicDamping::new([0.1, 0.3], 1.0, 1.0, 0.5)?, Duffing::new(0.2, 1.0, 0.3, 0.2)?);
    let wall = Barrier::new(-0.5, 0.95)?;
    let short = Chain::<2>::new()?;
    let at = |order: u32| Closure::new(order);
    let orders = |highest: u32| (2..=highest.min(options.highest)).step_by(2);
    let timed = |name, closed: &dyn Fn() -> expoly::Result<[f64; 4]>| timed(options.repeats, name, closed);

    let in_plane = orders(16).map(|n| timed("two states", &|| facts(at(n).solve(&plane)?)));
    let in_plane = in_plane.collect::<expoly::Result<Vec<Row>>>()?;
    let above_wall = orders(10).map(|n| timed("a wall", &|| facts(at(n).solve_with_wall(&duffing, wall)?)));
    let above_wall = above_wall.collect::<expoly::Result<Vec<Row>>>()?;
    let in_chain = orders(6).map(|n| timed("two oscillators", &|| facts::<4>(at(n).solve(&short)?)));
    let in_chain = in_chain.collect::<expoly::Result<Vec<Row>>>()?;

    let states = [25_000, 50_000, 100_000, 200_000].into_iter();
    let with_nodes =
        states.map(|count| timed("two oscillators", &|| facts::<4>(at(4).pilot_states(count).solve(&short)?)));
    let with_nodes = with_nodes.collect::<expoly::Result<Vec<Row>>>()?;

    let mut of_chains = Vec::new();
    for oscillators in 2..=options.longest.min(5) {
        of_chains.push(match oscillators {
            2 => timed("two oscillators", &|| facts::<4>(at(4).solve(&short)?)),
            3 => timed("three oscillators", &|| facts::<6>(at(4).solve(&Chain::<3>::new()?)?)),
            4 => timed("four oscillators", &|| facts::<8>(at(4).solve(&Chain::<4>::new()?)?)),
            _ => timed("five oscillators", &|| facts::<10>(at(4).solve(&Chain::<5>::new()?)?)),
        }?);
    }

    let rows: Vec<Vec<f64>> = [&in_plane, &above_wall, &in_chain, &with_nodes, &of_chains]
        .iter()
        .flat_map(|rows| rows.iter())
        .map(|row| row.to_vec())
        .collect();
    let columns = ["order", "states", "nodes", "unknowns", "seconds"].map(String::from);
    write_csv(&options.out.join("cost.csv"), &columns, &rows)?;
    let views = [
        panel("order n", [("two states", &in_plane), ("a wall", &above_wall), ("four states", &in_chain)], |row| {
            row[0]
        }),
        panel("nodes / 1000, four states, n = 4", [("", &with_nodes)], |row| row[2] / 1000.0),
        panel("states, n = 4", [("", &of_chains)], |row| row[1]),
    ];
    let caption = format!(
        "Time from the system to the density, pilot included, the least of {}; two states: cubic damping; a wall: b = −0.5, \
         r = 0.95; four states and more: chains of oscillators, the pilot's states as nodes. {} threads; seed 0.",
        options.repeats,
        std::thread::available_parallelism()?
    );
    let path = options.out.join("cost.svg");
    write_figure(&path, &caption, 3, &views)?;
    println!("figure: {}", path.display());
    Ok(())
}

/// States, nodes, unknowns and the order of a density.
fn facts<const N: usize>(density: ClosureDensity<N>) -> expoly::Result<[f64; 4]> {
    let provenance = density.provenance();
    Ok([f64::from(provenance.order), N as f64, provenance.nodes as f64, provenance.unknowns as f64])
}

/// The least time of several, with what stays the same in all.
fn timed(repeats: usize, name: &str, closed: &dyn Fn() -> expoly::Result<[f64; 4]>) -> expoly::Result<Row> {
    let mut least = f64::INFINITY;
    let mut facts = [0.0; 4];
    for _ in 0..repeats.max(1) {
        let begin = Instant::now();
        facts = closed()?;
        least = least.min(begin.elapsed().as_secs_f64());
    }
    let [order, states, nodes, unknowns] = facts;
    println!("{name:>22} {order:>6} {states:>7} {nodes:>9} {unknowns:>9} {least:>9.3}");
    Ok([order, states, nodes, unknowns, least])
}

fn panel<const K: usize>(x_label: &str, lines: [(&str, &Vec<Row>); K], x: impl Fn(&Row) -> f64) -> View {
    let curves = lines.into_iter().enumerate().flat_map(|(k, (label, rows))| {
        let points: Vec<[f64; 2]> = rows.iter().map(|row| [x(row), row[4]]).collect();
        let curve =
            |style: Style, label: &str| Curve { label: label.to_owned(), style, colour: k + 1, points: points.clone() };
        [curve(Style::Solid, ""), curve(Style::Points, label)]
    });
    View::Curves(Panel {
        title: String::new(),
        x_label: x_label.to_owned(),
        y_label: String::from("seconds"),
        scale: Scale::Logarithmic,
        bands: Vec::new(),
        curves: curves.collect(),
        y_range: Some([1e-2, 1e2]),
        x_range: None,
    })
}
