//! Spectral density and autocovariance, from segments of the path.

use super::{Sample, Statistic};
use crate::checks::{positive, require, state_index};
use crate::error::{Error, Result};
use crate::estimate::Estimate;
use crate::simulation::jackknife::jackknife;
use crate::simulation::{SimulatedDensity, Simulation, plan::Plan};
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex, num_complex::Complex};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use std::fmt;
use std::sync::Arc;

/// The most samples in a segment of a spectrum.
const LONGEST_SEGMENT: usize = 1 << 20;

impl Simulation<'_> {
    /// Keeps the spectral density and the autocovariance of one state, from segments of `length` samples each (8 to 2²⁰).
    /// [`SimulatedDensity::spectrum`](crate::SimulatedDensity::spectrum) gives them.
    ///
    /// The path is sampled once in each sampling interval Δ: frequencies beyond π/Δ are folded back, and a segment lasts
    /// `length` × Δ, which should be many relaxation times. The present segment of every trajectory is kept in memory.
    ///
    /// ```
    /// use expoly::{Simulation, models::{Linear, Solved}};
    /// let problem = Linear::new(0.5, 2.0, 0.3)?.problem()?;
    /// let simulation = Simulation::new().sampling_interval(0.1).spectrum(0, 256);
    /// let result = simulation.trajectories(64).samples(64 * 2048).run(&problem)?;
    /// let spectrum = result.spectrum(0)?;
    /// // x″ + c x′ + k x = ξ has R(τ) = D/ck exp(−cτ/2) (cos ω_d τ + c/2ω_d sin ω_d τ), ω_d² = k − c²/4: here at 0 and at 1.
    /// assert!(spectrum.autocovariance(0)?.deviation(0.3) < 4.0);
    /// assert!(spectrum.autocovariance(10)?.deviation(0.08286) < 4.0);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn spectrum(mut self, state: usize, length: usize) -> Self {
        self.requests.spectra.push((state, length));
        self
    }
}

impl SimulatedDensity {
    /// The spectral density and the autocovariance of one state.
    ///
    /// # Errors
    /// [`Error::NotKnown`] if it was not requested by [`Simulation::spectrum`](crate::Simulation::spectrum),
    /// [`Error::OutOfRange`] if the run was shorter than a segment, [`Error::Dimension`] if there is no such state.
    pub fn spectrum(&self, state: usize) -> Result<Spectrum> {
        let state = state_index("a state's index", state, self.layout.axes.len())?;
        let spectra = &self.layout.recorders.spectra;
        let place = spectra.iter().position(|segments| segments.state == state).ok_or_else(|| Error::NotKnown {
            what: format!("the spectrum of state {state}"),
            remedy: "request it by `Simulation::spectrum` before the run",
        })?;
        let tallies = self.batches.iter().map(|b| b.recordings.spectra[place].clone()).collect();
        Spectrum::new(spectra[place].clone(), tallies)
    }
}

/// The segments that the path of one state is cut into for its spectral density and autocovariance (P. D. Welch, 1967,
/// doi:10.1109/TAU.1967.1161901).
#[derive(Clone)]
pub(in crate::simulation) struct Segments {
    state: usize,
    length: usize,
    interval: f64,
    window: Vec<f64>,
    /// |Σ_t w_t exp(−iω_j t)|², the contribution of a mean of 1 to the periodogram.
    of_mean: Vec<f64>,
    /// Σ w².
    energy: f64,
    forward: Arc<dyn RealToComplex<f64>>,
    padded: Arc<dyn RealToComplex<f64>>,
    inverse: Arc<dyn ComplexToReal<f64>>,
}

/// The sums of one batch of trajectories.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub(in crate::simulation) struct SpectralTally {
    segments: f64,
    /// Σ x over the samples of all segments.
    sum: f64,
    /// Σ |Σ_t w_t x_t exp(−iω_j t)|².
    power: Vec<f64>,
    /// Σ Σ_t x_t x_(t+k) for each lag k.
    products: Vec<f64>,
}

impl Segments {
    /// Segments of `length` samples of a state that are `interval` apart.
    fn new(state: usize, length: usize, interval: f64) -> Self {
        let hann = |t: usize| 0.5 - 0.5 * (TAU * t as f64 / length as f64).cos();
        let window: Vec<f64> = (0..length).map(hann).collect();
        let mut planner = RealFftPlanner::new();
        let mut segments = Segments {
            state,
            length,
            interval,
            of_mean: Vec::new(),
            energy: window.iter().map(|w| w * w).sum(),
            forward: planner.plan_fft_forward(length),
            padded: planner.plan_fft_forward(2 * length),
            inverse: planner.plan_fft_inverse(2 * length),
            window,
        };
        segments.of_mean = segments.periodogram(&segments.window);
        segments
    }

