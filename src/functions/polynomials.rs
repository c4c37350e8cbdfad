use super::{Fold, HIGHEST};
use crate::numerics::legendre;
use crate::polynomial::Polynomial;
use crate::record::{Read, exponents, positive_states, states};
use serde::{Deserialize, Serialize};

/// Products of Legendre polynomials in each state, scaled to a box.
///
/// They span the monomials with the same exponents, provided that with each monomial its divisors of the same parities are
/// there, and stay of order one where monomials would not. In the place of a Legendre polynomial may be its product with a function
/// that has a kink, by [`Fold::code`] in the list of exponents.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Polynomials {
    centre: Vec<f64>,
    half_width: Vec<f64>,
    exponents: Vec<Vec<u32>>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    folds: Vec<Fold>,
}

impl Polynomials {
    /// The products with these exponents on the box `centre` ± `half_width`.
    pub(crate) fn new(centre: Vec<f64>, half_width: Vec<f64>, exponents: Vec<Vec<u32>>) -> Self {
        Polynomials { centre, half_width, exponents, folds: Vec::new() }
    }

    /// The same whose exponents may be those of folds.
    pub(crate) fn folded(self, folds: Vec<Fold>) -> Self {
        Polynomials { folds, ..self }
    }

    /// The folds that exponents may have.
    pub(crate) fn folds(&self) -> &[Fold] {
        &self.folds
    }

    /// Whether an exponent is that of no fold.
    pub(crate) fn is_plain(alpha: &[u32]) -> bool {
        alpha.iter().all(|&exponent| Fold::decoded(exponent).0.is_none())
    }

    /// Refuses numbers without a meaning, such as those of a damaged file.
    pub(super) fn checked(self, count: usize) -> Read<Self> {
        states("the centre of the polynomials", &self.centre, count)?;
        positive_states("the half width of the polynomials", &self.half_width, count)?;
        let folds: Vec<Fold> = self.folds.into_iter().map(|fold| fold.checked(count)).collect::<Read<_>>()?;
        for alpha in &self.exponents {
            if folds.is_empty() {
                exponents(alpha, count, HIGHEST)?;
            }
            let degrees: Vec<u32> = alpha.iter().map(|&exponent| Fold::decoded(exponent).1).collect();
            exponents(&degrees, count, HIGHEST)?;
            let known = |(state, &exponent): (usize, &u32)| {
                Fold::decoded(exponent).0.is_none_or(|fold| folds.get(fold).is_some_and(|fold| fold.state == state))
            };
            if !alpha.iter().enumerate().all(known) {
                return Err(format!("the exponents {alpha:?} have no such fold"));
            }
        }
        Ok(Polynomials::new(self.centre, self.half_width, self.exponents).folded(folds))
    }

    /// The number of functions.
    pub(crate) fn len(&self) -> usize {
        self.exponents.len()
    }

    /// The middle of the box.
    pub(crate) fn centre(&self) -> &[f64] {
        &self.centre
    }

    /// The half widths of the box.
    pub(crate) fn half_width(&self) -> &[f64] {
        &self.half_width
    }

    /// The degrees of each function in the states.
    pub(crate) fn exponents(&self) -> &[Vec<u32>] {
        &self.exponents
    }

    /// Σ a_k φ_k in powers of the scaled coordinates t, x = centre + half_width t.
    pub(crate) fn in_powers(&self, a: &[f64]) -> Polynomial {
        let states = self.centre.len();
        let degree = |exponent: u32| Fold::decoded(exponent).1 as usize;
        let highest = |i: usize| self.exponents.iter().map(|alpha| degree(alpha[i])).max().unwrap_or(0);
        let variables = Polynomial::variables(states);
        let legendre: Vec<Vec<Polynomial>> =
            variables.iter().enumerate().map(|(i, t)| as_polynomials(t, highest(i))).collect();
        self.exponents.iter().zip(a).fold(Polynomial::zero(states), |sum, (alpha, &a)| {
            let factors = legendre.iter().zip(alpha).filter(|(_, power)| **power > 0);
            let start = Polynomial::constant(states, a);
            sum + factors.fold(start, |product, (legendre, &exponent)| {
                let product = &product * &legendre[degree(exponent)];
                match Fold::decoded(exponent).0.map(|fold| &self.folds[fold]) {
                    Some(fold) => {
                        product * fold.polynomial(states, self.centre[fold.state], self.half_width[fold.state])
                    }
                    None => product,
                }
            })
        })
    }

