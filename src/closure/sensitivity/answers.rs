//! What a derivative answers, each with its error.

use super::carried::Carried;
use super::on_states::OnStates;
use super::slope::Slope;
use crate::checks::{coordinate, dimension, finite, point};
use crate::closure::density::ClosureDensity;
use crate::closure::density::content::Integrals;
use crate::closure::{SOLVED, UNRELIABLE};
use crate::density::{Crossing, Density};
use crate::error::Result;
use crate::estimate::Estimate;
use crate::numerics::Rule;
use crate::polynomial::power;
use crate::sensitivity::Sensitivity;
use crate::states::States;
use std::sync::Arc;

/// The step of the differences that are the slope of an integrand, relative to the domain's width: the errors by its square and by
/// rounding over it are some 1e-10.
const STEP: f64 = 1e-5;
/// The step of the differences that are the slope of a section of a density, which is a sum over draws, relative to the domain's
/// width: the error by its square is some tenths of a percent.
const WIDE_STEP: f64 = 5e-3;
/// Gauss nodes from a level to the edge of the domain for the derivative of the probability that a state exceeds it.
const TAIL_NODES: usize = 80;

/// The derivative ∂p/∂θ of a closure's density by a parameter θ, and of every answer that it gives.
///
/// ∂Q/∂θ is a polynomial of the closure's order; next to walls it has the functions that Q has there, and the derivative of the
/// singular part. With the offset of a wall the density moves: its nodes, its domain and the functions of Q. Its errors are the
/// distances from the derivative of the reference, the solution of the moment equations of a higher degree. Relative to ∫|p′| they
/// are some 2 to 12 times as large as those of the density relative to 1. Next to walls with r < 1 errors of moments, a few 1e-6,
/// were up to 3 times these distances, and 8 times by the restitution: both solutions have the same singular functions. Under Poisson
/// impulses both are those of a process that does not jump out of the domain, and errors of second moments, some 0.4 % of them at n = 8,
/// were up to 4 times the estimated ones, which have the part of ∂p/∂θ that lies beyond.
///
/// In three states and more means and exceedances are those of the pilot's states, with standard errors, to which exceedances add
/// the distance from those of p̃′: ∂ ln p/∂θ ≈ s = Σ d′_l ψ_l with Σ_l E\[ψ_l 𝓖ψ_k\] d′_l = −E\[𝓖′ψ_k\] for polynomials ψ, so
/// that dE g/dθ = E\[g s\], whose error is the product of those of s and of the solution for g. Next to walls, where impacts of
/// the rate ν take ψ₋ to ψ₊, ν E\[ψ_l₋ (ψ_k₊ − ψ_k₋)\] joins the matrix and ν E\[∇ψ_k₊·∂x₊/∂r r′\] the right side; with the
/// offset of a wall displacements move along by x_i′ = η_i(x_i), which adds E\[Σ η_i ∂_i g\]; and s has beside the polynomials
/// how the singular part of ln p moves with r and with the noise at the wall. Of the impact rate the slow impacts are known less
/// well than means: what the two highest degrees of ψ change is a part of its error, and was half of it by r = 0.8 behind a
/// filter. Other answers are those of the exponential polynomial whose moments have these derivatives.
#[derive(Clone, Debug)]
pub struct ClosureSensitivity {
    pub(super) density: ClosureDensity,
    pub(super) parameter: String,
    /// The derivative of Q, with a constant that makes the derivative of the density one of a density.
    pub(super) slope: Slope,
    /// The derivatives of p̃ and of the reference at the density's nodes, times the weights, in the coordinate in which walls stand
    /// still,
    pub(super) masses: Vec<[f64; 2]>,
    /// and what they have beside at fixed states.
    pub(super) carried: Carried,
    /// The derivative of the impact rate, where there are walls.
    pub(super) impacts: Option<Estimate>,
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

impl Sensitivity for ClosureSensitivity {
    fn parameter(&self) -> &str {
        &self.parameter
    }

    fn density(&self) -> &dyn Density {
        &self.density
    }

    fn relative(&self, x: &[f64]) -> Result<f64> {
        point(x, self.density.dimension())?;
        let exponent = self.density.exponent();
        let displaced = self.on_states.as_ref().map_or(0.0, |states| states.displaced.value(exponent, x));
        Ok(self.at(x) + self.carried.value(exponent, x) + displaced)
    }

    fn pdf(&self, x: &[f64]) -> Result<Estimate> {
        let (relative, density) = (self.relative(x)?, self.density.pdf(x)?);
        Ok(self.shared(relative * density.value))
    }

    fn size(&self) -> f64 {
        match &self.on_states {
            Some(states) => states.size,
            None if self.in_many_states() => self.under_density(&|x| self.at(x).abs()).value,
            None => self.at_fixed_states().map(|[own, _]| own.abs()).sum(),
        }
    }

