//! The closures, the robust one and the literature's, against known densities and against a grid's.

mod classical_walls;
mod closed_forms;
mod closest;
mod dynamics;
mod impulses;
mod integrals;
mod many_states;
mod modes;
mod modulated;
mod references;
mod robust;
mod sensitivity;
mod sensitivity_at_walls;
mod sensitivity_in_many_states;
mod sensitivity_under_impulses;
mod thin_states;
mod trajectories;
mod walls;
pub(crate) mod walls_in_many_states;
