use super::Parameter;
use crate::checks::{finite, positive, require};
use crate::error::Result;
use crate::numerics::Rule;
use serde::{Deserialize, Serialize};

/// Poisson impulses: a process J that jumps by independent amplitudes Y at times whose distances are exponential, λ of them per
/// unit time on average.
///
/// A state under the impulses H dJ jumps from x to x + H(x) Y, H taken just before the impulse. Many small impulses of mean zero
/// are a white noise of the intensity D = λ E\[Y²\]/2 ([`PoissonImpulses::intensity`]). Rate and law may be parameters of a
/// [`Parametric`](crate::Parametric) system, which names them as it does all others ([`PoissonImpulses::of`]).
///
/// ```
/// use expoly::{Amplitude, PoissonImpulses};
/// let hail = PoissonImpulses::new(2.0, Amplitude::Normal { mean: 0.0, deviation: 0.5 })?;
/// assert_eq!(hail.intensity(), 0.25);
/// // As strong as a white noise of D = 0.2, by five impulses per unit time.
/// let same = PoissonImpulses::with_intensity(5.0, Amplitude::Laplace { mean: 0.0, scale: 1.0 }, 0.2)?;
/// assert!((same.intensity() - 0.2).abs() < 1e-15);
/// # Ok::<(), expoly::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PoissonImpulses<P = f64> {
    rate: P,
    amplitude: Amplitude<P>,
}

/// The law of an impulse's amplitude Y.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Amplitude<P = f64> {
    /// The normal law.
    Normal {
        /// E Y.
        mean: P,
        /// The standard deviation.
        deviation: P,
    },
    /// The exponential law of one sign, that of its mean.
    Exponential {
        /// E Y, which is not zero.
        mean: P,
    },
    /// Equal probability between two bounds.
    Uniform {
        /// The lower bound.
        low: P,
        /// The upper bound.
        high: P,
    },
    /// One of two numbers, either with the probability one half.
    TwoPoint {
        /// The one.
        a: P,
        /// The other.
        b: P,
    },
    /// The density exp(−|y − mean|/scale)/(2 scale).
    Laplace {
        /// E Y.
        mean: P,
        /// The mean of |Y − mean|.
        scale: P,
    },
}

/// The highest moment of an amplitude that is computed.
const HIGHEST_MOMENT: u32 = 120;

impl PoissonImpulses {
    /// Impulses at the mean rate λ per unit time.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless λ and the spread of the amplitude are finite and above zero (a
    /// normal or Laplace law may have no spread, but then a mean), and bounds rise.
    pub fn new(rate: f64, amplitude: Amplitude) -> Result<Self> {
        Self::of(rate, amplitude).checked()
    }

    /// The same with amplitudes in the proportions of `shape`, scaled so that λ E\[Y²\] = 2D for the intensity `d`.
    ///
    /// # Errors
    /// As [`PoissonImpulses::new`]; also for an intensity that is not finite and positive.
    pub fn with_intensity(rate: f64, shape: Amplitude, d: f64) -> Result<Self> {
        positive("intensity D", d, "a noise strength must be finite and above zero")?;
        let own = Self::new(rate, shape)?;
        let factor = (d / own.intensity()).sqrt();
        Self::new(rate, own.amplitude.each(|number| number * factor))
    }
}

impl<P: Parameter> PoissonImpulses<P> {
    /// Impulses whose numbers are parameters. Values without a meaning are refused where the system is used.
    ///
    /// ```
    /// use expoly::{Amplitude, Intensity, Oscillator, Parameter, PoissonImpulses, Problem, Scalar, parametric};
    ///
    /// struct Hail<P = f64> { damping: P, rate: P, size: P }
    ///
    /// impl<P: Parameter> Oscillator<P> for Hail<P> {
    ///     fn force<S: Scalar<P>>(&self, x: S, v: S) -> S { v * self.damping + x }
    ///     fn intensity(&self) -> Intensity<P> { Intensity::of(P::zero()) }
    ///     fn impulses(&self) -> Vec<PoissonImpulses<P>> { vec![PoissonImpulses::of(self.rate, Amplitude::Exponential { mean: self.size })] }
    /// }
    ///
    /// parametric!(Hail { damping: "c", rate: "lambda", size: "m" });
    ///
    /// let problem = Problem::parametric(Hail { damping: 0.2, rate: 3.0, size: 0.5 })?;
    /// // λ E[(v + Y)² − v²] = λ (2 v m + 2 m²), by m.
    /// let v = expoly::Polynomial::variable(2, 1);
    /// let by_size = problem.derivative("m")?.generator(&(&v * &v));
    /// assert_eq!(by_size.text(problem.states()).to_string(), "6 + 6 v");
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn of(rate: P, amplitude: Amplitude<P>) -> Self {
        PoissonImpulses { rate, amplitude }
    }