    fn l1_estimate(&self) -> f64 {
        if let Some(states) = &self.on_states {
            return states.l1_estimate;
        }
        let apart: f64 = self.at_fixed_states().map(|[own, other]| (own - other).abs()).sum();
        let doubt: f64 = self.whole.masses.iter().map(|[own, below]| (own - below).abs()).sum();
        apart.hypot(doubt).hypot(self.beyond(&|_| 1.0))
    }

    fn warning(&self) -> Option<&str> {
        let large = self.l1_estimate() > UNRELIABLE * self.size().max(SOLVED);
        let own = large.then_some("the estimated error of the derivative is large: take a higher order");
        let few = self.on_states.as_ref().is_some_and(|states| states.change() > UNRELIABLE * states.size);
        let few =
            few.then_some("the derivative still changes with the degree on the pilot's states: take more of them");
        self.density.warning().or(few).or(own)
    }

    fn expectation(&self, g: &(dyn Fn(&[f64]) -> f64 + Sync)) -> Estimate {
        if let Some(states) = &self.on_states {
            let steps = self.steps(STEP);
            let slope = |x: &[f64]| states.displaced.slope(g, x, &steps);
            return states.expectation(g, states.displaced.moves().then_some(&slope));
        }
        if self.in_many_states() {
            return self.under_density(&|x| g(x) * self.at(x));
        }
        let still = self.mean(g);
        if !self.carried.moves() {
            return still;
        }
        let step = self.steps(STEP)[0];
        let at = |x: &[f64], step: f64| g(&[x[0] + step, x[1]]);
        let slope = |x: &[f64]| (at(x, step) - at(x, -step)) / (2.0 * step);
        still.plus(self.carried.mean(&self.density, slope))
    }

    fn moment(&self, powers: &[u32]) -> Result<Estimate> {
        dimension("a list of powers", powers.len(), self.density.dimension())?;
        if self.in_many_states() {
            return Ok(self.expectation(&|x| power(x, powers)));
        }
        let still = self.mean(&|x| power(x, powers));
        if !self.carried.moves() || powers[0] == 0 {
            return Ok(still);
        }
        let (factor, lower) = (f64::from(powers[0]), [powers[0] - 1, powers[1]]);
        Ok(still.plus(self.carried.mean(&self.density, |x| factor * power(x, &lower))))
    }

    fn exceedance(&self, state: usize, level: f64) -> Result<Estimate> {
        coordinate("the state of an exceedance", state, level, self.density.dimension())?;
        if self.in_many_states() {
            let beyond = |x: &[f64]| f64::from(u8::from(x[state] > level));
            let own = self.under_density(&|x| beyond(x) * self.at(x));
            // No polynomial of a low degree follows a step: the distance from p̃′ is an error beside that of chance.
            let still = self.on_states.as_ref().map_or(own, |states| {
                let found = states.expectation(&beyond, None);
                Estimate::new(found.value, found.error.hypot(found.value - own.value))
            });
            let rate = self.displaced(state, level);
            let through =
                if rate == 0.0 { Estimate::exact(0.0) } else { self.density.marginal(state, level)?.scaled(rate) };
            return Ok(still.plus(through));
        }
        let [low, high] = self.density.bounds()[state];
        if level <= low || level >= high {
            return Ok(Estimate::new(0.0, self.density.truncated_mass()));
        }
        let rule = Rule::legendre(TAIL_NODES).on(level, high);
        let sections = rule.iter().map(|(x, w)| self.shared(w * self.sum_over(state, x, |x| self.at(x))));
        let beyond = sections.fold(Estimate::exact(0.0), Estimate::plus);
        // What is carried over the level by a wall that moves.
        if state == 0 && self.carried.moves() {
            let through = self.sum_over(0, level, |x| self.carried.rate(x[0]));
            return Ok(beyond.plus(self.shared(through)));
        }
        Ok(beyond)
    }

    fn marginal(&self, state: usize, x: f64) -> Result<Estimate> {
        coordinate("the state of a marginal", state, x, self.density.dimension())?;
        if self.in_many_states() {
            return self.drawn(state, x, |_| 1.0);
        }
        // Over the displacement the integral follows the walls.
        let fixed = |x: &[f64]| if state == 0 { self.carried.value(self.density.exponent(), x) } else { 0.0 };
        Ok(self.shared(self.sum_over(state, x, |x| self.at(x) + fixed(x))))
    }

    fn upcrossing_rate(&self, level: f64) -> Result<Estimate> {
        let [displacement, velocity] = Crossing::upward(finite("level", level)?).states(self.density.dimension())?;
        if self.in_many_states() {
            return self.drawn(displacement, level, |x| x[velocity].max(0.0));
        }
        let fixed = |x: &[f64]| self.at(x) + self.carried.value(self.density.exponent(), x);
        Ok(self.shared(self.sum_over(displacement, level, |x| x[velocity].max(0.0) * fixed(x))))
    }

