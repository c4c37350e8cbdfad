use super::Jet;
use super::degrees::HIGHEST;
use crate::control_variates::products::Products;
use crate::numerics::legendre;
use crate::polynomial::Polynomial;
use crate::record::{Read, exponents, positive_states, states};
use serde::{Deserialize, Serialize};

/// The most entries of a table on the stack: those of two states to the highest degree, or of ten to the fourth.
const ON_STACK: usize = 2 * (HIGHEST as usize + 1);

/// Products of Legendre polynomials in each state, scaled to a box.
///
/// They span the monomials with the same exponents, provided that with each monomial its divisors of the same parities are
/// there, and stay of order one where monomials would not.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Polynomials {
    centre: Vec<f64>,
    half_width: Vec<f64>,
    exponents: Vec<Vec<u32>>,
    /// The states with a power above zero, for each function, and the places of those powers in a table.
    #[serde(skip)]
    factors: Vec<Vec<(usize, usize)>>,
    /// The highest power of each state.
    #[serde(skip)]
    highest: Vec<usize>,
    /// Entries of each state in a table of the one-dimensional polynomials.
    #[serde(skip)]
    width: usize,
}

impl Polynomials {
    /// The products with these exponents on the box `centre` ± `half_width`.
    pub(crate) fn new(centre: Vec<f64>, half_width: Vec<f64>, exponents: Vec<Vec<u32>>) -> Self {
        let highest = |i: usize| exponents.iter().map(|alpha| alpha[i] as usize).max().unwrap_or(0);
        let highest: Vec<usize> = (0..centre.len()).map(highest).collect();
        let width = highest.iter().copied().max().unwrap_or(0) + 1;
        let factors = |alpha: &Vec<u32>| {
            let powers = alpha.iter().enumerate().filter(|(_, power)| **power > 0);
            powers.map(|(i, &power)| (i, i * width + power as usize)).collect()
        };
        let factors = exponents.iter().map(factors).collect();
        Polynomials { centre, half_width, exponents, factors, highest, width }
    }

    /// Refuses numbers without a meaning, such as those of a damaged file.
    pub(super) fn checked(self, count: usize) -> Read<Self> {
        states("the centre of the polynomials", &self.centre, count)?;
        positive_states("the half width of the polynomials", &self.half_width, count)?;
        self.exponents.iter().try_for_each(|alpha| exponents(alpha, count, HIGHEST))?;
        Ok(Polynomials::new(self.centre, self.half_width, self.exponents))
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
        let legendre: Vec<Vec<Polynomial>> = Polynomial::variables(states)
            .iter()
            .zip(&self.highest)
            .map(|(t, highest)| as_polynomials(t, *highest))
            .collect();
        self.exponents.iter().zip(a).fold(Polynomial::zero(states), |sum, (alpha, &a)| {
            let factors = legendre.iter().zip(alpha).filter(|(_, power)| **power > 0);
            let start = Polynomial::constant(states, a);
            sum + factors.fold(start, |product, (legendre, &power)| &product * &legendre[power as usize])
        })
    }

    /// The scaled coordinates as polynomials of the states.
    pub(crate) fn coordinates(&self) -> Vec<Polynomial> {
        let sides = self.centre.iter().zip(&self.half_width);
        let variables = Polynomial::variables(self.centre.len()).into_iter().zip(sides);
        variables.map(|(x, (centre, half_width))| (x + -centre) * half_width.recip()).collect()
    }

    pub(super) fn values(&self, x: &[f64], values: &mut [f64]) {
        self.on_values(x, |table| {
            for (value, factors) in values.iter_mut().zip(&self.factors) {
                *value = factors.iter().map(|&(_, at)| table[at]).product();
            }
        });
    }

    /// `start` + Σ a_k φ_k, the terms added one after the other.
    pub(super) fn added(&self, start: f64, x: &[f64], a: &[f64]) -> f64 {
        let product =
            |table: &[f64], factors: &[(usize, usize)]| factors.iter().map(|&(_, at)| table[at]).product::<f64>();
        self.on_values(x, |table| {
            self.factors.iter().zip(a).fold(start, |sum, (factors, a)| sum + product(table, factors) * a)
        })
    }

