//! The combination of the pilot's means and the moment equations, each weighted by the inverse of its covariance.

use super::equations::{Columns, Equations};
use super::likelihood::{Fit, Likelihood};
use crate::closure::ROUNDING;
use crate::numerics::definite;
use crate::problem::Problem;
use faer::linalg::solvers::SolveLstsq;
use faer::{Mat, MatRef};

/// The factors κ on the covariance of the moment equations; κ is raised until the remaining deviation from the pilot's means is
/// chance.
const DOUBTS: [f64; 13] = [1.0, 3.0, 10.0, 30.0, 1e2, 3e2, 1e3, 3e3, 1e4, 1e5, 1e6, 1e7, 1e8];

/// The first-order change from exp(Q) to p = exp(Q)(1 + δ), δ a combination of the functions less their means.
#[derive(Clone, Debug)]
pub(super) struct Reconciled {
    /// E φ_k of p, the constant left out.
    pub(super) means: Vec<f64>,
    /// The coefficients of δ, constant first.
    pub(super) change: Vec<f64>,
    /// √E δ², and the part of it that is chance.
    pub(super) size: f64,
    pub(super) noise: f64,
}

impl Likelihood<'_> {
    /// The first-order change δ of exp(Q) = `fit` that serves both the pilot's `means`, which are known to a covariance Σ, and
    /// the moment equations E\[𝓖φ (1 + δ)\] = 0, whose integrals are known to a covariance Λ: of
    /// (Hd − m)ᵀ Σ⁻¹ (Hd − m) + (F + Ad)ᵀ Λ⁻¹ (F + Ad)/κ the least, with H = Cov φ, m what the means are off by, F = E\[r φ\]
    /// and A = E\[𝓖φ φᵀ\] (generalised least squares: A. C. Aitken, 1935, doi:10.1017/S0370164600014346).
    /// κ ≥ 1 allows for residuals that no combination of the functions removes. None where no κ leaves the pilot's means as
    /// likely as they should be.
    pub(super) fn reconciled(
        &self,
        problem: &Problem,
        fit: &Fit,
        means: &[f64],
        covariance: MatRef<'_, f64>,
    ) -> Option<Reconciled> {
        let size = means.len();
        let found = self.means(&fit.masses);
        let Equations { matrix, tested, noise, spread, .. } =
            self.equations(problem, &fit.a, &fit.masses, Columns::Generator);
        // In functions that are orthonormal under exp(Q), H = 1.
        let factor = definite(self.covariance(&fit.masses, &found))?;
        let lower = factor.L();
        let whitened = |mut matrix: Mat<f64>| -> Mat<f64> {
            lower.solve_lower_triangular_in_place(matrix.as_mut());
            let mut turned = matrix.transpose().to_owned();
            lower.solve_lower_triangular_in_place(turned.as_mut());
            turned.transpose().to_owned()
        };
        let column = |values: &dyn Fn(usize) -> f64| {
            let mut column = Mat::from_fn(size, 1, |k, _| values(k));
            lower.solve_lower_triangular_in_place(column.as_mut());
            column
        };
        let off = column(&|k| means[k] - found[k]);
        let force = column(&|k| tested[k + 1] - found[k] * tested[0]);
        // Row k is 𝓖φ_k's; the image of the mean is nothing.
        let operator =
            whitened(Mat::from_fn(size, size, |k, l| matrix[(l + 1, k + 1)] - found[l] * matrix[(0, k + 1)]));
        let centred = |sums: &Mat<f64>| {
            Mat::from_fn(size, size, |k, l| {
                sums[(k + 1, l + 1)] - found[k] * sums[(0, l + 1)] - found[l] * sums[(k + 1, 0)]
                    + found[k] * found[l] * sums[(0, 0)]
            })
        };
        let noise = whitened(centred(&noise));
        // Nodes fill the space more evenly than independent draws.
        let spread = centred(&spread);
        let variances = self.variances(&fit.masses, &found);
        let even: Vec<f64> = (0..size).map(|k| (variances[k] / spread[(k, k)]).sqrt()).collect();
        let of_means = Mat::from_fn(size, size, |k, l| covariance[(k, l)] + even[k] * even[l] * spread[(k, l)]);
        let floor = ROUNDING * operator.squared_norm_l2() / size as f64;
        let noise = Mat::from_fn(size, size, |k, l| noise[(k, l)] + if k == l { floor } else { 0.0 });
        let (pilot, equations) = (standardised(&whitened(of_means))?, standardised(&noise)?);
        let (by_pilot, off_by_pilot) = (pilot(&Mat::identity(size, size)), pilot(&off));
        let (by_equations, force) = (equations(&operator), equations(&force));
        DOUBTS.iter().find_map(|doubt| {
            let share = doubt.sqrt().recip();
            let stacked = Mat::from_fn(2 * size, size, |k, l| {
                if k < size { by_pilot[(k, l)] } else { share * by_equations[(k - size, l)] }
            });
            let right = Mat::from_fn(2 * size, 1, |k, _| match k.checked_sub(size) {
                None => off_by_pilot[(k, 0)],
                Some(k) => -share * force[(k, 0)],
            });
            let solver = stacked.qr();
            let y = solver.solve_lstsq(&right).get(..size, ..).to_owned();
            let left = &by_pilot * &y - &off_by_pilot;
            (left.squared_norm_l2() <= size as f64).then(|| {
                // (Rᵀ R)⁻¹ is the covariance of y.
                let mut inverse = Mat::<f64>::identity(size, size);
                solver.thin_R().solve_upper_triangular_in_place(inverse.as_mut());
                let (length, noise) = (y.norm_l2(), inverse.norm_l2());
                let moved = lower * &y;
                let mut d = y;
                lower.transpose().solve_upper_triangular_in_place(d.as_mut());
                let constant = -(0..size).map(|k| d[(k, 0)] * found[k]).sum::<f64>();
                Reconciled {
                    means: (0..size).map(|k| found[k] + moved[(k, 0)]).collect(),
                    change: std::iter::once(constant).chain((0..size).map(|k| d[(k, 0)])).collect(),
                    size: length,
                    noise,
                }
            })
        })
    }
}

/// The map of a vector of this covariance to one of covariance 1. None where the matrix is not positive definite.
fn standardised(covariance: &Mat<f64>) -> Option<impl Fn(&Mat<f64>) -> Mat<f64> + use<>> {
    let size = covariance.nrows();
    let scale: Vec<f64> = (0..size).map(|k| covariance[(k, k)].sqrt().recip()).collect();
    if !scale.iter().all(|scale| scale.is_finite()) {
        return None;
    }
    let factor = definite(Mat::from_fn(size, size, |k, l| scale[k] * scale[l] * covariance[(k, l)]))?;
    Some(move |matrix: &Mat<f64>| {
        let mut scaled = Mat::from_fn(size, matrix.ncols(), |k, l| scale[k] * matrix[(k, l)]);
        factor.L().solve_lower_triangular_in_place(scaled.as_mut());
        scaled
    })
}
