//! The closure in time, against the grid's transients.
//!
//! Duffing's oscillator x″ + 0.2 x′ + x + 0.3 x³, D = 0.2, two wells x″ + 0.5 x′ − x + x³, D = 0.3, both from N((1, 0), 0.2² I), van
//! der Pol's x″ − 0.5 (1 − x²) x′ + x, D = 0.3, from N(0, 0.2² I), the Duffing oscillator above a wall at −0.5, and under noise with
//! the envelope 1.2748 (e^(−0.09 t) − e^(−1.49 t)) of peak 1, D = 0.6625: for each order and time the L¹ distance from the grid, the closure's own
//! estimate of it and the grid's. Then the slowest rates of relaxation of both.

use crate::Outcome;
use clap::Args;
use expoly::models::{Duffing, Solved};
use expoly::{Closure, Course, Density, Envelope, Gaussian, Grid, Problem, Result, Start, Wall, Weight, compare};
use nalgebra::{dmatrix, dvector};
use std::time::Instant;

/// The closure in time.
#[derive(Clone, Debug, Args)]
pub(crate) struct Options {
    /// Orders, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "4,6,8")]
    orders: Vec<u32>,
    /// Times, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "0.5,1,2,4,8,16,32")]
    times: Vec<f64>,
    /// L¹ accuracy of the grid
    #[arg(long, default_value = "1e-6")]
    accuracy: f64,
    /// Only the systems whose names contain this
    #[arg(long, default_value = "")]
    only: String,
}

struct Case {
    name: &'static str,
    problem: Problem,
    /// The displacement that the start is about.
    start: f64,
    envelope: Option<Envelope>,
    /// The region of the grid; none for its own choice.
    domain: Option<[[f64; 2]; 2]>,
}

fn cases() -> Result<Vec<Case>> {
    let duffing = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?;
    let text = "states = [\"x\", \"v\"]\n[drift]\nx = \"v\"\nv = \"0.5*(1 - x^2)*v - x\"\n[noise.w]\nv = \"sqrt(0.6)\"";
    let plain = |name, problem, start, domain| Case { name, problem, start, envelope: None, domain };
    let wall = |restitution| duffing.clone().with_wall(Wall::above(-0.5, restitution)?);
    let peak = Envelope::exponentials(1.0, 0.09, 1.49)?.peak();
    Ok(vec![
        plain("Duffing", duffing.clone(), 1.0, Some([[-3.9, 3.9], [-6.2, 6.2]])),
        plain("two wells", Duffing::new(0.5, -1.0, 1.0, 0.3)?.problem()?, 1.0, Some([[-2.9, 2.9], [-5.0, 5.0]])),
        plain("van der Pol", Problem::from_toml(text)?, 0.0, Some([[-5.0, 5.0], [-6.5, 6.5]])),
        plain("wall, r = 1", wall(1.0)?, 1.0, None),
        plain("wall, r = 0.8", wall(0.8)?, 1.0, None),
        Case {
            name: "modulated",
            problem: Duffing::new(0.2, 1.0, 0.3, 0.6625)?.problem()?,
            start: 0.0,
            envelope: Some(Envelope::exponentials(1.0 / peak, 0.09, 1.49)?),
            domain: None,
        },
    ])
}

pub(crate) fn run(options: &Options) -> Outcome {
    let times = &options.times;
    println!("L1 / estimate at t = {times:?}; seconds for all times");
    for Case { name, problem, start, envelope, domain } in cases()? {
        if !name.contains(&options.only) {
            continue;
        }
        let start =
            Start::Gaussian(Gaussian { mean: dvector![start, 0.0], covariance: dmatrix![0.04, 0.0; 0.0, 0.04] });
        let mut grid = Grid::new().accuracy(options.accuracy);
        if let Some(domain) = domain {
            grid = grid.domain(domain);
        }
        let stationary = grid.solve(&problem)?;
        let steady = envelope.is_none();
        let course = match envelope {
            None => Course::from(start),
            Some(envelope) => Course::from(start).under(envelope),
        };
        let truth = stationary.transient(&course, times, 1e-4)?;
        let cells = |of: &dyn Fn(usize) -> Result<String>| (0..times.len()).map(of).collect::<Result<String>>();
        println!("{name:>14}     grid {}", cells(&|k| Ok(format!("{:>18.1e}", truth[k].density.l1_estimate())))?);
        for &order in &options.orders {
            let begin = Instant::now();
            let closure = Closure::new(order).weight(Weight::Density);
            let found = closure.transient(&problem, &course, times)?;
            let seconds = begin.elapsed().as_secs_f64();
            let cell = |k: usize| {
                let distance = compare::l1(&found[k].density, &truth[k].density)?.value;
                Ok(format!("{distance:>10.1e}/{:.1e}", found[k].density.l1_estimate()))
            };
            println!("{name:>14}  n = {order:<2} {}  {seconds:.2}", cells(&cell)?);
        }
        if steady {
            let own = Closure::new(6).solve(&problem)?.relaxation(4)?;
            for (own, grid) in own.iter().zip(stationary.relaxation(4)?).skip(1) {
                let apart = (own.rate - grid.rate).hypot(own.frequency - grid.frequency);
                let size = grid.rate.hypot(grid.frequency);
                println!(
                    "{:>21}  {:.7} ± {:.7} i, from the grid's {:.1e}",
                    "rate",
                    own.rate,
                    own.frequency,
                    apart / size
                );
            }
        }
    }
    Ok(())
}
