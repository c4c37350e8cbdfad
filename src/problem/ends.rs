//! Ends that reflect a state which is no displacement.

use super::Problem;
use super::surfaces::Split;
use crate::error::{Error, Result};
use crate::field::PolynomialField;
use crate::walls::{Wall, limits};
use std::sync::Arc;

impl Problem {
    /// The reflecting ends: walls with r = 1 of states that are no displacements. The flux of probability through them is zero.
    ///
    /// ```
    /// use expoly::{Density, Grid, Problem, Wall};
    /// // Brownian motion on [0, 1] is uniform.
    /// let problem = Problem::from_toml("states = ['x']\ndrift.x = 0\nnoise.w.x = 1")?;
    /// let problem = problem.with_wall(Wall::above(0.0, 1.0)?)?.with_wall(Wall::below(1.0, 1.0)?)?;
    /// assert!(problem.walls().is_empty() && problem.ends().len() == 2);
    /// assert!((Grid::new().solve(&problem)?.variance(0)?.value - 1.0 / 12.0).abs() < 1e-9);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn ends(&self) -> &[Wall] {
        &self.ends
    }

    /// Whether a wall is an end.
    pub(super) fn is_end(&self, wall: &Wall) -> bool {
        let (state, diffusion) = (wall.state(), self.operator().diffusion());
        let driven = diffusion.get(state).is_some_and(|row| !row[state].is_zero());
        wall.restitution() == 1.0 && wall.other().is_none() && self.velocity_of(state).is_none() && driven
    }

    pub(super) fn with_end(mut self, end: Wall) -> Result<Self> {
        let refused = |remedy| Err(Error::OutOfRange { name: "offset of the wall", value: end.offset(), remedy });
        if self.ends.iter().any(|other| (other.state(), other.is_above()) == (end.state(), end.is_above())) {
            return refused("there is a wall on this side of the state already; remove it by `without_walls`");
        }
        self.ends.push(end);
        let [low, high] = limits(&self.ends, end.state());
        if low >= high {
            return refused("the motion must have room between the walls");
        }
        if !self.constant_noise() || !self.operator().coupled().is_empty() {
            let what = "a reflecting end under noise that depends on the states, or is that of other states as well";
            return Err(Error::NotServed {
                method: "problem",
                what,
                remedy: "write the state as a function of one whose noise is constant",
            });
        }
        let split = Split::of(self.drift(), self.surfaces(), true).with_ends(&self.ends);
        let whole = PolynomialField::new(self.drift(), self.columns(), false);
        self.beside_ends = Some(Arc::new(whole.bridged(split.bridges, &split.pushes, &split.rest)));
        Ok(self)
    }

    /// The ends below the motion of a state and above it.
    pub(crate) fn end_limits(&self, state: usize) -> [Option<f64>; 2] {
        limits(&self.ends, state).map(|limit| Some(limit).filter(|limit| limit.is_finite()))
    }

    /// Refuses ends, for a method that does not serve them.
    ///
    /// # Errors
    /// [`Error::NotServed`].
    pub(crate) fn require_no_ends(&self, method: &'static str) -> Result<()> {
        let (what, remedy) = ("a reflecting end", "take the grid or the simulation");
        if self.ends.is_empty() { Ok(()) } else { Err(Error::NotServed { method, what, remedy }) }
    }
}
