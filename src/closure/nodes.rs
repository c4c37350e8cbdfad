use super::trust_domain::TrustDomain;
use crate::quadrature::Rule;
use std::fmt;

/// The points that stand for integrals while the equations are solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NodeKind {
    /// Gauss nodes in one state and in two, the pilot's states in more.
    #[default]
    Automatic,
    /// Products of Gauss nodes on the trust domain: one state or two.
    Tensor,
    /// The pilot's own states: any number of states, no walls.
    Samples,
}

impl fmt::Display for NodeKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            NodeKind::Automatic => "automatic",
            NodeKind::Tensor => "tensor",
            NodeKind::Samples => "samples",
        })
    }
}

/// Points of the state space with weights: sums over them stand for integrals over the trust domain.
#[derive(Clone, Debug)]
pub(super) struct Nodes<const N: usize> {
    pub(super) points: Vec<[f64; N]>,
    pub(super) weights: Vec<f64>,
    /// The rules whose product they are taken from.
    pub(super) rules: [Rule; N],
}

impl<const N: usize> Nodes<N> {
    /// The nodes of `count` Gauss points along each side of the box around the domain.
    pub(super) fn gauss(domain: &TrustDomain<N>, count: usize) -> Self {
        let bounds = domain.bounds();
        let rule = Rule::legendre(count);
        Nodes::tensor(domain, &std::array::from_fn(|i| rule.on(bounds[i][0], bounds[i][1])))
    }

    /// The nodes of a product of one-dimensional rules that lie inside the domain.
    ///
    /// The rules know nothing of the domain's edge. The density there is below a millionth of its peak, and so is the
    /// error.
    pub(super) fn tensor(domain: &TrustDomain<N>, rules: &[Rule; N]) -> Self {
        let mut nodes = Nodes { points: Vec::new(), weights: Vec::new(), rules: rules.clone() };
        nodes.extend(domain, rules, [0.0; N], 1.0, 0);
        nodes
    }

    fn extend(&mut self, domain: &TrustDomain<N>, rules: &[Rule; N], start: [f64; N], weight: f64, state: usize) {
        if state == N {
            if domain.contains(&start) {
                self.points.push(start);
                self.weights.push(weight);
            }
            return;
        }
        for (x, w) in rules[state].iter() {
            let mut point = start;
            point[state] = x;
            self.extend(domain, rules, point, weight * w, state + 1);
        }
    }

    /// The nodes that `keep` keeps.
    pub(super) fn filtered(&self, keep: impl Fn(&[f64; N]) -> bool) -> Self {
        let pairs = self.points.iter().zip(&self.weights).filter(|(x, _)| keep(x));
        let (points, weights) = pairs.map(|(x, w)| (*x, *w)).unzip();
        Nodes { points, weights, rules: self.rules.clone() }
    }

    pub(super) fn len(&self) -> usize {
        self.points.len()
    }
}
