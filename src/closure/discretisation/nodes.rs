use super::trust_domain::TrustDomain;
use super::{WallPassage, impulses};
use crate::closure::space::orthonormal::Orthonormal;
use crate::closure::space::sweep;
use crate::fokker_planck::{ImpulseTerm, Local};
use crate::functions::Functions;
use crate::numerics::Rule;
use crate::states::States;
use faer::{Mat, MatMut};

/// Points of the state space with weights: sums over them stand for integrals over the trust domain.
#[derive(Clone, Debug)]
pub(in crate::closure) struct Nodes {
    pub(in crate::closure) points: States,
    pub(in crate::closure) weights: Vec<f64>,
    /// The rules whose product they are taken from.
    pub(in crate::closure) rules: Vec<Rule>,
}

impl Nodes {
    /// The nodes of `count` Gauss points along each side of the box around the domain.
    pub(in crate::closure) fn gauss(domain: &TrustDomain, count: usize) -> Self {
        let rule = Rule::legendre(count);
        Nodes::tensor(domain, domain.bounds().iter().map(|[low, high]| rule.on(*low, *high)).collect())
    }

    /// The nodes of a product of one-dimensional rules that lie inside the domain.
    ///
    /// The rules take no account of the domain's edge. The density there is below a millionth of its peak, and the error is
    /// of the same size.
    pub(in crate::closure) fn tensor(domain: &TrustDomain, rules: Vec<Rule>) -> Self {
        let mut nodes = Nodes { points: States::new(rules.len()), weights: Vec::new(), rules: Vec::new() };
        nodes.extend(domain, &rules, &mut Vec::with_capacity(rules.len()), 1.0);
        Nodes { rules, ..nodes }
    }

    /// Adds all nodes that begin with the coordinates `start`.
    fn extend(&mut self, domain: &TrustDomain, rules: &[Rule], start: &mut Vec<f64>, weight: f64) {
        let Some(rule) = rules.get(start.len()) else {
            if domain.contains(start) {
                self.points.push(start);
                self.weights.push(weight);
            }
            return;
        };
        for (x, w) in rule.iter() {
            start.push(x);
            self.extend(domain, rules, start, weight * w);
            start.pop();
        }
    }

    /// The nodes that lie in a smaller domain.
    pub(in crate::closure) fn within(&self, domain: &TrustDomain) -> Self {
        let mut kept = Nodes { points: States::new(self.points.dimension()), weights: Vec::new(), rules: Vec::new() };
        for (x, &weight) in self.points.iter().zip(&self.weights).filter(|(x, _)| domain.contains(x)) {
            kept.points.push(x);
            kept.weights.push(weight);
        }
        Nodes { rules: self.rules.clone(), ..kept }
    }

    pub(in crate::closure) fn len(&self) -> usize {
        self.weights.len()
    }
}

/// Functions at nodes, with their mean rates of change: one row a node, one column a function.
///
/// There is one more row for each impact: a function's values are those before, and its rate is its jump.
#[derive(Clone, Debug)]
pub(in crate::closure) struct Table {
    /// Combinations of 1, φ₁ … φ_K.
    pub(in crate::closure) functions: Orthonormal,
    /// Their rates, those of the constant 0.
    pub(in crate::closure) rates: Mat<f64>,
    /// Their values after impacts.
    pub(in crate::closure) after: Mat<f64>,
}

/// The generator of a system at nodes: what changes the mean of a function there.
#[derive(Clone, Copy)]
pub(in crate::closure) struct NodalGenerator<'a> {
    pub(in crate::closure) points: &'a States,
    /// The Fokker-Planck operator at the nodes.
    pub(in crate::closure) locals: &'a [Local],
    pub(in crate::closure) passages: &'a [WallPassage],
    /// Impulses, of which those that leave the domain are left out.
    pub(in crate::closure) impulses: &'a [ImpulseTerm],
    pub(in crate::closure) domain: &'a TrustDomain,
}

impl NodalGenerator<'_> {
    /// Fills tables with 1, φ₁ … φ_K at the points and their rates there, impacts left out.
    pub(in crate::closure) fn enter(&self, space: &Functions, [mut values, mut rates]: [MatMut<'_, f64>; 2]) {
        let local = |i: usize| (&self.locals[i].drift[..], &self.locals[i].diffusion[..]);
        sweep::tabulate_rates(space, self.points, &local, [values.as_mut(), rates.as_mut()]);
        impulses::add_rates(self.impulses, self.domain, (space, self.points), values.as_ref(), rates);
    }
}

impl Table {
    /// Tabulates functions, orthonormal under `measure`, under the generator. `None` where they are linearly dependent.
    pub(in crate::closure) fn new(generator: NodalGenerator<'_>, space: &Functions, measure: &[f64]) -> Option<Self> {
        let NodalGenerator { points, passages, .. } = generator;
        let ends = |end: fn(&WallPassage) -> &[f64; 2]| {
            let mut points = States::new(points.dimension());
            passages.iter().for_each(|passage| points.push(end(passage)));
            values(space, &points)
        };
        let (before, mut after) = (ends(|passage| &passage.before), ends(|passage| &passage.after));
        let [mut values, mut rates] = [(); 2].map(|()| Mat::zeros(points.len() + passages.len(), space.len() + 1));
        let (inside, mut beyond) = values.as_mut().split_at_row_mut(points.len());
        let (rates_inside, mut jumps) = rates.as_mut().split_at_row_mut(points.len());
        generator.enter(space, [inside, rates_inside]);
        beyond.copy_from(&before);
        jumps.copy_from(&after - &before);
        let functions = Orthonormal::new(values, measure)?;
        functions.transform(rates.as_mut());
        functions.transform(after.as_mut());
        Some(Table { functions, rates, after })
    }
}

/// 1, φ₁ … φ_K at some points: one row a point.
pub(in crate::closure) fn values(space: &Functions, points: &States) -> Mat<f64> {
    let mut table = Mat::zeros(points.len(), space.len() + 1);
    sweep::tabulate(space, points, table.as_mut());
    table
}
