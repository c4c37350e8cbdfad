//! Which parameter matters for a failure?
//!
//! Answer, by `cargo run --release --example sensitivities`, for an oscillator whose damping grows with its displacement,
//! x″ + (α + β x²) x′ + k x + μ x³ = ξ: a percent more noise makes a displacement above 2σ 2.1 % more likely, and a percent more
//! of the damping β, of the stiffness k, of its cubic part μ and of the damping α 1.5, 1.2, 0.9 and 0.7 % less likely. Each derivative
//! is one linear solve, states its error, and is a tangent to what the closure finds at other values, as the figure in `out/`
//! shows. Above a wall at −σ/2 that keeps 0.8 of the speed the impact rate changes most with the place of the wall: by
//! −0.39 % for a percent more distance, and by 0.07 % for a percent more of the speed.

#![allow(clippy::print_stdout, reason = "an example prints its answer")]

use clap::Parser;
use expoly::models::DuffingVanDerPol;
use expoly::statistics::Marginal;
use expoly::{Closure, ClosureDensity, ClosureSensitivity, Density, Estimate, Grid, Problem, Sensitivity, Wall};
use std::{path::PathBuf, process::ExitCode};
use support::figure::{Band, Panel, Scale, Style, View, between, curve, values, write_figure};

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

fn exceedance(density: &dyn Density, level: f64) -> expoly::Result<Estimate> {
    Marginal::new(density, 0)?.exceedance(level)
}

/// Percent of an answer for a percent of the parameter.
fn elasticity(value: f64, slope: Estimate, answer: f64) -> Estimate {
    slope.scaled(value / answer)
}

fn run(options: &Options) -> Result<(), Box<dyn std::error::Error>> {
    let problem = Problem::parametric(DuffingVanDerPol::new([0.1, 0.3], 1.0, 0.3, 0.3)?)?;
    let closure = Closure::new(options.order);
    let density = closure.solve(&problem)?;
    let level = options.level * density.variance(0)?.value.sqrt();
    let names: Vec<&str> = problem.parameters().iter().map(|(name, _)| name.as_str()).collect();
    let found = density.sensitivities(&names)?;

    let rare = exceedance(&density, level)?;
    println!("P(x > {level:.4}) = {rare}, L1 {:.1e} by the closure's own estimate", density.l1_estimate());
    println!("percent of each answer for a percent of a parameter:");
    println!("  parameter            E x^2                 E v^2              P(x > {} s)", options.level);
    let mut bars: Vec<Vec<f64>> = Vec::new();
    for ((name, value), found) in problem.parameters().iter().zip(&found) {
        let of = |powers: [u32; 2]| -> expoly::Result<Estimate> {
            Ok(elasticity(*value, found.moment(&powers)?, density.moment(&powers)?.value))
        };
        let tail = elasticity(*value, found.exceedance(0, level)?, rare.value);
        let all = [of([2, 0])?, of([0, 2])?, tail];
        bars.push(all.iter().map(|elasticity| elasticity.value).collect());
        let [x, v, tail] = all.map(|elasticity| elasticity.to_string());
        println!("  {name:6} = {value:4}  {x:>20}  {v:>20}  {tail:>20}");
    }

    let wall = Wall::above(-0.5 * density.variance(0)?.value.sqrt(), 0.8)?;
    let (walled, impacts) = next_to_a_wall(&problem.clone().with_wall(wall)?, &closure)?;
    let walled: Vec<&str> = walled.iter().map(String::as_str).collect();
    let views = [
        bar_chart("answer: 1 E x², 2 E v², 3 exceedance", &names, &bars),
        tangents(&closure, &problem, &found, level)?,
        marginals(&problem, &density, &found)?,
        bar_chart("impact rate: 1 by the closure, 2 by a grid", &walled, &impacts),
    ];
    let caption = format!(
        "x″ + (α + β x²) x′ + k x + μ x³ = ξ, α = 0.1, β = 0.3, k = 1, μ = 0.3, D = 0.3, E[ξ(t)ξ(t+τ)] = 2D δ(τ); closure of \
         order {}, seed 0. Above: percent of each answer for a percent of a parameter, the last of them P(x > {level:.4}), and that with \
         one parameter times a factor, and tangents. Below: θ ∂p(x)/∂θ; and above a wall at {:.4} with r = 0.8 the same percents of \
         the impact rate.",
        options.order,
        wall.offset()
    );
    let path = options.out.join("sensitivities.svg");
    write_figure(&path, &caption, 2, &views.map(View::Curves))?;
    println!("figure: {}", path.display());
    Ok(())
}

