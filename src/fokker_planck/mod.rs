//! The Fokker-Planck operator of a system.
//!
//! 0 = L p = −∂_i(f_i p) + ½ ∂_i∂_j(B_ij p), B = G Gᵀ, is the equation of the stationary density p. For p = exp(Q) it
//! divides by p and becomes the *residual*
//!
//! r(x; Q) = −∇·f − f·∇Q + ½ [ ∂_i∂_jB_ij + 2 (∂_jB_ij) ∂_iQ + B_ij (∂_i∂_jQ + ∂_iQ ∂_jQ) ],
//!
//! which is quadratic in the coefficients of Q. Under Poisson impulses x → x + H(x) Y at the rate λ the equation is that of A. N.
//! Kolmogorov and W. Feller, with λ (E\[p before\] − p) added; where H is constant, that is λ (E\[p(x − H Y)\] − p). [`FokkerPlanck`] holds the operator as polynomials: exact degrees, exact
//! Gaussian moments, an equation to print. [`Local`] is the operator at one point, which dual numbers compute from the user's
//! own definition; the equations at nodes are assembled from it.

mod impulse_term;
mod impulses;
mod local;
mod near;
mod stretched;
mod text;

pub(crate) use impulse_term::{ImpulseAt, ImpulseTerm};
pub use impulses::Impulse;
pub(crate) use local::Local;

use crate::checks::require;
use crate::error::{Error, Result};
use crate::polynomial::{Arena, Frame, Polynomial, Symbol, multiplied};
use crate::system::Interpretation;
use nalgebra::DMatrix;
use num_dual::Dual64;

/// The Fokker-Planck operator as polynomials: the Itô drift f, the diffusion matrix B = G Gᵀ, and impulses.
#[derive(Clone, Debug, PartialEq)]
pub struct FokkerPlanck {
    drift: Vec<Polynomial>,
    diffusion: Vec<Vec<Polynomial>>,
    impulses: Vec<Impulse>,
    /// In a derivative of an operator that of the impulses' part.
    moved: Vec<ImpulseTerm>,
}

/// Drift and noise are of this degree at most.
pub(crate) const HIGHEST_DEGREE: u32 = 60;

impl FokkerPlanck {
    /// The operator of a drift, of the noise's columns and of impulses. A Stratonovich drift is converted to Itô's,
    /// f_i += ½ Σ_jk G_jk ∂_j G_ik.
    ///
    /// # Errors
    /// [`Error::NotFinite`] if a coefficient is NaN or infinite, [`Error::OutOfRange`] for a degree above 60,
    /// [`Error::NoDensity`] if B and all H vanish identically; those of [`PoissonImpulses::new`](crate::PoissonImpulses::new).
    pub(crate) fn new(
        drift: &[Polynomial],
        columns: &[Vec<Polynomial>],
        interpretation: Interpretation,
        impulses: Vec<Impulse>,
    ) -> Result<Self> {
        let n = drift.len();
        impulses.iter().try_for_each(|impulse| impulse.process().checked().map(|_| ()))?;
        for i in 0..n {
            impulses.iter().try_for_each(|impulse| sound("impulses", i, &impulse.field()[i]))?;
            if impulses.iter().any(|impulse| !impulse.field()[i].is_plain()) {
                let (what, remedy) = (
                    "impulses whose factor is no polynomial",
                    "write a polynomial that is close to it where the density is",
                );
                return Err(Error::NotServed { method: "Fokker-Planck operator", what, remedy });
            }
            sound("drift", i, &drift[i])?;
            columns.iter().try_for_each(|column| sound("noise", i, &column[i]))?;
        }
        let mut drift = drift.to_vec();
        if interpretation == Interpretation::Stratonovich {
            for (i, correction) in noise_induced_drift(columns, n).into_iter().enumerate() {
                drift[i] = &drift[i] + &correction;
            }
        }
        let product =
            |i: usize, j: usize| columns.iter().fold(Polynomial::zero(n), |sum, column| sum + &column[i] * &column[j]);
        let diffusion: Vec<Vec<Polynomial>> = (0..n).map(|i| (0..n).map(|j| product(i, j)).collect()).collect();
        // Products of large finite coefficients may be infinite.
        for i in 0..n {
            all_finite("drift", i, &drift[i])?;
            diffusion[i].iter().try_for_each(|entry| all_finite("squared noise", i, entry))?;
        }
        let operator = FokkerPlanck { drift, diffusion, impulses, moved: Vec::new() };
        if (0..n).any(|i| operator.is_driven(i)) {
            Ok(operator)
        } else {
            Err(Error::no_density("the noise vanishes identically; give at least one intensity above zero"))
        }
    }

