//! The grid: stationary densities, walls, derivatives by parameters, relaxation, transients, modulated noise and survival.

mod dynamics;
mod in_space;
mod modulated;
mod one_state;
mod sensitivity;
mod stationary;
mod survival;
mod walls;
