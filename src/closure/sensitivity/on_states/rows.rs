//! Functions at eight states, and their images under an operator, in rows of a table: in the widest registers of the processor.

use crate::functions::{Functions, ImpulseImages, Scratch};
use crate::numerics::Eight;
use faer::MatMut;
use pulp::NullaryFnOnce;
use std::ops::Range;

/// An operator b·∇ + ½ B:∇∇ with impulses: b and B, the states of its mixed parts, and the images under impulses.
pub(super) type OperatorParts<'s> = ((&'s [Eight], &'s [Eight]), &'s [usize], &'s ImpulseImages);

/// The functions, without the constant, at eight states, or their images under an operator, in rows of a table.
pub(super) struct Rows<'s> {
    pub(super) space: &'s Functions,
    pub(super) x: &'s [Eight],
    pub(super) operator: Option<OperatorParts<'s>>,
    pub(super) scratch: &'s mut Scratch<Eight>,
    pub(super) rows: &'s Range<usize>,
    pub(super) table: MatMut<'s, f64>,
}

impl NullaryFnOnce for Rows<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Rows { space, x, operator, scratch, rows, table } = self;
        match operator {
            None => {
                space.place_values(x, scratch);
                enter(rows, table, |k| space.value(scratch, 1 + k));
            }
            Some((operator, coupled, impulses)) => {
                space.place(x, scratch);
                space.apply(operator, coupled, scratch);
                enter(rows, table, |k| space.image_under(impulses, scratch, 1 + k));
            }
        }
    }
}

/// Writes the values for each column into rows of a table.
#[inline(always)]
pub(super) fn enter(rows: &Range<usize>, mut table: MatMut<'_, f64>, of: impl Fn(usize) -> Eight) {
    for k in 0..table.ncols() {
        let lane = of(k);
        let column = table.as_mut().col_mut(k).subrows_mut(rows.start, rows.len());
        column.iter_mut().zip(lane.0).for_each(|(entry, value)| *entry = value);
    }
}
