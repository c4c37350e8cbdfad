//! Nodes for integrals in a few states: a cubic lattice over the region that holds the density.

use super::copula::Copula;
use super::nodes::SampleNodes;
use crate::closure::pilot::Pilot;
use crate::numerics::exponentials;
use crate::problem::Symmetry;
use crate::record::{Read, positive, states};
use crate::states::States;
use nalgebra::{Cholesky, DMatrix, DVector};
use rand::{SeedableRng, rngs::ChaCha8Rng, seq::SliceRandom};
use serde::{Deserialize, Serialize};

/// The finest spacing of a lattice, in standard deviations: no density needs a finer one.
const FINEST: f64 = 0.12;
/// The coarsest spacing of a lattice, in standard deviations, by which no density is resolved any more.
const COARSEST: f64 = 1.2;
/// The most places of a lattice in a ball around the density, for each node that there may be: a bound on work.
const SEARCHED: f64 = 64.0;

/// No lattice that is made here has more nodes than this.
const MOST: usize = 1 << 22;

/// A cubic lattice in the states' principal axes.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Lattice {
    centre: Vec<f64>,
    /// The lower triangle L of the states' covariance L Lᵀ, by rows.
    axes: Vec<Vec<f64>>,
    /// The largest distance of nodes from the centre, and their spacing, in standard deviations.
    radius: f64,
    spacing: f64,
}

impl Lattice {
    /// The finest lattice over the copula's trust domain with at most `most` nodes, and its nodes: the trapezoidal rule,
    /// whose error falls faster than any power of the spacing where the integrand is smooth and vanishes at the edge (L. N.
    /// Trefethen and J. A. C. Weideman, 2014, doi:10.1137/130932132). None where the lattice would be too coarse.
    pub(in crate::closure) fn finest(
        pilot: &Pilot,
        symmetry: &Symmetry,
        copula: &Copula,
        most: usize,
    ) -> Option<(Lattice, SampleNodes)> {
        let n = pilot.states.dimension();
        let (centre, _) = pilot.spread(symmetry);
        let mut covariance = DMatrix::zeros(n, n);
        for x in &pilot.states {
            let off = DVector::from_fn(n, |i, _| x[i] - centre[i]);
            covariance.ger(1.0, &off, &off, 1.0);
        }
        covariance /= pilot.states.len() as f64;
        symmetry.average(&mut covariance);
        let axes = Cholesky::new(covariance)?.l();
        let length = |x: &[f64]| {
            let off = DVector::from_fn(n, |i, _| x[i] - centre[i]);
            axes.solve_lower_triangular(&off).map_or(f64::INFINITY, |z| z.norm())
        };
        let radius = copula.beyond(pilot) * pilot.states.iter().map(length).fold(0.0, f64::max);
        // A ball of so many more places is not searched.
        let ball = (1..=n).rev().step_by(2).map(|k| if k == 1 { 2.0 } else { std::f64::consts::TAU / k as f64 });
        if ball.product::<f64>() * (radius / COARSEST).powi(n as i32) > SEARCHED * most as f64 {
            return None;
        }
        let axes = axes.row_iter().map(|row| row.iter().copied().collect()).collect();
        let mut lattice = Lattice { centre, axes, radius, spacing: COARSEST };
        // The volume by a coarse lattice, then the finest that there is room for.
        let coarse = lattice.nodes(symmetry, copula, most)?;
        let room = most as f64 / coarse.points.len().max(1) as f64;
        lattice.spacing *= room.powf(-(n as f64).recip());
        while lattice.spacing < COARSEST {
            lattice.spacing = lattice.spacing.max(FINEST);
            if let Some(nodes) = lattice.nodes(symmetry, copula, most) {
                return Some((lattice, nodes));
            }
            lattice.spacing *= 1.04;
        }
        Some((Lattice { spacing: COARSEST, ..lattice }, coarse))
    }

    /// All nodes with their weights, none for its mirror images.
    pub(in crate::closure) fn all(&self, copula: &Copula) -> (States, Vec<f64>) {
        let whole = self.nodes(&Symmetry::none(self.centre.len()), copula, MOST);
        let nodes = whole.unwrap_or_else(|| SampleNodes::empty(self.centre.len()));
        let mut weights = nodes.base;
        exponentials(&mut weights);
        (nodes.points, weights)
    }

    /// A state in multiples of the axes; nodes have whole ones.
    pub(super) fn place(&self, x: &[f64]) -> Vec<f64> {
        let mut place: Vec<f64> = Vec::with_capacity(x.len());
        for (i, (row, (x, centre))) in self.axes.iter().zip(x.iter().zip(&self.centre)).enumerate() {
            let before: f64 = row.iter().zip(&place).map(|(l, k)| l * k).sum();
            place.push(((x - centre) / self.spacing - before) / row[i]);
        }
        place
    }

