//! Derivatives by differences, which tests compare with exact ones.

/// The gradient and the Hessian, by rows, of each of some functions of the state, by differences of fourth order in steps `h`: along each
/// axis, and along the diagonals of each two.
pub(crate) fn differences(at: impl Fn(&[f64]) -> Vec<f64>, x: &[f64], h: f64) -> Vec<(Vec<f64>, Vec<f64>)> {
    let (n, here) = (x.len(), at(x));
    // The first and the second derivative of each function along a vector.
    let along = |axes: &[usize]| -> Vec<[f64; 2]> {
        let [far_below, below, above, far_above] = [-2.0, -1.0, 1.0, 2.0].map(|steps| {
            let mut moved = x.to_vec();
            axes.iter().for_each(|i| moved[*i] += steps * h);
            at(&moved)
        });
        let of = |k: usize| {
            let (near, far) = ([above[k], below[k]], [far_above[k], far_below[k]]);
            let slope = (8.0 * (near[0] - near[1]) - (far[0] - far[1])) / (12.0 * h);
            let bend = (16.0 * (near[0] + near[1]) - (far[0] + far[1]) - 30.0 * here[k]) / (12.0 * h * h);
            [slope, bend]
        };
        (0..here.len()).map(of).collect()
    };
    let axes: Vec<Vec<[f64; 2]>> = (0..n).map(|i| along(&[i])).collect();
    let diagonals: Vec<Vec<[f64; 2]>> = (0..n * n).map(|ij| along(&[ij / n, ij % n])).collect();
    let of = |k: usize| {
        let mixed = |i: usize, j: usize| (diagonals[i * n + j][k][1] - axes[i][k][1] - axes[j][k][1]) / 2.0;
        let bend = |ij: usize| if ij / n == ij % n { axes[ij / n][k][1] } else { mixed(ij / n, ij % n) };
        ((0..n).map(|i| axes[i][k][0]).collect(), (0..n * n).map(bend).collect())
    };
    (0..here.len()).map(of).collect()
}
