//! The unknowns of all faces by iteration: in three states fronts fill too much.
//!
//! A cell's own unknowns are eliminated as before. The matrix of faces that is left has blocks where two faces share a cell. It is
//! solved by [generalised minimal residuals](super::krylov) after two preconditioners: the means and the slopes of all faces by
//! [fronts](super::elimination), and what these leave by [incomplete factors](super::incomplete) in the order of the
//! [drift](super::drift_order). The number of steps hardly depends on the mesh.

use super::dissection::Front;
use super::drift_order::along_drift;
use super::elimination::{Cells, Factored};
use super::incomplete::{BlockPlaces, BlockRows, Incomplete};
use super::krylov;
use super::operator::Layout;
use super::panel::Panel;
use super::shape::Shape;
use crate::error::{Error, Result};
use crate::parallel;
use faer::Mat;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The residual of the faces' equations, over that without a solution; where what wells exchange decides, the second.
pub(super) const TOLERANCES: [f64; 2] = [1e-9, 1e-12];

/// What solves for the unknowns of all cells and faces.
#[derive(Debug)]
pub(super) struct Iteration {
    /// The factors of each cell's own unknowns.
    panels: Vec<Panel>,
    /// The place of each face in the order of the drift.
    places: Vec<usize>,
    rows: BlockRows,
    incomplete: Incomplete,
    /// The functions of a face of degree 1 at most along each state, and their factors.
    low: Vec<usize>,
    coarse: Factored,
    pub(super) tolerance: f64,
    /// The most steps that a solution has taken.
    steps: AtomicUsize,
}

/// What many steps mean.
pub(super) const THIN: &str = "the density is a sheet too thin for its cells; take the closure or the simulation";
/// With so many steps, of a few dozen where cells resolve a density, finer meshes lead to none within a sensible time.
const MANY: usize = 150;

/// The numbers that it takes, without those of single cells.
pub(super) fn numbers(layout: &Layout, shape: Shape) -> f64 {
    let faces = |cell: usize| layout.faces(cell).count() as f64;
    let blocks: f64 = (0..layout.mesh.cells.len()).map(|cell| faces(cell).powi(2)).sum();
    let low = low(shape).len() as f64;
    // The matrix, its factors in half the precision, and the cells' parts of it while it is made.
    2.5 * blocks * (shape.face() as f64).powi(2) + layout.front.numbers(low).most
}

/// The functions of a face of degree 1 at most along each state.
fn low(shape: Shape) -> Vec<usize> {
    let along = shape.along(0);
    (0..along.len()).filter(|function| shape.degrees(along[*function]).iter().all(|degree| *degree <= 1)).collect()
}

impl Iteration {
    pub(super) fn new(layout: &Layout, cells: &impl Cells, carried: &[[f64; 2]], shape: Shape, tolerance: f64) -> Self {
        let (mesh, size) = (&layout.mesh, shape.face());
        let condensed = parallel::map(mesh.cells.len(), |cell| cells.condensed(cell));
        let (panels, left): (Vec<Panel>, Vec<Mat<f64>>) = condensed.into_iter().unzip();
        let order = along_drift(mesh, carried);
        let mut places = vec![0; order.len()];
        order.iter().enumerate().for_each(|(place, face)| places[*face] = place);
        let around: Vec<Vec<usize>> =
            (0..mesh.cells.len()).map(|cell| layout.faces(cell).map(|face| places[face]).collect()).collect();
        let columns = |face: &usize| {
            let mut columns: Vec<usize> = mesh.faces[*face].iter().flat_map(|cell| &around[*cell]).copied().collect();
            columns.sort_unstable();
            columns.dedup();
            columns
        };
        let all: Vec<Vec<usize>> = order.iter().map(columns).collect();
        let rows = BlockRows::new(BlockPlaces::new(size, &all), |row, columns, blocks| {
            let mut visited = None;
            for cell in mesh.faces[order[row]].iter().filter(|cell| visited.replace(**cell) != Some(**cell)) {
                let from = |(part, _): &(usize, &usize)| part * size;
                for own in around[*cell].iter().enumerate().filter(|(_, place)| **place == row) {
                    for other in around[*cell].iter().enumerate() {
                        let at = columns.partition_point(|column| column < other.1) * size * size;
                        for j in 0..size {
                            let entries = &left[*cell].col_as_slice(from(&other) + j)[from(&own)..][..size];
                            let target = &mut blocks[at + j * size..][..size];
                            target.iter_mut().zip(entries).for_each(|(t, e)| *t += e);
                        }
                    }
                }
            }
        });
        let low = low(shape);
        let coarse = || Factored::new(&layout.front, &Coarse { left: &left, low: &low, size });
        let (incomplete, coarse) = rayon::join(|| Incomplete::new(&rows), coarse);
        Iteration { panels, places, rows, incomplete, low, coarse, tolerance, steps: AtomicUsize::new(0) }
    }

