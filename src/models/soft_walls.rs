use super::{Duffing, Solved};
use crate::checks::{finite, positive, require};
use crate::error::Result;
use crate::problem::{Problem, Wall};
use crate::scalar::Scalar;
use crate::system::{Intensity, Oscillator, Parameter, Parametric};

/// A Duffing oscillator between two soft walls at b₁ and b₂, y″ + c y′ + k y + μ y³ + U′ + γ y′ = ξ: an ordinary oscillator that
/// approaches the one between rigid walls with the restitution r as the walls get stiffer.
///
/// The energy of the contact is the polynomial U = e s²ᵐ with an odd m, where s goes from −1 at b₁ to 1 at b₂: e at the walls,
/// and (1 − δ/ℓ)²ᵐ of it at a distance δ on the motion's side, with half the distance of the walls ℓ = (b₂ − b₁)/2. One wall is
/// the case that the other is out of the motion's reach. The damping of the contact is γ = 2ζ √(2e) (m/ℓ) sᵐ⁻¹ with
/// ζ = −ln r/√(π² + ln² r). In q = √(2e) sᵐ and τ = ∫ (m/ℓ) √(2e) sᵐ⁻¹ dt contact alone is the linear oscillator
/// d²q/dτ² + 2ζ dq/dτ + q = 0, and an impact half a period of it: the body leaves with r times the speed that it came with, whatever
/// the speed, the power m and the energy e.
///
/// The stiffness of the walls is K = U″(b) = 2m (2m − 1) e/ℓ², and bodies of the speed w enter them by w/√K or so: the density
/// differs from that of rigid walls by L¹ ~ K^(−1/2), K^(−0.4) with r = 0.7. For r = 1, p = C exp(−c H/D) with U in the energy H.
///
/// Behind the walls the force grows by orders within ℓ/m, and a linear estimate of the motion does not see it. By their defaults
/// the methods serve m ≤ 9. Beyond, the closure is refused, a [`Grid`](crate::Grid) is given a domain that ends where U is 16 D/c or
/// so, with some 8 + 3m/2 cells along y, and a [`Simulation`](crate::Simulation) its time step, burn-in and interval.
///
/// # Reference
/// K. H. Hunt and F. R. E. Crossley, Coefficient of restitution interpreted as damping in vibroimpact, Journal of Applied Mechanics
/// 42 (1975) 440-445, doi:10.1115/1.3423596, of contacts whose damping follows their force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoftWalls<P = f64> {
    oscillator: Duffing<P>,
    /// The offsets of the walls.
    offsets: [P; 2],
    restitution: P,
    power: u32,
    energy: P,
}

impl SoftWalls {
    /// The oscillator, the places of the walls b₁ < b₂ and their restitution r, the odd power m from 3 to 29, and the energy e of
    /// contact at the walls, per unit mass.
    ///
    /// e = 0.561 D/c, with e^(−C) for Euler's constant C, lets elastic walls reflect at b₁ and b₂ on average: moments then
    /// approach those of rigid walls like 1/K.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless the numbers are as said, finite, and e is positive.
    ///
    /// ```
    /// use expoly::{Closure, Density, models::{Duffing, SoftWalls}};
    /// let duffing = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
    /// let elastic = SoftWalls::new(duffing, [-1.0, 1.0], 1.0, 3, 0.56)?.problem()?;
    /// let density = Closure::new(6).solve(&elastic)?; // contains s⁶
    /// assert!((density.moment(&[0, 2])?.value - 1.0).abs() < 1e-8 && density.l1_estimate() < 1e-8);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn new(oscillator: Duffing, [low, high]: [f64; 2], restitution: f64, power: u32, energy: f64) -> Result<Self> {
        let remedy = "the second wall is above the first one, at a finite distance";
        positive("distance of the walls", finite("offset of the wall", high)? - low, remedy)?;
        let served = power % 2 == 1 && (3..=29).contains(&power);
        let remedy = "give an odd power from 3 to 29, so that the damping is above zero on both sides";
        require(served, "power m", f64::from(power), remedy)?;
        let energy = positive("energy e", energy, "the walls hold bodies by an energy above zero")?;
        let soft = SoftWalls { oscillator, offsets: [low, high], restitution, power, energy };
        soft.walls().map(|_| soft)
    }

    /// The oscillator between soft walls.
    ///
    /// # Errors
    /// As [`Problem::of`].
    pub fn problem(&self) -> Result<Problem> {
        Problem::parametric(*self)
    }

    /// The same oscillator between rigid walls at b₁ and b₂, the limit of m → ∞.
    ///
    /// # Errors
    /// As [`Problem::with_wall`].
    pub fn rigid(&self) -> Result<Problem> {
        self.walls()?.into_iter().try_fold(self.oscillator.problem()?, Problem::with_wall)
    }

    /// The stiffness of the walls K = U″(b), per unit mass.
    pub fn stiffness(&self) -> f64 {
        let m = f64::from(self.power);
        2.0 * m * (2.0 * m - 1.0) * self.energy / self.half().powi(2)
    }

    fn walls(&self) -> Result<[Wall; 2]> {
        let [low, high] = self.offsets;
        Ok([Wall::above(low, self.restitution)?, Wall::below(high, self.restitution)?])
    }
}

impl<P: Parameter> SoftWalls<P> {
    /// ℓ.
    fn half(&self) -> P {
        (self.offsets[1] - self.offsets[0]) / 2.0
    }

    /// ζ.
    fn damping_ratio(&self) -> P {
        let decay = -self.restitution.ln();
        decay / (decay * decay + std::f64::consts::PI.powi(2)).sqrt()
    }
}

impl<P: Parameter> Oscillator<P> for SoftWalls<P> {
    #[inline]
    fn force<S: Scalar<P>>(&self, y: S, v: S) -> S {
        let half = self.half();
        let s = (y - (self.offsets[0] + half)) * half.recip();
        // |q′| and q for √(2e) = 1.
        let steepness = s.powi(self.power - 1);
        let rate = half.recip() * f64::from(self.power);
        let damping = self.damping_ratio() * 2.0 * (self.energy * 2.0).sqrt() * rate;
        let contact = steepness * (steepness * s * (self.energy * rate * 2.0) + v * damping);
        self.oscillator.force(y, v) + contact
    }

    fn intensity(&self) -> Intensity<P> {
        self.oscillator.intensity()
    }
}

impl Parametric for SoftWalls {
    type With<P: Parameter> = SoftWalls<P>;

    fn with<P: Parameter>(&self, of: &mut dyn FnMut(&str, f64) -> P) -> SoftWalls<P> {
        let [low, high] = self.offsets;
        SoftWalls {
            oscillator: self.oscillator.with(of),
            offsets: [of("b1", low), of("b2", high)],
            restitution: of("r", self.restitution),
            power: self.power,
            energy: of("e", self.energy),
        }
    }
}
