//! How much is in each of several wells.
//!
//! Wells that exchange next to nothing have a [pin](super::pins) each, and p = Σ s_i u_i with the shares s_i and the densities u_i that
//! come from the pins. M_ji, what of the probability that comes from pin i arrives at pin j, is a Markov chain: q = M q gives what
//! passes each pin, and with it the shares, without subtractions (W. K. Grassmann, M. I. Taksar and D. P. Heyman, 1985,
//! doi:10.1287/opre.33.5.1107). Since columns keep their sums, rounding changes what wells exchange by 3e-17 of what passes a pin at
//! most: shares are determined up to barriers of some 28 temperatures. Beyond, those of trajectories stand for them.

use super::factors::GridSolution;
use super::field::GridField;
use super::operator::Operator;
use super::pins::Pin;
use crate::error::{Error, Result};
use crate::grid::{HIDDEN, KEPT, ROUNDING, singular};
use crate::memory::MemoryLimit;
use crate::problem::Problem;
use crate::problem::Symmetry;
use crate::states::States;
use nalgebra::{DMatrix, DVector};

/// The largest part of what comes from one pin that rounding makes arrive at another. Since columns keep their sums it is far
/// less: of 216 solutions of two unlike wells (16 to 80 temperatures, damping 0.1 and 1) none has more than a third of this.
const EXCHANGED: f64 = 3e-17;
/// The exchange of two wells may be off by so many times what that of another degree differs by: two numbers may be near by
/// chance.
const NEAR: f64 = 3.0;
/// The least part of what comes from one pin that counts as arriving at another, so that wells have shares where nothing
/// arrives by rounding, or by what the part may be off by.
const NOTHING: f64 = 1e-200;
/// Shares of wells that rounding, leaks or another degree may change by so much are not determined by the equation.
const UNDETERMINED: f64 = 0.1;

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

/// The wells and their shares.
#[derive(Debug)]
pub(super) struct Wells {
    pub(super) pins: Vec<Pin>,
    /// What is in each well.
    pub(super) shares: DVector<f64>,
    /// Changes of these that rounding may make, and what another degree exchanges.
    changes: Vec<DVector<f64>>,
    /// Whether the equations determine the shares.
    pub(super) determined: bool,
    /// M, of which the diagonal is not taken,
    arrives: DMatrix<f64>,
    /// and what each part of it may be off by.
    off: DMatrix<f64>,
    /// The well that each becomes by a change of signs, and its part of what both have.
    images: Vec<Vec<(usize, f64)>>,
}

impl Wells {
    /// `rounding` is the part of what passes a pin that solutions take away.
    pub(super) fn new(pins: Vec<Pin>, question: Question<'_>, rounding: f64) -> Self {
        let count = pins.len();
        let moves = DMatrix::from_fn(count, count, |i, j| pins[i].arrives(&pins[j]));
        // The loss on the way from each pin at the edges, or what rounding hides.
        let lost = |to: f64| {
            let exchanged = if rounding > ROUNDING { rounding } else { EXCHANGED };
            if (1.0 - to).abs() > HIDDEN * rounding { (1.0 - to).abs() } else { exchanged }
        };
        let lost: Vec<f64> = moves.column_iter().map(|to| lost(to.sum())).collect();
        // What is below zero is off by at least as much.
        let off = DMatrix::from_fn(count, count, |i, j| lost[j].max(-2.0 * moves[(i, j)]));
        let images = images(&question.problem.symmetry(), &pins);
        let (shares, changes) = (DVector::zeros(count), Vec::new());
        let arrives = moves.map(|part| part.max(NOTHING));
        let mut wells = Wells { pins, shares, changes, determined: true, arrives, off, images };
        wells.weigh(question.states);
        wells
    }

    /// Shares and their changes by what arrives where.
    fn weigh(&mut self, states: &States) {
        let count = self.pins.len();
        let mut shares = self.stationary(&self.arrives);
        let mut changes = self.changed();
        if changes.iter().any(|change| change.amax() >= UNDETERMINED) {
            shares = self.counted(states);
            // All may be in one well, or none.
            let unit = |i: usize| DVector::from_fn(count, |j, _| f64::from(u8::from(i == j)));
            changes = (0..count).map(|i| (unit(i) - &shares) / count as f64 * 2.0).collect();
            self.determined = false;
        }
        self.changes = self.symmetric(changes);
        self.determined |= self.changes.is_empty();
        self.shares = self.averaged(&shares);
    }

