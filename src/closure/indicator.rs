//! How far a density is from satisfying the Fokker-Planck equation.

use super::exponent::{Exponent, Residual};
use super::orthonormal::Orthonormal;
use super::projection::tempered;
use super::setting::Setting;
use super::trust_domain::TrustDomain;
use faer::{Mat, MatRef};

/// What the residual says of a density.
#[derive(Clone, Copy, Debug)]
pub(super) struct Indication {
    /// η.
    pub(super) indicator: f64,
    /// ‖F‖ over the functions that Q itself is made of.
    pub(super) residual: f64,
}

/// Where a density is probed, and with what.
pub(super) struct Probe<'a, const N: usize> {
    pub(super) domain: &'a TrustDomain<N>,
    pub(super) points: &'a [[f64; N]],
    pub(super) weights: &'a [f64],
    /// The test functions at the points, the constant first, then those of Q.
    pub(super) values: MatRef<'a, f64>,
    /// The same where trajectories leave a wall.
    pub(super) at_walls: MatRef<'a, f64>,
    /// How many columns are the constant's and Q's.
    pub(super) own: usize,
    /// n.
    pub(super) order: u32,
}

/// The indicator η = ‖∫ r ψ_k p̃ dx‖/√(1 + n) of a density, with test functions ψ_k of a higher degree than its own,
/// orthonormal under it, and the norm ‖F‖ of those of Q alone. Where there are walls, what fails to return from them is
/// part of the residual.
pub(super) fn indicate<const N: usize>(
    setting: &Setting<N>,
    exponent: &Exponent<N>,
    probe: &Probe<'_, N>,
) -> Option<Indication> {
    let Probe { domain, points, weights, values, at_walls, own, order } = *probe;
    let log: Vec<f64> = points.iter().map(|x| exponent.value(x)).collect();
    let measure = tempered(&log, weights, 1.0);
    let basis = Orthonormal::new(values, &measure)?;
    let residual = Residual::new(&setting.operator);
    let rows = points.len();
    let tested = Mat::from_fn(rows, 1, |i, _| measure[i].sqrt() * residual.at(&points[i], &exponent.jet(&points[i])));
    let mut f = basis.weighted.transpose() * tested;
    if !setting.passages.is_empty() {
        // What comes back at the speed after the impact, against what leaves the wall there.
        let missing = Mat::from_fn(setting.passages.len(), 1, |i, _| {
            let passage = &setting.passages[i];
            if !domain.contains(&passage.before) || !domain.contains(&passage.after) {
                return 0.0;
            }
            let density = |x| exponent.value(x).exp();
            passage.weight * (passage.contraction * density(&passage.after) - density(&passage.before))
        });
        f -= basis.transformed(at_walls).transpose() * missing;
    }
    let columns = values.ncols();
    let norm = |from: usize, to: usize| (from..to).map(|k| f[(k, 0)].powi(2)).sum::<f64>();
    let residual = norm(1, own).sqrt();
    let scale = f64::from(order + 1);
    let indicator = ((norm(1, own) + norm(own, columns)) / scale).sqrt();
    Some(Indication { indicator, residual })
}
