//! Functions at many points: eight at a time, on all threads.

use super::{Functions, Jet};
use crate::numerics::{EIGHT, Eight, Number, stretches};
use crate::parallel;
use crate::states::States;
use faer::MatMut;
use pulp::{Arch, NullaryFnOnce};

/// Points that a thread takes at a time: their values of a hundred functions stay in a core's cache.
const STRETCH: usize = 128;

/// A function of the state.
pub(in crate::closure) trait Function: Sync {
    /// The value at a point, or at several.
    fn at<T: Number>(&self, x: &[T]) -> T;
}

/// A function with derivatives.
pub(in crate::closure) trait Differentiable: Sync {
    /// The value with its derivatives at a point, or at several.
    fn jet<T: Number>(&self, x: &[T], jet: &mut Jet<T>);
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

/// What `of` makes of each point's number and of the gradient and the Hessian, by rows, of a function there.
pub(in crate::closure) fn at_jets<R: Send>(
    function: &impl Differentiable,
    points: &States,
    of: impl Fn(usize, &[f64], &[f64]) -> R + Sync,
) -> Vec<R> {
    let stretch = |run: usize| {
        let points = Points::run(points, run);
        let mut all = Vec::with_capacity(points.len());
        let mut visit = |i: usize, gradient: &[f64], hessian: &[f64]| {
            all.push(of(run * STRETCH + i, gradient, hessian));
        };
        visit_jets(function, points, &mut visit);
        all
    };
    let parts: Vec<Vec<R>> = parallel::map(points.len().div_ceil(STRETCH), stretch);
    parts.into_iter().flatten().collect()
}

/// What is called with the number, the gradient and the Hessian of each point.
type JetVisit<'a> = &'a mut dyn FnMut(usize, &[f64], &[f64]);

/// Not inlined, so that the derivatives are compiled once and not for each use of them.
#[inline(never)]
fn visit_jets(function: &impl Differentiable, points: Points<'_>, visit: JetVisit<'_>) {
    Arch::new().dispatch(JetSweep { function, points, visit });
}

/// A stretch of points, state after state.
#[derive(Clone, Copy)]
struct Points<'a> {
    from: &'a [f64],
    states: usize,
}

impl<'a> Points<'a> {
    /// A run of the points.
    fn run(points: &'a States, run: usize) -> Self {
        Points { from: points.run(run, STRETCH), states: points.dimension() }
    }

    fn len(&self) -> usize {
        self.from.len() / self.states
    }

    /// Eight points from `first` on; the last one takes the place of those that are missing.
    #[inline(always)]
    fn place(&self, first: usize, x: &mut [Eight]) {
        let last = self.len() - 1;
        for (i, x) in x.iter_mut().enumerate() {
            *x = Eight::from_points(|l| self.from[(first + l).min(last) * self.states + i]);
        }
    }
}

const ZERO: Eight = Eight([0.0; EIGHT]);
const ONE: Eight = Eight([1.0; EIGHT]);

struct ValueSweep<'a, F> {
    function: &'a F,
    points: Points<'a>,
    to: &'a mut [f64],
}

impl<F: Function> NullaryFnOnce for ValueSweep<'_, F> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let mut x = vec![ZERO; self.points.states];
        for (group, to) in self.to.chunks_mut(EIGHT).enumerate() {
            self.points.place(group * EIGHT, &mut x);
            let values = self.function.at(&x);
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
        let (mut x, mut values) = (vec![ZERO; self.points.states], vec![ZERO; self.space.len()]);
        let mut sums = values.clone();
        for first in (0..self.points.len()).step_by(EIGHT) {
            self.points.place(first, &mut x);
            self.space.values(&x, &mut values);
            let used = EIGHT.min(self.points.len() - first);
            for (sum, value) in sums.iter_mut().zip(&values) {
                for l in 0..used {
                    sum.0[l] += value.0[l];
                }
            }
        }
        sums.iter().map(|sum| sum.0.iter().sum()).collect()
    }
}

