//! Walls: the barrier, and Zhuravlev's transformation that makes the displacement continuous.

mod zhuravlev;

pub use zhuravlev::Zhuravlev;

use crate::{Error, Result, error::finite};

/// A rigid wall at y = `offset` with the oscillator above it: y ≥ b, and y′₊ = −r y′₋ at each impact.
///
/// The wall need not stand at the rest position: `offset` is b, in the unit of the displacement. `restitution` is r, the
/// ratio of rebound to approach speed, 0 < r ≤ 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Barrier {
    offset: f64,
    restitution: f64,
}

impl Barrier {
    /// A wall at y = `offset` with coefficient of restitution `restitution`.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless the offset is finite and 0 < r ≤ 1.
    pub fn new(offset: f64, restitution: f64) -> Result<Self> {
        finite("offset of the wall", offset)?;
        if !(restitution > 0.0 && restitution <= 1.0) {
            return Err(Error::OutOfRange {
                name: "restitution r",
                value: restitution,
                remedy: "it is the ratio of rebound to approach speed and must satisfy 0 < r ≤ 1",
            });
        }
        Ok(Barrier { offset, restitution })
    }

    /// The wall's position b.
    pub fn offset(&self) -> f64 {
        self.offset
    }

    /// The coefficient of restitution r.
    pub fn restitution(&self) -> f64 {
        self.restitution
    }
}
