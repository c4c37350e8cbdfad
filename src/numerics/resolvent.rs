use nalgebra::{Complex, DMatrix, DVector, Hessenberg};

/// Re c·(iω − A)⁻¹ b for any number of ω, by one reduction to a matrix that has nothing below its first subdiagonal.
#[derive(Debug)]
pub(crate) struct Resolvent {
    hessenberg: DMatrix<f64>,
    left: DVector<f64>,
    right: DVector<f64>,
}

impl Resolvent {
    pub(crate) fn new(matrix: DMatrix<f64>, left: &DVector<f64>, right: &DVector<f64>) -> Self {
        let (q, hessenberg) = Hessenberg::new(matrix).unpack();
        Resolvent { hessenberg, left: q.tr_mul(left), right: q.tr_mul(right) }
    }

    /// At one ω, by elimination with the larger of two neighbouring rows as pivot.
    pub(crate) fn at(&self, omega: f64) -> f64 {
        let n = self.left.len();
        // Columns are rows here, which elimination goes through.
        let mut rows =
            DMatrix::from_fn(n, n, |l, k| Complex::new(-self.hessenberg[(k, l)], if k == l { omega } else { 0.0 }));
        let mut right: Vec<Complex<f64>> = self.right.iter().map(|&b| Complex::from(b)).collect();
        for k in 0..n.saturating_sub(1) {
            if rows[(k, k + 1)].norm_sqr() > rows[(k, k)].norm_sqr() {
                (k..n).for_each(|l| rows.swap((l, k), (l, k + 1)));
                right.swap(k, k + 1);
            }
            let factor = rows[(k, k + 1)] / rows[(k, k)];
            if factor != Complex::ZERO {
                for l in k + 1..n {
                    let above = rows[(l, k)];
                    rows[(l, k + 1)] -= factor * above;
                }
                let above = right[k];
                right[k + 1] -= factor * above;
            }
        }
        for k in (0..n).rev() {
            let known: Complex<f64> = (k + 1..n).map(|l| rows[(l, k)] * right[l]).sum();
            right[k] = (right[k] - known) / rows[(k, k)];
        }
        right.iter().zip(&self.left).map(|(y, c)| y.re * c).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{dmatrix, dvector};

    /// x″ + c x′ + k x under a force: the real part of the velocity's response, and against a plain solution of full size.
    #[test]
    fn responses_are_those_of_the_definition() {
        let oscillator = Resolvent::new(dmatrix![0.0, 1.0; -2.0, -0.3], &dvector![0.0, 1.0], &dvector![0.0, 1.0]);
        for omega in [0.0, 0.9, 2.0_f64.sqrt(), 7.0] {
            let response = Complex::new(0.0, omega) / Complex::new(2.0 - omega * omega, 0.3 * omega);
            assert!((oscillator.at(omega) - response.re).abs() < 1e-13);
        }
        let n = 9;
        let matrix =
            DMatrix::from_fn(n, n, |i, j| ((3 * i + 5 * j + i * j) as f64).sin() - if i == j { 3.0 } else { 0.0 });
        let [left, right] = [1.0, 2.0].map(|s| DVector::from_fn(n, |i, _| (s * i as f64).cos()));
        let found = Resolvent::new(matrix.clone(), &left, &right);
        for omega in [0.0, 0.4, 3.0] {
            let whole = DMatrix::from_fn(n, n, |i, j| Complex::new(-matrix[(i, j)], if i == j { omega } else { 0.0 }));
            let solved = whole.lu().solve(&right.map(Complex::from)).unwrap_or_default();
            let plain: f64 = solved.iter().zip(&left).map(|(y, c)| y.re * c).sum();
            assert!((found.at(omega) - plain).abs() < 1e-12, "{omega}: {} and {plain}", found.at(omega));
        }
    }
}
