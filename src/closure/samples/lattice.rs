//! Nodes for integrals of exp(Q) in a few states: a cubic lattice over where the density is.

use super::copula::Copula;
use super::likelihood::Nodes;
use crate::closure::pilot::Pilot;
use crate::problem::Symmetry;
use crate::states::States;
use nalgebra::{Cholesky, DMatrix, DVector};
use rand::{SeedableRng, rngs::ChaCha8Rng, seq::SliceRandom};

/// The lattice's spacing in standard deviations: what no density needs finer, and what no density forgives coarser.
const FINEST: f64 = 0.12;
const COARSEST: f64 = 1.2;
/// A lattice with too many nodes gives way to one that is so much wider.
const WIDER: f64 = 1.04;
/// The places of the lattice in a ball around the density, for each node that there may be.
const SEARCHED: f64 = 64.0;
/// The farthest a node is from the centre, relative to the farthest state.
const BEYOND: f64 = 1.1;

/// The nodes of a cubic lattice in the states' principal axes, as many as `most` at the utmost, wherever the copula trusts: the
/// trapezoidal rule, whose error falls faster than any power of the spacing where the integrand is smooth and vanishes at the
/// edge (L. N. Trefethen and J. A. C. Weideman, 2014, doi:10.1137/130932132). Of mirror images one stands for all. The nodes come
/// in two halves, like the black and the white fields of a chessboard, each a coarser rule. None where the lattice would be too coarse.
pub(super) fn lattice(pilot: &Pilot, symmetry: &Symmetry, copula: &Copula, most: usize) -> Option<Nodes> {
    let n = pilot.states.dimension();
    let (centre, _) = pilot.spread(symmetry);
    let mut covariance = DMatrix::zeros(n, n);
    let images = || pilot.states.iter().flat_map(|x| symmetry.images(x));
    for x in images() {
        let off = DVector::from_fn(n, |i, _| x[i] - centre[i]);
        covariance.ger(1.0, &off, &off, 1.0);
    }
    covariance /= images().count() as f64;
    let axes = Cholesky::new(covariance)?.l();
    let length = |x: &[f64]| {
        axes.solve_lower_triangular(&DVector::from_fn(n, |i, _| x[i] - centre[i])).map_or(f64::INFINITY, |z| z.norm())
    };
    let radius = BEYOND * pilot.states.iter().map(length).fold(0.0, f64::max);
    let region = Region { symmetry, copula, centre: &centre, axes: &axes, radius, most };
    // A ball of so many more places is not searched.
    let ball = (1..=n).rev().step_by(2).map(|k| if k == 1 { 2.0 } else { std::f64::consts::TAU / k as f64 });
    if ball.product::<f64>() * (radius / COARSEST).powi(n as i32) > SEARCHED * most as f64 {
        return None;
    }
    // The volume by a coarse lattice, then the finest that there is room for.
    let coarse = region.nodes(COARSEST)?;
    let room = most as f64 / coarse.points.len().max(1) as f64;
    let mut spacing = COARSEST * room.powf(-(n as f64).recip());
    while spacing < COARSEST {
        spacing = spacing.max(FINEST);
        if let Some(nodes) = region.nodes(spacing) {
            return Some(nodes);
        }
        spacing *= WIDER;
    }
    Some(coarse)
}

/// Where nodes may be.
struct Region<'a> {
    symmetry: &'a Symmetry,
    copula: &'a Copula,
    centre: &'a [f64],
    axes: &'a DMatrix<f64>,
    radius: f64,
    most: usize,
}

impl Region<'_> {
    /// The nodes of a spacing. None where they are too many.
    fn nodes(&self, spacing: f64) -> Option<Nodes> {
        let n = self.centre.len();
        let mut halves = [(); 2].map(|()| (Vec::new(), Vec::new()));
        let mut place = vec![0.0; n];
        let reach = (self.radius / spacing).powi(2);
        self.along(0, reach, &mut place, &mut |place| {
            let images: Vec<Vec<f64>> = self.symmetry.images(place).collect();
            // The first of the images in the order of numbers stands for all.
            if images.iter().any(|image| image.as_slice() < place) {
                return true;
            }
            let z = DVector::from_column_slice(place) * spacing;
            let x = self.axes * z;
            let x: Vec<f64> = x.iter().zip(self.centre).map(|(x, centre)| x + centre).collect();
            if self.copula.trusts(&x) {
                let itself = images.iter().filter(|image| image.as_slice() == place).count();
                let (points, base) = &mut halves[place.iter().sum::<f64>().rem_euclid(2.0) as usize];
                points.extend(x);
                base.push((images.len() as f64 / itself as f64).ln());
            }
            halves[0].1.len() + halves[1].1.len() <= self.most
        })
        .then(|| {
            let log_volume = n as f64 * spacing.ln() + self.axes.diagonal().iter().map(|side| side.ln()).sum::<f64>();
            let (mut points, mut base, mut parts) = (Vec::new(), Vec::new(), Vec::new());
            let mut stream = ChaCha8Rng::seed_from_u64(0);
            for (half, weights) in &halves {
                // In no order, so that a few of them lie everywhere.
                let mut order: Vec<usize> = (0..weights.len()).collect();
                order.shuffle(&mut stream);
                points.extend(order.iter().flat_map(|k| &half[k * n..(k + 1) * n]));
                base.extend(order.iter().map(|k| weights[*k] + log_volume));
                parts.push(base.len());
            }
            Nodes { points: States::from_values(n, points), base, parts, measured: true }
        })
    }

    /// Visits the whole numbers of `place` from entry `from` on whose squares sum up to `left` at most, while `visit` goes on.
    fn along(&self, from: usize, left: f64, place: &mut Vec<f64>, visit: &mut impl FnMut(&[f64]) -> bool) -> bool {
        if from == place.len() {
            return visit(place);
        }
        let reach = left.max(0.0).sqrt().floor();
        let mut k = -reach;
        while k <= reach {
            place[from] = k;
            if !self.along(from + 1, left - k * k, place, visit) {
                return false;
            }
            k += 1.0;
        }
        true
    }
}
