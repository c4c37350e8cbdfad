use crate::checks::state_index;
use crate::density::{Density, Sampled, central};
use crate::error::Result;
use crate::estimate::Estimate;
use crate::polynomial::of_one;

/// The first four cumulants of one state: mean, variance, κ₃ = E(x − m)³ and κ₄ = E(x − m)⁴ − 3 Var².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cumulants {
    /// The mean m.
    pub mean: Estimate,
    /// The variance κ₂.
    pub variance: Estimate,
    /// κ₃, which vanishes for a symmetric density.
    pub third: Estimate,
    /// κ₄, which vanishes for a normal density.
    pub fourth: Estimate,
    skewness: Estimate,
    kurtosis: Estimate,
}

impl Cumulants {
    /// The cumulants of `state`.
    ///
    /// They are means of powers of x − m. Of a simulation they are those of its raw moments, each with one standard error,
    /// and lose digits where the mean is large compared with the standard deviation.
    ///
    /// # Errors
    /// [`Error::Dimension`](crate::Error::Dimension) if there is no such state; as [`Density::expectation`].
    ///
    /// ```
    /// use expoly::{models::{Duffing, Solved}, statistics::Cumulants};
    /// let density = Duffing::new(0.2, 1.0, 0.3, 0.2)?.exact()?;
    /// let displacement = Cumulants::new(&density, 0)?;
    /// assert!((displacement.variance.value - 0.661714969204).abs() < 1e-11);
    /// assert!((displacement.kurtosis().value - 1.12761676932 / 0.661714969204_f64.powi(2)).abs() < 1e-10);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn new(density: &dyn Density, state: usize) -> Result<Self> {
        let states = density.dimension();
        let state = state_index("the state of cumulants", state, states)?;
        if let Some(sampled) = density.evidence().sampled() {
            return Cumulants::sampled(sampled, state);
        }
        let mean = density.moment(&of_one(states, state, 1))?;
        let variance = density.variance(state)?;
        let central = |power: i32| density.expectation(&|x| (x[state] - mean.value).powi(power));
        let (third, fourth) = (central(3)?, central(4)?);
        let value = fourth.value - 3.0 * variance.value.powi(2);
        let fourth = Estimate::new(value, fourth.error + 6.0 * variance.value.abs() * variance.error);
        let excess = standardised(fourth, variance, 4.0);
        Ok(Cumulants {
            mean,
            variance,
            third,
            fourth,
            skewness: standardised(third, variance, 3.0),
            kurtosis: Estimate::new(3.0 + excess.value, excess.error),
        })
    }

    fn sampled(density: &dyn Sampled, state: usize) -> Result<Self> {
        let of = |statistic: fn([f64; 3]) -> f64| density.of_moments(state, &|raw| statistic(central(raw)));
        Ok(Cumulants {
            mean: density.of_moments(state, &|raw| raw[1])?,
            variance: of(|[variance, _, _]| variance)?,
            third: of(|[_, third, _]| third)?,
            fourth: of(|[variance, _, fourth]| fourth - 3.0 * variance.powi(2))?,
            skewness: of(|[variance, third, _]| third / variance.powf(1.5))?,
            kurtosis: of(|[variance, _, fourth]| fourth / variance.powi(2))?,
        })
    }

    /// The skewness κ₃/κ₂^(3/2).
    pub fn skewness(&self) -> Estimate {
        self.skewness
    }

    /// The kurtosis 3 + κ₄/κ₂², which is 3 for a normal density.
    pub fn kurtosis(&self) -> Estimate {
        self.kurtosis
    }
}

/// κ/κ₂^(order/2), with both errors.
fn standardised(cumulant: Estimate, variance: Estimate, order: f64) -> Estimate {
    let scale = variance.value.powf(order / 2.0);
    let value = cumulant.value / scale;
    let relative = order / 2.0 * variance.error / variance.value;
    Estimate::new(value, cumulant.error / scale + value.abs() * relative)
}
