//! LU factors of block matrices by fronts: the multifrontal method (I. S. Duff and J. K. Reid, 1983,
//! doi:10.1145/356044.356047).
//!
//! The dissection of the mesh is a tree of fronts. Each has elements of its own, and a boundary: what these and the elements of the
//! parts below are coupled with outside. Its dense matrix is the sum of the blocks that couple the own elements and of what the parts
//! leave to it; what it leaves goes to the front above. Pivots are chosen among the rows of a front's own elements, so that factors
//! fill where those of the coupled elements do, whatever the pivots. That is safe here: probability gets out of every group of
//! elements in the end. What it costs in digits shows in the residual that every stationary solution carries.

use super::dissection::Front;
use super::panel::Panel;
use faer::Mat;

/// Parts with fewer elements than this together are not worth tasks of their own.
const TASK: usize = 16;

/// A matrix of square blocks of one size, by columns of blocks: the row of each block, rising, and the block.
#[derive(Debug)]
pub(super) struct BlockMatrix {
    pub(super) block: usize,
    pub(super) columns: Vec<Vec<(usize, Mat<f64>)>>,
}

/// The factors of a front and of all below it.
#[derive(Debug)]
pub(super) struct Factored {
    parts: Vec<Factored>,
    panel: Panel,
}

impl Factored {
    /// The factors of a matrix that couples no elements but those that the dissection was made for.
    pub(super) fn new(front: &Front, matrix: &BlockMatrix) -> Self {
        factored(front, matrix).0
    }

    /// Solves for `x`, the right side before, of `block` unknowns per element.
    pub(super) fn solve(&self, front: &Front, block: usize, x: &mut [f64]) {
        self.eliminate(front, block, x);
        self.substitute(front, block, x);
    }

    /// Eliminates the own unknowns in their places of `x`, after those of the parts; what is left to the boundary.
    fn eliminate(&self, front: &Front, block: usize, x: &mut [f64]) -> Vec<f64> {
        let mut sum = gathered(&front.own, block, x);
        sum.resize((front.own.len() + front.boundary.len()) * block, 0.0);
        for (part, factored) in front.parts.iter().zip(&self.parts) {
            let left = factored.eliminate(part, block, x);
            for (place, left) in part.places.iter().zip(left.chunks_exact(block)) {
                sum[place * block..][..block].iter_mut().zip(left).for_each(|(s, l)| *s += l);
            }
        }
        let mut left = sum.split_off(front.own.len() * block);
        scatter(&front.own, block, &self.panel.eliminated(&sum, &mut left), x);
        left
    }

    /// Puts the own unknowns in their places of `x`, and then those of the parts.
    fn substitute(&self, front: &Front, block: usize, x: &mut [f64]) {
        let [own, boundary] = [&front.own, &front.boundary].map(|elements| gathered(elements, block, x));
        scatter(&front.own, block, &self.panel.substituted(own, &boundary), x);
        front.parts.iter().zip(&self.parts).for_each(|(part, factored)| factored.substitute(part, block, x));
    }
}

fn gathered(elements: &[usize], block: usize, x: &[f64]) -> Vec<f64> {
    elements.iter().flat_map(|element| &x[element * block..][..block]).copied().collect()
}

fn scatter(elements: &[usize], block: usize, values: &[f64], x: &mut [f64]) {
    for (element, values) in elements.iter().zip(values.chunks_exact(block)) {
        x[element * block..][..block].copy_from_slice(values);
    }
}

/// The factors of a front and of all below it, and what it leaves to its boundary.
fn factored(front: &Front, matrix: &BlockMatrix) -> (Factored, Mat<f64>) {
    let below = |part: &Front| factored(part, matrix);
    let parts = match &front.parts[..] {
        [first, second] if front.below > TASK => {
            let (first, second) = rayon::join(|| below(first), || below(second));
            vec![first, second]
        }
        parts => parts.iter().map(below).collect(),
    };
    let mut sum = Sum::of(front, matrix);
    let add = |(part, (factored, left)): (&Front, (Factored, Mat<f64>))| {
        sum.add(&part.places, &left);
        factored
    };
    let parts = front.parts.iter().zip(parts).map(add).collect();
    let panel = Panel::new(sum.lower, sum.upper, &mut sum.following);
    (Factored { parts, panel }, sum.following)
}

/// The matrix of a front, the own elements first: F₁₁ with F₂₁ below it, F₁₂ and F₂₂.
struct Sum {
    block: usize,
    own: usize,
    lower: Mat<f64>,
    upper: Mat<f64>,
    following: Mat<f64>,
}

impl Sum {
    /// The blocks that couple own elements with each other and with the boundary. Those within the boundary are those of the
    /// fronts above.
    fn of(front: &Front, matrix: &BlockMatrix) -> Self {
        let (block, own, boundary) = (matrix.block, front.own.len(), front.boundary.len());
        let zeros = |rows: usize, columns: usize| Mat::zeros(rows * block, columns * block);
        let (lower, upper) = (zeros(own + boundary, own), zeros(own, boundary));
        let mut sum = Sum { block, own, lower, upper, following: zeros(boundary, boundary) };
        for (place, element) in front.own.iter().chain(&front.boundary).enumerate() {
            for (row, entries) in &matrix.columns[*element] {
                if let Some(row) = front.place(*row).filter(|row| place < own || *row < own) {
                    for j in 0..block {
                        sum.entries(row, place, j).copy_from_slice(entries.col_as_slice(j));
                    }
                }
            }
        }
        sum
    }

    /// Adds what a part leaves to elements at `places`.
    fn add(&mut self, places: &[usize], left: &Mat<f64>) {
        let block = self.block;
        for column in 0..left.ncols() {
            for (row, entries) in places.iter().zip(left.col_as_slice(column).chunks_exact(block)) {
                let target = self.entries(*row, places[column / block], column % block);
                target.iter_mut().zip(entries).for_each(|(t, e)| *t += e);
            }
        }
    }

    /// The rows of one element in column `j` of another.
    fn entries(&mut self, row: usize, column: usize, j: usize) -> &mut [f64] {
        let (part, row, column) = match (row.checked_sub(self.own), column.checked_sub(self.own)) {
            (_, None) => (&mut self.lower, row, column),
            (None, Some(column)) => (&mut self.upper, row, column),
            (Some(row), Some(column)) => (&mut self.following, row, column),
        };
        &mut part.col_as_slice_mut(column * self.block + j)[row * self.block..][..self.block]
    }
}
