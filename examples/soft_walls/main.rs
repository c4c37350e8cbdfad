//! How stiff must a wall be to count as rigid?
//!
//! Soft walls are an ordinary oscillator's: a steep polynomial force holds it between −0.5 and 2.5, with a damping that gives
//! every impact the same restitution. Answer, by `cargo run --release --example soft_walls`: elastic walls of the stiffness K = 76, in
//! units of the oscillator's own, leave an L¹ distance of 0.046 from the density of displacement between rigid ones, and K = 610
//! leaves 0.016; it falls like K^(−1/2), the depth that bodies enter the walls by, and E y² like 1/K. Walls that take energy are
//! farther from their limit: with r = 0.7, K = 380 leaves 0.030 and 1.2 % of E y², which
//! fall like K^(−0.41) and K^(−0.34). The program solves both on grids and writes a figure to `out/soft_walls/`.

#![allow(clippy::print_stdout, reason = "an example prints its answer")]

mod walls;

use clap::Parser;
use expoly::models::Duffing;
use expoly::{Density, Estimate, Grid, GridDensity};
use std::path::PathBuf;
use support::figure::{Panel, Scale, Style, View, between, curve, values, write_figure};
use walls::{SoftWalls, rigid};

/// An oscillator between soft walls and between rigid ones.
#[derive(Clone, Debug, Parser)]
struct Options {
    /// Restitutions, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "1,0.7")]
    restitutions: Vec<f64>,
    /// Powers m of the soft walls, odd, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "5,9,15,25")]
    powers: Vec<u32>,
    /// L¹ accuracy of the grids
    #[arg(long, default_value = "1e-5")]
    accuracy: f64,
    /// Folder for the figure and its numbers
    #[arg(long, default_value = "out/soft_walls")]
    out: PathBuf,
}

/// b₁ and b₂, of which the second one is seldom reached.
const WALLS: [f64; 2] = [-0.5, 2.5];
/// exp(−C) with Euler's constant C. Of elastic walls this contact energy, in units of E v², leaves no shift of their mean place.
const ENERGY: f64 = 0.561_459_483_566_885_2;
/// Velocities on the grid, which end where the density is below 1e-7 of its peak.
const FASTEST: f64 = 5.8;
/// The energy of contact where the grid ends, in units of E v² of the free oscillator: exp(−16) = 1e-7.
const HIGHEST: f64 = 16.0;

/// Soft walls of the power m, and how far their density is from that of rigid walls.
struct Row {
    power: u32,
    stiffness: f64,
    /// L¹ of the density of displacement; E y² and E v², relative.
    distances: [Estimate; 3],
}

impl Row {
    /// Stiffness and distance, where this is known to a quarter.
    fn known(&self, k: usize) -> Option<[f64; 2]> {
        let distance = self.distances[k];
        (distance.error < 0.25 * distance.value).then_some([self.stiffness, distance.value])
    }
}

/// The exponent n of d ~ Kⁿ between the last two rows.
fn exponent(rows: &[Row], k: usize) -> Option<f64> {
    let [.., first, last] = rows else { return None };
    let ([softer, far], [stiffer, near]) = (first.known(k)?, last.known(k)?);
    Some((near / far).ln() / (stiffer / softer).ln())
}

/// The grid's density between soft walls, on a domain that ends within them.
fn solve(soft: &SoftWalls, options: &Options, power: u32, energy: f64) -> expoly::Result<GridDensity> {
    let half = (WALLS[1] - WALLS[0]) / 2.0;
    let reach = half * ((HIGHEST / energy).powf(0.5 / f64::from(power)) - 1.0);
    let domain = [[WALLS[0] - reach, WALLS[1] + reach], [-FASTEST, FASTEST]];
    Grid::new().accuracy(options.accuracy).domain(domain).solve(&soft.problem()?)
}

/// ∫ |p − q| dy by the midpoint rule, with the kinks at the walls between the parts, and with the L¹ errors of both grids.
fn distance(soft: &GridDensity, rigid: &GridDensity) -> expoly::Result<Estimate> {
    const POINTS: u32 = 600;
    let [low, high] = soft.bounds()[0];
    let mut sum = 0.0;
    for [low, high] in [[low, WALLS[0]], WALLS, [WALLS[1], high]] {
        let width = (high - low) / f64::from(POINTS);
        for k in 0..POINTS {
            let y = low + (f64::from(k) + 0.5) * width;
            sum += width * (soft.marginal(0, y)?.value - rigid.marginal(0, y)?.value).abs();
        }
    }
    Ok(Estimate::new(sum, soft.l1_estimate() + rigid.l1_estimate()))
}