    pub(super) fn rates(&self, x: &[f64], (drift, diffusion): (&[f64], &[f64]), values: &mut [f64], rates: &mut [f64]) {
        let states = self.centre.len();
        self.on_jets(x, |table| {
            for ((value, rate), factors) in values.iter_mut().zip(rates).zip(&self.factors) {
                *value = factors.iter().map(|&(_, at)| table[at][0]).product();
                *rate = 0.0;
                for (one, &(i, k)) in factors.iter().enumerate() {
                    let others = product_without(table, factors, one, usize::MAX);
                    *rate += others * (drift[i] * table[k][1] + 0.5 * diffusion[i * states + i] * table[k][2]);
                    for (other, &(j, l)) in factors.iter().enumerate().skip(one + 1) {
                        let b = diffusion[i * states + j];
                        if b != 0.0 {
                            *rate += product_without(table, factors, one, other) * b * table[k][1] * table[l][1];
                        }
                    }
                }
            }
        });
    }

    pub(super) fn combine(&self, x: &[f64], a: &[f64], sum: &mut Jet) {
        let states = self.centre.len();
        self.on_jets(x, |table| {
            for (&a, factors) in a.iter().zip(&self.factors) {
                sum.value += a * factors.iter().map(|&(_, at)| table[at][0]).product::<f64>();
                for (one, &(i, k)) in factors.iter().enumerate() {
                    let others = a * product_without(table, factors, one, usize::MAX);
                    sum.gradient[i] += others * table[k][1];
                    sum.hessian[i * states + i] += others * table[k][2];
                    for (other, &(j, l)) in factors.iter().enumerate().skip(one + 1) {
                        let mixed = a * product_without(table, factors, one, other) * table[k][1] * table[l][1];
                        sum.hessian[i * states + j] += mixed;
                        sum.hessian[j * states + i] += mixed;
                    }
                }
            }
        });
    }

    /// Works on a table of P_k of all degrees, state after state.
    fn on_values<R>(&self, x: &[f64], work: impl FnOnce(&[f64]) -> R) -> R {
        on_table(self.width * self.centre.len(), |table: &mut [f64]| {
            for (i, row) in table.chunks_exact_mut(self.width).enumerate() {
                let t = (x[i] - self.centre[i]) / self.half_width[i];
                legendre::values(t, &mut row[..=self.highest[i]]);
            }
            work(table)
        })
    }

    /// Works on a table of P_k, P_k′ and P_k″.
    fn on_jets<R>(&self, x: &[f64], work: impl FnOnce(&[[f64; 3]]) -> R) -> R {
        on_table(self.width * self.centre.len(), |table: &mut [[f64; 3]]| {
            for (i, rows) in table.chunks_exact_mut(self.width).enumerate() {
                let scale = self.half_width[i].recip();
                let t = (x[i] - self.centre[i]) * scale;
                rows[0] = [1.0, 0.0, 0.0];
                if self.highest[i] > 0 {
                    rows[1] = [t, scale, 0.0];
                }
                // The recurrence, and the same differentiated.
                for k in 1..self.highest[i] {
                    let ([p, d, s], [p0, d0, s0]) = (rows[k], rows[k - 1]);
                    let [a, b] = legendre::recurrence(k);
                    rows[k + 1] =
                        [a * t * p - b * p0, a * (t * d + scale * p) - b * d0, a * (t * s + 2.0 * scale * d) - b * s0];
                }
            }
            work(table)
        })
    }
}

impl Products {
    /// These functions, after the constant.
    pub(in crate::closure) fn new(functions: &Polynomials) -> Self {
        Products::on_box(&functions.centre, &functions.half_width, &functions.exponents)
    }
}

/// Works on a table of so many entries, on the stack where it fits.
fn on_table<T: Copy + Default, R>(entries: usize, work: impl FnOnce(&mut [T]) -> R) -> R {
    if entries <= ON_STACK {
        work(&mut [T::default(); ON_STACK][..entries])
    } else {
        work(&mut vec![T::default(); entries])
    }
}

