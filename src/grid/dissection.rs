//! Nested dissection of the mesh (A. George, 1973, doi:10.1137/0710032).
//!
//! A stripe of elements divides a piece into two parts that are not coupled. They are eliminated first, the stripe last, and so on
//! within each, so that factors fill only within stripes and towards those around. A wall couples speeds of both signs: next to it
//! a stripe holds speeds that become each other by the rebound.

use super::space::{Side, Space};
use super::sparse::SparseMatrix;
use std::collections::BTreeSet;

/// An element more in a stripe costs as much as so many in the larger one of the pieces beside it. From 1 to 8 the time of a
/// solution changes by a few percent.
const STRIPE: usize = 3;

/// Elements that are eliminated together, after the parts below them.
#[derive(Clone, Debug)]
pub(super) struct Front {
    /// Rising.
    pub(super) own: Vec<usize>,
    /// Those eliminated later that the own elements, or any of the parts below, are coupled with, rising.
    pub(super) boundary: Vec<usize>,
    /// The places of the boundary's elements in the front above, its own counted first.
    pub(super) places: Vec<usize>,
    pub(super) parts: Vec<Front>,
    /// Elements of all parts.
    pub(super) below: usize,
}

/// Numbers in memory.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Numbers {
    /// What is kept: the factors.
    kept: f64,
    /// What is there at most at a time, however the parts are dealt to threads.
    pub(super) most: f64,
}

impl Front {
    /// All elements of a mesh on which `matrix` couples them.
    pub(super) fn whole(space: &Space, matrix: &SparseMatrix) -> Self {
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
            eliminated: vec![false; space.elements()],
        };
        dissection.divided((0..space.elements()).collect())
    }

    /// The place of an element among the own ones and the boundary.
    pub(super) fn place(&self, element: usize) -> Option<usize> {
        let among = |elements: &[usize]| elements.binary_search(&element).ok();
        among(&self.own).or_else(|| among(&self.boundary).map(|place| self.own.len() + place))
    }

    /// What the factors take with `block` unknowns per element.
    pub(super) fn numbers(&self, block: f64) -> Numbers {
        let [own, boundary] = [&self.own, &self.boundary].map(|elements| elements.len() as f64 * block);
        let parts = self.parts.iter().map(|part| (part.numbers(block), (part.boundary.len() as f64 * block).powi(2)));
        let [mut kept, mut below, mut held] = [0.0; 3];
        for (numbers, left) in parts {
            kept += numbers.kept;
            below += numbers.most;
            held += numbers.kept + left;
        }
        let factors = own * (own + 2.0 * boundary);
        Numbers { kept: kept + factors, most: below.max(held + factors + boundary * boundary) }
    }
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
    /// The number of the last cut whose lower part is next to an element.
    reached: Vec<usize>,
    cuts: usize,
    eliminated: Vec<bool>,
}

impl Dissection {
    fn divided(&mut self, piece: Vec<usize>) -> Front {
        let below = piece.len();
        let cuts: Vec<_> = (0..3).filter_map(|key| self.cut(&piece, key)).collect();
        let cost = |[low, stripe, high]: &[Vec<usize>; 3]| STRIPE * stripe.len() + low.len().max(high.len());
        match cuts.into_iter().min_by_key(cost) {
            Some([low, stripe, high]) => {
                let parts = vec![self.divided(low), self.divided(high)];
                self.front(stripe, parts, below)
            }
            None => self.front(piece, Vec::new(), below),
        }
    }

