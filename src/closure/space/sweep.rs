//! Functions at many points: eight at a time, on all threads.

use crate::functions::{Functions, Scratch};
use crate::numerics::{EIGHT, Eight, Number, stretches};
use crate::parallel;
use crate::states::States;
use faer::{Mat, MatMut};
use pulp::{Arch, NullaryFnOnce};
use std::ops::Range;

/// Points that a thread takes at a time: their values of a hundred functions stay in a core's cache.
pub(in crate::closure) const STRETCH: usize = 128;

/// A function of the state.
pub(in crate::closure) trait Function: Sync {
    /// The value at a point, or at several.
    fn at<T: Number>(&self, x: &[T], scratch: &mut Scratch<T>) -> T;
}

/// A function at some points.
pub(in crate::closure) fn values(function: &impl Function, points: &States) -> Vec<f64> {
    let mut values = vec![0.0; points.len()];
    parallel::on_runs(&mut values, STRETCH, |run, to| {
        let points = Points::run(points, run);
        Arch::new().dispatch(ValueSweep { function, points, to });
    });
    values
}

/// The sums of φ₁ … φ_K over some points.
pub(in crate::closure) fn sums(space: &Functions, points: &States) -> Vec<f64> {
    let mut sums = vec![0.0; space.len()];
    let stretch = |run| Arch::new().dispatch(SumSweep { space, points: Points::run(points, run) });
    let parts: Vec<Vec<f64>> = parallel::map(points.len().div_ceil(STRETCH), stretch);
    parts.iter().for_each(|part| sums.iter_mut().zip(part).for_each(|(sum, part)| *sum += part));
    sums
}

/// Fills `table` with 1, φ₁ … φ_K, one row a point.
pub(in crate::closure) fn tabulate(space: &Functions, points: &States, table: MatMut<'_, f64>) {
    parallel::map_into(stretches(table, STRETCH), |run, table| {
        Arch::new().dispatch(TableSweep { space, points: Points::run(points, run), table });
    });
}

/// 1, φ₁ … φ_K at some states, one after the other in `x`, one row a state; on this thread.
pub(in crate::closure) fn rows(space: &Functions, states: usize, x: &[f64]) -> Mat<f64> {
    let mut table = Mat::zeros(x.len() / states, space.len() + 1);
    Arch::new().dispatch(TableSweep { space, points: Points { from: x, states }, table: table.as_mut() });
    table
}

/// Fills `values` with 1, φ₁ … φ_K and `rates` with their mean rates of change f·∇φ + ½ B:∇∇φ, one row a point; `local` gives f
/// and B, by rows, at a point.
pub(in crate::closure) fn tabulate_rates<'a>(
    space: &Functions,
    points: &States,
    local: &(dyn Fn(usize) -> (&'a [f64], &'a [f64]) + Sync),
    [values, rates]: [MatMut<'_, f64>; 2],
) {
    let [values, rates] = [values, rates].map(|table| stretches(table, STRETCH));
    parallel::map_into(values.into_iter().zip(rates).collect(), |run, (values, rates)| {
        let local = |i: usize| local(run * STRETCH + i);
        Arch::new().dispatch(Rates { space, points: Points::run(points, run), local: &local, values, rates });
    });
}

/// A stretch of points, state after state.
#[derive(Clone, Copy)]
pub(in crate::closure) struct Points<'a> {
    from: &'a [f64],
    pub(in crate::closure) states: usize,
}

impl<'a> Points<'a> {
    /// A run of the points.
    pub(in crate::closure) fn run(points: &'a States, run: usize) -> Self {
        Points { from: points.run(run, STRETCH), states: points.dimension() }
    }

    pub(in crate::closure) fn len(&self) -> usize {
        self.from.len() / self.states
    }

    /// The numbers of up to eight points from `first` on.
    fn rows(&self, first: usize) -> Range<usize> {
        first..self.len().min(first + EIGHT)
    }

    /// Eight points from `first` on; the last one takes the place of those that are missing.
    #[inline(always)]
    pub(in crate::closure) fn place(&self, first: usize, x: &mut [Eight]) {
        let last = self.len() - 1;
        for (i, x) in x.iter_mut().enumerate() {
            *x = Eight::from_points(|l| self.from[(first + l).min(last) * self.states + i]);
        }
    }
}

struct ValueSweep<'a, F> {
    function: &'a F,
    points: Points<'a>,
    to: &'a mut [f64],
}

impl<F: Function> NullaryFnOnce for ValueSweep<'_, F> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let (mut x, mut scratch) = (vec![Eight::ZERO; self.points.states], Scratch::default());
        for (group, to) in self.to.chunks_mut(EIGHT).enumerate() {
            self.points.place(group * EIGHT, &mut x);
            let values = self.function.at(&x, &mut scratch);
            to.copy_from_slice(&values.0[..to.len()]);
        }
    }
}

