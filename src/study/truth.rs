use super::row::OrderRow;
use crate::closure::{Closure, Weight};
use crate::compare;
use crate::density::{Crossing, Density, ExpPolynomial};
use crate::error::Result;
use crate::estimate::Estimate;
use crate::grid::GridDensity;
use crate::polynomial::of_one;
use crate::simulation::SimulatedDensity;
use std::collections::BTreeMap;
use std::fmt;
use std::sync::{Mutex, PoisonError};

/// The level, relative to the peak, down to which tails are compared.
const LEVEL: f64 = 1e-5;

/// The reference for the answers of one case: an exact density, a solution on a grid, or a simulation.
pub struct Truth {
    kind: Kind,
    /// The distances of the closest exponential polynomials, by their orders.
    closest: Mutex<BTreeMap<u32, Option<f64>>>,
}

enum Kind {
    Exact(Box<dyn Density>),
    Grid(Box<GridDensity>),
    /// The distance is that of the first state's marginal from the histogram, whose noise is in it.
    Simulation(Box<SimulatedDensity>),
}

impl fmt::Debug for Truth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Truth").field(&self.text()).finish()
    }
}

impl From<ExpPolynomial> for Truth {
    fn from(density: ExpPolynomial) -> Self {
        Truth::exact(density)
    }
}

impl From<GridDensity> for Truth {
    fn from(density: GridDensity) -> Self {
        Truth::of(Kind::Grid(Box::new(density)))
    }
}

impl From<SimulatedDensity> for Truth {
    fn from(density: SimulatedDensity) -> Self {
        Truth::of(Kind::Simulation(Box::new(density)))
    }
}

impl Truth {
    /// A density in closed form.
    pub fn exact(density: impl Density + 'static) -> Self {
        Truth::of(Kind::Exact(Box::new(density)))
    }

    fn of(kind: Kind) -> Self {
        Truth { kind, closest: Mutex::new(BTreeMap::new()) }
    }

    /// The distance of the closest exponential polynomial of an order; none where it is not known.
    pub(super) fn closest(&self, order: u32) -> Option<f64> {
        if matches!(self.kind, Kind::Simulation(_)) || self.density().dimension() > 2 {
            return None;
        }
        let mut known = self.closest.lock().unwrap_or_else(PoisonError::into_inner);
        *known.entry(order).or_insert_with(|| {
            let fitted = Closure::new(order).weight(Weight::Density).fit(self.density());
            fitted.ok().map(|fitted| fitted.l1_estimate())
        })
    }

    fn density(&self) -> &dyn Density {
        match &self.kind {
            Kind::Exact(density) => &**density,
            Kind::Grid(density) => &**density,
            Kind::Simulation(density) => &**density,
        }
    }

    /// Its description, in a few words.
    pub(super) fn text(&self) -> String {
        match &self.kind {
            Kind::Exact(_) => String::from("exact density"),
            Kind::Grid(density) => {
                let (unknowns, degree) = (density.provenance().unknowns, density.provenance().degree);
                let [unknowns, degree] = [unknowns, degree].map(Option::unwrap_or_default);
                format!("grid of {unknowns} unknowns, degree {degree}, L1 error {:.1e}", density.l1_estimate())
            }
            Kind::Simulation(density) => {
                let provenance = density.provenance();
                let samples = provenance.samples.unwrap_or_default();
                let (seed, step) = (provenance.seed.unwrap_or_default(), provenance.time_step.unwrap_or_default());
                format!("simulation of {samples} samples, seed {seed}, time step {step}")
            }
        }
    }

    /// ∫ |p − q| dx of an answer, with the error due to the truth's own error.
    fn l1(&self, answer: &dyn Density) -> Result<Estimate> {
        match &self.kind {
            Kind::Exact(density) => compare::l1(answer, &**density),
            Kind::Grid(density) => Ok(Estimate::new(compare::l1(answer, &**density)?.value, density.l1_estimate())),
            Kind::Simulation(density) => {
                let distance = compare::with_histogram(answer, 0, density.histogram(0)?)?;
                Ok(Estimate::new(distance.l1, distance.noise))
            }
        }
    }

    /// Writes the errors of an answer into its row; `velocity` is that of state 0. Values that cannot be compared are `None`.
    pub(super) fn compare(&self, answer: &dyn Density, velocity: Option<usize>, row: &mut OrderRow) -> Result<()> {
        let (truth, states) = (self.density(), answer.dimension());
        // ln p is known between samples too.
        let smooth = !matches!(self.kind, Kind::Simulation(_));
        let relative = |of: &dyn Fn(&dyn Density) -> Result<Estimate>| {
            let error = of(answer).ok()?.value / of(truth).ok()?.value - 1.0;
            error.is_finite().then_some(error)
        };
        let mean_square = |state: usize| relative(&|density| density.moment(&of_one(states, state, 2)));
        // A simulation has only the levels that it was given.
        let level = if smooth { truth.moment(&of_one(states, 0, 1))?.value } else { 0.0 };
        let l1 = Some(self.l1(answer)?).filter(|l1| l1.value.is_finite());
        row.l1 = l1.map(|l1| l1.value);
        row.l1_error = l1.map(|l1| l1.error);
        if smooth && states <= 2 {
            let tail = compare::log_ratio(answer, truth, LEVEL).ok().map(|tail| tail.value);
            row.tail = tail.filter(|tail| tail.is_finite());
        }
        row.mean_square_x = mean_square(0);
        row.mean_square_v = mean_square(1);
        row.rate = velocity.and_then(|velocity| {
            let crossing = Crossing { velocity, ..Crossing::upward(level) };
            relative(&|density| density.flux(crossing, 1))
        });
        Ok(())
    }
}
