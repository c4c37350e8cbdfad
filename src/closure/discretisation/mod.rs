//! The part of a closure that is the same at every order of one system: the domain of the density, and the nodes for
//! integrals.
//!
//! - `trust_domain`: the region that the pilot has visited;
//! - `nodes`: Gauss nodes there, with the values of functions and their images under the operator;
//! - `panels`: rules for the integrals of a density that is found;
//! - `impulses`: jumps between nodes;
//! - `likelihood`: the first guess of ln p, by which the pilot's states are most likely;
//! - `walled`: the same next to walls.

pub(super) mod impulses;
pub(super) mod likelihood;
pub(super) mod nodes;
pub(super) mod panels;
pub(super) mod trust_domain;
pub(super) mod walled;

use super::density::exponent::Exponent;
use super::pilot::Pilot;
use super::space::nested_spaces::{Smooth, SpaceFamily};
use crate::closure::{FINE_NODES, KEPT_DROP};
use crate::fokker_planck::{ImpulseTerm, Local};
use crate::functions::Corner;
use crate::numerics::Rule;
use crate::parallel;
use crate::problem::Problem;
use crate::states::States;
use likelihood::likeliest;
use nodes::{NodalGenerator, Nodes};
use trust_domain::TrustDomain;

/// The largest factor by which the domain is widened where the first guess has not fallen enough at its edge.
const FOLLOWED: f64 = 1.4;
/// The domain ends where the first guess has fallen to e^−18 = 1.5e-8 of its peak. Halved or doubled, it makes an L¹ error of
/// nine closures of orders 4 to 8 up to 12 times as large, or 2 % smaller.
const DROP: f64 = 18.0;
/// Gauss nodes along each state for the first guess. Halved or doubled, it changes L¹ errors of nine closures of orders 4 to 8
/// by up to +5 % or +6 %.
const COARSE: usize = 40;
/// Up to this order, whose functions are smoother, fewer nodes suffice in two states, and the answer is faster. Halved or
/// doubled, it changes L¹ errors of nine closures of orders 4 to 8 by up to 0 or +5 %.
const LOW_ORDER: u32 = 5;
/// Gauss nodes along each of two states for low orders, without impulses and with them. Halved or doubled, it changes L¹ errors
/// of nine closures of orders 4 to 8 by up to +1 % or 0.
const LOW_ORDER_NODES: [usize; 2] = [44, 56];
/// Gauss nodes on either side of 0, or of the middle, along a line across the domain, for integrals over one state. None of
/// nine closures of orders 4 to 8 depends on it.
const LINE: usize = 72;
/// The degree of the polynomial that the pilot's states are fitted by, as the first guess of ln p.
const DEGREE: u32 = 8;

/// A jump that trajectories make where they meet a wall.
#[derive(Clone, Copy, Debug)]
pub(super) struct WallPassage {
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
    pub(super) passages: Vec<WallPassage>,
    /// Impulses, of which those that leave the domain are left out.
    pub(super) impulses: Vec<ImpulseTerm>,
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
    /// density): the most likely polynomial, multiplied back, is the first guess, and good in the tails as well. Under impulses it
    /// does not scale: there the guess is that of `own`, the pilot under the system's own intensities. The nodes serve up to
    /// `highest_order`. `None` if the states cannot be fitted.
    pub(super) fn new(
        problem: &Problem,
        [own, pilot]: [&Pilot; 2],
        family: Smooth,
        highest_order: u32,
    ) -> Option<Self> {
        let ends = impulses::ends(problem, pilot);
        let met = TrustDomain::new(pilot, &family.symmetry, family.centre.clone(), ends, 1.0);
        let coarse = Nodes::gauss(&met, COARSE);
        let (centre, half_width) = met.box_around();
        let space = Smooth { centre, half_width, ..family.clone() }.functions(DEGREE);
        let fitted = if problem.impulses().is_empty() { pilot } else { own };
        let guess = likeliest(space, Vec::new(), &coarse, &fitted.states, fitted.inflation)?;
        let domain = met.following(|points| guess.values(points), DROP, FOLLOWED);
        let states = problem.dimension();
        let along = if states == 2 && highest_order <= LOW_ORDER {
            // Impulses that leave the domain are cut off between nodes.
            LOW_ORDER_NODES[usize::from(!problem.impulses().is_empty())]
        } else {
            FINE_NODES[states.min(2) - 1]
        };
        let nodes = Nodes::gauss(&domain, along);
        let (centre, half_width) = domain.box_around();
        let family = SpaceFamily::Smooth(Smooth { centre, half_width, ..family });
        let (lines, locals, fixed) = (lines(&domain), locals(problem, &nodes.points), vec![0.0; nodes.len()]);
        let (passages, impulses, drop) = (Vec::new(), problem.operator().impulse_terms(), KEPT_DROP);
        Some(Discretisation { family, domain, nodes, locals, lines, passages, impulses, fixed, guess, drop })
    }

    /// The discretisation on the nodes of a lattice, with a first guess that is good already.
    pub(super) fn on_lattice(
        problem: &Problem,
        (domain, family): (TrustDomain, Smooth),
        (points, weights): (States, Vec<f64>),
        guess: Exponent,
    ) -> Self {
        let nodes = Nodes { points, weights, rules: Vec::new() };
        let (locals, fixed) = (locals(problem, &nodes.points), vec![0.0; nodes.len()]);
        let (family, lines, passages) = (SpaceFamily::Smooth(family), Vec::new(), Vec::new());
        let (impulses, drop) = (Vec::new(), f64::INFINITY);
        Discretisation { family, domain, nodes, locals, lines, passages, impulses, fixed, guess, drop }
    }

    /// The generator at the nodes.
    pub(super) fn generator(&self) -> NodalGenerator<'_> {
        let Discretisation { domain, nodes: Nodes { points, .. }, locals, passages, impulses, .. } = self;
        NodalGenerator { points, locals, passages, impulses, domain }
    }

    /// Whether the nodes are those of a lattice, which ends where the density does: there is no edge to stay away from.
    pub(super) fn is_on_lattice(&self) -> bool {
        self.nodes.rules.is_empty()
    }

    /// Whether the moment equations of exp(Q) have a second expression, by its residual: neither impacts nor impulses have one.
    pub(super) fn has_residual(&self) -> bool {
        self.passages.is_empty() && self.impulses.is_empty()
    }

    /// The residual of exp(Q) at the nodes.
    pub(super) fn residuals(&self, q: &Exponent) -> Vec<f64> {
        q.residuals(&self.nodes.points, |i| &self.locals[i])
    }

    /// The walls whose grazing impacts make the part of ln p that no function here can follow.
    pub(super) fn known(&self) -> &[Corner] {
        &self.guess.known
    }
}

/// The Fokker-Planck operator at some points.
pub(super) fn locals(problem: &Problem, points: &States) -> Vec<Local> {
    let local = |x: &[f64]| {
        let mut local = Local::new(x.len());
        problem.local(x, &mut local);
        local
    };
    parallel::map(points.len(), |k| local(points.state(k)))
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
