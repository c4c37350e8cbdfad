//! The functions that ln p and its corrections are combined from.
//!
//! - `degrees`: which monomials are of an order; `polynomials`: products of Legendre polynomials of them;
//! - `corner`, `similarity`, `wall`, `contact`: the functions next to walls, in two states and in more;
//! - `nested_spaces`: the spaces that an order needs; `orthonormal`: their bases under a weight;
//! - `sweep`: functions at many points.

pub(super) mod degrees;
pub(super) mod nested_spaces;
pub(super) mod orthonormal;
pub(super) mod sweep;

mod contact;
mod contact_products;
mod corner;
mod polynomials;
mod similarity;
mod wall;

pub(crate) use contact::{ContactFunctions, ContactLevel};
pub(in crate::closure) use corner::GrazingMotion;
pub(crate) use corner::{Corner, Kink, SMALLEST};
pub(crate) use polynomials::Polynomials;
pub(crate) use similarity::{CLOSEST, PER_UNIT, STEPS, Similarity, TAYLOR};
pub(super) use wall::{WallFunctions, WallLevel};

use crate::control_variates::products::Products;
use crate::numerics::{EIGHT, Number};
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
    /// The same in more states.
    Contacts(ContactFunctions),
}

impl Functions {
    /// K.
    pub(super) fn len(&self) -> usize {
        match self {
            Functions::Polynomials(functions) => functions.len(),
            Functions::Walls(functions) => functions.len(),
            Functions::Contacts(functions) => functions.len(),
        }
    }

    /// The first so many; all of them next to walls.
    pub(super) fn first(&self, count: usize) -> Self {
        let Functions::Polynomials(all) = self else { return self.clone() };
        let exponents = all.exponents()[..count].to_vec();
        Functions::Polynomials(Polynomials::new(all.centre().to_vec(), all.half_width().to_vec(), exponents))
    }

    /// The number of states.
    pub(super) fn dimension(&self) -> usize {
        match self {
            Functions::Polynomials(functions) => functions.centre().len(),
            Functions::Walls(_) => 2,
            Functions::Contacts(functions) => functions.dimension(),
        }
    }

    /// φ_k at `x`.
    #[inline(always)]
    pub(super) fn values<T: Number>(&self, x: &[T], values: &mut [T]) {
        match self {
            Functions::Polynomials(functions) => functions.values(x, values),
            Functions::Walls(functions) => functions.values(x, values),
            Functions::Contacts(functions) => functions.values(x, values),
        }
    }

    /// φ_k and their mean rates of change f·∇φ_k + ½ B:∇∇φ_k at `x`, B by rows.
    #[inline(always)]
    pub(super) fn rates<T: Number>(&self, x: &[T], local: (&[T], &[T]), values: &mut [T], rates: &mut [T]) {
        match self {
            Functions::Polynomials(functions) => functions.rates(x, local, values, rates),
            Functions::Walls(functions) => functions.rates(x, local, values, rates),
            Functions::Contacts(functions) => functions.rates(x, local, values, rates),
        }
    }

    /// Σ a_k φ_k over as many functions as there are a_k.
    #[inline(always)]
    pub(super) fn sum<T: Number>(&self, x: &[T], a: &[f64]) -> T {
        match self {
            Functions::Polynomials(functions) => functions.added(T::everywhere(0.0), x, a),
            Functions::Walls(functions) => functions.sum(x, a),
            Functions::Contacts(functions) => functions.sum(x, a),
        }
    }

    /// Adds Σ a_k φ_k with its derivatives to `sum`.
    #[inline(always)]
    pub(super) fn combine<T: Number>(&self, x: &[T], a: &[f64], sum: &mut Jet<T>) {
        match self {
            Functions::Polynomials(functions) => functions.combine(x, a, sum),
            Functions::Walls(functions) => functions.combine(x, a, sum),
            Functions::Contacts(functions) => functions.combine(x, a, sum),
        }
    }

    /// The polynomials alone, where there is no more.
    pub(crate) fn polynomials(&self) -> Option<&Polynomials> {
        match self {
            Functions::Polynomials(functions) => Some(functions),
            Functions::Walls(_) | Functions::Contacts(_) => None,
        }
    }

