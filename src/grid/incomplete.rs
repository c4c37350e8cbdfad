//! A matrix of blocks of equal size in sparse rows, and its incomplete factors L U on the same places (J. A. Meijerink and H. A. van der
//! Vorst, 1977, doi:10.1090/S0025-5718-1977-0438681-4).

use super::columns::add_combination;
use crate::parallel;
use faer::Mat;
use faer::linalg::solvers::Solve;
use pulp::{Arch, NullaryFnOnce};

/// Rows whose products are one task.
const ROWS: usize = 32;

/// The places of blocks: by row the columns, rising.
#[derive(Debug)]
pub(super) struct BlockPlaces {
    /// The unknowns of a row.
    pub(super) size: usize,
    /// The first block of each row, and the end of all.
    starts: Vec<usize>,
    columns: Vec<usize>,
}

impl BlockPlaces {
    pub(super) fn new(size: usize, rows: &[Vec<usize>]) -> Self {
        let mut starts = vec![0];
        rows.iter().for_each(|row| starts.push(starts[starts.len() - 1] + row.len()));
        BlockPlaces { size, starts, columns: rows.concat() }
    }

    pub(super) fn rows(&self) -> usize {
        self.starts.len() - 1
    }

    /// The numbers of a row's blocks.
    pub(super) fn row(&self, row: usize) -> std::ops::Range<usize> {
        self.starts[row]..self.starts[row + 1]
    }

    fn columns(&self, row: usize) -> &[usize] {
        &self.columns[self.row(row)]
    }

    fn block<'a, T>(&self, blocks: &'a [T], number: usize) -> &'a [T] {
        let length = self.size * self.size;
        &blocks[number * length..][..length]
    }
}

/// The matrix.
#[derive(Debug)]
pub(super) struct BlockRows {
    pub(super) places: BlockPlaces,
    /// Each block by columns.
    blocks: Vec<f64>,
}

impl BlockRows {
    /// `add` adds to the blocks of a row, by columns, in the order of the row's columns.
    pub(super) fn new(places: BlockPlaces, add: impl Fn(usize, &[usize], &mut [f64]) + Sync) -> Self {
        let length = places.size * places.size;
        let mut blocks = vec![0.0; places.columns.len() * length];
        let (mut rest, mut rows) = (&mut blocks[..], Vec::with_capacity(places.rows()));
        for row in 0..places.rows() {
            let (own, others) = rest.split_at_mut(places.columns(row).len() * length);
            rows.push(own);
            rest = others;
        }
        parallel::map_into(rows, |row, own| add(row, places.columns(row), own));
        BlockRows { places, blocks }
    }

    /// The product with a vector.
    pub(super) fn product(&self, x: &[f64]) -> Vec<f64> {
        let all: Vec<usize> = (0..self.places.size).collect();
        self.product_with(&all, x)
    }

    /// The product with a vector of which only the entries `of` of each row are not 0, which is given by them.
    pub(super) fn product_with(&self, of: &[usize], x: &[f64]) -> Vec<f64> {
        let BlockPlaces { size, .. } = self.places;
        let mut product = vec![0.0; self.places.rows() * size];
        parallel::on_runs(&mut product, ROWS * size, |run, part| {
            Arch::new().dispatch(RowProducts { matrix: self, first: run * ROWS, of, x, product: part });
        });
        product
    }
}

struct RowProducts<'a> {
    matrix: &'a BlockRows,
    first: usize,
    of: &'a [usize],
    x: &'a [f64],
    product: &'a mut [f64],
}

impl NullaryFnOnce for RowProducts<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let RowProducts { matrix: BlockRows { places, blocks }, first, of, x, product } = self;
        for (k, own) in product.chunks_exact_mut(places.size).enumerate() {
            for number in places.row(first + k) {
                let part = &x[places.columns[number] * of.len()..][..of.len()];
                add_block(own, places.block(blocks, number), of, 1.0, part);
            }
        }
    }
}

/// Adds a multiple of Σ_k x_k times the column `of`\[k\] of a block.
#[inline(always)]
fn add_block<T: Copy + Into<f64>>(sum: &mut [f64], block: &[T], of: &[usize], factor: f64, x: &[f64]) {
    let size = sum.len();
    add_combination(sum, |k| &block[of[k] * size..][..size], factor, x);
}

/// The factors of a matrix without fill, rounded to single precision: as a preconditioner that is enough.
#[derive(Debug)]
pub(super) struct Incomplete {
    all: Vec<usize>,
    /// L below the diagonal, whose own blocks are 1, and U above it.
    blocks: Vec<f32>,
    /// The inverses of the diagonal blocks of U.
    inverses: Vec<f32>,
}

