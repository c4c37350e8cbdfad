//! expoly
mod barrier;
mod closure;
pub mod compare;
mod density;
mod error;
mod estimate;
mod fokker_planck;
pub mod models;
mod polynomial;
mod quadrature;
mod scalar;
mod simulation;
mod system;

pub use barrier::{Barrier, Zhuravlev};
pub use closure::{Basis, Closure, Route, Solution, Termination};
pub use density::{Crossing, Density, ExpPolynomial, Frame, Support, energy_balance};
pub use error::{Error, Result};
pub use estimate::Estimate;
pub use fokker_planck::{FokkerPlanck, LocalOperator, OperatorText};
pub use polynomial::{Arena, Gaussian, Monomial, Polynomial, Symbol, Text, monomials};
pub use scalar::Scalar;
#[doc(hidden)]
pub use scalar::Transcendental;
pub use simulation::{Axis, Histogram, Progress, Provenance, SimulatedDensity, Simulation};
pub use system::{Intensity, Interpretation, Oscillator, PolynomialDrift};