/// |E/E₀ − 1| for a moment, with the errors of both grids.
fn difference(soft: Estimate, rigid: Estimate) -> Estimate {
    Estimate::new((soft.value / rigid.value - 1.0).abs(), (soft.error + rigid.error) / rigid.value)
}

fn run(options: &Options) -> Result<(), Box<dyn std::error::Error>> {
    let duffing = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
    let (mut views, mut approaches) = (Vec::new(), [const { Vec::new() }; 3]);
    let names = ["r", "m", "stiffness K", "L1 of p(y)", "E y^2 off by", "E v^2 off by"];
    println!("{:>6}{:>6}{:>14}{:>22}{:>22}{:>22}", names[0], names[1], names[2], names[3], names[4], names[5]);
    for (colour, &r) in options.restitutions.iter().enumerate() {
        let rigid = Grid::new().accuracy(options.accuracy).solve(&rigid(duffing, WALLS, r)?)?;
        let truth = [rigid.moment(&[2, 0])?, rigid.moment(&[0, 2])?];
        let energy = ENERGY * truth[1].value;
        let places = between([WALLS[0] - 0.4, 1.5], 191);
        let mut densities = vec![curve("rigid", Style::Solid, 0, &values(&places, |y| rigid.marginal(0, y))?)];
        let mut rows = Vec::new();
        for (k, &power) in options.powers.iter().enumerate() {
            let soft = SoftWalls { oscillator: duffing, offsets: WALLS, restitution: r, power, energy };
            let density = solve(&soft, options, power, energy)?;
            let squares = [density.moment(&[2, 0])?, density.moment(&[0, 2])?];
            let [y, v] = [0, 1].map(|k| difference(squares[k], truth[k]));
            let stiffness = soft.stiffness();
            rows.push(Row { power, stiffness, distances: [distance(&density, &rigid)?, y, v] });
            let line = values(&places, |y| density.marginal(0, y))?;
            densities.push(curve(&format!("K = {stiffness:.0}"), Style::Dashed, k + 1, &line));
        }
        for Row { power, stiffness, distances } in &rows {
            let cells = distances.map(|distance| format!("{:>22}", format!("{distance:.5}")));
            println!("{r:6}{power:6}{stiffness:14.1}{}", cells.concat());
        }
        let falls = [0, 1, 2].map(|k| exponent(&rows, k).map_or_else(String::new, |n| format!("K^{n:.2}")));
        println!("{:>26}{}", "falls in the end with", falls.map(|fall| format!("{fall:>22}")).concat());
        for (k, lines) in approaches.iter_mut().enumerate() {
            let line: Vec<_> = rows.iter().filter_map(|row| row.known(k)).collect();
            if !line.is_empty() {
                lines.push(curve(&format!("r = {r}"), Style::Solid, colour + 1, &line));
            }
        }
        let labels = [format!("displacement y [L], r = {r}"), String::from("density p(y) [1/L]")];
        let panel = Panel::new(labels.each_ref().map(String::as_str), Scale::Linear, densities);
        views.push(View::Curves(panel.with_x_range([WALLS[0] - 0.4, 1.5])));
    }
    let ordinates = ["L¹ distance of p(y) from rigid walls'", "E y², relative difference", "E v², relative difference"];
    for (lines, ordinate) in approaches.into_iter().zip(ordinates) {
        views.push(View::Curves(Panel::new(["stiffness of the walls K [1/T²]", ordinate], Scale::LogLog, lines)));
    }
    let caption = format!(
        "y″ + 0.2 y′ + y + 0.3 y³ + U′ + γ y′ = ξ, D = 0.2, E[ξ(t)ξ(t+τ)] = 2D δ(τ), U = e s²ᵐ, e = 0.561 E v², s = ±1 at {} and {}; \
         K = U″ there. Grids of L¹ accuracy {:e}.",
        WALLS[0], WALLS[1], options.accuracy
    );
    write_figure(&options.out.join("stiffness.svg"), &caption, 2, &views)?;
    println!("figure: {}", options.out.join("stiffness.svg").display());
    Ok(())
}

fn main() -> std::process::ExitCode {
    support::exit_code(run(&Options::parse()))
}
