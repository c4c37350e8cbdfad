//! One case: the closures, the simulation and the grid, and their statistics.

use crate::options::{Method, Options, Parameters};
use crate::support::progress::{simulation_bar, spinner};
use expoly::{
    Barrier, Basis, Closure, Crossing, Density, Estimate, ExpPolynomial, FokkerPlanck, Grid, GridDensity, Histogram,
    SimulatedDensity, Simulation, Solution, Termination, compare, energy_balance,
};
use std::time::Instant;

/// What is compared between methods.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Statistics {
    pub(crate) mean_displacement: Estimate,
    pub(crate) variance_displacement: Estimate,
    pub(crate) mean_square_velocity: Estimate,
    pub(crate) impact_rate: Estimate,
    pub(crate) energy_balance: Estimate,
}

impl Statistics {
    fn of(density: &impl Density<2>, barrier: Barrier, balance: Estimate) -> expoly::Result<Self> {
        Ok(Statistics {
            mean_displacement: density.moment([1, 0]),
            variance_displacement: density.variance(0)?,
            mean_square_velocity: density.moment([0, 2]),
            impact_rate: density.flux(Crossing::downward(barrier.offset()), 1)?,
            energy_balance: balance,
        })
    }
}

/// A closure's answer. Without a density, `refusal` says why.
#[derive(Clone, Debug)]
pub(crate) struct Closed {
    pub(crate) solution: Solution<2>,
    pub(crate) density: Option<ExpPolynomial<2>>,
    pub(crate) statistics: Option<Statistics>,
    pub(crate) refusal: Option<String>,
    /// From the system to the normalised density and its statistics.
    pub(crate) seconds: f64,
}

impl Closed {
    pub(crate) fn name(&self) -> String {
        format!("{} n = {}", self.solution.basis(), self.solution.order())
    }

    /// The density to draw: the real one or, where Q turns upwards, exp(Q) cut off at the range of the samples. The flag
    /// tells the two apart.
    pub(crate) fn drawn(&self, simulated: Option<&SimulatedDensity<2>>) -> Option<(ExpPolynomial<2>, bool)> {
        if let Some(density) = &self.density {
            return Some((density.clone(), false));
        }
        let range = |state: usize| {
            let edges: Vec<f64> = simulated?.histogram(state).ok()?.edges().collect();
            Some([*edges.first()?, *edges.last()?])
        };
        let drawable = self.solution.termination() == Termination::NotNormalisable;
        let region = [range(0)?, range(1)?];
        drawable.then(|| self.solution.density_within(region).ok()).flatten().map(|density| (density, true))
    }
}

/// Everything that is known of one case.
#[derive(Debug)]
pub(crate) struct Study {
    pub(crate) parameters: Parameters,
    pub(crate) closed: Vec<Closed>,
    pub(crate) simulated: Option<(SimulatedDensity<2>, Statistics)>,
    pub(crate) gridded: Option<(GridDensity, Statistics)>,
}

impl Study {
    pub(crate) fn run(parameters: Parameters, options: &Options) -> expoly::Result<Self> {
        let model = parameters.model()?;
        let operator = FokkerPlanck::new(model.oscillator())?;
        let close = |(order, basis): (u32, Basis)| -> expoly::Result<Closed> {
            let start = Instant::now();
            let closure = Closure::classical(order).with_basis(basis);
            let solution = closure.solve_with_wall(model.oscillator(), model.barrier())?;
            let (density, refusal) = match solution.density() {
                Ok(density) => (Some(density), None),
                Err(error) => (None, Some(error.to_string())),
            };
            let statistics = match &density {
                Some(density) => {
                    let balance = energy_balance(&operator, density, Some(model.barrier()))?;
                    Some(Statistics::of(density, model.barrier(), balance)?)
                }
                None => None,
            };
            Ok(Closed { solution, density, statistics, refusal, seconds: start.elapsed().as_secs_f64() })
        };
        let closed = options.closures().into_iter().map(close).collect::<expoly::Result<Vec<_>>>()?;
        let gridded = match options.method.includes(Method::Grid) {
            false => None,
            true => {
                let mut grid = options.degree.map_or(Grid::new(), |degree| Grid::new().degree(degree));
                if let Some(&[along, across]) = options.cells.as_deref() {
                    grid = grid.cells([along, across]);
                }
                if let Some(&[low, high, slowest, fastest]) = options.domain.as_deref() {
                    grid = grid.domain([[low, high], [slowest, fastest]]);
                }
                let sign = spinner(&format!("grid at {}", parameters.stem()));
                let density = grid.solve_with_wall(model.oscillator(), model.barrier())?;
                sign.finish_and_clear();
                let balance = energy_balance(&operator, &density, Some(model.barrier()))?;
                let statistics = Statistics::of(&density, model.barrier(), balance)?;
                Some((density, statistics))
            }
        };
        let simulated = match options.method.includes(Method::Simulation) {
            false => None,
            true => {
                let (bar, callback) = simulation_bar(&format!("simulation at {}", parameters.stem()));
                let result = Simulation::new(model.oscillator())
                    .barrier(model.barrier())
                    .samples(options.samples)
                    .seed(options.seed)
                    .progress(callback)
                    .run()?;
                bar.finish_and_clear();
                let balance = result.energy_balance().unwrap_or(Estimate::new(f64::NAN, f64::INFINITY));
                let statistics = Statistics::of(&result, model.barrier(), balance)?;
                Some((result, statistics))
            }
        };
        Ok(Study { parameters, closed, simulated, gridded })
    }

    /// The L¹ distance of a closure's p_Y to the grid's.
    pub(crate) fn distance_to_grid(&self, closed: &Closed) -> Option<(f64, bool)> {
        let (grid, _) = self.gridded.as_ref()?;
        let (density, cut_off) = closed.drawn(self.simulated.as_ref().map(|(density, _)| density))?;
        let range = grid.provenance().domain[0];
        compare::marginal_l1(&density, grid, 0, range).ok().map(|distance| (distance.value, cut_off))
    }

    /// The distance of a closure's p_Y to the simulation's, with the flag of [`Closed::drawn`].
    pub(crate) fn distance(&self, closed: &Closed) -> Option<(compare::HistogramDistance, bool)> {
        let simulated = &self.simulated.as_ref()?.0;
        let (density, cut_off) = closed.drawn(Some(simulated))?;
        let histogram: &Histogram<1> = simulated.histogram(0).ok()?;
        compare::with_histogram(&density, 0, histogram).ok().map(|distance| (distance, cut_off))
    }
}
