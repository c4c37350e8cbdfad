use super::Duffing;
use crate::checks::positive;
use crate::error::Result;
use crate::parametric;
use crate::problem::Problem;
use crate::scalar::Scalar;
use crate::system::{Drift, Intensity, Oscillator, Parameter};

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
            Filter::First(a) => Problem::parametric(FirstOrder { oscillator, a }),
            Filter::Second(omega, zeta) => Problem::parametric(SecondOrder { oscillator, omega, zeta }),
        }
    }
}

struct FirstOrder<P = f64> {
    oscillator: Duffing<P>,
    a: P,
}

impl<P: Parameter> Drift<3, 1, P> for FirstOrder<P> {
    #[inline]
    fn drift<S: Scalar<P>>(&self, [x, v, z]: [S; 3]) -> [S; 3] {
        [v, z - self.oscillator.force(x, v), -(z * self.a)]
    }

    #[inline]
    fn noise<S: Scalar<P>>(&self, _: [S; 3]) -> [[S; 1]; 3] {
        behind(self.a, self.oscillator.intensity())
    }

    fn names(&self) -> Vec<String> {
        ["x", "v", "z"].map(str::to_owned).to_vec()
    }
}

parametric!(FirstOrder { oscillator, a: "a" });

struct SecondOrder<P = f64> {
    oscillator: Duffing<P>,
    omega: P,
    zeta: P,
}

impl<P: Parameter> Drift<4, 1, P> for SecondOrder<P> {
    #[inline]
    fn drift<S: Scalar<P>>(&self, [x, v, z, w]: [S; 4]) -> [S; 4] {
        let square = self.omega * self.omega;
        [v, z - self.oscillator.force(x, v), w, -(w * (self.zeta * self.omega * 2.0) + z * square)]
    }

    #[inline]
    fn noise<S: Scalar<P>>(&self, _: [S; 4]) -> [[S; 1]; 4] {
        behind(self.omega * self.omega, self.oscillator.intensity())
    }

    fn names(&self) -> Vec<String> {
        ["x", "v", "z", "w"].map(str::to_owned).to_vec()
    }
}

parametric!(SecondOrder { oscillator, omega: "omega", zeta: "zeta" });

/// Noise on the last state alone, times a gain.
#[inline]
fn behind<P: Parameter, S: Scalar<P>, const N: usize>(gain: P, intensity: Intensity<P>) -> [[S; 1]; N] {
    std::array::from_fn(|i| [if i + 1 == N { S::from(gain * intensity.amplitude()) } else { S::zero() }])
}