    /// Refuses values without a meaning.
    pub(crate) fn checked(self) -> Result<Self> {
        positive("rate of the impulses", self.rate.re(), "it must be finite and above zero")?;
        self.amplitude.each(|number| number.re()).checked()?;
        Ok(self)
    }

    /// The same, `factor` times as often.
    pub(crate) fn times(self, factor: f64) -> Self {
        PoissonImpulses { rate: self.rate * factor, ..self }
    }

    /// The same with a function of every number.
    pub(crate) fn each<Q>(self, mut of: impl FnMut(P) -> Q) -> PoissonImpulses<Q> {
        PoissonImpulses { rate: of(self.rate), amplitude: self.amplitude.each(of) }
    }

    /// The mean number λ of impulses per unit time.
    pub fn rate(&self) -> P {
        self.rate
    }

    /// The law of the amplitudes.
    pub fn amplitude(&self) -> Amplitude<P> {
        self.amplitude
    }

    /// λ E\[Y²\]/2, the intensity of the white noise that many small impulses of mean zero become.
    pub fn intensity(&self) -> P {
        self.rate * self.amplitude.moment(2) / 2.0
    }
}

impl Amplitude {
    fn checked(self) -> Result<Self> {
        let spread = |name, value: f64, mean: f64| {
            finite("mean amplitude of the impulses", mean)?;
            let sound = value.is_finite() && (value > 0.0 || value == 0.0 && mean != 0.0);
            require(sound, name, value, "it must be finite and above zero, or zero beside a mean that is not")
                .map(|_| ())
        };
        match self {
            Amplitude::Normal { mean, deviation } => spread("deviation of the amplitudes", deviation, mean)?,
            Amplitude::Laplace { mean, scale } => spread("scale of the amplitudes", scale, mean)?,
            Amplitude::Exponential { mean } => {
                let remedy = "it must be finite and not zero; its sign is that of the impulses";
                require(mean.is_finite() && mean != 0.0, "mean amplitude of the impulses", mean, remedy)?;
            }
            Amplitude::Uniform { low, high } => {
                finite("lower bound of the amplitudes", low)?;
                require(
                    high.is_finite() && high > low,
                    "upper bound of the amplitudes",
                    high,
                    "it must be above the lower one",
                )?;
            }
            Amplitude::TwoPoint { a, b } => {
                finite("first amplitude of the impulses", a)?;
                finite("second amplitude of the impulses", b)?;
                require(
                    a != 0.0 || b != 0.0,
                    "second amplitude of the impulses",
                    b,
                    "one of the two must not be zero",
                )?;
            }
        }
        let square = self.moment(2);
        let remedy = "its square must be a finite number above zero: take other units";
        require(square.is_finite() && square > 0.0, "mean square amplitude of the impulses", square, remedy)?;
        Ok(self)
    }

    /// Whether −Y has the same law.
    pub(crate) fn is_symmetric(&self) -> bool {
        match *self {
            Amplitude::Normal { mean, .. } | Amplitude::Laplace { mean, .. } => mean == 0.0,
            Amplitude::Exponential { .. } => false,
            Amplitude::Uniform { low, high } => low == -high,
            Amplitude::TwoPoint { a, b } => a == -b,
        }
    }
}

impl<P: Parameter> Amplitude<P> {
    /// The law with a function of every number of it.
    pub(crate) fn each<Q>(self, mut of: impl FnMut(P) -> Q) -> Amplitude<Q> {
        match self {
            Amplitude::Normal { mean, deviation } => Amplitude::Normal { mean: of(mean), deviation: of(deviation) },
            Amplitude::Exponential { mean } => Amplitude::Exponential { mean: of(mean) },
            Amplitude::Uniform { low, high } => Amplitude::Uniform { low: of(low), high: of(high) },
            Amplitude::TwoPoint { a, b } => Amplitude::TwoPoint { a: of(a), b: of(b) },
            Amplitude::Laplace { mean, scale } => Amplitude::Laplace { mean: of(mean), scale: of(scale) },
        }
    }

