#![doc = include_str!("../README.md")]
//!
//! # The library in one page
//!
//! A system dX = f(X) dt + G(X) dW is [`PolynomialDrift`], or [`Oscillator`] for x″ + h(x, x′) = ξ. Everything reads that
//! one definition: [`FokkerPlanck`] for the equation 0 = −∂_i(f_i p) + ½ ∂_i∂_j(B_ij p), B = G Gᵀ; [`Closure`] for p = C exp(Q);
//! [`Simulation`] for trajectories; [`Grid`] for the equation itself, in two states, to seven digits. All answers are a
//! [`Density`], so that any two can be compared ([`compare`]).
//!
//! [`Closure::new`] gives a density at every order, with an estimate of its error: the exponential polynomial that comes
//! closest to a solution of many more moment equations than it has coefficients. [`Closure::classical`] is the literature's
//! method, which asks that the residual r = L exp(Q) / exp(Q) be orthogonal, under a Gaussian f_N, to the polynomials that Q
//! is made of: ∫ r(x; a) ψ_k f_N dx = 0. f_N is the Gaussian closure of the same system, [`Closure::gaussian`].

mod barrier;
mod closure;
pub mod compare;
mod density;
mod error;
mod estimate;
mod fokker_planck;
mod grid;
pub mod models;
mod polynomial;
mod quadrature;
mod scalar;
mod simulation;
mod system;

pub use barrier::{Barrier, Zhuravlev};
pub use closure::{
    Basis, Candidate, ClassicalClosure, Closure, ClosureDensity, ClosureProvenance, Degrees, NodeKind, Origin, Route,
    Solution, Termination, Weight,
};
pub use density::{Crossing, Density, ExpPolynomial, Frame, Support, energy_balance};
pub use error::{Error, Result};
pub use estimate::Estimate;
pub use fokker_planck::{FokkerPlanck, LocalOperator, OperatorText};
pub use grid::{Grid, GridDensity, GridProvenance, Relaxation, Start, Transient};
pub use polynomial::{Arena, Gaussian, Monomial, Polynomial, Symbol, Text, monomials};
pub use scalar::Scalar;
#[doc(hidden)]
pub use scalar::Transcendental;
pub use simulation::{
    Axis, FirstPassage, Histogram, Progress, Provenance, SimulatedDensity, Simulation, Spectrum, Splitting,
    SplittingProvenance, Stopped, Tails, Tolerance,
};
pub use system::{Intensity, Interpretation, Oscillator, PolynomialDrift};
