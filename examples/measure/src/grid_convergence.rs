//! How accurate is the grid, and what does accuracy cost?
//!
//! Seven oscillators with a known density are solved to one accuracy after another; the mesh, the joint L¹ error and its
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

/// The grid's error and cost by the accuracy it is asked for.
#[derive(Clone, Debug, Args)]
pub(crate) struct Options {
    /// L¹ accuracies, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "1e-2,1e-3,1e-4,1e-5,1e-6,1e-7,1e-8")]
    accuracies: Vec<f64>,
    /// Folder for the figure
    #[arg(long, default_value = "out/grid_convergence")]
    out: PathBuf,
}

pub(crate) fn run(options: &Options) -> Outcome {
    println!("joint L1 error of the grid; D is the intensity of E[xi(t) xi(t+tau)] = 2 D delta(tau)");
    println!(
        "{:>24} {:>8} {:>6} {:>9} {:>6} {:>9} {:>9} {:>7}",
        "", "accuracy", "cells", "unknowns", "rounds", "estimate", "true L1", "s"
    );
    let accuracies = &options.accuracies;
    let curves = [
        study("Duffing", &Duffing::new(0.2, 1.0, 0.3, 0.2)?, 1, accuracies)?,
        study("Duffing, two wells", &Duffing::new(1.0, -1.0, 1.0, 0.3)?, 2, accuracies)?,
        study("Duffing, three wells", &QuinticDuffing::new(1.0, 1.0, -1.8, 0.6, 0.3)?, 3, accuracies)?,
        study("van der Pol-Rayleigh", &VanDerPolRayleigh::new(1.0, 0.15)?, 4, accuracies)?,
        study("energy damping", &EnergyDamping::new(0.2, 0.3, 0.3, 0.2)?, 5, accuracies)?,
        study("displacement noise", &DisplacementNoise::new(0.5, 1.0, 0.4, 0.7, 0.5)?, 6, accuracies)?,
        study("velocity noise", &VelocityNoise::new([0.7, 0.3], [0.8, 0.0], 1.0, 0.4)?, 0, accuracies)?,
    ];
    let panel = Panel {
        title: String::new(),
        x_label: String::from("L¹ accuracy asked for"),
        y_label: String::from("joint L¹ error"),
        scale: Scale::LogLog,
        bands: Vec::new(),
        curves: curves.into_iter().flatten().collect(),
        y_range: Some([1e-11, 1e-1]),
        x_range: None,
    };
    let path = options.out.join("accuracy.svg");
    let caption = "Joint L¹ distance to the exact density. Duffing: c = 0.2, k = 1, μ = 0.3, D = 0.2; \
        two wells: c = 1, k = −1, μ = 1, D = 0.3; three: c = k = 1, μ = −1.8, ν = 0.6, D = 0.3; van der Pol-Rayleigh: \
        ε = 1, D = 0.15; energy: α = 0.2, β = μ = 0.3, D = 0.2; displacement: c = D = 0.5, k = 1, μ = 0.4, g = 0.7; \
        velocity: g₀ = 0.7, g₁ = 0.3, α = 0.8, k = 1, μ = 0.4. E[ξ(t)ξ(t+τ)] = 2D δ(τ).";
    write_figure(&path, caption, 1, &[View::Curves(panel)])?;
    println!("figure: {}", path.display());
    Ok(())
}

/// One system over all accuracies: a line and its points.
fn study(name: &str, system: &impl Solved, colour: usize, accuracies: &[f64]) -> expoly::Result<[Curve; 2]> {
    let (problem, exact) = (system.problem()?, system.exact()?);
    let mut points = Vec::new();
    for &accuracy in accuracies {
        let density = Grid::new().accuracy(accuracy).solve(&problem)?;
        let (l1, provenance) = (compare::l1(&density, &exact)?.value, density.provenance());
        println!(
            "{name:>24} {accuracy:>8e} {:>6} {:>9} {:>6} {:>9.1e} {l1:>9.1e} {:>7.2}",
            shown(provenance.cells),
            shown(provenance.unknowns),
            shown(provenance.iterations),
            density.l1_estimate(),
            provenance.seconds
        );
        points.push([accuracy, l1]);
    }
    let curve = |style: Style, label: &str| Curve { label: label.to_owned(), style, colour, points: points.clone() };
    Ok([curve(Style::Solid, ""), curve(Style::Points, name)])
}
