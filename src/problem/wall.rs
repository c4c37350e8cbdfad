use crate::checks::finite;
use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};

/// The warning of every method for a wall that trajectories collapse onto.
pub(crate) const COLLAPSE: &str = "the restitution is at most 0.163, where grazing impacts do not end: the impact rate is infinite, and \
    what is found of it is that of the shortest step or the smallest cell";

/// A rigid wall that a displacement y hits: y′₊ = −r y′₋ at y = b.
///
/// The motion stays above it, y ≥ b, or below it, y ≤ b. The wall need not stand at the rest position: `offset` is b, in the
/// unit of the displacement. `restitution` is r, the ratio of rebound to approach speed, 0 < r ≤ 1. For r ≤ 0.163 white noise lets
/// trajectories collapse onto the wall after infinitely many impacts: moments stay finite, but the impact rate is infinite,
/// and every method's provenance carries a warning.
///
/// ```
/// use expoly::{Wall, models::{Duffing, Solved}};
/// // Between two walls.
/// let duffing = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?;
/// let problem = duffing.with_wall(Wall::above(-0.5, 0.9)?)?.with_wall(Wall::below(1.0, 0.8)?)?;
/// assert_eq!(problem.walls().len(), 2);
/// # Ok::<(), expoly::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wall {
    state: usize,
    offset: f64,
    restitution: f64,
    above: bool,
}

impl Wall {
    /// The wall with the motion above it: y ≥ `offset`, on state 0.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless the offset is finite and 0 < r ≤ 1.
    pub fn above(offset: f64, restitution: f64) -> Result<Self> {
        Wall { state: 0, offset, restitution, above: true }.checked()
    }

    /// The wall with the motion below it: y ≤ `offset`, on state 0.
    ///
    /// # Errors
    /// As [`Wall::above`].
    pub fn below(offset: f64, restitution: f64) -> Result<Self> {
        Wall { state: 0, offset, restitution, above: false }.checked()
    }

    /// The same wall on another state.
    #[must_use]
    pub fn on(self, state: usize) -> Self {
        Wall { state, ..self }
    }

    /// Refuses numbers without a meaning, such as those of a damaged file.
    pub(crate) fn checked(self) -> Result<Self> {
        finite("offset of the wall", self.offset)?;
        if !(self.restitution > 0.0 && self.restitution <= 1.0) {
            return Err(Error::OutOfRange {
                name: "restitution r",
                value: self.restitution,
                remedy: "it is the ratio of rebound to approach speed and must satisfy 0 < r ≤ 1",
            });
        }
        Ok(self)
    }

    /// The displacement's state.
    pub fn state(&self) -> usize {
        self.state
    }

    /// The wall's position b.
    pub fn offset(&self) -> f64 {
        self.offset
    }

    /// The coefficient of restitution r.
    pub fn restitution(&self) -> f64 {
        self.restitution
    }

    /// Whether white noise presses trajectories that graze the wall onto it, after infinitely many impacts: for r ≤ e^(−π/√3)
    /// (S. J. Cornell, M. R. Swift and A. J. Bray, 1998, doi:10.1103/PhysRevLett.81.1142).
    pub(crate) fn collapses(&self) -> bool {
        self.restitution <= (-std::f64::consts::PI / 3.0_f64.sqrt()).exp()
    }

    /// Whether the motion is above the wall.
    pub fn is_above(&self) -> bool {
        self.above
    }
}
