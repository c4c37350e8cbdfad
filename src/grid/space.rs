//! The elements, and the conditions at the domain's sides.

use super::legendre::{Axis, Table};
use crate::numerics::Rule;

/// The condition at one side of the domain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Side {
    /// Probability that is carried out is lost; none comes in.
    Open,
    /// A level: the same, and on purpose.
    Level,
    /// A wall with restitution r: probability that leaves with velocity −w/r comes back with velocity w.
    Wall(f64),
}

/// Tensor products of Legendre polynomials of one degree on a rectangular mesh of two states.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Space {
    pub(super) axes: [Axis; 2],
    pub(super) degree: usize,
    /// The lower and the upper side of state 0.
    pub(super) sides: [Side; 2],
}

impl Space {
    /// Basis functions along one axis of an element.
    pub(super) fn modes(&self) -> usize {
        self.degree + 1
    }

    /// Basis functions of an element.
    pub(super) fn block(&self) -> usize {
        self.modes() * self.modes()
    }

    pub(super) fn elements(&self) -> usize {
        self.axes[0].cells() * self.axes[1].cells()
    }

    pub(super) fn unknowns(&self) -> usize {
        self.elements() * self.block()
    }

    /// The number of the element in column `i` and row `j`.
    pub(super) fn element(&self, i: usize, j: usize) -> usize {
        i * self.axes[1].cells() + j
    }

    /// The column and the row of an element.
    pub(super) fn place(&self, element: usize) -> [usize; 2] {
        [element / self.axes[1].cells(), element % self.axes[1].cells()]
    }

    /// √area: the coefficient of the constant function 1 in an element's first basis function, and the mass of that
    /// function.
    pub(super) fn root_area(&self, element: usize) -> f64 {
        let [i, j] = self.place(element);
        (self.axes[0].width(i) * self.axes[1].width(j)).sqrt()
    }

    /// The nodes of an element as states, each with its weight and the basis along both states, times √area.
    pub(super) fn nodes<'a>(
        &'a self,
        element: usize,
        table: &'a Table,
    ) -> impl Iterator<Item = ([f64; 2], f64, [&'a [f64]; 2])> {
        let place = self.place(element);
        let area = self.axes[0].width(place[0]) * self.axes[1].width(place[1]);
        (0..table.len() * table.len()).map(move |k| {
            let nodes = [k / table.len(), k % table.len()];
            let at = |s: usize| self.axes[s].origin + self.axes[s].place(place[s], table.nodes[nodes[s]]);
            let weight = area * table.weights[nodes[0]] * table.weights[nodes[1]];
            ([at(0), at(1)], weight, nodes.map(|node| table.values[node].as_slice()))
        })
    }

    /// A rule that integrates a product of two basis functions and a polynomial of degree `extra` exactly.
    pub(super) fn rule(&self, extra: usize) -> Rule {
        Rule::legendre(self.degree + 1 + extra.div_ceil(2))
    }
}
