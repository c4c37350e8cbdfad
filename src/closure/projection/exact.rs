//! Densities that are exact, in one state and two: whether there is one next to the reference, and its integrals.

use crate::closure::candidates::{Retained, Scoring};
use crate::closure::density::content::{Content, Integrals};
use crate::closure::density::exponent::Exponent;
use crate::closure::discretisation::nodes::{self, Nodes};
use crate::closure::discretisation::panels::{ResolvedRules, resolved};
use crate::closure::discretisation::trust_domain::TrustDomain;
use crate::closure::discretisation::{Discretisation, lines, walled};
use crate::closure::nodal::NodalClosure;
use crate::closure::projection::on_states::{exact_near, may_be_exact};
use crate::closure::projection::{distance, project, tempered};
use crate::closure::reference::scaled_mass;
use crate::closure::space::orthonormal::Orthonormal;
use crate::closure::{FINE_NODES, FINE_REFERENCE, FULL_DROP};
use crate::numerics::Rule;
use crate::states::States;

/// The largest factor by which the domain is widened for an exact density on Gauss nodes.
const EXACT_FOLLOWED: f64 = 3.0;
/// The orders at which known densities are exact: those below the order of the closure are tried.
const LOWER_ORDERS: [u32; 4] = [2, 4, 6, 8];
/// A density whose L¹ distance from the reference exceeds the reference's own error by this factor is not exact. Halved, it
/// misses the exact density of two wells at order 6.
const POLISHABLE: f64 = 30.0;
/// Two rules for an exact density agree to this part of its mass and second moments.
const EXACT: f64 = 1e-10;
/// An exact density has no known integrals where two rules differ by more than this part of its mass and second moments.
const UNKNOWN: f64 = 1e-6;

impl NodalClosure {
    /// The exact density of the lowest order next to the reference: the equations of a higher one are all but singular at it. On a
    /// lattice the states have shown before that there is none.
    pub(in crate::closure) fn exact_at(&self, order: u32, scoring: &Scoring<'_>, kept: &Retained) -> Option<Exponent> {
        if self.lattice.is_some() || !may_be_exact(&self.problem) {
            return None;
        }
        let family = self.discretisation.family.without_kinks();
        // The distance of an exact density from the reference is the reference's own error.
        let near = POLISHABLE * scoring.reference.doubt + FINE_REFERENCE;
        let measure = tempered(&scoring.target, &kept.weights, 1.0);
        LOWER_ORDERS.into_iter().filter(|lower| *lower < order).chain([order]).find_map(|order| {
            let space = family.functions(order);
            let functions = Orthonormal::new(nodes::values(&space, &kept.points), &measure)?;
            let fit = project((&functions, functions.values.as_ref()), &scoring.fixed, &scoring.target, &measure)?;
            if distance(&fit.logarithm, &scoring.target, &kept.weights) > near {
                return None;
            }
            let start = Exponent { known: Vec::new(), space, constant: 0.0, coefficients: fit.coefficients };
            exact_near(&self.problem, &self.pilot.states, &start)
        })
    }

    /// An exact density that was found by so many linear systems: it is its own reference, and its trust domain extends as far as it
    /// falls. None where it has no integral there.
    pub(in crate::closure) fn exact(&self, order: u32, mut exponent: Exponent, solved: usize) -> Option<Content> {
        let discretisation = &self.discretisation;
        let found = if self.lattice.is_some() {
            let Discretisation { domain, nodes, lines, .. } = discretisation;
            Integrated { domain: domain.clone(), nodes: nodes.clone(), lines: lines.clone(), apart: 0.0 }
        } else if discretisation.family.is_smooth() {
            Integrated::within(&exponent, &discretisation.domain)?
        } else {
            let domain = followed(&discretisation.domain, &exponent);
            let rules = walled::rules(&domain);
            let nodes = Nodes::tensor(&domain, rules.clone());
            Integrated { domain, nodes, lines: rules, apart: 0.0 }
        };
        let Integrated { domain, nodes, lines, mut apart } = found;
        exponent.constant += log_normaliser(&exponent, &nodes);
        if self.lattice.is_none() {
            apart += domain.mass_beyond(|x| exponent.value(x));
        }
        let unknowns = exponent.coefficients.len();
        let integrals = self.integrals(&exponent, ResolvedRules { rules: nodes.rules, apart }, lines)?;
        let lattice = self.lattice.as_ref().map(|(lattice, _)| lattice.clone());
        let provenance = self.provenance(order, unknowns, solved);
        Some(Content { lattice, provenance, ..Content::exact(exponent, domain, integrals, apart) })
    }
}

/// The content of an exact density in open space that was found without nodes, integrated about the region that a pilot has visited.
pub(in crate::closure) fn exact_about(mut exponent: Exponent, region: &TrustDomain) -> Option<Content> {
    let Integrated { domain, nodes, lines, apart } = Integrated::within(&exponent, region)?;
    exponent.constant += log_normaliser(&exponent, &nodes);
    let error = apart + domain.mass_beyond(|x| exponent.value(x));
    let integrals = Integrals::Panels { rules: nodes.rules, lines, apart: error };
    Some(Content::exact(exponent, domain, integrals, error))
}

/// −ln of the mass of exp(Q) on some nodes.
fn log_normaliser(exponent: &Exponent, nodes: &Nodes) -> f64 {
    let (top, mass) = scaled_mass(&exponent.values(&nodes.points), &nodes.weights);
    -top - mass.ln()
}

/// A domain about a region as far as exp(Q) falls.
fn followed(region: &TrustDomain, exponent: &Exponent) -> TrustDomain {
    let log = |points: &States| exponent.values(points);
    region.following(log, FULL_DROP, EXACT_FOLLOWED)
}

/// Where an exact density is integrated: its domain with nodes, rules along the states, and what two rules differ by.
struct Integrated {
    domain: TrustDomain,
    nodes: Nodes,
    lines: Vec<Rule>,
    apart: f64,
}

impl Integrated {
    /// About the region that a pilot has visited, and wherever else in a larger ellipse exp(Q) is not small. None where no rule of two
    /// agrees with the other.
    fn within(exponent: &Exponent, region: &TrustDomain) -> Option<Self> {
        let own = followed(region, exponent);
        let farthest = EXACT_FOLLOWED * region.reach.iter().copied().fold(0.0, f64::max);
        let ellipse = TrustDomain::whole(region.centre.clone(), region.scale.clone(), farthest);
        let elsewhere = ellipse.above(|points| exponent.values(points), FULL_DROP);
        Self::over(exponent, own.joined(&elsewhere))
    }

    fn over(exponent: &Exponent, domain: TrustDomain) -> Option<Self> {
        let given = Nodes::gauss(&domain, FINE_NODES[domain.centre.len().min(2) - 1]).rules;
        let found = resolved(&domain, |points| exponent.values(points), &given, EXACT);
        let lines = if found.rules == given { lines(&domain) } else { found.rules.clone() };
        let nodes = Nodes::tensor(&domain, found.rules);
        (found.apart <= UNKNOWN).then_some(Integrated { domain, nodes, lines, apart: found.apart })
    }
}