/// Enters functions at eight points into the rows of a table from `first` on, as far as it has them.
#[inline(always)]
fn enter(table: &mut MatMut<'_, f64>, first: usize, functions: &[Eight]) {
    let used = EIGHT.min(table.nrows() - first);
    for (k, values) in functions.iter().enumerate() {
        if let Some(column) = table.as_mut().col_mut(k).try_as_col_major_mut() {
            column.as_slice_mut()[first..first + used].copy_from_slice(&values.0[..used]);
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
        let (mut x, mut values) = (vec![ZERO; self.points.states], vec![ONE; self.space.len() + 1]);
        for first in (0..self.points.len()).step_by(EIGHT) {
            self.points.place(first, &mut x);
            self.space.values(&x, &mut values[1..]);
            enter(&mut self.table, first, &values);
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
        let (states, columns) = (self.points.states, self.space.len() + 1);
        let (mut x, mut drift, mut diffusion) = (vec![ZERO; states], vec![ZERO; states], vec![ZERO; states * states]);
        let (mut values, mut rates) = (vec![ONE; columns], vec![ZERO; columns]);
        for first in (0..self.points.len()).step_by(EIGHT) {
            self.points.place(first, &mut x);
            for l in 0..EIGHT {
                let (f, b) = (self.local)((first + l).min(self.points.len() - 1));
                drift.iter_mut().zip(f).for_each(|(to, f)| to.0[l] = *f);
                diffusion.iter_mut().zip(b).for_each(|(to, b)| to.0[l] = *b);
            }
            self.space.rates(&x, (&drift, &diffusion), &mut values[1..], &mut rates[1..]);
            enter(&mut self.values, first, &values);
            enter(&mut self.rates, first, &rates);
        }
    }
}

struct JetSweep<'a, F> {
    function: &'a F,
    points: Points<'a>,
    visit: JetVisit<'a>,
}

impl<F: Differentiable> NullaryFnOnce for JetSweep<'_, F> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let states = self.points.states;
        let (mut x, mut jet) = (vec![ZERO; states], Jet::zero(states));
        let (mut gradient, mut hessian) = (vec![0.0; states], vec![0.0; states * states]);
        for first in (0..self.points.len()).step_by(EIGHT) {
            self.points.place(first, &mut x);
            self.function.jet(&x, &mut jet);
            for l in 0..EIGHT.min(self.points.len() - first) {
                gradient.iter_mut().zip(&jet.gradient).for_each(|(to, from)| *to = from.0[l]);
                hessian.iter_mut().zip(&jet.hessian).for_each(|(to, from)| *to = from.0[l]);
                (self.visit)(first + l, &gradient, &hessian);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop")]
    use super::*;
    use crate::closure::density::exponent::Exponent;
    use crate::closure::space::{Corner, Polynomials, WallLevel};
    use crate::problem::Wall;
    use faer::Mat;

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

    /// The same bits as at single points, for a number of points that is neither one of stretches nor one of eights.
    #[test]
    fn sweeps_agree_with_single_points() {
        let mut points = States::new(2);
        (0..2 * STRETCH + 13).for_each(|i| points.push(&[1.0 + 1.4 * (i as f64).sin(), 3.0 * (0.3 * i as f64).cos()]));
        for exponent in exponents() {
            let (space, count) = (&exponent.space, exponent.space.len());
            let found = values(&exponent, &points);
            let jets = at_jets(&exponent, &points, |i, gradient, hessian| (i, gradient.to_vec(), hessian.to_vec()));
            let mut tables = [(); 3].map(|()| Mat::zeros(points.len(), count + 1));
            let [table, beside, rates] = &mut tables;
            tabulate(space, &points, table.as_mut());
            let local: (&[f64], &[f64]) = (&[0.4, -0.9], &[0.5, 0.1, 0.1, 0.8]);
            tabulate_rates(space, &points, &|_| local, [beside.as_mut(), rates.as_mut()]);
            let (mut single, mut single_rates) = (vec![0.0; count], vec![0.0; count]);
            let mut jet = Jet::zero(2);
            for (i, x) in points.iter().enumerate() {
                assert_eq!(found[i].to_bits(), exponent.value(x).to_bits(), "{x:?}");
                exponent.jet(x, &mut jet);
                assert_eq!(jets[i], (i, jet.gradient.clone(), jet.hessian.clone()), "{x:?}");
                space.rates(x, local, &mut single, &mut single_rates);
                assert!((0..count).all(|k| beside[(i, k + 1)] == single[k] && rates[(i, k + 1)] == single_rates[k]));
                space.values(x, &mut single);
                assert!((0..count).all(|k| table[(i, k + 1)] == single[k]), "{x:?}");
                assert_eq!([table[(i, 0)], beside[(i, 0)], rates[(i, 0)]], [1.0, 1.0, 0.0]);
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
