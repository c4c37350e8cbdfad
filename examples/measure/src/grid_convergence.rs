//! How accurate is the grid, and what does accuracy cost?
//!
//! Seven oscillators with a known density are solved by polynomials of rising degree on one mesh; the joint L¹ error, its
//! estimate, and the time are printed, and a figure goes to `out/grid_convergence/`.

use crate::Outcome;
use clap::Args;
use expoly::models::{
    DisplacementNoise, Duffing, EnergyDamping, QuinticDuffing, Solved, VanDerPolRayleigh, VelocityNoise,
};
use expoly::{Density, Grid, compare};
use std::path::PathBuf;
use support::figure::{Curve, Panel, Scale, Style, View, write_figure};
use support::shown;

/// Convergence of the grid with its polynomials' degree.
#[derive(Clone, Debug, Args)]
pub(crate) struct Options {
    /// Degrees, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "2,3,4,5,6,7,8,9,10")]
    degrees: Vec<usize>,
    /// Folder for the figure
    #[arg(long, default_value = "out/grid_convergence")]
    out: PathBuf,
}

/// By this part of its width a domain is wider on each side than the defaults', where solutions of degree 2 have noise.
const WIDER: f64 = 0.05;

pub(crate) fn run(options: &Options) -> Outcome {
    println!("joint L1 error of the grid, 12 x 14 cells; D is the intensity of E[xi(t) xi(t+tau)] = 2 D delta(tau)");
    println!("{:>24} {:>6} {:>9} {:>9} {:>9} {:>7}", "", "degree", "unknowns", "L1", "estimate", "s");
    let degrees = &options.degrees;
    let curves = [
        study("Duffing", &Duffing::new(0.2, 1.0, 0.3, 0.2)?, 1, degrees)?,
        study("Duffing, two wells", &Duffing::new(1.0, -1.0, 1.0, 0.3)?, 2, degrees)?,
        study("Duffing, three wells", &QuinticDuffing::new(1.0, 1.0, -1.8, 0.6, 0.3)?, 3, degrees)?,
        study("van der Pol-Rayleigh", &VanDerPolRayleigh::new(1.0, 0.15)?, 4, degrees)?,
        study("energy damping", &EnergyDamping::new(0.2, 0.3, 0.3, 0.2)?, 5, degrees)?,
        study("displacement noise", &DisplacementNoise::new(0.5, 1.0, 0.4, 0.7, 0.5)?, 6, degrees)?,
        study("velocity noise", &VelocityNoise::new([0.7, 0.3], [0.8, 0.0], 1.0, 0.4)?, 0, degrees)?,
    ];
    let panel = Panel {
        title: String::new(),
        x_label: String::from("degree of the polynomials"),
        y_label: String::from("joint L¹ error"),
        scale: Scale::Logarithmic,
        bands: Vec::new(),
        curves: curves.into_iter().flatten().collect(),
        y_range: Some([1e-11, 1e-1]),
        x_range: None,
    };
    let path = options.out.join("degree.svg");
    let caption = "Joint L¹ distance to the exact density, 12 × 14 cells. Duffing: c = 0.2, k = 1, μ = 0.3, D = 0.2; \
        two wells: c = 1, k = −1, μ = 1, D = 0.3; three: c = k = 1, μ = −1.8, ν = 0.6, D = 0.3; van der Pol-Rayleigh: \
        ε = 1, D = 0.15; energy: α = 0.2, β = μ = 0.3, D = 0.2; displacement: c = D = 0.5, k = 1, μ = 0.4, g = 0.7; \
        velocity: g₀ = 0.7, g₁ = 0.3, α = 0.8, k = 1, μ = 0.4. E[ξ(t)ξ(t+τ)] = 2D δ(τ).";
    write_figure(&path, caption, 1, &[View::Curves(panel)])?;
    println!("figure: {}", path.display());
    Ok(())
}

/// One system over all degrees: a line and its points.
fn study(name: &str, system: &impl Solved, colour: usize, degrees: &[usize]) -> expoly::Result<[Curve; 2]> {
    let (problem, exact) = (system.problem()?, system.exact()?);
    // A domain somewhat wider than the finest solution's serves all degrees, so that only the degree changes.
    let widened = |[low, high]: [f64; 2]| [low - WIDER * (high - low), high + WIDER * (high - low)];
    let bounds = Grid::new().solve(&problem)?.bounds();
    let domain = [widened(bounds[0]), widened(bounds[1])];
    let mut points = Vec::new();
    for &degree in degrees {
        let density = Grid::new().degree(degree).cells([12, 14]).domain(domain).edge_level(1e-3).solve(&problem)?;
        let (l1, provenance) = (compare::l1(&density, &exact)?.value, density.provenance());
        println!(
            "{name:>24} {degree:>6} {:>9} {l1:>9.1e} {:>9.1e} {:>7.2}",
            shown(provenance.unknowns),
            density.l1_estimate(),
            provenance.seconds
        );
        points.push([degree as f64, l1]);
    }
    let curve = |style: Style, label: &str| Curve { label: label.to_owned(), style, colour, points: points.clone() };
    Ok([curve(Style::Solid, ""), curve(Style::Points, name)])
}
