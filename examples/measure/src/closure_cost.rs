//! What does a closure cost?
//!
//! The closure, pilot included, is timed over its order, over the number of nodes and over the number of states; tables are
//! printed and drawn, figure and CSV go to `out/closure_cost/`.

use crate::Outcome;
use clap::Args;
use expoly::models::{CubicDamping, Duffing, DuffingChain, Solved};
use expoly::{Closure, ClosureDensity, Density, Problem, Wall};
use std::path::PathBuf;
use std::time::Instant;
use support::figure::{Curve, Panel, Scale, Style, View, write_figure};
use support::file::write_csv;

/// The cost of a closure over its order, its nodes and its states.
#[derive(Clone, Debug, Args)]
pub(crate) struct Options {
    /// Highest order in two states; walls end at 10, chains at 6
    #[arg(long, default_value_t = 16)]
    highest: u32,
    /// Longest chain of oscillators
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

pub(crate) fn run(options: &Options) -> Outcome {
    println!("{:>22} {:>6} {:>7} {:>9} {:>9} {:>9}", "", "order", "states", "nodes", "unknowns", "seconds");
    let plane = Problem::of(CubicDamping::new([0.1, 0.3], 1.0, 1.0, 0.5)?)?;
    let walled = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?.with_wall(Wall::above(-0.5, 0.95)?)?;
    let chain = |length: usize| DuffingChain::new(&vec![0.2; length], 1.0, 0.3, 0.5, 0.8)?.problem();
    let short = chain(2)?;
    let orders = |highest: u32| (2..=highest.min(options.highest)).step_by(2);
    let timed = |name: &str, problem: &Problem, closure: Closure| timed(options.repeats, name, problem, &closure);
    let over_orders = |name, problem: &Problem, highest| -> expoly::Result<Vec<Row>> {
        orders(highest).map(|order| timed(name, problem, Closure::new(order))).collect()
    };
    let in_plane = over_orders("two states", &plane, 16)?;
    let above_wall = over_orders("a wall", &walled, 10)?;
    let in_chain = over_orders("2 oscillators", &short, 6)?;
    let with_nodes = [25_000, 50_000, 100_000, 200_000]
        .map(|count| timed("2 oscillators", &short, Closure::new(4).pilot_states(count)))
        .into_iter()
        .collect::<expoly::Result<Vec<Row>>>()?;
    let of_chain = |length| timed(&format!("{length} oscillators"), &chain(length)?, Closure::new(4));
    let of_chains = (2..=options.longest).map(of_chain).collect::<expoly::Result<Vec<Row>>>()?;

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
         r = 0.95; four states and more: chains of Duffing oscillators, the pilot's states as nodes. {} threads; seed 0.",
        options.repeats,
        std::thread::available_parallelism()?
    );
    let path = options.out.join("cost.svg");
    write_figure(&path, &caption, 3, &views)?;
    println!("figure: {}", path.display());
    Ok(())
}

/// The least time of several, with the numbers that are the same in all.
fn timed(repeats: usize, name: &str, problem: &Problem, closure: &Closure) -> expoly::Result<Row> {
    let mut least = f64::INFINITY;
    let mut facts = [0.0; 4];
    for _ in 0..repeats.max(1) {
        let begin = Instant::now();
        let density = closure.solve(problem)?;
        least = least.min(begin.elapsed().as_secs_f64());
        facts = [order(&density), problem.dimension() as f64, nodes(&density), unknowns(&density)];
    }
    let [order, states, nodes, unknowns] = facts;
    println!("{name:>22} {order:>6} {states:>7} {nodes:>9} {unknowns:>9} {least:>9.3}");
    Ok([order, states, nodes, unknowns, least])
}

fn order(density: &ClosureDensity) -> f64 {
    density.provenance().order.map_or(f64::NAN, f64::from)
}

fn nodes(density: &ClosureDensity) -> f64 {
    density.provenance().nodes.map_or(f64::NAN, |nodes| nodes as f64)
}

fn unknowns(density: &ClosureDensity) -> f64 {
    density.provenance().unknowns.map_or(f64::NAN, |unknowns| unknowns as f64)
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