    /// Weighs again if exchanges may be off by what they differ by from another solution with the same pins. Shares themselves would not
    /// do: what passes between wells may be of no use in both solutions, and all be in one well in both. Pins within one well have
    /// shares that are those of their cells.
    pub(super) fn compare(&mut self, other: &mut Self, states: &States) {
        let count = self.pins.len();
        if count == 1 || self.places_of_pins() != other.places_of_pins() {
            return;
        }
        if self.determined && (0..count).all(|well| self.kept(well) > KEPT[2]) {
            for (i, j) in (0..count).flat_map(|j| (0..count).map(move |i| (i, j))) {
                // A pin's strength depends on the degree; what a well loses per unit time does not.
                let arrives = other.arrives[(i, j)] * other.pins[j].rate / self.pins[j].rate;
                self.off[(i, j)] = self.off[(i, j)].max(NEAR * (arrives - self.arrives[(i, j)]).abs());
            }
            self.weigh(states);
        }
        if !self.determined {
            other.shares.clone_from(&self.shares);
        }
    }

    /// The shares if these are the moves between the pins: what passes a pin over the rate at which it does.
    fn stationary(&self, arrives: &DMatrix<f64>) -> DVector<f64> {
        let passing = stationary_chain(arrives);
        let within = DVector::from_fn(passing.len(), |j, _| passing[j] / self.pins[j].rate);
        let sum = within.sum();
        within / sum
    }

    /// What changes in them with each part of what arrives, where the other parts are as little as they may be: half of what it makes
    /// from its lowest value to its highest one.
    fn changed(&self) -> Vec<DVector<f64>> {
        let count = self.pins.len();
        let least = (&self.arrives - &self.off).map(|part| part.max(NOTHING));
        let known = self.stationary(&least);
        let pairs = (0..count).flat_map(|j| (0..count).filter(move |i| *i != j).map(move |i| (i, j)));
        let change = |(i, j): (usize, usize)| {
            let mut other = least.clone();
            other[(i, j)] = self.arrives[(i, j)] + self.off[(i, j)];
            (self.stationary(&other) - &known) / 2.0
        };
        pairs.map(change).collect()
    }

    /// What of the probability that comes from a pin comes back to it before it arrives at another.
    pub(super) fn kept(&self, well: usize) -> f64 {
        self.pins[well].arrives(&self.pins[well])
    }

    /// Shares that are symmetric where the problem is.
    fn averaged(&self, shares: &DVector<f64>) -> DVector<f64> {
        let with = |shares: DVector<f64>, image: &Vec<(usize, f64)>| {
            DVector::from_fn(shares.len(), |i, _| (shares[i] + shares[image[i].0]) * image[i].1)
        };
        self.images.iter().fold(shares.clone(), with)
    }

    /// Whether a change of signs makes one well of the other.
    pub(super) fn alike(&self, [one, other]: [usize; 2]) -> bool {
        self.images.iter().any(|image| image[one].0 == other)
    }

    /// Changes of shares, but for those that symmetry excludes.
    fn symmetric(&self, changes: Vec<DVector<f64>>) -> Vec<DVector<f64>> {
        let averaged = changes.iter().map(|change| self.averaged(change));
        averaged.filter(|change| change.amax() > 1e-14).collect()
    }

    /// The shares of states that lie in cells where the mean of each well is the largest of all.
    fn counted(&self, states: &States) -> DVector<f64> {
        let count = self.pins.len();
        let mut counts = DVector::from_element(count, 0.0);
        for cell in states.iter().filter_map(|x| self.pins[0].from.field.mesh.locate(x)) {
            let mean = |well: &usize| self.well(*well).mean(cell);
            if let Some(well) = (0..count).max_by(|a, b| mean(a).total_cmp(&mean(b))) {
                counts[well] += 1.0;
            }
        }
        let sum = counts.sum();
        if sum > 0.0 { counts / sum } else { DVector::from_element(count, 1.0 / count as f64) }
    }

    /// The density of a well, with mass 1.
    pub(super) fn well(&self, pin: usize) -> &GridField {
        &self.pins[pin].from.field
    }

    /// Where the pins are, as states.
    pub(super) fn places_of_pins(&self) -> Vec<Vec<f64>> {
        self.pins.iter().map(|pin| pin.from.field.mesh.centre(pin.cell)).collect()
    }

    /// What comes from all pins, by the shares.
    pub(super) fn density(&self, operator: &Operator) -> GridSolution {
        let mut density = GridSolution::zero(operator);
        self.pins.iter().zip(&self.shares).for_each(|(pin, share)| density.add(*share, &pin.from));
        density
    }

    /// What the changes of the shares make of the density, each without mass.
    pub(super) fn open(&self) -> Vec<GridField> {
        let first = self.well(0);
        let zero = || GridField::zero(&first.mesh, first.shape);
        let change =
            |shares: &DVector<f64>| (0..self.pins.len()).fold(zero(), |sum, pin| sum.plus(shares[pin], self.well(pin)));
        self.changes.iter().map(change).collect()
    }

