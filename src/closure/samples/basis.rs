use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::prelude::*;
use faer::{Mat, Side};

/// Functions ψ orthonormal under the pilot's states, by their Gram matrix alone: φ = ψ R, the constant first.
///
/// A Gram matrix squares the condition number that a QR factorisation of the table would have; but it needs no table, and
/// products of Legendre polynomials are far from dependent.
#[derive(Clone, Debug)]
pub(super) struct Basis {
    /// R.
    triangle: Mat<f64>,
}

impl Basis {
    /// `None` where the functions are linearly dependent at the states.
    pub(super) fn new(gram: &Mat<f64>) -> Option<Self> {
        let lower = gram.llt(Side::Lower).ok()?;
        Some(Basis { triangle: lower.L().transpose().to_owned() })
    }

    /// The means E[r ψ_k] from E[r φ_k], the constant left out.
    pub(super) fn tested(&self, means: &[f64]) -> Mat<f64> {
        let mut column = Mat::from_fn(means.len(), 1, |k, _| means[k]);
        solve_lower_triangular_in_place(self.triangle.transpose(), column.as_mut(), Par::Seq);
        column.get(1.., ..).to_owned()
    }

    /// The matrix of a bilinear form of the ψ from that of the φ, the constant left out.
    pub(super) fn form(&self, matrix: &Mat<f64>) -> Mat<f64> {
        // R⁻ᵀ X R⁻¹, the second factor applied to the transpose.
        let mut left = matrix.clone();
        solve_lower_triangular_in_place(self.triangle.transpose(), left.as_mut(), Par::Seq);
        let mut right = left.transpose().to_owned();
        solve_lower_triangular_in_place(self.triangle.transpose(), right.as_mut(), Par::Seq);
        right.get(1.., 1..).transpose().to_owned()
    }

    /// The coefficients, constant first, of Σ d_k ψ_k in the functions φ. Short lists mean the first functions.
    pub(super) fn coefficients(&self, d: &[f64]) -> Vec<f64> {
        let given = |k: usize| k.checked_sub(1).and_then(|k| d.get(k)).copied().unwrap_or(0.0);
        let mut column = Mat::from_fn(self.triangle.nrows(), 1, |k, _| given(k));
        solve_upper_triangular_in_place(self.triangle.as_ref(), column.as_mut(), Par::Seq);
        (0..column.nrows()).map(|k| column[(k, 0)]).collect()
    }

    /// Σ a_k φ_k as d in the functions ψ, the constant left out.
    pub(super) fn orthogonal(&self, a: &[f64]) -> Vec<f64> {
        let d = &self.triangle * Mat::from_fn(a.len(), 1, |k, _| a[k]);
        (1..a.len()).map(|k| d[(k, 0)]).collect()
    }
}