    /// Solves for the unknowns of all cells, right sides before, and for those at faces.
    ///
    /// # Errors
    /// [`Error::NotResolved`] where the iteration does not end.
    pub(super) fn solve(&self, layout: &Layout, inner: &mut [f64], faces: &mut [f64]) -> Result<()> {
        let size = self.rows.places.size;
        let block = inner.len() / self.panels.len();
        let eliminated = parallel::map(self.panels.len(), |cell| {
            let mut own = inner[cell * block..][..block].to_vec();
            let mut left = vec![0.0; layout.faces(cell).count() * size];
            self.panels[cell].eliminate(&mut own, &mut left);
            (own, left)
        });
        for (cell, (own, left)) in eliminated.into_iter().enumerate() {
            inner[cell * block..][..block].copy_from_slice(&own);
            for (face, left) in layout.faces(cell).zip(left.chunks_exact(size)) {
                faces[face * size..][..size].iter_mut().zip(left).for_each(|(s, l)| *s += l);
            }
        }
        let mut right = vec![0.0; faces.len()];
        for (face, place) in self.places.iter().enumerate() {
            right[place * size..][..size].copy_from_slice(&faces[face * size..][..size]);
        }
        let steps = AtomicUsize::new(0);
        let found = krylov::solved(&right, self.tolerance, |r| {
            steps.fetch_add(1, Ordering::Relaxed);
            self.preconditioned(&layout.front, r)
        });
        self.steps.fetch_max(steps.into_inner(), Ordering::Relaxed);
        let found = found.ok_or_else(|| Error::NotResolved {
            estimate: f64::INFINITY,
            reason: format!("the iteration for the unknowns of the grid's faces does not end: {THIN}"),
        })?;
        for (face, place) in self.places.iter().enumerate() {
            faces[face * size..][..size].copy_from_slice(&found[place * size..][..size]);
        }
        parallel::on_runs(inner, block, |cell, own| {
            let around: Vec<f64> = layout.faces(cell).flat_map(|face| &faces[face * size..][..size]).copied().collect();
            self.panels[cell].substitute(own, &around);
        });
        Ok(())
    }

    /// Whether a solution has taken too many steps for finer meshes to be of use.
    pub(super) fn is_slow(&self) -> bool {
        self.steps.load(Ordering::Relaxed) > MANY
    }

    /// What both preconditioners make of a residual, and the matrix of that.
    fn preconditioned(&self, front: &Front, residual: &[f64]) -> [Vec<f64>; 2] {
        let (size, few) = (self.rows.places.size, self.low.len());
        let mut means = vec![0.0; self.places.len() * few];
        for (face, place) in self.places.iter().enumerate() {
            let own = &residual[place * size..][..size];
            self.low.iter().enumerate().for_each(|(k, function)| means[face * few + k] = own[*function]);
        }
        self.coarse.solve(front, [0, few], &mut [], &mut means);
        let mut coarse = vec![0.0; means.len()];
        for (face, place) in self.places.iter().enumerate() {
            coarse[place * few..][..few].copy_from_slice(&means[face * few..][..few]);
        }
        let mut image = self.rows.product_with(&self.low, &coarse);
        let mut change: Vec<f64> = residual.iter().zip(&image).map(|(r, i)| r - i).collect();
        self.incomplete.solve(&self.rows.places, &mut change);
        image.iter_mut().zip(self.rows.product(&change)).for_each(|(i, more)| *i += more);
        for (own, coarse) in change.chunks_exact_mut(size).zip(coarse.chunks_exact(few)) {
            self.low.iter().zip(coarse).for_each(|(function, c)| own[*function] += c);
        }
        [change, image]
    }
}

/// The means and slopes of all faces.
struct Coarse<'a> {
    left: &'a [Mat<f64>],
    low: &'a [usize],
    size: usize,
}

impl Cells for Coarse<'_> {
    fn condensed(&self, cell: usize) -> (Panel, Mat<f64>) {
        let (left, few) = (&self.left[cell], self.low.len());
        let faces = left.nrows() / self.size;
        let place = |k: usize| k / few * self.size + self.low[k % few];
        let own = Mat::from_fn(faces * few, faces * few, |i, j| left[(place(i), place(j))]);
        (Panel::empty(own.nrows()), own)
    }

    fn face(&self) -> usize {
        self.low.len()
    }
}
