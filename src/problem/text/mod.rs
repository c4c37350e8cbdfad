//! Problems as text.

mod family;
mod impulse;
mod read;
mod write;
