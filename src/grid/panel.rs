//! Unknowns that are eliminated together, from the rows of those that follow.

use super::columns::{AT_ONCE, add_columns};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::lu::partial_pivoting::factor::{lu_in_place, lu_in_place_scratch};
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_unit_lower_triangular_in_place};
use faer::{Accum, Mat, Par};
use pulp::{Arch, NullaryFnOnce};

/// The factors of
///
/// ⎡ F₁₁ F₁₂ ⎤   own unknowns
/// ⎣ F₂₁ F₂₂ ⎦   those that follow
///
/// with F₁₁ = P⁻¹LU. Pivots are chosen among the own rows.
#[derive(Debug)]
pub(super) struct Panel {
    /// The row of F₁₁ in each row of LU.
    rows: Vec<usize>,
    /// L and U in one, F₂₁U⁻¹ below them.
    lower: Mat<f64>,
    /// L⁻¹PF₁₂.
    upper: Mat<f64>,
}

impl Panel {
    /// Of no unknowns, before so many that follow.
    pub(super) fn empty(following: usize) -> Self {
        Panel { rows: Vec::new(), lower: Mat::zeros(following, 0), upper: Mat::zeros(0, following) }
    }

    /// Of F₁₁ with F₂₁ below it and of F₁₂. F₂₂ becomes F₂₂ − F₂₁F₁₁⁻¹F₁₂.
    pub(super) fn new(mut lower: Mat<f64>, mut upper: Mat<f64>, following: &mut Mat<f64>) -> Self {
        let size = upper.nrows();
        let (mut factors, mut below) = lower.as_mut().split_at_row_mut(size);
        let [mut rows, mut inverse] = [0, 1].map(|_| vec![0_usize; size]);
        let mut memory = MemBuffer::new(lu_in_place_scratch::<usize, f64>(size, size, Par::Seq, Default::default()));
        let stack = MemStack::new(&mut memory);
        lu_in_place(factors.as_mut(), &mut rows, &mut inverse, Par::Seq, stack, Default::default());
        let mut before = vec![0.0; size];
        for k in 0..upper.ncols() {
            let column = upper.col_as_slice_mut(k);
            before.copy_from_slice(column);
            column.iter_mut().zip(&rows).for_each(|(entry, row)| *entry = before[*row]);
        }
        solve_unit_lower_triangular_in_place(factors.as_ref(), upper.as_mut(), Par::Seq);
        solve_lower_triangular_in_place(factors.as_ref().transpose(), below.as_mut().transpose_mut(), Par::Seq);
        matmul(following.as_mut(), Accum::Add, below.as_ref(), upper.as_ref(), -1.0, Par::Seq);
        Panel { rows, lower, upper }
    }

    /// Makes L⁻¹P of the own unknowns' right side of it, which is taken from that of the others.
    pub(super) fn eliminate(&self, own: &mut [f64], following: &mut [f64]) {
        let mut all: Vec<f64> = self.rows.iter().map(|row| own[*row]).collect();
        all.extend_from_slice(following);
        Arch::new().dispatch(Elimination { panel: self, all: &mut all });
        own.copy_from_slice(&all[..own.len()]);
        following.copy_from_slice(&all[own.len()..]);
    }

    /// The own unknowns after the others, in the place of what [`Panel::eliminate`] makes.
    pub(super) fn substitute(&self, own: &mut [f64], following: &[f64]) {
        Arch::new().dispatch(Substitution { panel: self, own, following });
    }
}

struct Elimination<'a> {
    panel: &'a Panel,
    all: &'a mut [f64],
}

impl NullaryFnOnce for Elimination<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Elimination { panel: Panel { rows, lower, .. }, all } = self;
        for first in (0..rows.len()).step_by(AT_ONCE) {
            let end = (first + AT_ONCE).min(rows.len());
            for k in first..end {
                let column = lower.col_as_slice(k);
                (k + 1..end).for_each(|i| all[i] -= all[k] * column[i]);
            }
            let (known, rest) = all.split_at_mut(end);
            add_columns(rest, lower, [end, first], -1.0, &known[first..]);
        }
    }
}

struct Substitution<'a> {
    panel: &'a Panel,
    own: &'a mut [f64],
    following: &'a [f64],
}

impl NullaryFnOnce for Substitution<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Substitution { panel: Panel { lower, upper, .. }, own, following } = self;
        for (k, x) in following.chunks(AT_ONCE).enumerate() {
            add_columns(own, upper, [0, k * AT_ONCE], -1.0, x);
        }
        for first in (0..own.len()).step_by(AT_ONCE).rev() {
            let end = (first + AT_ONCE).min(own.len());
            for k in (first..end).rev() {
                let column = lower.col_as_slice(k);
                own[k] /= column[k];
                (first..k).for_each(|i| own[i] -= own[k] * column[i]);
            }
            let (rest, known) = own.split_at_mut(first);
            add_columns(rest, lower, [0, first], -1.0, &known[..end - first]);
        }
    }
}