    /// The number of states.
    pub fn dimension(&self) -> usize {
        self.drift.len()
    }

    /// The Itô drift f.
    pub fn drift(&self) -> &[Polynomial] {
        &self.drift
    }

    /// The diffusion matrix B = G Gᵀ.
    pub fn diffusion(&self) -> &[Vec<Polynomial>] {
        &self.diffusion
    }

    /// The states i with some B_ij ≠ 0, j ≠ i.
    pub(crate) fn coupled(&self) -> Vec<usize> {
        let n = self.dimension();
        (0..n).filter(|&i| (0..n).any(|j| j != i && !self.diffusion[i][j].is_zero())).collect()
    }

    /// The number of terms of the drift.
    pub(crate) fn drift_terms(&self) -> usize {
        self.drift.iter().map(|f| f.terms().count()).sum()
    }

    /// The number of terms of B, on the diagonal and below it, that depend on the state.
    pub(crate) fn varying_noise(&self) -> usize {
        let lower = self.diffusion.iter().enumerate().flat_map(|(i, row)| &row[..=i]);
        lower.flat_map(Polynomial::terms).filter(|(powers, _)| powers.iter().any(|power| *power > 0)).count()
    }

    /// Whether the drift is linear and the noise constant, so that a stationary density is normal.
    pub(crate) fn is_linear(&self) -> bool {
        self.drift.iter().all(|f| f.is_plain() && f.degree() <= 1) && self.varying_noise() == 0
    }

    /// Whether drift and noise are polynomials of the states, without functions of them.
    pub fn is_polynomial(&self) -> bool {
        self.drift.iter().chain(self.diffusion.iter().flatten()).all(Polynomial::is_plain)
    }

    /// Refuses functions of the states, for a method that takes polynomials alone.
    ///
    /// # Errors
    /// [`Error::NotServed`].
    pub(crate) fn require_polynomial(&self, method: &'static str) -> Result<()> {
        let (what, remedy) =
            ("functions of the states, such as sin x or |v|", "take `Closure::new`, the grid or the simulation");
        if self.is_polynomial() { Ok(()) } else { Err(Error::NotServed { method, what, remedy }) }
    }

    /// Requires that noise reaches every state, its own or that of states which its drift contains, or that impacts join with it.
    ///
    /// # Errors
    /// [`Error::NoDensity`] otherwise: the motion of such a state is deterministic, and it has no density.
    pub(crate) fn require_reached(&self, joined: &[[usize; 2]]) -> Result<()> {
        let n = self.dimension();
        let mut reached: Vec<bool> = (0..n).map(|i| self.is_driven(i)).collect();
        let meet = |i: usize, j: usize| joined.contains(&[i, j]) || joined.contains(&[j, i]);
        let contains = |i: usize, j: usize| meet(i, j) || self.drift[i].contains(j);
        for _ in 0..n {
            reached = (0..n).map(|i| reached[i] || (0..n).any(|j| reached[j] && contains(i, j))).collect();
        }
        match reached.iter().position(|reached| !reached) {
            Some(state) => Err(Error::no_density(format!(
                "no noise reaches state {state}, not even through other states; leave it out, or give it noise"
            ))),
            None => Ok(()),
        }
    }

    /// Whether white noise acts on any state.
    pub(crate) fn has_white_noise(&self) -> bool {
        (0..self.dimension()).any(|i| !self.diffusion[i][i].is_zero())
    }

    /// Whether white noise or impulses act on a state.
    fn is_driven(&self, i: usize) -> bool {
        !self.diffusion[i][i].is_zero() || self.impulses.iter().any(|impulse| !impulse.field()[i].is_zero())
    }

    /// The highest total degree among drift and diffusion.
    pub fn degree(&self) -> u32 {
        self.drift.iter().chain(self.diffusion.iter().flatten()).map(Polynomial::degree).max().unwrap_or(0)
    }

