//! The literature's oscillators.
mod duffing;
mod linear;
pub use duffing::Duffing;
pub use linear::Linear;