    /// The scaled coordinates as polynomials of the states.
    pub(crate) fn coordinates(&self) -> Vec<Polynomial> {
        let sides = self.centre.iter().zip(&self.half_width);
        let variables = Polynomial::variables(self.centre.len()).into_iter().zip(sides);
        variables.map(|(x, (centre, half_width))| (x + -centre) * half_width.recip()).collect()
    }
}

/// P_0 … P_`highest` of a variable.
fn as_polynomials(t: &Polynomial, highest: usize) -> Vec<Polynomial> {
    let mut all = vec![Polynomial::constant(t.dimension(), 1.0), t.clone()];
    for k in 1..highest {
        let [a, b] = legendre::recurrence(k);
        all.push(t * &all[k] * a - &all[k - 1] * b);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::functions::{Functions, Scratch};
    use crate::numerics::{EIGHT, Eight, Number};

    /// The tree and the powers are two routes to the same functions: values, gradients and images, at one point and at eight.
    #[test]
    fn two_routes_agree() {
        let exponents = [[1, 0, 0], [0, 2, 0], [1, 1, 0], [3, 1, 2], [0, 0, 5]].map(Vec::from).to_vec();
        let polynomials = Polynomials::new(vec![0.1, -0.2, 0.3], vec![1.5, 0.7, 2.0], exponents);
        let space = Functions::from(polynomials.clone());
        let a = [0.3, -1.2, 0.5, 0.7, -0.4];
        let x: [Eight; 3] = std::array::from_fn(|i| Eight::from_points(|l| 0.3 * i as f64 - 0.2 * l as f64 + 0.1));
        let (drift, diffusion) = ([0.4, -0.9, 1.3], [0.5, 0.1, 0.0, 0.1, 0.8, -0.3, 0.0, -0.3, 1.1]);
        let mut eight = Scratch::default();
        space.place(&x, &mut eight);
        let value = space.sum(&a, &eight);
        space.apply((&drift.map(Eight::everywhere), &diffusion.map(Eight::everywhere)), &[0, 1, 2], &mut eight);
        let image = space.sum_of_images(&a, &eight);
        space.gradient(&a, &mut eight);
        let powers = polynomials.in_powers(&a).compose(&polynomials.coordinates());
        for l in 0..EIGHT {
            let point = x.map(|x| x.at(l));
            let mut single = Scratch::default();
            space.place(&point, &mut single);
            assert_eq!(value.at(l).to_bits(), space.sum(&a, &single).to_bits());
            space.apply((&drift, &diffusion), &[0, 1, 2], &mut single);
            assert_eq!(image.at(l).to_bits(), space.sum_of_images(&a, &single).to_bits());
            let (slope, bend) = (powers.gradient(&point), powers.hessian(&point));
            let bent = (0..9).map(|k| 0.5 * diffusion[k] * bend[k / 3][k % 3]).sum::<f64>();
            let exact = (0..3).map(|i| drift[i] * slope[i]).sum::<f64>() + bent;
            // Sums of some products of numbers up to a thousand.
            let close = |found: f64, exact: f64| (found - exact).abs() < 1e-11 * (1.0 + exact.abs());
            assert!(close(value.at(l), powers.evaluate(&point)) && close(image.at(l), exact), "{point:?}");
            assert!((0..3).all(|i| close(eight.gradient[i].at(l), slope[i])), "{point:?}");
        }
    }
}
