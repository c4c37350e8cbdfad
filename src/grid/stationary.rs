//! The null vector of the operator: the stationary density.
//!
//! The columns of K sum to the flux out of the domain, which is next to zero: K is singular. A source of strength α (1 − p_k) at the
//! first function of a cell k, the pin, its strength unknown beforehand, makes up for the loss. It adds one number to the diagonal and
//! nothing to the pattern, unlike a border, whose full row would fill the factors. Where nothing is lost, p_k = 1 and K p = 0 exactly.
//!
//! Wells that exchange next to nothing have a pin each. With α p at all pins eliminated, u_i is the density that comes from pin i:
//! p = Σ c_i u_i with the shares of the [wells](super::wells).

use super::field::Field;
use super::flux::Part;
use super::operator::{Factors, Layout, Operator, Regular, Solution};
use super::shape::Place;
use super::wells::{self, Wells};
use crate::error::{Error, Result};
use crate::grid::tuning::{refinement, wells as tuning};
use crate::memory::MemoryLimit;
use crate::problem::Problem;
use crate::states::States;
use nalgebra::{DMatrix, DVector};

/// What a stationary density is solved for.
#[derive(Clone, Copy)]
pub(super) struct Question<'a> {
    pub(super) problem: &'a Problem,
    /// States of trajectories, by which wells have shares where equations do not determine them.
    pub(super) states: &'a States,
    pub(super) memory: MemoryLimit,
    /// Changes of less than this, in L¹, do not matter.
    pub(super) target: f64,
}

/// A stationary density, with the factors that made it.
#[derive(Debug)]
pub(super) struct Stationary {
    pub(super) operator: Operator,
    factors: Factors,
    pins: Vec<Pin>,
    wells: Wells,
    pub(super) field: Field,
    /// Its unknowns at faces.
    faces: Vec<f64>,
    /// The field if a unit of probability per unit time came back everywhere alike, and not at the pins; without mass.
    elsewhere: Solution,
    /// The probability that leaves the domain per unit time, at least what rounding hides of it.
    pub(super) leak: Leak,
    /// The largest |K p| relative to the largest |K| |p| of the cells: rounding.
    pub(super) residual: f64,
    /// What is changed by shares of wells that are not known exactly.
    pub(super) shares: Vec<Field>,
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
        self.lost.abs() > tuning::HIDDEN * self.rounding
    }
}

/// A pin, and the density that comes from it.
#[derive(Clone, Debug)]
pub(super) struct Pin {
    pub(super) cell: usize,
    alpha: f64,
    /// The probability per unit time that α lets through it: α times the mass of the cell's first function.
    pub(super) through: f64,
    pub(super) from: Solution,
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
        let elsewhere = pinned.elsewhere(&operator)?;
        let field = Field { coefficients: elsewhere.inner, ..Field::zero(&layout.mesh, operator.shape) };
        let next = furthest(&field);
        let rounding = tuning::ROUNDING * pinned.rate(&operator);
        let together = rounding * field.size() <= (tuning::SHARE * question.target).max(tuning::APART);
        if together || cells.contains(&next) || cells.len() == tuning::MOST {
            let elsewhere = Solution { inner: field.coefficients, faces: elsewhere.faces };
            return pinned.solved(question, operator, elsewhere);
        }
        cells.push(next);
    }
}

/// The cell in which a field is farthest from zero, in the mean.
fn furthest(field: &Field) -> usize {
    let cells = 0..field.mesh.cells.len();
    cells.max_by(|a, b| field.mean(*a).abs().total_cmp(&field.mean(*b).abs())).unwrap_or(0)
}

/// The factors with pins, and what comes from each.
struct Pinned {
    factors: Factors,
    pins: Vec<Pin>,
}

impl Pinned {
    fn new(operator: &Operator, cells: &[usize]) -> Result<Self> {
        let scale = |cell: usize| {
            let column = operator.cells[cell].inner.col_as_slice(0);
            column.iter().fold(f64::MIN_POSITIVE, |a: f64, b| a.max(b.abs()))
        };
        let at: Vec<(usize, f64)> = cells.iter().map(|cell| (*cell, scale(*cell))).collect();
        let factors = operator.factors(Regular::Pins(&at));
        let block = operator.shape.block();
        let pin = |&(cell, alpha): &(usize, f64)| {
            let mut right = vec![0.0; operator.unknowns()];
            right[cell * block] = alpha;
            let through = alpha * operator.layout.mesh.cells[cell].root_volume();
            Ok(Pin { cell, alpha, through, from: factors.solve(&right, None)? })
        };
        let pins = at.iter().map(pin).collect::<Result<_>>()?;
        Ok(Pinned { factors, pins })
    }

