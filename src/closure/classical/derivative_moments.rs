//! Impulses by their derivative moments.

use super::hermite::in_powers;
use crate::fokker_planck::{FokkerPlanck, Impulse};
use crate::numerics::Rule;
use crate::polynomial::Polynomial;
use faer::{Col, Mat};

/// The terms of third order and more of the expansion of impulses, λ Σ_k (−1)^k E\[Y^k\]/k! (H·∇)^k p (H. A. Kramers, 1940,
/// doi:10.1016/S0031-8914(40)90098-2; J. E. Moyal, 1949, doi:10.1111/j.2517-6161.1949.tb00030.x), with p = exp(Q) and H the same at all
/// states; those of first and second order are a drift and a white noise.
///
/// exp(−Q) D^k exp(Q), D = H·∇, is the complete Bell polynomial B_k of DQ … D^kQ, and ∂B_k/∂(D^jQ) = C(k, j) B_{k−j} (E. T. Bell,
/// 1934, doi:10.2307/1968431). All are polynomials in the states, so that a Gauss rule under f_N projects them exactly.
#[derive(Clone, Debug)]
pub(super) struct DerivativeMoments {
    sources: Vec<Source>,
    /// The functions at the nodes times the rule's weights.
    weighted: Mat<f64>,
}

#[derive(Clone, Debug)]
struct Source {
    /// λ (−1)^k E\[Y^k\]/k!, from k = 0 on; those below 3 are zero.
    factors: Vec<f64>,
    /// D^j of the functions at the nodes, from j = 1 on.
    slopes: Vec<Mat<f64>>,
}

impl DerivativeMoments {
    /// Those up to order `highest`, for an operator in the coordinates in which f_N is standard normal and for functions of these
    /// indices. None where there are none.
    pub(super) fn new(operator: &FokkerPlanck, basis: &[Vec<u32>], highest: u32) -> Option<Self> {
        if operator.impulses().is_empty() || highest < 3 {
            return None;
        }
        let n = operator.dimension();
        let order = basis.iter().map(|index| index.iter().sum::<u32>()).max().unwrap_or(0);
        // Of degree `highest` (order − 1) + order, by a rule that is exact up to twice its nodes.
        let rule = Rule::hermite((highest as usize * (order as usize).saturating_sub(1) + order as usize) / 2 + 1);
        let nodes = product(&rule, n);
        let function = |index: &Vec<u32>| {
            let mut series = Polynomial::zero(n);
            series.add_term(index, 1.0);
            in_powers(&series)
        };
        let functions: Vec<Polynomial> = basis.iter().map(function).collect();
        let at_nodes = |all: &[Polynomial]| Mat::from_fn(nodes.len(), all.len(), |i, k| all[k].evaluate(&nodes[i].0));
        let weighted = at_nodes(&functions);
        let weighted = Mat::from_fn(nodes.len(), basis.len(), |i, k| nodes[i].1 * weighted[(i, k)]);
        let source = |impulse: &Impulse| {
            let direction: Vec<f64> = impulse.field().iter().map(Polynomial::constant_term).collect();
            let along = |p: &Polynomial| {
                let parts = direction.iter().enumerate().filter(|(_, h)| **h != 0.0);
                parts.fold(Polynomial::zero(n), |sum, (i, h)| sum + p.derivative(i) * *h)
            };
            let mut moved = functions.clone();
            let slopes = (1..=highest).map(|_| {
                moved = moved.iter().map(along).collect();
                at_nodes(&moved)
            });
            let slopes = slopes.collect();
            let (jumps, mut inverse) = (impulse.jumps(), 1.0);
            let factor = |k: u32| {
                inverse *= if k == 0 { 1.0 } else { -f64::from(k).recip() };
                if k < 3 { 0.0 } else { jumps.rate() * inverse * jumps.amplitude().moment(k) }
            };
            Source { factors: (0..=highest).map(factor).collect(), slopes }
        };
        Some(DerivativeMoments { sources: operator.impulses().iter().map(source).collect(), weighted })
    }

