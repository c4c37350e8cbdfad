use crate::error::state_index;
use crate::{Density, Estimate, Result};

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
}

impl Cumulants {
    /// The cumulants of `state`.
    ///
    /// They are means of powers of x − m. A simulation of more than two states knows raw moments only: there cumulants are
    /// differences of these, and lose digits where the mean is large compared with the standard deviation.
    ///
    /// # Errors
    /// [`Error::Dimension`](crate::Error::Dimension) if there is no such state.
    ///
    /// ```
    /// use expoly::{models::{Duffing, Solved}, statistics::Cumulants};
    /// let density = Duffing::new(0.2, 1.0, 0.3, 0.2)?.exact()?;
    /// let displacement = Cumulants::new(&density, 0)?;
    /// assert!((displacement.variance.value - 0.661714969204).abs() < 1e-11);
    /// assert!((displacement.kurtosis().value - 1.12761676932 / 0.661714969204_f64.powi(2)).abs() < 1e-10);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn new<const N: usize>(density: &dyn Density<N>, state: usize) -> Result<Self> {
        let state = state_index::<N>("the state of cumulants", state)?;
        let raw = |power: u32| density.moment(std::array::from_fn(|i| if i == state { power } else { 0 }));
        let mean = raw(1);
        let variance = density.variance(state)?;
        let central = |power: i32| density.expectation(&|x| (x[state] - mean.value).powi(power));
        let [mut third, mut fourth] = [3, 4].map(central);
        if third.value.is_nan() {
            let (m, [m2, m3, m4]) = (mean.value, [2, 3, 4].map(raw));
            let value = m3.value - 3.0 * m * m2.value + 2.0 * m.powi(3);
            let slope = (6.0 * m * m - 3.0 * m2.value).abs();
            third = Estimate::new(value, m3.error + 3.0 * m.abs() * m2.error + slope * mean.error);
            let value = m4.value - 4.0 * m * m3.value + 6.0 * m * m * m2.value - 3.0 * m.powi(4);
            let slope = (12.0 * m * m2.value - 4.0 * m3.value - 12.0 * m.powi(3)).abs();
            let error = m4.error + 4.0 * m.abs() * m3.error + 6.0 * m * m * m2.error + slope * mean.error;
            fourth = Estimate::new(value, error);
        }
        let value = fourth.value - 3.0 * variance.value.powi(2);
        let fourth = Estimate::new(value, fourth.error + 6.0 * variance.value.abs() * variance.error);
        Ok(Cumulants { mean, variance, third, fourth })
    }

    /// The skewness κ₃/κ₂^(3/2).
    pub fn skewness(&self) -> Estimate {
        self.standardised(self.third, 3.0)
    }

    /// The kurtosis 3 + κ₄/κ₂², which is 3 for a normal density.
    pub fn kurtosis(&self) -> Estimate {
        let excess = self.standardised(self.fourth, 4.0);
        Estimate::new(3.0 + excess.value, excess.error)
    }

    /// κ/κ₂^(order/2), with both errors.
    fn standardised(&self, cumulant: Estimate, order: f64) -> Estimate {
        let scale = self.variance.value.powf(order / 2.0);
        let value = cumulant.value / scale;
        let relative = order / 2.0 * self.variance.error / self.variance.value;
        Estimate::new(value, cumulant.error / scale + value.abs() * relative)
    }
}
