//! The method of generalised minimal residuals (Y. Saad and M. H. Schultz, 1986, doi:10.1137/0907058).

/// The most vectors of the Krylov space; then it begins anew from what has been found.
const VECTORS: usize = 120;
/// The most beginnings.
const BEGINNINGS: usize = 4;

/// The x with |A x − b| ≤ `tolerance` |b|, by a preconditioner M on the right: `applied` makes M r and A M r of r. None where that is not
/// reached.
pub(super) fn solved(right: &[f64], tolerance: f64, applied: impl Fn(&[f64]) -> [Vec<f64>; 2]) -> Option<Vec<f64>> {
    let aim = tolerance * norm(right);
    let (mut x, mut residual) = (vec![0.0; right.len()], right.to_vec());
    for _ in 0..BEGINNINGS {
        if norm(&residual) <= aim {
            return Some(x);
        }
        let combination = smallest(&residual, aim, &applied)?;
        let [change, image] = applied(&combination);
        x.iter_mut().zip(change).for_each(|(x, c)| *x += c);
        residual.iter_mut().zip(image).for_each(|(r, i)| *r -= i);
    }
    (norm(&residual) <= aim).then_some(x)
}

/// The vector r of the Krylov space with the smallest |A M r − b|, or the first below `aim`; none if it is no number.
fn smallest(right: &[f64], aim: f64, applied: &impl Fn(&[f64]) -> [Vec<f64>; 2]) -> Option<Vec<f64>> {
    let size = norm(right);
    let mut basis = vec![scaled(right, size.recip())];
    // The triangle that rotations make of the projected matrix, by columns, and the projected right side.
    let (mut triangle, mut rotations, mut target) = (Vec::<Vec<f64>>::new(), Vec::<[f64; 2]>::new(), vec![size]);
    for k in 0..VECTORS {
        let [_, mut next] = applied(&basis[k]);
        let mut column = Vec::with_capacity(k + 2);
        for q in &basis {
            let part = dot(q, &next);
            next.iter_mut().zip(q).for_each(|(n, q)| *n -= part * q);
            column.push(part);
        }
        let rest = norm(&next);
        for (row, [c, s]) in rotations.iter().enumerate() {
            let [a, b] = [column[row], column[row + 1]];
            (column[row], column[row + 1]) = (c * a + s * b, c * b - s * a);
        }
        let last = column[k].hypot(rest);
        if !(last.is_finite() && last > 0.0) {
            return None;
        }
        let [c, s] = [column[k] / last, rest / last];
        column[k] = last;
        rotations.push([c, s]);
        triangle.push(column);
        let left = target[k];
        target[k] = c * left;
        target.push(-s * left);
        if target[k + 1].abs() <= aim || k + 1 == VECTORS {
            break;
        }
        basis.push(scaled(&next, rest.recip()));
    }
    let count = triangle.len();
    let mut factors = target[..count].to_vec();
    for k in (0..count).rev() {
        factors[k] /= triangle[k][k];
        let factor = factors[k];
        (0..k).for_each(|row| factors[row] -= factor * triangle[k][row]);
    }
    let mut sum = vec![0.0; right.len()];
    for (factor, q) in factors.iter().zip(&basis) {
        sum.iter_mut().zip(q).for_each(|(sum, q)| *sum += factor * q);
    }
    Some(sum)
}

fn scaled(x: &[f64], factor: f64) -> Vec<f64> {
    x.iter().map(|x| factor * x).collect()
}

fn norm(x: &[f64]) -> f64 {
    dot(x, x).sqrt()
}

/// By eight sums, which no number of threads changes.
fn dot(x: &[f64], y: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (a, b) = (x.chunks_exact(8), y.chunks_exact(8));
    let rest: f64 = a.remainder().iter().zip(b.remainder()).map(|(x, y)| x * y).sum();
    for (a, b) in a.zip(b) {
        (0..8).for_each(|k| sums[k] += a[k] * b[k]);
    }
    sums.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A matrix that is no symmetric one, with its diagonal as preconditioner: to rounding within as many steps as unknowns.
    #[test]
    fn systems_are_solved_to_their_tolerance() {
        let size = 40;
        let entry = |i: usize, j: usize| match i as i64 - j as i64 {
            0 => 2.0 + i as f64,
            1 => -1.0,
            -1 => 0.5,
            _ => 0.0,
        };
        let product =
            |x: &[f64]| -> Vec<f64> { (0..size).map(|i| (0..size).map(|j| entry(i, j) * x[j]).sum()).collect() };
        let truth: Vec<f64> = (0..size).map(|i| (i as f64 * 0.7).sin()).collect();
        let applied = |r: &[f64]| {
            let change: Vec<f64> = r.iter().enumerate().map(|(i, r)| r / entry(i, i)).collect();
            let image = product(&change);
            [change, image]
        };
        let right = product(&truth);
        for tolerance in [1e-4, 1e-8, 1e-13] {
            let found = solved(&right, tolerance, applied).unwrap();
            let off: Vec<f64> = product(&found).iter().zip(&right).map(|(a, b)| a - b).collect();
            assert!(norm(&off) <= tolerance * norm(&right));
        }
        assert!(solved(&right, 1e-8, |r| [r.to_vec(), vec![f64::NAN; size]]).is_none());
    }
}