    /// |Σ_t y_t exp(−iω_j t)|². The transform fails only for buffers of a wrong length, which these are not.
    fn periodogram(&self, y: &[f64]) -> Vec<f64> {
        let (mut input, mut output) = (y.to_vec(), self.forward.make_output_vec());
        if self.forward.process(&mut input, &mut output).is_err() {
            return vec![f64::NAN; output.len()];
        }
        output.iter().map(Complex::norm_sqr).collect()
    }

    /// Σ_t x_t x_(t+k), by a transform padded with zeros, so that nothing wraps around.
    fn products(&self, x: &[f64]) -> Vec<f64> {
        let mut input = self.padded.make_input_vec();
        input[..x.len()].copy_from_slice(x);
        let mut spectrum = self.padded.make_output_vec();
        let mut output = self.inverse.make_output_vec();
        let mut done = self.padded.process(&mut input, &mut spectrum).is_ok();
        for c in &mut spectrum {
            (c.re, c.im) = (c.norm_sqr(), 0.0);
        }
        done &= self.inverse.process(&mut spectrum, &mut output).is_ok();
        // Neither transform is normalised.
        let scale = if done { (output.len() as f64).recip() } else { f64::NAN };
        output[..=self.length / 2].iter().map(|p| p * scale).collect()
    }
}

impl Statistic for Segments {
    /// The state, and the number of samples in a segment.
    type Request = (usize, usize);
    type Sums = SpectralTally;
    /// The present segment so far.
    type Path = Vec<f64>;

    /// Refuses intervals that are not finite and positive, lengths that do not lie between 8 and 2²⁰, and a state twice.
    fn check(requests: &[(usize, usize)], states: usize, interval: f64) -> Result<()> {
        for (k, &(state, length)) in requests.iter().enumerate() {
            state_index("the state of a spectrum", state, states)?;
            positive("sampling interval", interval, "it must be finite and above zero")?;
            let remedy = "a segment holds from 8 to 2^20 samples";
            require((8..=LONGEST_SEGMENT).contains(&length), "length of a segment", length as f64, remedy)?;
            let remedy = "its spectrum is requested twice; one segment length can be given for each state";
            require(requests[..k].iter().all(|&(other, _)| other != state), "state", state as f64, remedy)?;
        }
        Ok(())
    }

    fn kept(&(_, length): &(usize, usize)) -> usize {
        length
    }

    fn of(&(state, length): &(usize, usize), plan: &Plan) -> Result<Self> {
        Ok(Segments::new(state, length, plan.interval()))
    }

    fn sums(&self) -> SpectralTally {
        let zeros = vec![0.0; self.length / 2 + 1];
        SpectralTally { segments: 0.0, sum: 0.0, power: zeros.clone(), products: zeros }
    }

    fn observe(&self, sums: &mut SpectralTally, path: &mut Vec<f64>, sample: &Sample<'_>) {
        sums.push(self, path, sample.x[self.state]);
    }
}

impl fmt::Debug for Segments {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Segments")
            .field("length", &self.length)
            .field("interval", &self.interval)
            .finish_non_exhaustive()
    }
}

impl SpectralTally {
    /// Takes one sample of a trajectory. `path` holds what its present segment has so far; it is empty at the start, and
    /// each trajectory has its own. Segments overlap by a half.
    fn push(&mut self, segments: &Segments, path: &mut Vec<f64>, x: f64) {
        path.push(x);
        if path.len() < segments.length {
            return;
        }
        let windowed: Vec<f64> = path.iter().zip(&segments.window).map(|(x, w)| x * w).collect();
        self.segments += 1.0;
        self.sum += path.iter().sum::<f64>();
        for (sum, power) in self.power.iter_mut().zip(segments.periodogram(&windowed)) {
            *sum += power;
        }
        for (sum, product) in self.products.iter_mut().zip(segments.products(path)) {
            *sum += product;
        }
        path.drain(..segments.length / 2);
    }
}

/// Spectral density and autocovariance with standard errors from batches of independent trajectories.
///
/// The spectral density S(ω) is two-sided, ω in radians per unit time: Var x = ∫ S dω over all ω, negative ones included, and
/// R(τ) = ∫ S(ω) exp(iωτ) dω. The one-sided density over ω > 0 is 2S, that over the frequency f = ω/2π is 4πS. For
/// x″ + c x′ + k x = ξ it is S = (D/π) / ((k − ω²)² + c²ω²).
///
/// It is a mean over segments that overlap by a half, each under a Hann window (P. D. Welch, 1967,
/// doi:10.1109/TAU.1967.1161901). Segments of the length T smooth it and add ⅔ (π/T)² S″; power above the highest frequency
/// is folded back below it. Errors cover chance, but neither of these.
#[derive(Clone, Debug)]
pub struct Spectrum {
    segments: Segments,
    batches: Vec<SpectralTally>,
}

