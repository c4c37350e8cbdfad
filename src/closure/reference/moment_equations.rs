//! The moment equations as a linear system for the ratio of the density to a reference weight.

use crate::closure::discretisation::nodes::Table;
use crate::closure::space::nested_spaces::Truncation;
use crate::closure::space::orthonormal::Change;
use crate::numerics::{combination, weighted_product, weighted_sum};
use faer::Mat;
use faer::prelude::*;

/// The density p̂ = ω (1 + δ) that satisfies the moment equations E\[Gψ_k\] = 0 of a whole space of functions, δ itself
/// a combination of them.
///
/// The equations are linear in δ, Σ_l A_kl d_l = −F_k with A_kl = ∫ ω ψ_l Gψ_k dx, and the derivatives stand on the test
/// functions alone, so that any positive ω will do. Under ω ≈ p the symmetric part of A is −½ ∫ ω ∇ψ·B∇ψ: the equations
/// are as stable as the system itself.
#[derive(Clone, Debug)]
pub(in crate::closure) struct Resolved {
    /// δ at the nodes.
    pub(in crate::closure) correction: Vec<f64>,
    /// Its coefficients in the functions of the table.
    pub(in crate::closure) coefficients: Vec<f64>,
    /// ∫ ω |δ|.
    pub(in crate::closure) size: f64,
    /// An estimate of the error of p̂ in the L¹ norm: the share of δ in the functions of the highest degrees, which still
    /// changes with the degree, and what the edge of the domain may do.
    pub(in crate::closure) error: f64,
}

/// Solves the moment equations, by two expressions for F.
///
/// F_k = ∫ ω Gψ_k dx needs no derivatives of ω. F_k = ∫ ω r ψ_k dx, with the residual r of ω, differs from it by the flux
/// through the edge of the domain, and is exactly zero where ω is the solution. The first is better where ω is far off at the
/// edge, the second near the solution; the smoother of the two is returned, and their distance is part of its error.
///
/// `measure` holds ω times the quadrature weights, with sum 1, at the rows of `table`, of which the first `columns` count; the
/// rows beyond its length are impacts, the equations' other terms, and `passages` holds their weights. `None` where the functions
/// are linearly dependent under ω or the system is singular.
pub(in crate::closure) fn resolve(
    table: &Table,
    columns: usize,
    measure: &[f64],
    passages: &[f64],
    residual: Option<&[f64]>,
    truncation: Truncation,
) -> Option<Resolved> {
    let (values, rates) = (table.functions.values.get(.., ..columns), table.rates.get(.., ..columns));
    // Impacts are nodes with weights of their own.
    let weights = [measure, passages].concat();
    let mut matrix = weighted_product(rates, values, &weights);
    let values = values.get(..measure.len(), ..);
    let change = Change::new(values, measure)?;
    change.transform(matrix.as_mut());
    change.transform(matrix.transpose_mut());
    let by_weight = Mat::from_fn(columns - 1, 1, |k, _| -matrix[(k + 1, 0)]);
    let by_residual = residual.map(|r| {
        let weighted: Vec<f64> = measure.iter().zip(r).map(|(w, r)| w * r).collect();
        let mut tested = Mat::zeros(columns, 1);
        tested.col_as_slice_mut(0).copy_from_slice(&weighted_sum(values, &weighted));
        change.transform(tested.as_mut());
        Mat::from_fn(columns - 1, 1, |k, _| -tested[(k + 1, 0)])
    });
    let factors = matrix.get(1.., 1..).partial_piv_lu();
    let at_nodes = |c: &[f64]| combination(values, c);
    let solutions = std::iter::once(by_weight).chain(by_residual).filter_map(|right| {
        let solved = factors.solve(right);
        let kept = truncation.end - 1;
        let d: Vec<f64> = std::iter::once(0.0).chain((0..kept).map(|k| solved[(k, 0)])).collect();
        let highest: Vec<f64> =
            d.iter().enumerate().map(|(k, d)| if k < truncation.lower { 0.0 } else { *d }).collect();
        let rough: f64 = measure.iter().zip(at_nodes(&change.coefficients(&highest))).map(|(w, d)| w * d.abs()).sum();
        let coefficients = change.coefficients(&d);
        let correction = at_nodes(&coefficients);
        (correction.iter().all(|d| d.is_finite()) && rough.is_finite()).then(|| {
            let size = measure.iter().zip(&correction).map(|(w, d)| w * d.abs()).sum();
            Resolved { correction, coefficients, size, error: rough }
        })
    });
    let mut solutions: Vec<Resolved> = solutions.collect();
    if let [by_weight, by_residual] = &mut solutions[..] {
        let apart = measure
            .iter()
            .zip(by_weight.correction.iter().zip(&by_residual.correction))
            .map(|(w, (a, b))| w * (a - b).abs())
            .sum::<f64>();
        by_weight.error += apart;
        by_residual.error += apart;
    }
    let best = solutions.iter().enumerate().min_by(|(_, a), (_, b)| a.error.total_cmp(&b.error))?.0;
    Some(solutions.swap_remove(best))
}
