//! The part of a closure that is the same at every order of one system: the domain of the density, and the nodes for
//! integrals.
//!
//! - `trust_domain`: the region that the pilot has visited;
//! - `nodes`: Gauss nodes there; `table`: the functions and their images under the operator, at the nodes;
//! - `likelihood`: the first guess of ln p;
//! - `walled`: the same next to walls.

pub(super) mod likelihood;
pub(super) mod nodes;
pub(super) mod table;
pub(super) mod trust_domain;
pub(super) mod walled;

use super::density::exponent::{Exponent, known_value};
use super::pilot::Pilot;
use super::space::nested_spaces::{Smooth, SpaceFamily};
use super::space::{Corner, Functions};
use crate::fokker_planck::Local;
use crate::numerics::Rule;
use crate::problem::Problem;
use crate::states::States;
use likelihood::most_likely;
use nodes::Nodes;
use rayon::prelude::*;
use trust_domain::TrustDomain;

/// The degree of the polynomial that the pilot's states are fitted by.
const FIT: u32 = 8;
/// Nodes along each state for that fit, and for everything else, in one state and in two.
const COARSE: usize = 40;
pub(super) const FINE: [usize; 2] = [240, 80];
/// Up to this order, whose functions are smoother, fewer nodes suffice, and the answer is faster.
const LOW_ORDER: u32 = 5;
const LOW_ORDER_NODES: usize = 44;
/// Nodes on either side of 0 along a line.
const LINE: usize = 72;
/// The answer is defined where the reference is above e^−13.8 = 1e-6 of its peak.
const KEPT: f64 = 13.8;
/// The domain ends where the fit is e^−18 = 1.5e-8 of its peak, but not beyond 1.4 times the pilot's reach.
const DROP: f64 = 18.0;
const WIDENING: f64 = 1.4;

/// A jump that trajectories make where they meet a wall.
#[derive(Clone, Copy, Debug)]
pub(super) struct Passage {
    pub(super) before: [f64; 2],
    pub(super) after: [f64; 2],
    /// The flux through the wall for p = 1 times the quadrature weight.
    pub(super) weight: f64,
    /// r², by which p falls at the jump.
    pub(super) contraction: f64,
}

/// A system with its trust domain, the nodes in it, and the functions on it.
pub(super) struct Discretisation {
    pub(super) family: SpaceFamily,
    pub(super) domain: TrustDomain,
    pub(super) nodes: Nodes,
    /// The Fokker-Planck operator at the nodes.
    pub(super) locals: Vec<Local>,
    /// Rules along the states, for integrals over a single one; 0 is the edge of a panel.
    pub(super) lines: Vec<Rule>,
    pub(super) passages: Vec<Passage>,
    /// The values at the nodes of the part of ln p that no function here can follow.
    pub(super) fixed: Vec<f64>,
    /// The first guess of ln p, with that part.
    pub(super) guess: Exponent,
    /// The depth below its peak, in ln p, down to which the answer is defined.
    pub(super) drop: f64,
}

impl Discretisation {
    /// The discretisation of a system on the whole space.
    ///
    /// Its pilot ran at an inflated intensity, under which ln p is roughly divided by the inflation (exactly so for a Gibbs
    /// density): the most likely polynomial, multiplied back, is the first guess, and good in the tails as well. The nodes
    /// serve up to `highest_order`. `None` if the states cannot be fitted.
    pub(super) fn new(problem: &Problem, pilot: &Pilot, family: Smooth, highest_order: u32) -> Option<Self> {
        let met = TrustDomain::new(pilot, &family.symmetry, family.centre.clone(), [None, None], 1.0);
        let coarse = Nodes::gauss(&met, COARSE);
        let (centre, half_width) = met.box_around();
        let space = Smooth { centre, half_width, ..family.clone() }.functions(FIT);
        let guess = likeliest(space, Vec::new(), &coarse, &pilot.states, pilot.inflation)?;
        let domain = met.following(|x| guess.value(x), DROP, WIDENING);
        let states = problem.dimension();
        let along = if states == 2 && highest_order <= LOW_ORDER { LOW_ORDER_NODES } else { FINE[states.min(2) - 1] };
        let nodes = Nodes::gauss(&domain, along);
        let (centre, half_width) = domain.box_around();
        let family = SpaceFamily::Smooth(Smooth { centre, half_width, ..family });
        let (lines, locals, fixed) = (lines(&domain), locals(problem, &nodes), vec![0.0; nodes.len()]);
        let (passages, drop) = (Vec::new(), KEPT);
        Some(Discretisation { family, domain, nodes, locals, lines, passages, fixed, guess, drop })
    }