/// A bar for each parameter and answer, side by side at the numbers of the answers.
fn bar_chart(answers: &str, names: &[&str], bars: &[Vec<f64>]) -> Panel {
    let width = 0.8 / names.len() as f64;
    let band = |(k, answer, value): (usize, usize, f64)| {
        let begin = answer as f64 + 0.6 + width * k as f64;
        let points = [0.1, 0.9].map(|part| [begin + part * width, value.min(0.0), value.max(0.0)]);
        let label = if answer == 0 { names[k].trim_start_matches("x.above.").to_owned() } else { String::new() };
        Band { label, colour: k + 1, points: points.into() }
    };
    let all = bars.iter().enumerate().flat_map(|(k, bars)| bars.iter().enumerate().map(move |(i, v)| (k, i, *v)));
    let bands = all.map(band).collect();
    let count = bars.first().map_or(0, Vec::len) as f64;
    let zero = curve("", Style::Solid, 0, &[[0.5, 0.0], [count + 0.5, 0.0]]);
    Panel { bands, ..Panel::new([answers, "percent per percent"], Scale::Linear, vec![zero]) }
}

/// The elasticities of the impact rate, by the closure and by the grid, those by the wall's own parameters among them, with their names.
fn next_to_a_wall(problem: &Problem, closure: &Closure) -> expoly::Result<(Vec<String>, Vec<Vec<f64>>)> {
    let (mut bars, mut shown) = (Vec::new(), Vec::new());
    let names: Vec<&str> = problem.parameters().iter().map(|(name, _)| name.as_str()).collect();
    let density = closure.solve(problem)?;
    let found = density.sensitivities(&names)?;
    let truth = Grid::new().accuracy(1e-5).solve(problem)?;
    let truths = truth.sensitivities(&names)?;
    let (Some(rate), Some(true_rate)) = (density.impact_rate(), truth.impact_rate()) else { return Ok((shown, bars)) };
    println!(
        "above a wall, {rate} impacts per unit time, by the grid {true_rate}; percent for a percent of a parameter:"
    );
    for (((name, value), found), truth) in problem.parameters().iter().zip(&found).zip(&truths) {
        let (Some(own), Some(other)) = (found.impact_rate(), truth.impact_rate()) else { continue };
        let [own, other] = [elasticity(*value, own, rate.value), elasticity(*value, other, true_rate.value)];
        println!("  {name:19} = {value:7.4}  {:>20}  by the grid {:>20}", own.to_string(), other.to_string());
        shown.push(name.clone());
        bars.push(vec![own.value, other.value]);
    }
    Ok((shown, bars))
}

/// θ ∂p/∂θ of the displacement's marginal density for each parameter.
fn marginals(problem: &Problem, density: &ClosureDensity, found: &[ClosureSensitivity]) -> expoly::Result<Panel> {
    let scale =
        |name: &str| problem.parameters().iter().find(|(other, _)| other == name).map_or(1.0, |(_, value)| *value);
    let [low, high] = density.bounds()[0];
    let x = between([low, high], 161);
    let curves = found.iter().enumerate().map(|(k, found)| {
        let points = values(&x, |x| found.marginal(0, x))?;
        let scaled: Vec<[f64; 2]> = points.iter().map(|[x, p, _]| [*x, p * scale(found.parameter())]).collect();
        Ok(curve(found.parameter(), Style::Solid, k, &scaled))
    });
    let curves = curves.collect::<expoly::Result<Vec<_>>>()?;
    Ok(Panel::new(["displacement x [L]", "θ ∂p(x)/∂θ [1/L]"], Scale::Linear, curves))
}

/// The exceedance at other values of two parameters, and its tangents.
fn tangents(closure: &Closure, problem: &Problem, found: &[ClosureSensitivity], level: f64) -> expoly::Result<Panel> {
    let mut curves = Vec::new();
    for (colour, name) in ["beta", "mu"].into_iter().enumerate() {
        let Some(found) = found.iter().find(|found| found.parameter() == name) else { continue };
        let value = problem.parameters().iter().find(|(other, _)| other == name).map_or(1.0, |(_, value)| *value);
        let at = |factor: f64| exceedance(&closure.solve(&problem.with_parameter(name, factor * value)?)?, level);
        let points = values(&between([0.8, 1.2], 9), at)?;
        let (middle, slope) = (exceedance(found.density(), level)?.value, found.exceedance(0, level)?.value);
        let line: Vec<[f64; 2]> = [0.8, 1.2].map(|factor| [factor, middle + slope * value * (factor - 1.0)]).into();
        curves.push(curve(&format!("{name}, solved again"), Style::Points, colour + 1, &points));
        curves.push(curve(&format!("{name}, tangent"), Style::Solid, colour + 1, &line));
    }
    Ok(Panel::new(["factor on the parameter", "P(x > level)"], Scale::Linear, curves))
}

fn main() -> ExitCode {
    support::exit_code(run(&Options::parse()))
}
