//! Derivatives where the pilot's states carry the density: no nodes are needed, nor a simulation for each parameter.
//!
//! - `weights`: those of the states under which all means of images are zero; `moved`: images under the derivative of the generator;
//! - `equations`: the Galerkin equations there, and their solutions;
//! - `masses`: what these are on the states, and means with standard errors;
//! - `fit`: the exponential polynomial's part; `displaced`: how displacements move with walls.

mod displaced;
mod equations;
mod fit;
mod masses;
mod moved;
mod weights;

use super::ClosureSensitivity;
use super::exact::Newton;
use super::slope::Slope;
use crate::closure::candidates::Origin;
use crate::closure::density::ClosureDensity;
use crate::closure::density::exponent::Exponent;
use crate::closure::dynamics::Dynamics;
use crate::closure::samples;
use crate::density::{CountedImpacts, Density};
use crate::error::{Error, Result};
use crate::estimate::Estimate;
use crate::fokker_planck::{FokkerPlanck, ImpulseTerm};
use crate::functions::{Corner, Functions, GrazingMotion};
use crate::parallel;
use crate::problem::{Problem, StillMotion, Symmetry};
use crate::states::States;
use crate::walls::Contact;
use displaced::Displaced;
use equations::{EquationGround, StateEquations};
use fit::Likely;
use masses::{Masses, doubt, jackknife};
use std::fmt;
use std::sync::Arc;

/// The most nodes or draws on which the equations of an exact density are solved for its derivatives in three states and more.
const DRAWS: usize = 1 << 16;
/// The logarithm of the ratio of standard errors above which derivatives on the pilot's states are taken by two degrees less. Of 16
/// seeds of a filter, where both degrees are as noisy, some took the lower one with 0.7, which is 0.2 % off there; of a chain the
/// highest degree is noisier by far more.
const NOISIER: f64 = 1.4;

/// A function of the state that is averaged.
type StateFunction<'a> = dyn Fn(&[f64]) -> f64 + Sync + 'a;

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
struct StateDerivatives {
    symmetry: Symmetry,
    masses: Vec<Masses>,
    density: Arc<Masses>,
}

impl ClosureDensity {
    /// The derivatives in three states and more.
    pub(super) fn sensitivities_on_states(
        &self,
        problem: &Problem,
        parameters: &[&str],
    ) -> Result<Vec<ClosureSensitivity>> {
        let along: Vec<StillMotion> =
            parameters.iter().map(|parameter| problem.motion(parameter)?.still(problem)).collect::<Result<_>>()?;
        if self.is_exact() && problem.walls().is_empty() {
            let symmetry = symmetry_of(problem, &along);
            let on_nodes = self.on_kept_nodes()?;
            let newton = self.newton(&on_nodes, problem, &symmetry)?;
            let one = |(name, motion): (&&str, &StillMotion)| {
                Ok(self.moving_by(name, self.exact_slope(&newton, &motion.operator)?.into()))
            };
            return parameters.iter().zip(&along).map(one).collect();
        }
        let motion = self.origin()?;
        let grazing = self.grazing(motion, &along)?;
        let StateDerivatives { symmetry, masses, density } = self.on_states(motion, &along, &grazing)?;
        let states = self.pilot_states(motion)?;
        let (points, measure) = self.carrying_nodes().ok_or(self.failed())?;
        let likely = Likely::new(self.functions_with(&symmetry), &points, &measure).ok_or(self.failed())?;
        let one = |((name, (moving, grazing)), masses): ((&&str, (&StillMotion, Vec<GrazingMotion>)), Masses)| {
            let slope = likely.slope(states, masses.own(), grazing).ok_or(self.failed())?;
            let own = slope.values(states);
            let displaced = Displaced::new(&moving.shift);
            let impacts = self.impacts_on_states(problem, moving, &masses);
            let on_states = self.carried_by((motion, &symmetry), masses, &own, (&density, displaced));
            let on_states = Some(Arc::new(on_states));
            Ok(ClosureSensitivity { on_states, impacts, ..self.moving_by(name, slope) })
        };
        parameters.iter().zip(along.iter().zip(grazing)).zip(masses).map(one).collect()
    }

