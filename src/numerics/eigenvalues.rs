use nalgebra::{Complex, DMatrix};

/// The eigenvalues of a square matrix; none where an entry is not finite, since the search for them would then never end.
pub(crate) fn eigenvalues(matrix: DMatrix<f64>) -> Option<Vec<Complex<f64>>> {
    let finite = matrix.iter().all(|entry| entry.is_finite());
    finite.then(|| matrix.complex_eigenvalues().iter().copied().collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;

    #[test]
    fn a_rotation_has_imaginary_eigenvalues_and_no_number_has_none() {
        let found = eigenvalues(dmatrix![0.0, 2.0; -2.0, 0.0]).unwrap_or_default();
        assert!(found.len() == 2 && found.iter().all(|l| l.re.abs() < 1e-15 && (l.im.abs() - 2.0).abs() < 1e-15));
        for odd in [f64::NAN, f64::INFINITY] {
            assert!(eigenvalues(dmatrix![1.0, odd; 0.0, 1.0]).is_none());
        }
    }
}
