//! The part of the generator that impulses make, as a matrix.

use crate::fokker_planck::ImpulseTerm;
use crate::numerics::legendre::recurrence;
use crate::numerics::sort_by_number;
use crate::polynomial::Polynomial;
use std::collections::HashMap;

/// λ E\[ψ(x + H Y) − ψ(x)\], or its derivative by a parameter, of products of Legendre polynomials as combinations of these products: for each its terms, by
/// the place of the product in the list, where 0 is the constant.
///
/// Impulses are jumps of the sampled states; their expectation has far less variance than the jumps themselves, and costs a few
/// multiplications.
pub(crate) type ImpulseImages = Vec<Vec<(usize, f64)>>;

/// The images of the products with these `exponents` on a box. None where H is not of first degree, whose images have higher
/// degrees than the list.
pub(crate) fn images(
    terms: &[ImpulseTerm],
    (centre, half_width): (&[f64], &[f64]),
    exponents: &[Vec<u32>],
) -> Option<ImpulseImages> {
    let n = centre.len();
    let on_box: Vec<Polynomial> = (0..n).map(|i| Polynomial::variable(n, i) * half_width[i] + centre[i]).collect();
    let on_scale = |field: &[Polynomial]| -> Vec<Polynomial> {
        field.iter().zip(half_width).map(|(h, width)| h.compose(&on_box) * width.recip()).collect()
    };
    if terms.iter().flat_map(ImpulseTerm::fields).any(|(_, h)| h.degree() > 1) {
        return None;
    }
    let scaled: Vec<ImpulseTerm> = terms.iter().map(|term| term.with(1.0, on_scale)).collect();
    let highest = exponents.iter().flatten().copied().max().unwrap_or(0) as usize;
    let legendre = legendre(highest);
    let powers = powers(highest);
    let places: HashMap<&[u32], usize> =
        exponents.iter().enumerate().map(|(k, alpha)| (alpha.as_slice(), k + 1)).collect();
    let image = |alpha: &Vec<u32>| {
        let factors = alpha.iter().enumerate().map(|(i, degree)| {
            let mut factor = Polynomial::zero(n);
            let terms = legendre[*degree as usize].iter().enumerate();
            terms.for_each(|(power, c)| factor.add_term(&crate::polynomial::of_one(n, i, power as u32), *c));
            factor
        });
        let psi = factors.fold(Polynomial::constant(n, 1.0), |product, factor| product * factor);
        let image = scaled.iter().fold(Polynomial::zero(n), |sum, term| sum + term.generator(&psi));
        let mut found: HashMap<usize, f64> = HashMap::new();
        for (alpha, c) in image.terms() {
            let mut products = vec![(Vec::with_capacity(n), c)];
            for power in alpha {
                let each = |(degrees, c): &(Vec<u32>, f64)| {
                    let (degrees, c) = (degrees.clone(), *c);
                    let terms = powers[*power as usize].iter().enumerate().filter(|(_, part)| **part != 0.0);
                    terms
                        .map(move |(k, part)| ([degrees.as_slice(), &[k as u32]].concat(), c * part))
                        .collect::<Vec<_>>()
                };
                products = products.iter().flat_map(each).collect();
            }
            for (degrees, c) in products {
                let place =
                    if degrees.iter().all(|d| *d == 0) { Some(0) } else { places.get(degrees.as_slice()).copied() };
                *found.entry(place?).or_insert(0.0) += c;
            }
        }
        let mut found: Vec<(usize, f64)> = found.into_iter().filter(|(_, c)| *c != 0.0).collect();
        sort_by_number(&mut found, |(place, _)| *place as f64);
        Some(found)
    };
    exponents.iter().map(image).collect()
}

/// P_k as powers of its argument.
fn legendre(highest: usize) -> Vec<Vec<f64>> {
    let mut all: Vec<Vec<f64>> = vec![vec![1.0], vec![0.0, 1.0]];
    for k in 1..highest {
        let [a, b] = recurrence(k);
        let mut next = vec![0.0; k + 2];
        all[k].iter().enumerate().for_each(|(i, c)| next[i + 1] += a * c);
        all[k - 1].iter().enumerate().for_each(|(i, c)| next[i] -= b * c);
        all.push(next);
    }
    all
}

/// Powers as combinations of P_k, by t P_k = ((k + 1) P_{k+1} + k P_{k−1})/(2k + 1).
fn powers(highest: usize) -> Vec<Vec<f64>> {
    let mut all: Vec<Vec<f64>> = vec![vec![1.0]];
    for m in 0..highest {
        let mut next = vec![0.0; m + 2];
        for (k, c) in all[m].iter().enumerate() {
            let size = (2 * k + 1) as f64;
            next[k + 1] += c * (k + 1) as f64 / size;
            if k > 0 {
                next[k - 1] += c * k as f64 / size;
            }
        }
        all.push(next);
    }
    all
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop")]
    use super::*;
    use crate::fokker_planck::Impulse;
    use crate::functions::{Functions, Scratch};
    use crate::polynomial::monomials;
    use crate::system::{Amplitude, PoissonImpulses};

    /// Two routes: the matrix, and ψ at the states after impulses by a Gauss rule that is exact for it.
    #[test]
    fn images_are_the_expectations() {
        let process = |amplitude| PoissonImpulses::new(1.7, amplitude).unwrap();
        let [x, v] = [0, 1].map(|i| Polynomial::variable(2, i));
        let impulses = [
            Impulse::new(
                process(Amplitude::Exponential { mean: 0.3 }),
                vec![Polynomial::zero(2), Polynomial::constant(2, 0.8)],
            ),
            Impulse::new(
                process(Amplitude::Normal { mean: -0.1, deviation: 0.4 }),
                vec![&x * 0.5 + 0.1, &v * 0.2 + &x],
            ),
        ];
        let mut exponents = monomials(2, 8);
        exponents.retain(|alpha| alpha.iter().any(|power| *power > 0));
        let (centre, half_width) = ([0.4, -0.2], [2.0, 3.0]);
        let found = images(&impulses.each_ref().map(ImpulseTerm::of), (&centre, &half_width), &exponents).unwrap();
        let functions = Functions::on_box(&centre, &half_width, &exponents);
        let values = |x: [f64; 2]| {
            let mut scratch = Scratch::default();
            functions.place_values(&x, &mut scratch);
            (0..=exponents.len()).map(|k| functions.value(&scratch, k)).collect::<Vec<f64>>()
        };
        for x in [[0.3, 1.2], [-1.1, 2.0]] {
            let own = values(x);
            let mut exact = vec![0.0; own.len()];
            for impulse in &impulses {
                for (y, w) in impulse.process().amplitude().rule(6) {
                    let h = impulse.field();
                    let after = values([x[0] + h[0].evaluate(&x) * y, x[1] + h[1].evaluate(&x) * y]);
                    (0..own.len()).for_each(|k| exact[k] += 1.7 * w * (after[k] - own[k]));
                }
            }
            for (k, row) in found.iter().enumerate() {
                let image: f64 = row.iter().map(|(place, c)| c * own[*place]).sum();
                let size: f64 = 1.0 + row.iter().map(|(place, c)| (c * own[*place]).abs()).sum::<f64>();
                assert!((image - exact[k + 1]).abs() < 1e-12 * size, "{:?} {image} {}", exponents[k], exact[k + 1]);
            }
        }
        let square = Impulse::new(process(Amplitude::TwoPoint { a: 0.1, b: 0.2 }), vec![&x * &x, Polynomial::zero(2)]);
        assert!(images(&[ImpulseTerm::of(&square)], (&centre, &half_width), &exponents).is_none());
    }
}
