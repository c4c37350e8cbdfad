//! The most likely density on the nodes that resolve it: a lattice, Gauss nodes across a wall's line, or draws.

use super::importance::ImportanceRule;
use super::lattice::Lattice;
use super::likelihood::{Fit, Likelihood};
use super::nodes::SampleNodes;
use super::strata::Strata;
use super::wall_nodes::WallNodes;
use super::{FunctionFamily, Samples};
use crate::closure::density::exponent::Exponent;
use crate::closure::samples::{FEWER, FEWEST_NODES, NODES_EACH, ROUGH, UNEVEN};
use crate::closure::{EVEN_LATTICE, LIKELIHOOD_SEARCH, MOST_NODES};
use crate::functions::Functions;
use crate::numerics::Search;

/// The fewest draws of the maximisation next to walls.
const FEWEST_AT_WALLS: usize = 1 << 17;
/// Draws of the maximisation next to walls for each function. With 234 for each, the search found a spike.
const NODES_EACH_AT_WALLS: usize = 450;
/// Draws of impacts on each wall.
const ON_WALL: usize = 1 << 14;

/// A mask of the seed, which makes the draws of the maximisation independent of those of the answers.
const FITTED: u64 = 0x9e37_79b9_7f4a_7c15;

/// A fit of means.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fitting<'a> {
    pub(super) samples: Samples<'a>,
    /// Of the functions in order.
    pub(super) means: &'a [f64],
}

/// The fit and its nodes.
#[derive(Clone, Debug)]
pub(super) struct NodalFit {
    /// That of the nodes, if they are on one.
    pub(super) lattice: Option<Lattice>,
    pub(super) nodes: SampleNodes,
    /// The nodes on each wall.
    pub(super) walls: Vec<WallNodes>,
    pub(super) fit: Fit,
}

impl Fitting<'_> {
    /// The fit of the first of two lists of functions; the means of the other one decide whether nodes resolve the density.
    /// None where there is no fit.
    pub(super) fn best(&self, lists: [&Functions; 2]) -> Option<NodalFit> {
        if self.samples.family.corners().is_empty() {
            self.on_lattice(lists).or_else(|| self.on_draws(lists))
        } else {
            self.on_strata(lists).or_else(|| self.on_draws(lists))
        }
    }

    fn fitted(&self, space: &Functions, nodes: SampleNodes, walls: Vec<WallNodes>, search: Search) -> Option<NodalFit> {
        let corners = self.samples.family.corners();
        let (mut steps, mut start) = (0, Vec::new());
        let mut most_likely = |space: &Functions, search| {
            start.resize(space.len() + 1, 0.0);
            let means = &self.means[..space.len()];
            let likelihood = Likelihood { nodes: &nodes, space, corners, walls: &walls };
            let fit = likelihood.most_likely(means, start.clone(), search)?;
            steps += fit.steps;
            start.clone_from(&fit.a);
            Some(Fit { steps, ..fit })
        };
        // Order by order, each from the one before; next to walls their functions are not nested.
        let lower = (2..self.samples.order).step_by(2).filter(|_| corners.is_empty());
        for order in lower {
            most_likely(&self.samples.family.functions(order), ROUGH)?;
        }
        let fit = most_likely(space, search)?;
        Some(NodalFit { lattice: None, nodes, walls, fit })
    }

    /// The largest difference of a mean by one part of the nodes from that by all, in standard deviations.
    fn unevenness(&self, NodalFit { nodes, walls, fit, .. }: &NodalFit, space: &Functions) -> f64 {
        Likelihood { nodes, space, corners: self.samples.family.corners(), walls }.unevenness(&fit.masses)
    }

    /// Fewer nodes where they are as good as more; where they are not, the search on them may not end.
    fn on_lattice(&self, [space, comparing]: [&Functions; 2]) -> Option<NodalFit> {
        let most = (NODES_EACH * space.len()).max(NODES_EACH / 2 * comparing.len()).clamp(FEWEST_NODES, MOST_NODES);
        let on = |most, uneven, search| {
            let (lattice, nodes) =
                Lattice::finest(self.samples.pilot, self.samples.family.symmetry(), self.samples.copula, most)?;
            let fitted = self.fitted(space, nodes, Vec::new(), search)?;
            let resolved = self.unevenness(&fitted, comparing) < uneven;
            resolved.then_some(NodalFit { lattice: Some(lattice), ..fitted })
        };
        let search = LIKELIHOOD_SEARCH;
        let few = on(most / FEWER, EVEN_LATTICE, Search { most: search.most / 2, ..search });
        few.filter(|fitted| fitted.fit.converged).or_else(|| on(most, UNEVEN, search))
    }

    /// Next to walls on one line, in up to four states.
    fn on_strata(&self, [space, comparing]: [&Functions; 2]) -> Option<NodalFit> {
        let contacts = self.samples.problem.contacts();
        let strata = Strata::new(self.samples.pilot, &contacts, self.samples.copula)?;
        let (nodes, walls) = strata.finest(self.samples.family.corners(), MOST_NODES)?;
        let fitted = self.fitted(space, nodes, walls, LIKELIHOOD_SEARCH)?;
        (self.unevenness(&fitted, comparing) < UNEVEN).then_some(fitted)
    }

    fn on_draws(&self, [space, comparing]: [&Functions; 2]) -> Option<NodalFit> {
        let corners = self.samples.family.corners();
        let count = space.len();
        let most = if corners.is_empty() {
            (NODES_EACH * count).max(NODES_EACH / 2 * comparing.len()).clamp(FEWEST_NODES, MOST_NODES)
        } else {
            // About as many stay on this side of all walls.
            (NODES_EACH_AT_WALLS * count).clamp(FEWEST_AT_WALLS, MOST_NODES) * (1 + corners.len())
        };
        let coefficients = vec![0.0; count];
        let nothing = Exponent { known: corners.to_vec(), space: space.clone(), constant: 0.0, coefficients };
        let seed = self.samples.seed ^ FITTED;
        let nodes = ImportanceRule::new(&nothing, self.samples.copula, most, seed)?.nodes().ok()?;
        let contacts = self.samples.problem.contacts();
        let on_wall = |(wall, contact)| {
            let seed = seed.rotate_left(1 + wall as u32);
            WallNodes::new(self.samples.pilot, (wall, contact), corners, ON_WALL, seed)
        };
        let walls = contacts.iter().enumerate().map(on_wall).collect::<Option<_>>()?;
        self.fitted(space, nodes, walls, LIKELIHOOD_SEARCH)
    }
}

/// The largest difference of a mass or a second moment by one part of the nodes of a lattice from that by all, in standard deviations.
pub(in crate::closure) fn unevenness(nodes: &SampleNodes, family: &FunctionFamily, masses: &[f64]) -> f64 {
    Likelihood { nodes, space: &family.functions(2), corners: &[], walls: &[] }.unevenness(masses)
}
