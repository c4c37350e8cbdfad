use faer::{Col, Mat};

/// The shortest of the vectors x that make |Ax − b| least, for a matrix whose singular values up to `cut` count as zero. None
/// where the decomposition fails, as it does for numbers that are not finite.
pub(crate) fn least_norm(matrix: &Mat<f64>, right: &Col<f64>, cut: f64) -> Option<Col<f64>> {
    let svd = matrix.thin_svd().ok()?;
    let (sizes, mut parts) = (svd.S(), svd.U().transpose() * right);
    for i in 0..parts.nrows() {
        parts[i] = if sizes[i] > cut { parts[i] / sizes[i] } else { 0.0 };
    }
    Some(svd.V() * parts)
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::{col, mat};

    /// x + 2y = 5 twice, the second time with errors of opposite sign: the point of the line that is closest to the origin. A
    /// column in which there is nothing gets nothing.
    #[test]
    fn dependent_equations_have_the_shortest_solution() {
        let matrix = mat![[1.0, 2.0, 0.0], [1.0, 2.0, 1e-14], [2.0, 4.0, 0.0], [0.0, 0.0, 0.0]];
        let x = least_norm(&matrix, &col![5.5, 4.5, 10.0, 1.0], 1e-12);
        assert!(x.as_ref().is_some_and(|x| (x - col![1.0, 2.0, 0.0]).norm_max() < 1e-14), "{x:?}");
        assert!(least_norm(&mat![[f64::NAN]], &col![1.0], 0.0).is_none());
    }
}
