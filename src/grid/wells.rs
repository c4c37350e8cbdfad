//! How much is in each of several wells.
//!
//! M_ji, what of the probability that comes from pin i arrives at pin j, is a Markov chain of the wells: q = M q gives what passes each
//! pin, and with it their shares, without subtractions (W. K. Grassmann, M. I. Taksar and D. P. Heyman, 1985,
//! doi:10.1287/opre.33.5.1107). Since columns keep their sums M is right to 1e-16: where wells exchange less than that, beyond barriers
//! of some 30 temperatures, their shares are not determined, and those of trajectories stand for them.

use super::density::of_one;
use super::field::Field;
use super::stationary::{Pin, Question};
use crate::grid::tuning::wells as tuning;
use crate::problem::Symmetry;
use crate::states::States;
use nalgebra::{DMatrix, DVector};

/// The shares of the wells.
#[derive(Debug)]
pub(super) struct Wells {
    /// The factor of what comes from each pin.
    pub(super) parts: Vec<f64>,
    /// Changes of these that rounding may make.
    pub(super) changes: Vec<Vec<f64>>,
    /// Whether the equations determine the shares.
    pub(super) determined: bool,
    /// M without its diagonal.
    arrives: DMatrix<f64>,
    /// The time that what passes a pin spends on its way.
    spent: Vec<f64>,
    /// The masses of what comes from each pin.
    masses: Vec<f64>,
    /// The well that each becomes by a change of signs, and its part of what both have.
    images: Vec<Vec<(usize, f64)>>,
    /// What is in each well.
    pub(super) shares: DVector<f64>,
}

impl Wells {
    pub(super) fn new(pins: &[Pin], block: usize, fields: &[Field], question: Question<'_>) -> Self {
        let count = pins.len();
        let moves = moves(pins, block);
        // The loss on the way from each pin at the edges, or what rounding hides.
        let lost = |to: f64| {
            if (1.0 - to).abs() > tuning::HIDDEN * tuning::ROUNDING { (1.0 - to).abs() } else { tuning::EXCHANGED }
        };
        let lost: Vec<f64> = moves.column_iter().map(|to| lost(to.sum())).collect();
        let masses: Vec<f64> = fields.iter().map(Field::mass).collect();
        let mut wells = Wells {
            parts: Vec::new(),
            changes: Vec::new(),
            determined: true,
            arrives: moves.map(|part| part.max(0.0)),
            spent: pins.iter().zip(&masses).map(|(pin, mass)| mass / pin.through).collect(),
            masses,
            images: images(&question.problem.symmetry(), fields),
            shares: DVector::zeros(count),
        };
        let mut shares = wells.stationary(&wells.arrives);
        let mut changes = wells.changed(&lost);
        if changes.iter().any(|change| change.amax() >= tuning::UNDETERMINED) {
            shares = counted(fields, question.states);
            // All may be in one well, or none.
            let unit = |i: usize| DVector::from_fn(count, |j, _| f64::from(u8::from(i == j)));
            changes = (0..count).map(|i| (unit(i) - &shares) / count as f64 * 2.0).collect();
            wells.determined = false;
        }
        wells.changes = wells.parts(changes);
        wells.determined |= wells.changes.is_empty();
        wells.shares = wells.averaged(&shares);
        wells.parts = wells.part(&wells.shares);
        wells
    }

    /// The shares if these are the moves between the pins.
    fn stationary(&self, arrives: &DMatrix<f64>) -> DVector<f64> {
        let passing = stationary_chain(arrives);
        let within = DVector::from_fn(passing.len(), |j, _| passing[j] * self.spent[j]);
        let sum = within.sum();
        within / sum
    }

    /// What changes in them if what is lost from each pin arrives at each of the others, in turn.
    fn changed(&self, lost: &[f64]) -> Vec<DVector<f64>> {
        let (count, known) = (self.masses.len(), self.stationary(&self.arrives));
        let pairs = (0..count).flat_map(|j| (0..count).filter(move |i| *i != j).map(move |i| (i, j)));
        let change = |(i, j): (usize, usize)| {
            let mut other = self.arrives.clone();
            other[(i, j)] += lost[j];
            self.stationary(&other) - &known
        };
        pairs.map(change).collect()
    }

