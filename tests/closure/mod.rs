//! The closures, the robust one and the literature's, where the truth is known and where a grid knows it.

mod classical_walls;
mod closed_forms;
mod many_states;
mod references;
mod robust;
mod walls;
