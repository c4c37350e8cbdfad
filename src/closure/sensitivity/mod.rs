//! How a density moves with a parameter of its system.
//!
//! The derivative p′ of the stationary density by a parameter solves L p′ = −L′p, the same linear equation with another right
//! side. Nothing is differenced and no search is differentiated.
//!
//! - `moving`: what of a problem moves with a parameter, walls among it;
//! - `exact`: of an exact density, from its Galerkin equations;
//! - `factors`: of the moment equations;
//! - `tangent`: of their solution, under a weight that moves along;
//! - `projected`: of the exponential polynomial that is closest to it;
//! - `on_states`: in three states and more, on the pilot's states;
//! - `slope`: the derivative of ln p; `carried`, `impacts`, `answers`: what it says at fixed states and at the walls, of moments, tails
//!   and crossings.

mod answers;
mod carried;
mod exact;
mod factors;
mod impacts;
mod moving;
mod on_states;
mod projected;
mod slope;
mod tangent;

pub use answers::ClosureSensitivity;

use super::candidates::Origin;
use super::density::ClosureDensity;
use super::density::content::Integrals;
use super::density::exponent::Exponent;
use super::dynamics::MomentSystem;
use crate::closure::REFERENCE_EXCESS;
use crate::density::Density;
use crate::error::{Error, Result};
use crate::functions::{Functions, Polynomials};
use crate::parallel;
use crate::polynomial::monomials;
use crate::problem::{Problem, Symmetry};
use crate::states::States;
use answers::Whole;
use carried::Carried;
use exact::Newton;
use moving::Moving;
use projected::LinearisedFit;
use slope::Slope;
use tangent::{Derivative, Tangent};

/// The least degree of the moment equations for derivatives by parameters of systems without impulses.
const LEAST_DEGREE: u32 = 14;
/// The least degree of the moment equations for derivatives by parameters under impulses.
const LEAST_DEGREE_STRUCK: u32 = 12;
/// The degree above the order, in one state and in two, of the moment equations for derivatives under impulses, where high degrees
/// ring. Gamma's law of shape 10 lost its derivatives at n = 8 by degree 16, and has them to 1e-3 by 12; for a Duffing oscillator
/// at n = 6 the estimate is 4 times as large by 12 as by 14.
const EXCESS_STRUCK: [u32; 2] = [4, 8];

/// What all derivatives of one density have in common.
struct Linearised<'a> {
    /// Of an exact density.
    newton: Option<Newton<'a>>,
    fitted: Option<(LinearisedFit, Tangent<'a>)>,
}