    /// The number of whole places on either side along an axis.
    fn reach(&self) -> f64 {
        (self.radius / self.spacing).floor()
    }

    /// The number of places in a cube around all nodes.
    pub(super) fn places(&self) -> usize {
        (2 * self.reach() as usize + 1).pow(self.centre.len() as u32)
    }

    /// The number of a place in that cube. None outside.
    pub(super) fn index(&self, place: &[f64]) -> Option<usize> {
        let reach = self.reach();
        place
            .iter()
            .try_fold(0, |at, k| (k.abs() <= reach).then(|| at * (2 * reach as usize + 1) + (k + reach) as usize))
    }

    /// Refuses numbers without a meaning, such as those of a damaged file.
    pub(in crate::closure) fn checked(self, n: usize) -> Read<Self> {
        states("the centre of the lattice", &self.centre, n)?;
        if self.axes.len() != n {
            return Err(format!("the lattice has {} axes in {n} states", self.axes.len()));
        }
        self.axes.iter().try_for_each(|row| states("an axis of the lattice", row, n))?;
        positive("the radius of the lattice", self.radius)?;
        positive("the spacing of the lattice", self.spacing)?;
        if (2.0 * self.radius / self.spacing).powi(n as i32) > SEARCHED * MOST as f64 {
            return Err(format!("a lattice of the spacing {} has too many nodes", self.spacing));
        }
        Ok(self)
    }

    /// The nodes in the copula's trust domain; of mirror images one stands for all. They come in two halves, like the black
    /// and the white fields of a chessboard, each a coarser rule. None where they are more than `most`.
    fn nodes(&self, symmetry: &Symmetry, copula: &Copula, most: usize) -> Option<SampleNodes> {
        let n = self.centre.len();
        let mut halves = [(); 2].map(|()| (Vec::new(), Vec::new(), Vec::new()));
        let mut place = vec![0.0; n];
        let reach = (self.radius / self.spacing).powi(2);
        let along = |row: &[f64], place: &[f64]| row.iter().zip(place).map(|(l, k)| l * k).sum::<f64>();
        each(0, reach, &vec![1.0; n], &mut place, &mut |place| {
            let Some(images) = symmetry.stands_for(place) else { return true };
            let rows = self.axes.iter().zip(&self.centre);
            let x: Vec<f64> = rows.map(|(row, centre)| centre + self.spacing * along(row, place)).collect();
            if copula.trusts(&x) {
                // Mirror images have the same.
                let odd = |bits, k: &f64| bits << 1 | u32::from(k.rem_euclid(2.0) > 0.5);
                let (points, base, odds) = &mut halves[place.iter().sum::<f64>().rem_euclid(2.0) as usize];
                points.extend(x);
                base.push((images as f64).ln());
                odds.push(place.iter().rev().fold(0, odd));
            }
            halves[0].1.len() + halves[1].1.len() <= most
        })
        .then(|| {
            let log_volume = (0..n).map(|i| (self.spacing * self.axes[i][i]).ln()).sum::<f64>();
            let mut nodes = SampleNodes::empty(n);
            let (mut points, mut stream) = (Vec::new(), ChaCha8Rng::seed_from_u64(0));
            for (half, weights, odd) in &halves {
                // Shuffled, so that the first few of them are spread over the whole domain.
                let mut order: Vec<usize> = (0..weights.len()).collect();
                order.shuffle(&mut stream);
                points.extend(order.iter().flat_map(|k| &half[k * n..(k + 1) * n]));
                nodes.base.extend(order.iter().map(|k| weights[*k] + log_volume));
                nodes.odd.extend(order.iter().map(|k| odd[*k]));
                nodes.parts.push(nodes.base.len());
            }
            SampleNodes { points: States::from_values(n, points), ..nodes }
        })
    }
}

/// Visits the places, whole multiples of `steps` from entry `from` on, whose squares there sum up to `left` at most, while
/// `visit` goes on.
pub(super) fn each(
    from: usize,
    left: f64,
    steps: &[f64],
    place: &mut [f64],
    visit: &mut impl FnMut(&[f64]) -> bool,
) -> bool {
    if from == place.len() {
        return visit(place);
    }
    let step = steps[from];
    let reach = (left.max(0.0).sqrt() / step).floor();
    let mut k = -reach;
    while k <= reach {
        place[from] = k * step;
        if !each(from + 1, left - place[from] * place[from], steps, place, visit) {
            return false;
        }
        k += 1.0;
    }
    true
}
