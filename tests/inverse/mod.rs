//! Parameters from measured states.

mod identification;
