use super::trust_domain::TrustDomain;
use crate::numerics::Rule;
use crate::states::States;

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