    /// The discretisation on the nodes of a lattice, with a first guess that is good already.
    pub(super) fn on_lattice(
        problem: &Problem,
        (domain, family): (TrustDomain, Smooth),
        (points, weights): (States, Vec<f64>),
        guess: Exponent,
    ) -> Self {
        let nodes = Nodes { points, weights, rules: Vec::new() };
        let (locals, fixed) = (locals(problem, &nodes), vec![0.0; nodes.len()]);
        let (family, lines, passages) = (SpaceFamily::Smooth(family), Vec::new(), Vec::new());
        Discretisation { family, domain, nodes, locals, lines, passages, fixed, guess, drop: f64::INFINITY }
    }

    /// Whether the nodes are those of a lattice, which ends where the density does: there is no edge to stay away from.
    pub(super) fn is_on_lattice(&self) -> bool {
        self.nodes.rules.is_empty()
    }

    /// The walls whose grazing impacts make the part of ln p that no function here can follow.
    pub(super) fn known(&self) -> &[Corner] {
        &self.guess.known
    }
}

/// The Fokker-Planck operator at nodes.
pub(super) fn locals(problem: &Problem, nodes: &Nodes) -> Vec<Local> {
    let local = |x: &[f64]| {
        let mut local = Local::new(x.len());
        problem.local(x, &mut local);
        local
    };
    nodes.points.par_iter().map(local).collect()
}

/// Rules across a domain along each state, in two panels that meet at 0 or in the middle.
pub(super) fn lines(domain: &TrustDomain) -> Vec<Rule> {
    let rule = Rule::legendre(LINE);
    let across = |&[low, high]: &[f64; 2]| {
        let middle = if low < 0.0 && high > 0.0 { 0.0 } else { (low + high) / 2.0 };
        let (left, right) = (rule.on(low, middle), rule.on(middle, high));
        Rule { nodes: [left.nodes, right.nodes].concat(), weights: [left.weights, right.weights].concat() }
    };
    domain.bounds().iter().map(across).collect()
}

/// The most likely Q of a space for a pilot's states, times `inflation`; a known part of ln p is kept as it is.
pub(super) fn likeliest(
    space: Functions,
    known: Vec<Corner>,
    nodes: &Nodes,
    states: &States,
    inflation: f64,
) -> Option<Exponent> {
    let mean = means(&space, states);
    let table = table::values(&space, &nodes.points);
    let fixed: Vec<f64> = nodes.points.iter().map(|x| known_value(&known, x)).collect();
    let a = most_likely(table.get(.., 1..), &fixed, &nodes.weights, &mean)?;
    Some(Exponent { known, space, constant: 0.0, coefficients: a.iter().map(|a| inflation * a).collect() })
}

/// States whose functions' values are added up at a time: sums of sums are the same on any number of threads.
const CHUNK: usize = 512;

/// The means of a space's functions over some states.
fn means(space: &Functions, states: &States) -> Vec<f64> {
    let sums = |chunk: &[f64]| {
        let (mut sums, mut values) = (vec![0.0; space.len()], vec![0.0; space.len()]);
        for x in chunk.chunks_exact(states.dimension()) {
            space.values(x, &mut values);
            sums.iter_mut().zip(&values).for_each(|(sum, value)| *sum += value);
        }
        sums
    };
    let parts: Vec<Vec<f64>> = states.par_chunks(CHUNK).map(sums).collect();
    (0..space.len()).map(|k| parts.iter().map(|part| part[k]).sum::<f64>() / states.len() as f64).collect()
}
