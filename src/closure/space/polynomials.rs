use super::{Jet, Local, Space, SpaceRecord, StepRecord};
use crate::{Monomial, Polynomial};

/// One more than the highest degree of the one-dimensional polynomials.
const TABLE: usize = crate::closure::degrees::HIGHEST as usize + 1;

/// Products of Legendre polynomials in each state, scaled to a box.
///
/// They span the monomials with the same exponents, provided that with each monomial its divisors of the same parities are
/// there, and stay of order one where monomials would not.
#[derive(Clone, Debug)]
pub(crate) struct Polynomials<const N: usize> {
    centre: [f64; N],
    half_width: [f64; N],
    exponents: Vec<[u32; N]>,
    /// The states with a power above zero, for each function.
    factors: Vec<Vec<(usize, usize)>>,
    highest: [usize; N],
}

/// P_k, P_k′ and P_k″ of all degrees, for each state.
type Table<const N: usize> = [[[f64; 3]; TABLE]; N];

impl<const N: usize> Polynomials<N> {
    /// The products with these exponents on the box `centre` ± `half_width`.
    pub(crate) fn new(centre: [f64; N], half_width: [f64; N], exponents: Vec<[u32; N]>) -> Self {
        let factors = exponents
            .iter()
            .map(|alpha| (0..N).filter(|&i| alpha[i] > 0).map(|i| (i, alpha[i] as usize)).collect())
            .collect();
        let highest = std::array::from_fn(|i| exponents.iter().map(|alpha| alpha[i] as usize).max().unwrap_or(0));
        Polynomials { centre, half_width, exponents, factors, highest }
    }

    /// Σ a_k φ_k in powers of the scaled coordinates t, x = centre + half_width t.
    pub(crate) fn in_powers(&self, a: &[f64]) -> Polynomial<N> {
        let legendre = legendre_coefficients(self.highest.iter().copied().max().unwrap_or(0));
        let mut sum = Polynomial::zero();
        for (factors, &a) in self.factors.iter().zip(a) {
            let mut terms = vec![(Monomial::one(), a)];
            for &(i, k) in factors {
                terms = terms
                    .iter()
                    .flat_map(|(m, c)| {
                        legendre[k].iter().enumerate().filter(|(_, l)| **l != 0.0).map(move |(power, l)| {
                            let mut raised: Monomial<N> = *m;
                            raised.0[i] = power as u32;
                            (raised, c * l)
                        })
                    })
                    .collect();
            }
            terms.into_iter().for_each(|(m, c)| sum.add_term(m, c));
        }
        sum
    }

    /// The scaled coordinates as polynomials of the states.
    pub(crate) fn coordinates(&self) -> [Polynomial<N>; N] {
        let variables = Polynomial::<N>::variables();
        std::array::from_fn(|i| (&variables[i] + -self.centre[i]) * self.half_width[i].recip())
    }

    /// P_k of all degrees, for each state.
    fn values_only(&self, x: &[f64; N]) -> [[f64; TABLE]; N] {
        let mut table = [[1.0; TABLE]; N];
        for i in 0..N {
            let t = (x[i] - self.centre[i]) / self.half_width[i];
            let row = &mut table[i];
            row[1] = t;
            for k in 1..self.highest[i] {
                let n = k as f64;
                row[k + 1] = ((2.0 * n + 1.0) * t * row[k] - n * row[k - 1]) / (n + 1.0);
            }
        }
        table
    }

    fn table(&self, x: &[f64; N]) -> Table<N> {
        let mut table = [[[0.0; 3]; TABLE]; N];
        for i in 0..N {
            let scale = self.half_width[i].recip();
            let t = (x[i] - self.centre[i]) * scale;
            let rows = &mut table[i];
            rows[0] = [1.0, 0.0, 0.0];
            if self.highest[i] > 0 {
                rows[1] = [t, scale, 0.0];
            }
            // (k+1) P_{k+1} = (2k+1) t P_k − k P_{k−1}, and the same rule differentiated.
            for k in 1..self.highest[i] {
                let (n, [p, d, s], [p0, d0, s0]) = (k as f64, rows[k], rows[k - 1]);
                let (a, b) = ((2.0 * n + 1.0) / (n + 1.0), n / (n + 1.0));
                rows[k + 1] =
                    [a * t * p - b * p0, a * (t * d + scale * p) - b * d0, a * (t * s + 2.0 * scale * d) - b * s0];
            }
        }
        table
    }
}

impl<const N: usize> Polynomials<N> {
    /// The box and the exponents.
    pub(super) fn step(&self) -> StepRecord {
        StepRecord {
            centre: self.centre.to_vec(),
            half_width: self.half_width.to_vec(),
            exponents: self.exponents.iter().map(|alpha| alpha.to_vec()).collect(),
            kinks: Vec::new(),
        }
    }
}