    /// The divergence ∇·f of the drift.
    pub fn divergence(&self) -> Polynomial {
        let n = self.dimension();
        (0..n).fold(Polynomial::zero(n), |sum, i| sum + self.drift[i].derivative(i))
    }

    /// The vector Σ_j ∂_jB_ij.
    pub fn diffusion_divergence(&self) -> Vec<Polynomial> {
        let n = self.dimension();
        let row = |row: &Vec<Polynomial>| (0..n).fold(Polynomial::zero(n), |sum, j| sum + row[j].derivative(j));
        self.diffusion.iter().map(row).collect()
    }

    /// −f_i + Σ_j ∂_jB_ij, the residual's coefficients of ∂_iQ.
    pub(crate) fn backward(&self) -> Vec<Polynomial> {
        self.diffusion_divergence().iter().zip(&self.drift).map(|(spread, f)| spread - f).collect()
    }

    /// The residual r(x; Q) = L exp(Q) / exp(Q) as a polynomial. It vanishes identically if exp(Q) is stationary. Impulses, whose
    /// part is no polynomial, are left out.
    ///
    /// ```
    /// use expoly::{Polynomial, models::{Linear, Solved}};
    /// let problem = Linear::new(0.5, 1.0, 0.5)?.problem()?;
    /// let [x, v] = [0, 1].map(|i| Polynomial::variable(2, i));
    /// let q = &x * &x * -0.5 + &v * &v * -0.5; // −(c/D)(v² + k x²)/2
    /// assert!(problem.operator().residual(&q).is_zero());
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn residual(&self, q: &Polynomial) -> Polynomial {
        let n = self.dimension();
        let gradient: Vec<Polynomial> = (0..n).map(|i| q.derivative(i)).collect();
        let (spread, backward) = (self.diffusion_divergence(), self.backward());
        let mut r = &self.divergence() * -1.0;
        for i in 0..n {
            r = r + &backward[i] * &gradient[i] + spread[i].derivative(i) * 0.5;
            for j in 0..n {
                let curvature = gradient[i].derivative(j) + &gradient[i] * &gradient[j];
                r = r + &self.diffusion[i][j] * &curvature * 0.5;
            }
        }
        r
    }

    /// The state that is the velocity of state `i`: j where the drift of x_i is x_j alone and no noise drives x_i.
    pub fn velocity_of(&self, i: usize) -> Option<usize> {
        let n = self.dimension();
        (i < n && !self.is_driven(i))
            .then(|| (0..n).find(|&j| j != i && self.drift[i] == Polynomial::variable(n, j)))
            .flatten()
    }

    /// The same operator for the scaled coordinates z of x = m + L z: drift L⁻¹f and diffusion L⁻¹B L⁻ᵀ.
    pub(crate) fn in_frame(&self, frame: &Frame) -> Self {
        self.in_states(&frame.state_polynomials(), frame.inverse())
    }

    /// The same for any z of which the states are linear functions, with the matrix L⁻¹ of z.
    pub(crate) fn in_states(&self, states: &[Polynomial], inverse: &DMatrix<f64>) -> Self {
        let n = self.dimension();
        let arena = Arena::new(n);
        let state: Vec<Symbol<'_>> = states.iter().map(|p| arena.symbol(p.clone())).collect();
        let in_z = |p: &Polynomial| p.evaluate(&state).polynomial(n);
        let drift: Vec<Polynomial> = self.drift.iter().map(in_z).collect();
        let diffusion: Vec<Vec<Polynomial>> = self.diffusion.iter().map(|row| row.iter().map(in_z).collect()).collect();
        let column = |j: usize| diffusion.iter().map(|row| row[j].clone()).collect::<Vec<_>>();
        let halves: Vec<Vec<Polynomial>> = (0..n).map(|j| multiplied(inverse, &column(j))).collect();
        let half = |i: usize| halves.iter().map(|column| column[i].clone()).collect::<Vec<_>>();
        let fields = |field: &[Polynomial]| multiplied(inverse, field);
        FokkerPlanck {
            drift: fields(&drift),
            diffusion: (0..n).map(|i| multiplied(inverse, &half(i))).collect(),
            impulses: self.impulses_in(&in_z, &fields),
            moved: self
                .moved
                .iter()
                .map(|term| term.with(1.0, |h| fields(&h.iter().map(in_z).collect::<Vec<_>>())))
                .collect(),
        }
    }

