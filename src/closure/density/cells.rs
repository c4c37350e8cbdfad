//! The domain of a density that is closest to another one.

use crate::density::Cell;
use crate::numerics::Rule;
use crate::record::{Read, number};
use crate::states::States;
use serde::{Deserialize, Serialize};
use std::sync::OnceLock;

/// The most cells and the most nodes along a side of one in a file.
const MOST: [usize; 2] = [1_000_000, 64];

/// Boxes with a density p̂ at Gauss nodes in each: the domain of an exp(Q) that is closest to it.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct DomainCells {
    /// The lower and upper limits of each box along each state.
    limits: Vec<Vec<[f64; 2]>>,
    /// Gauss nodes along each side.
    along: usize,
    /// p̂ at the nodes of one box after the other, those along the last state next to each other.
    density: Vec<f64>,
    /// The relative error of integrals: that of p̂, of the rule, and what lies beyond the boxes.
    #[serde(with = "number")]
    pub(in crate::closure) error: f64,
    /// The rules along a side of [-1, 1]: that of the nodes, and a finer one.
    #[serde(skip)]
    rules: OnceLock<[Rule; 2]>,
}

impl DomainCells {
    pub(in crate::closure) fn new(
        cells: impl Iterator<Item = Cell>,
        along: usize,
        density: Vec<f64>,
        error: f64,
    ) -> Self {
        DomainCells { limits: cells.map(|cell| cell.limits).collect(), along, density, error, rules: OnceLock::new() }
    }

    fn rules(&self) -> &[Rule; 2] {
        self.rules.get_or_init(|| [self.along, 2 * self.along].map(Rule::legendre))
    }

    /// The limits of each box.
    pub(crate) fn limits(&self) -> &[Vec<[f64; 2]>] {
        &self.limits
    }

    /// p̂ at the nodes.
    pub(in crate::closure) fn values(&self) -> &[f64] {
        &self.density
    }

    /// The nodes and their weights.
    pub(in crate::closure) fn nodes(&self) -> (States, Vec<f64>) {
        let mut nodes = (States::new(self.dimension()), Vec::new());
        let [rule, _] = self.rules();
        self.limits.iter().for_each(|limits| add_nodes(limits, rule, &mut nodes));
        nodes
    }

    /// Nodes with weights on the part of the boxes where some states are held, for functions that are smooth on either side of 0.
    pub(in crate::closure) fn section(&self, held: &[(usize, f64)]) -> Vec<(Vec<f64>, f64)> {
        let [_, rule] = self.rules();
        let mut found = Vec::new();
        let bounds = self.bounds();
        // A wall above the motion is the upper end of all.
        let meets = |limits: &&Vec<[f64; 2]>| {
            held.iter().all(|&(state, x)| {
                let [low, high] = limits[state];
                (low..high).contains(&x) || x == high && x == bounds[state][1]
            })
        };
        for limits in self.limits.iter().filter(meets) {
            let mut point = vec![0.0; limits.len()];
            held.iter().for_each(|&(state, x)| point[state] = x);
            let mut own = vec![(point, 1.0)];
            for axis in (0..limits.len()).filter(|axis| held.iter().all(|(state, _)| state != axis)) {
                let [low, high] = limits[axis];
                let middle = 0.0_f64.clamp(low, high);
                let halves = [[low, middle], [middle, high]].into_iter().filter(|[a, b]| a < b);
                let nodes: Vec<(f64, f64)> =
                    halves.flat_map(|[a, b]| rule.on(a, b).iter().collect::<Vec<_>>()).collect();
                let with = |(point, weight): &(Vec<f64>, f64), (t, w): &(f64, f64)| {
                    let mut point = point.clone();
                    point[axis] = *t;
                    (point, weight * w)
                };
                own = own.iter().flat_map(|part| nodes.iter().map(move |node| with(part, node))).collect();
            }
            found.extend(own);
        }
        found
    }

