//! The grid: stationary densities, relaxation and transients.

mod dynamics;
mod stationary;
