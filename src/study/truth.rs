use super::row::OrderRow;
use crate::closure::{Closure, Weight};
use crate::compare;
use crate::density::{Crossing, Density};
use crate::error::Result;
use crate::estimate::Estimate;
use crate::polynomial::of_one;
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

/// The level, relative to the peak, down to which tails are compared.
const LEVEL: f64 = 1e-5;

/// The density that those of one case are compared with: an exact one, a solution on a grid, or a simulation's.
pub(super) struct Truth {
    density: Box<dyn Density>,
    /// The distances of the closest exponential polynomials, by their orders.
    closest: Mutex<BTreeMap<u32, Option<f64>>>,
}

impl Truth {
    pub(super) fn new(density: Box<dyn Density>) -> Self {
        Truth { density, closest: Mutex::new(BTreeMap::new()) }
    }

    /// Whether it was made of samples: ln p is not known between them, and their noise is in every distance.
    fn is_sampled(&self) -> bool {
        self.density.evidence().sampled().is_some()
    }

    /// The distance of the closest exponential polynomial of an order; none where it is not known.
    pub(super) fn closest(&self, order: u32) -> Option<f64> {
        if self.is_sampled() || self.density.dimension() > 3 {
            return None;
        }
        let mut known = self.closest.lock().unwrap_or_else(PoisonError::into_inner);
        *known.entry(order).or_insert_with(|| {
            let fitted = Closure::new(order).weight(Weight::Density).fit(&*self.density);
            fitted.ok().map(|fitted| fitted.l1_estimate())
        })
    }

    /// Its description, in a few words.
    pub(super) fn text(&self) -> String {
        let provenance = self.density.provenance();
        match (provenance.samples, provenance.degree) {
            (Some(samples), _) if self.is_sampled() => {
                let (seed, step) = (provenance.seed.unwrap_or_default(), provenance.time_step.unwrap_or_default());
                format!("simulation of {samples} samples, seed {seed}, time step {step}")
            }
            (_, Some(degree)) => {
                let (unknowns, estimate) = (provenance.unknowns.unwrap_or_default(), self.density.l1_estimate());
                format!("grid of {unknowns} unknowns, degree {degree}, L1 error {estimate:.1e}")
            }
            _ => String::from("exact density"),
        }
    }

    /// ∫ |p − q| dx of an answer, with the error due to the truth's own error; from a simulation, the distance of the first state's
    /// marginal from the histogram.
    fn l1(&self, answer: &dyn Density) -> Result<Estimate> {
        if let Some(sampled) = self.density.evidence().sampled() {
            let distance = compare::with_bins(answer, 0, &sampled.bins(0)?)?;
            return Ok(Estimate::new(distance.l1, distance.noise));
        }
        let distance = compare::l1(answer, &*self.density)?;
        let own = self.density.provenance().l1_estimate.unwrap_or(0.0);
        Ok(Estimate::new(distance.value, distance.error.max(own)))
    }

    /// Writes the errors of an answer into its row; `velocity` is that of state 0. Values that cannot be compared are `None`.
    pub(super) fn compare(&self, answer: &dyn Density, velocity: Option<usize>, row: &mut OrderRow) -> Result<()> {
        let (truth, states) = (&*self.density, answer.dimension());
        // ln p is known between samples too.
        let smooth = !self.is_sampled();
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
