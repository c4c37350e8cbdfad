use crate::checks::{finite, positive, require};
use crate::error::Result;
use crate::numerics::Rule;
use serde::{Deserialize, Serialize};

/// Poisson impulses: a process J that jumps by independent amplitudes Y at times whose distances are exponential, λ of them per
/// unit time on average.
///
/// A state under the impulses H dJ jumps from x to x + H(x) Y, H taken just before the impulse. Many small impulses of mean zero
/// are a white noise of the intensity D = λ E\[Y²\]/2 ([`Jumps::intensity`]).
///
/// ```
/// use expoly::{Amplitude, Jumps};
/// let hail = Jumps::new(2.0, Amplitude::Normal { mean: 0.0, deviation: 0.5 })?;
/// assert_eq!(hail.intensity(), 0.25);
/// // As strong as a white noise of D = 0.2, by five impulses per unit time.
/// let same = Jumps::with_intensity(5.0, Amplitude::Laplace { mean: 0.0, scale: 1.0 }, 0.2)?;
/// assert!((same.intensity() - 0.2).abs() < 1e-15);
/// # Ok::<(), expoly::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Jumps {
    rate: f64,
    amplitude: Amplitude,
}

/// The law of an impulse's amplitude Y.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Amplitude {
    /// The normal law.
    Normal {
        /// E Y.
        mean: f64,
        /// The standard deviation.
        deviation: f64,
    },
    /// The exponential law of one sign, that of its mean.
    Exponential {
        /// E Y, which is not zero.
        mean: f64,
    },
    /// Equal probability between two bounds.
    Uniform {
        /// The lower bound.
        low: f64,
        /// The upper bound.
        high: f64,
    },
    /// One of two numbers, either with the probability one half.
    TwoPoint {
        /// The one.
        a: f64,
        /// The other.
        b: f64,
    },
    /// The density exp(−|y − mean|/scale)/(2 scale).
    Laplace {
        /// E Y.
        mean: f64,
        /// The mean of |Y − mean|.
        scale: f64,
    },
}

/// The highest moment of an amplitude that is computed.
const HIGHEST_MOMENT: u32 = 120;

impl Jumps {
    /// Impulses at the mean rate λ per unit time.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless λ and the spread of the amplitude are finite and above zero (a
    /// normal or Laplace law may have no spread, but then a mean), and bounds rise.
    pub fn new(rate: f64, amplitude: Amplitude) -> Result<Self> {
        positive("rate of the impulses", rate, "it must be finite and above zero")?;
        Ok(Jumps { rate, amplitude: amplitude.checked()? })
    }

    /// The same with amplitudes in the proportions of `shape`, scaled so that λ E\[Y²\] = 2D for the intensity `d`.
    ///
    /// # Errors
    /// As [`Jumps::new`]; also for an intensity that is not finite and positive.
    pub fn with_intensity(rate: f64, shape: Amplitude, d: f64) -> Result<Self> {
        positive("intensity D", d, "a noise strength must be finite and above zero")?;
        let own = Self::new(rate, shape)?;
        Self::new(rate, own.amplitude.scaled((d / own.intensity()).sqrt()))
    }

    /// The same, `factor` times as often.
    pub(crate) fn times(self, factor: f64) -> Self {
        Jumps { rate: self.rate * factor, ..self }
    }

    /// The mean number λ of impulses per unit time.
    pub fn rate(&self) -> f64 {
        self.rate
    }

    /// The law of the amplitudes.
    pub fn amplitude(&self) -> Amplitude {
        self.amplitude
    }

