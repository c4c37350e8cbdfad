//! Checks of what is given to the library: numbers, points, indices, lengths.

use crate::error::{Error, Result};

/// Refuses a number unless its condition `holds`.
pub(crate) fn require(holds: bool, name: &'static str, value: f64, remedy: &'static str) -> Result<f64> {
    if holds { Ok(value) } else { Err(Error::OutOfRange { name, value, remedy }) }
}

/// Refuses a number that is not finite and positive.
pub(crate) fn positive(name: &'static str, value: f64, remedy: &'static str) -> Result<f64> {
    require(value.is_finite() && value > 0.0, name, value, remedy)
}

/// Refuses a number that is NaN or infinite.
pub(crate) fn finite(name: &'static str, value: f64) -> Result<f64> {
    require(value.is_finite(), name, value, "it must be a finite number")
}

/// Refuses a part of a number of parts that does not exist.
pub(crate) fn part(k: usize, parts: usize) -> Result<f64> {
    require((1..=parts).contains(&k), "number of the part", k as f64, "parts are counted from 1 to their number")
}

/// Refuses the index of a state that does not exist.
pub(crate) fn state_index(what: &'static str, index: usize, states: usize) -> Result<usize> {
    if index < states { Ok(index) } else { Err(Error::Dimension { what, expected: states, found: index }) }
}

/// Refuses a list that has not one number for each state.
pub(crate) fn dimension(what: &'static str, found: usize, states: usize) -> Result<()> {
    if found == states { Ok(()) } else { Err(Error::Dimension { what, expected: states, found }) }
}

/// Refuses a point that has not one finite number for each state.
pub(crate) fn point(x: &[f64], states: usize) -> Result<()> {
    dimension("a state", x.len(), states)?;
    x.iter().try_for_each(|&x| finite("coordinate of a state", x).map(|_| ()))
}

/// Refuses the value of a state that does not exist, or that is no finite number.
pub(crate) fn coordinate(what: &'static str, state: usize, x: f64, states: usize) -> Result<usize> {
    finite("coordinate of a state", x)?;
    state_index(what, state, states)
}
