//! Gauss rules in one dimension.
//!
//! The weights come from Christoffel's function, w_i = 1/Σ_k p_k(x_i)², with p_k the orthonormal polynomials: a sum of
//! positive terms, accurate *relatively* even where a Gauss-Hermite weight is 1e-80.

use nalgebra::{DMatrix, SymmetricEigen};
use serde::{Deserialize, Serialize};
use std::sync::OnceLock;

/// Nodes and weights of a rule Σ w_i g(x_i).
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Rule {
    pub(crate) nodes: Vec<f64>,
    pub(crate) weights: Vec<f64>,
}

/// Rules of fewer nodes than this are made once.
const KEPT: usize = 256;
type Made = [OnceLock<Rule>; KEPT];
static LEGENDRE: Made = [const { OnceLock::new() }; KEPT];
static HERMITE: Made = [const { OnceLock::new() }; KEPT];
static LAGUERRE: Made = [const { OnceLock::new() }; KEPT];

impl Rule {
    /// The rule of a family, as it was made before.
    fn kept(made: &Made, count: usize, make: impl FnOnce() -> Self) -> Self {
        match made.get(count) {
            Some(kept) => kept.get_or_init(make).clone(),
            None => make(),
        }
    }

    /// ∫₋₁¹ g(x) dx, exact for degree 2`count` − 1.
    pub(crate) fn legendre(count: usize) -> Self {
        Self::kept(&LEGENDRE, count, || {
            let beta = |k: f64| k / (4.0 * k * k - 1.0).sqrt();
            let recurrence = Recurrence::symmetric(count, 2.0, beta);
            // Francesco Tricomi's asymptotic nodes are close enough for Newton's method, and need no eigenvalues.
            let angle = |i: usize| std::f64::consts::PI * (i as f64 + 0.75) / (count as f64 + 0.5);
            recurrence.rule((0..count).rev().map(|i| angle(i).cos()).collect())
        })
    }

    /// E[g(Z)] for a standard normal Z, exact for degree 2`count` − 1.
    pub(crate) fn hermite(count: usize) -> Self {
        Self::kept(&HERMITE, count, || Recurrence::symmetric(count, 1.0, f64::sqrt).golub_welsch())
    }

    /// E[g(Y)] for Y > 0 with the density exp(−y), exact for degree 2`count` − 1.
    pub(crate) fn laguerre(count: usize) -> Self {
        Self::kept(&LAGUERRE, count, || {
            let alpha = (0..count).map(|k| 2.0 * k as f64 + 1.0).collect();
            let beta = (1..=count).map(|k| k as f64).collect();
            Recurrence { alpha, beta, mass: 1.0 }.golub_welsch()
        })
    }

    /// The rule of `count` nodes for the measure that `self` stands for, exact for degree 2`count` − 1 as long as `self`
    /// has many more nodes.
    pub(crate) fn condensed(&self, count: usize) -> Self {
        Recurrence::stieltjes(self, count).golub_welsch()
    }

    /// The rule moved from [−1, 1] to [`low`, `high`].
    pub(crate) fn on(&self, low: f64, high: f64) -> Rule {
        let half = (high - low) / 2.0;
        Rule {
            nodes: self.nodes.iter().map(|x| low + half * (x + 1.0)).collect(),
            weights: self.weights.iter().map(|w| w * half).collect(),
        }
    }

    /// The pairs (node, weight).
    pub(crate) fn iter(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.nodes.iter().copied().zip(self.weights.iter().copied())
    }
}

/// Orthonormal polynomials x p_k = β_{k+1} p_{k+1} + α_k p_k + β_k p_{k−1} of a measure of total mass `mass`.
struct Recurrence {
    alpha: Vec<f64>,
    /// β₁ …, one more than α.
    beta: Vec<f64>,
    mass: f64,
}

impl Recurrence {
    fn symmetric(count: usize, mass: f64, beta: impl Fn(f64) -> f64) -> Self {
        Recurrence { alpha: vec![0.0; count], beta: (1..=count).map(|k| beta(k as f64)).collect(), mass }
    }

