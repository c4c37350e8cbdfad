//! A piecewise polynomial: its values and integrals.

use super::legendre::Table;
use super::space::Space;
use crate::numerics::Rule;

/// The coefficients of a density on its elements.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Field {
    pub(super) space: Space,
    pub(super) coefficients: Vec<f64>,
}

impl Field {
    /// The L² projection of a function.
    pub(super) fn projected(space: &Space, g: impl Fn([f64; 2]) -> f64) -> Self {
        let table = Table::new(space.degree, space.rule(8));
        let mut field = Field { space: space.clone(), coefficients: vec![0.0; space.unknowns()] };
        for (element, block) in field.coefficients.chunks_exact_mut(space.block()).enumerate() {
            for (x, weight, [a, b]) in space.nodes(element, &table) {
                let value = weight * g(x) / space.root_area(element);
                for (row, a) in block.chunks_exact_mut(b.len()).zip(a) {
                    row.iter_mut().zip(b).for_each(|(c, b)| *c += value * a * b);
                }
            }
        }
        field
    }

    /// ∫ |p| dx.
    pub(super) fn size(&self) -> f64 {
        let mut sum = 0.0;
        self.for_each_node(self.space.rule(0), |_, weight, p| sum += weight * p.abs());
        sum
    }

    fn block(&self, element: usize) -> &[f64] {
        let size = self.space.block();
        &self.coefficients[element * size..(element + 1) * size]
    }

    /// The value at a state; 0 outside the domain.
    pub(super) fn value(&self, x: &[f64; 2]) -> f64 {
        let u: [f64; 2] = std::array::from_fn(|i| x[i] - self.space.axes[i].origin);
        let cells = [0, 1].map(|i| self.space.axes[i].locate(u[i]));
        let [Some(i), Some(j)] = cells else { return 0.0 };
        let [a, b] = [(0, i), (1, j)].map(|(s, cell)| self.space.axes[s].basis(cell, self.space.degree, u[s]).0);
        self.contract(self.space.element(i, j), &a, &b)
    }

    fn contract(&self, element: usize, a: &[f64], b: &[f64]) -> f64 {
        let rows = self.block(element).chunks_exact(b.len());
        rows.zip(a).map(|(row, a)| a * row.iter().zip(b).map(|(c, b)| c * b).sum::<f64>()).sum()
    }

    /// ∫ g₀(x₀) g₁(x₁) p dx from the integrals ∫ g φ of every cell of both axes.
    pub(super) fn integrate(&self, weights: [&[Vec<f64>]; 2]) -> f64 {
        let mut sum = 0.0;
        for (i, a) in weights[0].iter().enumerate().filter(|(_, a)| !a.is_empty()) {
            for (j, b) in weights[1].iter().enumerate().filter(|(_, b)| !b.is_empty()) {
                sum += self.contract(self.space.element(i, j), a, b);
            }
        }
        sum
    }

    /// ∫ g φ_k du for every cell of the axis of `state`, over `range`; `extra` is the degree of g.
    pub(super) fn weights(&self, state: usize, extra: usize, range: [f64; 2], g: impl Fn(f64) -> f64) -> Vec<Vec<f64>> {
        let axis = &self.space.axes[state];
        let rule = self.space.rule(extra);
        let range = range.map(|x| x - axis.origin);
        (0..axis.cells())
            .map(|cell| axis.project(cell, self.space.degree, &rule, range, |u| g(u + axis.origin)))
            .collect()
    }

    /// φ_k at x for the cell that holds it, nothing for all other cells.
    pub(super) fn point(&self, state: usize, x: f64) -> Vec<Vec<f64>> {
        let axis = &self.space.axes[state];
        let u = x - axis.origin;
        let mut weights = vec![Vec::new(); axis.cells()];
        if let Some(cell) = axis.locate(u) {
            weights[cell] = axis.basis(cell, self.space.degree, u).0;
        }
        weights
    }

    /// Calls `visit` with every quadrature node: the state, the weight and the value there.
    pub(super) fn for_each_node(&self, rule: Rule, mut visit: impl FnMut([f64; 2], f64, f64)) {
        let table = Table::new(self.space.degree, rule);
        for element in 0..self.space.elements() {
            for (x, weight, [a, b]) in self.space.nodes(element, &table) {
                visit(x, weight, self.contract(element, a, b) / self.space.root_area(element));
            }
        }
    }

    /// The integral over everything.
    pub(super) fn mass(&self) -> f64 {
        (0..self.space.elements()).map(|e| self.space.root_area(e) * self.block(e)[0]).sum()
    }

    /// The element with the highest mean density.
    pub(super) fn peak_element(&self) -> usize {
        let mean = |e: &usize| self.block(*e)[0] / self.space.root_area(*e);
        (0..self.space.elements()).max_by(|a, b| mean(a).total_cmp(&mean(b))).unwrap_or(0)
    }
}
