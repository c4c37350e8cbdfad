//! Products with polynomials in Hermite's functions.

use crate::polynomial::Polynomial;
use std::collections::HashMap;

/// Coefficients of products h_α(z) of Hermite's polynomials, orthonormal under the standard normal density, with every degree
/// below `side`; that of state i is the i-th digit of the index.
#[derive(Clone, Debug)]
pub(super) struct HermiteTable {
    pub(super) states: usize,
    pub(super) side: usize,
    pub(super) values: Vec<f64>,
}

impl HermiteTable {
    /// The constant 1.
    pub(super) fn one(states: usize, side: usize) -> Self {
        let mut values = vec![0.0; side.pow(states as u32)];
        values[0] = 1.0;
        HermiteTable { states, side, values }
    }

    /// The distance of neighbours along a state.
    pub(super) fn stride(&self, state: usize) -> usize {
        self.side.pow(state as u32)
    }

    /// The degree in a state of the coefficient at `index`.
    pub(super) fn degree(&self, index: usize, state: usize) -> usize {
        index / self.stride(state) % self.side
    }

    /// The sum of its degrees.
    pub(super) fn total(&self, index: usize) -> usize {
        (0..self.states).map(|state| self.degree(index, state)).sum()
    }

    /// z_i times this: z h_n = √(n+1) h_{n+1} + √n h_{n−1}, without what exceeds the table.
    fn times(&self, state: usize) -> Self {
        let stride = self.stride(state);
        let mut values = vec![0.0; self.values.len()];
        for (index, value) in self.values.iter().enumerate().filter(|(_, value)| **value != 0.0) {
            let degree = self.degree(index, state);
            if degree + 1 < self.side {
                values[index + stride] += value * ((degree + 1) as f64).sqrt();
            }
            if degree > 0 {
                values[index - stride] += value * (degree as f64).sqrt();
            }
        }
        HermiteTable { values, ..*self }
    }

    /// Adds `factor` times another.
    pub(super) fn add(&mut self, factor: f64, other: &Self) {
        self.values.iter_mut().zip(&other.values).for_each(|(to, from)| *to += factor * from);
    }
}

/// Products of one table with monomials of z, each made from another.
pub(super) struct HermiteProducts {
    known: HashMap<Vec<u32>, HermiteTable>,
}

impl HermiteProducts {
    pub(super) fn of(table: HermiteTable) -> Self {
        HermiteProducts { known: HashMap::from([(vec![0; table.states], table)]) }
    }

    /// The table times a polynomial of z.
    pub(super) fn with(&mut self, polynomial: &Polynomial) -> HermiteTable {
        let zero = &self.known[&vec![0; polynomial.dimension()]];
        let mut sum = HermiteTable { values: vec![0.0; zero.values.len()], ..*zero };
        for (alpha, c) in polynomial.terms() {
            self.prepare(alpha);
            sum.add(c, &self.known[alpha]);
        }
        sum
    }

    fn prepare(&mut self, alpha: &[u32]) {
        let Some(state) = alpha.iter().position(|power| *power > 0) else { return };
        if self.known.contains_key(alpha) {
            return;
        }
        let mut lower = alpha.to_vec();
        lower[state] -= 1;
        self.prepare(&lower);
        let product = self.known[&lower].times(state);
        self.known.insert(alpha.to_vec(), product);
    }
}

/// h₀ … of one variable, `count` of them.
pub(super) fn hermite(z: f64, count: usize) -> Vec<f64> {
    let mut all = vec![1.0, z];
    for n in 2..count {
        all.push((z * all[n - 1] - ((n - 1) as f64).sqrt() * all[n - 2]) / (n as f64).sqrt());
    }
    all.truncate(count);
    all
}
