//! Hermite polynomials h_j = He_j/√j!, orthonormal under the standard normal weight, and their exact algebra.
//!
//! In several dimensions the basis function of an index α is the product h_α = Π h_{α_d}(z_d), so that a sum Σ c_α h_α is
//! kept as the polynomial Σ c_α z^α. Integrals against the Gaussian are read off coefficients: no quadrature, any number of
//! states.

use crate::polynomial::{Polynomial, total_degree};
use faer::Col;

/// The coefficients of a polynomial in the Hermite basis.
pub(super) fn in_hermite(polynomial: &Polynomial) -> Polynomial {
    converted(polynomial, &powers_in_hermite(polynomial.degree()))
}

/// The function of these coefficients in the Hermite basis, in powers of z.
fn in_powers(series: &Polynomial) -> Polynomial {
    converted(series, &hermite_in_powers(series.degree()))
}

/// Σ a_k h_α(k) in powers of z, without its constant.
pub(super) fn combination(states: usize, indices: &[Vec<u32>], a: &Col<f64>) -> Polynomial {
    let mut series = Polynomial::zero(states);
    indices.iter().zip(a.iter()).for_each(|(index, a)| series.add_term(index, *a));
    in_powers(&series).filtered(|alpha, _| total_degree(alpha) > 0)
}

/// The coefficients of ln f_N = −|z|²/2 = −Σ_d h₂(z_d)/√2 + constant.
pub(super) fn standard_normal(indices: &[Vec<u32>]) -> Col<f64> {
    let square = |index: &Vec<u32>| total_degree(index) == 2 && index.contains(&2);
    indices.iter().map(|index| f64::from(square(index)) * -0.5_f64.sqrt()).collect()
}

/// Replaces each one-dimensional factor by a row of `tables`.
fn converted(series: &Polynomial, tables: &[Vec<f64>]) -> Polynomial {
    let states = series.dimension();
    let mut sum = Polynomial::zero(states);
    for (index, coefficient) in series.terms() {
        let mut partial = vec![(vec![0; states], coefficient)];
        for d in 0..states {
            let row = &tables[index[d] as usize];
            let parts = partial.iter().flat_map(|(alpha, c)| {
                row.iter().enumerate().filter(|(_, t)| **t != 0.0).map(move |(power, t)| {
                    let mut alpha = alpha.clone();
                    alpha[d] = power as u32;
                    (alpha, c * t)
                })
            });
            partial = parts.collect();
        }
        partial.iter().for_each(|(alpha, c)| sum.add_term(alpha, *c));
    }
    sum
}

/// Row k: z^k = Σ_j row[j] h_j, by z h_j = √(j+1) h_{j+1} + √j h_{j−1}.
fn powers_in_hermite(degree: u32) -> Vec<Vec<f64>> {
    let mut rows = vec![vec![1.0]];
    for k in 0..degree as usize {
        let mut next = vec![0.0; k + 2];
        for (j, c) in rows[k].iter().enumerate() {
            next[j + 1] += c * ((j + 1) as f64).sqrt();
            if j > 0 {
                next[j - 1] += c * (j as f64).sqrt();
            }
        }
        rows.push(next);
    }
    rows
}

/// Row j: h_j = Σ_k row[k] z^k, by √(j+1) h_{j+1} = z h_j − √j h_{j−1}.
fn hermite_in_powers(degree: u32) -> Vec<Vec<f64>> {
    let mut rows: Vec<Vec<f64>> = vec![vec![1.0]];
    for j in 0..degree as usize {
        let mut next = vec![0.0; j + 2];
        for (k, c) in rows[j].iter().enumerate() {
            next[k + 1] += c;
        }
        if j > 0 {
            for (k, c) in rows[j - 1].iter().enumerate() {
                next[k] -= (j as f64).sqrt() * c;
            }
        }
        rows.push(next.into_iter().map(|c| c / ((j + 1) as f64).sqrt()).collect());
    }
    rows
}

/// h₀(z) … h_degree(z).
pub(super) fn hermite_row(z: f64, degree: u32) -> Vec<f64> {
    let mut row = vec![1.0, z];
    for j in 1..degree as usize {
        row.push((z * row[j] - (j as f64).sqrt() * row[j - 1]) / ((j + 1) as f64).sqrt());
    }
    row.truncate(degree as usize + 1);
    row
}

