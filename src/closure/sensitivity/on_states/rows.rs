//! Functions at eight states, and their images under an operator, in rows of a table: in the widest registers of the processor.

use crate::control_variates::impulses::ImpulseImages;
use crate::control_variates::products::{Products, Scratch};
use crate::numerics::PointLane;
use faer::MatMut;
use pulp::NullaryFnOnce;
use std::ops::Range;

/// An operator b·∇ + ½ B:∇∇ with impulses: B, the states of its mixed parts, and the images under impulses; b is `first` of the scratch.
pub(super) type OperatorParts<'s> = (&'s [PointLane], &'s [usize], &'s ImpulseImages);

/// The functions from `first` on at eight states, or their images under an operator, in rows of a table.
pub(super) struct Rows<'s> {
    pub(super) products: &'s Products,
    pub(super) first: usize,
    pub(super) x: &'s [PointLane],
    pub(super) operator: Option<OperatorParts<'s>>,
    pub(super) scratch: &'s mut Scratch,
    pub(super) rows: &'s Range<usize>,
    pub(super) table: MatMut<'s, f64>,
}

impl NullaryFnOnce for Rows<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Rows { products, first, x, operator, scratch, rows, table } = self;
        match operator {
            None => {
                products.place_values(x, scratch);
                enter(rows, table, |k| products.value(scratch, first + k));
            }
            Some((second, coupled, impulses)) => {
                products.place(x, scratch);
                products.apply(second, coupled, scratch);
                enter(rows, table, |k| products.image_under(impulses, scratch, first + k));
            }
        }
    }
}

/// Writes the values for each column into rows of a table.
#[inline(always)]
pub(super) fn enter(rows: &Range<usize>, mut table: MatMut<'_, f64>, of: impl Fn(usize) -> PointLane) {
    for k in 0..table.ncols() {
        let lane = of(k);
        let column = table.as_mut().col_mut(k).subrows_mut(rows.start, rows.len());
        column.iter_mut().zip(lane).for_each(|(entry, value)| *entry = value);
    }
}
