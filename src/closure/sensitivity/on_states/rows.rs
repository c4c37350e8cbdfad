//! Functions at eight states, and their images under an operator, in rows of a table: in the widest registers of the processor.

use crate::control_variates::impulses;
use crate::control_variates::products::{Lane, Products, Scratch};
use faer::MatMut;
use pulp::NullaryFnOnce;
use std::ops::Range;

/// The functions at eight states, in rows of a table.
pub(super) struct Values<'s> {
    pub(super) products: &'s Products,
    /// The function of the first column.
    pub(super) first: usize,
    pub(super) x: &'s [Lane],
    pub(super) scratch: &'s mut Scratch,
    pub(super) rows: &'s Range<usize>,
    pub(super) table: MatMut<'s, f64>,
}

impl NullaryFnOnce for Values<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.products.place_values(self.x, self.scratch);
        enter(self.rows, self.table, |k| self.products.value(self.scratch, self.first + k));
    }
}

/// The images of all functions but the constant under b·∇ + ½ B:∇∇ and impulses, where b is `first` of the scratch.
pub(super) struct Images<'s> {
    pub(super) products: &'s Products,
    pub(super) x: &'s [Lane],
    /// B, the states of its mixed parts, and the images under impulses.
    pub(super) operator: (&'s [Lane], &'s [usize], &'s impulses::Images),
    pub(super) scratch: &'s mut Scratch,
    pub(super) rows: &'s Range<usize>,
    pub(super) table: MatMut<'s, f64>,
}

impl NullaryFnOnce for Images<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let (second, coupled, impulses) = self.operator;
        self.products.place(self.x, self.scratch);
        self.products.apply(second, coupled, self.scratch);
        enter(self.rows, self.table, |k| self.products.image_under(impulses, self.scratch, 1 + k));
    }
}

/// Writes the values for each column into rows of a table.
#[inline(always)]
pub(super) fn enter(rows: &Range<usize>, mut table: MatMut<'_, f64>, of: impl Fn(usize) -> Lane) {
    for k in 0..table.ncols() {
        let lane = of(k);
        let column = table.as_mut().col_mut(k).subrows_mut(rows.start, rows.len());
        column.iter_mut().zip(lane).for_each(|(entry, value)| *entry = value);
    }
}