impl Spectrum {
    /// From the tallies of batches that are independent of each other.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) if fewer than two batches have a whole segment.
    fn new(segments: Segments, mut batches: Vec<SpectralTally>) -> Result<Self> {
        batches.retain(|batch| batch.segments > 0.0);
        let remedy = "too few trajectories have so many samples; take more samples or a shorter segment";
        require(batches.len() >= 2, "length of a segment", segments.length as f64, remedy)?;
        Ok(Spectrum { segments, batches })
    }

    /// The frequencies ω_j = 2πj/(length × interval), from 0 to π/interval.
    pub fn frequencies(&self) -> impl Iterator<Item = f64> + '_ {
        let segments = &self.segments;
        (0..segments.of_mean.len()).map(move |j| TAU * j as f64 / (segments.length as f64 * segments.interval))
    }

    /// The two-sided spectral density S at ω_j, smoothed by the window. The contribution of the mean is taken off, which
    /// costs precision at ω = 0 and next to it.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) if there is no such frequency.
    pub fn density(&self, j: usize) -> Result<Estimate> {
        let segments = &self.segments;
        known("index of a frequency", j, segments.of_mean.len())?;
        let (length, of_mean) = (segments.length as f64, segments.of_mean[j]);
        let scale = segments.interval / (TAU * segments.energy);
        Ok(jackknife(
            &self.batches,
            |b| [b.segments, b.sum, b.power[j]],
            move |[n, sum, power]| scale * (power / n - (sum / (n * length)).powi(2) * of_mean),
        ))
    }

    /// The autocovariance R(τ) = E[(x(t) − m)(x(t + τ) − m)] at the lag τ = k × interval, k up to half the length of a
    /// segment.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) for a longer lag.
    pub fn autocovariance(&self, k: usize) -> Result<Estimate> {
        let length = self.segments.length as f64;
        known("lag", k, self.segments.length / 2 + 1)?;
        Ok(jackknife(
            &self.batches,
            |b| [b.segments, b.sum, b.products[k]],
            move |[n, sum, products]| products / (n * (length - k as f64)) - (sum / (n * length)).powi(2),
        ))
    }
}

fn known(name: &'static str, index: usize, count: usize) -> Result<f64> {
    let remedy = "the segments are too short for it: frequencies and lags go up to half their length";
    require(index < count, name, index as f64, remedy)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The products are those of the definition, to the rounding of a transform of 32 numbers of order one.
    #[test]
    fn products_do_not_wrap_around() {
        let segments = Segments::new(0, 16, 0.5);
        let x: Vec<f64> = (0..16).map(|t| (1.7 * f64::from(t)).sin() + 0.3).collect();
        for (k, product) in segments.products(&x).into_iter().enumerate() {
            let plain: f64 = (0..16 - k).map(|t| x[t] * x[t + k]).sum();
            assert!((product - plain).abs() < 1e-13, "{k}: {product}, {plain}");
        }
    }

    /// Parseval's identity: a path of ±1 whose sum over every segment vanishes has the mean square 1, which the densities of both
    /// sides add up to.
    #[test]
    fn densities_add_up_to_the_mean_square() -> Result<()> {
        let segments = Segments::new(0, 16, 0.5);
        let (mut tally, mut path) = (segments.sums(), Vec::new());
        let signs = [1.0, -1.0, -1.0, 1.0, 1.0, 1.0, -1.0, -1.0];
        signs.iter().cycle().take(64).for_each(|x| tally.push(&segments, &mut path, *x));
        let spectrum = Spectrum::new(segments, vec![tally.clone(), tally])?;
        let (step, mut sum) = (TAU / (16.0 * 0.5), 0.0);
        for j in 0..=8 {
            let sides = if j % 8 == 0 { 1.0 } else { 2.0 };
            sum += sides * spectrum.density(j)?.value * step;
        }
        assert!((sum - 1.0).abs() < 1e-13, "{sum}");
        Ok(())
    }

    /// A constant has neither spectrum nor covariance.
    #[test]
    fn a_mean_is_no_fluctuation() -> Result<()> {
        let segments = Segments::new(0, 8, 1.0);
        let mut tally = segments.sums();
        let mut path = Vec::new();
        (0..20).for_each(|_| tally.push(&segments, &mut path, 3.0));
        assert_eq!(tally.segments, 4.0);
        let spectrum = Spectrum::new(segments, vec![tally.clone(), tally])?;
        for j in 0..5 {
            // Squares of 9 times the window's energy, less themselves.
            assert!(spectrum.density(j)?.value.abs() < 1e-13 && spectrum.autocovariance(j)?.value.abs() < 1e-13);
        }
        assert!(spectrum.density(5).is_err() && spectrum.autocovariance(5).is_err());
        Ok(())
    }
}
