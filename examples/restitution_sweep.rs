//! How do the density, the impact rate and the energy loss of a vibro-impact oscillator change as r goes from 1 to 0.5?
//!
//! Answer: the mass moves towards the wall. For y″ + 0.2 y′ + y + 0.3 y³ = ξ, D = 0.2, y > 0, the impact rate falls from 0.3616 to
//! 0.3594 at r = 0.925 before it rises to 0.445 ± 0.001 at r = 0.5; an impact costs most, 0.299, at r = 0.575; the power
//! lost rises all the way to 0.1296 ± 0.0001. `cargo run --release --example restitution_sweep` solves each r from one
//! close by and writes a table and a figure to `out/restitution_sweep/`; an interrupted run goes on from the table. With
//! `--restitution 0.8` it is the wall that moves, from b = −1 to 1.

#![allow(clippy::print_stdout, reason = "an example prints its answer")]

use clap::Parser;
use expoly::models::{Duffing, Solved};
use expoly::{Closure, ClosureDensity, Density, Wall, statistics::Impacts, study::Sweep};
use std::path::PathBuf;
use support::dealt::Dealt;
use support::figure::{Panel, Scale, Style, View, between, curve, values, write_figure};
use support::progress::study_bar;

/// A sweep of the restitution r, or of the wall's offset b.
#[derive(Clone, Debug, Parser)]
struct Options {
    /// Move the wall from b = -1 to 1 at this restitution
    #[arg(long, allow_negative_numbers = true)]
    restitution: Option<f64>,
    /// Offset b of the wall where r changes
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    offset: f64,
    /// Three values at order 4, instead of 21 at order 8
    #[arg(long)]
    short: bool,
    #[command(flatten)]
    dealt: Dealt,
    /// Folder for the table and the figure
    #[arg(long, default_value = "out/restitution_sweep")]
    out: PathBuf,
}

const COLUMNS: [&str; 6] = ["impact rate", "its error", "energy per impact", "power lost", "error", "L1 estimate"];

fn run(options: &Options) -> Result<(), Box<dyn std::error::Error>> {
    let (count, order) = if options.short { (3, 4) } else { (21, 8) };
    let oscillator = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
    let (free, closure) = (oscillator.problem()?, Closure::new(order));
    let (name, abscissa, range, fixed) = match options.restitution {
        None => ("r", "restitution r", [1.0, 0.5], format!("b = {}", options.offset)),
        Some(r) => ("b", "offset b of the wall [L]", [-1.0, 1.0], format!("r = {r}")),
    };
    let wall = |value| options.restitution.map_or(Wall::above(options.offset, value), |r| Wall::above(value, r));
    let heights = between([0.06, 3.0], 50);
    let at_heights = heights.iter().map(|u| format!("p at {u:.2}"));
    let columns: Vec<String> = COLUMNS.map(str::to_owned).into_iter().chain(at_heights).collect();
    std::fs::create_dir_all(&options.out)?;
    let file = |end| options.out.join(format!("{}_n{order}.{end}", fixed.replace(" = ", "")));
    let (bar, progress) = study_bar();
    let table = Sweep::new(name, &between(range, count), &columns)
        .settings(&format!("{oscillator:?} {fixed} {closure:?}"))
        .file(file("csv"))
        .part(options.dealt.part.0, options.dealt.part.1)
        .progress(progress)
        .run(|value, near: Option<&ClosureDensity>| {
            let wall = wall(value)?;
            let problem = free.clone().with_wall(wall)?;
            let density = closure.clone().starting_from(near).solve(&problem)?;
            let impacts = Impacts::new(&density, &problem)?;
            let (rate, each, power) = (impacts.rate(), impacts.energy_loss(), impacts.power());
            let mut row = vec![rate.value, rate.error, each.value, power.value, power.error, density.l1_estimate()];
            row.extend(values(&heights, |u| density.marginal(0, wall.offset() + u))?.iter().map(|[_, p, _]| *p));
            Ok((row, density))
        })?;
    bar.finish_and_clear();
    if let Some(note) = options.dealt.note(&file("csv"), table.missing()) {
        println!("{note}");
        return Ok(());
    }
    println!("     {name}        impacts per time  energy per impact              power lost   L1 estimate");
    let rows = table.rows();
    for row in rows {
        let [value, rate, error, each, power, off, l1, ..] = row[..] else { continue };
        println!("{value:6.3} {rate:12.6} ± {error:.1e} {each:18.6} {power:13.6} ± {off:.1e} {l1:13.1e}");
    }
    let against = |ordinate, at: usize| {
        let points: Vec<_> = rows.iter().map(|row| [row[0], row[at]]).collect();
        Panel::new([abscissa, ordinate], Scale::Linear, vec![curve("", Style::Solid, at, &points)])
    };
    let densities = [(1, 0), (2, rows.len() / 2), (3, rows.len() - 1)].map(|(colour, k)| {
        let points: Vec<[f64; 2]> = heights.iter().zip(&rows[k][7..]).map(|(u, p)| [*u, *p]).collect();
        curve(&format!("{name} = {}", rows[k][0]), Style::Solid, colour, &points)
    });
    let views = [
        Panel::new(["height above the wall y − b [L]", "density p(y) [1/L]"], Scale::Linear, densities.to_vec()),
        against("impacts per unit time [1/T]", 1),
        against("energy per impact and mass [L²/T²]", 3),
        against("power lost per mass [L²/T³]", 4),
    ];
    let caption =
        format!("y″ + 0.2 y′ + y + 0.3 y³ = ξ, D = 0.2, E[ξ(t)ξ(t+τ)] = 2D δ(τ); {fixed}; order {order}, seed 0");
    write_figure(&file("svg"), &caption, 2, &views.map(View::Curves))?;
    println!("table: {}, figure: {}", file("csv").display(), file("svg").display());
    Ok(())
}

fn main() -> std::process::ExitCode {
    support::exit_code(run(&Options::parse()))
}