struct SumSweep<'a> {
    space: &'a Functions,
    points: Points<'a>,
}

impl NullaryFnOnce for SumSweep<'_> {
    type Output = Vec<f64>;

    #[inline(always)]
    fn call(self) -> Vec<f64> {
        let (mut x, mut scratch) = (vec![Eight::ZERO; self.points.states], Scratch::default());
        let mut sums = vec![Eight::ZERO; self.space.len()];
        for first in (0..self.points.len()).step_by(EIGHT) {
            self.points.place(first, &mut x);
            self.space.place_values(&x, &mut scratch);
            let used = EIGHT.min(self.points.len() - first);
            for (k, sum) in sums.iter_mut().enumerate() {
                let value = self.space.value(&scratch, k + 1);
                (0..used).for_each(|l| sum[l] += value[l]);
            }
        }
        sums.iter().map(|sum| sum.0.iter().sum()).collect()
    }
}

/// Writes what each column has at up to eight points into rows of a table, which is by columns.
#[inline(always)]
pub(in crate::closure) fn enter(table: &mut MatMut<'_, f64>, rows: Range<usize>, of: impl Fn(usize) -> Eight) {
    // A loop of its own for eight: copies of a known length are a few instructions.
    if rows.len() == EIGHT {
        each_column(table, |k, column| column[rows.start..rows.start + EIGHT].copy_from_slice(&of(k).0));
    } else {
        each_column(table, |k, column| column[rows.clone()].copy_from_slice(&of(k).0[..rows.len()]));
    }
}

#[inline(always)]
fn each_column(table: &mut MatMut<'_, f64>, mut visit: impl FnMut(usize, &mut [f64])) {
    for k in 0..table.ncols() {
        if let Some(column) = table.as_mut().col_mut(k).try_as_col_major_mut() {
            visit(k, column.as_slice_mut());
        }
    }
}

struct TableSweep<'a> {
    space: &'a Functions,
    points: Points<'a>,
    table: MatMut<'a, f64>,
}

impl NullaryFnOnce for TableSweep<'_> {
    type Output = ();

    #[inline(always)]
    fn call(mut self) {
        let (mut x, mut scratch) = (vec![Eight::ZERO; self.points.states], Scratch::default());
        for first in (0..self.points.len()).step_by(EIGHT) {
            self.points.place(first, &mut x);
            self.space.place_values(&x, &mut scratch);
            enter(&mut self.table, self.points.rows(first), |k| self.space.value(&scratch, k));
        }
    }
}

struct Rates<'a, 'l> {
    space: &'a Functions,
    points: Points<'a>,
    local: &'a dyn Fn(usize) -> (&'l [f64], &'l [f64]),
    values: MatMut<'a, f64>,
    rates: MatMut<'a, f64>,
}

impl NullaryFnOnce for Rates<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn call(mut self) {
        let states = self.points.states;
        let (mut x, mut drift, mut diffusion) =
            (vec![Eight::ZERO; states], vec![Eight::ZERO; states], vec![Eight::ZERO; states * states]);
        let (mut coupled, mut scratch) = (Vec::with_capacity(states), Scratch::default());
        for first in (0..self.points.len()).step_by(EIGHT) {
            self.points.place(first, &mut x);
            for l in 0..EIGHT {
                let (f, b) = (self.local)((first + l).min(self.points.len() - 1));
                drift.iter_mut().zip(f).for_each(|(to, f)| to[l] = *f);
                diffusion.iter_mut().zip(b).for_each(|(to, b)| to[l] = *b);
            }
            enter_coupled(&diffusion, states, &mut coupled);
            self.space.place(&x, &mut scratch);
            self.space.apply((&drift, &diffusion), &coupled, &mut scratch);
            enter(&mut self.values, self.points.rows(first), |k| self.space.value(&scratch, k));
            enter(&mut self.rates, self.points.rows(first), |k| self.space.image(&scratch, k));
        }
    }
}

