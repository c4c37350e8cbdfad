use super::trust_domain::TrustDomain;
use crate::closure::space::Functions;
use crate::fokker_planck::Local;
use crate::numerics::Rule;
use crate::states::States;
use faer::Mat;
use rayon::prelude::*;

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

/// The values of functions at points, with their mean rates of change: one row a point, one column a function.
#[derive(Clone, Debug)]
pub(in crate::closure) struct Table {
    /// 1, φ₁ … φ_K.
    pub(in crate::closure) values: Mat<f64>,
    /// 0, Gφ₁ … Gφ_K.
    pub(in crate::closure) rates: Mat<f64>,
}

impl Table {
    /// Tabulates functions under the generator, whose coefficients at the points are `locals`.
    pub(in crate::closure) fn new(space: &Functions, points: &States, locals: &[Local]) -> Self {
        let columns = space.len() + 1;
        let (mut values, mut rates) = (vec![1.0; points.len() * columns], vec![0.0; points.len() * columns]);
        let rows = values.par_chunks_mut(columns).zip(rates.par_chunks_mut(columns));
        rows.zip(points.par_iter()).zip(locals).for_each(|(((values, rates), x), local)| {
            space.rates(x, (&local.drift, &local.diffusion), &mut values[1..], &mut rates[1..]);
        });
        Table { values: by_rows(&values, columns), rates: by_rows(&rates, columns) }
    }

    /// The table with one more row for each impact: a function's values are those before, and its rate is its jump.
    pub(in crate::closure) fn with_impacts(&self, before: &Mat<f64>, after: &Mat<f64>) -> Self {
        let (interior, columns) = (self.values.nrows(), self.values.ncols());
        let joined = |inside: &Mat<f64>, beyond: &dyn Fn(usize, usize) -> f64| {
            let entry = |i: usize, k: usize| if i < interior { inside[(i, k)] } else { beyond(i - interior, k) };
            Mat::from_fn(interior + before.nrows(), columns, entry)
        };
        Table {
            values: joined(&self.values, &|i, k| before[(i, k)]),
            rates: joined(&self.rates, &|i, k| after[(i, k)] - before[(i, k)]),
        }
    }
}

/// 1, φ₁ … φ_K at some points: one row a point.
pub(in crate::closure) fn values(space: &Functions, points: &States) -> Mat<f64> {
    let columns = space.len() + 1;
    let mut rows = vec![1.0; points.len() * columns];
    rows.par_chunks_mut(columns).zip(points.par_iter()).for_each(|(row, x)| space.values(x, &mut row[1..]));
    by_rows(&rows, columns)
}

fn by_rows(rows: &[f64], columns: usize) -> Mat<f64> {
    Mat::from_fn(rows.len() / columns, columns, |i, k| rows[i * columns + k])
}