/// The product of all factors' values but two.
fn product_without(table: &[[f64; 3]], factors: &[(usize, usize)], one: usize, other: usize) -> f64 {
    let kept = factors.iter().enumerate().filter(|(at, _)| *at != one && *at != other);
    kept.map(|(_, &(_, k))| table[k][0]).product()
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
    use crate::closure::space::Functions;
    use crate::control_variates::products::{LANES, Lane};
    use crate::fokker_planck::generator;

    /// The jet, the rates and the powers are three routes to the same function.
    #[test]
    fn three_routes_agree() {
        let exponents = [[1, 0, 0], [0, 2, 0], [1, 1, 0], [3, 1, 2], [0, 0, 5]].map(|alpha| alpha.to_vec());
        let space = Polynomials::new(vec![0.1, -0.2, 0.3], vec![1.5, 0.7, 2.0], exponents.to_vec());
        let a = [0.3, -1.2, 0.5, 0.7, -0.4];
        let x = [0.6, 0.1, -1.1];
        let local: (&[f64], &[f64]) = (&[0.4, -0.9, 1.3], &[0.5, 0.1, 0.0, 0.1, 0.8, -0.3, 0.0, -0.3, 1.1]);
        let mut jet = Jet::zero(3);
        space.combine(&x, &a, &mut jet);
        let (mut values, mut rates) = ([0.0; 5], [0.0; 5]);
        space.rates(&x, local, &mut values, &mut rates);
        let dot = |b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let powers = space.in_powers(&a).compose(&space.coordinates());
        // Sums of a few products of numbers near one.
        assert!((dot(&values) - jet.value).abs() < 1e-13 && (space.added(0.5, &x, &a) - 0.5 - jet.value).abs() < 1e-13);
        assert!((dot(&rates) - generator(local, &jet.gradient, &jet.hessian)).abs() < 1e-12);
        assert!((powers.evaluate(&x) - jet.value).abs() < 1e-12);
        for i in 0..3 {
            assert!((powers.gradient(&x)[i] - jet.gradient[i]).abs() < 1e-12);
            for j in 0..3 {
                assert!((powers.hessian(&x)[i][j] - jet.hessian[3 * i + j]).abs() < 1e-11);
            }
        }
    }

    /// The tree's sweeps give what the functions one by one give.
    #[test]
    fn sweeps_agree_with_single_functions() {
        let exponents = [[1, 0, 0], [0, 2, 0], [1, 1, 0], [3, 1, 2], [0, 0, 5]].map(Vec::from).to_vec();
        let space = Polynomials::new(vec![0.1, -0.2, 0.3], vec![1.5, 0.7, 2.0], exponents);
        let products = Products::new(&space);
        let space = Functions::Polynomials(space);
        let mut scratch = products.scratch();
        let x: [Lane; 3] = std::array::from_fn(|i| std::array::from_fn(|l| 0.3 * i as f64 - 0.2 * l as f64 + 0.1));
        let (drift, diffusion) = ([0.4, -0.9, 1.3], [0.5, 0.1, 0.0, 0.1, 0.8, -0.3, 0.0, -0.3, 1.1]);
        let a = [0.7, 0.3, -1.2, 0.5, 0.7, -0.4];
        products.place(&x, &mut scratch);
        scratch.first = drift.map(|f| [f; LANES]).to_vec();
        products.apply(&diffusion.map(|b| [b; LANES]), &[0, 1, 2], &mut scratch);
        for l in 0..LANES {
            let point = [0, 1, 2].map(|i| x[i][l]);
            let (mut values, mut rates) = ([0.0; 5], [0.0; 5]);
            space.rates(&point, (&drift, &diffusion), &mut values, &mut rates);
            for k in 0..5 {
                assert!((products.value(&scratch, k + 1)[l] - values[k]).abs() < 1e-12 * (1.0 + values[k].abs()));
                assert!((products.image(&scratch, k + 1)[l] - rates[k]).abs() < 1e-11 * (1.0 + rates[k].abs()));
            }
        }
        let sum = products.sum(&a, &scratch);
        products.gradient(&a, &mut scratch);
        for l in 0..LANES {
            let mut jet = Jet::zero(3);
            space.combine(&[0, 1, 2].map(|i| x[i][l]), &a[1..], &mut jet);
            assert!((sum[l] - 0.7 - jet.value).abs() < 1e-12 * (1.0 + jet.value.abs()));
            for i in 0..3 {
                let slope = scratch.gradient[i][l];
                assert!((slope - jet.gradient[i]).abs() < 1e-11 * (1.0 + jet.gradient[i].abs()));
            }
        }
    }
}
