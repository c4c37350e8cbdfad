use crate::numerics::{divide_by_triangle, triangle, weighted_gram};
use faer::linalg::solvers::Llt;
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::{Mat, MatMut, MatRef, Par, Side};

/// A function that is a combination of those before it up to this relative size, which is rounding, is dependent on them.
const DEPENDENT: f64 = 1e-13;
/// Functions are nearly orthonormal under a measure where the pivots of Cholesky's factor of their Gram matrix differ by less
/// than this factor, as under 98 % of the measures of random systems: it is then right to 1e-7, and mostly to 1e-10.
const NEAR: f64 = 30.0;

/// Functions made orthonormal under a discrete measure, in their given order: each is a combination of those up to it.
#[derive(Clone, Debug)]
pub(in crate::closure) struct Orthonormal {
    /// ψ at the points, one row each.
    pub(in crate::closure) values: Mat<f64>,
    /// Upper triangular, φ = ψ R.
    pub(in crate::closure) triangle: Mat<f64>,
}

impl Orthonormal {
    /// Orthonormalises the columns of `values` under the weights `measure` of its first rows. `None` where they are linearly
    /// dependent, as they are at fewer nodes than functions.
    pub(in crate::closure) fn new(mut values: Mat<f64>, measure: &[f64]) -> Option<Self> {
        let triangle = independent(values.get(..measure.len(), ..), measure)?;
        divide_by_triangle(values.as_mut(), triangle.as_ref());
        Some(Orthonormal { values, triangle })
    }

    /// The coefficients of Σ c_k ψ_k in the functions φ.
    pub(in crate::closure) fn coefficients(&self, c: &[f64]) -> Vec<f64> {
        let size = c.len();
        let mut column = Mat::from_fn(size, 1, |k, _| c[k]);
        solve_upper_triangular_in_place(self.triangle.get(..size, ..size), column.as_mut(), Par::Seq);
        column.col_as_slice(0).to_vec()
    }

    /// Replaces values of some linear image of the first φ by those of the same image of the ψ.
    pub(in crate::closure) fn transform(&self, images: MatMut<'_, f64>) {
        let size = images.ncols();
        divide_by_triangle(images, self.triangle.get(..size, ..size));
    }
}

/// The upper triangle R of functions φ = ψ R with ψ orthonormal. `None` where the φ are linearly dependent.
fn independent(values: MatRef<'_, f64>, measure: &[f64]) -> Option<Mat<f64>> {
    if measure.len() < values.ncols() {
        return None;
    }
    let triangle = triangle(values, measure);
    let above = |k: usize| triangle[(k, k)] > DEPENDENT * triangle.col(k).norm_l2();
    (0..triangle.ncols()).all(above).then_some(triangle)
}

/// Cholesky's factors of the Gram matrix of functions under a measure that they are nearly orthonormal under already. `None`
/// where they are not: the factors lose more to rounding than orthogonal transformations do.
pub(in crate::closure) fn near_orthonormal(values: MatRef<'_, f64>, measure: &[f64]) -> Option<Llt<f64>> {
    let factors = weighted_gram(values, measure, &vec![0.0; values.ncols()]).llt(Side::Lower).ok()?;
    let pivots = (0..values.ncols()).map(|k| factors.L()[(k, k)]);
    let (least, most) = pivots.fold((f64::INFINITY, 0.0_f64), |(least, most), p| (least.min(p), most.max(p)));
    (most < NEAR * least).then_some(factors)
}

/// Combinations χ of functions ψ that are orthonormal under another measure, each of those up to it.
#[derive(Debug)]
pub(in crate::closure) struct Change {
    /// ψ = L χ.
    lower: Mat<f64>,
}

impl Change {
    /// The change to a measure. `None` where the functions are linearly dependent under it.
    pub(in crate::closure) fn new(values: MatRef<'_, f64>, measure: &[f64]) -> Option<Self> {
        let lower = match near_orthonormal(values, measure) {
            Some(factors) => factors.L().to_owned(),
            None => independent(values, measure)?.transpose().to_owned(),
        };
        Some(Change { lower })
    }

    /// Replaces products with the ψ, one row each, by those with the χ.
    pub(in crate::closure) fn transform(&self, products: MatMut<'_, f64>) {
        solve_lower_triangular_in_place(self.lower.as_ref(), products, Par::Seq);
    }

    /// The coefficients of Σ d_k χ_k in the functions ψ.
    pub(in crate::closure) fn coefficients(&self, d: &[f64]) -> Vec<f64> {
        let size = d.len();
        let mut column = Mat::from_fn(size, 1, |k, _| d[k]);
        solve_upper_triangular_in_place(self.lower.get(..size, ..size).transpose(), column.as_mut(), Par::Seq);
        column.col_as_slice(0).to_vec()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop")]
    use super::*;
    use crate::numerics::weighted_product;

    /// Powers made orthonormal under the uniform measure, then under narrower ones, of which the last is too far for Cholesky's
    /// factor. What is left is rounding times the condition of the factor, squared, or of the triangle.
    #[test]
    fn functions_stay_orthonormal_under_other_measures() {
        let (points, count) = (400, 9);
        let t = |i: usize| (2 * i + 1) as f64 / points as f64 - 1.0;
        let measure =
            |narrow: f64| -> Vec<f64> { (0..points).map(|i| (-narrow * t(i) * t(i)).exp() / 200.0).collect() };
        let powers = Mat::from_fn(points, count, |i, k| t(i).powi(k as i32));
        let psi = Orthonormal::new(powers.clone(), &measure(0.0)).unwrap();
        let c: Vec<f64> = (0..count).map(|k| (k as f64).cos()).collect();
        let sum = |values: &Mat<f64>, c: &[f64], i: usize| (0..count).map(|k| c[k] * values[(i, k)]).sum::<f64>();
        for (narrow, near, rounding) in [(0.0, true, 1e-14), (2.0, true, 1e-14), (30.0, false, 2e-12)] {
            let measure = measure(narrow);
            assert_eq!(near_orthonormal(psi.values.as_ref(), &measure).is_some(), near, "{narrow}");
            let change = Change::new(psi.values.as_ref(), &measure).unwrap();
            let mut transposed = psi.values.transpose().to_owned();
            change.transform(transposed.as_mut());
            let chi = transposed.transpose().to_owned();
            let gram = weighted_product(chi.as_ref(), chi.as_ref(), &measure);
            let off = (&gram - Mat::<f64>::identity(count, count)).norm_max();
            assert!(off < rounding, "{narrow}: {off:e}");
            let (in_psi, i) = (change.coefficients(&c), 123);
            let in_powers = psi.coefficients(&in_psi);
            let [direct, by_psi, by_powers] =
                [sum(&chi, &c, i), sum(&psi.values, &in_psi, i), sum(&powers, &in_powers, i)];
            assert!((direct - by_psi).abs() < rounding * direct.abs(), "{narrow}: {direct} and {by_psi}");
            assert!((direct - by_powers).abs() < rounding * direct.abs(), "{narrow}: {direct} and {by_powers}");
        }
        // Two functions that are the same, under either measure.
        let twice = Mat::from_fn(points, 2, |i, _| t(i));
        assert!(
            Orthonormal::new(twice.clone(), &measure(0.0)).is_none()
                && Change::new(twice.as_ref(), &measure(2.0)).is_none()
        );
    }
}
