//! The functions that ln p and its corrections are combined from.
//!
//! - `degrees`: which monomials are of an order; `polynomials`: products of Legendre polynomials of them;
//! - `corner`, `similarity`, `wall`: the singularity of grazing impacts, and the functions that have it;
//! - `functions`: lists of both; `products`: the same lists for sweeps over many states;
//! - `nested_spaces`: the spaces that an order needs; `orthonormal`: their bases under a weight;
//! - `sweep`: functions at many points.

pub(super) mod degrees;
pub(super) mod nested_spaces;
pub(super) mod orthonormal;
pub(super) mod sweep;

mod corner;
mod functions;
mod polynomials;
mod products;
mod similarity;
mod wall;

pub(in crate::closure) use corner::GrazingMotion;
pub(crate) use corner::{Corner, SMALLEST};
pub(crate) use functions::Functions;
pub(crate) use polynomials::Polynomials;
pub(crate) use similarity::{CLOSEST, PER_UNIT, STEPS, Similarity, TAYLOR};
pub(super) use wall::WallLevel;

use crate::numerics::{EIGHT, Number};

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
