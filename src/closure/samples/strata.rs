//! Nodes next to walls on one line in a few states: Gauss nodes across the line, a lattice along it.

use super::copula::Copula;
use super::lattice;
use super::nodes::SampleNodes;
use super::wall_nodes::WallNodes;
use crate::closure::pilot::Pilot;
use crate::functions::Corner;
use crate::numerics::Rule;
use crate::parallel;
use crate::states::States;
use crate::walls::Contact;
use nalgebra::{Cholesky, DMatrix, DVector};

/// The most states in which nodes next to walls are Gauss nodes across the walls' line and a lattice along it: a bound on work.
const MOST_STATES: usize = 4;
/// Nodes next to walls are tried as far out as so many times the farthest state. With 1.1 a part of the trust domain had no
/// nodes, and there one density of thirty rose to a spike.
const BEYOND: f64 = 1.4;
/// Gauss nodes in the displacement from a wall to the farthest states; between two walls either half has two thirds of them.
const ACROSS: usize = 28;
/// Gauss nodes in the speed of impacts on a wall.
const SPEEDS: usize = 32;
/// The spacing of nodes in the rate of the displacement that meets walls, relative to that in the other states: next to a wall
/// the density varies faster in this rate.
const FINER: f64 = 0.5;
/// The finest spacing of the lattice along the walls' line, in standard deviations.
const FINEST: f64 = 0.2;
/// The coarsest spacing of the lattice along the walls' line, in standard deviations.
const COARSEST: f64 = 0.9;
/// The most places of the lattice for each node that there may be: a bound on work where the states have heavy tails.
const SEARCHED: usize = 16;

/// The states as (y, w, z): the displacement that meets the walls, its rate, and the others, about which the density of the
/// latter two is centred at each y.
#[derive(Clone, Debug)]
pub(super) struct Strata<'a> {
    contacts: &'a [Contact],
    copula: &'a Copula,
    /// The displacements and the velocities whose differences are y and w.
    bodies: [(usize, usize); 2],
    paired: bool,
    /// The states z.
    others: Vec<usize>,
    /// The means of y and of (w, z), and the regression of the latter on y.
    middle: f64,
    centre: DVector<f64>,
    slope: DVector<f64>,
    /// L of the covariance L Lᵀ that is left of (w, z).
    axes: DMatrix<f64>,
    /// The range of y between the walls, and the largest distance |L⁻¹ …| of a state.
    range: [f64; 2],
    radius: f64,
}

impl<'a> Strata<'a> {
    /// None where walls are on several lines, or the states on a surface, or too many for a lattice.
    pub(super) fn new(pilot: &Pilot, contacts: &'a [Contact], copula: &'a Copula) -> Option<Self> {
        let (first, second) = contacts.first()?.bodies();
        if contacts.iter().any(|contact| contact.bodies() != (first, second)) {
            return None;
        }
        let n = pilot.states.dimension();
        if n > MOST_STATES {
            return None;
        }
        let others = (0..n).filter(|&i| i != first.0 && i != first.1).collect();
        let bodies = [first, second.unwrap_or(first)];
        let mut strata = Strata {
            contacts,
            copula,
            bodies,
            paired: second.is_some(),
            others,
            middle: 0.0,
            centre: DVector::zeros(n - 1),
            slope: DVector::zeros(n - 1),
            axes: DMatrix::zeros(n - 1, n - 1),
            range: [f64::INFINITY, f64::NEG_INFINITY],
            radius: 0.0,
        };
        let count = pilot.states.len() as f64;
        let mut square = 0.0;
        for x in &pilot.states {
            let (y, rest) = strata.split(x);
            strata.middle += y / count;
            strata.centre += rest / count;
            strata.range = [strata.range[0].min(y), strata.range[1].max(y)];
        }
        for x in &pilot.states {
            let (y, rest) = strata.split(x);
            strata.slope += (y - strata.middle) * (rest - &strata.centre);
            square += (y - strata.middle).powi(2);
        }
        strata.slope /= square;
        let mut covariance = DMatrix::zeros(n - 1, n - 1);
        for x in &pilot.states {
            let off = strata.off(x);
            covariance.ger(1.0 / count, &off, &off, 1.0);
        }
        strata.axes = Cholesky::new(covariance)?.l();
        let length = |x: &[f64]| strata.axes.solve_lower_triangular(&strata.off(x)).map_or(0.0, |z| z.norm());
        // The nodes fill the copula's trust domain, which ends a little beyond the states; walls end the range.
        strata.radius = BEYOND * pilot.states.iter().map(length).fold(0.0, f64::max);
        let beyond = (BEYOND - 1.0) * (strata.range[1] - strata.range[0]);
        strata.range = [strata.range[0] - beyond, strata.range[1] + beyond];
        for contact in contacts {
            let side = usize::from(!contact.wall.is_above());
            strata.range[side] = contact.wall.offset();
        }
        Some(strata)
    }

