//! The null vector of the operator: the stationary density.
//!
//! With [pins](super::pins) K is regular. Where nothing is lost, p_k = 1 at a single one and K p = 0 exactly. Several have one of the
//! [wells](super::wells) each.

use super::factors::{Factors, GridSolution};
use super::field::GridField;
use super::flux::Part;
use super::operator::{Layout, Operator};
use super::pins::{Pin, Pinned};
use super::wells::{Question, Wells};
use crate::error::Result;
use crate::grid::{HIDDEN, singular};
use crate::states::States;

/// The share of the accuracy, in L¹, that rounding may change before a further pin is set, for a well of its own.
const SHARE: f64 = 0.1;
/// What rounding may change in any case, in L¹, before a further pin is set. Of a single well it changes 1e-12 to 1e-10, which
/// is part of the estimate.
const APART: f64 = 1e-9;
/// The number of pins at which no further one is set, whatever rounding changes.
const MOST: usize = 12;

/// A stationary density, with the factors that made it.
#[derive(Debug)]
pub(super) struct Stationary {
    pub(super) operator: Operator,
    factors: Factors,
    pub(super) wells: Wells,
    pub(super) density: GridSolution,
    /// The density if a unit of probability per unit time came back everywhere alike, and not at the pins; without mass.
    elsewhere: GridSolution,
    /// The probability that leaves the domain per unit time, at least what rounding hides of it.
    pub(super) leak: Leak,
    /// The largest |K p| relative to the largest |K| |p| of the cells: rounding.
    pub(super) residual: f64,
    /// What is changed by shares of wells that are not known exactly.
    pub(super) open: Vec<GridField>,
}

/// A loss per unit time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leak {
    pub(super) lost: f64,
    /// What rounding may hide.
    pub(super) rounding: f64,
}

impl Leak {
    fn bound(self) -> f64 {
        self.lost.abs().max(self.rounding)
    }

    /// Whether the domain's edges lose more than rounding does.
    pub(super) fn at_edges(self) -> bool {
        self.lost.abs() > HIDDEN * self.rounding
    }
}

/// Solves K p = 0 with total mass 1, with pins at some places and where they turn out to be needed.
pub(super) fn solve(question: Question<'_>, layout: &Layout, degree: usize, places: &[Vec<f64>]) -> Result<Stationary> {
    let operator = Operator::new(question.problem, layout, degree, Part::Whole, question.memory)?;
    let mut cells = Vec::new();
    for cell in places.iter().filter_map(|place| layout.mesh.locate(place)) {
        if !cells.contains(&cell) {
            cells.push(cell);
        }
    }
    if cells.is_empty() {
        cells.push(layout.mesh.cells.len() / 2);
    }
    loop {
        let pinned = Pinned::new(&operator, &cells)?;
        let elsewhere = pinned.elsewhere();
        let next = elsewhere.field.farthest();
        let rounding = pinned.factors.rounding() * pinned.rate();
        let together = rounding * elsewhere.field.size() <= (SHARE * question.target).max(APART);
        if together || cells.contains(&next) || cells.len() == MOST {
            return Stationary::new(question, operator, pinned, elsewhere);
        }
        cells.push(next);
    }
}

impl Stationary {
    fn new(
        question: Question<'_>,
        operator: Operator,
        Pinned { factors, pins, .. }: Pinned,
        mut elsewhere: GridSolution,
    ) -> Result<Self> {
        let wells = Wells::new(pins, question, factors.rounding());
        let density = wells.density(&operator);
        let p = &density.field;
        if !p.coefficients.iter().all(|p| p.is_finite()) {
            return Err(singular(operator.unknowns()));
        }
        let fed = |(pin, share): (&Pin, &f64)| pin.rate * share - pin.passing(p);
        let fed: Vec<f64> = wells.pins.iter().zip(&wells.shares).map(fed).collect();
        let passing: f64 = wells.pins.iter().map(|pin| pin.passing(p).abs()).sum();
        let leak = Leak { lost: fed.iter().sum(), rounding: factors.rounding() * passing };
        let [mut balance, at_faces] = operator.balance(&p.coefficients, &density.faces);
        wells.pins.iter().zip(&fed).for_each(|(pin, fed)| pin.feed(&mut balance, -fed));
        let largest = |x: &[f64]| x.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
        let magnitude = operator.cells.iter().map(|cell| cell.inner.norm_max()).fold(0.0, f64::max);
        let residual = largest(&balance).max(largest(&at_faces)) / (magnitude * largest(&p.coefficients));
        let between = elsewhere.field.mass();
        elsewhere.add(-between, &density);
        let open = wells.open();
        Ok(Stationary { operator, factors, wells, density, elsewhere, leak, residual, open })
    }

