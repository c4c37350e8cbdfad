//! Pins: sources that make K regular, and the densities that come from them.
//!
//! The columns of K sum to the flux out of the domain, which is next to zero: K is singular. A source of strength α (1 − p_k) at the
//! first function of a cell k, the pin, its strength unknown beforehand, makes up for the loss. It adds one number to the diagonal and
//! nothing to the pattern, unlike a border, whose full row would fill the factors.

use super::factors::{Factors, GridSolution, Regular};
use super::field::GridField;
use super::operator::Operator;
use crate::error::Result;
use crate::parallel;

/// A pin, and the density that comes from it.
#[derive(Clone, Debug)]
pub(super) struct Pin {
    pub(super) cell: usize,
    /// What a source of one unit of probability per unit time is at the first function, √volume⁻¹.
    source: f64,
    /// The probability per unit time that passes the pin where the coefficient of the first function is 1.
    through: f64,
    /// The density that comes from the pin, with mass 1,
    pub(super) from: GridSolution,
    /// and the probability per unit time that comes with it.
    pub(super) rate: f64,
}

impl Pin {
    /// The probability of a density per unit time that passes the pin.
    pub(super) fn passing(&self, p: &GridField) -> f64 {
        self.through * p.block(self.cell)[0]
    }

    /// What of the probability that comes from another pin, or from this one, arrives at this one before any other.
    pub(super) fn arrives(&self, from: &Pin) -> f64 {
        self.passing(&from.from.field) / from.rate
    }

    /// Enters a source of probability per unit time into the right sides.
    pub(super) fn feed(&self, right: &mut [f64], rate: f64) {
        let block = self.from.field.shape.block();
        right[self.cell * block] += rate * self.source;
    }
}

/// The factors with pins at some cells, and what comes from each.
pub(super) struct Pinned {
    pub(super) factors: Factors,
    pub(super) pins: Vec<Pin>,
    /// What comes of a unit of probability per unit time that comes in everywhere alike and goes out at the pins.
    even: GridSolution,
}

impl Pinned {
    pub(super) fn new(operator: &Operator, cells: &[usize]) -> Result<Self> {
        let scale = |cell: usize| {
            let column = operator.cells[cell].inner.col_as_slice(0);
            column.iter().fold(f64::MIN_POSITIVE, |a: f64, b| a.max(b.abs()))
        };
        let at: Vec<(usize, f64)> = cells.iter().map(|cell| (*cell, scale(*cell))).collect();
        let factors = operator.factors(Regular::Pins(&at));
        let (mesh, block) = (&operator.layout.mesh, operator.shape.block());
        let volume = mesh.volume();
        let mut sources = vec![vec![0.0; operator.unknowns()]; cells.len() + 1];
        for (source, (cell, alpha)) in sources.iter_mut().zip(&at) {
            source[cell * block] = *alpha;
        }
        let everywhere = &mut sources[cells.len()];
        mesh.cells.iter().enumerate().for_each(|(cell, own)| everywhere[cell * block] = own.root_volume() / volume);
        let mut solutions: Vec<GridSolution> =
            parallel::map_into(sources, |_, right| factors.solve(&right, None)).into_iter().collect::<Result<_>>()?;
        let even = solutions.pop().unwrap_or_else(|| GridSolution::zero(operator));
        let pin = |(&(cell, alpha), mut from): (&(usize, f64), GridSolution)| {
            let (root, mass) = (mesh.cells[cell].root_volume(), from.field.mass());
            from.scale(mass.recip());
            Pin { cell, source: root.recip(), through: alpha * root, from, rate: alpha * root / mass }
        };
        let pins = at.iter().zip(solutions).map(pin).collect();
        Ok(Pinned { factors, pins, even })
    }

    /// The largest rate at which probability passes through a pin, if all of a well's were there.
    pub(super) fn rate(&self) -> f64 {
        self.pins.iter().map(|pin| pin.rate.abs()).fold(0.0, f64::max)
    }

    /// What comes of a unit of probability per unit time that comes in everywhere alike and goes out at the pins, without what is
    /// there at the pins.
    pub(super) fn elsewhere(&self) -> GridSolution {
        let mut solution = self.even.clone();
        let passing: Vec<f64> = self.pins.iter().map(|pin| pin.passing(&solution.field)).collect();
        for (pin, passing) in self.pins.iter().zip(passing) {
            solution.add(-passing / pin.rate, &pin.from);
        }
        solution
    }
}
