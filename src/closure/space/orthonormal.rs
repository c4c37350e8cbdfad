use crate::closure::tuning;
use faer::prelude::*;
use faer::{Mat, MatRef};

/// Functions made orthonormal under a discrete measure, in their given order: each is a combination of those up to it.
#[derive(Debug)]
pub(in crate::closure) struct Orthonormal {
    /// √ω ψ at the nodes.
    pub(in crate::closure) weighted: Mat<f64>,
    /// Upper triangular, φ = ψ R.
    triangle: Mat<f64>,
}

impl Orthonormal {
    /// Orthonormalises the columns of `values` under the weights `measure` of its rows. `None` where they are linearly
    /// dependent, as they are at fewer nodes than functions.
    pub(in crate::closure) fn new(values: MatRef<'_, f64>, measure: &[f64]) -> Option<Self> {
        if values.nrows() < values.ncols() {
            return None;
        }
        let roots: Vec<f64> = measure.iter().map(|w| w.sqrt()).collect();
        let scaled = Mat::from_fn(values.nrows(), values.ncols(), |i, k| roots[i] * values[(i, k)]);
        let qr = scaled.qr();
        let triangle = qr.thin_R().to_owned();
        for k in 0..triangle.ncols() {
            let column = scaled.col(k).norm_l2();
            let own = triangle[(k, k)].abs();
            if own.is_nan() || own <= tuning::space::DEPENDENT * column {
                return None;
            }
        }
        Some(Orthonormal { weighted: qr.compute_thin_Q(), triangle })
    }

    /// The coefficients of Σ d_k ψ_k in the functions φ.
    pub(in crate::closure) fn coefficients(&self, d: &[f64]) -> Vec<f64> {
        let mut column = Mat::from_fn(d.len(), 1, |k, _| d[k]);
        let size = d.len();
        faer::linalg::triangular_solve::solve_upper_triangular_in_place(
            self.triangle.get(..size, ..size),
            column.as_mut(),
            Par::Seq,
        );
        (0..size).map(|k| column[(k, 0)]).collect()
    }

    /// The columns of `other`, values of some linear image of the φ, as the same image of the ψ.
    pub(in crate::closure) fn transformed(&self, other: MatRef<'_, f64>) -> Mat<f64> {
        // X R = other, solved as Rᵀ Xᵀ = otherᵀ.
        let mut transposed = other.transpose().to_owned();
        faer::linalg::triangular_solve::solve_lower_triangular_in_place(
            self.triangle.transpose(),
            transposed.as_mut(),
            faer::get_global_parallelism(),
        );
        transposed.transpose().to_owned()
    }
}
