use super::Duffing;
use super::follower::{Follower, Kind};
use crate::checks::positive;
use crate::error::Result;
use crate::problem::Problem;

/// A mass on a viscoelastic isolator, a spring and a dashpot (Kelvin and Voigt) beside a spring and a dashpot in line
/// (Maxwell): x″ + c x′ + k x + μ x³ + f = ξ, f′ = k₁ x′ − f/τ.
///
/// The states are x, v = x′ and the Maxwell element's force f. To slow motion the element is a dashpot of k₁ τ, to fast
/// motion a spring of k₁. No closed form is known for μ ≠ 0; with μ = 0 < k the density is normal.
///
/// # Reference
/// C. Zener, Elasticity and Anelasticity of Metals, University of Chicago Press, 1948, for the solid with c = μ = 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViscoelasticIsolator(Follower);

impl ViscoelasticIsolator {
    /// The mass on the spring and the dashpot that stand side by side, the Maxwell element's stiffness k₁ and its
    /// relaxation time τ.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless k₁ and τ are finite and positive.
    ///
    /// ```
    /// use expoly::models::{Duffing, ViscoelasticIsolator};
    /// // Linear: E f² = D k₁² τ²/(c (1 + c τ + (k + k₁) τ²) + k₁ τ).
    /// let isolator = ViscoelasticIsolator::new(Duffing::new(0.1, 1.0, 0.0, 0.2)?, 0.5, 2.0)?;
    /// let force = isolator.problem()?.gaussian()?.covariance[(2, 2)];
    /// assert!((force - 0.2 / (0.1 * (1.0 + 0.2 + 6.0) + 1.0)).abs() < 1e-12);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn new(mass: Duffing, stiffness: f64, relaxation: f64) -> Result<Self> {
        let remedy = "a Maxwell element has a spring and a dashpot, so that it must be finite and above zero";
        let forth = positive("stiffness k₁", stiffness, remedy)?;
        let rate = positive("relaxation time τ", relaxation, remedy)?.recip();
        Ok(ViscoelasticIsolator(Follower { oscillator: mass, back: 1.0, forth, rate }))
    }

    /// The isolator as a problem.
    ///
    /// # Errors
    /// As [`Problem::of`].
    pub fn problem(&self) -> Result<Problem> {
        self.0.problem(Kind::Force)
    }
}
