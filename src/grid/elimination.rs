//! LU factors by fronts: the multifrontal method (I. S. Duff and J. K. Reid, 1983, doi:10.1145/356044.356047).
//!
//! A cell's own unknowns are eliminated first, which is static condensation (R. J. Guyan, 1965, doi:10.2514/3.2874): a matrix of its
//! faces is left. The dissection of the mesh is a tree of fronts: the matrix of each is the sum of what its halves leave, its own
//! faces are eliminated, and what it leaves goes to the front above. Pivots are chosen among a front's own rows, so that factors fill
//! where coupled faces do, whatever the pivots. That is safe here: probability gets out of every piece in the end.

use super::dissection::{Front, Parts};
use super::panel::Panel;
use faer::Mat;

/// Pieces with fewer cells than this together are not worth tasks of their own.
const TASK: usize = 16;

/// The linear system of a mesh: what it takes from each cell.
pub(super) trait Cells: Sync {
    /// The factors of a cell's own unknowns, and the matrix that they leave to its faces.
    fn condensed(&self, cell: usize) -> (Panel, Mat<f64>);
    /// Unknowns at a face.
    fn face(&self) -> usize;
}

/// The factors of a front and of all below it.
#[derive(Debug)]
pub(super) struct Factored {
    parts: Vec<Factored>,
    panel: Panel,
}

impl Factored {
    pub(super) fn new(front: &Front, cells: &impl Cells) -> Self {
        factored(front, cells).0
    }

    /// Solves for the unknowns of all cells, right sides before, and for those at faces, by the sizes of both.
    pub(super) fn solve(&self, front: &Front, sizes: [usize; 2], inner: &mut [f64], faces: &mut [f64]) {
        self.eliminate(front, sizes, inner, faces);
        self.substitute(front, sizes, inner, faces);
    }

    /// Eliminates the own unknowns in their places, after those of the parts; what is left to the boundary.
    fn eliminate(&self, front: &Front, sizes: [usize; 2], inner: &mut [f64], faces: &mut [f64]) -> Vec<f64> {
        let [block, size] = sizes;
        let boundary = front.boundary.len() * size;
        match &front.parts {
            Parts::Cell(cell) => {
                let mut left = vec![0.0; boundary];
                self.panel.eliminate(&mut inner[cell * block..][..block], &mut left);
                left
            }
            Parts::Halves(parts) => {
                let mut sum = gathered(&front.own, size, faces);
                sum.resize(sum.len() + boundary, 0.0);
                for ((part, places), factored) in parts.iter().zip(&self.parts) {
                    let left = factored.eliminate(part, sizes, inner, faces);
                    for (place, left) in places.iter().zip(left.chunks_exact(size)) {
                        sum[place * size..][..size].iter_mut().zip(left).for_each(|(s, l)| *s += l);
                    }
                }
                let mut left = sum.split_off(front.own.len() * size);
                self.panel.eliminate(&mut sum, &mut left);
                scatter(&front.own, size, &sum, faces);
                left
            }
        }
    }

    /// Puts the own unknowns in their places, and then those of the parts.
    fn substitute(&self, front: &Front, sizes: [usize; 2], inner: &mut [f64], faces: &mut [f64]) {
        let [block, size] = sizes;
        let boundary = gathered(&front.boundary, size, faces);
        match &front.parts {
            Parts::Cell(cell) => self.panel.substitute(&mut inner[cell * block..][..block], &boundary),
            Parts::Halves(parts) => {
                let mut own = gathered(&front.own, size, faces);
                self.panel.substitute(&mut own, &boundary);
                scatter(&front.own, size, &own, faces);
                for ((part, _), factored) in parts.iter().zip(&self.parts) {
                    factored.substitute(part, sizes, inner, faces);
                }
            }
        }
    }
}

fn gathered(faces: &[usize], size: usize, x: &[f64]) -> Vec<f64> {
    faces.iter().flat_map(|face| &x[face * size..][..size]).copied().collect()
}

fn scatter(faces: &[usize], size: usize, values: &[f64], x: &mut [f64]) {
    for (face, values) in faces.iter().zip(values.chunks_exact(size)) {
        x[face * size..][..size].copy_from_slice(values);
    }
}

/// The factors of a front and of all below it, and what it leaves to its boundary.
fn factored(front: &Front, cells: &impl Cells) -> (Factored, Mat<f64>) {
    let size = cells.face();
    let parts = match &front.parts {
        Parts::Cell(cell) => {
            let (panel, left) = cells.condensed(*cell);
            debug_assert_eq!(left.nrows(), front.boundary.len() * size);
            return (Factored { parts: Vec::new(), panel }, left);
        }
        Parts::Halves(parts) => parts,
    };
    let below = |k: usize| factored(&parts[k].0, cells);
    let [first, second] =
        if front.cells > TASK { rayon::join(|| below(0), || below(1)).into() } else { [below(0), below(1)] };
    let (own, boundary) = (front.own.len() * size, front.boundary.len() * size);
    let zeros = |rows: usize, columns: usize| Mat::zeros(rows, columns);
    let mut sum = FrontMatrix {
        size,
        own: front.own.len(),
        lower: zeros(own + boundary, own),
        upper: zeros(own, boundary),
        following: zeros(boundary, boundary),
    };
    sum.add(&parts[0].1, first.1);
    sum.add(&parts[1].1, second.1);
    let panel = Panel::new(sum.lower, sum.upper, &mut sum.following);
    (Factored { parts: vec![first.0, second.0], panel }, sum.following)
}

/// The matrix of a front, the own faces first: F₁₁ with F₂₁ below it, F₁₂ and F₂₂.
struct FrontMatrix {
    size: usize,
    own: usize,
    lower: Mat<f64>,
    upper: Mat<f64>,
    following: Mat<f64>,
}

impl FrontMatrix {
    /// Adds what a part leaves to faces at `places`.
    fn add(&mut self, places: &[usize], left: Mat<f64>) {
        let size = self.size;
        for column in 0..left.ncols() {
            for (row, entries) in places.iter().zip(left.col_as_slice(column).chunks_exact(size)) {
                let target = self.entries(*row, places[column / size], column % size);
                target.iter_mut().zip(entries).for_each(|(t, e)| *t += e);
            }
        }
    }

    /// The rows of one face in column `j` of another.
    fn entries(&mut self, row: usize, column: usize, j: usize) -> &mut [f64] {
        let (part, row, column) = match (row.checked_sub(self.own), column.checked_sub(self.own)) {
            (_, None) => (&mut self.lower, row, column),
            (None, Some(column)) => (&mut self.upper, row, column),
            (Some(row), Some(column)) => (&mut self.following, row, column),
        };
        &mut part.col_as_slice_mut(column * self.size + j)[row * self.size..][..self.size]
    }
}
