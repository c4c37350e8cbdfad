use crate::checks::finite;
use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};

/// The warning of every method for a wall that trajectories collapse onto.
pub(crate) const COLLAPSE: &str = "the restitution is at most 0.163, where grazing impacts do not end: the impact rate is infinite, and \
    what is found of it is that of the shortest step or the smallest cell";

/// A rigid wall that a displacement y hits, or that two bodies are to each other: ẏ₊ = −r ẏ₋ at y = b.
///
/// The motion stays above it, y ≥ b, or below it, y ≤ b. The wall need not stand at the rest position: `offset` is b, in the
/// unit of the displacement. `restitution` is r, the ratio of rebound to approach speed, 0 < r ≤ 1. Between two bodies y is
/// the difference y_i − y_j of their displacements, and impacts keep their momentum ([`Wall::between`]).
///
/// Where white noise acts on the velocity ẏ, r ≤ 0.163 lets trajectories collapse onto the wall after infinitely many impacts:
/// moments stay finite, but the impact rate is infinite, and every method's provenance carries a warning. Where none does and
/// r < 1, as behind a filter, a trajectory that is pressed onto the wall comes to rest there after infinitely many impacts, and
/// stays until its acceleration points away from it. There is no density then: the simulation is the method for such a wall.
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
    /// The other body of two.
    partner: Option<Partner>,
    offset: f64,
    restitution: f64,
    above: bool,
}

/// The body whose displacement is subtracted.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Partner {
    state: usize,
    /// The masses of the first body and of this one.
    masses: [f64; 2],
}

impl Wall {
    /// The wall with the motion above it: y ≥ `offset`, on state 0.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless the offset is finite and 0 < r ≤ 1.
    pub fn above(offset: f64, restitution: f64) -> Result<Self> {
        Wall { state: 0, partner: None, offset, restitution, above: true }.checked()
    }

    /// The wall with the motion below it: y ≤ `offset`, on state 0.
    ///
    /// # Errors
    /// As [`Wall::above`].
    pub fn below(offset: f64, restitution: f64) -> Result<Self> {
        Wall { state: 0, partner: None, offset, restitution, above: false }.checked()
    }

    /// The same wall on another state.
    #[must_use]
    pub fn on(self, state: usize) -> Self {
        Wall { state, partner: None, ..self }
    }

    /// The same wall between two bodies with displacements y_i and y_j and the masses m_i and m_j: y = y_i − y_j.
    ///
    /// An impact changes ẏ_i by −(1 + r) ẏ m_j/(m_i + m_j) and ẏ_j by (1 + r) ẏ m_i/(m_i + m_j): the momentum
    /// m_i ẏ_i + m_j ẏ_j is kept, and ½ m (1 − r²) ẏ² is lost with the reduced mass m = m_i m_j/(m_i + m_j). Only the ratio
    /// of the masses matters to the motion.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless both masses are finite and positive.
    ///
    /// ```
    /// use expoly::{Wall, models::{Duffing, TunedAbsorber}};
    /// // Stops half a unit to each side of an absorber of a tenth of the mass.
    /// let absorber = TunedAbsorber::new(Duffing::new(0.04, 1.0, 0.0, 0.03)?, 0.1, 0.09, 0.03)?.problem()?;
    /// let stops = [Wall::above(-0.5, 0.8)?, Wall::below(0.5, 0.8)?];
    /// let problem = stops.into_iter().try_fold(absorber, |problem, wall| problem.with_wall(wall.between([0, 1], [1.0, 0.1])?))?;
    /// assert!((problem.walls()[0].mass() - 1.0 / 11.0).abs() < 1e-15);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn between(self, [state, other]: [usize; 2], masses: [f64; 2]) -> Result<Self> {
        Wall { state, partner: Some(Partner { state: other, masses }), ..self }.checked()
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
        for &mass in self.partner.iter().flat_map(|partner| &partner.masses) {
            let ratio = self.mass() / mass;
            if !(mass > 0.0 && mass.is_finite() && ratio > 0.0) {
                let remedy = "two bodies that hit each other have finite masses above zero";
                return Err(Error::OutOfRange { name: "mass of a body", value: mass, remedy });
            }
        }
        Ok(self)
    }

    /// The displacement's state; of two bodies the first one's.
    pub fn state(&self) -> usize {
        self.state
    }

    /// The state of the displacement that is subtracted, between two bodies.
    pub fn other(&self) -> Option<usize> {
        self.partner.map(|partner| partner.state)
    }

    /// The masses m_i and m_j of two bodies.
    pub fn masses(&self) -> Option<[f64; 2]> {
        self.partner.map(|partner| partner.masses)
    }

    /// The mass whose kinetic energy with the velocity ẏ impacts reduce: 1 for a displacement alone, whose equation is one for
    /// each unit of mass, and m_i m_j/(m_i + m_j) between two bodies.
    pub fn mass(&self) -> f64 {
        self.partner.map_or(1.0, |Partner { masses: [first, second], .. }| first * (second / (first + second)))
    }

    /// The parts of a change of ẏ that the two velocities take.
    pub(crate) fn shares(&self) -> [f64; 2] {
        let shares = |Partner { masses: [first, second], .. }| [second / (first + second), first / (first + second)];
        self.partner.map_or([1.0, 0.0], shares)
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

    /// The names and values of its parameters, given those of the states: its offset and its restitution.
    pub(crate) fn parameters(&self, states: &[String]) -> [(String, f64); 2] {
        let side = if self.above { "above" } else { "below" };
        let other = self.other().map(|other| format!("-{}", states[other])).unwrap_or_default();
        let place = format!("{}{other}.{side}", states[self.state]);
        [(format!("{place}.offset"), self.offset), (format!("{place}.restitution"), self.restitution)]
    }

    /// The same wall with another offset and another restitution.
    pub(crate) fn with_numbers(self, [offset, restitution]: [f64; 2]) -> Self {
        Wall { offset, restitution, ..self }
    }

    /// Its offset and its restitution.
    pub(crate) fn numbers(&self) -> [f64; 2] {
        [self.offset, self.restitution]
    }

    /// Which of its numbers, offset and restitution, are those of another wall on the same side of the same displacement.
    pub(crate) fn shared(&self, other: &Wall) -> [bool; 2] {
        let place = |wall: &Wall| (wall.state(), wall.other(), wall.above);
        [0, 1].map(|k| place(self) == place(other) && self.numbers()[k] == other.numbers()[k])
    }

    /// The same wall in a mirror, y → −y.
    pub(crate) fn mirrored(&self) -> Self {
        Wall { offset: -self.offset, above: !self.above, ..*self }
    }
}

/// Where walls leave a state alone: between these two, which are infinite where there is no wall.
pub(crate) fn limits(walls: &[Wall], state: usize) -> [f64; 2] {
    let own = walls.iter().filter(|wall| wall.state == state && wall.partner.is_none());
    own.fold([f64::NEG_INFINITY, f64::INFINITY], |[low, high], wall| {
        if wall.above { [low.max(wall.offset), high] } else { [low, high.min(wall.offset)] }
    })
}
