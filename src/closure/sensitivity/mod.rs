//! How a density moves with a parameter of its system.
//!
//! The derivative p′ of the stationary density by a parameter solves L p′ = −L′p, the same linear equation with another right
//! side. Nothing is differenced and no search is differentiated.
//!
//! - `exact`: of an exact density, from its Galerkin equations;
//! - `tangent`: of the solution of the moment equations, under a weight that moves along;
//! - `projected`: of the exponential polynomial that is closest to it.

mod exact;
mod projected;
mod tangent;

use super::candidates::Origin;
use super::density::ClosureDensity;
use super::density::content::Integrals;
use super::density::exponent::Exponent;
use super::dynamics::Weighted;
use super::space::{Functions, Polynomials};
use super::tuning;
use crate::checks::{coordinate, dimension, finite, point};
use crate::density::{Crossing, Density};
use crate::error::{Error, Result};
use crate::estimate::Estimate;
use crate::fokker_planck::{FokkerPlanck, Local};
use crate::numerics::Rule;
use crate::polynomial::{monomials, power};
use crate::states::States;
use exact::Newton;
use projected::Fit;
use rayon::prelude::*;
use tangent::Tangent;

/// The derivative ∂p/∂θ = p ∂ ln p/∂θ of a closure's density by a parameter θ, and of every answer that it gives.
///
/// ∂Q/∂θ is a polynomial of the closure's order. Its errors are the distances from the derivative of the reference, the solution
/// of the moment equations of a higher degree. Relative to ∫|p′| they are some 2 to 12 times as large as those of the density
/// relative to 1.
#[derive(Clone, Debug)]
pub struct Sensitivity {
    density: ClosureDensity,
    parameter: String,
    /// ∂Q/∂θ, normalised.
    slope: Exponent,
    /// ∂p̃/∂θ and that of the reference at the density's nodes, times the weights.
    masses: Vec<[f64; 2]>,
    /// The reference's on its whole domain; none where the density is exact.
    whole: Weighted,
    /// An estimate of the error of the reference's derivative, in L¹.
    doubt: f64,
}

/// A derivative before it is normalised.
struct Found {
    slope: Exponent,
    /// ∂ ln p̂/∂θ at the density's nodes; none where the density is exact.
    reference: Option<Vec<f64>>,
    whole: Weighted,
    doubt: f64,
}

impl ClosureDensity {
    /// The derivative by a parameter of the problem.
    ///
    /// # Errors
    /// [`Error::NotServed`] next to walls, under impulses, in three states and more, and for a density of a time;
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

    /// The derivatives by several parameters, with what they have in common made once: six of them take about as long as the
    /// closure itself.
    ///
    /// # Errors
    /// As [`ClosureDensity::sensitivity`].
    pub fn sensitivities(&self, parameters: &[&str]) -> Result<Vec<Sensitivity>> {
        let tails = match self.candidates()[0].origin {
            Origin::Exact => None,
            Origin::MomentEquations { tails } => Some(tails),
            _ => return Err(NOT_SERVED),
        };
        let served = self.dimension() <= 2 && self.exponent().space.corners().is_empty();
        if !served || !matches!(self.content.integrals, Integrals::Panels { .. }) {
            return Err(NOT_SERVED);
        }
        let (dynamics, system) = self.motion()?;
        let problem = dynamics.problem();
        if !problem.impulses().is_empty() {
            return Err(NOT_SERVED);
        }
        let order = self.provenance().order.unwrap_or(0);
        let failed = Error::NotClosed { order, reason: "the linear equations of the derivative have no solution" };
        let space = self.functions();
        let moved = parameters.iter().map(|parameter| problem.derivative(&[parameter])).collect::<Result<Vec<_>>>()?;
        let found: Vec<Option<Found>> = if let Some(tails) = tails {
            let fit = Fit::new(self, space, tails).ok_or(failed.clone())?;
            let tangent = Tangent::new(problem, system).ok_or(failed.clone())?;
            let along = |moved: &FokkerPlanck| {
                let derivative = tangent.along(moved)?;
                let reference = derivative.values(&self.nodes);
                let (slope, whole) = (fit.slope(&reference)?, derivative.masses());
                Some(Found { slope, reference: Some(reference), whole, doubt: derivative.error })
            };
            moved.par_iter().map(along).collect()
        } else {
            let newton = Newton::new(self, problem, space).ok_or(failed.clone())?;
            let along = |moved: &FokkerPlanck| {
                let slope = newton.slope(moved)?;
                Some(Found { slope, reference: None, whole: Weighted::none(self.dimension()), doubt: 0.0 })
            };
            moved.par_iter().map(along).collect()
        };
        let named = parameters.iter().zip(found);
        named.map(|(parameter, found)| Ok(self.moving_with(parameter, found.ok_or(failed.clone())?))).collect()
    }