/// The derivative ∂h_α/∂z_d = √α_d h_{α − e_d}, or nothing where it vanishes.
pub(super) fn derivative(index: &[u32], d: usize) -> Option<(Vec<u32>, f64)> {
    let mut lower = index.to_vec();
    lower[d] = index[d].checked_sub(1)?;
    Some((lower, f64::from(index[d]).sqrt()))
}

/// The product h_a h_b = Σ_c t h_c in one dimension, for all a, b up to a degree:
/// t = √(a! b! c!) / ((s−a)! (s−b)! (s−c)!) with 2s = a + b + c, where c runs from |a − b| to a + b in steps of two.
#[derive(Clone, Debug)]
pub(super) struct ProductTable {
    size: usize,
    rows: Vec<Vec<(u32, f64)>>,
}

impl ProductTable {
    pub(super) fn new(degree: u32) -> Self {
        let size = degree as usize + 1;
        let log_factorial: Vec<f64> = std::iter::once(0.0)
            .chain((1..=2 * size).scan(0.0, |sum, k| {
                *sum += (k as f64).ln();
                Some(*sum)
            }))
            .collect();
        let entry = |a: usize, b: usize, c: usize| {
            let s = (a + b + c) / 2;
            let above = (log_factorial[a] + log_factorial[b] + log_factorial[c]) / 2.0;
            (above - log_factorial[s - a] - log_factorial[s - b] - log_factorial[s - c]).exp()
        };
        let row = |a: usize, b: usize| (a.abs_diff(b)..=a + b).step_by(2).map(|c| (c as u32, entry(a, b, c))).collect();
        let rows = (0..size * size).map(|k| row(k / size, k % size)).collect();
        ProductTable { size, rows }
    }

    /// Visits the terms of degree at most `degree` of the product of two basis functions.
    pub(super) fn product(&self, a: &[u32], b: &[u32], degree: u32, visit: &mut impl FnMut(&[u32], f64)) {
        self.extend(a, b, degree, &mut Vec::with_capacity(a.len()), 1.0, visit);
    }

    /// The terms whose index begins with `index`.
    fn extend(
        &self,
        a: &[u32],
        b: &[u32],
        left: u32,
        index: &mut Vec<u32>,
        factor: f64,
        visit: &mut impl FnMut(&[u32], f64),
    ) {
        let d = index.len();
        if d == a.len() {
            return visit(index, factor);
        }
        for &(c, t) in &self.rows[a[d] as usize * self.size + b[d] as usize] {
            if c > left {
                break;
            }
            index.push(c);
            self.extend(a, b, left - c, index, factor * t, visit);
            index.pop();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::Rule;

    fn h(j: usize, z: f64) -> f64 {
        hermite_row(z, j as u32)[j]
    }

    /// Exact integrands for the rule; values up to 1e3 are summed, so 1e-12 is rounding.
    #[test]
    fn products_agree_with_quadrature() {
        let (table, rule) = (ProductTable::new(6), Rule::hermite(12));
        for a in 0..=6u32 {
            for b in 0..=6u32 {
                let mut terms = [0.0; 13];
                table.product(&[a], &[b], 12, &mut |m, t| terms[m[0] as usize] += t);
                for c in 0..=6usize {
                    let integral: f64 =
                        rule.iter().map(|(z, w)| w * h(a as usize, z) * h(b as usize, z) * h(c, z)).sum();
                    assert!((integral - terms[c]).abs() < 1e-12 * (1.0 + integral.abs()), "{a} {b} {c}");
                }
            }
        }
    }

    /// Two recurrences for the same polynomials.
    #[test]
    fn rows_agree_with_powers() {
        for j in 0..9 {
            let powers = &hermite_in_powers(j as u32)[j];
            for z in [-2.5, 0.0, 0.3, 4.0_f64] {
                let value: f64 = powers.iter().enumerate().map(|(k, c)| c * z.powi(k as i32)).sum();
                // Powers up to 4⁸ cancel.
                assert!((value - h(j, z)).abs() < 1e-11, "{j}, {z}");
            }
        }
    }

    #[test]
    fn powers_and_hermite_polynomials_convert_back_and_forth() {
        let [x, v] = [0, 1].map(|i| Polynomial::variable(2, i));
        let p = &x * &x * &v * &v * 2.0 + &v * &v * &v + &x * -0.5 + 3.0;
        let back = in_powers(&in_hermite(&p));
        for (m, c) in p.terms() {
            assert!((back.coefficient(m) - c).abs() < 1e-14 * 10.0, "{back}");
        }
    }
}