impl<const N: usize> Space<N> for Polynomials<N> {
    fn record(&self) -> SpaceRecord {
        SpaceRecord { corners: Vec::new(), steps: vec![self.step()] }
    }

    fn len(&self) -> usize {
        self.exponents.len()
    }

    fn values(&self, x: &[f64; N], values: &mut [f64]) {
        let table = self.values_only(x);
        for (value, factors) in values.iter_mut().zip(&self.factors) {
            *value = factors.iter().map(|&(i, k)| table[i][k]).product();
        }
    }

    fn rates(&self, x: &[f64; N], local: &Local<N>, values: &mut [f64], rates: &mut [f64]) {
        let table = self.table(x);
        for ((value, rate), factors) in values.iter_mut().zip(rates).zip(&self.factors) {
            *value = factors.iter().map(|&(i, k)| table[i][k][0]).product();
            *rate = 0.0;
            for (at, &(i, k)) in factors.iter().enumerate() {
                let others = product_without(&table, factors, at, usize::MAX);
                *rate += others * (local.drift[i] * table[i][k][1] + 0.5 * local.diffusion[i][i] * table[i][k][2]);
                for (second, &(j, l)) in factors.iter().enumerate().skip(at + 1) {
                    if local.diffusion[i][j] != 0.0 {
                        let others = product_without(&table, factors, at, second);
                        *rate += others * local.diffusion[i][j] * table[i][k][1] * table[j][l][1];
                    }
                }
            }
        }
    }

    fn combination(&self, x: &[f64; N], a: &[f64]) -> Jet<N> {
        let table = self.table(x);
        let mut sum = Jet::ZERO;
        for (&a, factors) in a.iter().zip(&self.factors) {
            sum.value += a * factors.iter().map(|&(i, k)| table[i][k][0]).product::<f64>();
            for (at, &(i, k)) in factors.iter().enumerate() {
                let others = a * product_without(&table, factors, at, usize::MAX);
                sum.gradient[i] += others * table[i][k][1];
                sum.hessian[i][i] += others * table[i][k][2];
                for (second, &(j, l)) in factors.iter().enumerate().skip(at + 1) {
                    let mixed = a * product_without(&table, factors, at, second) * table[i][k][1] * table[j][l][1];
                    sum.hessian[i][j] += mixed;
                    sum.hessian[j][i] += mixed;
                }
            }
        }
        sum
    }
}

/// The product of all factors' values but two.
fn product_without<const N: usize>(table: &Table<N>, factors: &[(usize, usize)], one: usize, other: usize) -> f64 {
    let kept = factors.iter().enumerate().filter(|(at, _)| *at != one && *at != other);
    kept.map(|(_, &(i, k))| table[i][k][0]).product()
}

/// The coefficients of P_0 … P_`highest` in rising powers.
fn legendre_coefficients(highest: usize) -> Vec<Vec<f64>> {
    let mut rows = vec![vec![1.0], vec![0.0, 1.0]];
    for k in 1..highest {
        let n = k as f64;
        let mut next = vec![0.0; k + 2];
        for (power, c) in rows[k].iter().enumerate() {
            next[power + 1] += (2.0 * n + 1.0) / (n + 1.0) * c;
        }
        for (power, c) in rows[k - 1].iter().enumerate() {
            next[power] -= n / (n + 1.0) * c;
        }
        rows.push(next);
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The jet, the rates and the powers are three routes to the same function.
    #[test]
    fn three_routes_agree() {
        let exponents = vec![[1, 0, 0], [0, 2, 0], [1, 1, 0], [3, 1, 2], [0, 0, 5]];
        let space = Polynomials::new([0.1, -0.2, 0.3], [1.5, 0.7, 2.0], exponents);
        let a = [0.3, -1.2, 0.5, 0.7, -0.4];
        let x = [0.6, 0.1, -1.1];
        let local = Local { drift: [0.4, -0.9, 1.3], diffusion: [[0.5, 0.1, 0.0], [0.1, 0.8, -0.3], [0.0, -0.3, 1.1]] };
        let jet = space.combination(&x, &a);
        let (mut values, mut rates) = ([0.0; 5], [0.0; 5]);
        space.rates(&x, &local, &mut values, &mut rates);
        let dot = |b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let powers = space.in_powers(&a).compose(&space.coordinates());
        // Sums of a few products of numbers near one.
        assert!((dot(&values) - jet.value).abs() < 1e-13);
        assert!((dot(&rates) - local.generator(&jet)).abs() < 1e-12);
        assert!((powers.evaluate(&x) - jet.value).abs() < 1e-12);
        for i in 0..3 {
            assert!((powers.gradient(&x)[i] - jet.gradient[i]).abs() < 1e-12);
            for j in 0..3 {
                assert!((powers.hessian(&x)[i][j] - jet.hessian[i][j]).abs() < 1e-11);
            }
        }
    }
}
