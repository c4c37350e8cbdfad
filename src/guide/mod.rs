//! The method, when to rely on it, how accurate it is, the conventions, and the way here from other tools.
//!
//! 1. [`method`]: from the equation of motion to the density, and the two methods to judge it by;
//! 2. [`trust`]: what to look at before a density is used, and what it cannot do;
//! 3. [`accuracy`]: measured errors, each with the program that prints it;
//! 4. [`conventions`]: intensities, states, units, Itô or Stratonovich, walls, seeds;
//! 5. [`decisions`]: exceedances, first passages, derivatives by parameters, formulas for elsewhere;
//! 6. [`others`]: the same oscillator in MATLAB, PathIntegrationMethod.jl and FiPy, and here;
//! 7. [`programs`]: the examples, a question each, and the programs that measure the library.

#[doc = include_str!("accuracy.md")]
pub mod accuracy {}
#[doc = include_str!("conventions.md")]
pub mod conventions {}
#[doc = include_str!("decisions.md")]
pub mod decisions {}
#[doc = include_str!("method.md")]
pub mod method {}
#[doc = include_str!("others.md")]
pub mod others {}
#[doc = include_str!("programs.md")]
pub mod programs {}
#[doc = include_str!("trust.md")]
pub mod trust {}
