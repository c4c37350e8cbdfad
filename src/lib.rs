#![doc = include_str!("../README.md")]
//!
//! # The library in one page
//!
//! A system dX = f(X) dt + G(X) dW is [`PolynomialDrift`], or [`Oscillator`] for x″ + h(x, x′) = ξ. Everything reads that
//! one definition:
//!
//! | question | where |
//! |---|---|
//! | What is its equation 0 = −∂_i(f_i p) + ½ ∂_i∂_j(B_ij p), B = G Gᵀ? | [`FokkerPlanck`] |
//! | What is its density, as a formula p = C exp(Q)? | [`Closure`]; above a wall, with [`Barrier`] |
//! | Is that right? | [`ClosureDensity::l1_estimate`]; [`Grid`], [`Simulation`], [`compare`] |
//! | What lies in the far tail? | [`Splitting`] |
//! | How likely, how often, how soon? | [`statistics`] |
//! | How do I take it elsewhere: LaTeX, Python, Rust, MATLAB, JSON? | [`ClosedForm`] |
//! | Which order is enough, what depends on a parameter? | [`study`] |
//! | Which systems are solved? | [`models`] |
//!
//! All answers are a [`Density`], whichever method made them. The [`guide`] says how the method works, when to trust it, what
//! the conventions are, and how to come here from other tools.

mod barrier;
mod closed_form;
mod closure;
pub mod compare;
mod density;
mod eigenvalues;
mod error;
mod estimate;
mod file;
mod fokker_planck;
mod grid;
#[doc = include_str!("guide.md")]
pub mod guide {}
pub mod models;
mod polynomial;
mod quadrature;
mod record;
mod scalar;
mod simulation;
pub mod statistics;
pub mod study;
mod system;

pub use barrier::{Barrier, Zhuravlev};
pub use closed_form::{ClosedDensity, ClosedForm};
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
