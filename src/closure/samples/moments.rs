//! Moments from the means of Legendre products.

use super::family::FunctionFamily;
use crate::closure::density::moment::Moment;
use crate::functions::Functions;
use std::collections::HashMap;

/// The moments E x^α of the exponents α of the polynomials among the functions, as far as x^α is a combination of them.
///
/// `error` is that of E Σ c_k φ_k.
pub(super) fn moments(
    functions: &Functions,
    family: &FunctionFamily,
    means: &[f64],
    error: impl Fn(&[(usize, f64)]) -> f64,
) -> Vec<Moment> {
    let listed = functions.powers();
    let place: HashMap<&[u32], usize> = listed.iter().map(|&(k, alpha)| (alpha, k)).collect();
    let highest = listed.iter().flat_map(|(_, alpha)| *alpha).copied().max().unwrap_or(0);
    let [centre, half_width] = family.box_around();
    let sides: Vec<(f64, f64)> = centre.iter().copied().zip(half_width.iter().copied()).collect();
    let tables: Vec<Vec<Vec<f64>>> =
        sides.iter().map(|&(centre, half_width)| powers_in_legendre(centre, half_width, highest as usize)).collect();
    let moment = |&(_, alpha): &(usize, &[u32])| {
        // Products of one term for each state.
        let mut terms = vec![(vec![0; alpha.len()], 1.0)];
        for (i, &power) in alpha.iter().enumerate().filter(|(_, power)| **power > 0) {
            let row = &tables[i][power as usize];
            terms = terms
                .iter()
                .flat_map(|(beta, c)| {
                    row.iter().enumerate().filter(|(_, a)| **a != 0.0).map(move |(k, a)| {
                        let mut beta = beta.clone();
                        beta[i] = k as u32;
                        (beta, c * a)
                    })
                })
                .collect();
        }
        let (mut value, mut parts) = (0.0, Vec::new());
        for (beta, c) in terms {
            if beta.iter().all(|power| *power == 0) {
                value += c;
            } else {
                let k = *place.get(beta.as_slice())?;
                value += c * means[k];
                parts.push((k, c));
            }
        }
        Some(Moment { powers: alpha.to_vec(), value, error: error(&parts) })
    };
    listed.iter().filter_map(moment).collect()
}

/// The coefficients of (centre + half_width t)^p in the Legendre polynomials of t, for p = 0, 1, …
fn powers_in_legendre(centre: f64, half_width: f64, highest: usize) -> Vec<Vec<f64>> {
    let mut rows = vec![vec![0.0; highest + 1]];
    rows[0][0] = 1.0;
    for p in 0..highest {
        // t P_k = ((k + 1) P_{k+1} + k P_{k−1})/(2k + 1).
        let mut next: Vec<f64> = rows[p].iter().map(|c| centre * c).collect();
        for (k, c) in rows[p].iter().enumerate().take(p + 1) {
            let (k_, share) = (k as f64, half_width * c / (2.0 * k as f64 + 1.0));
            next[k + 1] += share * (k_ + 1.0);
            if k > 0 {
                next[k - 1] += share * k_;
            }
        }
        rows.push(next);
    }
    rows
}