    /// y and (w, z).
    fn split(&self, x: &[f64]) -> (f64, DVector<f64>) {
        let [first, second] = self.bodies;
        let [y, w] =
            if self.paired { [x[first.0] - x[second.0], x[first.1] - x[second.1]] } else { [x[first.0], x[first.1]] };
        let rest = std::iter::once(w).chain(self.others.iter().map(|&i| x[i]));
        (y, DVector::from_iterator(self.others.len() + 1, rest))
    }

    /// (w, z) less its centre at y.
    fn off(&self, x: &[f64]) -> DVector<f64> {
        let (y, rest) = self.split(x);
        rest - &self.centre - &self.slope * (y - self.middle)
    }

    /// Enters the state of y and a place, the multiples of the axes.
    fn place(&self, y: f64, place: &[f64], x: &mut [f64]) {
        let along = |i: usize| {
            let axis: f64 = (0..=i).map(|k| self.axes[(i, k)] * place[k]).sum();
            self.centre[i] + self.slope[i] * (y - self.middle) + axis
        };
        self.others.iter().enumerate().for_each(|(k, &i)| x[i] = along(k + 1));
        let [first, second] = self.bodies;
        let [from_y, from_w] = if self.paired { [x[second.0], x[second.1]] } else { [0.0; 2] };
        (x[first.0], x[first.1]) = (from_y + y, from_w + along(0));
    }

    /// Gauss nodes in y, close to each other next to walls, where the density varies with the cube root of the distance.
    fn across(&self) -> Vec<(f64, f64)> {
        let [low, high] = self.range;
        let walled = [true, false].map(|above| self.contacts.iter().any(|contact| contact.wall.is_above() == above));
        let half = |from: f64, to: f64, count: usize| -> Vec<(f64, f64)> {
            let rule = Rule::legendre(count);
            let node = |(t, w): (f64, f64)| {
                let s = 0.5 * (t + 1.0);
                (from + (to - from) * s.powi(3), 0.5 * w * 3.0 * s * s * (to - from).abs())
            };
            rule.iter().map(node).collect()
        };
        let count = ACROSS;
        match walled {
            [true, true] => {
                let middle = 0.5 * (low + high);
                [half(low, middle, count * 2 / 3), half(high, middle, count * 2 / 3)].concat()
            }
            [true, false] => half(low, high, count),
            _ => half(high, low, count),
        }
    }

    /// The steps of a lattice of the spacing h along each axis. The first is that of w, in which the density varies faster next to
    /// a wall.
    fn steps(&self, h: f64) -> Vec<f64> {
        std::iter::once(h * FINER).chain(self.others.iter().map(|_| h)).collect()
    }

    /// Visits the places of a lattice of the spacing h at a y, with the sum of the place's whole numbers, while `visit` goes on.
    fn each_place(&self, y: f64, h: f64, mut visit: impl FnMut(&[f64], f64) -> bool) -> bool {
        let steps = self.steps(h);
        let [mut place, mut x] = [self.others.len() + 1, self.others.len() + 2].map(|size| vec![0.0; size]);
        lattice::each(0, self.radius * self.radius, &steps, &mut place, &mut |place| {
            self.place(y, place, &mut x);
            visit(&x, place.iter().zip(&steps).map(|(p, step)| (p / step).round()).sum())
        })
    }