    /// The largest rate at which probability passes through a pin, if all of a well's were there.
    fn rate(&self, operator: &Operator) -> f64 {
        let of = |pin: &Pin| {
            let field =
                Field { coefficients: pin.from.inner.clone(), ..Field::zero(&operator.layout.mesh, operator.shape) };
            pin.through / field.mass().abs()
        };
        self.pins.iter().map(of).fold(0.0, f64::max)
    }

    /// What comes of a unit of probability per unit time that comes in everywhere alike and goes out at the pins, without what is
    /// there at the pins.
    fn elsewhere(&self, operator: &Operator) -> Result<Solution> {
        let (mesh, block) = (&operator.layout.mesh, operator.shape.block());
        let mut right = vec![0.0; operator.unknowns()];
        let volume = mesh.volume();
        mesh.cells.iter().enumerate().for_each(|(cell, own)| right[cell * block] = own.root_volume() / volume);
        let mut solution = self.factors.solve(&right, None)?;
        let at_pins: Vec<f64> = self.pins.iter().map(|pin| solution.inner[pin.cell * block]).collect();
        for (pin, at) in self.pins.iter().zip(at_pins) {
            solution.add(-at, &pin.from);
        }
        Ok(solution)
    }

    fn solved(self, question: Question<'_>, operator: Operator, mut elsewhere: Solution) -> Result<Stationary> {
        let Pinned { factors, pins } = self;
        let (layout, block) = (operator.layout.clone(), operator.shape.block());
        let mesh = &layout.mesh;
        let field =
            |solution: &Solution| Field { coefficients: solution.inner.clone(), ..Field::zero(mesh, operator.shape) };
        let wells = Wells::new(&pins, block, &pins.iter().map(|pin| field(&pin.from)).collect::<Vec<_>>(), question);
        let mut p = Solution { inner: vec![0.0; operator.unknowns()], faces: vec![0.0; pins[0].from.faces.len()] };
        pins.iter().zip(&wells.parts).for_each(|(pin, part)| p.add(*part, &pin.from));
        let mass = field(&p).mass();
        p.scale(mass.recip());
        if !p.inner.iter().all(|p| p.is_finite()) {
            return Err(Error::SingularSystem { unknowns: operator.unknowns() });
        }
        let lost = |(pin, part): (&Pin, &f64)| pin.through * (part / mass - p.inner[pin.cell * block]);
        let lost: f64 = pins.iter().zip(&wells.parts).map(lost).sum();
        let passing: f64 = pins.iter().map(|pin| pin.through * p.inner[pin.cell * block].abs()).sum();
        let [mut balance, at_faces] = operator.balance(&p.inner, &p.faces);
        pins.iter().zip(&wells.parts).for_each(|(pin, part)| {
            balance[pin.cell * block] -= pin.alpha * (part / mass - p.inner[pin.cell * block]);
        });
        let largest = |x: &[f64]| x.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
        let magnitude = operator.cells.iter().map(|cell| cell.inner.norm_max()).fold(0.0, f64::max);
        let residual = largest(&balance).max(largest(&at_faces)) / (magnitude * largest(&p.inner));
        let between = field(&elsewhere).mass();
        elsewhere.add(-between, &p);
        let leak = Leak { lost, rounding: tuning::ROUNDING * passing };
        let (field, faces, shares) = (field(&p), p.faces, Vec::new());
        let mut solution =
            Stationary { operator, factors, pins, wells, field, faces, elsewhere, leak, residual, shares };
        solution.shares = solution.wells.changes.iter().map(|parts| solution.change(parts)).collect();
        Ok(solution)
    }
}

impl Stationary {
    /// What could change if the lost probability came back elsewhere.
    ///
    /// Where it comes back is arbitrary, and between wells that mix as slowly as it is lost it decides what is in each. Twice the
    /// change if it came back everywhere alike holds it: between two wells of like size half of the loss then returns to each, and
    /// no return changes more than the whole to either. For those of Duffing's oscillator, D = 0.006 to 0.02, it is 1.2 to 6 times
    /// the error of E x.
    pub(super) fn returned(&self) -> Field {
        let scale = 2.0 * self.leak.bound();
        let coefficients = self.elsewhere.inner.iter().map(|c| scale * c).collect();
        Field { coefficients, ..self.field.clone() }
    }

