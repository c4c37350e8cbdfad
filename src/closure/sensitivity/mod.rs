//! How a density moves with a parameter of its system.
//!
//! The derivative p′ of the stationary density by a parameter solves L p′ = −L′p, the same linear equation with another right
//! side, and the second one L p″ = −L′ₖp′ₗ − L′ₗp′ₖ − L″p. Nothing is differenced and no search is differentiated.
//!
//! - `moving`: what of a problem moves with a parameter, walls among it;
//! - `exact`: of an exact density, from its Galerkin equations;
//! - `tangent`: of the solution of the moment equations, under a weight that moves along; `walled`: the same next to walls, where
//!   the singular part of the weight does;
//! - `projected`: of the exponential polynomial that is closest to it;
//! - `on_states`: in three states and more, on the pilot's states;
//! - `slope`: the derivative of ln p; `carried`, `impacts`, `answers`, `derived`: what it says at fixed states and at the walls, of moments,
//!   tails, crossings, quantiles and first passages.

mod answers;
mod carried;
mod derived;
mod exact;
mod impacts;
mod moving;
mod on_states;
mod projected;
mod slope;
mod tangent;
mod walled;

pub use answers::Sensitivity;

use super::candidates::Origin;
use super::density::ClosureDensity;
use super::density::content::Integrals;
use super::density::exponent::Exponent;
use super::dynamics::MomentSystem;
use super::space::{Functions, Polynomials};
use super::tuning;
use crate::density::Density;
use crate::error::{Error, Result};
use crate::polynomial::monomials;
use crate::problem::{Problem, Symmetry};
use crate::states::States;
use answers::Whole;
use carried::Carried;
use exact::Newton;
use moving::Moving;
use projected::Fit;
use rayon::prelude::*;
use slope::Slope;
use tangent::{Derivative, Tangent};
use walled::WalledTangent;

/// What all derivatives of one density have in common.
struct Linearised<'a> {
    /// Of an exact density.
    newton: Option<Newton<'a>>,
    fitted: Option<(Fit, Solution<'a>)>,
}

/// The moment equations that a derivative solves.
enum Solution<'a> {
    Smooth(Box<Tangent<'a>>),
    Walled(Box<WalledTangent<'a>>),
}

/// A first derivative.
struct First<'a> {
    slope: Slope,
    /// ∂ ln p̃/∂θ and ∂ ln p̂/∂θ at the density's nodes, each with mean zero.
    at_nodes: [Vec<f64>; 2],
    /// That of the reference; none where the density is exact.
    reference: Option<Derivative<'a>>,
}