    /// What moves in the singular parts next to walls along some motions.
    fn grazing(&self, motion: &Dynamics, along: &[StillMotion]) -> Result<Vec<Vec<GrazingMotion>>> {
        let (problem, pilot) = (motion.problem(), motion.pilot().ok_or(self.too_few())?);
        let corners = samples::corners(problem, pilot).ok_or(self.failed())?;
        let contacts = problem.contacts();
        let one = |motion: &StillMotion| {
            let at = |((contact, corner), restitution): ((&Contact, &Corner), &f64)| {
                // As the coordinate stretches, the noise does more.
                let stretched = motion.shift[contact.wall.state()][1] * corner.intensity();
                let noise = problem.intensity_rate_at(contact, &motion.operator) + stretched;
                GrazingMotion::new(corner, [*restitution, noise])
            };
            let all = contacts.iter().zip(&corners).zip(&motion.restitution).map(at);
            all.filter(GrazingMotion::moves).collect()
        };
        Ok(along.iter().map(one).collect())
    }

    fn is_exact(&self) -> bool {
        self.candidates()[0].origin == Origin::Exact
    }

    /// What the equations of the highest degree give along some derivatives of the operator, or those of two degrees less if the
    /// highest are [noisier](NOISIER) than that: where functions are all but dependent on each other in the equations, their noise is large.
    fn on_states(
        &self,
        motion: &Dynamics,
        along: &[StillMotion],
        grazing: &[Vec<GrazingMotion>],
    ) -> Result<StateDerivatives> {
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
        let ladder = EquationGround::ladder(motion, along).ok_or(self.too_few())?;
        let of_degree = |ground: &EquationGround| {
            let equations = StateEquations::new(ground, motion)?;
            let masses = equations.along(along.iter().zip(grazing.iter().map(Vec::as_slice)))?;
            let found =
                StateDerivatives { symmetry: ground.symmetry.clone(), masses, density: Arc::new(equations.density()) };
            Some((doubt(states, &found.masses), found))
        };
        let mut degrees = ladder.iter().filter_map(of_degree);
        let (highest, found) = degrees.next().ok_or(self.too_few())?;
        let lower = degrees.next().filter(|(lower, _)| lower + NOISIER < highest);
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
                let fixed = |(x, w): (&[f64], &f64)| -displaced.value(self.exponent(), x) * w;
                let own = density.own();
                masses.distance(&parallel::map(own.len(), |k| fixed((pilot.states.state(k), &own[k]))))
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
            return self.polynomials(symmetry).into();
        }
        self.exponent().space.clone()
    }

    /// The same density on as many nodes as the equations of an exact one take: they hold on any.
    fn on_kept_nodes(&self) -> Result<ClosureDensity> {
        let (states, mut masses) = self.carrying_nodes().ok_or(self.failed())?;
        let kept = states.len().min(DRAWS);
        masses.truncate(kept);
        let nodes = States::from_values(states.dimension(), states.values()[..kept * states.dimension()].to_vec());
        let masses = masses.into_iter().map(|mass| [mass; 2]).collect();
        Ok(ClosureDensity { nodes, masses, ..self.clone() })
    }

    fn newton<'a>(&self, on_nodes: &'a ClosureDensity, problem: &Problem, symmetry: &Symmetry) -> Result<Newton<'a>> {
        let space = Functions::from(self.polynomials(symmetry));
        Newton::new(on_nodes, problem, space, &[]).ok_or(self.failed())
    }

    /// The derivative of ln p, with mean zero.
    fn exact_slope(&self, newton: &Newton<'_>, operator: &FokkerPlanck) -> Result<Exponent> {
        let mut slope = newton.slope(operator).ok_or(self.failed())?;
        slope.constant -= self.expectation(&|x| slope.value(x))?.value;
        Ok(slope)
    }

    /// The derivative with that of ln p̃.
    fn moving_by(&self, parameter: &str, slope: Slope) -> ClosureSensitivity {
        self.moving_with(parameter, slope, [Vec::new(), Vec::new()], None)
    }

    /// States with weights that sum to about 1, on which integrals of the density are taken.
    fn carrying_nodes(&self) -> Option<(States, Vec<f64>)> {
        if self.nodes.is_empty() {
            return self.evidence().weighted_states();
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
    pub(super) fn expectation(&self, g: &StateFunction<'_>, slope: Option<&StateFunction<'_>>) -> Estimate {
        let Some(pilot) = self.motion.pilot() else { return Estimate::new(f64::NAN, f64::INFINITY) };
        // Every state stands for its mirror images too.
        let count = self.symmetry.count() as f64;
        let values = |g: &StateFunction<'_>| -> Vec<f64> {
            let at = |x: &[f64]| self.symmetry.images(x).map(|image| g(&image)).sum::<f64>() / count;
            parallel::map(pilot.states.len(), |k| at(pilot.states.state(k)))
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
