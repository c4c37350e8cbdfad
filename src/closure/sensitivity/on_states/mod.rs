//! Derivatives where the pilot's states carry the density: no nodes are needed, nor a simulation for each parameter.
//!
//! - `walk`: functions and their images along the pilot's trajectories;
//! - `equations`: the Galerkin equations there, and their solutions;
//! - `masses`: what these are on the states, and means with standard errors;
//! - `fit`: the exponential polynomial's part; `displaced`: how displacements move with walls.

mod displaced;
mod equations;
mod fit;
mod masses;
mod walk;

use super::Sensitivity;
use super::carried::{Along, Carried};
use super::exact::Newton;
use super::slope::Slope;
use crate::closure::candidates::Origin;
use crate::closure::density::ClosureDensity;
use crate::closure::density::exponent::Exponent;
use crate::closure::dynamics::Dynamics;
use crate::closure::space::Functions;
use crate::closure::tuning;
use crate::density::{CountedImpacts, Density};
use crate::error::{Error, Result};
use crate::estimate::Estimate;
use crate::fokker_planck::{FokkerPlanck, ImpulseTerm};
use crate::problem::{Problem, StillMotion, Symmetry};
use crate::states::States;
use displaced::Displaced;
use equations::{Ground, StateEquations};
use fit::Likely;
use masses::{Masses, doubt, jackknife};
use rayon::prelude::*;
use std::fmt;
use std::sync::Arc;

/// A function of the state that is averaged.
type Integrand<'a> = dyn Fn(&[f64]) -> f64 + Sync + 'a;

/// The derivative of a density that the pilot's states carry, in the coordinates in which walls stand still.
pub(super) struct OnStates {
    motion: Arc<Dynamics>,
    symmetry: Symmetry,
    masses: Masses,
    /// How displacements move with walls,
    pub(super) displaced: Displaced,
    /// and the density itself, where they do.
    density: Option<Arc<Masses>>,
    /// ∫ |∂p/∂θ| dx.
    pub(super) size: f64,
    /// The estimate of ∫ |∂p̃/∂θ − ∂p/∂θ| dx.
    pub(super) l1_estimate: f64,
}

impl fmt::Debug for OnStates {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("OnStates").field("l1_estimate", &self.l1_estimate).finish_non_exhaustive()
    }
}

/// Derivatives by the equations of the degree that serves them best, and the weights of the states.
struct Found {
    symmetry: Symmetry,
    masses: Vec<Masses>,
    density: Arc<Masses>,
}

impl ClosureDensity {
    /// The derivatives in three states and more.
    pub(super) fn sensitivities_on_states(&self, problem: &Problem, parameters: &[&str]) -> Result<Vec<Sensitivity>> {
        let along: Vec<StillMotion> =
            parameters.iter().map(|parameter| problem.motion(parameter)?.still(problem)).collect::<Result<_>>()?;
        if self.is_exact() && problem.walls().is_empty() {
            let symmetry = symmetry_of(problem, &along);
            let on_nodes = self.on_kept_nodes()?;
            let newton = self.newton(&on_nodes, problem, &symmetry)?;
            let one = |(name, motion): (&&str, &StillMotion)| {
                Ok(self.moving_by(&[name], (self.exact_slope(&newton, &motion.operator)?, None)))
            };
            return parameters.iter().zip(&along).map(one).collect();
        }
        let motion = self.origin()?;
        let Found { symmetry, masses, density } =
            self.on_states(motion, &along, |equations| equations.first(&along))?;
        let states = self.pilot_states(motion)?;
        let (points, measure) = self.carrying_nodes().ok_or(self.failed())?;
        let likely = Likely::new(self.functions_with(&symmetry), &points, &measure).ok_or(self.failed())?;
        let one = |((name, moving), masses): ((&&str, &StillMotion), Masses)| {
            let slope = likely.slope(states, masses.own()).ok_or(self.failed())?;
            let own = slope.values(states);
            let displaced = Displaced::new(&moving.shift);
            let impacts = self.impacts_on_states(problem, moving, &masses);
            let on_states = self.carried_by((motion, &symmetry), masses, &own, (&density, displaced));
            let found = self.moving_by(&[name], (slope, None));
            Ok(Sensitivity { on_states: Some(Arc::new(on_states)), impacts, ..found })
        };
        parameters.iter().zip(&along).zip(masses).map(one).collect()
    }