    /// E Y^k.
    ///
    /// ```
    /// use expoly::Amplitude;
    /// assert_eq!(Amplitude::Exponential { mean: -2.0 }.moment(3), -48.0); // 3! mean³
    /// assert_eq!(Amplitude::Normal { mean: 0.0, deviation: 2.0 }.moment(4), 48.0); // 3 deviation⁴
    /// ```
    pub fn moment(&self, k: u32) -> P {
        let power = |x: P, k: u32| x.powi(k.min(HIGHEST_MOMENT) as i32);
        let sum = |of: &dyn Fn(u32) -> P| (0..=k).fold(P::zero(), |sum, j| sum + of(j));
        // Σ C(k, j) mean^(k−j) E Z^j with a symmetric Z.
        let about = |mean: P, central: &dyn Fn(u32) -> P| {
            let binomial = |j: u32| (0..j).fold(1.0, |c, i| c * f64::from(k - i) / f64::from(i + 1));
            sum(&|j| if j.is_multiple_of(2) { power(mean, k - j) * central(j) * binomial(j) } else { P::zero() })
        };
        match *self {
            Amplitude::Normal { mean, deviation } => {
                let double_factorial = |j: u32| (1..j).step_by(2).map(f64::from).product::<f64>();
                about(mean, &|j| power(deviation, j) * double_factorial(j))
            }
            Amplitude::Exponential { mean } => (1..=k).fold(P::one(), |product, j| product * mean * f64::from(j)),
            // The mean of y^k over an interval, by products that do not cancel.
            Amplitude::Uniform { low, high } => sum(&|j| power(low, j) * power(high, k - j)) / f64::from(k + 1),
            Amplitude::TwoPoint { a, b } => (power(a, k) + power(b, k)) / 2.0,
            Amplitude::Laplace { mean, scale } => {
                about(mean, &|j| (1..=j).fold(P::one(), |product, i| product * scale * f64::from(i)))
            }
        }
    }

    /// A Gauss rule of `count` nodes, of `count` on each side for the Laplace law: Σ w g(y) = E g(Y), with Σ w = 1.
    ///
    /// The weights do not depend on the numbers of the law: y is a location and a multiple of a node of a standard law.
    pub(crate) fn rule(&self, count: usize) -> Vec<(P, f64)> {
        let on = |rule: Rule, y: &dyn Fn(f64) -> P, share: f64| -> Vec<(P, f64)> {
            rule.iter().map(|(z, w)| (y(z), share * w)).collect()
        };
        match *self {
            Amplitude::Normal { mean, deviation } => on(Rule::hermite(count), &|z| mean + deviation * z, 1.0),
            Amplitude::Exponential { mean } => on(Rule::laguerre(count), &|z| mean * z, 1.0),
            Amplitude::Uniform { low, high } => {
                on(Rule::legendre(count), &|z| (low + high) / 2.0 + (high - low) * (z / 2.0), 0.5)
            }
            Amplitude::TwoPoint { a, b } => vec![(a, 0.5), (b, 0.5)],
            Amplitude::Laplace { mean, scale } => {
                let side = |sign: f64| on(Rule::laguerre(count), &|z| mean + scale * (sign * z), 0.5);
                [side(-1.0), side(1.0)].concat()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    pub(crate) const LAWS: [Amplitude; 6] = [
        Amplitude::Normal { mean: 0.3, deviation: 0.5 },
        Amplitude::Exponential { mean: -0.7 },
        Amplitude::Uniform { low: -0.2, high: 1.1 },
        Amplitude::TwoPoint { a: -0.4, b: 0.9 },
        Amplitude::Laplace { mean: -0.1, scale: 0.6 },
        Amplitude::Normal { mean: 0.5, deviation: 0.0 },
    ];

    /// Two routes: moments in closed form, and by Gauss rules that are exact for them. Σ|w y^k| bounds what may cancel.
    #[test]
    fn rules_have_the_moments() {
        for law in LAWS {
            let rule = law.rule(12);
            for k in 0..=20 {
                let found: f64 = rule.iter().map(|(y, w)| w * y.powi(k)).sum();
                let size: f64 = rule.iter().map(|(y, w)| w * y.abs().powi(k)).sum();
                let exact = law.moment(k as u32);
                assert!((found - exact).abs() < 1e-13 * size, "{law:?} {k}: {found} {exact}");
            }
        }
    }

    #[test]
    fn laws_without_a_meaning_are_refused() {
        let refused = [
            Amplitude::Normal { mean: 0.0, deviation: 0.0 },
            Amplitude::Normal { mean: 0.0, deviation: -1.0 },
            Amplitude::Normal { mean: f64::NAN, deviation: 1.0 },
            Amplitude::Exponential { mean: 0.0 },
            Amplitude::Uniform { low: 1.0, high: 1.0 },
            Amplitude::TwoPoint { a: 0.0, b: 0.0 },
            Amplitude::Laplace { mean: 0.0, scale: f64::INFINITY },
            Amplitude::Normal { mean: 0.0, deviation: 1e200 },
        ];
        assert!(refused.iter().all(|law| PoissonImpulses::new(1.0, *law).is_err()));
        assert!(
            LAWS.iter().all(|law| PoissonImpulses::new(1.0, *law).is_ok() && PoissonImpulses::new(0.0, *law).is_err())
        );
        assert!(LAWS.iter().all(|law| PoissonImpulses::with_intensity(1.0, *law, -0.2).is_err()));
    }
}
