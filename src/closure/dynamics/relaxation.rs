//! The modes of the moment equations, and what they say about the stationary response.

use super::moment_system::MomentSystem;
use crate::checks::{finite, require, state_index};
use crate::closure::density::ClosureDensity;
use crate::density::Density;
use crate::error::Result;
use crate::estimate::Estimate;
use crate::numerics::{Resolvent, propagated, weighted_sum};
use crate::transient::Relaxation;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::PI;

/// Modes of two degrees are the same if they differ by at most this factor times the error of the one of the higher degree.
const SAME_MODE: f64 = 3.0;

impl ClosureDensity {
    /// The `count` slowest modes of relaxation by rising rate, the stationary density itself first, whose rate is 0. They are
    /// the eigenvalues of the moment equations of degree 24 in one state and in two, whatever the order, of 12, 8, 6 and 4 in three,
    /// four, five and six, and chosen among the 2`count` that are nearest to zero.
    ///
    /// A transient lasts as long as the second one: it has fallen to a thousandth after 7/rate. A bistable system's second
    /// rate is the rate at which its wells mix.
    ///
    /// # Errors
    /// [`Error::NotServed`](crate::Error::NotServed) next to walls in three states and more, [`Error::NotKnown`](crate::Error::NotKnown) for a density from a document,
    /// [`Error::NotClosed`](crate::Error::NotClosed) where the equations have a growing mode at every degree.
    ///
    /// ```
    /// use expoly::{Closure, models::{Linear, Solved}};
    /// let modes = Closure::new(2).solve(&Linear::new(0.5, 1.0, 0.5)?.problem()?)?.relaxation(3)?;
    /// // The eigenvalues of a linear oscillator: c/2 ± √(c²/4 − k).
    /// assert!(modes[0].rate == 0.0);
    /// assert!((modes[1].rate - 0.25).abs() < 1e-9 && (modes[1].frequency - 0.9375_f64.sqrt()).abs() < 1e-9);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn relaxation(&self, count: usize) -> Result<Vec<Relaxation>> {
        let modes = self.motion()?.1.modes();
        let (highest, below) = (&modes[0], &modes[1]);
        let slowest = Relaxation::slowest(highest.clone(), below, count);
        Ok(slowest.into_iter().map(|mode| settled(mode, &modes)).collect())
    }

    /// The autocovariances R(τ) = E[(x(t) − m)(x(t + τ) − m)] of one state of the stationary response at some lags τ ≥ 0. Their
    /// errors are the distances from those of a lower degree.
    ///
    /// # Errors
    /// As [`ClosureDensity::relaxation`]; [`Error::Dimension`](crate::Error::Dimension) if there is no such state, [`Error::OutOfRange`](crate::Error::OutOfRange) for a lag that is
    /// negative or not finite.
    ///
    /// ```
    /// use expoly::{Closure, models::{Linear, Solved}};
    /// // Critical damping: x″ + 2x′ + x = ξ with D = 2 has R(τ) = (1 + τ) exp(−τ).
    /// let density = Closure::new(2).solve(&Linear::new(2.0, 1.0, 2.0)?.problem()?)?;
    /// let found = density.autocovariance(0, &[0.0, 1.5])?;
    /// assert!((found[0].value - 1.0).abs() < 1e-5 && (found[1].value - 2.5 * (-1.5_f64).exp()).abs() < 1e-5);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn autocovariance(&self, state: usize, lags: &[f64]) -> Result<Vec<Estimate>> {
        let (_, system) = self.motion()?;
        state_index("the state of an autocovariance", state, self.dimension())?;
        for &lag in lags {
            require(finite("lag", lag)? >= 0.0, "lag", lag, "R(−τ) = R(τ): give it as a positive number")?;
        }
        let [own, lower] = [false, true].map(|lower| {
            let [state, excited] = fluctuation(system, state, lower);
            let matrix = system.matrix(lower);
            let columns = propagated(matrix, &excited, lags);
            (0..lags.len()).map(|j| (0..state.len()).map(|k| state[k] * columns[(k, j)]).sum()).collect()
        });
        Ok(compared(own, lower))
    }

    /// The two-sided spectral densities S(ω) of one state of the stationary response at some circular frequencies ω, with
    /// Var x = ∫ S dω over all ω as for [`Spectrum`](crate::Spectrum). Their errors are the distances from those of a lower
    /// degree.
    ///
    /// # Errors
    /// As [`ClosureDensity::relaxation`]; [`Error::Dimension`](crate::Error::Dimension) if there is no such state, [`Error::OutOfRange`](crate::Error::OutOfRange) for a frequency that
    /// is not finite.
    ///
    /// ```
    /// use expoly::{Closure, models::{Linear, Solved}};
    /// let density = Closure::new(2).solve(&Linear::new(0.5, 1.0, 0.5)?.problem()?)?;
    /// // S = (D/π) / ((k − ω²)² + c²ω²).
    /// let at_resonance = density.spectral_density(0, &[1.0])?[0];
    /// assert!((at_resonance.value - 2.0 / std::f64::consts::PI).abs() < 1e-5);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn spectral_density(&self, state: usize, frequencies: &[f64]) -> Result<Vec<Estimate>> {
        let (_, system) = self.motion()?;
        state_index("the state of a spectral density", state, self.dimension())?;
        frequencies.iter().try_for_each(|&omega| finite("frequency", omega).map(|_| ()))?;
        let [own, lower] = [false, true].map(|lower| {
            // The constant has no part in a fluctuation.
            let [state, excited] = fluctuation(system, state, lower).map(|all| DVector::from_column_slice(&all[1..]));
            let inner = system.matrix(lower).get(1.., 1..);
            let matrix = DMatrix::from_fn(inner.nrows(), inner.ncols(), |k, l| inner[(k, l)]);
            let resolvent = Resolvent::new(matrix, &state, &excited);
            frequencies.iter().map(|omega| resolvent.at(*omega) / PI).collect()
        });
        Ok(compared(own, lower))
    }
}