    /// Adds their part of the left sides and of the Jacobian.
    pub(super) fn add(&self, a: &Col<f64>, residual: &mut Col<f64>, jacobian: &mut Mat<f64>) {
        for Source { factors, slopes } in &self.sources {
            let highest = slopes.len();
            let derivatives: Vec<Col<f64>> = slopes.iter().map(|slope| slope * a).collect();
            let nodes = self.weighted.nrows();
            // B_0 … B_highest at each node, by B_{k+1} = Σ_j C(k, j) B_{k−j} D^{j+1}Q.
            let mut bell = vec![vec![1.0; nodes]];
            for k in 0..highest {
                let term = |i: usize| (0..=k).map(|j| binomial(k, j) * bell[k - j][i] * derivatives[j][i]).sum::<f64>();
                bell.push((0..nodes).map(term).collect());
            }
            let value = Col::from_fn(nodes, |i| (3..=highest).map(|k| factors[k] * bell[k][i]).sum::<f64>());
            *residual += self.weighted.transpose() * &value;
            for (j, slope) in slopes.iter().enumerate().map(|(j, slope)| (j + 1, slope)) {
                let partial =
                    |i: usize| (3.max(j)..=highest).map(|k| factors[k] * binomial(k, j) * bell[k - j][i]).sum::<f64>();
                let partial: Vec<f64> = (0..nodes).map(partial).collect();
                let scaled = Mat::from_fn(nodes, slope.ncols(), |i, l| partial[i] * slope[(i, l)]);
                *jacobian += self.weighted.transpose() * &scaled;
            }
        }
    }
}

/// The nodes and weights of the product of a rule with itself.
fn product(rule: &Rule, n: usize) -> Vec<(Vec<f64>, f64)> {
    (0..n).fold(vec![(Vec::new(), 1.0)], |nodes, _| {
        let longer = |(x, w): &(Vec<f64>, f64)| {
            let (x, w) = (x.clone(), *w);
            rule.iter().map(move |(z, v)| ([x.as_slice(), &[z]].concat(), w * v)).collect::<Vec<_>>()
        };
        nodes.iter().flat_map(longer).collect()
    })
}

fn binomial(n: usize, k: usize) -> f64 {
    (0..k).map(|i| (n - i) as f64 / (i + 1) as f64).product()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop")]
    use super::*;
    use crate::closure::classical::galerkin::{GalerkinEquations, HermiteGalerkin};
    use crate::polynomial::of_one;
    use crate::problem::Problem;

    fn equations(highest: u32) -> HermiteGalerkin {
        let problem = Problem::from_toml(
            "states = [\"x\", \"v\"]\n[drift]\nx = \"v\"\nv = \"-v - x\"\n[impulse.j]\nrate = 2\n\
             amplitude = { exponential = { mean = 0.3 } }\nv = 1\nx = 0.5",
        )
        .unwrap();
        HermiteGalerkin::new(problem.operator(), 4, highest)
    }

    /// The Jacobian is that of the differences, whose error is the step squared times third derivatives.
    #[test]
    fn the_jacobian_is_the_derivative() {
        for highest in [2, 3, 4, 6] {
            let equations = equations(highest);
            let size = equations.gaussian().nrows();
            let a = &equations.gaussian() + Col::from_fn(size, |k| 0.05 * (1.3 * k as f64).sin());
            let (_, jacobian) = equations.evaluate(&a);
            for l in 0..size {
                let moved = |h: f64| equations.evaluate(&(&a + Col::from_fn(size, |k| if k == l { h } else { 0.0 }))).0;
                let difference = (moved(1e-4) - moved(-1e-4)) * 5e3;
                for k in 0..size {
                    let exact = jacobian[(k, l)];
                    assert!((difference[k] - exact).abs() < 1e-5 * (1.0 + exact.abs()), "{highest} {k} {l}");
                }
            }
        }
    }

    /// For Q = −|z|²/2, F_k = ∫ L f_N ψ_k is the mean of 𝓖ψ_k under f_N: exactly, where the expansion goes as far as ψ's degree.
    #[test]
    fn the_expansion_is_exact_for_functions_of_its_order() {
        let problem = Problem::from_toml(
            "states = [\"x\"]\n[drift]\nx = \"-x\"\n[impulse.j]\nrate = 2\namplitude = { exponential = { mean = 0.3 } }\nx = 0.5",
        )
        .unwrap();
        let gaussian = crate::polynomial::Gaussian {
            mean: nalgebra::DVector::zeros(1),
            covariance: nalgebra::DMatrix::identity(1, 1),
        };
        let equations = HermiteGalerkin::new(problem.operator(), 4, 4);
        let (found, _) = equations.evaluate(&equations.gaussian());
        for k in 1..=4_u32 {
            let mut series = Polynomial::zero(1);
            series.add_term(&of_one(1, 0, k), 1.0);
            let exact = gaussian.expectation(&problem.operator().generator(&in_powers(&series)));
            assert!((found[k as usize - 1] - exact).abs() < 1e-13, "{k}: {} {exact}", found[k as usize - 1]);
        }
    }
}
