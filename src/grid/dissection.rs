//! The order of elimination: nested dissection of the mesh (A. George, 1973, doi:10.1137/0710032).
//!
//! Two lines of elements divide the rest into halves that are not coupled. The halves are eliminated first, the lines last,
//! and so on within each half, so that factors fill only within lines. One line would do for the matrix A, but with row
//! exchanges factors fill like those of AᵀA, in which elements two apart are coupled.

use super::legendre::Axis;
use super::space::{Side, Space};

/// Pieces of this size are not divided.
const WHOLE: usize = 4;

/// All unknowns in the order of their elimination; none with a wall, which joins rows far apart and leaves no halves.
pub(super) fn elimination_order(space: &Space) -> Option<Vec<usize>> {
    if space.sides != [Side::Open, Side::Open] {
        return None;
    }
    let [columns, rows] = space.axes.each_ref().map(Axis::cells);
    let mut order = Vec::with_capacity(space.elements());
    dissect(space, [0, columns], [0, rows], &mut order);
    let block = space.block();
    Some(order.into_iter().flat_map(|element| element * block..(element + 1) * block).collect())
}

fn dissect(space: &Space, [i0, i1]: [usize; 2], [j0, j1]: [usize; 2], order: &mut Vec<usize>) {
    let (width, height) = (i1 - i0, j1 - j0);
    if width.max(height) <= WHOLE {
        order.extend((i0..i1).flat_map(|i| (j0..j1).map(move |j| space.element(i, j))));
    } else if width >= height {
        let middle = i0 + (width - 2) / 2;
        dissect(space, [i0, middle], [j0, j1], order);
        dissect(space, [middle + 2, i1], [j0, j1], order);
        dissect(space, [middle, middle + 2], [j0, j1], order);
    } else {
        let middle = j0 + (height - 2) / 2;
        dissect(space, [i0, i1], [j0, middle], order);
        dissect(space, [i0, i1], [middle + 2, j1], order);
        dissect(space, [i0, i1], [middle, middle + 2], order);
    }
}
