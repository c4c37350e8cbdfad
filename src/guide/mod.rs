//! The method, when to rely on it, how accurate it is, the conventions, and the way here from other tools.
//!
//! 1. [`method`]: from the equation of motion to the density, and the two methods to judge it by;
//! 2. [`trust`]: what to look at before a density is used, what is served and what is not;
//! 3. [`conventions`]: intensities, states, units, Itô or Stratonovich, walls, seeds;
//! 4. [`others`]: the same oscillator in MATLAB, PathIntegrationMethod.jl and FiPy, and here.
//!
//! Measured errors are on one page, [`accuracy`], which a program writes.

#[doc = include_str!("accuracy.md")]
pub mod accuracy {}
#[doc = include_str!("conventions.md")]
pub mod conventions {}
#[doc = include_str!("method.md")]
pub mod method {}
#[doc = include_str!("others.md")]
pub mod others {}
#[doc = include_str!("trust.md")]
pub mod trust {}