    /// The walls.
    pub(crate) fn corners(&self) -> &[Corner] {
        match self {
            Functions::Polynomials(_) => &[],
            Functions::Walls(functions) => functions.corners(),
            Functions::Contacts(functions) => functions.corners(),
        }
    }

    /// The functions as one list of polynomials and, at each wall, one list of kinks; none where there are several.
    pub(crate) fn single(&self) -> Option<(&Polynomials, &[Kink])> {
        match self {
            Functions::Polynomials(functions) => Some((functions, &[])),
            Functions::Walls(functions) => functions.single(),
            Functions::Contacts(_) => None,
        }
    }

    /// Refuses numbers without a meaning, such as those of a damaged file.
    pub(super) fn checked(self, states: usize) -> Read<Self> {
        Ok(match self {
            Functions::Polynomials(functions) => Functions::Polynomials(functions.checked(states)?),
            Functions::Walls(functions) if states == 2 => Functions::Walls(functions.checked()?),
            Functions::Walls(_) => return Err(format!("functions of a plane are none of {states} states")),
            Functions::Contacts(functions) => Functions::Contacts(functions.checked(states)?),
        })
    }
}

impl Products {
    /// These functions, after the constant; none of those of a plane, which are not products.
    pub(in crate::closure) fn of(functions: &Functions) -> Self {
        match functions {
            Functions::Polynomials(functions) => Products::new(functions),
            Functions::Contacts(functions) => Products::next_to_walls(functions),
            Functions::Walls(_) => Products::default(),
        }
    }
}

/// A value with its derivatives at a point, or at several.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::closure) struct Jet<T> {
    pub(in crate::closure) value: T,
    pub(in crate::closure) gradient: Vec<T>,
    /// By rows.
    pub(in crate::closure) hessian: Vec<T>,
}

impl<T: Number> Jet<T> {
    #[inline(always)]
    pub(in crate::closure) fn zero(states: usize) -> Self {
        let zero = T::everywhere(0.0);
        Jet { value: zero, gradient: vec![zero; states], hessian: vec![zero; states * states] }
    }

    /// Makes all numbers 0 again.
    #[inline(always)]
    pub(in crate::closure) fn clear(&mut self) {
        let zero = T::everywhere(0.0);
        self.value = zero;
        self.gradient.fill(zero);
        self.hessian.fill(zero);
    }

    /// Adds `factor` times the jet of a function of two states.
    #[inline(always)]
    pub(super) fn add(&mut self, factor: f64, other: &PlaneJet<T>) {
        self.value += other.value * factor;
        for i in 0..2 {
            self.gradient[i] += other.gradient[i] * factor;
            for j in 0..2 {
                self.hessian[2 * i + j] += other.hessian[i][j] * factor;
            }
        }
    }
}

/// The same of a function of two states.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::closure) struct PlaneJet<T> {
    pub(in crate::closure) value: T,
    pub(in crate::closure) gradient: [T; 2],
    pub(in crate::closure) hessian: [[T; 2]; 2],
}

impl PlaneJet<f64> {
    pub(super) const ZERO: Self = PlaneJet { value: 0.0, gradient: [0.0; 2], hessian: [[0.0; 2]; 2] };
}

impl<T: Number> PlaneJet<T> {
    /// The jets at single points.
    #[inline(always)]
    pub(super) fn from_points(at: impl Fn(usize) -> PlaneJet<f64>) -> Self {
        let mut jets = [PlaneJet::ZERO; EIGHT];
        (0..T::POINTS).for_each(|point| jets[point] = at(point));
        let slope = |i: usize| T::from_points(|point| jets[point].gradient[i]);
        let bend = |i: usize, j: usize| T::from_points(|point| jets[point].hessian[i][j]);
        PlaneJet {
            value: T::from_points(|point| jets[point].value),
            gradient: [slope(0), slope(1)],
            hessian: [[bend(0, 0), bend(0, 1)], [bend(1, 0), bend(1, 1)]],
        }
    }
}
