//! Derivatives by parameters next to a wall that takes energy, against those of the grid and differences of both.
//!
//! x″ + 0.2 x′ + x + 0.3 x³ = ξ, D = 0.2, E[ξ(t)ξ(t+τ)] = 2D δ(τ), with the motion above a wall at b that keeps the share r of the
//! speed. For each parameter and order: how far the derivatives of E y, E y² and E y′² are off at most, and that of the impact rate with
//! its stated error, relative to the grid's; with `--step` the same of central differences, of the closure and of the grid.

use crate::Outcome;
use clap::Args;
use expoly::models::{Duffing, Solved};
use expoly::{Closure, Density, Grid, Method, Problem, Result, Sensitivity, Wall};

/// Derivatives by parameters above lossy walls.
#[derive(Clone, Debug, Args)]
pub(crate) struct Options {
    /// Places of the wall, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "-0.5,0,0.5", allow_hyphen_values = true)]
    wall: Vec<f64>,
    /// Restitutions
    #[arg(long, value_delimiter = ',', default_value = "0.95,0.8")]
    restitutions: Vec<f64>,
    /// Orders of the closure
    #[arg(long, value_delimiter = ',', default_value = "4,6,8")]
    orders: Vec<u32>,
    /// L¹ accuracy of the grid
    #[arg(long, default_value = "1e-6")]
    accuracy: f64,
    /// The step of central differences; none leaves them out
    #[arg(long, default_value_t = 0.0)]
    step: f64,
}

/// Those of E y, E y² and E y′², and of the impact rate.
pub(crate) type Answers = [f64; 4];

const NAMES: [&str; 6] = ["c", "k", "mu", "D", "x.above.offset", "x.above.restitution"];

fn answers(moment: impl Fn(&[u32]) -> Result<f64>, impacts: Option<f64>) -> Result<Answers> {
    Ok([moment(&[1, 0])?, moment(&[2, 0])?, moment(&[0, 2])?, impacts.unwrap_or(f64::NAN)])
}

/// The largest relative deviation of the moments, and that of the impact rate.
fn apart(found: &Answers, truth: &Answers) -> [f64; 2] {
    let off: Vec<f64> = found.iter().zip(truth).map(|(found, truth)| (found / truth - 1.0).abs()).collect();
    [off[..3].iter().copied().fold(0.0, f64::max), off[3]]
}

/// Central differences of a density's answers by each parameter.
fn differences(problem: &Problem, step: f64, solve: &dyn Fn(&Problem) -> Result<Answers>) -> Result<Vec<Answers>> {
    let of = |name: &&str| {
        let value = problem.parameters().iter().find(|(other, _)| other == name).map_or(0.0, |(_, value)| *value);
        let at = |h: f64| solve(&problem.with_parameter(name, value + h)?);
        let (above, below) = (at(step)?, at(-step)?);
        Ok(std::array::from_fn(|k| (above[k] - below[k]) / (2.0 * step)))
    };
    NAMES.iter().map(of).collect()
}

fn of_density(density: &dyn Density, impacts: Option<f64>) -> Result<Answers> {
    answers(|powers| Ok(density.moment(powers)?.value), impacts)
}

/// The derivatives by each parameter of the grid's density.
pub(crate) fn by_grid(problem: &Problem, accuracy: f64) -> Result<Vec<Answers>> {
    let by = Grid::new().accuracy(accuracy).solve(problem)?.sensitivities(&NAMES)?;
    let truth = |by: &expoly::GridSensitivity| {
        answers(|powers| Ok(by.moment(powers)?.value), by.impact_rate().map(|rate| rate.value))
    };
    by.iter().map(truth).collect()
}

/// Two relative numbers for each parameter: of the moments the largest, and of the impact rate.
type Apart = Vec<[f64; 2]>;

/// How far those of the closure are off, and what they state: moments and impact rate for each parameter, relative to the truth.
pub(crate) fn by_closure(problem: &Problem, order: u32, truths: &[Answers]) -> Result<(Apart, Apart)> {
    let found = Closure::new(order).solve(problem)?.sensitivities(&NAMES)?;
    let (mut off, mut stated) = (Vec::new(), Vec::new());
    for (by, truth) in found.iter().zip(truths) {
        let impacts = by.impact_rate();
        off.push(apart(&answers(|powers| Ok(by.moment(powers)?.value), impacts.map(|rate| rate.value))?, truth));
        let moments = [[1, 0], [2, 0], [0, 2]].iter().zip(truth);
        let moments = moments.map(|(powers, truth)| Ok((by.moment(powers)?.error / truth).abs()));
        let moments = moments.collect::<Result<Vec<f64>>>()?.into_iter().fold(0.0, f64::max);
        stated.push([moments, impacts.map_or(f64::NAN, |rate| (rate.error / truth[3]).abs())]);
    }
    Ok((off, stated))
}

pub(crate) fn run(options: &Options) -> Outcome {
    let duffing = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?;
    for (&b, &r) in options.wall.iter().flat_map(|b| options.restitutions.iter().map(move |r| (b, r))) {
        let problem = duffing.clone().with_wall(Wall::above(b, r)?)?;
        let truths = by_grid(&problem, options.accuracy)?;
        println!("b = {b}, r = {r}; moments and impact rate relative to the grid's derivatives");
        let print = |what: &str, off: Vec<[f64; 2]>| {
            let row: Vec<String> = off.iter().map(|[moments, rate]| format!("{moments:.1e} {rate:.1e}")).collect();
            println!("  {what:22} {}", row.join("  "));
        };
        println!("  {:22} {}", "", NAMES.map(|name| format!("{:15}", name.trim_start_matches("x.above."))).join("  "));
        let by_differences = |what: &str, solve: &dyn Fn(&Problem) -> Result<Box<dyn Density>>| -> Result<()> {
            let of = |problem: &Problem| {
                let density = solve(problem)?;
                of_density(&*density, density.impact_rate().map(|rate| rate.value))
            };
            let found = differences(&problem, options.step, &of)?;
            print(what, found.iter().zip(&truths).map(|(found, truth)| apart(found, truth)).collect());
            Ok(())
        };
        if options.step > 0.0 {
            by_differences("differences, grid", &|problem| Grid::new().accuracy(options.accuracy).density(problem))?;
        }
        for &order in &options.orders {
            let (off, stated) = by_closure(&problem, order, &truths)?;
            print(&format!("n = {order}"), off);
            print("  stated errors", stated);
            if options.step > 0.0 {
                by_differences("  differences", &|problem| Closure::new(order).density(problem))?;
            }
        }
    }
    Ok(())
}
