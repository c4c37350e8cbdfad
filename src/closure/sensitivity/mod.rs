//! How a density moves with a parameter of its system.
//!
//! The derivative p′ of the stationary density by a parameter solves L p′ = −L′p, the same linear equation with another right
//! side, and the second one L p″ = −L′ₖp′ₗ − L′ₗp′ₖ − L″p. Nothing is differenced and no search is differentiated.
//!
//! - `exact`: of an exact density, from its Galerkin equations;
//! - `tangent`: of the solution of the moment equations, under a weight that moves along;
//! - `projected`: of the exponential polynomial that is closest to it;
//! - `on_states`: in three states and more, on the pilot's states;
//! - `answers`: what they say of moments, tails and crossings.

mod answers;
mod exact;
mod on_states;
mod projected;
mod tangent;

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
use crate::fokker_planck::FokkerPlanck;
use crate::polynomial::monomials;
use crate::problem::{Problem, Symmetry};
use crate::states::States;
use answers::Whole;
use exact::Newton;
use on_states::OnStates;
use projected::Fit;
use rayon::prelude::*;
use std::borrow::Cow;
use std::sync::Arc;
use tangent::{Derivative, Tangent};

/// What all derivatives of one density have in common.
enum Linearised<'a> {
    Exact(Box<Newton<'a>>),
    Fitted(Box<(Fit, Tangent<'a>)>),
}

/// A first derivative.
struct First<'a> {
    slope: Exponent,
    /// ∂ ln p̃/∂θ and ∂ ln p̂/∂θ at the density's nodes, each with mean zero.
    at_nodes: [Vec<f64>; 2],
    /// That of the reference; none where the density is exact.
    reference: Option<Derivative<'a>>,
}

impl ClosureDensity {
    /// The derivative by a parameter of the problem.
    ///
    /// # Errors
    /// [`Error::NotServed`] next to walls, under impulses, and for a density of a time;
    /// [`Error::NotKnown`] for a density from a document; those of [`Problem::derivative`](crate::Problem::derivative);
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
        let moved = parameters.iter().map(|parameter| problem.derivative(&[parameter])).collect::<Result<Vec<_>>>()?;
        if self.is_on_states() {
            return self.moving_by_states(parameters, &moved);
        }
        let system = self.system_of_order()?;
        let symmetry = self.common_symmetry(problem, &moved);
        let on_nodes = self.on_nodes().ok_or(self.failed())?;
        let linearised = on_nodes.linearised(problem, system.as_ref(), &symmetry)?;
        let found: Vec<Option<First<'_>>> = moved.par_iter().map(|moved| linearised.first(&on_nodes, moved)).collect();
        let one = |(parameter, found): (&&str, Option<First<'_>>)| {
            let First { slope, at_nodes, reference } = found.ok_or(self.failed())?;
            let whole = reference.as_ref().map(|reference| reference.whole(None));
            Ok(self.moving_with(vec![(*parameter).to_owned()], (slope, None), at_nodes, whole))
        };
        parameters.iter().zip(found).map(one).collect()
    }

    /// The second derivative by two parameters, which may be the same.
    ///
    /// # Errors
    /// As [`ClosureDensity::sensitivity`].
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
        if self.dimension() > 2 {
            let what = "second derivatives in three states and more";
            return Err(Error::NotServed { method: "closure", what, remedy: "take differences of first ones" });
        }
        let system = self.system_of_order()?;
        let [k, l] = parameters;
        let moved = [problem.derivative(&[k])?, problem.derivative(&[l])?];
        let twice = problem.derivative(&parameters)?;
        let symmetry = self.common_symmetry(problem, &moved);
        let linearised = self.linearised(problem, system.as_ref(), &symmetry)?;
        let first = moved.each_ref().map(|moved| linearised.first(self, moved));
        let [Some(first), Some(second)] = first else { return Err(self.failed()) };
        let (slopes, moved) = ([&first.slope, &second.slope], moved.each_ref());
        let both =
            |values: [&Vec<f64>; 2]| -> Vec<f64> { values[0].iter().zip(values[1]).map(|(k, l)| k * l).collect() };
        let own = both([&first.at_nodes[0], &second.at_nodes[0]]);
        let (mut slope, reference, whole) = match &linearised {
            Linearised::Exact(newton) => (newton.second(moved, &twice, slopes).ok_or(self.failed())?, None, None),
            Linearised::Fitted(fitted) => {
                let (fit, tangent) = &**fitted;
                let (Some(k), Some(l)) = (&first.reference, &second.reference) else { return Err(self.failed()) };
                let derivative = tangent.second(moved, &twice, [k, l]).ok_or(self.failed())?;
                let along = self.centred(derivative.second_values([k, l], &self.nodes), 1).0;
                let square = both([&first.at_nodes[1], &second.at_nodes[1]]);
                let curved: Vec<f64> = along.iter().zip(square).map(|(along, square)| along - square).collect();
                let at = |k: usize| [&first.at_nodes[k][..], &second.at_nodes[k][..]];
                let slope = fit.second(at(0), at(1), &curved).ok_or(self.failed())?;
                (slope, Some(along), Some(derivative.whole(Some([k, l]))))
            }
        };
        let sums = slope.values(&self.nodes).into_iter().zip(own).map(|(slope, product)| slope + product).collect();
        let (own, centre) = self.centred(sums, 0);
        slope.constant -= centre;
        let at_nodes = [own.clone(), reference.unwrap_or(own)];
        let product = [first.slope.clone(), second.slope.clone()];
        let names = parameters.map(str::to_owned).to_vec();
        Ok(self.moving_with(names, (slope, Some(product)), at_nodes, whole))
    }

    /// The problem, if derivatives of its density are served.
    fn differentiable(&self) -> Result<&Problem> {
        let problem = self.problem()?;
        let stationary = match self.candidates()[0].origin {
            Origin::Exact | Origin::MomentEquations { .. } => true,
            Origin::MaximumLikelihood => self.dimension() > 2 && self.content.indication.is_some(),
            _ => false,
        };
        let on_panels = matches!(self.content.integrals, Integrals::Panels { .. });
        let smooth = problem.walls().is_empty() && problem.impulses().is_empty();
        if stationary && smooth && on_panels == (self.dimension() <= 2) { Ok(problem) } else { Err(NOT_SERVED) }
    }

    /// The same with some of its draws for nodes where it has no others. The Galerkin equations of an exact density hold on any.
    fn on_nodes(&self) -> Option<Cow<'_, ClosureDensity>> {
        if !self.nodes.is_empty() {
            return Some(Cow::Borrowed(self));
        }
        let (states, mut masses) = self.weighted_states()?;
        let kept = states.len().min(tuning::sensitivity::DRAWS);
        masses.truncate(kept);
        let values = states.values()[..kept * states.dimension()].to_vec();
        let nodes = States::from_values(states.dimension(), values);
        let masses = masses.into_iter().map(|mass| [mass; 2]).collect();
        Some(Cow::Owned(ClosureDensity { nodes, masses, ..self.clone() }))
    }

    /// Whether the derivative is found on the pilot's states: in three states and more, where the density is not exact.
    fn is_on_states(&self) -> bool {
        self.dimension() > 2 && self.candidates()[0].origin != Origin::Exact
    }

    /// The symmetry of the equation and its derivatives; none where that would save little.
    fn common_symmetry(&self, problem: &Problem, moved: &[FokkerPlanck]) -> Symmetry {
        let own = if self.dimension() > 2 { problem.symmetry() } else { Symmetry::none(self.dimension()) };
        moved.iter().fold(own, Symmetry::and_of)
    }

    /// The moment equations of as many degrees above the order as those of the reference; none where the density is exact. The
    /// highest of all serve densities that move, and carry what the edge of the domain makes of the derivative.
    fn system_of_order(&self) -> Result<Option<MomentSystem>> {
        let Origin::MomentEquations { .. } = self.candidates()[0].origin else { return Ok(None) };
        let excess = tuning::space::EXCESS[self.dimension() - 1];
        let degree = self.provenance().order.unwrap_or(0) + excess;
        Ok(Some(self.motion()?.1.up_to(degree.max(tuning::sensitivity::LEAST_DEGREE))))
    }

    fn linearised<'a>(
        &'a self,
        problem: &Problem,
        system: Option<&'a MomentSystem>,
        symmetry: &Symmetry,
    ) -> Result<Linearised<'a>> {
        let space = Functions::Polynomials(self.polynomials(symmetry));
        let found = match (system, self.candidates()[0].origin) {
            (Some(system), Origin::MomentEquations { tails }) => Fit::new(self, space, tails)
                .and_then(|fit| Some(Linearised::Fitted(Box::new((fit, Tangent::new(problem, system)?))))),
            _ => Newton::new(self, problem, space).map(|newton| Linearised::Exact(Box::new(newton))),
        };
        found.ok_or(self.failed())
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

    /// The same where there are no nodes.
    fn moving_on_states(
        &self,
        parameters: Vec<String>,
        (slope, product): (Exponent, Option<[Exponent; 2]>),
        on_states: Option<Arc<OnStates>>,
    ) -> Sensitivity {
        let found = self.moving_with(parameters, (slope, product), [Vec::new(), Vec::new()], None);
        Sensitivity { on_states, ..found }
    }

    /// The derivative of the density from those of its logarithm and of the reference's.
    fn moving_with(
        &self,
        parameters: Vec<String>,
        (slope, product): (Exponent, Option<[Exponent; 2]>),
        [own, other]: [Vec<f64>; 2],
        whole: Option<Whole>,
    ) -> Sensitivity {
        let masses =
            own.iter().zip(other).zip(&self.masses).map(|((own, other), m)| [own * m[0], other * m[1]]).collect();
        let none = || Whole { points: States::new(self.dimension()), masses: Vec::new() };
        let whole = whole.unwrap_or_else(none);
        Sensitivity { density: self.clone(), parameters, slope, product, masses, whole, on_states: None }
    }

    /// The polynomials of the order with a symmetry: a parameter may break that of the density. Where it does not, they are the
    /// density's own.
    fn polynomials(&self, symmetry: &Symmetry) -> Polynomials {
        let own = self.exponent().space.polynomials().map_or(&[][..], |own| own.exponents());
        let degree = own.iter().map(|alpha| alpha.iter().sum()).max().unwrap_or(0);
        let (centre, half_width) = self.content.domain.box_around();
        let kept = self.problem().is_ok_and(|problem| problem.symmetry() == *symmetry);
        let exponents = if kept {
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
    what: "derivatives by parameters next to walls, under impulses, and of a density that is not stationary",
    remedy: "take differences of two densities, at `Problem::with_parameter`",
};

impl<'a> Linearised<'a> {
    /// The derivative along that of the operator. None where it is not finite.
    fn first(&self, density: &ClosureDensity, moved: &FokkerPlanck) -> Option<First<'a>> {
        let (mut slope, along, reference) = match self {
            Linearised::Exact(newton) => (newton.slope(moved)?, None, None),
            Linearised::Fitted(fitted) => {
                let (fit, tangent) = &**fitted;
                let derivative = tangent.along(moved)?;
                let along = density.centred(derivative.values(&density.nodes), 1).0;
                (fit.slope(&along)?, Some(along), Some(derivative))
            }
        };
        let (own, centre) = density.centred(slope.values(&density.nodes), 0);
        slope.constant -= centre;
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
