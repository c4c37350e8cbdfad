//! The Galerkin equations on the whole space: ∫ r(x; a) ψ_k f_N dx = 0.

use super::hermite::{ProductTable, combination, derivative, in_hermite, standard_normal};
use crate::fokker_planck::FokkerPlanck;
use crate::polynomial::{Polynomial, monomials, total_degree};
use faer::{Col, Mat};
use std::collections::HashMap;

/// As many nonlinear equations as unknowns, with their exact Jacobian.
///
/// The functions of a lower order come first, so that its solution followed by zeros is a start for a higher one.
pub(super) trait GalerkinEquations {
    /// The left sides F(a) and the Jacobian ∂F/∂a.
    fn evaluate(&self, a: &Col<f64>) -> (Col<f64>, Mat<f64>);

    /// The coefficients of ln f_N itself, −|z|²/2, the start of every search.
    fn gaussian(&self) -> Col<f64>;

    /// Q as a polynomial in the scaled coordinates; its constant part is left out.
    fn polynomial(&self, a: &Col<f64>) -> Polynomial;
}

/// F_k(a) = c_k + Σ_i L_ki a_i + Σ_{i≤j} T_kij a_i a_j, with coefficients exact but for rounding.
///
/// The operator is that in scaled coordinates, in which f_N is standard normal, and the unknowns are the coefficients of
/// Q in the orthonormal Hermite basis; the same functions test the equation.
#[derive(Clone, Debug)]
pub(super) struct HermiteGalerkin {
    states: usize,
    basis: Vec<Vec<u32>>,
    constant: Col<f64>,
    linear: Mat<f64>,
    quadratic: Vec<Triple>,
}

/// One coefficient T_kij.
#[derive(Clone, Copy, Debug)]
struct Triple {
    k: u32,
    i: u32,
    j: u32,
    value: f64,
}

impl HermiteGalerkin {
    /// The equations of order `order` for an operator in scaled coordinates.
    pub(super) fn new(operator: &FokkerPlanck, order: u32) -> Self {
        let states = operator.dimension();
        let basis = monomials(states, order).split_off(1);
        // The number of each basis function.
        let rows: HashMap<Vec<u32>, usize> = basis.iter().cloned().zip(0..).collect();
        let terms = OperatorSeries::new(operator);
        let table = ProductTable::new(terms.degree + order);
        let mut constant = Col::zeros(basis.len());
        for (m, c) in terms.constant.terms() {
            if let Some(&k) = rows.get(m) {
                constant[k] = c;
            }
        }
        let mut linear = Mat::zeros(basis.len(), basis.len());
        for (i, index) in basis.iter().enumerate() {
            terms.linear(&table, index, &mut |m, c| {
                let Some(row) = (total_degree(m) <= order).then(|| rows.get(m)).flatten() else { return };
                linear[(*row, i)] += c;
            });
        }
        let quadratic = terms.quadratic(&table, &basis, &rows, order);
        HermiteGalerkin { states, basis, constant, linear, quadratic }
    }
}

impl GalerkinEquations for HermiteGalerkin {
    fn evaluate(&self, a: &Col<f64>) -> (Col<f64>, Mat<f64>) {
        let mut jacobian = self.linear.clone();
        for t in &self.quadratic {
            let (k, i, j) = (t.k as usize, t.i as usize, t.j as usize);
            jacobian[(k, i)] += t.value * a[j];
            jacobian[(k, j)] += t.value * a[i];
        }
        // The linear part counts once and the quadratic part half of its derivative.
        let residual = &self.constant + (&self.linear + &jacobian) * a * 0.5;
        (residual, jacobian)
    }

    fn gaussian(&self) -> Col<f64> {
        standard_normal(&self.basis)
    }

    fn polynomial(&self, a: &Col<f64>) -> Polynomial {
        combination(self.states, &self.basis, a)
    }
}

