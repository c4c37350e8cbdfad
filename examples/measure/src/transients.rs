//! The closure in time, against the grid's transients.
//!
//! Duffing's oscillator x″ + 0.2 x′ + x + 0.3 x³, D = 0.2, two wells x″ + 0.5 x′ − x + x³, D = 0.3, both from N((1, 0), 0.2² I), van
//! der Pol's x″ − 0.5 (1 − x²) x′ + x, D = 0.3, from N(0, 0.2² I), the Duffing oscillator above a wall at −0.5, and under noise with
//! the envelope 1.2748 (e^(−0.09 t) − e^(−1.49 t)) of peak 1, D = 0.6625: for each order and time the L¹ distance from the grid, the closure's own
//! estimate of it and the grid's. Then the slowest rates of relaxation of both.

use crate::Outcome;
use clap::Args;
use expoly::models::{Duffing, Solved};
use expoly::{
    Closure, ClosureDensity, Course, Density, Envelope, Gaussian, Grid, GridDensity, Problem, Result, Start, Transient,
    Wall, Weight, compare,
};
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

pub(crate) struct Case {
    pub(crate) name: &'static str,
    problem: Problem,
    /// The displacement that the start is about.
    start: f64,
    envelope: Option<Envelope>,
    /// The region of the grid; none for its own choice.
    domain: Option<[[f64; 2]; 2]>,
}

pub(crate) fn cases() -> Result<Vec<Case>> {
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

impl Case {
    /// From N((start, 0), 0.2² I).
    fn course(&self) -> Course {
        let (mean, covariance) = (dvector![self.start, 0.0], dmatrix![0.04, 0.0; 0.0, 0.04]);
        let course = Course::from(Start::Gaussian(Gaussian { mean, covariance }));
        self.envelope.clone().map_or(course.clone(), |envelope| course.under(envelope))
    }

    /// The grid's stationary density and those at some times.
    pub(crate) fn truth(&self, accuracy: f64, times: &[f64]) -> Result<(GridDensity, Vec<Transient<GridDensity>>)> {
        let grid = Grid::new().accuracy(accuracy);
        let stationary = self.domain.map_or(grid.clone(), |domain| grid.domain(domain)).solve(&self.problem)?;
        let densities = stationary.transient(self.course(), times, 1e-4)?;
        Ok((stationary, densities))
    }

    /// The distances of the closure's densities, and its estimates of them.
    pub(crate) fn distances(
        &self,
        order: u32,
        times: &[f64],
        (_, truth): &(GridDensity, Vec<Transient<GridDensity>>),
    ) -> Result<Vec<[f64; 2]>> {
        let found = Closure::new(order).weight(Weight::Density).transient(&self.problem, self.course(), times)?;
        let pair = |(found, truth): (&Transient<_>, &Transient<GridDensity>)| {
            let (found, truth): (&ClosureDensity, _) = (&found.density, &truth.density);
            Ok([compare::l1(found, truth)?.value, found.l1_estimate()])
        };
        found.iter().zip(truth).map(pair).collect()
    }
}

pub(crate) fn run(options: &Options) -> Outcome {
    let times = &options.times;
    println!("L1 / estimate at t = {times:?}; seconds for all times");
    for case in cases()?.into_iter().filter(|case| case.name.contains(&options.only)) {
        let (name, truth) = (case.name, case.truth(options.accuracy, times)?);
        let estimates = truth.1.iter().map(|at| format!("{:>18.1e}", at.density.l1_estimate()));
        println!("{name:>14}     grid {}", estimates.collect::<String>());
        for &order in &options.orders {
            let begin = Instant::now();
            let found = case.distances(order, times, &truth)?;
            let seconds = begin.elapsed().as_secs_f64();
            let cells = found.iter().map(|[distance, estimate]| format!("{distance:>10.1e}/{estimate:.1e}"));
            println!("{name:>14}  n = {order:<2} {}  {seconds:.2}", cells.collect::<String>());
        }
        if case.envelope.is_none() {
            let own = Closure::new(6).solve(&case.problem)?.relaxation(4)?;
            for (own, grid) in own.iter().zip(truth.0.relaxation(4)?).skip(1) {
                let apart = (own.rate - grid.rate).hypot(own.frequency - grid.frequency);
                let apart = apart / grid.rate.hypot(grid.frequency);
                println!("{:>21}  {:.7} ± {:.7} i, from the grid's {apart:.1e}", "rate", own.rate, own.frequency);
            }
        }
    }
    Ok(())
}
