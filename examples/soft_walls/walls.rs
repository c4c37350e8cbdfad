//! The oscillator between soft walls, and that between rigid ones.

use expoly::models::Duffing;
use expoly::{Intensity, Oscillator, Problem, Result, Scalar, Wall};
use std::f64::consts::PI;

/// A Duffing oscillator between two soft walls at b₁ and b₂, y″ + c y′ + k y + μ y³ + U′ + γ y′ = ξ.
///
/// The energy of the contact is the polynomial U = e s²ᵐ with an odd m, where s goes from −1 at b₁ to 1 at b₂: e at the walls,
/// and (1 − δ/ℓ)²ᵐ of it at a distance δ on the motion's side, with half the distance of the walls ℓ = (b₂ − b₁)/2. The damping
/// of the contact is γ = 2ζ √(2e) (m/ℓ) sᵐ⁻¹ with ζ = −ln r/√(π² + ln² r). In q = √(2e) sᵐ and τ = ∫ (m/ℓ) √(2e) sᵐ⁻¹ dt contact
/// alone is the linear oscillator d²q/dτ² + 2ζ dq/dτ + q = 0, and an impact half a period of it: the body leaves with r times the
/// speed that it came with, whatever the speed, the power m and the energy e.
///
/// The stiffness of the walls is K = U″(b) = 2m (2m − 1) e/ℓ², and bodies of the speed w enter them by w/√K or so.
///
/// K. H. Hunt and F. R. E. Crossley, Coefficient of restitution interpreted as damping in vibroimpact, Journal of Applied Mechanics
/// 42 (1975) 440-445, doi:10.1115/1.3423596, have contacts whose damping follows their force.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SoftWalls {
    pub(crate) oscillator: Duffing,
    /// b₁ < b₂.
    pub(crate) offsets: [f64; 2],
    /// r.
    pub(crate) restitution: f64,
    /// m.
    pub(crate) power: u32,
    /// e.
    pub(crate) energy: f64,
}

impl SoftWalls {
    pub(crate) fn problem(self) -> Result<Problem> {
        Problem::of(self)
    }

    /// K.
    pub(crate) fn stiffness(&self) -> f64 {
        let m = f64::from(self.power);
        2.0 * m * (2.0 * m - 1.0) * self.energy / self.half().powi(2)
    }

    /// ℓ.
    fn half(&self) -> f64 {
        (self.offsets[1] - self.offsets[0]) / 2.0
    }

    /// ζ.
    fn damping_ratio(&self) -> f64 {
        let decay = -self.restitution.ln();
        decay / decay.hypot(PI)
    }
}

impl Oscillator for SoftWalls {
    fn force<S: Scalar>(&self, y: S, v: S) -> S {
        let half = self.half();
        let s = (y - (self.offsets[0] + half)) * half.recip();
        // |q′| and q for √(2e) = 1.
        let steepness = s.powi(self.power - 1);
        let rate = f64::from(self.power) / half;
        let damping = 2.0 * self.damping_ratio() * (2.0 * self.energy).sqrt() * rate;
        let contact = steepness * (steepness * s * (2.0 * self.energy * rate) + v * damping);
        self.oscillator.force(y, v) + contact
    }

    fn intensity(&self) -> Intensity {
        self.oscillator.intensity()
    }
}

/// The limit of ever stiffer walls.
pub(crate) fn rigid(oscillator: Duffing, [low, high]: [f64; 2], restitution: f64) -> Result<Problem> {
    use expoly::models::Solved;
    let walls = [Wall::above(low, restitution)?, Wall::below(high, restitution)?];
    walls.into_iter().try_fold(oscillator.problem()?, Problem::with_wall)
}
