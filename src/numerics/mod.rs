//! Numerical mathematics for no oscillator in particular: Gauss rules, orthogonal polynomials, eigenvalues, least
//! squares, maxima of concave functions, exponentials of many numbers and of matrices, sixth roots, bisection, sorting, numbers
//! at several points at once.

mod ascent;
mod definite;
#[cfg(test)]
mod differences;
mod eigenvalues;
mod exponential;
mod gram;
mod lanes;
mod least_norm;
pub(crate) mod legendre;
mod propagation;
mod quadrature;
mod regression;
mod resolvent;
mod runge_kutta;
mod search;
mod sixth_root;
mod sorting;
mod tall;

pub(crate) use ascent::{Concave, Search, Summit};
pub(crate) use definite::definite;
#[cfg(test)]
pub(crate) use differences::differences;
pub(crate) use eigenvalues::eigenvalues;
pub(crate) use exponential::exponentials;
pub(crate) use gram::{add_gram, symmetric, weighted_gram};
pub(crate) use lanes::{EIGHT, Eight, Lanes, Number};
pub(crate) use least_norm::least_norm;
pub(crate) use propagation::propagated;
pub(crate) use quadrature::Rule;
pub(crate) use regression::regression;
pub(crate) use resolvent::Resolvent;
pub(crate) use runge_kutta::runge_kutta;
pub(crate) use search::{bisected, kronecker, turn};
pub(crate) use sixth_root::sixth_root;
pub(crate) use sorting::sort_by_number;
pub(crate) use tall::{combination, divide_by_triangle, stretches, triangle, weighted_product, weighted_sum};