    /// The change of the parts by twice what the shares of another solution differ by: a few numbers may be near by chance.
    pub(super) fn apart(&self, other: &Self) -> Vec<Vec<f64>> {
        if self.determined { self.parts(vec![(&other.shares - &self.shares) * 2.0]) } else { Vec::new() }
    }

    /// Shares that are symmetric where the problem is.
    fn averaged(&self, shares: &DVector<f64>) -> DVector<f64> {
        let with = |shares: DVector<f64>, image: &Vec<(usize, f64)>| {
            DVector::from_fn(shares.len(), |i, _| (shares[i] + shares[image[i].0]) * image[i].1)
        };
        self.images.iter().fold(shares.clone(), with)
    }

    fn part(&self, shares: &DVector<f64>) -> Vec<f64> {
        shares.iter().zip(&self.masses).map(|(share, mass)| share / mass).collect()
    }

    /// What changes of shares make of the parts, but for those that symmetry excludes.
    fn parts(&self, changes: Vec<DVector<f64>>) -> Vec<Vec<f64>> {
        let averaged = changes.iter().map(|change| self.averaged(change));
        averaged.filter(|change| change.amax() > 1e-14).map(|change| self.part(&change)).collect()
    }
}

/// M: what of the probability that comes from one pin, by column, arrives at another, by row.
pub(super) fn moves(pins: &[Pin], block: usize) -> DMatrix<f64> {
    DMatrix::from_fn(pins.len(), pins.len(), |i, j| {
        pins[i].through / pins[j].through * pins[j].from.inner[pins[i].cell * block]
    })
}

/// The stationary shares of a Markov chain by its transitions from j to i ≠ j, without subtractions.
fn stationary_chain(arrives: &DMatrix<f64>) -> Vec<f64> {
    let count = arrives.nrows();
    let mut rates = arrives.clone();
    for k in (1..count).rev() {
        let out: f64 = (0..k).map(|i| rates[(i, k)]).sum();
        for j in 0..k {
            let factor = rates[(k, j)] / out.max(f64::MIN_POSITIVE);
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

/// The shares of states that lie in cells where the mean of each field is the largest of all.
fn counted(fields: &[Field], states: &States) -> DVector<f64> {
    let mut counts = DVector::from_element(fields.len(), 0.0);
    let masses: Vec<f64> = fields.iter().map(Field::mass).collect();
    for cell in states.iter().filter_map(|x| fields[0].mesh.locate(x)) {
        let mean = |k: &usize| fields[*k].mean(cell) / masses[*k];
        if let Some(k) = (0..fields.len()).max_by(|a, b| mean(a).total_cmp(&mean(b))) {
            counts[k] += 1.0;
        }
    }
    let sum = counts.sum();
    if sum > 0.0 { counts / sum } else { DVector::from_element(fields.len(), 1.0 / fields.len() as f64) }
}

/// For each sign change of states that leaves the problem as it is, the well that each becomes, with its part of what both have: the
/// means of the states that change are 0. Halves would not do, since what comes from a pin has a little in the other wells.
fn images(symmetry: &Symmetry, fields: &[Field]) -> Vec<Vec<(usize, f64)>> {
    let mesh = &fields[0].mesh;
    let (domain, wells) = (mesh.domain(), 0..fields.len());
    let mean = |field: &Field| -> Vec<f64> {
        let width = |axis: usize| domain[axis][1] - domain[axis][0];
        (0..mesh.states()).map(|axis| of_one(field, axis, &|x: f64| x, 1) / field.mass() / width(axis)).collect()
    };
    let means: Vec<Vec<f64>> = fields.iter().map(mean).collect();
    let image = |flip: &Vec<bool>| -> Option<Vec<(usize, f64)>> {
        let distance = |i: usize, j: usize| -> f64 {
            let turned = |axis: usize| if flip[axis] { -means[i][axis] } else { means[i][axis] };
            (0..mesh.states()).map(|axis| (turned(axis) - means[j][axis]).powi(2)).sum()
        };
        let nearest = |i: usize| wells.clone().min_by(|a, b| distance(i, *a).total_cmp(&distance(i, *b)));
        let image: Vec<usize> = wells.clone().filter_map(nearest).collect();
        let part = |i: usize| {
            let apart = |axis: &usize| (means[i][*axis] - means[image[i]][*axis]).abs();
            let flipped = (0..mesh.states()).filter(|axis| flip[*axis]);
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
