//! One case: the closures, the simulation and the grid, and their statistics.

use crate::options::{Method, Options, Parameters, Task};
use expoly::statistics::energy_balance;
use expoly::{
    Closure, Crossing, Density, Estimate, ExpPolynomial, Grid, GridDensity, Method as _, Problem, Provenance,
    SimulatedDensity, Simulation, Solution, Termination, Wall, compare,
};
use indicatif::ProgressBar;
use std::sync::Arc;
use std::time::Instant;
use support::progress::{simulation_bar, spinner};

/// The name in tables of the closure that gives a density at every order.
const ROBUST: &str = "robust";

/// The statistics that are compared between methods: E y, Var y, E y′², the impact rate, the power balance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Statistics([Estimate; 5]);

impl Statistics {
    fn of(density: &dyn Density, problem: &Problem, balance: Estimate) -> expoly::Result<Self> {
        let offset = problem.walls().first().map_or(f64::NEG_INFINITY, Wall::offset);
        Ok(Statistics([
            density.moment(&[1, 0])?,
            density.variance(0)?,
            density.moment(&[0, 2])?,
            density.flux(Crossing::downward(offset), 1)?,
            balance,
        ]))
    }

    pub(crate) const NAMES: [&'static str; 5] =
        ["mean_displacement", "variance_displacement", "mean_square_velocity", "impact_rate", "energy_balance"];

    /// Each under its name.
    pub(crate) fn all(&self) -> [(&'static str, Estimate); 5] {
        std::array::from_fn(|k| (Self::NAMES[k], self.0[k]))
    }
}

/// A closure's answer with its statistics, if it has a density.
#[derive(Clone)]
pub(crate) struct Judged {
    pub(crate) method: &'static str,
    pub(crate) order: u32,
    pub(crate) provenance: Provenance,
    pub(crate) density: Option<Arc<dyn Density>>,
    /// The classical method's last iterate, also where it is no density.
    solution: Option<Solution>,
    pub(crate) statistics: Option<Statistics>,
    /// From the system to the normalised density.
    pub(crate) seconds: f64,
}

impl Judged {
    /// The closure's name in tables and figures.
    pub(crate) fn name(&self) -> String {
        format!("{} n = {}", self.provenance.basis.as_deref().unwrap_or(self.method), self.order)
    }

    /// Whether the robust closure's density is the best of its order and no root; the classical one has only roots.
    pub(crate) fn least_residual(&self) -> Option<bool> {
        let robust = self.method == ROBUST && self.density.is_some();
        robust.then(|| self.provenance.termination.as_deref() == Some("least residual"))
    }

    /// The density to draw: the real one or, where the classical Q turns upwards, exp(Q) cut off at the range of the
    /// samples. The flag is set for the latter.
    pub(crate) fn drawn(&self, simulated: Option<&SimulatedDensity>) -> Option<(Arc<dyn Density>, bool)> {
        if let Some(density) = &self.density {
            return Some((density.clone(), false));
        }
        let range = |state: usize| {
            let edges: Vec<f64> = simulated?.histogram(state).ok()?.edges(0).collect();
            Some([*edges.first()?, *edges.last()?])
        };
        let solution = self.solution.as_ref()?;
        let drawable = solution.termination() == Termination::NotNormalisable;
        let region = [range(0)?, range(1)?];
        let density = drawable.then(|| ExpPolynomial::cut_off(&solution.log_polynomial(), &region).ok()).flatten()?;
        Some((Arc::new(density), true))
    }
}

/// All results of one case.
pub(crate) struct Study {
    pub(crate) parameters: Parameters,
    pub(crate) closures: Vec<Judged>,
    pub(crate) simulated: Option<(SimulatedDensity, Statistics)>,
    pub(crate) gridded: Option<(GridDensity, Statistics)>,
}

impl Study {
    pub(crate) fn run(parameters: Parameters, options: &Options) -> expoly::Result<Self> {
        let problem = parameters.model()?.problem()?;
        let close = |task: Task| -> expoly::Result<Judged> {
            let begin = Instant::now();
            let (method, order, solution, density) = match task {
                Task::Robust(order) => {
                    let closure = Closure::new(order).weight(options.weight).seed(options.seed);
                    (ROBUST, order, None, closure.density(&problem))
                }
                Task::Classical(order, basis) => {
                    let solution = Closure::classical(order).basis(basis).solve(&problem)?;
                    let density = solution.density().map(|density| -> Box<dyn Density> { Box::new(density) });
                    ("classical", order, Some(solution), density)
                }
            };
            let seconds = begin.elapsed().as_secs_f64();
            let (density, provenance) = match density {
                Ok(density) => {
                    let provenance = density.provenance().clone();
                    (Some(Arc::from(density)), provenance)
                }
                Err(error) if error.is_without_density() => {
                    let mut provenance = solution.as_ref().map_or_else(Provenance::default, |s| s.provenance().clone());
                    provenance.refusal = Some(error.to_string());
                    (None, provenance)
                }
                Err(error) => return Err(error),
            };
            let statistics = density.as_ref().map(|density: &Arc<dyn Density>| {
                let balance = energy_balance(&problem, &**density)?;
                Statistics::of(&**density, &problem, balance)
            });
            let statistics = statistics.transpose()?;
            Ok(Judged { method, order, provenance, density, solution, statistics, seconds })
        };
        let closures = options.closures().into_iter().map(close).collect::<expoly::Result<Vec<_>>>()?;
        let (gridded, simulated) =
            rayon::join(|| gridded(&parameters, options, &problem), || simulated(&parameters, options, &problem));
        Ok(Study { parameters, closures, simulated: simulated?, gridded: gridded? })
    }

    /// The joint L¹ distance of a closure to the grid, with the flag of [`Judged::drawn`].
    pub(crate) fn distance_to_grid(&self, judged: &Judged) -> Option<(f64, bool)> {
        let (grid, _) = self.gridded.as_ref()?;
        let (density, cut_off) = judged.drawn(self.simulated.as_ref().map(|(density, _)| density))?;
        Some((compare::l1(&*density, grid).ok()?.value, cut_off))
    }

    /// The distance of a closure's p_Y to the simulation's, with the flag of [`Judged::drawn`].
    pub(crate) fn distance(&self, judged: &Judged) -> Option<(compare::HistogramDistance, bool)> {
        let simulated = &self.simulated.as_ref()?.0;
        let (density, cut_off) = judged.drawn(Some(simulated))?;
        let histogram = simulated.histogram(0).ok()?;
        compare::with_histogram(&*density, 0, histogram).ok().map(|distance| (distance, cut_off))
    }
}

fn gridded(
    parameters: &Parameters,
    options: &Options,
    problem: &Problem,
) -> expoly::Result<Option<(GridDensity, Statistics)>> {
    if !options.method.includes(Method::Grid) {
        return Ok(None);
    }
    let mut grid = Grid::new().accuracy(options.accuracy);
    if let Some(&[low, high, slowest, fastest]) = options.domain.as_deref() {
        grid = grid.domain([[low, high], [slowest, fastest]]);
    }
    // A simulation at the same time has a bar, and two signs would overwrite each other.
    let alone = !options.method.includes(Method::Simulation);
    let sign = alone.then(|| spinner(&format!("grid at {}", parameters.stem())));
    let density = grid.solve(problem)?;
    sign.inspect(ProgressBar::finish_and_clear);
    let statistics = Statistics::of(&density, problem, energy_balance(problem, &density)?)?;
    Ok(Some((density, statistics)))
}

fn simulated(
    parameters: &Parameters,
    options: &Options,
    problem: &Problem,
) -> expoly::Result<Option<(SimulatedDensity, Statistics)>> {
    if !options.method.includes(Method::Simulation) {
        return Ok(None);
    }
    let (bar, callback) = simulation_bar(&format!("simulation at {}", parameters.stem()));
    let result = Simulation::new().samples(options.samples).seed(options.seed).progress(callback).run(problem)?;
    bar.finish_and_clear();
    let balance = result.energy_balance()[0];
    let statistics = Statistics::of(&result, problem, balance)?;
    Ok(Some((result, statistics)))
}
