//! The integrals of an exact density in one state and two, which was found without nodes.

use super::content::{Content, Integrals};
use super::exponent::Exponent;
use crate::closure::discretisation::nodes::Nodes;
use crate::closure::discretisation::panels::resolved;
use crate::closure::discretisation::trust_domain::TrustDomain;
use crate::closure::discretisation::{lines, walled};
use crate::closure::reference::scaled_mass;
use crate::closure::{FINE_NODES, FULL_DROP};
use crate::numerics::Rule;
use crate::states::States;

/// The largest factor by which the domain is widened for an exact density on Gauss nodes.
const EXACT_FOLLOWED: f64 = 3.0;
/// Two rules for an exact density agree to this part of its mass and second moments.
const EXACT: f64 = 1e-10;
/// An exact density has no known integrals where two rules differ by more than this part of its mass and second moments.
const UNKNOWN: f64 = 1e-6;

/// What tables make of a density: a part of 1e-12 of the range of ln p, which is [`FULL_DROP`]. Distances to closed forms of 18 random
/// systems of one state are up to 1.4e-11.
const OF_TABLES: f64 = 1e-12 * FULL_DROP;

/// The content of an exact density, its own reference, integrated about the region that a pilot has visited as far as it falls. None
/// where it has no integral there.
pub(in crate::closure) fn exact_about(mut exponent: Exponent, region: &TrustDomain) -> Option<Content> {
    let free = region.walls == [None; 2];
    let integrated =
        if free { Integrated::within(&exponent, region)? } else { Integrated::at_walls(&exponent, region) };
    let Integrated { domain, nodes, lines, apart } = integrated;
    let (top, mass) = scaled_mass(&exponent.values(&nodes.points), &nodes.weights);
    exponent.constant -= top + mass.ln();
    let of_tables = if exponent.space.folds().iter().any(|fold| fold.curve.is_some()) { OF_TABLES } else { 0.0 };
    let error = apart + domain.mass_beyond(|x| exponent.value(x)) + of_tables;
    let integrals = Integrals::Panels { rules: nodes.rules, lines, apart: error };
    Some(Content::exact(exponent, domain, integrals, error))
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

    /// Next to walls, where the panels are fine.
    fn at_walls(exponent: &Exponent, region: &TrustDomain) -> Self {
        let domain = followed(region, exponent);
        let rules = walled::rules(&domain);
        Integrated { nodes: Nodes::tensor(&domain, rules.clone()), domain, lines: rules, apart: 0.0 }
    }

    fn over(exponent: &Exponent, domain: TrustDomain) -> Option<Self> {
        let given = Nodes::gauss(&domain, FINE_NODES[domain.centre.len().min(2) - 1]).rules;
        let found = resolved(&domain, |points| exponent.values(points), &given, EXACT);
        let lines = if found.rules == given { lines(&domain) } else { found.rules.clone() };
        let nodes = Nodes::tensor(&domain, found.rules);
        (found.apart <= UNKNOWN).then_some(Integrated { domain, nodes, lines, apart: found.apart })
    }
}
