//! expoly
mod barrier;
mod density;
mod error;
mod estimate;
mod fokker_planck;
pub mod models;
mod polynomial;
mod scalar;
mod simulation;
mod system;

pub use barrier::Barrier;
pub use density::{Crossing, Density};
pub use error::{Error, Result};
pub use estimate::Estimate;
pub use fokker_planck::{FokkerPlanck, LocalOperator, OperatorText};
pub use polynomial::{Arena, Gaussian, Monomial, Polynomial, Symbol, Text, monomials};
pub use scalar::Scalar;
#[doc(hidden)]
pub use scalar::Transcendental;
pub use simulation::{Axis, Histogram, Progress, Provenance, SimulatedDensity, Simulation};
pub use system::{Intensity, Interpretation, Oscillator, PolynomialDrift};

/// tmp
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Termination {
    Root,
}
impl std::fmt::Display for Termination {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("x")
    }
}