/// The derivative of a density.
struct DensityDerivative<'a> {
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
    /// [`Error::NotServed`] for a density of a time, and in three states and more by the offset of a wall with
    /// which no displacement can move while the other walls stay; [`Error::NotKnown`] for a density from a document, and where the
    /// problem does not depend on the parameter in a known way; [`Error::NotAName`] if it has none of the name;
    /// [`Error::NotClosed`] where the linear system has no solution.
    ///
    /// ```
    /// use expoly::{Closure, Density, Sensitivity, models::{Duffing, Solved}};
    /// let density = Closure::new(4).solve(&Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?)?;
    /// // p = C exp(−(c/D) H), so that E v² = D/c and P(x > a) falls as the damping rises.
    /// let by_damping = density.sensitivity("c")?;
    /// assert!((by_damping.moment(&[0, 2])?.value + 0.2 / 0.2_f64.powi(2)).abs() < 1e-8);
    /// assert!(by_damping.exceedance(0, 2.0)?.value < 0.0);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn sensitivity(&self, parameter: &str) -> Result<ClosureSensitivity> {
        Ok(self.sensitivities(&[parameter])?.remove(0))
    }

    /// The derivatives by several parameters, with what they have in common made once.
    ///
    /// # Errors
    /// As [`ClosureDensity::sensitivity`].
    pub fn sensitivities(&self, parameters: &[&str]) -> Result<Vec<ClosureSensitivity>> {
        if parameters.is_empty() {
            return Ok(Vec::new());
        }
        let problem = self.differentiable()?;
        if self.dimension() > 2 {
            return self.sensitivities_on_states(problem, parameters);
        }
        // An exact density above elastic walls has no kinks, but its derivatives by their restitutions have.
        let family = self.origin()?.functions(self.provenance().order.unwrap_or(0));
        let moving = parameters.iter().map(|parameter| Moving::new(problem, parameter, family.corners()));
        let moving = moving.collect::<Result<Vec<_>>>()?;
        let symmetry = moving.iter().fold(problem.symmetry(), |symmetry, moving| symmetry.and_of(&moving.operator));
        let system = self.system_of_order(moving.iter().any(Moving::grazes), &symmetry)?;
        let linearised = self.linearised(problem, system.as_ref(), &symmetry)?;
        let one = |(parameter, moving): (&&str, &Moving)| {
            let found = linearised.along(self, moving).ok_or(self.failed())?;
            // The rate of impacts is that of the density over the stretched length.
            let impacts = self.impacts_along(|points| {
                let over = |along: Vec<f64>| along.into_iter().map(|s| s - moving.shift[1]).collect();
                found.relative(self, points).map(over)
            });
            let DensityDerivative { slope, at_nodes, reference } = found;
            let whole = reference.as_ref().map(Derivative::whole);
            let found = self.moving_with(parameter, slope, at_nodes, whole);
            Ok(ClosureSensitivity { carried: Carried::new(moving.shift, self), impacts, ..found })
        };
        // The first error is that of the first parameter.
        parallel::map(moving.len(), |k| one((&parameters[k], &moving[k]))).into_iter().collect()
    }

    /// The problem, if derivatives of its density are served.
    fn differentiable(&self) -> Result<&Problem> {
        let on_panels = matches!(self.content.integrals, Integrals::Panels { .. });
        let stationary = match self.candidates()[0].origin {
            // A parameter within a function of the forces moves a potential to one that Q has not.
            Origin::Exact if !self.exponent().space.folds().is_empty() => false,
            Origin::Exact | Origin::MomentEquations { .. } => on_panels == (self.dimension() <= 2),
            Origin::MaximumLikelihood => !on_panels && self.content.indication.is_some(),
            _ => false,
        };
        if !stationary {
            return Err(Error::NotServed {
                method: "closure",
                what: "derivatives by parameters of a density that is not stationary or that no moment equations gave",
                remedy: "take differences of two densities, at `Problem::with_parameter`, or the grid's derivatives",
            });
        }
        self.problem()
    }

    /// The moment equations of as many degrees above the order as those of the reference; none where the density is exact, unless a
    /// derivative `grazes`. Next to walls they are of all degrees.
    fn system_of_order(&self, grazes: bool, symmetry: &Symmetry) -> Result<Option<MomentSystem>> {
        if matches!(self.candidates()[0].origin, Origin::Exact) && !grazes {
            return Ok(None);
        }
        let dynamics = self.origin()?;
        let system = if self.exponent().space.corners().is_empty() {
            // Under impulses high degrees ring: damping is bounded by the impulses' rate.
            let struck = !dynamics.problem().impulses().is_empty();
            let (least, excess) =
                if struck { (LEAST_DEGREE_STRUCK, &EXCESS_STRUCK[..]) } else { (LEAST_DEGREE, &REFERENCE_EXCESS[..]) };
            let degree = self.provenance().order.unwrap_or(0) + excess[self.dimension() - 1];
            MomentSystem::of_degree(dynamics, degree.max(least), symmetry)
        } else {
            MomentSystem::of_all_degrees(dynamics)
        };
        system.map(Some).ok_or(self.failed())
    }

    /// What derivatives with a symmetry have in common.
    fn linearised<'a>(
        &'a self,
        problem: &Problem,
        system: Option<&'a MomentSystem>,
        symmetry: &Symmetry,
    ) -> Result<Linearised<'a>> {
        let (origin, dynamics) = (self.candidates()[0].origin, self.origin()?);
        let tails = if let Origin::MomentEquations { tails } = origin { tails } else { 0.0 };
        let fitted = |system| {
            // Next to walls a density that is exact need not have all functions of its derivatives.
            let order = self.provenance().order.unwrap_or(0);
            let space =
                if dynamics.passages().is_empty() { self.functions(symmetry) } else { dynamics.functions(order) };
            let fit = LinearisedFit::new(self, space, tails).ok_or(self.failed())?;
            let tangent = Tangent::new(system, dynamics.passages(), dynamics.domain()).ok_or(self.failed())?;
            Ok((fit, tangent))
        };
        let newton = if matches!(origin, Origin::Exact) {
            let newton = Newton::new(self, problem, self.functions(symmetry), dynamics.passages());
            Some(newton.ok_or(self.failed())?)
        } else {
            None
        };
        Ok(Linearised { newton, fitted: system.map(fitted).transpose()? })
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

    /// The reference's values at some points less their mean under it.
    fn centred_at(&self, values: impl Fn(&States) -> Vec<f64>, points: &States) -> Vec<f64> {
        let centre = self.centred(values(&self.nodes), 1).1;
        values(points).into_iter().map(|value| value - centre).collect()
    }

    /// The derivative of the density from those of its logarithm and of the reference's.
    fn moving_with(
        &self,
        parameter: &str,
        slope: Slope,
        [own, other]: [Vec<f64>; 2],
        whole: Option<Whole>,
    ) -> ClosureSensitivity {
        let masses =
            own.iter().zip(other).zip(&self.masses).map(|((own, other), m)| [own * m[0], other * m[1]]).collect();
        let none = || Whole { points: States::new(self.dimension()), masses: Vec::new() };
        let (density, whole) = (self.clone(), whole.unwrap_or_else(none));
        let (parameter, carried) = (parameter.to_owned(), Carried::default());
        ClosureSensitivity { density, parameter, slope, masses, whole, carried, impacts: None, on_states: None }
    }

    /// The functions of the order with a symmetry, which a parameter may break that the density has. Next to walls it has none.
    fn functions(&self, symmetry: &Symmetry) -> Functions {
        if !self.exponent().space.corners().is_empty() {
            return self.exponent().space.clone();
        }
        self.polynomials(symmetry).into()
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

impl<'a> Linearised<'a> {
    /// The derivative along a motion. None where it is not finite.
    fn along(&self, density: &ClosureDensity, moving: &Moving) -> Option<DensityDerivative<'a>> {
        let (mut slope, along, reference) = match self {
            Linearised { newton: Some(newton), .. } if !moving.grazes() => {
                (Slope { regular: newton.slope(&moving.operator)?, singular: Vec::new() }, None, None)
            }
            Linearised { fitted: Some((fit, tangent)), .. } => {
                let derivative = tangent.along(moving)?;
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
        Some(DensityDerivative { slope, at_nodes, reference })
    }
}

impl DensityDerivative<'_> {
    /// ∂ ln q/∂θ at some points: of p̃, of the reference, and of the reference by the equations of the degree below.
    fn relative(&self, density: &ClosureDensity, points: &States) -> [Vec<f64>; 3] {
        let own = self.slope.values(points);
        let Some(reference) = &self.reference else { return [own.clone(), own.clone(), own] };
        let of = |along: &Derivative<'_>| density.centred_at(|points| along.values(points), points);
        [own, of(reference), of(&reference.by_lower_degree())]
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