    fn front(&mut self, mut own: Vec<usize>, parts: Vec<Front>, below: usize) -> Front {
        own.sort_unstable();
        own.iter().for_each(|element| self.eliminated[*element] = true);
        let around = own.iter().flat_map(|element| &self.near[*element]);
        let coupled = around.chain(parts.iter().flat_map(|part| &part.boundary));
        let later: BTreeSet<usize> = coupled.copied().filter(|element| !self.eliminated[*element]).collect();
        let below = below - own.len();
        let mut front =
            Front { own, boundary: later.into_iter().collect(), places: Vec::new(), parts: Vec::new(), below };
        front.parts = parts;
        for k in 0..front.parts.len() {
            let places = front.parts[k].boundary.iter().filter_map(|element| front.place(*element)).collect();
            front.parts[k].places = places;
        }
        front
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
            self.reached[*next] = self.cuts;
        }
        let (stripe, high) = rest.into_iter().partition(|element: &usize| self.reached[*element] == self.cuts);
        [low, stripe, high]
    }
}

#[cfg(test)]
mod tests {
    use super::super::legendre::Axis;
    use super::*;

    /// The pattern of a mesh of `columns` by `rows` elements with one unknown each, in which a wall at the lower side couples the
    /// rows above the middle with those below it.
    fn coupled(columns: usize, rows: usize) -> (Space, SparseMatrix) {
        let lines = |cells: usize| (0..=cells).map(|k| k as f64 - cells as f64 / 2.0).collect();
        let axes = [columns, rows].map(|cells| Axis { origin: 0.0, lines: lines(cells) });
        let space = Space { axes, degree: 0, sides: [Side::Wall(0.7), Side::Open] };
        let mut matrix = SparseMatrix { size: columns * rows, columns: vec![0], rows: vec![], values: vec![] };
        for element in 0..matrix.size {
            let [i, j] = space.place(element);
            let next = |other: &usize| {
                let [k, l] = space.place(*other);
                i.abs_diff(k) + j.abs_diff(l) <= 1 || (i == 0 && k == 0 && j + l + 1 == rows)
            };
            matrix.rows.extend((0..columns * rows).filter(next));
            matrix.columns.push(matrix.rows.len());
        }
        matrix.values = vec![1.0; matrix.rows.len()];
        (space, matrix)
    }

    /// Adds the elements of a front and of all below it to `found`, and checks what each front is coupled with.
    fn visit(front: &Front, near: &[Vec<usize>], found: &mut Vec<usize>) {
        let before = found.len();
        for part in &front.parts {
            visit(part, near, found);
            let places: Vec<_> = part.boundary.iter().filter_map(|element| front.place(*element)).collect();
            assert_eq!(places, part.places);
            assert_eq!(places.len(), part.boundary.len());
        }
        assert_eq!(found.len() - before, front.below);
        found.extend(&front.own);
        let below = &found[before..];
        let coupled = front.own.iter().flat_map(|element| &near[*element]);
        assert!(coupled.clone().all(|element| front.place(*element).is_some() || below.contains(element)));
        assert!(front.boundary.iter().all(|element| !below.contains(element)));
    }

    #[test]
    fn every_element_is_in_one_front_and_what_it_is_coupled_with_in_the_same_or_next_to_it() {
        for [columns, rows] in [[1, 1], [2, 1], [5, 4], [9, 10], [30, 7]] {
            let (space, matrix) = coupled(columns, rows);
            let front = Front::whole(&space, &matrix);
            let mut found = Vec::new();
            visit(&front, &neighbours(&space, &matrix), &mut found);
            found.sort_unstable();
            assert!(front.boundary.is_empty() && found.into_iter().eq(0..columns * rows));
        }
    }

    /// Two elements of `b` unknowns: one front of 4b² numbers. With more, the last front of a square mesh holds its stripe alone.
    #[test]
    fn numbers_are_those_of_the_fronts() {
        let whole = |columns, rows| {
            let (space, matrix) = coupled(columns, rows);
            Front::whole(&space, &matrix)
        };
        assert_eq!(whole(2, 1).numbers(3.0).most, 36.0);
        let three = whole(3, 1);
        assert_eq!((three.own.as_slice(), three.parts.len()), (&[1][..], 2));
        // Two outer elements, each with its coupling to the stripe and what it leaves there, and the stripe.
        assert_eq!(three.numbers(1.0).most, 2.0 * (3.0 + 1.0) + 1.0);
    }
}