    fn impact_rate(&self) -> Option<Estimate> {
        self.impacts.map(|rate| Estimate::new(rate.value, rate.error + self.rounding()))
    }
}

impl ClosureSensitivity {
    /// ∫ |g ∂p/∂θ| dx beyond the domain under impulses, if it falls on outwards at the rate that it has at the edge: tails are heavier
    /// there than under white noise, and the equations are those of a process that does not jump out.
    fn beyond(&self, g: &dyn Fn(&[f64]) -> f64) -> f64 {
        let struck = self.density.problem().is_ok_and(|problem| !problem.impulses().is_empty());
        let log = |x: &[f64]| self.density.exponent().value(x) + (g(x) * self.at(x)).abs().ln();
        if struck { self.density.content.domain.mass_beyond(log) } else { 0.0 }
    }

    /// The same in the coordinate in which walls stand still.
    fn mean(&self, g: &dyn Fn(&[f64]) -> f64) -> Estimate {
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
        let error = (sum - other).abs().max(apart).max(change.abs()) + self.beyond(g);
        Estimate::new(sum, error + self.rounding() * square.sqrt())
    }

    /// The derivatives of p̃ and of the reference at the density's nodes, times the weights.
    fn at_fixed_states(&self) -> impl Iterator<Item = [f64; 2]> {
        let carried = self.carried.at_nodes.iter().copied().chain(std::iter::repeat([0.0; 2]));
        let all = self.masses.iter().zip(&self.density.masses).zip(carried);
        all.map(|((moving, masses), carried)| [0, 1].map(|k| moving[k] + carried[k] * masses[k]))
    }

    fn in_many_states(&self) -> bool {
        self.density.dimension() > 2
    }

    /// ∫ g p dx in three states and more.
    fn under_density(&self, g: &(dyn Fn(&[f64]) -> f64 + Sync)) -> Estimate {
        self.density.expectation(g).unwrap_or(Estimate::new(f64::NAN, f64::INFINITY))
    }

    /// ∫ g ∂p/∂θ dx over all states but one, in three states and more. What walls carry along is −∂_x (η ∫ g p dx), whatever of the
    /// other states moves.
    fn drawn(&self, state: usize, x: f64, g: impl Fn(&[f64]) -> f64 + Sync) -> Result<Estimate> {
        let found = self.density.section(state, x, |x| g(x) * self.at(x))?;
        let step = self.steps(WIDE_STEP)[state];
        let through = |x: f64| -> Result<f64> {
            let rate = self.displaced(state, x);
            Ok(if rate == 0.0 { 0.0 } else { rate * self.density.section(state, x, &g)?.value })
        };
        let carried = (through(x - step)? - through(x + step)?) / (2.0 * step);
        let shared = self.shared(found.value.abs() + carried.abs());
        Ok(Estimate::new(found.value + carried, found.error.hypot(shared.error)))
    }

    /// The rate at which walls carry a state along, in three states and more.
    fn displaced(&self, state: usize, x: f64) -> f64 {
        self.on_states.as_ref().map_or(0.0, |states| states.displaced.rate(state, x))
    }

    /// A share of the domain's width in each state.
    fn steps(&self, share: f64) -> Vec<f64> {
        self.density.bounds().iter().map(|[low, high]| share * (high - low)).collect()
    }

    /// (∂p/∂θ)/p in the coordinate in which walls stand still.
    fn at(&self, x: &[f64]) -> f64 {
        self.slope.value(x)
    }

    /// ∫ g p dx over the other state.
    fn sum_over(&self, state: usize, x: f64, g: impl Fn(&[f64]) -> f64) -> f64 {
        let Integrals::Panels { lines, .. } = &self.density.content.integrals else { return 0.0 };
        let mut at = vec![0.0; lines.len()];
        at[state] = x;
        let value = |at: &[f64], w: f64| {
            let inside = self.density.content.domain.contains(at);
            if inside { w * g(at) * self.density.exponent().value(at).exp() } else { 0.0 }
        };
        if lines.len() == 1 {
            return value(&at, 1.0);
        }
        let other = usize::from(state == 0);
        let sum = lines[other].iter().map(|(t, w)| {
            at[other] = t;
            value(&at, w)
        });
        sum.sum()
    }

    /// A value with its error by that of the whole derivative, where nothing better is known.
    fn shared(&self, value: f64) -> Estimate {
        let share = self.l1_estimate() / self.size().max(f64::MIN_POSITIVE) + self.rounding();
        Estimate::new(value, value.abs() * share)
    }

    fn rounding(&self) -> f64 {
        SOLVED * self.size().max(1.0)
    }
}