    /// Of an operator whose last state is a parameter ε, and of its `impulses`, the coefficient of this.
    pub(crate) fn derivative(&self, impulses: &[Impulse<Dual64>]) -> Self {
        let n = self.dimension() - 1;
        let part = |p: &Polynomial| p.coefficient_of_last(1);
        FokkerPlanck {
            drift: self.drift[..n].iter().map(part).collect(),
            diffusion: self.diffusion[..n].iter().map(|row| row[..n].iter().map(part).collect()).collect(),
            impulses: Vec::new(),
            moved: impulses.iter().filter_map(ImpulseTerm::derivative).collect(),
        }
    }

    /// The operator 0 in so many states.
    pub(crate) fn zero(n: usize) -> Self {
        let zero = || Polynomial::zero(n);
        let diffusion = (0..n).map(|_| (0..n).map(|_| zero()).collect()).collect();
        FokkerPlanck { drift: (0..n).map(|_| zero()).collect(), diffusion, impulses: Vec::new(), moved: Vec::new() }
    }

    /// Whether drift, diffusion and impulses vanish.
    pub(crate) fn is_zero(&self) -> bool {
        let struck = !self.impulses.is_empty() || !self.moved.is_empty();
        !struck && self.drift.iter().chain(self.diffusion.iter().flatten()).all(Polynomial::is_zero)
    }

    /// The same operator for the time t/`unit`.
    pub(crate) fn in_time(&self, unit: f64) -> Self {
        let scaled = |row: &Vec<Polynomial>| row.iter().map(|p| p * unit).collect();
        FokkerPlanck {
            drift: scaled(&self.drift),
            diffusion: self.diffusion.iter().map(scaled).collect(),
            impulses: self.impulses.iter().map(|impulse| impulse.with(unit, impulse.field().to_vec())).collect(),
            moved: self.moved.iter().map(|term| term.with(unit, <[Polynomial]>::to_vec)).collect(),
        }
    }

    /// The rate of change of the mean of `statistic` as a polynomial: f·∇φ + ½ B:∇∇φ, and λ E[φ(x + H Y) − φ(x)] of impulses. Its
    /// stationary mean is zero, which makes every polynomial a check of a density: a *moment equation*. Under impulses a statistic with
    /// functions of the states has none.
    pub fn generator(&self, statistic: &Polynomial) -> Polynomial {
        let n = self.dimension();
        let mut rate = Polynomial::zero(n);
        for i in 0..n {
            let slope = statistic.derivative(i);
            rate = rate + &self.drift[i] * &slope;
            for j in 0..n {
                rate = rate + &self.diffusion[i][j] * &slope.derivative(j) * 0.5;
            }
        }
        rate + self.by_impulses(statistic)
    }
}

/// ½ Σ_jk G_jk ∂_j G_ik, the difference between the mean rate of change and the drift in Stratonovich's sense.
pub(crate) fn noise_induced_drift(columns: &[Vec<Polynomial>], n: usize) -> Vec<Polynomial> {
    let induced = |i: usize| {
        let mut sum = Polynomial::zero(n);
        for column in columns {
            for j in 0..n {
                sum = sum + &column[j] * &column[i].derivative(j) * 0.5;
            }
        }
        sum
    };
    (0..n).map(induced).collect()
}

/// Refuses coefficients that are not finite, and degrees above [`HIGHEST_DEGREE`].
fn sound(part: &'static str, state: usize, polynomial: &Polynomial) -> Result<()> {
    all_finite(part, state, polynomial)?;
    let (degree, name) =
        (polynomial.degree(), if part == "drift" { "degree of the drift" } else { "degree of the noise" });
    let remedy = "at most 60 is served: take a polynomial of a lower degree where the states are";
    require(degree <= HIGHEST_DEGREE, name, f64::from(degree), remedy).map(|_| ())
}

fn all_finite(part: &'static str, state: usize, polynomial: &Polynomial) -> Result<()> {
    match polynomial.not_finite() {
        None => Ok(()),
        Some((exponents, value)) => Err(Error::NotFinite { part, state, exponents, value }),
    }
}
