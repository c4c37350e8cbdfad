use faer::Mat;
use nalgebra::{Complex, DMatrix, Schur};

/// The most steps of the search for each eigenvalue, which takes two or three. It may turn in a circle for a singular matrix.
const STEPS: usize = 100;

/// The eigenvalues of a square matrix; none where an entry is not finite, since the search for them would then never end.
pub(crate) fn eigenvalues(matrix: DMatrix<f64>) -> Option<Vec<Complex<f64>>> {
    if !matrix.iter().all(|entry| entry.is_finite()) {
        return None;
    }
    let n = matrix.nrows();
    match Schur::try_new(matrix.clone(), f64::EPSILON, STEPS * n.max(1)) {
        Some(schur) => Some(schur.complex_eigenvalues().iter().copied().collect()),
        None => Mat::from_fn(n, n, |i, j| matrix[(i, j)]).eigenvalues().ok(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;

    #[test]
    fn a_rotation_has_imaginary_eigenvalues_and_no_number_has_none() {
        let found = eigenvalues(dmatrix![0.0, 2.0; -2.0, 0.0]).unwrap_or_default();
        assert!(found.len() == 2 && found.iter().all(|l| l.re.abs() < 1e-15 && (l.im.abs() - 2.0).abs() < 1e-15));
        // A body on a spring behind hysteresis, at rest: 0 and a pair.
        let found = eigenvalues(dmatrix![0.0, 1.0, 0.0; -0.5, -0.02, -0.5; 0.0, 1.0, 0.0]).unwrap_or_default();
        let sum = found.iter().sum::<Complex<f64>>();
        assert!(found.len() == 3 && (sum.re + 0.02).abs() < 1e-14 && sum.im.abs() < 1e-14, "{found:?}");
        for odd in [f64::NAN, f64::INFINITY] {
            assert!(eigenvalues(dmatrix![1.0, odd; 0.0, 1.0]).is_none());
        }
    }
}
