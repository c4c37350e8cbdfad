//! How much is in each of several wells.
//!
//! M_ji, what of the density from pin i arrives at pin j, is a Markov chain of the wells: c = M c gives their shares without
//! subtractions (W. K. Grassmann, M. I. Taksar and D. P. Heyman, 1985, doi:10.1287/opre.33.5.1107). M has rounding errors of 1e-13:
//! where wells exchange less, their shares are not determined, and those of trajectories stand for them.

use super::field::Field;
use super::stationary::{Pin, Question};
use crate::grid::tuning::wells as tuning;
use crate::problem::Symmetry;
use crate::states::States;
use nalgebra::{DMatrix, DVector};

/// The shares of the wells.
pub(super) struct Wells {
    /// The factor of what comes from each pin.
    pub(super) parts: Vec<f64>,
    /// Changes of these that cannot be excluded, where masses are 1.
    pub(super) changes: Vec<Vec<f64>>,
    /// Whether the equations determine the shares.
    pub(super) determined: bool,
}

impl Wells {
    pub(super) fn new(pins: &[Pin], block: usize, fields: &[Field], question: Question<'_>) -> Self {
        let count = pins.len();
        if count == 1 {
            return Wells { parts: vec![1.0], changes: Vec::new(), determined: true };
        }
        let arrives = DMatrix::from_fn(count, count, |i, j| pins[j].from.inner[pins[i].cell * block].max(0.0));
        // The loss on the way from each pin, at least what rounding hides.
        let lost: Vec<f64> = (0..count)
            .map(|j| {
                let sum: f64 = (0..count).map(|i| pins[j].from.inner[pins[i].cell * block]).sum();
                (1.0 - sum).abs().max(tuning::ROUNDING)
            })
            .collect();
        let masses: Vec<f64> = fields.iter().map(Field::mass).collect();
        let shares = |arrives: &DMatrix<f64>| {
            let parts = stationary_chain(arrives);
            let sum: f64 = parts.iter().zip(&masses).map(|(part, mass)| part * mass).sum();
            DVector::from_iterator(count, parts.iter().zip(&masses).map(|(part, mass)| part * mass / sum))
        };
        let known = shares(&arrives);
        // What each of the rates may be off by, in turn.
        let mut changes: Vec<DVector<f64>> = Vec::new();
        let mut uncertain = 0.0_f64;
        for j in 0..count {
            for i in (0..count).filter(|i| *i != j) {
                let mut other = arrives.clone();
                other[(i, j)] += lost[j];
                let change = shares(&other) - &known;
                uncertain = uncertain.max(change.amax());
                changes.push(change);
            }
        }
        let determined = uncertain < tuning::UNDETERMINED;
        let (mut shares, mut changes) = (known, changes);
        if !determined {
            shares = counted(fields, question.states);
            changes = (0..count)
                .map(|i| {
                    // All may be in one well, or none.
                    let unit = DVector::from_fn(count, |j, _| f64::from(u8::from(i == j)));
                    (unit - &shares) / count as f64 * 2.0
                })
                .collect();
        }
        let symmetry = question.problem.symmetry();
        let images = images(&symmetry, pins, fields);
        let averaged = |shares: &DVector<f64>| {
            images.iter().fold(shares.clone(), |shares, image| {
                DVector::from_fn(count, |i, _| (shares[i] + shares[image[i]]) / 2.0)
            })
        };
        let (shares, changes): (_, Vec<_>) = (averaged(&shares), changes.iter().map(averaged).collect());
        let parts = |shares: &DVector<f64>| shares.iter().zip(&masses).map(|(share, mass)| share / mass).collect();
        let changes: Vec<_> = changes.iter().filter(|change| change.amax() > 1e-14).collect();
        Wells {
            parts: parts(&shares),
            determined: determined || changes.is_empty(),
            changes: changes.into_iter().map(parts).collect(),
        }
    }
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

/// For each sign change of states that leaves the problem as it is, the wells that become each other.
fn images(symmetry: &Symmetry, pins: &[Pin], fields: &[Field]) -> Vec<Vec<usize>> {
    let mesh = &fields[0].mesh;
    let domain = mesh.domain();
    let peaks: Vec<Vec<f64>> = fields.iter().map(|field| mesh.centre(&mesh.cells[field.peak()])).collect();
    let image = |flip: &Vec<bool>| -> Option<Vec<usize>> {
        let nearest = |i: usize| {
            let distance = |j: &usize| -> f64 {
                let along = |axis: usize| {
                    let turned = if flip[axis] { -peaks[i][axis] } else { peaks[i][axis] };
                    ((turned - peaks[*j][axis]) / (domain[axis][1] - domain[axis][0])).powi(2)
                };
                (0..mesh.states()).map(along).sum()
            };
            (0..pins.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(i)
        };
        let image: Vec<usize> = (0..pins.len()).map(nearest).collect();
        let back = (0..pins.len()).all(|i| image[image[i]] == i);
        (back && (0..pins.len()).any(|i| image[i] != i)).then_some(image)
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
