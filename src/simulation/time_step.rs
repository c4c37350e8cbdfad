use super::{
    Simulation,
    boundaries::Boundaries,
    control::Control,
    group::{Group, Workspace},
    scheme::Scheme,
    start::TrajectoryStart,
    timetable::Times,
};
use crate::error::{Error, Result};
use crate::field::LANES;
use crate::numerics::eigenvalues;
use crate::problem::{Problem, TimeScales, two_digits};
use crate::simulation::{RESOLUTION, SAMPLING_INTERVAL, USUAL_IMPULSES};
use crate::walls::Contact;
use nalgebra::DMatrix;

/// The time step beside a wall with r < 1 as a part of the time scale 1/ω of the motion, where the bias of means is (ωh)²/3,
/// about: below 0.05 %.
const BESIDE_LOSSY_WALL: f64 = 0.03;
/// The factor of the time step where the drift jumps at a place that noise does not carry trajectories across: the bias of an oscillator
/// with a preload x + sgn x is seven times that of a linear one.
const AT_JUMPS: f64 = 0.4;
/// The largest product ωh of a state's rate and the time step anywhere on the way of a trajectory; at 2 the steps would be
/// unstable.
const LARGEST: f64 = 0.25;
/// The stretches that a try of a time step is divided into; rates are taken after each of the second half.
const STRETCHES: usize = 64;
/// The most time steps that are tried, each at most half the one before.
const ATTEMPTS: usize = 12;
/// The most steps in a stretch of a try of a time step, which reports no progress. Default times never take so many.
const MOST_STEPS: f64 = 4096.0;

/// The first of the trajectories for the choice, one group of lanes with streams of their own.
const FIRST: u64 = 1 << 33;

impl Simulation<'_> {
    /// Chooses the time step from the system's own time scales, where the trajectories are. Returns the rate ω too.
    ///
    /// The rate of a state is the largest modulus of the eigenvalues of ∂f/∂x, with the Itô drift f, and the square of
    /// ∂G/∂x, by which noise of its own strength grows; both from dual numbers. ω² is the mean of its square along the
    /// way of some trajectories, and of (πν)² for ν impacts per unit time: a wall that is hit twice as often as the
    /// force alone turns the motion round is another time scale. The step is 0.04/ω, or 0.03/ω beside a wall with r <
    /// 1, shorter where some state is more than six times faster, rounded down to two digits. Where the step that was
    /// tried turns out to be too long, the trajectories go again with a shorter one.
    ///
    /// # Errors
    /// [`Error::Exploded`] if they explode with the shortest step too, [`Error::TooStiff`], and [`Error::OutOfTime`].
    pub(super) fn chosen_step(
        &self,
        problem: &Problem,
        contacts: &[Contact],
        times: Times,
        control: &Control<'_>,
    ) -> Result<(f64, f64)> {
        TimeScales::require_moderate(problem)?;
        let lossy = contacts.iter().any(|contact| contact.wall.restitution() < 1.0);
        // A jump that no noise crosses has no slope to see it by.
        let jumps = problem.surfaces().iter().any(|surface| surface.order < 1.0) && !problem.is_bridged();
        let resolution = if lossy { BESIDE_LOSSY_WALL } else { RESOLUTION } * if jumps { AT_JUMPS } else { 1.0 };
        // Twenty steps between samples, and 640 to the end of the burn-in, are enough for any system.
        let burn_in = if times.burn_in > 0.0 { times.burn_in / 640.0 } else { f64::INFINITY };
        let slow = TimeScales::of(problem)?.short(SAMPLING_INTERVAL);
        // A wall may hold the trajectories where they would hardly ever be without it, and all rates are larger.
        let at_rest = |contact: &Contact| rate(problem, self.amplitude, &contact.at_rest(problem.dimension()));
        let at_wall = contacts.iter().map(at_rest).fold(0.0, f64::max);
        let longest = (times.interval.min(slow) / 20.0).min(burn_in).min(LARGEST / at_wall);
        let longest = longest.min(USUAL_IMPULSES / problem.impulse_rate());
        let mut step = longest;
        let mut attempt = 0;
        loop {
            attempt += 1;
            match self.rates(problem, contacts, step, times, control) {
                Err(error @ Error::Exploded { .. }) if attempt == ATTEMPTS => return Err(error),
                Err(Error::Exploded { .. }) => step /= 4.0,
                Err(error) => return Err(error),
                Ok((rate, largest)) => {
                    let fits = (resolution / rate).min(LARGEST / largest).min(longest);
                    if fits >= step / 2.0 || attempt == ATTEMPTS {
                        return Ok((two_digits(fits), rate));
                    }
                    step = fits;
                }
            }
        }
    }

    /// The root mean square of the rate and the largest one along the way with this step.
    fn rates(
        &self,
        problem: &Problem,
        contacts: &[Contact],
        step: f64,
        times: Times,
        control: &Control<'_>,
    ) -> Result<(f64, f64)> {
        let scheme = Scheme::new(problem, self.amplitude, step);
        let boundaries = Boundaries::for_scheme(&scheme, contacts, Vec::new());
        let start = TrajectoryStart::new(self, problem, step)?;
        let mut group = Group::new(self.seed, FIRST..FIRST + LANES as u64, scheme.states, |x| start.place(x));
        let time = times.burn_in.max(32.0 * times.interval);
        let steps = (time / step / STRETCHES as f64).ceil().clamp(1.0, MOST_STEPS) as usize;
        let (mut passages, mut work) = (boundaries.passages(), Workspace::new(&scheme));
        let (mut squares, mut largest, mut count) = (0.0, 0.0_f64, 0.0);
        for stretch in 0..STRETCHES {
            if stretch == STRETCHES / 2 {
                passages = boundaries.passages();
            }
            group.advance(&scheme, &boundaries, steps, &mut passages, &mut work);
            group.check(&[], ((stretch + 1) * steps) as f64 * step, step)?;
            control.check_anywhere()?;
            if stretch >= STRETCHES / 2 {
                for x in &group.states() {
                    let rate = rate(problem, self.amplitude, x);
                    squares += rate * rate;
                    largest = largest.max(rate);
                    count += 1.0;
                }
            }
        }
        // Impacts on a wall that trajectories come to rest on may be infinitely many, and have shorter steps of their own.
        let walls = contacts.iter().zip(&passages.impacts).filter(|(contact, _)| !contact.is_rested_on());
        let impacts = walls.map(|(_, powers)| powers[0]).sum::<f64>() / (count * steps as f64 * step);
        Ok(((squares / count + (std::f64::consts::PI * impacts).powi(2)).sqrt(), largest))
    }
}

/// The rate of a state: the spectral radius of ∂f/∂x, and Σ|∂G/∂x|² with all noises times `amplitude`.
fn rate(problem: &Problem, amplitude: f64, x: &[f64]) -> f64 {
    let mut jacobian = vec![0.0; x.len() * x.len()];
    let noise_rate = problem.field().slopes(x, &mut jacobian) * amplitude * amplitude;
    let found = eigenvalues(DMatrix::from_row_slice(x.len(), x.len(), &jacobian));
    found.map_or(f64::INFINITY, |all| noise_rate + all.iter().map(|value| value.norm()).fold(0.0, f64::max))
}
