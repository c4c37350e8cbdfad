//! The grid: stationary densities, walls, derivatives by parameters, relaxation, transients, modulated noise and survival.

mod dynamics;
mod modulated;
mod sensitivity;
mod soft_walls;
mod stationary;
mod survival;
mod walls;
