use crate::closure::Basis;
use crate::closure::classical::hermite::{combination, hermite_row, standard_normal};
use crate::polynomial::{Polynomial, monomials, total_degree};
use faer::{Col, ColRef, Mat};

/// Polynomials that are orthonormal under the weight on the half plane, and to the constants.
///
/// They are combinations of Hermite products in the scaled coordinates, less their means, lower degrees first.
#[derive(Clone, Debug)]
pub(super) struct HalfPlaneBasis {
    indices: Vec<Vec<u32>>,
    order: u32,
    /// Columns: the functions as combinations of Hermite products.
    transform: Mat<f64>,
    /// The coefficients of a combination of Hermite products in this basis.
    projection: Mat<f64>,
    means: Col<f64>,
}

/// Functions and their derivatives in z at a set of points: rows are points, columns functions.
pub(super) struct BasisValues {
    pub(super) value: Mat<f64>,
    pub(super) first: Mat<f64>,
    pub(super) second: Mat<f64>,
    pub(super) curvature: Mat<f64>,
}

impl HalfPlaneBasis {
    /// The basis of an order: even total degrees in the classical basis, all in the folded one.
    pub(super) fn new(basis: Basis, order: u32, points: &[[f64; 2]], weights: &[f64]) -> Self {
        let mut indices = monomials(2, order).split_off(1);
        indices.retain(|index| basis == Basis::Folded || total_degree(index).is_multiple_of(2));
        let (raw, count) = (hermite_products(&indices, order, points).value, indices.len());
        let raw_means = raw.transpose() * ColRef::from_slice(weights);
        let scaled = Mat::from_fn(points.len(), count, |i, k| weights[i].sqrt() * (raw[(i, k)] - raw_means[k]));
        let qr = scaled.qr();
        // With a positive diagonal R is unique: the functions of a higher order begin with those of a lower one.
        let projection = Mat::from_fn(count, count, |i, j| qr.thin_R()[(i, j)] * qr.thin_R()[(i, i)].signum());
        // The functions are linearly independent at as many nodes, so that R is regular.
        let mut transform = Mat::identity(count, count);
        projection.solve_upper_triangular_in_place(&mut transform);
        let means = transform.transpose() * &raw_means;
        HalfPlaneBasis { indices, order, transform, projection, means }
    }

    pub(super) fn len(&self) -> usize {
        self.indices.len()
    }

    /// The functions at points, with their derivatives in z₁, in z₂ and twice in z₂.
    pub(super) fn at(&self, points: &[[f64; 2]]) -> BasisValues {
        let hermite = hermite_products(&self.indices, self.order, points);
        let mut value = hermite.value * &self.transform;
        value.row_iter_mut().for_each(|mut row| row -= self.means.transpose());
        BasisValues {
            value,
            first: hermite.first * &self.transform,
            second: hermite.second * &self.transform,
            curvature: hermite.curvature * &self.transform,
        }
    }

    /// The coefficients of ln f_N.
    pub(super) fn gaussian(&self) -> Col<f64> {
        &self.projection * standard_normal(&self.indices)
    }

    /// A combination of the functions as a polynomial in z, without its constant.
    pub(super) fn polynomial(&self, a: &Col<f64>) -> Polynomial {
        combination(2, &self.indices, &(&self.transform * a))
    }
}

/// An entry is the value of the product of index (i, j) from the rows h₀ … of both coordinates.
type ProductEntry<'a> = &'a dyn Fn(&[Vec<f64>; 2], [usize; 2]) -> f64;

fn hermite_products(indices: &[Vec<u32>], order: u32, points: &[[f64; 2]]) -> BasisValues {
    let rows: Vec<[Vec<f64>; 2]> = points.iter().map(|z| z.map(|z| hermite_row(z, order))).collect();
    let matrix = |entry: ProductEntry<'_>| {
        Mat::from_fn(points.len(), indices.len(), |i, k| entry(&rows[i], [0, 1].map(|d| indices[k][d] as usize)))
    };
    let slope = |row: &[f64], j: usize| if j > 0 { (j as f64).sqrt() * row[j - 1] } else { 0.0 };
    let bend = |row: &[f64], j: usize| if j > 1 { ((j * (j - 1)) as f64).sqrt() * row[j - 2] } else { 0.0 };
    BasisValues {
        value: matrix(&|h, [i, j]| h[0][i] * h[1][j]),
        first: matrix(&|h, [i, j]| slope(&h[0], i) * h[1][j]),
        second: matrix(&|h, [i, j]| h[0][i] * slope(&h[1], j)),
        curvature: matrix(&|h, [i, j]| h[0][i] * bend(&h[1], j)),
    }
}
