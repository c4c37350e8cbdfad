//! The most likely densities on nested nodes, order by order.

use super::copula::Copula;
use super::fitting::Fitting;
use super::lattice::Lattice;
use super::likelihood::{Fit, Likelihood};
use super::lines::{Lines, within};
use super::nest::Nest;
use super::nodes::SampleNodes;
use super::thin::thin_state;
use super::{FunctionFamily, Samples};
use crate::closure::density::exponent::Exponent;
use crate::closure::pilot::Pilot;
use crate::closure::samples::UNEVEN;
use crate::functions::Functions;
use crate::numerics::Search;
use crate::states::States;

/// The most points of the states beside a thin one, by the number of these states, mirror images among the points. With 24 × 24
/// in place of 32 × 32 order 6 of a harvester lost 2e-3 nats, and 48 × 48 gained 3e-4.
const POINTS: [usize; 4] = [40, 1024, 9600, 9600];
/// The most nodes times the square of the number of functions, for the fit of an order and for that which it is compared with: the
/// work of one step of their search, half a second.
const MOST_WORK: f64 = 6e9;
/// Nodes on a line along a thin state, an even number: half a standard deviation apart.
const ALONG: usize = 56;
/// The most times that lines along a thin state are laid for one density.
const LAID: usize = 4;
/// The search for densities by which lines along a thin state are laid, and for those of a lower or higher order: its tolerance
/// is in standard deviations of ln p.
const LAYING: Search = Search { tolerance: 3e-3, most: 40 };
/// The search on a thin state for the density of the order asked for: its tolerance is in standard deviations of ln p.
const SEARCH: Search = Search { tolerance: 1e-5, most: 60 };

/// A fit on nested nodes.
#[derive(Clone, Debug)]
pub(super) struct Nested {
    pub(super) nest: Nest,
    pub(super) nodes: SampleNodes,
    pub(super) fit: Fit,
}

/// A fit of an order, and that of another one that it is compared with: two orders higher, or two lower where that has none.
#[derive(Clone, Debug)]
pub(super) struct OnLines {
    pub(super) own: Nested,
    pub(super) other: Nested,
    /// Whether the other one is of the higher order, whose functions are those compared with.
    pub(super) above: bool,
}

/// The points of the other states, and where the density of the last order has its mass on the lines through these.
struct Sheet {
    state: usize,
    /// On a lattice of the others.
    ground: SampleNodes,
    lattice: Lattice,
    /// The trust domain of the others.
    others: Copula,
    lines: Lines,
    /// The pilot's range of the thin state.
    range: [f64; 2],
}

impl Fitting<'_> {
    /// The fits of two lists of functions on nested nodes, each where its own density has its mass. None without a thin state, or where
    /// the nodes do not resolve the density.
    pub(super) fn on_lines(&self, [space, comparing]: [&Functions; 2]) -> Option<OnLines> {
        let Samples { pilot, family, order, .. } = self.samples;
        if !family.corners().is_empty() || family.has_folds() {
            return None;
        }
        let mut sheet = Sheet::new(pilot, family, thin_state(&pilot.states, family)?, space.len())?;
        let (mut start, mut below) = (Vec::new(), None);
        let mut fitted =
            |space: &Functions, search| sheet.fitted(space, &self.means[..space.len()], &mut start, search);
        for lower in (2..order).step_by(2) {
            below = Some(fitted(&family.functions(lower), LAYING)?);
        }
        let own = fitted(space, SEARCH)?;
        let likelihood = Likelihood { nodes: &own.nodes, space: comparing, corners: &[], walls: &[] };
        let uneven = likelihood.unevenness(&own.fit.masses);
        if uneven > UNEVEN {
            return None;
        }
        let affordable = (own.nodes.base.len() as f64) < most_nodes(comparing.len());
        let above = affordable.then(|| fitted(comparing, LAYING)).flatten();
        let above = above.filter(|above| above.fit.converged);
        match (above, below) {
            (Some(other), _) => Some(OnLines { own, other, above: true }),
            (None, Some(other)) => Some(OnLines { own, other, above: false }),
            (None, None) => None,
        }
    }
}

