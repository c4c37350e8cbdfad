use super::{
    lanes::Lanes,
    passage::{Course, Passages},
    scheme::Scheme,
};
use crate::eigenvalues::eigenvalues;
use crate::fokker_planck::ito_drift;
use crate::system::Amplified;
use crate::{Barrier, FokkerPlanck, PolynomialDrift, Result};
use nalgebra::DMatrix;
use num_dual::Dual64;

/// The step of time as a part of the time scale 1/ω: ωh. The bias of means is (ωh)²/10 without and (ωh)²/3 beside a wall
/// with r < 1, about: below 0.02 % and 0.05 %.
const RESOLUTION: f64 = 0.04;
const BESIDE_LOSSY_WALL: f64 = 0.03;

/// The largest ωh anywhere on the scouts' way. At 2 the steps would be unstable.
const LARGEST: f64 = 0.25;

/// The scouts: trajectories in one group of lanes, with streams of their own.
const SCOUTS: usize = 16;
const FIRST: u64 = 1 << 33;

/// The stretches of their way; they look around after each of the second half.
const STRETCHES: usize = 64;

/// The most steps tried. Each is at most half the one before.
const ATTEMPTS: usize = 12;

/// How fast a system is: the rate ω that its time step was chosen by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pace {
    pub(super) rate: f64,
    pub(super) step: f64,
}

/// What the scouts are sent through.
pub(super) struct Terrain<'a, T, const N: usize, const M: usize> {
    pub(super) system: Amplified<'a, T>,
    pub(super) operator: &'a FokkerPlanck<N>,
    pub(super) barrier: Option<Barrier>,
    pub(super) seed: u64,
    /// The time that the scouts travel, at least.
    pub(super) time: f64,
    /// The longest step that makes sense whatever the system.
    pub(super) longest: f64,
}

impl<T: PolynomialDrift<N, M>, const N: usize, const M: usize> Terrain<'_, T, N, M> {
    /// Chooses the time step from the system's own time scales, where the trajectories are.
    ///
    /// The rate of a state is the largest modulus of the eigenvalues of ∂f/∂x, with the Itô drift f, and the square of
    /// ∂G/∂x, by which noise of its own strength grows; both from dual numbers. ω² is the mean of its square along the way
    /// of some scouts, and of (πν)² for ν impacts per unit time: a wall that is hit twice as often as the force alone turns
    /// the motion round is another time scale. The step is 0.04/ω, or 0.03/ω beside a wall with r < 1, shorter where some
    /// state is more than six times faster, rounded down to two digits. Where the scouts' own step turns out to be too long,
    /// they go again with a shorter one.
    ///
    /// # Errors
    /// [`Error::Exploded`](crate::Error::Exploded) if the scouts explode with the shortest step too.
    pub(super) fn pace<S: Fn([f64; N]) -> [f64; N]>(&self, start: impl Fn(f64) -> S) -> Result<Pace> {
        let lossy = self.barrier.is_some_and(|wall| wall.restitution() < 1.0);
        let mut step = self.longest;
        let mut attempt = 0;
        loop {
            attempt += 1;
            match self.scouted(step, start(step)) {
                Err(error) if attempt == ATTEMPTS => return Err(error),
                Err(_) => step /= 4.0,
                Ok((rate, largest)) => {
                    let resolution = if lossy { BESIDE_LOSSY_WALL } else { RESOLUTION };
                    let fits = (resolution / rate).min(LARGEST / largest).min(self.longest);
                    if fits >= step / 2.0 || attempt == ATTEMPTS {
                        return Ok(Pace { rate, step: two_digits(fits) });
                    }
                    step = fits;
                }
            }
        }
    }

    /// The root mean square of the rate and the largest one along the way of scouts with this step.
    fn scouted(&self, step: f64, start: impl Fn([f64; N]) -> [f64; N]) -> Result<(f64, f64)> {
        let scheme = Scheme::new(self.system, self.operator, step);
        let course = Course::for_scheme(&scheme, self.barrier, Vec::new());
        let mut scouts = Lanes::<N, SCOUTS>::new(self.seed, FIRST..FIRST + SCOUTS as u64, start);
        let steps = (self.time / step / STRETCHES as f64).ceil().max(1.0) as usize;
        let mut passages = Passages::new(0);
        let (mut squares, mut largest, mut count) = (0.0, 0.0_f64, 0.0);
        for stretch in 0..STRETCHES {
            if stretch == STRETCHES / 2 {
                passages = Passages::new(0);
            }
            scouts.advance(&scheme, &course, steps, &mut passages);
            scouts.check(&[f64::INFINITY; N], ((stretch + 1) * steps) as f64 * step, step)?;
            if stretch >= STRETCHES / 2 {
                for x in scouts.states() {
                    let rate = rate(&self.system, x);
                    squares += rate * rate;
                    largest = largest.max(rate);
                    count += 1.0;
                }
            }
        }
        let impacts = passages.impacts[0] / (count * steps as f64 * step);
        Ok(((squares / count + (std::f64::consts::PI * impacts).powi(2)).sqrt(), largest))
    }
}

/// The rate of a state: the spectral radius of ∂f/∂x, and Σ|∂G/∂x|².
fn rate<T: PolynomialDrift<N, M>, const N: usize, const M: usize>(system: &T, x: [f64; N]) -> f64 {
    let mut jacobian = DMatrix::zeros(N, N);
    let mut noise_rate = 0.0;
    for j in 0..N {
        let at: [Dual64; N] = std::array::from_fn(|i| Dual64::new(x[i], f64::from(i == j)));
        let drift = ito_drift(system, at);
        let noise = system.noise(at);
        for i in 0..N {
            jacobian[(i, j)] = drift[i].eps;
            noise_rate += noise[i].iter().map(|g| g.eps * g.eps).sum::<f64>();
        }
    }
    let fastest = eigenvalues(jacobian).iter().map(|value| value.norm()).max_by(f64::total_cmp);
    fastest.map_or(f64::INFINITY, |fastest| noise_rate + fastest)
}

/// The number rounded down to two decimal digits.
fn two_digits(x: f64) -> f64 {
    let unit = 10.0_f64.powi(x.log10().floor() as i32 - 1);
    let digits = (x / unit).floor();
    // A quotient of whole numbers prints as the decimal number that it is meant to be.
    if unit < 1.0 { digits / unit.recip().round() } else { digits * unit }
}
