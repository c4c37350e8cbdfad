//! The functions that ln p and its corrections are combined from.
//!
//! - `degrees`: which monomials are of an order; `polynomials`: products of Legendre polynomials of them;
//! - `corner`, `similarity`, `wall`: the functions next to walls;
//! - `nested_spaces`: the spaces that an order needs; `orthonormal`: their bases under a weight.

pub(super) mod degrees;
pub(super) mod nested_spaces;
pub(super) mod orthonormal;

mod corner;
mod polynomials;
mod similarity;
mod wall;

pub(crate) use corner::{Corner, Kink, SMALLEST};
pub(crate) use polynomials::Polynomials;
pub(crate) use similarity::{CLOSEST, PER_UNIT, STEPS, Similarity, TAYLOR};
pub(super) use wall::{WallFunctions, WallLevel};

use crate::record::Read;
use serde::{Deserialize, Serialize};

/// A list of functions φ₁ … φ_K of the state, without the constant, in order of rising degree.
///
/// The lists are nested: those of a smaller degree come first in the list of a larger one.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Functions {
    /// In any number of states.
    Polynomials(Polynomials),
    /// Polynomials of two states, and functions with the singularity of grazing impacts.
    Walls(WallFunctions),
}

impl Functions {
    /// K.
    pub(super) fn len(&self) -> usize {
        match self {
            Functions::Polynomials(functions) => functions.len(),
            Functions::Walls(functions) => functions.len(),
        }
    }

    /// The number of states.
    pub(super) fn dimension(&self) -> usize {
        match self {
            Functions::Polynomials(functions) => functions.centre().len(),
            Functions::Walls(_) => 2,
        }
    }

    /// φ_k at `x`.
    pub(super) fn values(&self, x: &[f64], values: &mut [f64]) {
        match self {
            Functions::Polynomials(functions) => functions.values(x, values),
            Functions::Walls(functions) => functions.values(x, values),
        }
    }

    /// φ_k and their mean rates of change f·∇φ_k + ½ B:∇∇φ_k at `x`, B by rows.
    pub(super) fn rates(&self, x: &[f64], local: (&[f64], &[f64]), values: &mut [f64], rates: &mut [f64]) {
        match self {
            Functions::Polynomials(functions) => functions.rates(x, local, values, rates),
            Functions::Walls(functions) => functions.rates(x, local, values, rates),
        }
    }

    /// Σ a_k φ_k over as many functions as there are a_k.
    pub(super) fn sum(&self, x: &[f64], a: &[f64]) -> f64 {
        match self {
            Functions::Polynomials(functions) => functions.added(0.0, x, a),
            Functions::Walls(functions) => functions.sum(x, a),
        }
    }

    /// Adds Σ a_k φ_k with its derivatives to `sum`.
    pub(super) fn combine(&self, x: &[f64], a: &[f64], sum: &mut Jet) {
        match self {
            Functions::Polynomials(functions) => functions.combine(x, a, sum),
            Functions::Walls(functions) => functions.combine(x, a, sum),
        }
    }

    /// The polynomials alone, where there is no more.
    pub(crate) fn polynomials(&self) -> Option<&Polynomials> {
        match self {
            Functions::Polynomials(functions) => Some(functions),
            Functions::Walls(_) => None,
        }
    }

    /// The walls.
    pub(crate) fn corners(&self) -> &[Corner] {
        match self {
            Functions::Polynomials(_) => &[],
            Functions::Walls(functions) => functions.corners(),
        }
    }

    /// The functions as one list of polynomials and, at each wall, one list of kinks; none where there are several.
    pub(crate) fn single(&self) -> Option<(&Polynomials, &[Kink])> {
        match self {
            Functions::Polynomials(functions) => Some((functions, &[])),
            Functions::Walls(functions) => functions.single(),
        }
    }

    /// Refuses numbers without a meaning, such as those of a damaged file.
    pub(super) fn checked(self, states: usize) -> Read<Self> {
        Ok(match self {
            Functions::Polynomials(functions) => Functions::Polynomials(functions.checked(states)?),
            Functions::Walls(functions) if states == 2 => Functions::Walls(functions.checked()?),
            Functions::Walls(_) => return Err(format!("walls stand in two states, not in {states}")),
        })
    }
}

/// A value with its derivatives at a point.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::closure) struct Jet {
    pub(in crate::closure) value: f64,
    pub(in crate::closure) gradient: Vec<f64>,
    /// By rows.
    pub(in crate::closure) hessian: Vec<f64>,
}

impl Jet {
    pub(in crate::closure) fn zero(states: usize) -> Self {
        Jet { value: 0.0, gradient: vec![0.0; states], hessian: vec![0.0; states * states] }
    }

    /// Makes all numbers 0 again.
    pub(in crate::closure) fn clear(&mut self) {
        self.value = 0.0;
        self.gradient.fill(0.0);
        self.hessian.fill(0.0);
    }

    /// Adds `factor` times the jet of a function of two states.
    pub(super) fn add(&mut self, factor: f64, other: &PlaneJet) {
        self.value += factor * other.value;
        for i in 0..2 {
            self.gradient[i] += factor * other.gradient[i];
            for j in 0..2 {
                self.hessian[2 * i + j] += factor * other.hessian[i][j];
            }
        }
    }
}

/// The same of a function of two states.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PlaneJet {
    pub(super) value: f64,
    pub(super) gradient: [f64; 2],
    pub(super) hessian: [[f64; 2]; 2],
}

impl PlaneJet {
    pub(super) const ZERO: Self = PlaneJet { value: 0.0, gradient: [0.0; 2], hessian: [[0.0; 2]; 2] };
}
