//! The distance of a density from satisfying the Fokker-Planck equation.

use super::Retained;
use crate::closure::density::exponent::Exponent;
use crate::closure::discretisation::Discretisation;
use crate::closure::projection::tempered;
use crate::closure::space::orthonormal::Change;
use crate::numerics::weighted_sum;
use crate::record::number;
use faer::{Mat, MatRef};
use serde::{Deserialize, Serialize};

/// How large the residual of a density is.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Indication {
    /// η.
    #[serde(with = "number")]
    pub(in crate::closure) indicator: f64,
    /// ‖F‖ over the functions that Q itself is made of.
    #[serde(with = "number")]
    pub(in crate::closure) residual: f64,
}

/// The test functions and the nodes that a density is probed with.
pub(in crate::closure) struct Probe<'a> {
    pub(in crate::closure) kept: &'a Retained,
    /// The test functions at the kept nodes, each a combination of those up to it: the constant, those of Q, others.
    pub(in crate::closure) values: MatRef<'a, f64>,
    /// Their rates under the generator.
    pub(in crate::closure) rates: MatRef<'a, f64>,
    /// The values where trajectories leave a wall.
    pub(in crate::closure) at_walls: MatRef<'a, f64>,
    /// How many columns are the constant's and Q's.
    pub(in crate::closure) own: usize,
    /// n.
    pub(in crate::closure) order: u32,
}

/// The indicator η = ‖∫ r ψ_k p̃ dx‖/√(1 + n) of a density, with test functions ψ_k of a higher degree than its own,
/// orthonormal under it, and the norm ‖F‖ of those of Q alone. Where there are walls, the flux that fails to return from them
/// is part of the residual.
pub(in crate::closure) fn indicate(
    discretisation: &Discretisation,
    exponent: &Exponent,
    probe: &Probe<'_>,
) -> Option<Indication> {
    let Probe { kept, values, rates, at_walls, own, order } = *probe;
    let measure = tempered(&exponent.values(&kept.points), &kept.weights, 1.0);
    let tested = if discretisation.impulses.is_empty() {
        let residuals = exponent.residuals(&kept.points, |i| &discretisation.locals[kept.nodes[i]]);
        let weighted: Vec<f64> = measure.iter().zip(&residuals).map(|(w, r)| w * r).collect();
        weighted_sum(values, &weighted)
    } else {
        // The same integrals, ∫ p̃ Gψ_k dx, but for what leaves through the edge.
        weighted_sum(rates, &measure)
    };
    let mut f = Mat::zeros(values.ncols(), 1);
    f.col_as_slice_mut(0).copy_from_slice(&tested);
    if !discretisation.passages.is_empty() {
        // The flux out of the wall at the speed after the impact less the flux into it before.
        let missing = Mat::from_fn(discretisation.passages.len(), 1, |i, _| {
            let passage = &discretisation.passages[i];
            if !kept.domain.contains(&passage.before) || !kept.domain.contains(&passage.after) {
                return 0.0;
            }
            let density = |x: &[f64]| exponent.value(x).exp();
            passage.weight * (passage.contraction * density(&passage.after) - density(&passage.before))
        });
        f -= at_walls.transpose() * missing;
    }
    Indication::of((values, &measure), f, (own, order))
}

impl Indication {
    /// By the integrals of the residual with test functions, given at nodes with the density's masses there; `own` of them, the
    /// constant among them, are Q's of this order.
    pub(in crate::closure) fn of(
        (values, measure): (MatRef<'_, f64>, &[f64]),
        mut tested: Mat<f64>,
        (own, order): (usize, u32),
    ) -> Option<Self> {
        Change::new(values, measure)?.transform(tested.as_mut());
        let norm = |from: usize, to: usize| (from..to).map(|k| tested[(k, 0)].powi(2)).sum::<f64>();
        let residual = norm(1, own).sqrt();
        let scale = f64::from(order + 1);
        let indicator = ((norm(1, own) + norm(own, values.ncols())) / scale).sqrt();
        Some(Indication { indicator, residual })
    }
}
