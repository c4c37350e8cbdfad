//! What the orders are compared with: the exact density, the grid or a simulation.

use crate::rows::{Row, Study};
use crate::support::closure::Closed;
use crate::support::json::Number;
use crate::support::progress::{simulation_bar, spinner};
use crate::{Options, Reference};
use expoly::models::{PowerLaw, Solved};
use expoly::{ClosedDensity, Closure, Density, Grid, Histogram, PolynomialDrift, Simulation, compare};

/// The study that the options ask for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plan<'a>(pub(crate) &'a Options);

type Outcome = Result<Study, Box<dyn std::error::Error>>;

impl Plan<'_> {
    /// A model of two states with an exact density.
    pub(crate) fn solved<T: Solved<2, M> + Sync, const M: usize>(&self, equation: &str, model: &T) -> Outcome {
        self.two_states(equation, model, Some(&model.exact()?))
    }

    /// A model of two states without one.
    pub(crate) fn unsolved<T: PolynomialDrift<2, 1> + Sync>(&self, equation: &str, system: T) -> Outcome {
        self.two_states(equation, &system, None::<&PowerLaw>)
    }

    pub(crate) fn two_states<T: PolynomialDrift<2, M> + Sync, const M: usize>(
        &self,
        equation: &str,
        system: &T,
        exact: Option<&impl Density<2>>,
    ) -> Outcome {
        let best = if exact.is_some() { Reference::Exact } else { Reference::Grid };
        match (self.0.reference.unwrap_or(best), exact) {
            (Reference::Exact, Some(exact)) => self.against_exact(equation, system, exact),
            (Reference::Exact, None) => Err(format!("--model {}: no exact density is known", self.0.model).into()),
            (Reference::Grid, _) => self.against_grid(equation, system),
            (Reference::Simulation, _) => self.against_simulation(equation, system),
        }
    }

    /// A model of any number of states with an exact density.
    pub(crate) fn many_states<T: PolynomialDrift<N, M> + Sync, const N: usize, const M: usize>(
        &self,
        equation: &str,
        system: &T,
        exact: &impl Density<N>,
    ) -> Outcome {
        match self.0.reference.unwrap_or(Reference::Exact) {
            Reference::Exact => self.against_exact(equation, system, exact),
            Reference::Grid => Err(format!("--model {}: the grid takes two states, not {N}", self.0.model).into()),
            Reference::Simulation => self.against_simulation(equation, system),
        }
    }

    fn against_exact<T: PolynomialDrift<N, M> + Sync, const N: usize, const M: usize>(
        &self,
        equation: &str,
        system: &T,
        exact: &impl Density<N>,
    ) -> Outcome {
        let distance = |density: &ClosedDensity<N>| Ok(compare::l1(density, exact).value);
        let reference = String::from("against the exact density");
        self.study(equation, system, ("joint L1", reference, None), &distance)
    }

    fn against_grid<T: PolynomialDrift<2, M> + Sync, const M: usize>(&self, equation: &str, system: &T) -> Outcome {
        let sign = spinner("grid");
        let grid = Grid::new().solve(system)?;
        sign.finish_and_clear();
        let distance = |density: &ClosedDensity<2>| Ok(grid.l1_distance(density).value);
        let provenance = grid.provenance();
        let (x, v) = (grid.moment([2, 0]), grid.moment([0, 2]));
        let reference = format!(
            "against the grid, {} unknowns of degree {}: E x1^2 = {x:.8}, E x2^2 = {v:.8}, error of L1 {:.1e}",
            provenance.unknowns, provenance.degree, provenance.l1_error
        );
        self.study(equation, system, ("joint L1", reference, Some(provenance.l1_error)), &distance)
    }

    fn against_simulation<T: PolynomialDrift<N, M> + Sync, const N: usize, const M: usize>(
        &self,
        equation: &str,
        system: &T,
    ) -> Outcome {
        let (bar, callback) = simulation_bar("simulation");
        let simulated = Simulation::new(system).samples(self.0.samples).seed(self.0.seed).progress(callback).run()?;
        bar.finish_and_clear();
        let histogram: &Histogram<1> = simulated.histogram(0)?;
        let distance = |density: &ClosedDensity<N>| Ok(compare::with_histogram(density, 0, histogram)?.l1);
        // The noise is the histogram's own and the same for every density; one is needed to ask for it.
        let gaussian = Closure::classical(2).solve(system)?.density()?;
        let noise = compare::with_histogram(&gaussian, 0, histogram)?.noise;
        let provenance = simulated.provenance();
        let [x, v] = [0, 1].map(|state| simulated.moment(square(state)));
        let reference = format!(
            "against {} samples, seed {}, time step {}: E x1^2 = {x:.5}, E x2^2 = {v:.5}, noise of L1 {noise:.1e}",
            provenance.samples, provenance.seed, provenance.time_step
        );
        self.study(equation, system, ("L1 of p(x)", reference, Some(noise)), &distance)
    }

    fn study<T: PolynomialDrift<N, M> + Sync, const N: usize, const M: usize>(
        &self,
        equation: &str,
        system: &T,
        (measure, reference, noise): (&'static str, String, Option<f64>),
        distance: &impl Fn(&ClosedDensity<N>) -> expoly::Result<f64>,
    ) -> Outcome {
        let options = self.0;
        let mut rows = Vec::new();
        for &order in &options.orders {
            if options.method.robust() {
                let closure = Closure::new(order).weight(options.weight).nodes(options.nodes.into()).seed(options.seed);
                rows.push(Row::new(Closed::robust(order, || closure.solve(system))?, system, distance)?);
            }
            if options.method.classical() {
                let closed = Closed::classical(|| Closure::classical(order).solve(system))?;
                rows.push(Row::new(closed, system, distance)?);
            }
        }
        Ok(Study {
            model: options.model.clone(),
            equation: equation.to_owned(),
            reference,
            measure,
            noise: noise.map(|noise| Number::new("noise", noise)),
            rows,
        })
    }
}

/// The powers of x_i².
pub(crate) fn square<const N: usize>(state: usize) -> [u32; N] {
    std::array::from_fn(|i| if i == state { 2 } else { 0 })
}
