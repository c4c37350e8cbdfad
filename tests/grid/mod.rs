//! The grid: stationary densities, walls, relaxation, transients, modulated noise and survival.

mod dynamics;
mod modulated;
mod soft_walls;
mod stationary;
mod survival;
mod walls;
