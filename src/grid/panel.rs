//! Unknowns that are eliminated together, from the rows of those that follow.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::lu::partial_pivoting::factor::{lu_in_place, lu_in_place_scratch};
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_unit_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::{Accum, ColMut, ColRef, Mat, Par};

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

    /// L⁻¹P of the own unknowns' right side, which is taken from that of the others.
    pub(super) fn eliminated(&self, own: &[f64], following: &mut [f64]) -> Vec<f64> {
        let mut solved: Vec<f64> = self.rows.iter().map(|row| own[*row]).collect();
        let (factors, below) = self.lower.as_ref().split_at_row(own.len());
        solve_unit_lower_triangular_in_place(factors, ColMut::from_slice_mut(&mut solved).as_mat_mut(), Par::Seq);
        let (solution, following) = (ColRef::from_slice(&solved), ColMut::from_slice_mut(following));
        matmul(following.as_mat_mut(), Accum::Add, below, solution.as_mat(), -1.0, Par::Seq);
        solved
    }

    /// The own unknowns after the others, of which `own` has what [`Panel::eliminated`] returns.
    pub(super) fn substituted(&self, mut own: Vec<f64>, following: &[f64]) -> Vec<f64> {
        let mut column = ColMut::from_slice_mut(&mut own).as_mat_mut();
        let following = ColRef::from_slice(following).as_mat();
        matmul(column.as_mut(), Accum::Add, self.upper.as_ref(), following, -1.0, Par::Seq);
        solve_upper_triangular_in_place(self.lower.as_ref().subrows(0, self.rows.len()), column, Par::Seq);
        own
    }
}
