//! Parameters from measured states, and from a demand.

mod design;
mod identification;
