//! How do the density, the impact rate and the energy loss of a vibro-impact oscillator change as r goes from 1 to 0.5?
//!
//! The mass moves towards the wall. For y″ + 0.2 y′ + y + 0.3 y³ = ξ, D = 0.2, y > 0, the impact rate falls from 0.3616 to
//! 0.3594 at r = 0.925 before it rises to 0.445 ± 0.001 at r = 0.5; an impact costs most, 0.299, at r = 0.575; the power
//! lost rises all the way to 0.1296 ± 0.0001. `cargo run --release --example restitution_sweep` solves each r from one
//! close by and writes `out/restitution_sweep/sweep.csv` and `.svg`. An interrupted run goes on from the table.

#![allow(clippy::print_stdout)]

#[path = "support/mod.rs"]
mod support;

use clap::Parser;
use expoly::{Barrier, Closure, ClosureDensity, Crossing, Density, models::Duffing, study::Sweep};
use std::{ops::ControlFlow, path::PathBuf};
use support::figure::{Panel, Scale, Style, View, curve, write_figure};

/// A sweep of the restitution.
#[derive(Clone, Debug, Parser)]
struct Options {
    /// Offset b of the wall
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    offset: f64,
    /// Three values at order 4, instead of 21 at order 8
    #[arg(long)]
    short: bool,
    /// Solve each value from nothing
    #[arg(long)]
    cold: bool,
    /// Folder for the table and the figure
    #[arg(long, default_value = "out/restitution_sweep")]
    out: PathBuf,
}

const COLUMNS: [&str; 6] =
    ["impact rate", "error of the rate", "energy per impact", "power lost", "error of the power", "L1 estimate"];

/// Heights above the wall at which the density is drawn.
fn heights() -> impl Iterator<Item = f64> {
    (1..=50).map(|k| 0.06 * f64::from(k))
}

fn run(options: &Options) -> Result<(), Box<dyn std::error::Error>> {
    let (steps, order) = if options.short { (2, 4) } else { (20, 8) };
    let values: Vec<f64> = (0..=steps).map(|k| 1.0 - 0.5 * f64::from(k) / f64::from(steps)).collect();
    let (oscillator, closure, b) = (Duffing::new(0.2, 1.0, 0.3, 0.2)?, Closure::new(order), options.offset);
    let columns: Vec<String> =
        COLUMNS.map(str::to_owned).into_iter().chain(heights().map(|u| format!("p at {u:.2}"))).collect();
    std::fs::create_dir_all(&options.out)?;
    let table = Sweep::new("r", &values, &columns.iter().map(String::as_str).collect::<Vec<_>>())
        .segment(if options.cold { 1 } else { 7 })
        .settings(&format!("{oscillator:?} {b} {closure:?}"))
        .file(options.out.join("sweep.csv"))
        .progress(|progress| {
            println!("{}/{}", progress.done, progress.total);
            ControlFlow::Continue(())
        })
        .run(|r, near: Option<&ClosureDensity<2>>| {
            let wall = Barrier::new(b, r)?;
            let cold = || closure.solve_with_wall(&oscillator, wall);
            let density = near.map_or_else(cold, |near| closure.solve_with_wall_from(&oscillator, wall, near))?;
            // An impact at the speed |v| takes (1 − r²) v²/2.
            let power = density.flux(Crossing::downward(b), 3)?.scaled((1.0 - r * r) / 2.0);
            let (rate, l1) = (density.impact_rate()?, density.l1_estimate());
            let mut row = vec![rate.value, rate.error, power.value / rate.value, power.value, power.error, l1];
            for u in heights() {
                row.push(density.marginal(0, b + u)?.value);
            }
            Ok((row, density))
        })?;
    println!("     r        impacts per time  energy per impact              power lost   L1 estimate");
    for row in table.rows() {
        let [r, rate, error, each, power, off, l1, ..] = row[..] else { continue };
        println!("{r:6.3} {rate:12.6} ± {error:.1e} {each:18.6} {power:13.6} ± {off:.1e} {l1:13.1e}");
    }
    let rows = table.rows();
    let against_r = |ordinate, at: usize| {
        let points: Vec<[f64; 2]> = rows.iter().map(|row| [row[0], row[at]]).collect();
        Panel::new(["restitution r", ordinate], Scale::Linear, vec![curve("", Style::Solid, at, &points)])
    };
    let densities = [(1, 0), (2, rows.len() / 2), (3, rows.len() - 1)].map(|(colour, k)| {
        let points: Vec<[f64; 2]> = heights().zip(&rows[k][7..]).map(|(u, p)| [b + u, *p]).collect();
        curve(&format!("r = {}", rows[k][0]), Style::Solid, colour, &points)
    });
    let views = [
        Panel::new(["displacement y [L]", "density p(y) [1/L]"], Scale::Linear, densities.to_vec()),
        against_r("impacts per unit time [1/T]", 1),
        against_r("energy per impact and mass [L²/T²]", 3),
        against_r("power lost per mass [L²/T³]", 4),
    ];
    let caption = format!("y″ + 0.2 y′ + y + 0.3 y³ = ξ, D = 0.2, E[ξ(t)ξ(t+τ)] = 2D δ(τ), wall at b = {b}; seed 0");
    write_figure(&options.out.join("sweep.svg"), &caption, 2, &views.map(View::Curves))?;
    println!("table and figure: {}", options.out.display());
    Ok(())
}

fn main() -> std::process::ExitCode {
    support::exit_code(run(&Options::parse()))
}
