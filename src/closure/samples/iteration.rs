//! Newton's method with a matrix that is kept for as long as it serves.

use super::assembly::Assembly;
use super::basis::Basis;
use super::products::{LANES, Lane};
use faer::Mat;
use faer::linalg::solvers::PartialPivLu;
use faer::prelude::*;

const MOST_STEPS: usize = 60;
/// The change of ln p, in the mean square, at which the equations count as solved.
const SOLVED: f64 = 1e-10;
/// The longest step, in the same measure.
const LONGEST: f64 = 0.5;
/// A step that leaves more than this share of the change to be done asks for a new matrix, within this distance.
const SLOW: f64 = 0.6;
const NEAR: f64 = 0.05;
/// Exact matrices, times the number of functions.
const MOST_REFRESHES: usize = 4000;
/// The shortest share of a step that is tried.
const SHORTEST: f64 = 1.0 / 64.0;

/// States whose slopes make the dissipative part of the first matrix: each has an equation for every noise.
const STATES_EACH: usize = 24;
const FEWEST: usize = 8192;

/// Where the iteration ended.
#[derive(Clone, Debug)]
pub(super) struct Ended {
    /// Coefficients, constant first.
    pub(super) a: Vec<f64>,
    /// ‖F‖ in orthonormal functions.
    pub(super) residual: f64,
    /// The root mean square of the residual at the states.
    pub(super) pointwise: f64,
    pub(super) solved: bool,
    pub(super) steps: usize,
}

/// The matrix of the equations linearised at the stationary density itself, A = ½(C − Cᵀ) − ½S.
///
/// At Q = ln p, E[ψ_k L′ψ_l] = ∫ p ψ_l Gψ_k = C_kl, and C + Cᵀ = −S, S_kl = E[∇ψ_k·B∇ψ_l]. Written so, A is dissipative
/// whatever the states: their noise cannot make a stable system unstable.
pub(super) fn dissipative(assembly: &Assembly<'_>) -> Mat<f64> {
    let noisy = &assembly.sites.noisy;
    let rates = assembly.images(|site, scratch| scratch.first.copy_from_slice(&site.drift));
    let count = (STATES_EACH * assembly.products.len() / noisy.len().max(1)).max(FEWEST);
    let slopes = assembly.slopes(count, noisy.len(), |site, i, direction| root(noisy, &site.diffusion, i, direction));
    let size = rates.nrows();
    // `rates` holds E[φ_k Gφ_l], the transpose of C.
    Mat::from_fn(size, size, |k, l| 0.5 * (rates[(l, k)] - rates[(k, l)] - slopes[(k, l)]))
}

/// Enters column `i` of a lower triangular root of B, among the states with noise.
fn root(noisy: &[usize], b: &[Lane], i: usize, column: &mut [Lane]) {
    let (size, n) = (noisy.len(), column.len());
    for l in 0..LANES {
        let b = |r: usize, c: usize| b[noisy[r] * n + noisy[c]][l];
        let mut lower = vec![vec![0.0_f64; size]; size];
        for c in 0..=i {
            let left = b(c, c) - (0..c).map(|m| lower[c][m] * lower[c][m]).sum::<f64>();
            // A direction without noise of its own adds nothing.
            let pivot = if left > 1e-12 * b(c, c) { left.sqrt() } else { 0.0 };
            lower[c][c] = pivot;
            for r in c + 1..size {
                let left = b(r, c) - (0..c).map(|m| lower[r][m] * lower[c][m]).sum::<f64>();
                lower[r][c] = if pivot > 0.0 { left / pivot } else { 0.0 };
            }
        }
        (0..size).for_each(|r| column[noisy[r]][l] = lower[r][i]);
    }
}

/// The equations at one Q.
struct At {
    a: Vec<f64>,
    /// F in orthonormal functions.
    tested: Mat<f64>,
    pointwise: f64,
}

/// The equations E[r ψ_k] = 0 for all functions of an assembly.
#[derive(Debug)]
pub(super) struct Iteration<'a> {
    pub(super) assembly: Assembly<'a>,
    pub(super) basis: &'a Basis,
}

impl Iteration<'_> {
    /// Newton's method with the matrix `first`, and with the exact one where that does not help or is slow near the end.
    ///
    /// Far from the solution the exact matrix is not the better one: where damping is weak, the chance of the states makes
    /// it indefinite, and its steps lead to spurious roots. A step is taken if the next one, by the same matrix, is
    /// shorter: that test knows no units.
    pub(super) fn run(&self, start: Vec<f64>, first: &Mat<f64>) -> Ended {
        let mut steps = 0;
        let mut now = self.at(start);
        let mut matrix = self.basis.form(first).partial_piv_lu();
        let mut d = change(&matrix, &now);
        let (mut solved, mut fresh, mut refreshes) = (false, false, 0);
        let most = (MOST_REFRESHES / d.len()).clamp(3, MOST_STEPS);
        while steps < MOST_STEPS {
            let size = norm(&d);
            let whole = (LONGEST / size).min(1.0);
            let mut length = whole;
            let mut accepted = None;
            // The negation also refuses NaN.
            while size >= SOLVED && length >= SHORTEST * whole {
                let next = self.at(self.moved(&now.a, &d, length));
                let left = change(&matrix, &next);
                if norm(&left) <= size * (1.0 - 0.25 * length) {
                    accepted = Some((next, left));
                    break;
                }
                length *= 0.5;
            }
            solved = size < SOLVED;
            let Some((next, left)) = accepted else {
                if solved || fresh || !size.is_finite() || refreshes == most {
                    break;
                }
                (matrix, fresh, refreshes) = (self.jacobian(&now.a).partial_piv_lu(), true, refreshes + 1);
                d = change(&matrix, &now);
                continue;
            };
            steps += 1;
            let slow = norm(&left) > size * SLOW;
            (now, d, fresh) = (next, left, false);
            if slow && refreshes < most && norm(&d) < NEAR && norm(&d) > SOLVED {
                (matrix, fresh, refreshes) = (self.jacobian(&now.a).partial_piv_lu(), true, refreshes + 1);
                d = change(&matrix, &now);
            }
        }
        Ended { residual: now.tested.norm_l2(), pointwise: now.pointwise, a: now.a, solved, steps }
    }

    fn at(&self, a: Vec<f64>) -> At {
        let (means, square) = self.assembly.residual(&a);
        At { a, tested: self.basis.tested(&means), pointwise: square.sqrt() }
    }

    fn moved(&self, a: &[f64], d: &[f64], length: f64) -> Vec<f64> {
        a.iter().zip(self.basis.coefficients(d)).map(|(a, step)| a + length * step).collect()
    }

    /// E[ψ_k L′ψ_l] at Q.
    fn jacobian(&self, a: &[f64]) -> Mat<f64> {
        let images = self.assembly.images(|site, scratch| self.assembly.linearised(a, site, scratch));
        self.basis.form(&images)
    }
}

/// d of A d = −F.
fn change(matrix: &PartialPivLu<f64>, at: &At) -> Vec<f64> {
    let d = matrix.solve(&at.tested);
    (0..d.nrows()).map(|k| -d[(k, 0)]).collect()
}

fn norm(d: &[f64]) -> f64 {
    d.iter().map(|d| d * d).sum::<f64>().sqrt()
}
