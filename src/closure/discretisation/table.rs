use crate::closure::space::Functions;
use crate::fokker_planck::Local;
use crate::states::States;
use faer::Mat;
use rayon::prelude::*;

/// The values of functions at points, with their mean rates of change: one row a point, one column a function.
#[derive(Clone, Debug)]
pub(in crate::closure) struct Table {
    /// 1, φ₁ … φ_K.
    pub(in crate::closure) values: Mat<f64>,
    /// 0, Gφ₁ … Gφ_K.
    pub(in crate::closure) rates: Mat<f64>,
}

impl Table {
    /// Tabulates functions under the generator, whose coefficients at the points are `locals`.
    pub(in crate::closure) fn new(space: &Functions, points: &States, locals: &[Local]) -> Self {
        let columns = space.len() + 1;
        let (mut values, mut rates) = (vec![1.0; points.len() * columns], vec![0.0; points.len() * columns]);
        let rows = values.par_chunks_mut(columns).zip(rates.par_chunks_mut(columns));
        rows.zip(points.par_iter()).zip(locals).for_each(|(((values, rates), x), local)| {
            space.rates(x, (&local.drift, &local.diffusion), &mut values[1..], &mut rates[1..]);
        });
        Table { values: by_rows(&values, columns), rates: by_rows(&rates, columns) }
    }

    /// The table with one more row for each impact: a function's values are those before, and its rate is its jump.
    pub(in crate::closure) fn with_impacts(&self, before: &Mat<f64>, after: &Mat<f64>) -> Self {
        let (interior, columns) = (self.values.nrows(), self.values.ncols());
        let joined = |inside: &Mat<f64>, beyond: &dyn Fn(usize, usize) -> f64| {
            let entry = |i: usize, k: usize| if i < interior { inside[(i, k)] } else { beyond(i - interior, k) };
            Mat::from_fn(interior + before.nrows(), columns, entry)
        };
        Table {
            values: joined(&self.values, &|i, k| before[(i, k)]),
            rates: joined(&self.rates, &|i, k| after[(i, k)] - before[(i, k)]),
        }
    }
}

/// 1, φ₁ … φ_K at some points: one row a point.
pub(in crate::closure) fn values(space: &Functions, points: &States) -> Mat<f64> {
    let columns = space.len() + 1;
    let mut rows = vec![1.0; points.len() * columns];
    rows.par_chunks_mut(columns).zip(points.par_iter()).for_each(|(row, x)| space.values(x, &mut row[1..]));
    by_rows(&rows, columns)
}

fn by_rows(rows: &[f64], columns: usize) -> Mat<f64> {
    Mat::from_fn(rows.len() / columns, columns, |i, k| rows[i * columns + k])
}