    /// What was found, normalised.
    fn moving_with(&self, parameter: &str, found: Found) -> Sensitivity {
        let Found { mut slope, reference, whole, doubt } = found;
        let mean = |values: &[f64], k: usize| -> f64 {
            let sums = values.iter().zip(&self.masses);
            let [sum, mass] = sums.fold([0.0; 2], |[sum, mass], (v, m)| [sum + v * m[k], mass + m[k]]);
            sum / mass
        };
        let own = slope.values(&self.nodes);
        let centre = mean(&own, 0);
        slope.constant -= centre;
        let reference = reference.unwrap_or_else(|| own.clone());
        let other_centre = mean(&reference, 1);
        let both = own.iter().zip(&reference).zip(&self.masses);
        let masses = both.map(|((own, other), m)| [(own - centre) * m[0], (other - other_centre) * m[1]]).collect();
        Sensitivity { density: self.clone(), parameter: parameter.to_owned(), slope, masses, whole, doubt }
    }

    /// All polynomials of the order: a parameter may break the symmetry that the density has.
    fn functions(&self) -> Functions {
        let polynomials = self.exponent().space.polynomials();
        let degree =
            polynomials.map_or(0, |own| own.exponents().iter().map(|alpha| alpha.iter().sum()).max().unwrap_or(0));
        let (centre, half_width) = self.content.domain.box_around();
        let exponents = monomials(self.dimension(), degree).into_iter().filter(|alpha| alpha.iter().any(|a| *a > 0));
        Functions::Polynomials(Polynomials::new(centre, half_width, exponents.collect()))
    }
}

const NOT_SERVED: Error = Error::NotServed {
    method: "closure",
    what: "derivatives by parameters next to walls, under impulses, in three states and more, and of a pilot's own fit",
    remedy: "take differences of two densities, at `Problem::with_parameter`",
};

impl Sensitivity {
    /// The name of the parameter.
    pub fn parameter(&self) -> &str {
        &self.parameter
    }

    /// The density that this is a derivative of.
    pub fn density(&self) -> &ClosureDensity {
        &self.density
    }

    /// ∂ ln p/∂θ at a state, with mean zero under p.
    ///
    /// # Errors
    /// [`Error::Dimension`] if it is no state of the problem.
    pub fn log_derivative(&self, x: &[f64]) -> Result<f64> {
        point(x, self.density.dimension())?;
        Ok(self.slope.value(x))
    }

    /// ∫ |∂p/∂θ| dx.
    pub fn size(&self) -> f64 {
        self.masses.iter().map(|[own, _]| own.abs()).sum()
    }

    /// The estimate of ∫ |∂p̃/∂θ − ∂p/∂θ| dx: the distance from the derivative of the reference, and that derivative's own
    /// error. It is to be compared with [`Sensitivity::size`].
    pub fn l1_estimate(&self) -> f64 {
        let apart: f64 = self.masses.iter().map(|[own, other]| (own - other).abs()).sum();
        apart.hypot(self.doubt)
    }

