//! Legendre polynomials, orthonormal on the reference interval.

use crate::numerics::{Rule, legendre};

/// √(2k+1) P_k(ξ) for k = 0..=`degree`, on the reference interval −1 ≤ ξ ≤ 1 with the measure dξ/2.
pub(super) fn values(degree: usize, xi: f64) -> Vec<f64> {
    let mut p = vec![0.0; degree + 1];
    legendre::values(xi, &mut p);
    p.iter_mut().enumerate().for_each(|(k, p)| *p *= norm(k));
    p
}

/// The same, and their derivatives.
pub(super) fn reference(degree: usize, xi: f64) -> (Vec<f64>, Vec<f64>) {
    let [mut p, mut slope] = [(); 2].map(|()| vec![0.0; degree + 1]);
    legendre::values(xi, &mut p);
    legendre::slopes(&p, &mut slope);
    for k in 0..=degree {
        p[k] *= norm(k);
        slope[k] *= norm(k);
    }
    (p, slope)
}

fn norm(k: usize) -> f64 {
    (2.0 * k as f64 + 1.0).sqrt()
}

/// The reference basis at the nodes of a rule.
#[derive(Debug)]
pub(super) struct LegendreTable {
    /// Places on −1 ≤ ξ ≤ 1.
    pub(super) nodes: Vec<f64>,
    /// Weights of the measure dξ/2. On any interval an integral of two basis functions has the same ones.
    pub(super) weights: Vec<f64>,
    /// The basis by node, and its derivatives with respect to ξ.
    pub(super) values: Vec<Vec<f64>>,
    pub(super) slopes: Vec<Vec<f64>>,
}

impl LegendreTable {
    pub(super) fn new(degree: usize, rule: Rule) -> Self {
        let (values, slopes) = rule.nodes.iter().map(|xi| reference(degree, *xi)).unzip();
        LegendreTable { weights: rule.weights.iter().map(|w| w / 2.0).collect(), nodes: rule.nodes, values, slopes }
    }

    pub(super) fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Weight times the basis function `k` at a node.
    pub(super) fn weighted(&self, node: usize, k: usize) -> f64 {
        self.weights[node] * self.values[node][k]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rounding of a few hundred terms of size one; central differences are off by h² times the third derivative, below 1e5 here.
    #[test]
    fn the_basis_is_orthonormal_and_its_slopes_are_its_derivatives() {
        let table = LegendreTable::new(8, Rule::legendre(12));
        for k in 0..=8 {
            for l in 0..=8 {
                let sum: f64 = (0..table.len()).map(|node| table.weighted(node, k) * table.values[node][l]).sum();
                assert!((sum - f64::from(u8::from(k == l))).abs() < 1e-13);
            }
            let (xi, h) = (0.37, 1e-6);
            let [up, down] = [xi + h, xi - h].map(|xi| reference(8, xi).0[k]);
            let slope = reference(8, xi).1[k];
            assert!(((up - down) / (2.0 * h) - slope).abs() < 1e-6 * (1.0 + slope.abs()));
        }
    }
}
