//! Orthonormal functions for the search on thin states.

use super::likelihood::{Fit, Likelihood, effective, with_constant};
use crate::numerics::{Concave, Search, definite};
use faer::Mat;
use faer::linalg::solvers::Llt;

/// The steps of a search on a thin state after which its functions are made orthonormal again, one stretch after the other.
const FRAMES: [usize; 4] = [2, 4, 10, usize::MAX];
/// Functions on a thin state whose part beyond all others is below this, relative to the largest, are left out as dependent.
const DEPENDENT: f64 = 1e-11;

/// χ = Tᵀ(φ − Eφ), orthonormal under some masses.
///
/// On a thin state products of Legendre polynomials are all but dependent: the smallest eigenvalue of their covariance falls by 1e5
/// from one even order to the next, to 1e-13 at order 6 of a harvester, and a search by its Cholesky factors does not end. T comes from
/// R of the functions' own table, whose singular values are the roots of these.
pub(super) struct OrthonormalFrame {
    transform: Mat<f64>,
}

impl OrthonormalFrame {
    /// Of the triangle R with RᵀR = Cov φ. None where it is not finite.
    fn of(triangle: &Mat<f64>) -> Option<Self> {
        let size = triangle.ncols();
        let scale: Vec<f64> = (0..size).map(|k| triangle.col(k).norm_l2().max(f64::MIN_POSITIVE).recip()).collect();
        let scaled = Mat::from_fn(triangle.nrows(), size, |i, k| triangle[(i, k)] * scale[k]);
        let svd = scaled.thin_svd().ok()?;
        let (sizes, v) = (svd.S(), svd.V());
        let kept = (0..size).take_while(|k| sizes[*k] > DEPENDENT * sizes[0]).count();
        (kept > 0)
            .then(|| OrthonormalFrame { transform: Mat::from_fn(size, kept, |i, k| scale[i] * v[(i, k)] / sizes[k]) })
    }

    /// T b: the coefficients of φ of those of χ.
    fn of_products(&self, b: &[f64]) -> Vec<f64> {
        let column = Mat::from_fn(b.len(), 1, |k, _| b[k]);
        (&self.transform * column).col_as_slice(0).to_vec()
    }

    /// Tᵀ m.
    fn along(&self, m: &[f64]) -> Vec<f64> {
        let column = Mat::from_fn(m.len(), 1, |k, _| m[k]);
        (self.transform.transpose() * column).col_as_slice(0).to_vec()
    }
}

impl Likelihood<'_> {
    /// The orthonormal functions under some masses.
    fn frame(&self, masses: &[f64]) -> Option<OrthonormalFrame> {
        OrthonormalFrame::of(&self.triangle(masses, &self.means(masses)))
    }

    /// The most likely density as [`Likelihood::most_likely`] finds it, in functions that are orthonormal under the first densities
    /// on the way.
    pub(super) fn most_likely_in_frames(&self, means: &[f64], start: Vec<f64>, search: Search) -> Option<Fit> {
        let (mut a, mut steps) = (start, 0);
        for part in FRAMES {
            let q = self.combination(&a);
            let (_, masses) = self.integral(&q)?;
            let frame = self.frame(&masses)?;
            let (along, from) = (frame.along(means), a[1..].iter().zip(means).map(|(a, m)| a * m).sum());
            let towards = InFrame { likelihood: self, means, frame, along, q, from };
            let none = vec![0.0; towards.along.len()];
            let most = part.min(search.most - steps);
            let summit = Search { most, ..search }.ascend(&towards, none, None)?;
            steps += summit.steps;
            let change = towards.frame.of_products(&summit.a);
            a[1..].iter_mut().zip(&change).for_each(|(a, change)| *a += change);
            if summit.converged || steps >= search.most || part == usize::MAX {
                let (converged, next, masses) = (summit.converged, summit.next, summit.at);
                return Some(Fit { a, effective: effective(&masses), steps, converged, next, masses });
            }
        }
        None
    }

    /// The coefficients of the first-order change of ln p that a change of the means makes, the constant left out.
    pub(super) fn change_in_frame(&self, masses: &[f64], difference: &[f64]) -> Option<Vec<f64>> {
        let frame = self.frame(masses)?;
        Some(frame.of_products(&frame.along(difference)))
    }
}

/// The likelihood of means as a function of the coefficients of χ, which are added to those of φ that the search comes from.
struct InFrame<'a> {
    likelihood: &'a Likelihood<'a>,
    means: &'a [f64],
    frame: OrthonormalFrame,
    /// Tᵀ m.
    along: Vec<f64>,
    /// Q at each node that the search comes from, and its mean.
    q: Vec<f64>,
    from: f64,
}

impl Concave for InFrame<'_> {
    /// The mass of each node.
    type At = Vec<f64>;

    fn combination(&self, b: &[f64]) -> Vec<f64> {
        self.likelihood.combination(&with_constant(&self.frame.of_products(b)))
    }

    fn value(&self, b: &[f64], combination: &[f64]) -> Option<(f64, Vec<f64>)> {
        let q: Vec<f64> = self.q.iter().zip(combination).map(|(q, change)| q + change).collect();
        let (integral, masses) = self.likelihood.integral(&q)?;
        let along: f64 = b.iter().zip(&self.along).map(|(b, m)| b * m).sum();
        Some((self.from + along - integral, masses)).filter(|(value, _)| value.is_finite())
    }

    fn gradient(&self, masses: &Vec<f64>) -> Vec<f64> {
        let found = self.likelihood.means(masses);
        let off: Vec<f64> = self.means.iter().zip(found).map(|(wanted, found)| wanted - found).collect();
        self.frame.along(&off)
    }

    fn curvature(&self, masses: &Vec<f64>, _: &[f64]) -> Option<Llt<f64>> {
        let found = self.likelihood.means(masses);
        definite(self.likelihood.covariance_of(masses, &found, Some(self.frame.transform.as_ref())))
    }
}
