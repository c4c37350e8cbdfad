//! What a derivative answers, each with its error.

use super::on_states::OnStates;
use crate::checks::{coordinate, dimension, finite, point};
use crate::closure::density::ClosureDensity;
use crate::closure::density::content::Integrals;
use crate::closure::density::exponent::Exponent;
use crate::closure::tuning;
use crate::density::{Crossing, Density};
use crate::error::Result;
use crate::estimate::Estimate;
use crate::numerics::Rule;
use crate::polynomial::power;
use crate::states::States;
use std::sync::Arc;

/// The derivative ∂p/∂θ of a closure's density by a parameter θ, and of every answer that it gives; or the second derivative
/// by two.
///
/// ∂Q/∂θ is a polynomial of the closure's order. Its errors are the distances from the derivative of the reference, the solution
/// of the moment equations of a higher degree. Relative to ∫|p′| they are some 2 to 12 times as large as those of the density
/// relative to 1.
#[derive(Clone, Debug)]
pub struct Sensitivity {
    pub(super) density: ClosureDensity,
    pub(super) parameters: Vec<String>,
    /// The derivative of Q, with a constant that makes the derivative of the density one of a density.
    pub(super) slope: Exponent,
    /// The first derivatives of Q, whose product is a part of the second one of exp(Q).
    pub(super) product: Option<[Exponent; 2]>,
    /// The derivatives of p̃ and of the reference at the density's nodes, times the weights.
    pub(super) masses: Vec<[f64; 2]>,
    /// The reference's on its whole domain; nothing where the density is exact.
    pub(super) whole: Whole,
    /// In three states and more, where the density is not exact.
    pub(super) on_states: Option<Arc<OnStates>>,
}

/// Derivatives at nodes, times their weights, by the equations of the highest degree and by those of the one below it.
#[derive(Clone, Debug)]
pub(super) struct Whole {
    pub(super) points: States,
    pub(super) masses: Vec<[f64; 2]>,
}

impl Sensitivity {
    /// The name of the parameter, or of both.
    pub fn parameters(&self) -> &[String] {
        &self.parameters
    }

    /// The density that this is a derivative of.
    pub fn density(&self) -> &ClosureDensity {
        &self.density
    }

    /// (∂p/∂θ)/p at a state, which is ∂ ln p/∂θ; by two parameters (∂²p/∂θ∂φ)/p. Its mean under p is zero.
    ///
    /// # Errors
    /// [`Error::Dimension`](crate::Error::Dimension) if it is no state of the problem.
    pub fn relative(&self, x: &[f64]) -> Result<f64> {
        point(x, self.density.dimension())?;
        Ok(self.at(x))
    }

    /// ∫ |∂p/∂θ| dx.
    pub fn size(&self) -> f64 {
        match &self.on_states {
            Some(states) => states.size(),
            None if self.in_many_states() => self.under_density(&|x| self.at(x).abs()).value,
            None => self.masses.iter().map(|[own, _]| own.abs()).sum(),
        }
    }

    /// The estimate of ∫ |∂p̃/∂θ − ∂p/∂θ| dx: the distance from the derivative of the reference, and that derivative's own
    /// error. It is to be compared with [`Sensitivity::size`].
    pub fn l1_estimate(&self) -> f64 {
        if let Some(states) = &self.on_states {
            return states.l1_estimate;
        }
        let apart: f64 = self.masses.iter().map(|[own, other]| (own - other).abs()).sum();
        let doubt: f64 = self.whole.masses.iter().map(|[own, below]| (own - below).abs()).sum();
        apart.hypot(doubt)
    }

    /// Why the derivative should not be relied on, if there is a reason: the density's own, or its own estimated error.
    pub fn warning(&self) -> Option<&str> {
        let large = self.l1_estimate() > tuning::UNRELIABLE * self.size().max(tuning::SOLVED);
        let own = large.then_some("the estimated error of the derivative is large: take a higher order");
        let few = self.on_states.as_ref().is_some_and(|states| states.change() > tuning::UNRELIABLE * states.size());
        let few =
            few.then_some("the derivative is still changing with the degree on the pilot's states: take more of them");
        self.density.warning().or(few).or(own)
    }

    /// dE g/dθ, the sum over the nodes of the closure.
    pub fn expectation(&self, g: &(dyn Fn(&[f64]) -> f64 + Sync)) -> Estimate {
        if let Some(states) = &self.on_states {
            return states.expectation(g);
        }
        if self.in_many_states() {
            return self.under_density(&|x| g(x) * self.at(x));
        }
        let (mut sum, mut other, mut square) = (0.0, 0.0, 0.0);
        for ((x, [own, reference]), masses) in self.density.nodes.iter().zip(&self.masses).zip(&self.density.masses) {
            let value = g(x);
            sum += value * own;
            other += value * reference;
            square += value * value * masses[0];
        }
        // What lies between the edges of the two domains counts as an error, and what the highest degree changes.
        let (mut whole, mut change) = (0.0, 0.0);
        for (x, [own, below]) in self.whole.points.iter().zip(&self.whole.masses) {
            let value = g(x);
            whole += value * own;
            change += value * (own - below);
        }
        let apart = if self.whole.masses.is_empty() { 0.0 } else { (sum - whole).abs() };
        let error = (sum - other).abs().max(apart).max(change.abs());
        Estimate::new(sum, error + self.rounding() * square.sqrt())
    }