    /// What must come from the pins so that nothing of a density stays behind at any, where there are several: Σ_j (δ_ij − M_ij) q_j is
    /// what has gone at pin i.
    ///
    /// # Errors
    /// [`Error::NotKnown`] where the shares are not determined.
    pub(super) fn returning(&self, p: &GridField) -> Result<Vec<f64>> {
        let count = self.pins.len();
        if count == 1 {
            return Ok(vec![0.0]);
        }
        if !self.determined {
            let remedy = "the wells exchange less than rounding hides: take the derivative with one well alone within `Grid::domain`";
            return Err(Error::NotKnown { what: "derivatives of the shares of wells".into(), remedy });
        }
        let moves = DMatrix::from_fn(count, count, |i, j| self.pins[i].arrives(&self.pins[j]));
        // What leaves one pin for the others, so that small rates are not differences.
        let chain = DMatrix::from_fn(count, count, |i, j| {
            let out: f64 = (0..count).filter(|k| *k != j).map(|k| moves[(k, j)]).sum();
            if i == j { out } else { -moves[(i, j)] }
        });
        let gone = DVector::from_iterator(count, self.pins.iter().map(|pin| pin.passing(p)));
        let even = gone.mean();
        let least = 1e-6 * chain.amax();
        let found = chain.svd(true, true).solve(&gone.add_scalar(-even), least);
        let singular = singular(p.coefficients.len());
        Ok(found.map_err(|_| singular)?.iter().copied().collect())
    }
}

/// The stationary shares of a Markov chain by its transitions from j to i ≠ j, without subtractions.
fn stationary_chain(arrives: &DMatrix<f64>) -> Vec<f64> {
    let count = arrives.nrows();
    let mut rates = arrives.clone();
    for k in (1..count).rev() {
        let out: f64 = (0..k).map(|i| rates[(i, k)]).sum();
        for j in 0..k {
            let factor = rates[(k, j)] / out;
            rates[(k, j)] = factor;
            for i in (0..k).filter(|i| *i != j) {
                let more = rates[(i, k)] * factor;
                rates[(i, j)] += more;
            }
        }
    }
    let mut parts = vec![1.0; count];
    for k in 1..count {
        parts[k] = (0..k).map(|j| rates[(k, j)] * parts[j]).sum();
    }
    parts
}

/// For each sign change of states that leaves the problem as it is, the well that each becomes, with its part of what both have: the
/// means of the states that change are 0. Halves would not do, since what comes from a pin has a little in the other wells.
fn images(symmetry: &Symmetry, pins: &[Pin]) -> Vec<Vec<(usize, f64)>> {
    let mesh = &pins[0].from.field.mesh;
    let (domain, wells) = (mesh.domain(), 0..pins.len());
    let mean = |pin: &Pin| -> Vec<f64> {
        let width = |axis: usize| domain[axis][1] - domain[axis][0];
        (0..mesh.dimension()).map(|axis| pin.from.field.integral_over(axis, &|x: f64| x, 1) / width(axis)).collect()
    };
    let means: Vec<Vec<f64>> = pins.iter().map(mean).collect();
    let image = |flip: &Vec<bool>| -> Option<Vec<(usize, f64)>> {
        let distance = |i: usize, j: usize| -> f64 {
            let turned = |axis: usize| if flip[axis] { -means[i][axis] } else { means[i][axis] };
            (0..mesh.dimension()).map(|axis| (turned(axis) - means[j][axis]).powi(2)).sum()
        };
        let nearest = |i: usize| wells.clone().min_by(|a, b| distance(i, *a).total_cmp(&distance(i, *b)));
        let image: Vec<usize> = wells.clone().filter_map(nearest).collect();
        let part = |i: usize| {
            let apart = |axis: &usize| (means[i][*axis] - means[image[i]][*axis]).abs();
            let flipped = (0..mesh.dimension()).filter(|axis| flip[*axis]);
            let axis = flipped.max_by(|a, b| apart(a).total_cmp(&apart(b))).unwrap_or(0);
            let [own, other] = [i, image[i]].map(|well| means[well][axis].abs());
            (image[i], if image[i] == i { 0.5 } else { other / (own + other) })
        };
        let back = wells.clone().all(|i| image[image[i]] == i);
        (back && wells.clone().any(|i| image[i] != i)).then(|| wells.clone().map(part).collect())
    };
    symmetry.changes().iter().filter_map(image).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: p₁ : p₂ : p₃ of a chain of three with unlike rates.
    #[test]
    fn chains_have_their_stationary_shares() {
        let arrives = DMatrix::from_row_slice(3, 3, &[0.0, 0.2, 1e-15, 0.1, 0.0, 3e-15, 1e-16, 2e-16, 0.0]);
        let shares = stationary_chain(&arrives);
        for i in 0..3 {
            let into: f64 = (0..3).filter(|j| *j != i).map(|j| arrives[(i, j)] * shares[j]).sum();
            let out: f64 = (0..3).filter(|j| *j != i).map(|j| arrives[(j, i)] * shares[i]).sum();
            assert!((into / out - 1.0).abs() < 1e-14);
        }
    }
}
