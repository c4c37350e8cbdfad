//! Rules for the integrals of one density: Gauss nodes on panels along each state, which are halved until two rules agree.
//!
//! The nodes on which a density is sought are those of its system. Whether they also integrate it, where a well may be narrower than
//! their distance, is seen by rules of fewer nodes along one state after the other: what mass and second moments then differ by is the
//! error of the coarser rule.

use super::nodes::Nodes;
use super::trust_domain::TrustDomain;
use crate::numerics::{Rule, exponentials};
use crate::states::States;

/// The ratio of the nodes along one state to those of the coarser rule that they are compared with.
const FEWER: [usize; 2] = [5, 4];
/// Gauss nodes on a panel, and those of the coarser rule that they are compared with.
const EACH: [usize; 2] = [16, 12];
/// Panels along each state before any is halved.
const FIRST: usize = 4;
/// The most nodes of rules on panels along all states: a bound on work.
const MOST: usize = 1 << 20;
/// The relative difference of two rules must fall by this factor as panels are halved; where it does not, the edge of the domain is
/// what they differ by.
const FALLS: f64 = 0.7;
/// Panels are halved no more once the difference of two rules has not fallen enough so many times in a row.
const STALLED: usize = 2;

/// Rules along the states, and what another one differs by in mass and second moments, relative to these.
pub(in crate::closure) struct ResolvedRules {
    pub(in crate::closure) rules: Vec<Rule>,
    pub(in crate::closure) apart: f64,
}

/// The given Gauss rules if they integrate exp(Q) over a domain to `tolerance`, or else rules on panels that do, or that come as close
/// as the domain's edge allows and their number of nodes.
pub(in crate::closure) fn resolved(
    domain: &TrustDomain,
    log: impl Fn(&States) -> Vec<f64>,
    given: &[Rule],
    tolerance: f64,
) -> ResolvedRules {
    let (bounds, integrand) = (domain.bounds(), Integrand { domain, log });
    let whole: Vec<Vec<f64>> = bounds.iter().map(|bounds| bounds.to_vec()).collect();
    let fewer = |axis: usize| {
        let count = given[axis].nodes.len() * FEWER[1] / FEWER[0];
        Rule::legendre(count).on(bounds[axis][0], bounds[axis][1])
    };
    let (_, apart) = integrand.differences(given, &whole, fewer);
    if apart <= tolerance {
        return ResolvedRules { rules: given.to_vec(), apart };
    }
    let mut found = ResolvedRules { rules: given.to_vec(), apart: f64::INFINITY };
    let [own, less] = EACH.map(Rule::legendre);
    let mut edges: Vec<Vec<f64>> = bounds.iter().map(|[low, high]| evenly(*low, *high)).collect();
    let mut stalled = 0;
    while stalled < STALLED {
        let rules: Vec<Rule> = edges.iter().map(|edges| on_panels(edges, &own)).collect();
        if rules.iter().map(|rule| rule.nodes.len()).product::<usize>() > MOST {
            break;
        }
        let (differences, apart) = integrand.differences(&rules, &edges, |axis| on_panels(&edges[axis], &less));
        stalled = if apart < FALLS * found.apart { 0 } else { stalled + 1 };
        found = ResolvedRules { rules, apart };
        if apart <= tolerance {
            break;
        }
        for (edges, differences) in edges.iter_mut().zip(&differences) {
            divide(edges, differences, tolerance / (bounds.len() * differences.len()) as f64);
        }
    }
    found
}

/// The edges of equal panels.
fn evenly(low: f64, high: f64) -> Vec<f64> {
    (0..=FIRST).map(|k| low + (high - low) * k as f64 / FIRST as f64).collect()
}

/// A rule on each of the panels between some edges.
fn on_panels(edges: &[f64], rule: &Rule) -> Rule {
    let panels = edges.windows(2).map(|edges| rule.on(edges[0], edges[1]));
    let (nodes, weights) = panels.flat_map(|panel| panel.iter().collect::<Vec<_>>()).unzip();
    Rule { nodes, weights }
}

/// Halves the panels on which two rules differ by more than a share.
fn divide(edges: &mut Vec<f64>, differences: &[f64], share: f64) {
    let fits = |panel: &usize| differences[*panel] <= share;
    let middle = |panel: usize| (edges[panel] + edges[panel + 1]) / 2.0;
    // What is no number does not fit.
    let mut middles: Vec<f64> = (0..differences.len()).filter(|panel| !fits(panel)).map(middle).collect();
    edges.append(&mut middles);
    edges.sort_by(f64::total_cmp);
}

/// exp(Q) on a domain.
struct Integrand<'a, L> {
    domain: &'a TrustDomain,
    log: L,
}

impl<L: Fn(&States) -> Vec<f64>> Integrand<'_, L> {
    /// What mass and second moments differ by if the rule along one state is another one: the largest of them on each panel along that
    /// state, for each state, and the sum of all.
    fn differences(&self, rules: &[Rule], edges: &[Vec<f64>], other: impl Fn(usize) -> Rule) -> (Vec<Vec<f64>>, f64) {
        let nodes = Nodes::tensor(self.domain, rules.to_vec());
        let logarithms = (self.log)(&nodes.points);
        let top = logarithms.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let along = |axis: usize| -> Vec<f64> {
            let mut others = rules.to_vec();
            others[axis] = other(axis);
            let others = Nodes::tensor(self.domain, others);
            let panels = (axis, &edges[axis][..]);
            let fine = self.sums(&nodes, &logarithms, top, panels);
            let coarse = self.sums(&others, &(self.log)(&others.points), top, panels);
            let whole: Vec<f64> = (0..fine[0].len()).map(|k| fine.iter().map(|panel| panel[k]).sum()).collect();
            let difference = |(fine, coarse): (&Vec<f64>, &Vec<f64>)| {
                let each = (0..whole.len()).map(|k| (fine[k] - coarse[k]).abs() / whole[k]);
                // What is no number stays.
                each.fold(0.0, |most: f64, difference| if difference <= most { most } else { difference })
            };
            fine.iter().zip(&coarse).map(difference).collect()
        };
        let differences: Vec<Vec<f64>> = (0..rules.len()).map(along).collect();
        let apart = differences.iter().flatten().sum();
        (differences, apart)
    }

    /// The mass and the second moments about the centre over each of the panels between `edges` along one state.
    fn sums(&self, nodes: &Nodes, logarithms: &[f64], top: f64, (axis, edges): (usize, &[f64])) -> Vec<Vec<f64>> {
        let centre = &self.domain.centre;
        let mut density: Vec<f64> = logarithms.iter().map(|q| q - top).collect();
        exponentials(&mut density);
        let mut sums = vec![vec![0.0; 1 + centre.len()]; edges.len() - 1];
        for ((x, weight), p) in nodes.points.iter().zip(&nodes.weights).zip(&density) {
            let panel = edges[1..edges.len() - 1].partition_point(|edge| *edge <= x[axis]);
            let squares = x.iter().zip(centre).map(|(x, c)| (x - c).powi(2));
            let parts = std::iter::once(1.0).chain(squares);
            sums[panel].iter_mut().zip(parts).for_each(|(sum, part)| *sum += weight * p * part);
        }
        sums
    }
}