/// The most nodes for so many functions.
fn most_nodes(functions: usize) -> f64 {
    MOST_WORK / (functions as f64).powi(2)
}

impl Sheet {
    /// For so many functions. None where no lattice of the other states has few enough points.
    fn new(pilot: &Pilot, family: &FunctionFamily, state: usize, functions: usize) -> Option<Self> {
        let n = pilot.states.dimension();
        let mut others = States::with_capacity(n - 1, pilot.states.len());
        for x in &pilot.states {
            let mut x = x.to_vec();
            x.remove(state);
            others.push(&x);
        }
        let others = Pilot::of(others, pilot.interval);
        let symmetry = family.symmetry().without(state);
        let trusted = Copula::new(&others, &symmetry)?;
        let points = (POINTS.get(n - 2)? / symmetry.count()).min(most_nodes(functions) as usize / ALONG);
        let (lattice, ground) = Lattice::finest(&others, &symmetry, &trusted, points)?;
        let mut points = States::with_capacity(n, ground.points.len());
        for x in &ground.points {
            let mut x = x.to_vec();
            x.insert(state, 0.0);
            points.push(&x);
        }
        let lines = Lines::regressed(state, points, &pilot.states)?;
        let ends = |[low, high]: [f64; 2], x: &[f64]| [low.min(x[state]), high.max(x[state])];
        let [low, high] = pilot.states.iter().fold([f64::INFINITY, f64::NEG_INFINITY], ends);
        let far = high.max(-low);
        let range = if family.symmetry().flips(state) { [-far, far] } else { [low, high] };
        Some(Sheet { state, ground, lattice, others: trusted, lines, range })
    }

    /// Nodes between some ends of the lines.
    fn nodes(&self, ends: Vec<[f64; 2]>) -> (Nest, SampleNodes) {
        let (n, along) = (self.lines.points.dimension(), ALONG);
        let (points, volumes) = (self.lines.points.clone(), self.ground.base.clone());
        let (state, lattice, others) = (self.state, self.lattice.clone(), self.others.clone());
        let nest = Nest { state, along, points, volumes, ends, lattice, others, beyond: 0.0, lines: Vec::new() };
        let (points, base) = nest.nodes();
        let odd = |odd: u32| (0..along as u32).map(move |k| odd | (k & 1) << (n - 1));
        let odd = self.ground.odd.iter().copied().flat_map(odd).collect();
        let parts = self.ground.parts.iter().map(|end| end * along).collect();
        (nest, SampleNodes { points, base, parts, odd, thin: true })
    }

    /// The fit of some functions, from the coefficients of fewer of them on, on lines that are laid where exp(Q) has its mass.
    fn fitted(&mut self, space: &Functions, means: &[f64], start: &mut Vec<f64>, search: Search) -> Option<Nested> {
        start.resize(space.len() + 1, 0.0);
        let (mut ends, mut steps) = (self.lines.ends(self.range), 0);
        for laid in 1.. {
            let (nest, nodes) = self.nodes(ends);
            let likelihood = Likelihood { nodes: &nodes, space, corners: &[], walls: &[] };
            let fit = likelihood.most_likely(means, start.clone(), LAYING)?;
            steps += fit.steps;
            start.clone_from(&fit.a);
            let coefficients = fit.a[1..].to_vec();
            let exponent = Exponent { known: Vec::new(), space: space.clone(), constant: 0.0, coefficients };
            let masses: Vec<f64> = fit.masses.chunks(nest.along).map(|line| line.iter().sum()).collect();
            let lines = self.lines.following(&exponent, &nest.covered());
            let settled = self.lines.are_nearly(&lines, &masses);
            self.lines = lines;
            if settled || laid == LAID {
                let fit = likelihood.most_likely(means, start.clone(), search)?;
                steps += fit.steps;
                start.clone_from(&fit.a);
                return Some(Nested { nest, nodes, fit: Fit { steps, ..fit } });
            }
            // Beyond the last nodes this exp(Q) may rise again.
            ends = within(&self.lines.ends(self.range), &nest.covered());
        }
        None
    }
}