    /// Whether a state lies in one of the boxes.
    pub(in crate::closure) fn contains(&self, x: &[f64]) -> bool {
        self.cell(x).is_some()
    }

    /// p̂ at a state, from the nodes of its box; 0 outside of all.
    pub(in crate::closure) fn density(&self, x: &[f64]) -> f64 {
        let Some(cell) = self.cell(x) else { return 0.0 };
        let [rule, _] = self.rules();
        let size = self.along.pow(self.dimension() as u32);
        let mut values = self.density[cell * size..][..size].to_vec();
        // One state after the other, the first one first.
        for (x, [low, high]) in x.iter().zip(&self.limits[cell]) {
            let t = 2.0 * (x - low) / (high - low) - 1.0;
            let shares = lagrange(&rule.nodes, t);
            let rest = values.len() / self.along;
            values = (0..rest).map(|k| (0..self.along).map(|i| shares[i] * values[i * rest + k]).sum()).collect();
        }
        values[0]
    }

    /// The box around all.
    pub(in crate::closure) fn bounds(&self) -> Vec<[f64; 2]> {
        let along = |axis: usize| {
            let sides = self.limits.iter().map(|limits| limits[axis]);
            sides.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], [a, b]| [low.min(a), high.max(b)])
        };
        (0..self.dimension()).map(along).collect()
    }

    /// Refuses numbers without a meaning, such as those of a damaged file.
    pub(in crate::closure) fn checked(self, states: usize) -> Read<Self> {
        let DomainCells { limits, along, density, error, .. } = &self;
        let box_of = |limits: &Vec<[f64; 2]>| {
            limits.len() == states && limits.iter().all(|[low, high]| low.is_finite() && high.is_finite() && low < high)
        };
        if limits.is_empty() || limits.len() > MOST[0] || !limits.iter().all(box_of) {
            return Err(format!("its cells are no boxes of {states} states"));
        }
        let count = (1..=MOST[1]).contains(along).then(|| limits.len() * along.pow(states as u32));
        if count != Some(density.len()) || !density.iter().all(|p| p.is_finite()) {
            return Err(format!(
                "{} densities are not those of {along} nodes along each side of its cells",
                density.len()
            ));
        }
        if error.is_nan() || *error < 0.0 {
            return Err(format!("its integrals have the error {error}"));
        }
        Ok(self)
    }

    fn dimension(&self) -> usize {
        self.limits.first().map_or(1, Vec::len)
    }

    /// The box that a state lies in.
    fn cell(&self, x: &[f64]) -> Option<usize> {
        let within = |limits: &Vec<[f64; 2]>| limits.iter().zip(x).all(|([low, high], x)| (low..=high).contains(&x));
        self.limits.iter().position(within)
    }
}

/// Adds the nodes of a product of one rule in a box.
pub(in crate::closure) fn add_nodes(limits: &[[f64; 2]], rule: &Rule, (points, weights): &mut (States, Vec<f64>)) {
    let lines: Vec<Rule> = limits.iter().map(|[low, high]| rule.on(*low, *high)).collect();
    let count = rule.nodes.len();
    let mut x = vec![0.0; limits.len()];
    for k in 0..count.pow(limits.len() as u32) {
        let mut weight = 1.0;
        let mut rest = k;
        for (axis, line) in lines.iter().enumerate().rev() {
            x[axis] = line.nodes[rest % count];
            weight *= line.weights[rest % count];
            rest /= count;
        }
        points.push(&x);
        weights.push(weight);
    }
}

/// The polynomials that are 1 at one of some nodes and 0 at the others, at `t`.
fn lagrange(nodes: &[f64], t: f64) -> Vec<f64> {
    let one = |i: usize| {
        let others = nodes.iter().enumerate().filter(|(j, _)| *j != i);
        others.map(|(_, node)| (t - node) / (nodes[i] - node)).product()
    };
    (0..nodes.len()).map(one).collect()
}
