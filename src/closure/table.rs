use super::space::{Local, Space};
use crate::FokkerPlanck;
use faer::Mat;
use rayon::prelude::*;

/// The values of functions at points, with their mean rates of change: one row a point, one column a function.
#[derive(Clone, Debug)]
pub(super) struct Table {
    /// 1, φ₁ … φ_K.
    pub(super) values: Mat<f64>,
    /// 0, Gφ₁ … Gφ_K.
    pub(super) rates: Mat<f64>,
}

impl Table {
    /// Tabulates a space under the generator of `operator`.
    pub(super) fn new<const N: usize>(space: &dyn Space<N>, operator: &FokkerPlanck<N>, points: &[[f64; N]]) -> Self {
        let columns = space.len() + 1;
        let rows: Vec<(Vec<f64>, Vec<f64>)> = points
            .par_iter()
            .map(|x| {
                let (mut values, mut rates) = (vec![1.0; columns], vec![0.0; columns]);
                space.rates(x, &local(operator, x), &mut values[1..], &mut rates[1..]);
                (values, rates)
            })
            .collect();
        Table {
            values: Mat::from_fn(points.len(), columns, |i, k| rows[i].0[k]),
            rates: Mat::from_fn(points.len(), columns, |i, k| rows[i].1[k]),
        }
    }
}

impl Table {
    /// The table with the rows of impacts made one: after `interior` rows there are `count` of the states before and
    /// `count` of those after; a function's values are those before, and its rate becomes its jump.
    pub(super) fn with_passages(&self, interior: usize, count: usize) -> Self {
        let columns = self.values.ncols();
        let rates = |i: usize, k: usize| {
            if i < interior { self.rates[(i, k)] } else { self.values[(i + count, k)] - self.values[(i, k)] }
        };
        Table {
            values: self.values.get(..interior + count, ..).to_owned(),
            rates: Mat::from_fn(interior + count, columns, rates),
        }
    }
}

/// Itô drift and diffusion at a point.
pub(super) fn local<const N: usize>(operator: &FokkerPlanck<N>, x: &[f64; N]) -> Local<N> {
    Local {
        drift: operator.drift().each_ref().map(|f| f.evaluate(x)),
        diffusion: operator.diffusion().each_ref().map(|row| row.each_ref().map(|b| b.evaluate(x))),
    }
}
