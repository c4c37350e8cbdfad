use crate::closure::SOLVED;
use crate::closure::space::sweep::{self, Differentiable, Function};
use crate::closure::space::{Corner, Functions, Jet};
use crate::density::escape_direction;
use crate::fokker_planck::Local;
use crate::numerics::Number;
use crate::record::Read;
use crate::states::States;
use serde::{Deserialize, Serialize};

/// ln p = Q₀ + c + Σ a_k φ_k.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Exponent {
    /// The walls whose grazing impacts make Q₀, which no function here can follow.
    pub(crate) known: Vec<Corner>,
    /// φ.
    pub(crate) space: Functions,
    /// c.
    pub(crate) constant: f64,
    /// a.
    pub(crate) coefficients: Vec<f64>,
}

impl Exponent {
    #[inline(always)]
    pub(in crate::closure) fn value<T: Number>(&self, x: &[T]) -> T {
        self.space.sum(x, &self.coefficients) + self.constant + known_value(&self.known, x)
    }

    /// The values at many states.
    pub(in crate::closure) fn values(&self, points: &States) -> Vec<f64> {
        sweep::values(self, points)
    }

    /// Whether Q is a polynomial that falls in every direction.
    pub(in crate::closure) fn is_normalisable(&self) -> bool {
        self.space.polynomials().is_some_and(|polynomials| {
            let q = polynomials.in_powers(&self.coefficients);
            let least = SOLVED * q.max_coefficient();
            escape_direction(&q.filtered(|_, c| c.abs() > least), false, SOLVED).is_none()
        })
    }

    /// The residual of exp(Q) at many states, given the Fokker-Planck operator there.
    pub(in crate::closure) fn residuals<'a>(
        &self,
        points: &States,
        local: impl Fn(usize) -> &'a Local + Sync,
    ) -> Vec<f64> {
        sweep::at_jets(self, points, |i, gradient, hessian| local(i).residual(gradient, hessian))
    }

    /// Refuses numbers without a meaning, such as those of a damaged file.
    pub(in crate::closure) fn checked(self, states: usize) -> Read<Self> {
        let Exponent { known, space, constant, coefficients } = self;
        let space = space.checked(states)?;
        if coefficients.len() != space.len() {
            return Err(format!("there are {} coefficients for {} functions", coefficients.len(), space.len()));
        }
        if let Some(value) = coefficients.iter().chain([&constant]).find(|value| !value.is_finite()) {
            return Err(format!("a coefficient is {value}"));
        }
        let known = known.into_iter().map(|corner| corner.checked(states)).collect::<Read<_>>()?;
        Ok(Exponent { known, space, constant, coefficients })
    }
}

impl Function for Exponent {
    #[inline(always)]
    fn at<T: Number>(&self, x: &[T]) -> T {
        self.value(x)
    }
}

impl Differentiable for Exponent {
    #[inline(always)]
    fn jet<T: Number>(&self, x: &[T], jet: &mut Jet<T>) {
        jet.clear();
        self.space.combine(x, &self.coefficients, jet);
        jet.value = jet.value + self.constant;
        self.known.iter().for_each(|corner| corner.add_singular(x, jet));
    }
}

/// Q₀ at many states.
pub(in crate::closure) fn known_values(known: &[Corner], points: &States) -> Vec<f64> {
    if known.is_empty() { vec![0.0; points.len()] } else { sweep::values(&Known(known), points) }
}

struct Known<'a>(&'a [Corner]);

impl Function for Known<'_> {
    #[inline(always)]
    fn at<T: Number>(&self, x: &[T]) -> T {
        known_value(self.0, x)
    }
}

/// Q₀ at a state.
#[inline(always)]
pub(in crate::closure) fn known_value<T: Number>(known: &[Corner], x: &[T]) -> T {
    let mut sum = T::everywhere(0.0);
    for corner in known {
        sum += corner.singular_value(x);
    }
    sum
}
