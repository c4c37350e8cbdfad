//! The order of elimination: nested dissection of the mesh (A. George, 1973, doi:10.1137/0710032).
//!
//! A stripe of elements divides a piece into two that are not coupled. They are eliminated first, the stripe last, and so on
//! within each, so that factors fill only within stripes. A stripe of single elements would do for the matrix A, but with
//! row exchanges factors fill like those of AᵀA, in which elements two apart are coupled. A wall couples speeds of both signs:
//! next to it a stripe holds speeds that become each other by the rebound.

use super::space::{Side, Space};
use super::sparse::SparseMatrix;
use std::collections::BTreeSet;

/// Pieces of this many elements are not divided.
const WHOLE: usize = 16;
/// An element more in a stripe costs as much as so many in the larger one of the pieces beside it. From 1 to 10 the time of the
/// factors changes by a tenth.
const STRIPE: usize = 3;

/// All unknowns of `matrix` in the order of their elimination.
pub(super) fn elimination_order(space: &Space, matrix: &SparseMatrix) -> Vec<usize> {
    let rank = ranks(space);
    let keys = (0..space.elements()).map(|element| {
        let [i, j] = space.place(element);
        [i, j, rank[j]]
    });
    let mut dissection = Dissection {
        near: neighbours(space, matrix),
        keys: keys.collect(),
        reached: vec![0; space.elements()],
        cuts: 0,
        order: Vec::with_capacity(space.elements()),
    };
    dissection.divide((0..space.elements()).collect());
    let block = space.block();
    dissection.order.into_iter().flat_map(|element| element * block..(element + 1) * block).collect()
}

/// The elements that each one is coupled with, itself among them.
fn neighbours(space: &Space, matrix: &SparseMatrix) -> Vec<Vec<usize>> {
    let block = space.block();
    let mut near = vec![Vec::new(); space.elements()];
    for element in 0..space.elements() {
        let entries = matrix.columns[element * block]..matrix.columns[(element + 1) * block];
        for row in matrix.rows[entries].iter().map(|row| row / block).collect::<BTreeSet<_>>() {
            near[element].push(row);
            near[row].push(element);
        }
    }
    near
}

/// The place of each row among all by its speed, at which one sign is that after the rebound.
fn ranks(space: &Space) -> Vec<usize> {
    let restitution = space.sides.map(|side| if let Side::Wall(r) = side { r } else { 1.0 });
    let lines = &space.axes[1].lines;
    let speed = |j: usize| {
        let twice = lines[j] + lines[j + 1];
        if twice < 0.0 { -twice * restitution[0] } else { twice * restitution[1] }
    };
    let mut rows: Vec<usize> = (0..space.axes[1].cells()).collect();
    rows.sort_by(|a, b| speed(*a).total_cmp(&speed(*b)));
    let mut rank = vec![0; rows.len()];
    rows.iter().enumerate().for_each(|(place, row)| rank[*row] = place);
    rank
}

struct Dissection {
    near: Vec<Vec<usize>>,
    /// Column, row, and rank of the row's speed of each element.
    keys: Vec<[usize; 3]>,
    /// The number of the last cut whose lower part is next to an element or one away from it.
    reached: Vec<usize>,
    cuts: usize,
    order: Vec<usize>,
}

impl Dissection {
    fn divide(&mut self, piece: Vec<usize>) {
        let cuts: Vec<_> = (0..3).filter(|_| piece.len() > WHOLE).filter_map(|key| self.cut(&piece, key)).collect();
        let cost = |[low, stripe, high]: &[Vec<usize>; 3]| STRIPE * stripe.len() + low.len().max(high.len());
        match cuts.into_iter().min_by_key(cost) {
            Some([low, stripe, high]) => {
                self.divide(low);
                self.divide(high);
                self.order.extend(stripe);
            }
            None => self.order.extend(piece),
        }
    }

    /// The lower part of a piece by one of the keys, the stripe, and the upper part.
    fn cut(&mut self, piece: &[usize], key: usize) -> Option<[Vec<usize>; 3]> {
        let mut values: Vec<usize> = piece.iter().map(|element| self.keys[*element][key]).collect();
        values.sort_unstable();
        // With the stripe that the middle has, the two parts are even.
        let [_, stripe, _] = self.cut_at(piece, key, values[values.len() / 2]);
        let parts = self.cut_at(piece, key, values[(values.len() - stripe.len()) / 2]);
        (!parts[0].is_empty() && !parts[2].is_empty()).then_some(parts)
    }

    fn cut_at(&mut self, piece: &[usize], key: usize, value: usize) -> [Vec<usize>; 3] {
        self.cuts += 1;
        let (low, rest): (Vec<_>, Vec<_>) = piece.iter().partition(|element| self.keys[**element][key] < value);
        for next in low.iter().flat_map(|element: &usize| &self.near[*element]) {
            self.near[*next].iter().for_each(|second| self.reached[*second] = self.cuts);
        }
        let (stripe, high) = rest.into_iter().partition(|element: &usize| self.reached[*element] == self.cuts);
        [low, stripe, high]
    }
}
