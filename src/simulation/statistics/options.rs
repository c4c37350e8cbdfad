use super::requests::PassageRequest;
use crate::simulation::Simulation;

impl Simulation<'_> {
    /// Moments to be kept besides those that always are (all degrees up to 4 for up to three states): the exponents of each,
    /// of degree 32 at most. [`Density::moment`](crate::Density::moment) then has them.
    ///
    /// High moments depend on the tail: the relative standard error of E x^k grows about like 2^(k/2) for a normal density.
    pub fn moments(mut self, exponents: impl IntoIterator<Item = impl AsRef<[u32]>>) -> Self {
        self.requests.moments.extend(exponents.into_iter().map(|exponents| exponents.as_ref().to_vec()));
        self
    }

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

    /// Measures the time to the first passage of state 0 through `level` from below, in windows of the length `window`, each
    /// begun at a stationary state, and keeps its distribution at `bins` equal times in them.
    /// [`SimulatedDensity::first_passage`](crate::SimulatedDensity::first_passage) gives it.
    ///
    /// The path of a displacement is followed at all times, and its passages are located to a sampling interval; of any other
    /// state 0 only the samples are used. The window is rounded to whole sampling intervals for each of the `bins`.
    pub fn first_passage(mut self, level: f64, window: f64, bins: usize) -> Self {
        self.requests.passages.push(PassageRequest { level, length: window, bins });
        self
    }
}
