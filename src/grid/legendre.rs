//! Legendre polynomials, orthonormal on each interval of an axis.

use crate::numerics::{Rule, legendre};

/// √(2k+1) P_k(ξ) and its derivative for k = 0..=`degree`, on the reference interval −1 ≤ ξ ≤ 1 with the measure dξ/2.
pub(super) fn reference(degree: usize, xi: f64) -> (Vec<f64>, Vec<f64>) {
    let [mut p, mut slope] = [(); 2].map(|()| vec![0.0; degree + 1]);
    legendre::values(xi, &mut p);
    legendre::slopes(&p, &mut slope);
    for k in 0..=degree {
        let norm = (2.0 * k as f64 + 1.0).sqrt();
        p[k] *= norm;
        slope[k] *= norm;
    }
    (p, slope)
}

/// The reference basis at the nodes of a rule.
#[derive(Debug)]
pub(super) struct Table {
    /// Places on −1 ≤ ξ ≤ 1.
    pub(super) nodes: Vec<f64>,
    /// Weights of the measure dξ/2. On any interval an integral of two basis functions has the same ones.
    pub(super) weights: Vec<f64>,
    /// The basis by node, and its derivatives with respect to ξ.
    pub(super) values: Vec<Vec<f64>>,
    pub(super) slopes: Vec<Vec<f64>>,
}

impl Table {
    pub(super) fn new(degree: usize, rule: Rule) -> Self {
        let (values, slopes) = rule.nodes.iter().map(|xi| reference(degree, *xi)).unzip();
        Table { weights: rule.weights.iter().map(|w| w / 2.0).collect(), nodes: rule.nodes, values, slopes }
    }

    pub(super) fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Weight times the basis function `k` at a node.
    pub(super) fn weighted(&self, node: usize, k: usize) -> f64 {
        self.weights[node] * self.values[node][k]
    }
}

/// The mesh lines of one state, as distances from an origin.
///
/// Next to a wall elements are so small that their widths would be lost in the coordinate itself; distances from the wall
/// keep them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Axis {
    pub(super) origin: f64,
    pub(super) lines: Vec<f64>,
}

impl Axis {
    pub(super) fn cells(&self) -> usize {
        self.lines.len() - 1
    }

    pub(super) fn width(&self, cell: usize) -> f64 {
        self.lines[cell + 1] - self.lines[cell]
    }

    /// The place ξ of the reference interval in `cell`.
    pub(super) fn place(&self, cell: usize, xi: f64) -> f64 {
        self.lines[cell] + self.width(cell) / 2.0 * (xi + 1.0)
    }

    pub(super) fn low(&self) -> f64 {
        self.lines[0]
    }

    pub(super) fn high(&self) -> f64 {
        self.lines[self.cells()]
    }

    /// The cell that holds `u`, a distance from the origin; the upper one on a line. None outside.
    pub(super) fn locate(&self, u: f64) -> Option<usize> {
        if !(u >= self.low() && u <= self.high()) {
            return None;
        }
        Some(self.lines.partition_point(|line| *line <= u).clamp(1, self.cells()) - 1)
    }

    /// The basis of `cell` and its derivative at `u`: orthonormal with respect to du.
    pub(super) fn basis(&self, cell: usize, degree: usize, u: f64) -> (Vec<f64>, Vec<f64>) {
        let width = self.width(cell);
        let xi = 2.0 * (u - self.lines[cell]) / width - 1.0;
        let (mut p, mut slope) = reference(degree, xi);
        let scale = width.sqrt().recip();
        p.iter_mut().for_each(|p| *p *= scale);
        slope.iter_mut().for_each(|s| *s *= scale * 2.0 / width);
        (p, slope)
    }

    /// ∫ g(u) φ_k(u) du over the part of `cell` within [`from`, `to`], for each k.
    pub(super) fn project(
        &self,
        cell: usize,
        degree: usize,
        rule: &Rule,
        [from, to]: [f64; 2],
        g: impl Fn(f64) -> f64,
    ) -> Vec<f64> {
        let mut sums = vec![0.0; degree + 1];
        let (low, high) = (self.lines[cell].max(from), self.lines[cell + 1].min(to));
        if low < high {
            for (u, weight) in rule.on(low, high).iter() {
                let factor = weight * g(u);
                for (sum, p) in sums.iter_mut().zip(self.basis(cell, degree, u).0) {
                    *sum += factor * p;
                }
            }
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rounding of a few hundred terms of size one.
    #[test]
    fn the_basis_is_orthonormal_and_its_slopes_are_its_derivatives() {
        let axis = Axis { origin: 0.0, lines: vec![-1.0, 0.3, 2.0] };
        let rule = Rule::legendre(12);
        for cell in 0..2 {
            for k in 0..=8 {
                let sums = axis.project(cell, 8, &rule, [-1.0, 2.0], |u| axis.basis(cell, 8, u).0[k]);
                for (l, sum) in sums.iter().enumerate() {
                    assert!((sum - f64::from(k == l)).abs() < 1e-13);
                }
            }
            let (u, h) = (axis.lines[cell] + 0.4, 1e-6);
            let (up, down) = (axis.basis(cell, 8, u + h).0, axis.basis(cell, 8, u - h).0);
            for (k, slope) in axis.basis(cell, 8, u).1.iter().enumerate() {
                // Central differences are off by h² times the third derivative, below 1e5 here.
                assert!(((up[k] - down[k]) / (2.0 * h) - slope).abs() < 1e-6 * (1.0 + slope.abs()));
            }
        }
        assert_eq!((axis.locate(0.3), axis.locate(2.0), axis.locate(2.1)), (Some(1), Some(1), None));
    }
}
