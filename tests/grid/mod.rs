//! The grid: stationary densities, walls, relaxation and transients.

mod dynamics;
mod stationary;
mod walls;
