use crate::error::state_index;
use crate::simulation::{SimulatedDensity, central};
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
    skewness: Estimate,
    kurtosis: Estimate,
}

impl Cumulants {
    /// The cumulants of `state`.
    ///
    /// They are means of powers of x − m. Of a simulation they are those of its raw moments, with the standard errors of
    /// [`SimulatedDensity::kurtosis`], and lose digits where the mean is large compared with the standard deviation.
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
        if let Some(simulation) = density.simulation() {
            return Cumulants::sampled(simulation, state);
        }
        let mean = density.moment(std::array::from_fn(|i| u32::from(i == state)));
        let variance = density.variance(state)?;
        let central = |power: i32| density.expectation(&|x| (x[state] - mean.value).powi(power));
        let [third, fourth] = [3, 4].map(central);
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

    fn sampled<const N: usize>(simulation: &SimulatedDensity<N>, state: usize) -> Result<Self> {
        Ok(Cumulants {
            mean: simulation.mean(state)?,
            variance: simulation.variance(state)?,
            third: simulation.of_state(state, |raw| central(raw)[1])?,
            fourth: simulation.of_state(state, |raw| {
                let [variance, _, fourth] = central(raw);
                fourth - 3.0 * variance.powi(2)
            })?,
            skewness: simulation.skewness(state)?,
            kurtosis: simulation.kurtosis(state)?,
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