    /// Takes a density that is known in closed form in the place of the solution, on the same mesh.
    pub(super) fn replace(&mut self, exact: Field) {
        let mesh = &self.operator.layout.mesh;
        self.field = Field { coefficients: exact.coefficients, ..Field::zero(mesh, self.operator.shape) };
        self.faces = self.operator.traces(None).solved(self.operator.outward(&self.field.coefficients));
        (self.leak, self.shares) = (Leak { lost: 0.0, rounding: 0.0 }, Vec::new());
        self.wells.determined = true;
    }

    /// The solution of K q = −`derivative` p without mass, and what changes in it if lost probability comes back elsewhere.
    ///
    /// # Errors
    /// [`Error::SingularSystem`] if it is not finite.
    pub(super) fn moved(&self, derivative: &Operator, more: &[f64]) -> Result<[Field; 2]> {
        let balanced = |solution: Solution| {
            let change = Field { coefficients: solution.inner, ..self.field.clone() };
            let mass = change.mass();
            change.plus(-mass, &self.field)
        };
        let source = |inner: &[f64], faces: &[f64]| {
            let [mut right, mut at_faces] = derivative.balance(inner, faces);
            right.iter_mut().for_each(|r| *r = -*r);
            at_faces.iter_mut().for_each(|r| *r = -*r);
            [right, at_faces]
        };
        let [mut right, at_faces] = source(&self.field.coefficients, &self.faces);
        right.iter_mut().zip(more).for_each(|(r, m)| *r -= m);
        let mut solution = self.factors.solve(&right, Some(at_faces))?;
        let block = self.operator.shape.block();
        let lost: f64 = self.pins.iter().map(|pin| -pin.through * solution.inner[pin.cell * block]).sum();
        self.share_out(&mut solution)?;
        let moved = balanced(solution);
        let scale = 2.0 * self.leak.bound();
        let [mut right, mut at_faces] = source(&self.elsewhere.inner, &self.elsewhere.faces);
        right.iter_mut().chain(&mut at_faces).for_each(|r| *r *= scale);
        let mut returned = self.factors.solve(&right, Some(at_faces))?;
        returned.add(2.0 * lost, &self.elsewhere);
        Ok([moved, balanced(returned)])
    }

    /// Adds what comes from the pins, where there are several, so that nothing stays behind at any: Σ_j (δ_ij − M_ij) q_j is what has
    /// gone at pin i.
    fn share_out(&self, solution: &mut Solution) -> Result<()> {
        let (count, block) = (self.pins.len(), self.operator.shape.block());
        if count == 1 {
            return Ok(());
        }
        if !self.determined() {
            let remedy = "the wells exchange less than rounding hides: take the derivative with one well alone within `Grid::domain`";
            return Err(Error::NotKnown { what: "derivatives of the shares of wells".into(), remedy });
        }
        let moves = wells::moves(&self.pins, block);
        // What leaves one pin for the others, so that small rates are not differences.
        let chain = DMatrix::from_fn(count, count, |i, j| {
            let out: f64 = (0..count).filter(|k| *k != j).map(|k| moves[(k, j)]).sum();
            if i == j { out } else { -moves[(i, j)] }
        });
        let gone =
            DVector::from_iterator(count, self.pins.iter().map(|pin| pin.through * solution.inner[pin.cell * block]));
        let even = gone.mean();
        let least = 1e-6 * chain.amax();
        let found = chain.svd(true, true).solve(&gone.add_scalar(-even), least);
        let singular = Error::SingularSystem { unknowns: self.operator.unknowns() };
        for (pin, part) in self.pins.iter().zip(found.map_err(|_| singular)?.iter()) {
            solution.add(part / pin.through, &pin.from);
        }
        Ok(())
    }

    /// The places of the pins, as states: of several that of each well.
    pub(super) fn places(&self) -> Vec<Vec<f64>> {
        let mesh = &self.operator.layout.mesh;
        let place = |field: &Field| mesh.centre(&mesh.cells[field.peak()]);
        let wells: Vec<usize> = (0..self.pins.len()).filter(|pin| self.kept_at(*pin) > tuning::KEPT[0]).collect();
        match &wells[..] {
            [] | [_] => vec![place(&self.field)],
            wells => wells.iter().map(|pin| place(&self.well(*pin))).collect(),
        }
    }

