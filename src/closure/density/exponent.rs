use crate::closure::space::{Corner, Functions, Jet};
use crate::fokker_planck::Local;
use crate::record::Read;
use crate::states::States;
use rayon::prelude::*;
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
    pub(in crate::closure) fn value(&self, x: &[f64]) -> f64 {
        self.constant + self.space.sum(x, &self.coefficients) + known_value(&self.known, x)
    }

    /// The values at many states.
    pub(in crate::closure) fn values(&self, points: &States) -> Vec<f64> {
        points.par_iter().map(|x| self.value(x)).collect()
    }

    /// The value with its derivatives.
    pub(in crate::closure) fn jet(&self, x: &[f64], jet: &mut Jet) {
        jet.clear();
        self.space.combine(x, &self.coefficients, jet);
        jet.value += self.constant;
        self.known.iter().for_each(|corner| corner.add_singular(x, jet));
    }

    /// The residual of exp(Q) at many states, given the Fokker-Planck operator there.
    pub(in crate::closure) fn residuals<'a>(
        &self,
        points: &States,
        locals: impl IndexedParallelIterator<Item = &'a Local>,
    ) -> Vec<f64> {
        let residual = |jet: &mut Jet, (x, local): (&[f64], &Local)| {
            self.jet(x, jet);
            local.residual(&jet.gradient, &jet.hessian)
        };
        points.par_iter().zip(locals).map_init(|| Jet::zero(points.dimension()), residual).collect()
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
        if !known.is_empty() && states != 2 {
            return Err(format!("walls stand in two states, not in {states}"));
        }
        let known = known.into_iter().map(Corner::checked).collect::<Read<_>>()?;
        Ok(Exponent { known, space, constant, coefficients })
    }
}

/// Q₀ at a state.
pub(in crate::closure) fn known_value(known: &[Corner], x: &[f64]) -> f64 {
    known.iter().map(|corner| corner.singular_value(x)).sum()
}
