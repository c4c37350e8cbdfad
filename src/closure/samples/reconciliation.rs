//! The combination of the pilot's means and the moment equations, each weighted by the inverse of its covariance.

use super::equations::Equations;
use super::likelihood::{Fit, Likelihood};
use crate::closure::ROUNDING;
use crate::numerics::definite;
use crate::problem::Problem;
use faer::linalg::solvers::{Llt, SolveLstsq};
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
        let terms = WhitenedTerms::new(self, problem, fit, (means, covariance))?;
        DOUBTS.iter().find_map(|doubt| terms.weighed(*doubt))
    }
}

/// The two terms in functions that are orthonormal under exp(Q), where H = 1, each with its values of covariance 1.
struct WhitenedTerms {
    /// E φ_k, and the factor of Cov φ.
    found: Vec<f64>,
    factor: Llt<f64>,
    /// The identity and Hd − m.
    pilot: [Mat<f64>; 2],
    /// A and F.
    equations: [Mat<f64>; 2],
}

impl WhitenedTerms {
    /// None where a covariance is not positive definite.
    fn new(
        likelihood: &Likelihood<'_>,
        problem: &Problem,
        fit: &Fit,
        (means, covariance): (&[f64], MatRef<'_, f64>),
    ) -> Option<Self> {
        let size = means.len();
        let found = likelihood.means(&fit.masses);
        let Equations { matrix, tested, noise, spread, .. } = likelihood.equations(problem, &fit.a, &fit.masses, true);
        let factor = definite(likelihood.covariance(&fit.masses, &found))?;
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
        let noise = whitened(centred(&noise, &found));
        // Nodes fill the space more evenly than independent draws.
        let spread = centred(&spread, &found);
        let variances = likelihood.variances(&fit.masses, &found);
        let even: Vec<f64> = (0..size).map(|k| (variances[k] / spread[(k, k)]).sqrt()).collect();
        let of_means = Mat::from_fn(size, size, |k, l| covariance[(k, l)] + even[k] * even[l] * spread[(k, l)]);
        let floor = ROUNDING * operator.squared_norm_l2() / size as f64;
        let noise = Mat::from_fn(size, size, |k, l| noise[(k, l)] + if k == l { floor } else { 0.0 });
        let (by_pilot, by_equations) = (standardised(&whitened(of_means))?, standardised(&noise)?);
        let pilot = [by_pilot(&Mat::identity(size, size)), by_pilot(&off)];
        Some(WhitenedTerms { pilot, equations: [by_equations(&operator), by_equations(&force)], found, factor })
    }

    /// The change for one κ. None where it leaves the pilot's means less likely than they should be.
    fn weighed(&self, doubt: f64) -> Option<Reconciled> {
        let (size, share) = (self.found.len(), doubt.sqrt().recip());
        let ([by_pilot, off], [by_equations, force]) = (&self.pilot, &self.equations);
        let stacked =
            Mat::from_fn(
                2 * size,
                size,
                |k, l| {
                    if k < size { by_pilot[(k, l)] } else { share * by_equations[(k - size, l)] }
                },
            );
        let right = Mat::from_fn(2 * size, 1, |k, _| match k.checked_sub(size) {
            None => off[(k, 0)],
            Some(k) => -share * force[(k, 0)],
        });
        let solver = stacked.qr();
        let y = solver.solve_lstsq(&right).get(..size, ..).to_owned();
        let left = by_pilot * &y - off;
        if left.squared_norm_l2() > size as f64 || left.squared_norm_l2().is_nan() {
            return None;
        }
        // (Rᵀ R)⁻¹ is the covariance of y.
        let mut inverse = Mat::<f64>::identity(size, size);
        solver.thin_R().solve_upper_triangular_in_place(inverse.as_mut());
        let (length, noise) = (y.norm_l2(), inverse.norm_l2());
        let lower = self.factor.L();
        let moved = lower * &y;
        let mut d = y;
        lower.transpose().solve_upper_triangular_in_place(d.as_mut());
        let constant = -(0..size).map(|k| d[(k, 0)] * self.found[k]).sum::<f64>();
        Some(Reconciled {
            means: (0..size).map(|k| self.found[k] + moved[(k, 0)]).collect(),
            change: std::iter::once(constant).chain((0..size).map(|k| d[(k, 0)])).collect(),
            size: length,
            noise,
        })
    }
}

/// Sums of products of functions, the constant first, for the functions less their means.
fn centred(sums: &Mat<f64>, found: &[f64]) -> Mat<f64> {
    Mat::from_fn(found.len(), found.len(), |k, l| {
        sums[(k + 1, l + 1)] - found[k] * sums[(0, l + 1)] - found[l] * sums[(k + 1, 0)]
            + found[k] * found[l] * sums[(0, 0)]
    })
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