impl ClosureDensity {
    /// The derivative by a parameter of the problem.
    ///
    /// # Errors
    /// [`Error::NotServed`] under impulses, for a density of a time, and in three states and more by the offset of a wall with
    /// which no displacement can move while the other walls stay; [`Error::NotKnown`] for a density from a document, and where the
    /// problem does not depend on the parameter in a known way; [`Error::NotAName`] if it has none of the name;
    /// [`Error::NotClosed`] where the linear system has no solution.
    ///
    /// ```
    /// use expoly::{Closure, Density, models::{Duffing, Solved}};
    /// let density = Closure::new(4).solve(&Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?)?;
    /// // p = C exp(−(c/D) H), so that E v² = D/c and P(x > a) falls as the damping rises.
    /// let by_damping = density.sensitivity("c")?;
    /// assert!((by_damping.moment(&[0, 2])?.value + 0.2 / 0.2_f64.powi(2)).abs() < 1e-8);
    /// assert!(by_damping.exceedance(0, 2.0)?.value < 0.0);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn sensitivity(&self, parameter: &str) -> Result<Sensitivity> {
        Ok(self.sensitivities(&[parameter])?.remove(0))
    }

    /// The derivatives by several parameters, with what they have in common made once.
    ///
    /// # Errors
    /// As [`ClosureDensity::sensitivity`].
    pub fn sensitivities(&self, parameters: &[&str]) -> Result<Vec<Sensitivity>> {
        let problem = self.differentiable()?;
        if self.dimension() > 2 {
            return self.sensitivities_on_states(problem, parameters);
        }
        let corners = self.exponent().space.corners();
        let moving = parameters.iter().map(|parameter| Moving::new(problem, parameter, corners));
        let moving = moving.collect::<Result<Vec<_>>>()?;
        let system = self.system_of_order(moving.iter().any(Moving::grazes))?;
        let linearised = self.linearised(problem, system.as_ref())?;
        let found: Vec<Option<First<'_>>> = moving.par_iter().map(|moving| linearised.first(self, moving)).collect();
        let one = |((parameter, moving), found): ((&&str, &Moving), Option<First<'_>>)| {
            let First { slope, at_nodes, reference } = found.ok_or(self.failed())?;
            let impacts = self.impacts_along(moving.shift[1], &slope, reference.as_ref());
            let whole = reference.as_ref().map(|reference| reference.whole(None));
            let found = self.moving_with(vec![(*parameter).to_owned()], (slope, None), at_nodes, whole);
            Ok(Sensitivity { carried: Carried::new(moving.shift, self), impacts, ..found })
        };
        parameters.iter().zip(&moving).zip(found).map(one).collect()
    }

    /// The second derivative by two parameters, which may be the same.
    ///
    /// # Errors
    /// As [`ClosureDensity::sensitivity`]; [`Error::NotServed`] next to walls.
    ///
    /// ```
    /// use expoly::{Closure, models::{Duffing, Solved}};
    /// let density = Closure::new(4).solve(&Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?)?;
    /// // E v² = D/c.
    /// let mixed = density.second_sensitivity(["c", "D"])?.moment(&[0, 2])?;
    /// assert!((mixed.value + 1.0 / 0.2_f64.powi(2)).abs() < 1e-6);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn second_sensitivity(&self, parameters: [&str; 2]) -> Result<Sensitivity> {
        let problem = self.differentiable()?;
        if !problem.walls().is_empty() {
            return Err(NOT_SERVED);
        }
        if self.dimension() > 2 {
            return self.second_on_states(problem, parameters);
        }
        let system = self.system_of_order(false)?;
        let linearised = self.linearised(problem, system.as_ref())?;
        let [k, l] = [0, 1].map(|j| Moving::new(problem, parameters[j], &[]));
        let moving = [k?, l?];
        let twice = problem.derivative(&parameters)?;
        let first = moving.each_ref().map(|moving| linearised.first(self, moving));
        let [Some(first), Some(second)] = first else { return Err(self.failed()) };
        let slopes = [&first.slope.regular, &second.slope.regular];
        let moved = moving.each_ref().map(|moving| &moving.operator);
        let both =
            |values: [&Vec<f64>; 2]| -> Vec<f64> { values[0].iter().zip(values[1]).map(|(k, l)| k * l).collect() };
        let own = both([&first.at_nodes[0], &second.at_nodes[0]]);
        let (mut slope, reference, whole) = match &linearised {
            Linearised { newton: Some(newton), .. } => {
                (newton.second(moved, &twice, slopes).ok_or(self.failed())?, None, None)
            }
            Linearised { fitted: Some((fit, Solution::Smooth(tangent))), .. } => {
                let (Some(k), Some(l)) = (&first.reference, &second.reference) else { return Err(self.failed()) };
                let derivative = tangent.second(moved, &twice, [k, l]).ok_or(self.failed())?;
                let along = self.centred(derivative.second_values([k, l], &self.nodes), 1).0;
                let square = both([&first.at_nodes[1], &second.at_nodes[1]]);
                let curved: Vec<f64> = along.iter().zip(square).map(|(along, square)| along - square).collect();
                let at = |k: usize| [&first.at_nodes[k][..], &second.at_nodes[k][..]];
                let slope = fit.second(at(0), at(1), &curved).ok_or(self.failed())?;
                (slope, Some(along), Some(derivative.whole(Some([k, l]))))
            }
            Linearised { .. } => return Err(self.failed()),
        };
        let sums = slope.values(&self.nodes).into_iter().zip(own).map(|(slope, product)| slope + product).collect();
        let (own, centre) = self.centred(sums, 0);
        slope.constant -= centre;
        let at_nodes = [own.clone(), reference.unwrap_or(own)];
        let (product, slope) = (slopes.map(Clone::clone), Slope { regular: slope, singular: Vec::new() });
        let names = parameters.map(str::to_owned).to_vec();
        Ok(self.moving_with(names, (slope, Some(product)), at_nodes, whole))
    }

    /// The problem, if derivatives of its density are served.
    fn differentiable(&self) -> Result<&Problem> {
        let on_panels = matches!(self.content.integrals, Integrals::Panels { .. });
        let stationary = match self.candidates()[0].origin {
            Origin::Exact | Origin::MomentEquations { .. } => on_panels == (self.dimension() <= 2),
            Origin::MaximumLikelihood => !on_panels && self.content.indication.is_some(),
            _ => false,
        };
        if !stationary {
            return Err(NOT_SERVED);
        }
        let problem = self.problem()?;
        if problem.impulses().is_empty() { Ok(problem) } else { Err(NOT_SERVED) }
    }

    /// The moment equations of as many degrees above the order as those of the reference; none where the density is exact, unless a
    /// derivative `grazes`. The highest of all serve densities that move, and carry what the edge of the domain makes of the
    /// derivative; next to walls it is farther away.
    fn system_of_order(&self, grazes: bool) -> Result<Option<MomentSystem>> {
        if matches!(self.candidates()[0].origin, Origin::Exact) && !grazes {
            return Ok(None);
        }
        if !self.exponent().space.corners().is_empty() {
            return MomentSystem::of_all_degrees(self.origin()?).map(Some).ok_or(self.failed());
        }
        let system = self.motion()?.1;
        let excess = tuning::space::EXCESS[self.dimension() - 1];
        let degree = self.provenance().order.unwrap_or(0) + excess;
        Ok(Some(system.up_to(degree.max(tuning::sensitivity::LEAST_DEGREE))))
    }

    fn linearised<'a>(&'a self, problem: &Problem, system: Option<&'a MomentSystem>) -> Result<Linearised<'a>> {
        let (origin, walled) = (self.candidates()[0].origin, !problem.walls().is_empty());
        let tails = if let Origin::MomentEquations { tails } = origin { tails } else { 0.0 };
        let dynamics = self.origin()?;
        let solution = |system: &'a MomentSystem| {
            if walled {
                let room = (dynamics.passages(), dynamics.domain());
                return Some(Solution::Walled(Box::new(WalledTangent::new(problem, system, room)?)));
            }
            Some(Solution::Smooth(Box::new(Tangent::new(problem, system)?)))
        };
        let fitted = |system| Some((Fit::new(self, self.functions(), tails)?, solution(system)?));
        let newton = if matches!(origin, Origin::Exact) {
            let newton = Newton::new(self, problem, self.functions(), dynamics.passages());
            Some(newton.ok_or(self.failed())?)
        } else {
            None
        };
        let fitted = system.map(|system| fitted(system).ok_or(self.failed())).transpose()?;
        Ok(Linearised { newton, fitted })
    }

    fn failed(&self) -> Error {
        let order = self.provenance().order.unwrap_or(0);
        Error::NotClosed { order, reason: "the linear equations of the derivative have no solution" }
    }

    /// Values at the nodes less their mean under p̃, or under p̂, and that mean.
    fn centred(&self, mut values: Vec<f64>, k: usize) -> (Vec<f64>, f64) {
        let sums = values.iter().zip(&self.masses);
        let [sum, mass] = sums.fold([0.0; 2], |[sum, mass], (v, m)| [sum + v * m[k], mass + m[k]]);
        values.iter_mut().for_each(|value| *value -= sum / mass);
        (values, sum / mass)
    }

    /// The derivative of the density from those of its logarithm and of the reference's.
    fn moving_with(
        &self,
        parameters: Vec<String>,
        (slope, product): (Slope, Option<[Exponent; 2]>),
        [own, other]: [Vec<f64>; 2],
        whole: Option<Whole>,
    ) -> Sensitivity {
        let masses =
            own.iter().zip(other).zip(&self.masses).map(|((own, other), m)| [own * m[0], other * m[1]]).collect();
        let none = || Whole { points: States::new(self.dimension()), masses: Vec::new() };
        let (density, whole) = (self.clone(), whole.unwrap_or_else(none));
        let carried = Carried::default();
        Sensitivity { density, parameters, slope, product, masses, whole, carried, impacts: None, on_states: None }
    }

    /// All polynomials of the order: a parameter may break the symmetry that the density has. Next to walls it has none.
    fn functions(&self) -> Functions {
        if !self.exponent().space.corners().is_empty() {
            return self.exponent().space.clone();
        }
        Functions::Polynomials(self.polynomials(&Symmetry::none(self.dimension())))
    }

    /// The polynomials of the order with a symmetry: the density's own, if it is the problem's.
    fn polynomials(&self, symmetry: &Symmetry) -> Polynomials {
        let own = self.exponent().space.polynomials().map_or(&[][..], |own| own.exponents());
        let degree = own.iter().map(|alpha| alpha.iter().sum()).max().unwrap_or(0);
        let (centre, half_width) = self.content.domain.box_around();
        let exponents = if self.problem().is_ok_and(|problem| problem.symmetry() == *symmetry) {
            own.to_vec()
        } else {
            let all = monomials(self.dimension(), degree).into_iter();
            all.filter(|alpha| alpha.iter().any(|a| *a > 0) && symmetry.keeps(alpha)).collect()
        };
        Polynomials::new(centre, half_width, exponents)
    }
}

