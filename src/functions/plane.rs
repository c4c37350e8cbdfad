//! Functions of a plane, (u, w) with two linear forms of the state.

use crate::numerics::{EIGHT, Number};

/// A state, or a difference of two states, with a sign and without a constant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Form {
    pub(crate) sign: f64,
    pub(crate) first: usize,
    pub(crate) second: Option<usize>,
}

impl Form {
    /// Its states with their coefficients.
    pub(crate) fn parts(&self) -> impl Iterator<Item = (usize, f64)> + use<> {
        std::iter::once((self.first, self.sign)).chain(self.second.map(|second| (second, -self.sign)))
    }

    /// The same combination of numbers that belong to the states.
    #[inline(always)]
    pub(crate) fn of<T: Number>(&self, x: &[T]) -> T {
        let mut form = T::everywhere(0.0);
        for (i, sign) in self.parts() {
            form += x[i] * sign;
        }
        form
    }

    /// B of this form and another, from B of `n` states by rows.
    #[inline(always)]
    pub(crate) fn diffusion<T: Number>(&self, other: &Form, b: &[T], n: usize) -> T {
        let mut sum = T::everywhere(0.0);
        for (i, first) in self.parts() {
            for (j, second) in other.parts() {
                sum += b[i * n + j] * (first * second);
            }
        }
        sum
    }
}

/// A function of (u, w) with its derivatives, at a point or at several.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PlaneJet<T> {
    pub(crate) value: T,
    pub(crate) gradient: [T; 2],
    pub(crate) hessian: [[T; 2]; 2],
}

impl PlaneJet<f64> {
    pub(crate) const ZERO: Self = PlaneJet { value: 0.0, gradient: [0.0; 2], hessian: [[0.0; 2]; 2] };
}

impl<T: Number> PlaneJet<T> {
    /// The jets at single points.
    #[inline(always)]
    pub(crate) fn from_points(at: impl Fn(usize) -> PlaneJet<f64>) -> Self {
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

    /// Adds `factor` times the derivatives in the states.
    #[inline(always)]
    pub(crate) fn add_gradient(&self, forms: &[Form; 2], factor: T, gradient: &mut [T]) {
        for (form, slope) in forms.iter().zip(self.gradient) {
            for (i, sign) in form.parts() {
                gradient[i] += factor * slope * sign;
            }
        }
    }
}

/// An operator b·∇ + ½ B:∇∇ on functions of (u, w).
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlaneOperator<T> {
    first: [T; 2],
    /// B of u with itself, of u with w, and of w with itself.
    second: [T; 3],
}

impl<T: Number> PlaneOperator<T> {
    /// From b and B, by rows, of the states.
    #[inline(always)]
    pub(crate) fn new([u, w]: &[Form; 2], first: &[T], second: &[T]) -> Self {
        let b = |form: &Form, other: &Form| form.diffusion(other, second, first.len());
        PlaneOperator { first: [u.of(first), w.of(first)], second: [b(u, u), b(u, w), b(w, w)] }
    }

    /// b·∇f + ½ B:∇∇f.
    #[inline(always)]
    pub(crate) fn image(&self, jet: &PlaneJet<T>) -> T {
        let ([u, w], [[of_uu, of_uw], [_, of_ww]]) = (jet.gradient, jet.hessian);
        let [uu, uw, ww] = self.second;
        let bent = (uu * of_uu + ww * of_ww) * 0.5 + uw * of_uw;
        self.first[0] * u + self.first[1] * w + bent
    }
}
