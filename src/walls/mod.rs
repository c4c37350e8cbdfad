//! Walls, and how motions meet them.
//!
//! - `wall`: a wall on a displacement, or between two bodies;
//! - `contact`: the gap, its rate, and impacts;
//! - `room`: what walls leave of the displacements.

mod contact;
mod room;
mod wall;

pub(crate) use contact::Contact;
pub(crate) use room::{inside, is_room, reflect};
pub use wall::Wall;
pub(crate) use wall::{COLLAPSE, limits};
