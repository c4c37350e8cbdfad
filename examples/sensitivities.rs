//! Which parameter matters for a failure?
//!
//! Answer, by `cargo run --release --example sensitivities`, for an oscillator whose damping grows with its displacement,
//! x″ + (α + β x²) x′ + k x + μ x³ = ξ: a percent more noise makes a displacement above 2σ 2.1 % more likely, and a percent more
//! of the damping β, of the stiffness k, of its cubic part μ and of the damping α 1.5, 1.2, 0.9 and 0.7 % less likely. Each derivative
//! is one linear solve, states its error, and is a tangent to what the closure finds at other values, as the figure in `out/`
//! shows. The place of a wall and its restitution are parameters as well:
//! `expoly solve examples/systems/duffing.toml --sensitivity x.above.offset`.

#![allow(clippy::print_stdout, reason = "an example prints its answer")]

use clap::Parser;
use expoly::models::DuffingVanDerPol;
use expoly::statistics::Marginal;
use expoly::{Closure, Density, Estimate, Problem, Result, Sensitivity};
use std::{path::PathBuf, process::ExitCode};
use support::figure::{Panel, Scale, Style, View, between, curve, values, write_figure};
use support::text::aligned;

/// Elasticities of the answers, and tangents to them.
#[derive(Clone, Debug, Parser)]
struct Options {
    /// Order of the closure
    #[arg(long, default_value_t = 8)]
    order: u32,
    /// Level of the failure, in standard deviations of the displacement
    #[arg(long, default_value_t = 2.0)]
    level: f64,
    /// Folder for the figure and its numbers
    #[arg(long, default_value = "out/sensitivities")]
    out: PathBuf,
}

fn exceedance(density: &dyn Density, level: f64) -> Result<Estimate> {
    Marginal::new(density, 0)?.exceedance(level)
}

/// Percent of an answer for a percent of each parameter.
fn elasticities<S>(
    found: &[S],
    parameters: &[f64],
    answer: Estimate,
    slope: impl Fn(&S) -> Result<Estimate>,
) -> Result<Vec<Estimate>> {
    found.iter().zip(parameters).map(|(by, value)| Ok(slope(by)?.scaled(value / answer.value))).collect()
}

/// A row for each parameter and a column for each answer, and the same as bars.
fn shown(names: &[&str], parameters: &[f64], answers: &[(&str, Vec<Estimate>)]) -> Panel {
    let header = ["percent for a percent of", "at"].into_iter().chain(answers.iter().map(|(name, _)| *name));
    let mut rows: Vec<Vec<String>> = vec![header.map(String::from).collect()];
    for (k, (name, value)) in names.iter().zip(parameters).enumerate() {
        let cells = answers.iter().map(|(_, column)| column[k].to_string());
        rows.push([(*name).to_owned(), format!("{value:.4}")].into_iter().chain(cells).collect());
    }
    println!("{}", aligned(&rows, 1));
    let (categories, columns): (Vec<&str>, Vec<_>) = answers.iter().cloned().unzip();
    let series = names.iter().enumerate().map(|(k, name)| {
        let bars = columns.iter().map(|column| column[k].value).collect();
        (*name, bars)
    });
    Panel::bars(["", "percent for a percent"], &categories, &series.collect::<Vec<_>>())
}

fn run(options: &Options) -> std::result::Result<(), Box<dyn std::error::Error>> {
    let problem = Problem::parametric(DuffingVanDerPol::new([0.1, 0.3], 1.0, 0.3, 0.3)?)?;
    let closure = Closure::new(options.order);
    let density = closure.solve(&problem)?;
    let (names, present): (Vec<&str>, Vec<f64>) =
        problem.parameters().iter().map(|(name, value)| (name.as_str(), *value)).unzip();
    let (deviation, found) = (density.variance(0)?.value.sqrt(), density.sensitivities(&names)?);
    let (level, tail) = (options.level * deviation, format!("P(x > {}σ)", options.level));
    let [square, speed] = [[2, 0], [0, 2]];
    let (x, v, rare) = (density.moment(&square)?, density.moment(&speed)?, exceedance(&density, level)?);
    println!("P(x > {level:.4}) = {rare}, L1 {:.1e} by the closure's own estimate\n", density.l1_estimate());
    let answers = [
        ("E x²", elasticities(&found, &present, x, |by| by.moment(&square))?),
        ("E v²", elasticities(&found, &present, v, |by| by.moment(&speed))?),
        (tail.as_str(), elasticities(&found, &present, rare, |by| by.exceedance(0, level))?),
    ];
    let bars = shown(&names, &present, &answers);

    // The exceedance at other values of two parameters, and its tangents; what a parameter does to the density.
    let (mut tangents, mut slopes) = (Vec::new(), Vec::new());
    for (k, (by, value)) in found.iter().zip(&present).enumerate() {
        let name = by.parameter();
        let line = values(&between(density.bounds()[0], 161), |x| by.marginal(0, x).map(|p| p.scaled(*value)))?;
        slopes.push(curve(name, Style::Solid, k, &line));
        if ["beta", "mu"].contains(&name) {
            let again = |factor: f64| {
                let problem = problem.with_parameter(name, factor * value)?;
                exceedance(&closure.solve(&problem)?, level)
            };
            let slope = by.exceedance(0, level)?.value * value;
            let tangent = [0.8, 1.2].map(|factor| [factor, rare.value + slope * (factor - 1.0)]);
            let points = values(&between([0.8, 1.2], 9), again)?;
            tangents.push(curve(&format!("{name}, solved again"), Style::Points, k, &points));
            tangents.push(curve(&format!("{name}, tangent"), Style::Solid, k, &tangent));
        }
    }

    let caption = format!(
        "x″ + (α + β x²) x′ + k x + μ x³ = ξ, α = 0.1, β = 0.3, k = 1, μ = 0.3, D = 0.3, E[ξ(t)ξ(t+τ)] = 2D δ(τ); closure of order {}, \
         seed 0; the level is {level:.4}.",
        options.order
    );
    let views = [
        bars,
        Panel::new(["factor on the parameter", &tail], Scale::Linear, tangents),
        Panel::new(["displacement x [L]", "θ ∂p(x)/∂θ [1/L]"], Scale::Linear, slopes),
    ];
    let path = options.out.join("sensitivities.svg");
    write_figure(&path, &caption, 3, &views.map(View::Curves))?;
    println!("figure: {}", path.display());
    Ok(())
}

fn main() -> ExitCode {
    support::exit_code(run(&Options::parse()))
}