/// The parts of the residual in the Hermite basis: r = c − Σ_p g_p ∂_pQ + ½ Σ B_pq (∂_p∂_qQ + ∂_pQ ∂_qQ).
struct OperatorSeries {
    constant: Polynomial,
    /// −f_p + Σ_q ∂_qB_pq.
    gradient: Vec<Polynomial>,
    /// B_pq where it does not vanish.
    diffusion: Vec<(usize, usize, Polynomial)>,
    degree: u32,
}

impl OperatorSeries {
    fn new(operator: &FokkerPlanck) -> Self {
        let states = operator.dimension();
        let constant = operator.residual(&Polynomial::zero(states));
        let gradient = operator.backward();
        let mut degree = gradient.iter().map(Polynomial::degree).max().unwrap_or(0);
        let mut diffusion = Vec::new();
        for (p, row) in operator.diffusion().iter().enumerate() {
            for (q, b) in row.iter().enumerate().filter(|(_, b)| !b.is_zero()) {
                degree = degree.max(b.degree());
                diffusion.push((p, q, in_hermite(b)));
            }
        }
        let gradient = gradient.iter().map(in_hermite).collect();
        OperatorSeries { constant: in_hermite(&constant), gradient, diffusion, degree }
    }

    /// Visits the terms of what r has in front of the unknown of `index`.
    fn linear(&self, table: &ProductTable, index: &[u32], visit: &mut impl FnMut(&[u32], f64)) {
        let all = self.degree + total_degree(index);
        for (p, g) in self.gradient.iter().enumerate() {
            let Some((slope, factor)) = derivative(index, p) else { continue };
            for (m, c) in g.terms() {
                table.product(m, &slope, all, &mut |m, t| visit(m, factor * c * t));
            }
        }
        for (p, q, b) in &self.diffusion {
            let Some((slope, first)) = derivative(index, *p) else { continue };
            let Some((curvature, second)) = derivative(&slope, *q) else { continue };
            for (m, c) in b.terms() {
                table.product(m, &curvature, all, &mut |m, t| visit(m, 0.5 * first * second * c * t));
            }
        }
    }

    /// All T_kij: the projections of ½ Σ B_pq ∂_pψ_i ∂_qψ_j, counted twice for i < j.
    fn quadratic(
        &self,
        table: &ProductTable,
        basis: &[Vec<u32>],
        rows: &HashMap<Vec<u32>, usize>,
        order: u32,
    ) -> Vec<Triple> {
        let mut triples = Vec::new();
        let mut row = vec![0.0; basis.len()];
        for (i, index) in basis.iter().enumerate() {
            let weighted = self.weighted_gradient(table, index);
            for (j, other) in basis.iter().enumerate().skip(i) {
                let twice = if i == j { 1.0 } else { 2.0 };
                for (q, series) in weighted.iter().enumerate().filter(|(_, series)| !series.is_zero()) {
                    let Some((slope, factor)) = derivative(other, q) else { continue };
                    for (m, c) in series.terms() {
                        table.product(m, &slope, order, &mut |m, t| {
                            if let Some(&k) = rows.get(m) {
                                row[k] += twice * factor * c * t;
                            }
                        });
                    }
                }
                for (k, value) in row.iter_mut().enumerate().filter(|(_, value)| **value != 0.0) {
                    triples.push(Triple { k: k as u32, i: i as u32, j: j as u32, value: std::mem::take(value) });
                }
            }
        }
        triples
    }

    /// For each q the series ½ Σ_p B_pq ∂_pψ.
    fn weighted_gradient(&self, table: &ProductTable, index: &[u32]) -> Vec<Polynomial> {
        let mut weighted = vec![Polynomial::zero(index.len()); index.len()];
        for (p, q, b) in &self.diffusion {
            let Some((slope, factor)) = derivative(index, *p) else { continue };
            let all = self.degree + total_degree(index);
            for (m, c) in b.terms() {
                table.product(m, &slope, all, &mut |m, t| weighted[*q].add_term(m, 0.5 * factor * c * t));
            }
        }
        weighted
    }
}
