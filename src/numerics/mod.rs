//! Numerical mathematics for no oscillator in particular: Gauss rules, orthogonal polynomials, eigenvalues.

mod eigenvalues;
pub(crate) mod legendre;
mod quadrature;

pub(crate) use eigenvalues::eigenvalues;
pub(crate) use quadrature::Rule;
