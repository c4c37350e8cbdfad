//! The moment equations as a linear system for the ratio of the density to a reference weight.

use crate::closure::discretisation::nodes::Table;
use crate::closure::space::nested_spaces::Truncation;
use crate::closure::space::orthonormal::Orthonormal;
use faer::prelude::*;
use faer::{Mat, MatRef};

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
    /// Its coefficients, the constant's first.
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
/// `measure` holds ω times the quadrature weights, with sum 1, at the rows of `table`; the rows beyond its length are
/// impacts, the equations' other terms, and `passages` holds their weights. `None` where the functions are linearly dependent
/// under ω or the system is singular.
pub(in crate::closure) fn resolve(
    table: &Table,
    measure: &[f64],
    passages: &[f64],
    residual: Option<&[f64]>,
    truncation: Truncation,
) -> Option<Resolved> {
    let interior = measure.len();
    let columns = table.values.ncols();
    let basis = Orthonormal::new(table.values.get(..interior, ..), measure)?;
    let roots: Vec<f64> = measure.iter().map(|w| w.sqrt()).collect();
    let weighted = Mat::from_fn(interior, columns, |i, k| roots[i] * table.rates[(i, k)]);
    let rates = basis.transformed(weighted.as_ref());
    let mut matrix = rates.transpose() * &basis.weighted;
    if !passages.is_empty() {
        let at_wall = |m: MatRef<'_, f64>, weights: &[f64]| {
            Mat::from_fn(passages.len(), columns, |i, k| weights[i] * m[(interior + i, k)])
        };
        let values = basis.transformed(at_wall(table.values.as_ref(), passages).as_ref());
        let jumps = basis.transformed(table.rates.get(interior.., ..));
        matrix += jumps.transpose() * values;
    }
    // The first ψ is the constant ±1.
    let sign = basis.weighted[(0, 0)].signum();
    let by_weight = Mat::from_fn(columns - 1, 1, |k, _| -sign * matrix[(k + 1, 0)]);
    let by_residual = residual.map(|r| {
        let column = Mat::from_fn(interior, 1, |i, _| roots[i] * r[i]);
        let tested = basis.weighted.transpose() * column;
        Mat::from_fn(columns - 1, 1, |k, _| -tested[(k + 1, 0)])
    });
    let factors = matrix.get(1.., 1..).partial_piv_lu();
    let at_nodes = |c: &[f64]| -> Vec<f64> {
        let c = Mat::from_fn(c.len(), 1, |k, _| c[k]);
        let values = table.values.get(..interior, ..c.nrows()) * c;
        (0..interior).map(|i| values[(i, 0)]).collect()
    };
    let solutions = std::iter::once(by_weight).chain(by_residual).filter_map(|right| {
        let solved = factors.solve(right);
        let kept = truncation.end - 1;
        let d: Vec<f64> = std::iter::once(0.0).chain((0..kept).map(|k| solved[(k, 0)])).collect();
        let highest: Vec<f64> =
            d.iter().enumerate().map(|(k, d)| if k < truncation.lower { 0.0 } else { *d }).collect();
        let rough: f64 = measure.iter().zip(at_nodes(&basis.coefficients(&highest))).map(|(w, d)| w * d.abs()).sum();
        let coefficients = basis.coefficients(&d);
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
