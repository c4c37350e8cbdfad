use super::Jet;
use super::degrees::HIGHEST;
use crate::control_variates::products::Products;
use crate::numerics::{Number, legendre};
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

    /// Whether none of them depends on a state.
    #[inline(always)]
    pub(super) fn are_constant(&self) -> bool {
        self.width == 1
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

    #[inline(always)]
    pub(super) fn values<T: Number>(&self, x: &[T], values: &mut [T]) {
        let mut room = Room::new(self.width * self.centre.len(), T::everywhere(0.0));
        let table = self.placed(x, room.entries());
        for (value, factors) in values.iter_mut().zip(&self.factors) {
            *value = product(table, factors);
        }
    }

    /// `start` + Σ a_k φ_k, the terms added one after the other.
    #[inline(always)]
    pub(super) fn added<T: Number>(&self, start: T, x: &[T], a: &[f64]) -> T {
        let mut room = Room::new(self.width * self.centre.len(), T::everywhere(0.0));
        let table = self.placed(x, room.entries());
        let mut sum = start;
        for (factors, &a) in self.factors.iter().zip(a) {
            sum += product(table, factors) * a;
        }
        sum
    }

    #[inline(always)]
    pub(super) fn rates<T: Number>(
        &self,
        x: &[T],
        (drift, diffusion): (&[T], &[T]),
        values: &mut [T],
        rates: &mut [T],
    ) {
        let states = self.centre.len();
        let mut room = Room::new(self.width * states, [T::everywhere(0.0); 3]);
        let table = self.placed_jets(x, room.entries());
        for ((value, rate), factors) in values.iter_mut().zip(rates).zip(&self.factors) {
            *value = product_without(table, factors, usize::MAX, usize::MAX);
            let mut sum = T::everywhere(0.0);
            for (one, &(i, k)) in factors.iter().enumerate() {
                let others = product_without(table, factors, one, usize::MAX);
                sum += others * (drift[i] * table[k][1] + diffusion[i * states + i] * 0.5 * table[k][2]);
                for (other, &(j, l)) in factors.iter().enumerate().skip(one + 1) {
                    let b = diffusion[i * states + j];
                    if !b.is_zero() {
                        sum += product_without(table, factors, one, other) * b * table[k][1] * table[l][1];
                    }
                }
            }
            *rate = sum;
        }
    }

    #[inline(always)]
    pub(super) fn combine<T: Number>(&self, x: &[T], a: &[f64], sum: &mut Jet<T>) {
        let states = self.centre.len();
        let mut room = Room::new(self.width * states, [T::everywhere(0.0); 3]);
        let table = self.placed_jets(x, room.entries());
        for (&a, factors) in a.iter().zip(&self.factors) {
            sum.value += product_without(table, factors, usize::MAX, usize::MAX) * a;
            for (one, &(i, k)) in factors.iter().enumerate() {
                let others = product_without(table, factors, one, usize::MAX) * a;
                sum.gradient[i] += others * table[k][1];
                sum.hessian[i * states + i] += others * table[k][2];
                for (other, &(j, l)) in factors.iter().enumerate().skip(one + 1) {
                    let mixed = product_without(table, factors, one, other) * a * table[k][1] * table[l][1];
                    sum.hessian[i * states + j] += mixed;
                    sum.hessian[j * states + i] += mixed;
                }
            }
        }
    }

    /// P_k of all degrees, state after state.
    #[inline(always)]
    fn placed<'a, T: Number>(&self, x: &[T], table: &'a mut [T]) -> &'a [T] {
        for (i, row) in table.chunks_exact_mut(self.width).enumerate() {
            let t = (x[i] - self.centre[i]) / T::everywhere(self.half_width[i]);
            legendre::values(t, &mut row[..=self.highest[i]]);
        }
        table
    }

    /// P_k, P_k′ and P_k″.
    #[inline(always)]
    fn placed_jets<'a, T: Number>(&self, x: &[T], table: &'a mut [[T; 3]]) -> &'a [[T; 3]] {
        let [zero, one] = [0.0, 1.0].map(T::everywhere);
        for (i, rows) in table.chunks_exact_mut(self.width).enumerate() {
            let scale = self.half_width[i].recip();
            let t = (x[i] - self.centre[i]) * scale;
            rows[0] = [one, zero, zero];
            if self.highest[i] > 0 {
                rows[1] = [t, T::everywhere(scale), zero];
            }
            // The recurrence, and the same differentiated.
            for k in 1..self.highest[i] {
                let ([p, d, s], [p0, d0, s0]) = (rows[k], rows[k - 1]);
                let [a, b] = legendre::recurrence(k);
                rows[k + 1] =
                    [t * a * p - p0 * b, (t * d + p * scale) * a - d0 * b, (t * s + d * (2.0 * scale)) * a - s0 * b];
            }
        }
        table
    }
}

impl Products {
    /// These polynomials, after the constant.
    pub(in crate::closure) fn new(functions: &Polynomials) -> Self {
        Products::on_box(&functions.centre, &functions.half_width, &functions.exponents)
    }
}

/// Room for a table, on the stack where it fits.
struct Room<T> {
    stack: [T; ON_STACK],
    heap: Vec<T>,
    entries: usize,
}

impl<T: Copy> Room<T> {
    #[inline(always)]
    fn new(entries: usize, start: T) -> Self {
        let heap = if entries > ON_STACK { vec![start; entries] } else { Vec::new() };
        Room { stack: [start; ON_STACK], heap, entries }
    }

    #[inline(always)]
    fn entries(&mut self) -> &mut [T] {
        if self.entries <= ON_STACK { &mut self.stack[..self.entries] } else { &mut self.heap }
    }
}

/// The product of all factors.
#[inline(always)]
fn product<T: Number>(table: &[T], factors: &[(usize, usize)]) -> T {
    let mut product = T::everywhere(1.0);
    for &(_, at) in factors {
        product = product * table[at];
    }
    product
}

/// The product of all factors' values but two.
#[inline(always)]
fn product_without<T: Number>(table: &[[T; 3]], factors: &[(usize, usize)], one: usize, other: usize) -> T {
    let mut product = T::everywhere(1.0);
    for (at, &(_, k)) in factors.iter().enumerate() {
        if at != one && at != other {
            product = product * table[k][0];
        }
    }
    product
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
    use crate::fokker_planck::generator;
    use crate::numerics::{EIGHT, PointLane};

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
        let space = Functions::from(space);
        let mut scratch = products.scratch();
        let x: [PointLane; 3] = std::array::from_fn(|i| std::array::from_fn(|l| 0.3 * i as f64 - 0.2 * l as f64 + 0.1));
        let (drift, diffusion) = ([0.4, -0.9, 1.3], [0.5, 0.1, 0.0, 0.1, 0.8, -0.3, 0.0, -0.3, 1.1]);
        let a = [0.7, 0.3, -1.2, 0.5, 0.7, -0.4];
        products.place(&x, &mut scratch);
        scratch.first = drift.map(|f| [f; EIGHT]).to_vec();
        products.apply(&diffusion.map(|b| [b; EIGHT]), &[0, 1, 2], &mut scratch);
        for l in 0..EIGHT {
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
        for l in 0..EIGHT {
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
