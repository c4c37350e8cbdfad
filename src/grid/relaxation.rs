//! The slowest relaxation rates: the spectrum next to zero.

use super::factors::Regular;
use super::operator::Operator;
use crate::error::Result;
use crate::numerics::{eigenvalues, sort_by_number};
use crate::transient::Relaxation;
use nalgebra::{Complex, DMatrix, DVector};

/// The most vectors of the Krylov space for relaxation rates. Each costs one solve with the factors; a few dozen eigenvalues
/// next to the shift are then known to rounding.
const KRYLOV: usize = 80;
/// The eigenvalues nearest to zero are compared with earlier ones each time the Krylov space has so many more vectors.
const CHECKED: usize = 10;
/// An eigenvalue μ has converged where it changes by less than this between two comparisons, relative to |μ + shift|.
const STAYS: f64 = 1e-11;
/// Eigenvalues of two degrees are the same mode if they are no farther apart, in units of their modulus or of the shift if
/// that is larger.
const SAME: f64 = 2e-2;

/// The eigenvalues of an operator next to zero, by rate and frequency ≥ 0: by Arnoldi's method on (K + `shift`)⁻¹ (W. E. Arnoldi, 1951,
/// doi:10.1090/qam/42792), whose largest eigenvalues 1/(μ + shift) belong to the smallest μ, until the `count` nearest to zero stay.
fn spectrum(operator: &Operator, shift: f64, count: usize) -> Result<Vec<[f64; 2]>> {
    let factors = operator.factors(Regular::Shift(shift));
    let size = operator.unknowns();
    let krylov = KRYLOV.min(size);
    // Any vector with a part in every slow mode serves; this one has no symmetry of a mesh.
    let start = DVector::from_fn(size, |i, _| ((i as f64 + 1.0) * 0.754_877_666).fract() - 0.5);
    let mut basis = vec![&start / start.norm()];
    let mut hessenberg = DMatrix::<f64>::zeros(krylov, krylov);
    let mut before = Vec::new();
    for k in 0..krylov {
        let mut next = DVector::from_vec(factors.solve(basis[k].as_slice(), None)?.field.coefficients);
        // Twice is enough to keep the basis orthogonal to rounding.
        for _ in 0..2 {
            for (j, q) in basis.iter().enumerate() {
                let part = q.dot(&next);
                hessenberg[(j, k)] += part;
                next.axpy(-part, q, 1.0);
            }
        }
        let norm = next.norm();
        if k + 1 == krylov || norm < 1e-14 * hessenberg.column(k).norm() {
            return Ok(rates(&hessenberg, k + 1, shift));
        }
        if (k + 1) % CHECKED == 0 {
            let found = rates(&hessenberg, k + 1, shift);
            let stays =
                |(a, b): (&[f64; 2], &[f64; 2])| (a[0] - b[0]).hypot(a[1] - b[1]) < STAYS * (a[0] + shift).hypot(a[1]);
            if before.len() >= count && found.iter().zip(&before).take(count).all(stays) {
                return Ok(found);
            }
            before = found;
        }
        hessenberg[(k + 1, k)] = norm;
        basis.push(next / norm);
    }
    Ok(Vec::new())
}

/// The `count` slowest modes of two degrees. Where there is next to no density the operator has eigenvalues that are those of the mesh
/// alone: only what both degrees have counts, and the distance is its error.
pub(super) fn slowest([fine, coarse]: [&Operator; 2], shift: f64, count: usize) -> Result<Vec<Relaxation>> {
    // Slow modes are chosen among twice as many.
    let nearest = count.saturating_mul(2);
    let (fine, coarse) = rayon::join(|| spectrum(fine, shift, nearest), || spectrum(coarse, shift, nearest));
    let (mut fine, coarse) = (fine?, coarse?);
    let apart = |a: &[f64; 2]| coarse.iter().map(|b| (a[0] - b[0]).hypot(a[1] - b[1])).fold(f64::INFINITY, f64::min);
    fine.retain(|mode| apart(mode) <= SAME * mode[0].hypot(mode[1]).max(shift));
    Ok(Relaxation::slowest(fine, &coarse, count))
}

/// The eigenvalues μ of the leading block, the nearest to zero first.
fn rates(hessenberg: &DMatrix<f64>, size: usize, shift: f64) -> Vec<[f64; 2]> {
    let block = hessenberg.view((0, 0), (size, size)).into_owned();
    let mut rates: Vec<[f64; 2]> = eigenvalues(block)
        .unwrap_or_default()
        .iter()
        .map(Complex::inv)
        .filter(|inverse| inverse.re.is_finite() && inverse.im >= 0.0)
        .map(|inverse| [inverse.re - shift, inverse.im.abs()])
        .collect();
    sort_by_number(&mut rates, |rate| (rate[0] + shift).hypot(rate[1]));
    rates
}