    /// The second derivative by two parameters in three states and more.
    pub(super) fn second_on_states(&self, problem: &Problem, parameters: [&str; 2]) -> Result<Sensitivity> {
        let [k, l] = parameters.map(|parameter| problem.derivative(&[parameter]));
        let along = [k?, l?, problem.derivative(&parameters)?].map(StillMotion::open);
        let [k, l, twice] = &along;
        if self.is_exact() {
            let symmetry = symmetry_of(problem, &along);
            let on_nodes = self.on_kept_nodes()?;
            let newton = self.newton(&on_nodes, problem, &symmetry)?;
            let [k, l, twice] = along.each_ref().map(|motion| &motion.operator);
            let slopes = [self.exact_slope(&newton, k)?, self.exact_slope(&newton, l)?];
            let mut slope = newton.second([k, l], twice, slopes.each_ref()).ok_or(self.failed())?;
            slope.constant -= self.expectation(&|x| slope.value(x) + slopes[0].value(x) * slopes[1].value(x))?.value;
            return Ok(self.moving_by(&parameters, (slope, Some(slopes))));
        }
        let motion = self.origin()?;
        let solve = |equations: &StateEquations<'_>| {
            let mut found = equations.first(&along[..2])?;
            found.push(equations.second([k, l], twice, [&found[0], &found[1]])?);
            Some(found)
        };
        let Found { symmetry, mut masses, density } = self.on_states(motion, &along, solve)?;
        let states = self.pilot_states(motion)?;
        let (points, measure) = self.carrying_nodes().ok_or(self.failed())?;
        let likely = Likely::new(self.functions_with(&symmetry), &points, &measure).ok_or(self.failed())?;
        let second = masses.pop().ok_or(self.failed())?;
        let [k, l] = [0, 1].map(|j| likely.slope(states, masses[j].own()).ok_or(self.failed()));
        let slopes = [k?, l?];
        let slope = likely.second(states, second.own(), slopes.each_ref()).ok_or(self.failed())?;
        let [k, l] = slopes.each_ref().map(|slope| slope.values(states));
        let own: Vec<f64> = slope.values(states).iter().zip(k.iter().zip(&l)).map(|(q, (k, l))| q + k * l).collect();
        let on_states = self.carried_by((motion, &symmetry), second, &own, (&density, Displaced::new(&[])));
        Ok(Sensitivity { on_states: Some(Arc::new(on_states)), ..self.moving_by(&parameters, (slope, Some(slopes))) })
    }

    fn is_exact(&self) -> bool {
        self.candidates()[0].origin == Origin::Exact
    }

    /// What the equations of the highest degree give along some derivatives of the operator, or those of two degrees less if the
    /// highest are [noisier](tuning::sensitivity::NOISIER) than that: where functions are all but dependent on each other in the equations, their noise is large.
    fn on_states(
        &self,
        motion: &Dynamics,
        along: &[StillMotion],
        solve: impl Fn(&StateEquations<'_>) -> Option<Vec<Masses>>,
    ) -> Result<Found> {
        let curved = |motion: &StillMotion| {
            motion.operator.impulse_terms().iter().flat_map(ImpulseTerm::fields).any(|(_, h)| h.degree() > 1)
        };
        if along.iter().any(curved) {
            let what = "derivatives by parameters of impulses that depend on the states by more than the first degree, in three \
                        states and more";
            let remedy = "take differences of two densities, at `Problem::with_parameter`";
            return Err(Error::NotServed { method: "closure", what, remedy });
        }
        let states = self.pilot_states(motion)?;
        let ladder = Ground::ladder(motion, along).ok_or(self.too_few())?;
        let of_degree = |ground: &Ground| {
            let equations = StateEquations::new(ground, motion)?;
            let masses = solve(&equations)?;
            let found = Found { symmetry: ground.symmetry.clone(), masses, density: Arc::new(equations.density()) };
            Some((doubt(states, &found.masses), found))
        };
        let mut degrees = ladder.iter().filter_map(of_degree);
        let (highest, found) = degrees.next().ok_or(self.too_few())?;
        let lower = degrees.next().filter(|(lower, _)| lower + tuning::sensitivity::NOISIER < highest);
        Ok(lower.map_or(found, |(_, lower)| lower))
    }

    fn pilot_states<'a>(&self, motion: &'a Dynamics) -> Result<&'a States> {
        Ok(&motion.pilot().ok_or(self.too_few())?.states)
    }

    fn too_few(&self) -> Error {
        let reason = "the pilot's states are too few for the equations of the derivative: take more `pilot_states`";
        Error::NotClosed { order: self.provenance().order.unwrap_or(0), reason }
    }

    /// A derivative on the pilot's states, with its distance from that of the exponential polynomial, given relative to the density.
    fn carried_by(
        &self,
        (motion, symmetry): (&Arc<Dynamics>, &Symmetry),
        masses: Masses,
        own: &[f64],
        (density, displaced): (&Arc<Masses>, Displaced),
    ) -> OnStates {
        let own: Vec<f64> = own.iter().zip(density.own()).map(|(value, w)| value * w).collect();
        let size = match motion.pilot().filter(|_| displaced.moves()) {
            Some(pilot) => {
                let fixed = pilot.states.iter().map(|x| displaced.value(self.exponent(), x)).zip(density.own());
                masses.distance(&fixed.map(|(value, w)| -value * w).collect::<Vec<_>>())
            }
            None => masses.size(),
        };
        let l1_estimate = masses.distance(&own).hypot(self.l1_estimate() * size);
        let density = displaced.moves().then(|| Arc::clone(density));
        let (motion, symmetry) = (Arc::clone(motion), symmetry.clone());
        OnStates { motion, symmetry, masses, displaced, density, size, l1_estimate }
    }

    /// The derivative of the impact rate, wherever walls move: the rate of impacts in the coordinates in which they stand still,
    /// less that by which these stretch.
    fn impacts_on_states(&self, problem: &Problem, along: &StillMotion, masses: &Masses) -> Option<Estimate> {
        let stretched = problem.walls().iter().enumerate().map(|(wall, state)| {
            let slope = along.shift[state.state()][1];
            self.impact_flux(&[wall], 1).filter(|_| slope != 0.0).map(|rate| rate.scaled(-slope))
        });
        let still = (!problem.walls().is_empty()).then(|| masses.impact_rate())?;
        Some(stretched.flatten().fold(still, Estimate::plus))
    }

    /// The functions of Q with a symmetry; next to walls its own ones.
    fn functions_with(&self, symmetry: &Symmetry) -> Functions {
        if self.exponent().space.corners().is_empty() {
            return Functions::Polynomials(self.polynomials(symmetry));
        }
        self.exponent().space.clone()
    }

    /// The same density on as many nodes as the equations of an exact one take: they hold on any.
    fn on_kept_nodes(&self) -> Result<ClosureDensity> {
        let (states, mut masses) = self.carrying_nodes().ok_or(self.failed())?;
        let kept = states.len().min(tuning::sensitivity::DRAWS);
        masses.truncate(kept);
        let nodes = States::from_values(states.dimension(), states.values()[..kept * states.dimension()].to_vec());
        let masses = masses.into_iter().map(|mass| [mass; 2]).collect();
        Ok(ClosureDensity { nodes, masses, ..self.clone() })
    }

    fn newton<'a>(&self, on_nodes: &'a ClosureDensity, problem: &Problem, symmetry: &Symmetry) -> Result<Newton<'a>> {
        let space = Functions::Polynomials(self.polynomials(symmetry));
        Newton::new(on_nodes, problem, space, &[]).ok_or(self.failed())
    }

    /// The derivative of ln p, with mean zero.
    fn exact_slope(&self, newton: &Newton<'_>, operator: &FokkerPlanck) -> Result<Exponent> {
        let mut slope = newton.slope(operator).ok_or(self.failed())?;
        slope.constant -= self.expectation(&|x| slope.value(x))?.value;
        Ok(slope)
    }

    /// The derivative of ln p̃, by two parameters with the first ones.
    fn moving_by(&self, names: &[&str], (slope, first): (Exponent, Option<[Exponent; 2]>)) -> Sensitivity {
        let of = |regular: Exponent| Slope { regular, singular: Vec::new() };
        let names = names.iter().map(|&name| name.to_owned()).collect();
        let along = first.map(|first| first.map(|regular| Along { slope: of(regular), shift: [0.0; 2] }));
        let nothing = || [Vec::new(), Vec::new()];
        let carried = |along| Carried::second([0.0; 2], along, self, [nothing(), nothing()]);
        let carried = along.map_or_else(Carried::default, carried);
        Sensitivity { carried, ..self.moving_with(names, of(slope), nothing(), None) }
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
    /// ∫ of what the functions of the two highest degrees change.
    pub(super) fn change(&self) -> f64 {
        self.masses.change()
    }

    /// dE g/dθ, with its standard error, given Σ η_i ∂_i g where states move with walls.
    pub(super) fn expectation(&self, g: &Integrand<'_>, slope: Option<&Integrand<'_>>) -> Estimate {
        let Some(pilot) = self.motion.pilot() else { return Estimate::new(f64::NAN, f64::INFINITY) };
        // Every state stands for its mirror images too.
        let count = self.symmetry.count() as f64;
        let values = |g: &Integrand<'_>| -> Vec<f64> {
            let at = |x: &[f64]| self.symmetry.images(x).map(|image| g(&image)).sum::<f64>() / count;
            pilot.states.par_iter().map(at).collect()
        };
        let own = values(g);
        let (mut value, mut changes) = (self.masses.mean(&own), self.masses.changes(&own));
        if let (Some(density), Some(slope)) = (&self.density, slope) {
            let along = values(slope);
            value += density.mean(&along);
            changes.iter_mut().zip(density.changes(&along)).for_each(|(change, along)| *change += along);
        }
        Estimate::new(value, jackknife(&changes))
    }
}

/// The symmetry that a problem and its derivatives have in common.
fn symmetry_of(problem: &Problem, along: &[StillMotion]) -> Symmetry {
    along.iter().fold(problem.symmetry(), |symmetry, motion| symmetry.and_of(&motion.operator))
}
