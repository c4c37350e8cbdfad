#![doc = include_str!("../README.md")]
//!
//! # The library in one page
//!
//! A system dX = f(X) dt + G(X) dW, perhaps under Poisson impulses ([`PoissonImpulses`]) too, is a [`Drift`], an [`Oscillator`] for x″ + h(x, x′) = ξ, or a [`System`]
//! of any size, written over [`Scalar`]: polynomials, and functions such as sines and moduli. A [`Problem`] is that system as data, with its walls; every method takes one:
//!
//! | question | where |
//! |---|---|
//! | What is its equation 0 = −∂_i(f_i p) + ½ ∂_i∂_j(B_ij p), B = G Gᵀ? | [`Problem::operator`], [`FokkerPlanck`] |
//! | What is its density, as a formula p = C exp(Q)? | [`Closure`]; above a wall as well, with [`Wall`] |
//! | Is that right? | [`ClosureDensity::l1_estimate`]; [`Grid`], [`Simulation`], [`compare`] |
//! | What lies in the far tail? | [`Splitting`] |
//! | How does it come about from a start, under noise that rises and fades as well? | [`Closure::transient`], [`GridDensity::transient`], [`Simulation::transient`] on a [`Course`]; [`ClosureDensity::relaxation`] |
//! | How likely, how often, how soon? | [`statistics`]; [`Survival`] without Poisson's assumption |
//! | Which parameter matters, and how much? | [`Sensitivity`] by [`ClosureDensity::sensitivities`] and [`GridDensity::sensitivities`]; [`Problem::parameters`], [`Parametric`], [`Problem::derivative`] |
//! | Which parameters do measurements have, or does a demand need? | [`inverse`] |
//! | How do I take it elsewhere: LaTeX, Python, MATLAB, JSON? | [`ClosedForm`] |
//! | Which order is enough, what depends on a parameter? | [`study`] |
//! | Which systems are solved? | [`models`] |
//!
//! The answer of every method is a [`Density`]. The [`guide`] explains the method, when to rely on it, the conventions, and
//! the way here from other tools.

mod checks;
mod closed_form;
mod closure;
pub mod compare;
mod density;
mod elementary;
mod envelope;
mod error;
mod estimate;
mod field;
mod file;
mod fokker_planck;
mod functions;
mod grid;
pub mod guide;
pub mod inverse;
mod memory;
mod method;
pub mod models;
mod numerics;
mod parallel;
mod polynomial;
mod problem;
mod provenance;
mod record;
mod scalar;
mod sensitivity;
mod simulation;
mod states;
pub mod statistics;
pub mod study;
mod system;
mod transient;
mod walls;

pub use closed_form::ClosedForm;
pub use closure::{
    Basis, Candidate, ClassicalClosure, Closure, ClosureDensity, ClosureSensitivity, Degrees, Origin, Reference,
    Solution, Termination, Weight,
};
pub use density::{Crossing, Density, ExpPolynomial, Support};
pub use elementary::Elementary;
pub use envelope::Envelope;
pub use error::{Error, Result};
pub use estimate::Estimate;
pub use fokker_planck::{FokkerPlanck, Impulse};
pub use grid::{Grid, GridDensity, GridProgress, GridSensitivity, Survival};
pub use method::Method;
pub use polynomial::{Gaussian, Polynomial};
pub use problem::{Definition, Problem, Surface};
pub use provenance::{Provenance, Stopped};
pub use scalar::Scalar;
pub use sensitivity::Sensitivity;
pub use simulation::{
    FirstPassage, Histogram, Progress, SimulatedDensity, Simulation, Spectrum, Splitting, Tails, Tolerance,
};
pub use states::States;
pub use system::{
    Amplitude, Drift, Intensity, Interpretation, Oscillator, Parameter, Parameters, Parametric, PoissonImpulses, System,
};
pub use transient::{Course, Relaxation, Start, Transient};
pub use walls::Wall;