    /// Whether an iteration takes too many steps for finer meshes to be of use.
    pub(super) fn is_slow(&self) -> bool {
        self.factors.are_slow()
    }

    /// What could change if the lost probability came back elsewhere.
    ///
    /// Where it comes back is arbitrary, and between wells that mix as slowly as it is lost it decides what is in each. Twice the
    /// change if it came back everywhere alike holds it: between two wells of like size half of the loss then returns to each, and
    /// no return changes more than the whole to either. For those of Duffing's oscillator, D = 0.006 to 0.02, it is 1.2 to 6 times
    /// the error of E x.
    pub(super) fn returned(&self) -> GridField {
        self.elsewhere.field.times(2.0 * self.leak.bound())
    }

    /// Takes a density that is known in closed form in the place of the solution, on the same mesh.
    pub(super) fn replace(&mut self, exact: GridField) {
        let faces = self.operator.traces(None).solved(self.operator.outward(&exact.coefficients));
        let mesh = &self.operator.layout.mesh;
        self.density = GridSolution { field: GridField { mesh: mesh.clone(), ..exact }, faces };
        (self.leak, self.open) = (Leak { lost: 0.0, rounding: 0.0 }, Vec::new());
        self.wells.determined = true;
    }

    /// The solution of K q = −`derivative` p without mass, and what changes in it if lost probability comes back elsewhere.
    ///
    /// # Errors
    /// [`Error::NotResolved`](crate::Error::NotResolved) if it is not finite, [`Error::NotKnown`](crate::Error::NotKnown) where the shares of wells are not determined.
    pub(super) fn moved(&self, derivative: &Operator, more: &[f64]) -> Result<[GridField; 2]> {
        let balanced = |change: GridField| change.plus(-change.mass(), &self.density.field);
        let source = |p: &GridSolution, factor: f64| {
            let [mut right, mut at_faces] = derivative.balance(&p.field.coefficients, &p.faces);
            right.iter_mut().chain(&mut at_faces).for_each(|r| *r *= factor);
            [right, at_faces]
        };
        let [mut right, at_faces] = source(&self.density, -1.0);
        right.iter_mut().zip(more).for_each(|(r, m)| *r -= m);
        let mut solution = self.factors.solve(&right, Some(at_faces))?;
        let pins = &self.wells.pins;
        let lost: f64 = pins.iter().map(|pin| -pin.passing(&solution.field)).sum();
        let returning = self.wells.returning(&solution.field)?;
        pins.iter().zip(returning).for_each(|(pin, passing)| solution.add(passing / pin.rate, &pin.from));
        let moved = balanced(solution.field);
        let [right, at_faces] = source(&self.elsewhere, 2.0 * self.leak.bound());
        let mut returned = self.factors.solve(&right, Some(at_faces))?;
        returned.add(2.0 * lost, &self.elsewhere);
        Ok([moved, balanced(returned.field)])
    }

    /// The size of what shares of wells may be off by.
    pub(super) fn open(&self) -> f64 {
        self.open.iter().map(GridField::size).sum()
    }

    /// Counts what wells exchange in another solution on this mesh as what they may exchange. Where that leaves shares undetermined,
    /// the other solution takes those of this one.
    pub(super) fn compare(&mut self, other: &mut Self, states: &States) {
        self.wells.compare(&mut other.wells, states);
        if !self.wells.determined {
            [&mut *self, other].into_iter().for_each(|own| own.density = own.wells.density(&own.operator));
        }
        self.open = self.wells.open();
    }
}