    /// The finest nodes that are at most `most`, in two halves, each a coarser rule; with the nodes on each wall. None where
    /// they would be too coarse.
    pub(super) fn finest(&self, corners: &[Corner], most: usize) -> Option<(SampleNodes, Vec<WallNodes>)> {
        let mut h = COARSEST;
        let mut count = self.count(h, most)?;
        loop {
            let next =
                (h * (count as f64 / most as f64).powf((self.others.len() as f64 + 1.0).recip()).max(0.7)).max(FINEST);
            let Some(more) = (next < 0.97 * h).then(|| self.count(next, most)).flatten() else { break };
            (h, count) = (next, more);
        }
        Some((self.nodes(h, corners), self.on_walls(h, corners)))
    }

    /// How many nodes there are, unless more than `most`, or few of the places of the lattice.
    fn count(&self, h: f64, most: usize) -> Option<usize> {
        let across = self.across();
        let searched = SEARCHED * most / across.len();
        let counts = parallel::map(across.len(), |k| {
            let [mut count, mut places] = [0; 2];
            let counted = self.each_place(across[k].0, h, |x, _| {
                places += 1;
                count += usize::from(self.copula.trusts(x));
                count <= most && places <= searched
            });
            counted.then_some(count)
        });
        counts.into_iter().sum::<Option<usize>>().filter(|count| *count <= most)
    }

    fn nodes(&self, h: f64, corners: &[Corner]) -> SampleNodes {
        let n = self.others.len() + 2;
        let volume = self.axes.diagonal().product() * self.steps(h).iter().product::<f64>();
        let across = self.across();
        let along = parallel::map(across.len(), |k| {
            let (y, weight) = across[k];
            let mut halves = [(); 2].map(|()| (Vec::new(), Vec::new()));
            self.each_place(y, h, |x, parity| {
                if self.copula.trusts(x) {
                    let (points, bases) = &mut halves[parity.rem_euclid(2.0) as usize];
                    points.extend_from_slice(x);
                    bases.push((weight * volume).ln() + known(corners, x));
                }
                true
            });
            halves
        });
        let mut nodes = SampleNodes::empty(n);
        let mut points = Vec::new();
        for half in 0..2 {
            for (at, bases) in along.iter().map(|halves| &halves[half]) {
                points.extend(at);
                nodes.base.extend(bases);
            }
            nodes.parts.push(nodes.base.len());
        }
        SampleNodes { points: States::from_values(n, points), ..nodes }
    }

    fn on_walls(&self, h: f64, corners: &[Corner]) -> Vec<WallNodes> {
        let n = self.others.len() + 2;
        let steps = self.steps(h);
        let volume: f64 = steps.iter().enumerate().skip(1).map(|(i, step)| self.axes[(i, i)] * step).product();
        let of = |contact: &Contact| {
            let y = contact.wall.offset();
            let side = if contact.wall.is_above() { -1.0 } else { 1.0 };
            let mean = self.centre[0] + self.slope[0] * (y - self.middle);
            let fastest = self.radius * self.axes[(0, 0)] + side * mean;
            let mut nodes = WallNodes::empty(n);
            let [mut place, mut x] = [n - 1, n].map(|size| vec![0.0; size]);
            for (t, w) in Rule::legendre(SPEEDS).iter() {
                let s = 0.5 * (t + 1.0);
                let (speed, weight) = (fastest * s * s, w * s * fastest);
                place[0] = (side * speed - mean) / self.axes[(0, 0)];
                let left = self.radius * self.radius - place[0] * place[0];
                lattice::each(1, left, &steps, &mut place, &mut |place| {
                    self.place(y, place, &mut x);
                    contact.close(&mut x);
                    if self.copula.trusts(&x) {
                        nodes.push((speed * weight * volume).ln(), &x, contact, |x| known(corners, x));
                    }
                    true
                });
            }
            nodes
        };
        self.contacts.iter().map(of).collect()
    }
}

/// What is known of ln p.
fn known(corners: &[Corner], x: &[f64]) -> f64 {
    corners.iter().map(|corner| corner.singular_value(x)).sum()
}