    /// dE g/dθ.
    pub fn expectation(&self, g: &(dyn Fn(&[f64]) -> f64 + Sync)) -> Estimate {
        let (mut sum, mut other, mut square) = (0.0, 0.0, 0.0);
        for ((x, [own, reference]), masses) in self.density.nodes.iter().zip(&self.masses).zip(&self.density.masses) {
            let value = g(x);
            sum += value * own;
            other += value * reference;
            square += value * value * masses[0];
        }
        // What lies between the edges of the two domains counts as an error.
        let whole: f64 = self.whole.points.iter().zip(&self.whole.masses).map(|(x, mass)| mass * g(x)).sum();
        let apart = (sum - other).abs().max(if self.whole.masses.is_empty() { 0.0 } else { (sum - whole).abs() });
        Estimate::new(sum, apart + (self.doubt + self.rounding()) * square.sqrt())
    }

    /// The derivative of a raw moment, dE\[x₁^p₁ ⋯ x_n^p_n\]/dθ.
    ///
    /// # Errors
    /// [`Error::Dimension`] unless there is a power for each state.
    pub fn moment(&self, powers: &[u32]) -> Result<Estimate> {
        dimension("a list of powers", powers.len(), self.density.dimension())?;
        Ok(self.expectation(&|x| power(x, powers)))
    }

    /// The derivative of P(x_i > `level`) for a state i.
    ///
    /// # Errors
    /// [`Error::Dimension`] if there is no such state, [`Error::OutOfRange`] for a level that is not finite.
    pub fn exceedance(&self, state: usize, level: f64) -> Result<Estimate> {
        coordinate("the state of an exceedance", state, level, self.density.dimension())?;
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
    /// [`Error::Dimension`] in one state, [`Error::OutOfRange`] for a level that is not finite.
    pub fn upcrossing_rate(&self, level: f64) -> Result<Estimate> {
        let [displacement, velocity] = Crossing::upward(finite("level", level)?).states(self.density.dimension())?;
        Ok(self.section(displacement, level, |x| x[velocity].max(0.0)))
    }

    /// ∫ g ∂p/∂θ dx over the other state, with its error by that of the whole derivative where nothing better is known.
    fn section(&self, state: usize, x: f64, g: impl Fn(&[f64]) -> f64) -> Estimate {
        let Integrals::Panels { lines, .. } = &self.density.content.integrals else { return Estimate::exact(0.0) };
        let mut at = vec![0.0; lines.len()];
        at[state] = x;
        let mut sum = 0.0;
        let mut add = |at: &[f64], w: f64| {
            if self.density.content.domain.contains(at) {
                sum += w * g(at) * self.density.exponent().value(at).exp() * self.slope.value(at);
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
        let share = self.l1_estimate() / self.size().max(f64::MIN_POSITIVE) + self.rounding();
        Estimate::new(sum, sum.abs() * share)
    }

    fn rounding(&self) -> f64 {
        tuning::SOLVED * self.size().max(1.0)
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

/// An operator of polynomials at some points.
fn at_points(operator: &FokkerPlanck, points: &States) -> Vec<Local> {
    let n = operator.dimension();
    let divergence = operator.divergence();
    let slopes: Vec<Vec<_>> =
        (0..n).map(|i| (0..n).map(|j| operator.diffusion()[i][j].derivative(j)).collect()).collect();
    let curvatures: Vec<Vec<_>> = (0..n).map(|i| (0..n).map(|j| slopes[i][j].derivative(i)).collect()).collect();
    let local = |x: &[f64]| {
        let mut local = Local::new(n);
        local.drift = operator.drift().iter().map(|f| f.evaluate(x)).collect();
        local.divergence = divergence.evaluate(x);
        for i in 0..n {
            for j in 0..n {
                let parts =
                    [operator.diffusion()[i][j].evaluate(x), slopes[i][j].evaluate(x), curvatures[i][j].evaluate(x)];
                local.add_derivatives(i, j, parts);
            }
        }
        local
    };
    points.iter().map(local).collect()
}
