//! Derivatives where the pilot's states carry the density: no nodes are needed, nor a simulation for each parameter.
//!
//! - `walk`: functions and their images along the pilot's trajectories;
//! - `equations`: the Galerkin equations there, their solutions, and means with standard errors;
//! - `fit`: the exponential polynomial's part.

mod equations;
mod fit;
mod walk;

use super::Sensitivity;
use super::exact::Newton;
use super::slope::Slope;
use crate::closure::candidates::Origin;
use crate::closure::density::ClosureDensity;
use crate::closure::density::exponent::Exponent;
use crate::closure::dynamics::Dynamics;
use crate::closure::space::Functions;
use crate::closure::tuning;
use crate::density::Density;
use crate::error::{Error, Result};
use crate::estimate::Estimate;
use crate::fokker_planck::{FokkerPlanck, ImpulseTerm};
use crate::problem::{Problem, Symmetry};
use crate::states::States;
use equations::{Ground, Masses, StateEquations};
use fit::Likely;
use rayon::prelude::*;
use std::fmt;
use std::sync::Arc;

/// The derivative of a density that the pilot's states carry.
pub(super) struct OnStates {
    motion: Arc<Dynamics>,
    symmetry: Symmetry,
    masses: Masses,
    /// The estimate of ∫ |∂p̃/∂θ − ∂p/∂θ| dx.
    pub(super) l1_estimate: f64,
}

impl fmt::Debug for OnStates {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("OnStates").field("l1_estimate", &self.l1_estimate).finish_non_exhaustive()
    }
}

impl ClosureDensity {
    /// The derivatives in three states and more.
    pub(super) fn sensitivities_on_states(&self, problem: &Problem, parameters: &[&str]) -> Result<Vec<Sensitivity>> {
        let operators =
            parameters.iter().map(|parameter| problem.derivative(&[parameter])).collect::<Result<Vec<_>>>()?;
        if self.candidates()[0].origin == Origin::Exact {
            return self.exact_sensitivities(problem, parameters, &operators);
        }
        let curved = |operator: &FokkerPlanck| {
            operator.impulse_terms().iter().flat_map(ImpulseTerm::fields).any(|(_, h)| h.degree() > 1)
        };
        if operators.iter().any(curved) {
            let what = "derivatives by parameters of impulses that depend on the states by more than the first degree, in three \
                        states and more";
            let remedy = "take differences of two densities, at `Problem::with_parameter`";
            return Err(Error::NotServed { method: "closure", what, remedy });
        }
        let reason = "the pilot's states are too few for the equations of the derivative: take more `pilot_states`";
        let few = || Error::NotClosed { order: self.provenance().order.unwrap_or(0), reason };
        let motion = self.origin()?;
        let states = &motion.pilot().ok_or_else(few)?.states;
        let ladder = Ground::ladder(motion, &operators).ok_or_else(few)?;
        let of_degree = |ground: &Ground| StateEquations::new(ground, motion)?.derivatives(&operators);
        let mut degrees = ladder.iter().filter_map(of_degree).map(|found| (doubt(states, &found.0), found));
        let (highest, found) = degrees.next().ok_or_else(few)?;
        // Where functions of the highest degree are all but dependent on each other in the equations, their noise is large.
        let lower = degrees.next().filter(|(lower, _)| lower + tuning::sensitivity::NOISIER < highest);
        let (found, weights) = lower.map_or(found, |(_, lower)| lower);
        let symmetry = &ladder[0].symmetry;
        let (points, masses) = self.carrying_nodes().ok_or(self.failed())?;
        let likely = Likely::new(self.polynomials(symmetry), &points, &masses).ok_or(self.failed())?;
        let one = |(name, masses): (&&str, Masses)| {
            let slope = likely.slope(states, &masses.own).ok_or(self.failed())?;
            let own: Vec<f64> = slope.values(states).into_iter().zip(&weights).map(|(value, w)| value * w).collect();
            let l1_estimate = distance(&own, &masses.own).hypot(self.l1_estimate() * size(&masses.own));
            let symmetry = symmetry.clone();
            let on_states = OnStates { motion: Arc::clone(motion), symmetry, masses, l1_estimate };
            Ok(Sensitivity { on_states: Some(Arc::new(on_states)), ..self.moving_by(name, slope) })
        };
        parameters.iter().zip(found).map(one).collect()
    }