    /// λ E\[Y²\]/2, the intensity of the white noise that many small impulses of mean zero become.
    pub fn intensity(&self) -> f64 {
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

    /// The law of `factor` times Y.
    pub(crate) fn scaled(self, factor: f64) -> Self {
        match self {
            Amplitude::Normal { mean, deviation } => {
                Amplitude::Normal { mean: mean * factor, deviation: deviation * factor }
            }
            Amplitude::Exponential { mean } => Amplitude::Exponential { mean: mean * factor },
            Amplitude::Uniform { low, high } => Amplitude::Uniform { low: low * factor, high: high * factor },
            Amplitude::TwoPoint { a, b } => Amplitude::TwoPoint { a: a * factor, b: b * factor },
            Amplitude::Laplace { mean, scale } => Amplitude::Laplace { mean: mean * factor, scale: scale * factor },
        }
    }

    /// E Y^k.
    ///
    /// ```
    /// use expoly::Amplitude;
    /// assert_eq!(Amplitude::Exponential { mean: -2.0 }.moment(3), -48.0); // 3! mean³
    /// assert_eq!(Amplitude::Normal { mean: 0.0, deviation: 2.0 }.moment(4), 48.0); // 3 deviation⁴
    /// ```
    pub fn moment(&self, k: u32) -> f64 {
        let power = |x: f64, k: u32| x.powi(k.min(HIGHEST_MOMENT) as i32);
        // Σ C(k, j) mean^(k−j) E Z^j with a symmetric Z.
        let about = |mean: f64, central: &dyn Fn(u32) -> f64| {
            let mut binomial = 1.0;
            (0..=k)
                .map(|j| {
                    let term = binomial * power(mean, k - j) * central(j);
                    binomial *= f64::from(k - j) / f64::from(j + 1);
                    term
                })
                .sum()
        };
        let even = |j: u32, moment: f64| if j.is_multiple_of(2) { moment } else { 0.0 };
        match *self {
            Amplitude::Normal { mean, deviation } => {
                let double_factorial = |j: u32| (1..j).step_by(2).map(f64::from).product::<f64>();
                about(mean, &|j| even(j, power(deviation, j) * double_factorial(j)))
            }
            Amplitude::Exponential { mean } => (1..=k).map(|j| f64::from(j) * mean).product(),
            // The mean of y^k over an interval, by products that do not cancel.
            Amplitude::Uniform { low, high } => {
                (0..=k).map(|j| power(low, j) * power(high, k - j)).sum::<f64>() / f64::from(k + 1)
            }
            Amplitude::TwoPoint { a, b } => (power(a, k) + power(b, k)) / 2.0,
            Amplitude::Laplace { mean, scale } => {
                about(mean, &|j| even(j, (1..=j).map(|i| f64::from(i) * scale).product()))
            }
        }
    }

    /// A Gauss rule of `count` nodes, of `count` on each side for the Laplace law: Σ w g(y) = E g(Y), with Σ w = 1.
    pub(crate) fn rule(&self, count: usize) -> Rule {
        match *self {
            Amplitude::Normal { mean, deviation } => {
                let rule = Rule::hermite(count);
                Rule { nodes: rule.nodes.iter().map(|z| mean + deviation * z).collect(), weights: rule.weights }
            }
            Amplitude::Exponential { mean } => {
                let rule = Rule::laguerre(count);
                Rule { nodes: rule.nodes.iter().map(|z| mean * z).collect(), weights: rule.weights }
            }
            Amplitude::Uniform { low, high } => {
                let rule = Rule::legendre(count).on(low, high);
                Rule { weights: rule.weights.iter().map(|w| w / (high - low)).collect(), ..rule }
            }
            Amplitude::TwoPoint { a, b } => Rule { nodes: vec![a, b], weights: vec![0.5, 0.5] },
            Amplitude::Laplace { mean, scale } => {
                let rule = Rule::laguerre(count);
                let side = |sign: f64| rule.nodes.iter().map(move |z| mean + sign * scale * z);
                let weights = rule.weights.iter().map(|w| w / 2.0);
                Rule { nodes: side(-1.0).chain(side(1.0)).collect(), weights: weights.clone().chain(weights).collect() }
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
        assert!(refused.iter().all(|law| Jumps::new(1.0, *law).is_err()));
        assert!(LAWS.iter().all(|law| Jumps::new(1.0, *law).is_ok() && Jumps::new(0.0, *law).is_err()));
        assert!(LAWS.iter().all(|law| Jumps::with_intensity(1.0, *law, -0.2).is_err()));
    }
}