/// Lists the states i with some B_ij ≠ 0, j ≠ i.
#[inline(always)]
pub(in crate::closure) fn enter_coupled(diffusion: &[Eight], states: usize, coupled: &mut Vec<usize>) {
    let mixed = |i: usize| (0..states).any(|j| j != i && !diffusion[i * states + j].is_zero());
    coupled.clear();
    coupled.extend((0..states).filter(|i| mixed(*i)));
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop")]
    use super::*;
    use crate::closure::density::exponent::Exponent;
    use crate::closure::space::WallLevel;
    use crate::fokker_planck::Local;
    use crate::functions::{Corner, Polynomials};
    use crate::numerics::differences;
    use crate::walls::Wall;

    /// Polynomials, and functions next to two walls, with the singular part.
    fn exponents() -> [Exponent; 2] {
        let (centre, half_width) = (vec![1.0, 0.0], vec![1.5, 4.0]);
        let corners = [Wall::above(-0.5, 0.7), Wall::below(2.5, 0.9)];
        let corners = corners.map(|wall| Corner::new(wall.unwrap(), vec![1], 0.2, [3.0, 4.0])).to_vec();
        let levels = [WallLevel { degree: 4, kinks: 3, depth: 3, angular: 5, others: 0 }];
        let monomials = [[1, 0], [0, 2], [1, 1], [3, 2], [0, 5]].map(Vec::from).to_vec();
        let walls = Functions::in_a_plane(corners.clone(), (&centre, &half_width), &levels);
        let polynomials = Functions::from(Polynomials::new(centre, half_width, monomials));
        [(vec![], polynomials), (corners, walls)].map(|(known, space)| {
            let coefficients = (0..space.len()).map(|k| (0.7 * k as f64).sin()).collect();
            Exponent { known, space, constant: 0.3, coefficients }
        })
    }

    /// The same bits as at single points, for a number of points that is neither one of stretches nor one of eights; gradients and
    /// residuals are those of differences of Q, a sum of 58 functions: to the rounding of some ten over the step, 1e-12, and over its
    /// square, 1e-8. Measured are 4e-12 and 5e-9.
    #[test]
    fn sweeps_agree_with_single_points() {
        let mut points = States::new(2);
        (0..2 * STRETCH + 13).for_each(|i| points.push(&[1.0 + 1.4 * (i as f64).sin(), 3.0 * (0.3 * i as f64).cos()]));
        for exponent in exponents() {
            let (space, count) = (&exponent.space, exponent.space.len());
            let found = values(&exponent, &points);
            let mut tables = [(); 3].map(|()| Mat::zeros(points.len(), count + 1));
            let [table, beside, rates] = &mut tables;
            tabulate(space, &points, table.as_mut());
            let (f, b) = ([0.4, -0.9], [0.5, 0.1, 0.1, 0.8]);
            tabulate_rates(space, &points, &|_| (&f, &b), [beside.as_mut(), rates.as_mut()]);
            let mut local = Local::new(2);
            (local.drift, local.divergence) = (f.to_vec(), 0.7);
            local.diffusion.copy_from_slice(&b);
            let residuals = exponent.linearised(&points, |_| &local, |i, r, slope| (i, r, slope.to_vec()));
            let mut scratch = Scratch::default();
            for (i, x) in points.iter().enumerate() {
                assert_eq!(found[i].to_bits(), exponent.value(x).to_bits(), "{x:?}");
                space.place(x, &mut scratch);
                space.apply((&f, &b), &[0, 1], &mut scratch);
                let single = |k: usize| [space.value(&scratch, k), space.image(&scratch, k)];
                assert!((0..=count).all(|k| [beside[(i, k)], rates[(i, k)]] == single(k)), "{x:?}");
                assert!((0..=count).all(|k| table[(i, k)] == single(k)[0]), "{x:?}");
                assert_eq!([table[(i, 0)], rates[(i, 0)]], [1.0, 0.0]);
                let (slope, bend) = differences(|x| vec![exponent.value(x)], x, 3e-4).remove(0);
                let of_slopes = (0..2).map(|k| local.backward(k) * slope[k]).sum::<f64>();
                let bent = (0..4).map(|k| 0.5 * b[k] * (bend[k] + slope[k / 2] * slope[k % 2])).sum::<f64>();
                let r = local.source() + of_slopes + bent;
                let squares = slope.iter().map(|slope| slope * slope).sum::<f64>();
                let size = 1.0 + squares + bend.iter().map(|bend| bend.abs()).sum::<f64>();
                let off = (0..2).map(|k| (residuals[i].2[k] - slope[k]).abs()).fold(0.0, f64::max);
                assert_eq!(residuals[i].0, i);
                assert!((residuals[i].1 - r).abs() < 2e-8 * size, "{x:?}: {} and {r}", residuals[i].1);
                assert!(off < 1e-11 * size, "{x:?}: {off:e}");
                assert_eq!(exponent.gradient(x), residuals[i].2, "{x:?}");
            }
            // Sums of some hundred numbers.
            for (k, sum) in sums(space, &points).into_iter().enumerate() {
                let [direct, size] = (0..points.len()).fold([0.0; 2], |[direct, size]: [f64; 2], i| {
                    [direct + table[(i, k + 1)], size + table[(i, k + 1)].abs()]
                });
                assert!((sum - direct).abs() < 1e-14 * size, "{k}: {sum} and {direct}");
            }
        }
    }
}