/// A mode of the highest degree as it stands at the degree where it differs least from the one below: where low degrees hold
/// it already, higher ones add rounding. `modes` are those of all degrees, the highest first.
fn settled(mode: Relaxation, modes: &[Vec<[f64; 2]>]) -> Relaxation {
    let near = SAME_MODE * mode.error;
    let mut best = mode;
    for pair in modes[1..].windows(2) {
        let of_degree = Relaxation::slowest(pair[0].clone(), &pair[1], pair[0].len());
        let same = |other: &&Relaxation| (other.rate - mode.rate).hypot(other.frequency - mode.frequency) <= near;
        let found = of_degree.iter().filter(same).min_by(|a, b| a.error.total_cmp(&b.error));
        best = found.copied().filter(|found| found.error < best.error).unwrap_or(best);
    }
    best
}

/// The coefficients of a state's deviation from its mean in ψ, and those of the same times the stationary density: the second
/// are what the system relaxes from, R(τ) = c·exp(Aτ) b.
fn fluctuation(system: &MomentSystem, state: usize, lower: bool) -> [Vec<f64>; 2] {
    let [own, below] = system.ratios([&system.stationary(false), &system.stationary(true)]);
    let ratio = if lower { below } else { own };
    let values = system.functions.values.get(..system.nodes.len(), ..system.columns(lower));
    let x = || system.nodes.points.iter().map(|x| x[state]);
    let mean: f64 = x().zip(&ratio).zip(&system.measure).map(|((x, r), w)| w * r * x).sum();
    let tested = |ratio: &dyn Fn(usize) -> f64| {
        let weighted: Vec<f64> = x().enumerate().map(|(i, x)| system.measure[i] * ratio(i) * (x - mean)).collect();
        let mut tested = weighted_sum(values, &weighted);
        tested[0] = 0.0;
        tested
    };
    [tested(&|_| 1.0), tested(&|i| ratio[i])]
}

fn compared(own: Vec<f64>, lower: Vec<f64>) -> Vec<Estimate> {
    own.into_iter().zip(lower).map(|(own, lower)| Estimate::new(own, own - lower)).collect()
}
