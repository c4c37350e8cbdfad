//! The grid: stationary densities, walls, relaxation and transients.

mod dynamics;
mod soft_walls;
mod stationary;
mod walls;