    /// What of the probability that comes from a pin comes back to it before it arrives at another.
    fn kept_at(&self, pin: usize) -> f64 {
        self.pins[pin].from.inner[self.pins[pin].cell * self.operator.shape.block()]
    }

    /// The density that comes from a pin, with mass 1.
    fn well(&self, pin: usize) -> Field {
        let mut field = Field { coefficients: self.pins[pin].from.inner.clone(), ..self.field.clone() };
        let mass = field.mass();
        field.coefficients.iter_mut().for_each(|c| *c /= mass);
        field
    }

    /// What is left in the highest degree of each cell: of the density, and of each well as if it had some of it at least. Cells that
    /// are too coarse let out what a well keeps, and then say that next to nothing is in it.
    pub(super) fn unresolved(&self) -> Vec<Place> {
        let mut all = self.field.highest(refinement::BELOW);
        for pin in (0..self.pins.len()).filter(|_| self.pins.len() > 1) {
            let missing = tuning::LEAST - self.wells.shares[pin];
            if missing > 0.0 && self.kept_at(pin) > tuning::KEPT[1] {
                let own = self.well(pin).highest(refinement::BELOW);
                let along = all.iter_mut().flatten().zip(own.iter().flatten());
                along.for_each(|(all, own)| *all += missing * own);
            }
        }
        all
    }

    /// The place of many trajectories' states of which no well has any: there is one more.
    pub(super) fn missed(&self, states: &States) -> Option<Vec<f64>> {
        let mesh = &self.operator.layout.mesh;
        let wells: Vec<Field> = (0..self.pins.len()).map(|pin| self.well(pin)).collect();
        let mut counts = vec![0.0; mesh.cells.len()];
        states.iter().filter_map(|x| mesh.locate(x)).for_each(|cell| counts[cell] += 1.0 / states.len() as f64);
        let within = |cell: usize| -> f64 {
            let volume = mesh.cells[cell].root_volume().powi(2);
            wells.iter().map(|well| well.mean(cell).abs() * volume).sum()
        };
        let missed = |cell: &usize| counts[*cell] > tuning::MANY && within(*cell) < tuning::MISSED * counts[*cell];
        let most = (0..counts.len()).filter(missed).max_by(|a, b| counts[*a].total_cmp(&counts[*b]));
        most.map(|cell| mesh.centre(&mesh.cells[cell]))
    }

    /// A change of the density by those of the parts that come from the pins; without mass.
    fn change(&self, parts: &[f64]) -> Field {
        let mut change = Field::zero(&self.field.mesh, self.field.shape);
        for (pin, part) in self.pins.iter().zip(parts) {
            super::field::add_multiple(&mut change.coefficients, *part, &pin.from.inner);
        }
        let mass = change.mass();
        change.plus(-mass, &self.field)
    }

    /// Whether the equations determine the shares of all wells.
    pub(super) fn determined(&self) -> bool {
        self.wells.determined
    }

    /// The size of what shares of wells may be off by.
    pub(super) fn open(&self) -> f64 {
        self.shares.iter().map(Field::size).sum()
    }

    /// Where the pins are, as states.
    pub(super) fn pinned(&self) -> Vec<Vec<f64>> {
        let mesh = &self.operator.layout.mesh;
        self.pins.iter().map(|pin| mesh.centre(&mesh.cells[pin.cell])).collect()
    }

    /// Counts what the shares of wells differ from those of another solution by: what comes from other pins has other shares.
    pub(super) fn compare(&mut self, other: &Self) {
        if self.pinned() != other.pinned() {
            return;
        }
        let more: Vec<Field> = self.wells.apart(&other.wells).iter().map(|parts| self.change(parts)).collect();
        self.shares.extend(more);
    }
}

impl Solution {
    fn add(&mut self, factor: f64, other: &Solution) {
        super::field::add_multiple(&mut self.inner, factor, &other.inner);
        super::field::add_multiple(&mut self.faces, factor, &other.faces);
    }

    fn scale(&mut self, factor: f64) {
        self.inner.iter_mut().chain(&mut self.faces).for_each(|x| *x *= factor);
    }
}