    /// The derivative of a raw moment, dE\[x₁^p₁ ⋯ x_n^p_n\]/dθ.
    ///
    /// # Errors
    /// [`Error::Dimension`](crate::Error::Dimension) unless there is a power for each state.
    pub fn moment(&self, powers: &[u32]) -> Result<Estimate> {
        dimension("a list of powers", powers.len(), self.density.dimension())?;
        Ok(self.expectation(&|x| power(x, powers)))
    }

    /// The derivative of P(x_i > `level`) for a state i.
    ///
    /// # Errors
    /// [`Error::Dimension`](crate::Error::Dimension) if there is no such state, [`Error::OutOfRange`](crate::Error::OutOfRange) for a level that is not finite.
    pub fn exceedance(&self, state: usize, level: f64) -> Result<Estimate> {
        coordinate("the state of an exceedance", state, level, self.density.dimension())?;
        if self.in_many_states() {
            return Ok(self.expectation(&|x| f64::from(u8::from(x[state] > level))));
        }
        let [low, high] = self.density.bounds()[state];
        if level >= high {
            return Ok(Estimate::new(0.0, self.density.truncated_mass()));
        }
        let rule = Rule::legendre(tuning::sensitivity::TAIL_NODES).on(level.max(low), high);
        let sections = rule.iter().map(|(x, w)| self.section(state, x, |_| w));
        Ok(sections.fold(Estimate::exact(0.0), Estimate::plus))
    }

    /// The derivative of the marginal density of a state.
    ///
    /// # Errors
    /// As [`Sensitivity::exceedance`].
    pub fn marginal(&self, state: usize, x: f64) -> Result<Estimate> {
        coordinate("the state of a marginal", state, x, self.density.dimension())?;
        Ok(self.section(state, x, |_| 1.0))
    }

    /// The derivative of the mean rate at which the displacement crosses a level upwards.
    ///
    /// # Errors
    /// [`Error::Dimension`](crate::Error::Dimension) in one state, [`Error::OutOfRange`](crate::Error::OutOfRange) for a level that is not finite.
    pub fn upcrossing_rate(&self, level: f64) -> Result<Estimate> {
        let [displacement, velocity] = Crossing::upward(finite("level", level)?).states(self.density.dimension())?;
        Ok(self.section(displacement, level, |x| x[velocity].max(0.0)))
    }

    fn in_many_states(&self) -> bool {
        self.density.dimension() > 2
    }

    /// ∫ g p dx.
    fn under_density(&self, g: &(dyn Fn(&[f64]) -> f64 + Sync)) -> Estimate {
        self.density.expectation(g).unwrap_or(Estimate::new(f64::NAN, f64::INFINITY))
    }

    fn at(&self, x: &[f64]) -> f64 {
        let product = self.product.as_ref().map_or(0.0, |[k, l]| k.value(x) * l.value(x));
        self.slope.value(x) + product
    }

    /// ∫ g ∂p/∂θ dx over the other state, with its error by that of the whole derivative where nothing better is known.
    fn section(&self, state: usize, x: f64, g: impl Fn(&[f64]) -> f64 + Sync) -> Estimate {
        let relative = self.l1_estimate() / self.size().max(f64::MIN_POSITIVE);
        let Integrals::Panels { lines, .. } = &self.density.content.integrals else {
            let drawn = self.density.section(state, x, |x| g(x) * self.at(x));
            let drawn = drawn.unwrap_or(Estimate::new(f64::NAN, f64::INFINITY));
            return Estimate::new(drawn.value, drawn.error.hypot(drawn.value * relative));
        };
        let mut at = vec![0.0; lines.len()];
        at[state] = x;
        let mut sum = 0.0;
        let mut add = |at: &[f64], w: f64| {
            if self.density.content.domain.contains(at) {
                sum += w * g(at) * self.density.exponent().value(at).exp() * self.at(at);
            }
        };
        if lines.len() == 1 {
            add(&at, 1.0);
        } else {
            let other = usize::from(state == 0);
            for (t, w) in lines[other].iter() {
                at[other] = t;
                add(&at, w);
            }
        }
        Estimate::new(sum, sum.abs() * (relative + self.rounding()))
    }

    fn rounding(&self) -> f64 {
        tuning::SOLVED * self.size().max(1.0)
    }
}
