use super::{Duffing, listed};
use crate::checks::positive;
use crate::error::Result;
use crate::problem::Problem;
use crate::scalar::Scalar;
use crate::system::{Intensity, Oscillator, PolynomialDrift};

/// A Duffing oscillator under coloured noise, x″ + c x′ + k x + μ x³ = z, where z is white noise ξ behind a filter:
/// z′ = a (ξ − z), or z″ + 2 ζ ω z′ + ω² z = ω² ξ.
///
/// The states are x, v = x′, the force z and, behind a filter of second order, w = z′. D is the intensity of ξ. Slow
/// noise passes either filter as it is, so that for a or ω without bounds the oscillator is that under white noise. No
/// closed form is known for μ ≠ 0; with μ = 0 < k the density is normal.
///
/// # Reference
/// G. E. Uhlenbeck and L. S. Ornstein, On the theory of the Brownian motion, Physical Review 36 (1930) 823-841,
/// doi:10.1103/PhysRev.36.823.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilteredDuffing {
    oscillator: Duffing,
    filter: Filter,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Filter {
    /// a.
    First(f64),
    /// ω and ζ.
    Second(f64, f64),
}

const REMEDY: &str = "a filter with a stationary force has all of its parameters finite and above zero";

impl FilteredDuffing {
    /// The oscillator behind a filter of first order with the bandwidth a: E z² = a D, correlated as exp(−a |τ|).
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless a is finite and positive.
    ///
    /// ```
    /// use expoly::models::{Duffing, FilteredDuffing};
    /// // Linear: E x′² is a²/(a² + c a + k) of the D/c under white noise.
    /// let filtered = FilteredDuffing::first_order(Duffing::new(0.2, 1.0, 0.0, 0.4)?, 2.0)?;
    /// let covariance = filtered.problem()?.gaussian()?.covariance;
    /// assert!((covariance[(1, 1)] - 2.0 * 4.0 / (4.0 + 0.4 + 1.0)).abs() < 1e-12);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn first_order(oscillator: Duffing, bandwidth: f64) -> Result<Self> {
        let filter = Filter::First(positive("bandwidth a", bandwidth, REMEDY)?);
        Ok(FilteredDuffing { oscillator, filter })
    }

    /// The oscillator behind a filter of second order with the frequency ω and the damping ratio ζ: E z² = ω D/(2ζ),
    /// with most of its power near ω where ζ is small.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless ω and ζ are finite and positive.
    ///
    /// ```
    /// use expoly::models::{Duffing, FilteredDuffing};
    /// let filtered = FilteredDuffing::second_order(Duffing::new(0.2, 1.0, 0.3, 0.4)?, 1.5, 0.2)?;
    /// let covariance = filtered.problem()?.gaussian()?.covariance;
    /// assert!((covariance[(2, 2)] - 1.5 * 0.4 / 0.4).abs() < 1e-12);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn second_order(oscillator: Duffing, frequency: f64, damping_ratio: f64) -> Result<Self> {
        let frequency = positive("frequency ω", frequency, REMEDY)?;
        let filter = Filter::Second(frequency, positive("damping ratio ζ", damping_ratio, REMEDY)?);
        Ok(FilteredDuffing { oscillator, filter })
    }

    /// Oscillator and filter as a problem of three or four states.
    ///
    /// # Errors
    /// As [`Problem::of`].
    pub fn problem(&self) -> Result<Problem> {
        let oscillator = self.oscillator;
        match self.filter {
            Filter::First(a) => Problem::of(FirstOrder { oscillator, a }),
            Filter::Second(omega, zeta) => Problem::of(SecondOrder { oscillator, omega, zeta }),
        }
    }
}

struct FirstOrder {
    oscillator: Duffing,
    a: f64,
}

impl PolynomialDrift<3, 1> for FirstOrder {
    #[inline]
    fn drift<S: Scalar>(&self, [x, v, z]: [S; 3]) -> [S; 3] {
        [v, z - self.oscillator.force(x, v), -(z * self.a)]
    }

    #[inline]
    fn noise<S: Scalar>(&self, _: [S; 3]) -> [[S; 1]; 3] {
        behind(self.a, self.oscillator.intensity())
    }

    fn names(&self) -> Vec<String> {
        ["x", "v", "z"].map(str::to_owned).to_vec()
    }

    fn parameters(&self) -> Vec<(String, f64)> {
        [Oscillator::parameters(&self.oscillator), listed("a", [self.a])].concat()
    }
}

struct SecondOrder {
    oscillator: Duffing,
    omega: f64,
    zeta: f64,
}

impl PolynomialDrift<4, 1> for SecondOrder {
    #[inline]
    fn drift<S: Scalar>(&self, [x, v, z, w]: [S; 4]) -> [S; 4] {
        let square = self.omega * self.omega;
        [v, z - self.oscillator.force(x, v), w, -(w * (2.0 * self.zeta * self.omega) + z * square)]
    }

    #[inline]
    fn noise<S: Scalar>(&self, _: [S; 4]) -> [[S; 1]; 4] {
        behind(self.omega * self.omega, self.oscillator.intensity())
    }

    fn names(&self) -> Vec<String> {
        ["x", "v", "z", "w"].map(str::to_owned).to_vec()
    }

    fn parameters(&self) -> Vec<(String, f64)> {
        [Oscillator::parameters(&self.oscillator), listed("omega zeta", [self.omega, self.zeta])].concat()
    }
}

/// Noise on the last state alone, times a gain.
#[inline]
fn behind<S: Scalar, const N: usize>(gain: f64, intensity: Intensity) -> [[S; 1]; N] {
    std::array::from_fn(|i| [S::from(if i + 1 == N { gain * intensity.amplitude() } else { 0.0 })])
}