const NOT_SERVED: Error = Error::NotServed {
    method: "closure",
    what: "derivatives by parameters under impulses, of a density that is not stationary, and second ones next to walls",
    remedy: "take differences of two densities, at `Problem::with_parameter`",
};

impl<'a> Linearised<'a> {
    /// The derivative along a motion. None where it is not finite.
    fn first(&self, density: &ClosureDensity, moving: &Moving) -> Option<First<'a>> {
        let (mut slope, along, reference) = match self {
            Linearised { newton: Some(newton), .. } if !moving.grazes() => {
                (Slope { regular: newton.slope(&moving.operator)?, singular: Vec::new() }, None, None)
            }
            Linearised { fitted: Some((fit, solution)), .. } => {
                let derivative = match solution {
                    Solution::Smooth(tangent) => tangent.along(&moving.operator)?,
                    Solution::Walled(tangent) => tangent.along(moving)?,
                };
                let along = density.centred(derivative.values(&density.nodes), 1).0;
                let known = derivative.s.singulars(&density.nodes);
                let slope = Slope { regular: fit.slope(&along, &known)?, singular: moving.singular.clone() };
                (slope, Some(along), Some(derivative))
            }
            Linearised { .. } => return None,
        };
        let (own, centre) = density.centred(slope.values(&density.nodes), 0);
        slope.regular.constant -= centre;
        let at_nodes = [own.clone(), along.unwrap_or(own)];
        Some(First { slope, at_nodes, reference })
    }
}

/// The function of some coefficients, the constant's first. None where one is not finite.
fn exponent(space: &Functions, all: &[f64]) -> Option<Exponent> {
    let finite = all.iter().all(|a| a.is_finite());
    finite.then(|| Exponent {
        known: Vec::new(),
        space: space.clone(),
        constant: all[0],
        coefficients: all[1..].to_vec(),
    })
}