    /// The recurrence of a discrete measure, by inner products (T. J. Stieltjes, 1884).
    fn stieltjes(measure: &Rule, count: usize) -> Self {
        let mass: f64 = measure.weights.iter().sum();
        let mut recurrence = Recurrence { alpha: Vec::new(), beta: Vec::new(), mass };
        let mut p = vec![mass.sqrt().recip(); measure.nodes.len()];
        let mut q = vec![0.0; p.len()];
        let mut last = 0.0;
        for _ in 0..count {
            let alpha: f64 = measure.iter().zip(&p).map(|((x, w), p)| w * x * p * p).sum();
            let raw = measure.nodes.iter().zip(p.iter().zip(&q)).map(|(x, (p, q))| (x - alpha) * p - last * q);
            let raw: Vec<f64> = raw.collect();
            let beta = raw.iter().zip(&measure.weights).map(|(r, w)| w * r * r).sum::<f64>().sqrt();
            (q, p) = (p, raw.into_iter().map(|r| r / beta).collect());
            last = beta;
            recurrence.alpha.push(alpha);
            recurrence.beta.push(beta);
        }
        recurrence
    }

    /// Nodes as eigenvalues of the Jacobi matrix (G. H. Golub and J. H. Welsch, 1969,
    /// doi:10.1090/S0025-5718-69-99647-1).
    fn golub_welsch(&self) -> Rule {
        let count = self.alpha.len();
        let jacobi = DMatrix::from_fn(count, count, |i, j| match i.abs_diff(j) {
            0 => self.alpha[i],
            1 => self.beta[i.min(j)],
            _ => 0.0,
        });
        let mut guesses: Vec<f64> = SymmetricEigen::new(jacobi).eigenvalues.iter().copied().collect();
        guesses.sort_by(f64::total_cmp);
        self.rule(guesses)
    }

    /// The rule whose nodes Newton's method finds from approximate ones, `guesses`.
    fn rule(&self, guesses: Vec<f64>) -> Rule {
        let mut rule = Rule { nodes: Vec::with_capacity(guesses.len()), weights: Vec::with_capacity(guesses.len()) };
        for mut x in guesses {
            let mut christoffel = 0.0;
            for _ in 0..8 {
                let (mut p, mut q, mut dp, mut dq, mut below) = (self.mass.sqrt().recip(), 0.0, 0.0, 0.0, 0.0);
                christoffel = 0.0;
                for (alpha, beta) in self.alpha.iter().zip(&self.beta) {
                    christoffel += p * p;
                    let next = ((x - alpha) * p - below * q) / beta;
                    let slope = (p + (x - alpha) * dp - below * dq) / beta;
                    (q, p, dq, dp, below) = (p, next, dp, slope, *beta);
                }
                let step = p / dp;
                x -= step;
                if step.abs() <= 4.0 * f64::EPSILON * x.abs() {
                    break;
                }
            }
            rule.nodes.push(x);
            rule.weights.push(christoffel.recip());
        }
        rule
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both rules integrate every power up to their degree. The sums have up to 40 terms of the size of the result, so that
    /// 1e-13 relative is a few hundred rounding errors.
    #[test]
    fn rules_are_exact_for_the_powers_they_promise() {
        for count in [1, 2, 3, 8, 21, 40] {
            let (legendre, hermite) = (Rule::legendre(count), Rule::hermite(count));
            let mut normal_moment = 1.0;
            for power in (0..2 * count as i32).step_by(2) {
                let integral: f64 = legendre.iter().map(|(x, w)| w * x.powi(power)).sum();
                assert!((integral * f64::from(power + 1) / 2.0 - 1.0).abs() < 1e-13, "Legendre {count}, {power}");
                if power > 0 {
                    normal_moment *= f64::from(power - 1);
                }
                let mean: f64 = hermite.iter().map(|(x, w)| w * x.powi(power)).sum();
                assert!((mean / normal_moment - 1.0).abs() < 1e-12, "Hermite {count}, {power}");
            }
        }
    }

    /// The outermost weight for 100 nodes is 6e-79 with respect to exp(−x²) (A. Stroud and D. Secrest, Gaussian
    /// Quadrature Formulas, 1966): for the normal weight that is divided by √π.
    #[test]
    fn tail_weights_are_accurate_relatively() {
        let rule = Rule::hermite(100);
        let first = rule.weights[0] * std::f64::consts::PI.sqrt();
        assert!((first / 5.908e-79 - 1.0).abs() < 1e-3, "{first:e}");
    }
}