impl Incomplete {
    pub(super) fn new(matrix: &BlockRows) -> Self {
        let BlockRows { places, blocks } = matrix;
        let (size, length) = (places.size, places.size * places.size);
        let all: Vec<usize> = (0..size).collect();
        let mut factors =
            Incomplete { all, blocks: vec![0.0; blocks.len()], inverses: vec![0.0; places.rows() * length] };
        let mut found = vec![usize::MAX; places.rows()];
        for row in 0..places.rows() {
            let numbers = places.row(row);
            let mut own = blocks[numbers.start * length..numbers.end * length].to_vec();
            let columns = places.columns(row);
            columns.iter().enumerate().for_each(|(place, column)| found[*column] = place);
            Arch::new().dispatch(Elimination { factors: &factors, places, row, own: &mut own, found: &found });
            columns.iter().for_each(|column| found[*column] = usize::MAX);
            let diagonal = columns.partition_point(|column| *column < row);
            let block = Mat::from_fn(size, size, |i, j| own[diagonal * length + j * size + i]);
            let inverse = block.partial_piv_lu().solve(Mat::<f64>::identity(size, size));
            for j in 0..size {
                let target = &mut factors.inverses[row * length + j * size..][..size];
                target.iter_mut().zip(inverse.col_as_slice(j)).for_each(|(target, value)| *target = *value as f32);
            }
            let target = &mut factors.blocks[numbers.start * length..numbers.end * length];
            target.iter_mut().zip(&own).for_each(|(target, value)| *target = *value as f32);
        }
        factors
    }

    /// U⁻¹L⁻¹ times a vector, in its place.
    pub(super) fn solve(&self, places: &BlockPlaces, x: &mut [f64]) {
        Arch::new().dispatch(IncompleteSolution { factors: self, places, x });
    }
}

/// Takes from a row the multiples of those before that make its blocks below the diagonal 0.
struct Elimination<'a> {
    factors: &'a Incomplete,
    places: &'a BlockPlaces,
    row: usize,
    own: &'a mut [f64],
    /// The place of each column in the row.
    found: &'a [usize],
}

impl NullaryFnOnce for Elimination<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Elimination { factors: Incomplete { all, blocks, inverses }, places, row, own, found } = self;
        let length = places.size * places.size;
        let mut multiple = vec![0.0; length];
        for (place, &before) in places.columns(row).iter().enumerate().take_while(|(_, column)| **column < row) {
            multiple.fill(0.0);
            let block = &own[place * length..][..length];
            let inverse = places.block(inverses, before);
            add_product(&mut multiple, block, inverse, all, 1.0);
            own[place * length..][..length].copy_from_slice(&multiple);
            for number in places.row(before) {
                let column = places.columns[number];
                if column > before && found[column] != usize::MAX {
                    let target = &mut own[found[column] * length..][..length];
                    add_product(target, &multiple, places.block(blocks, number), all, -1.0);
                }
            }
        }
    }
}

/// Adds a multiple of the product of two blocks.
#[inline(always)]
fn add_product(sum: &mut [f64], left: &[f64], right: &[f32], all: &[usize], factor: f64) {
    let size = all.len();
    let mut x = vec![0.0; size];
    for (sum, right) in sum.chunks_exact_mut(size).zip(right.chunks_exact(size)) {
        x.iter_mut().zip(right).for_each(|(x, r)| *x = f64::from(*r));
        add_block(sum, left, all, factor, &x);
    }
}

struct IncompleteSolution<'a> {
    factors: &'a Incomplete,
    places: &'a BlockPlaces,
    x: &'a mut [f64],
}

impl NullaryFnOnce for IncompleteSolution<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let IncompleteSolution { factors: Incomplete { all, blocks, inverses }, places, x } = self;
        let size = places.size;
        for row in 0..places.rows() {
            let (before, own) = x.split_at_mut(row * size);
            for number in places.row(row).take_while(|number| places.columns[*number] < row) {
                let part = &before[places.columns[number] * size..][..size];
                add_block(&mut own[..size], places.block(blocks, number), all, -1.0, part);
            }
        }
        let mut image = vec![0.0; size];
        for row in (0..places.rows()).rev() {
            let (own, after) = x[row * size..].split_at_mut(size);
            for number in places.row(row).rev().take_while(|number| places.columns[*number] > row) {
                let part = &after[(places.columns[number] - row - 1) * size..][..size];
                add_block(own, places.block(blocks, number), all, -1.0, part);
            }
            image.fill(0.0);
            add_block(&mut image, places.block(inverses, row), all, 1.0, own);
            own.copy_from_slice(&image);
        }
    }
}