    /// Those of an exact density: its Galerkin equations hold on any nodes.
    fn exact_sensitivities(
        &self,
        problem: &Problem,
        parameters: &[&str],
        operators: &[FokkerPlanck],
    ) -> Result<Vec<Sensitivity>> {
        let symmetry = operators.iter().fold(problem.symmetry(), Symmetry::and_of);
        let (states, mut masses) = self.carrying_nodes().ok_or(self.failed())?;
        let kept = states.len().min(tuning::sensitivity::DRAWS);
        masses.truncate(kept);
        let nodes = States::from_values(states.dimension(), states.values()[..kept * states.dimension()].to_vec());
        let masses = masses.into_iter().map(|mass| [mass; 2]).collect();
        let on_nodes = ClosureDensity { nodes, masses, ..self.clone() };
        let space = Functions::Polynomials(self.polynomials(&symmetry));
        let newton = Newton::new(&on_nodes, problem, space, &[]).ok_or(self.failed())?;
        let one = |(name, operator): (&&str, &FokkerPlanck)| {
            let mut slope = newton.slope(operator).ok_or(self.failed())?;
            slope.constant -= self.expectation(&|x| slope.value(x))?.value;
            Ok(self.moving_by(name, slope))
        };
        parameters.iter().zip(operators).map(one).collect()
    }

    fn moving_by(&self, name: &str, slope: Exponent) -> Sensitivity {
        let slope = Slope { regular: slope, singular: Vec::new() };
        self.moving_with(vec![name.to_owned()], slope, [Vec::new(), Vec::new()], None)
    }

    /// States with weights that sum to about 1, on which integrals of the density are taken.
    fn carrying_nodes(&self) -> Option<(States, Vec<f64>)> {
        if self.nodes.is_empty() {
            return self.weighted_states();
        }
        Some((self.nodes.clone(), self.masses.iter().map(|masses| masses[0]).collect()))
    }
}

impl OnStates {
    /// ∫ |∂p/∂θ| dx.
    pub(super) fn size(&self) -> f64 {
        size(&self.masses.own)
    }

    /// ∫ of what the functions of the two highest degrees change.
    pub(super) fn change(&self) -> f64 {
        distance(&self.masses.own, &self.masses.below)
    }

    /// dE g/dθ, with the standard error of a jackknife over lots of trajectories (J. W. Tukey, 1958).
    pub(super) fn expectation(&self, g: &(dyn Fn(&[f64]) -> f64 + Sync)) -> Estimate {
        let Some(pilot) = self.motion.pilot() else { return Estimate::new(f64::NAN, f64::INFINITY) };
        // Every state stands for its mirror images too.
        let at = |x: &[f64]| self.symmetry.images(x).map(|image| g(&image)).sum::<f64>() / self.symmetry.count() as f64;
        let values: Vec<f64> = pilot.states.par_iter().map(at).collect();
        let value = values.iter().zip(&self.masses.own).map(|(g, mass)| g * mass).sum();
        Estimate::new(value, jackknife(&values, &self.masses))
    }
}

/// The mean logarithm of the standard errors of the derivatives of all mean squares.
fn doubt(states: &States, found: &[Masses]) -> f64 {
    let errors = (0..states.dimension()).flat_map(|i| {
        let squares: Vec<f64> = states.iter().map(|x| x[i] * x[i]).collect();
        found.iter().map(move |masses| jackknife(&squares, masses))
    });
    let errors: Vec<f64> = errors.collect();
    errors.iter().map(|error| error.max(f64::MIN_POSITIVE).ln()).sum::<f64>() / errors.len().max(1) as f64
}

/// The standard error of the derivative of a mean, given the values at the states, by what leaving out each lot changes.
fn jackknife(values: &[f64], masses: &Masses) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let change =
        |changes: &Vec<f32>| values.iter().zip(changes).map(|(g, mass)| (g - mean) * f64::from(*mass)).sum::<f64>();
    let changes: Vec<f64> = masses.changes.par_iter().map(change).collect();
    let count = changes.len() as f64;
    ((count - 1.0) / count * changes.iter().map(|change| change * change).sum::<f64>()).sqrt()
}

fn distance(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(a, b)| (a - b).abs()).sum()
}

fn size(masses: &[f64]) -> f64 {
    masses.iter().map(|mass| mass.abs()).sum()
}
