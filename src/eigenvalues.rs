//! Eigenvalues of small dense matrices.

use nalgebra::{Complex, DMatrix};

/// The eigenvalues of a real matrix; none are found where an entry is not finite.
///
/// The library calls it for systems of any type, and it is compiled once for all.
pub(crate) fn eigenvalues(matrix: DMatrix<f64>) -> Vec<Complex<f64>> {
    // The search for the eigenvalues of numbers that are not finite would never end.
    if !matrix.iter().all(|entry| entry.is_finite()) {
        return Vec::new();
    }
    matrix.complex_eigenvalues().iter().copied().collect()
}
