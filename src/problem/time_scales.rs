//! The fastest and the slowest rate of a system.

use super::{Problem, units::natural_units};
use crate::error::{Error, Result};
use crate::numerics::eigenvalues;
use crate::polynomial::Gaussian;
use crate::states::States;
use crate::walls::{Contact, Wall};
use nalgebra::{DMatrix, DVector};

/// The slowest rate counts as at least this part of the fastest.
const SLOWEST: f64 = 1e-3;
/// Rates that are farther apart than this leave no trajectory to follow: it would take a year.
const STIFF: f64 = 1e10;
/// A growth below this part of the fastest rate is none.
const ROUNDING: f64 = 1e-9;
/// What trajectories do without a restoring drift.
const DRIFTLESS: &str = "trajectories spread without end: the drift is the same everywhere, and must bring them back";

/// The rates that determine a simulation's burn-in and the time between its samples. They scale with the user's unit of time,
/// so that a count of the corresponding times does not depend on it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TimeScales {
    /// A bound on the moduli of the Jacobian's eigenvalues up to two standard deviations from the mean, and the rate of passages
    /// between two walls.
    fastest: f64,
    /// The slowest decay of the linearised system.
    slowest: f64,
    /// Whether the Gaussian closure settles.
    settles: bool,
}

impl TimeScales {
    /// Of the system near the normal density of its Gaussian closure, its walls apart, but for two that noise alone throws trajectories
    /// between.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] where coefficients differ so much that no units are finite.
    pub(crate) fn of(problem: &Problem) -> Result<Self> {
        let (gaussian, settles) = near(problem)?;
        let fastest = fastest(problem, &gaussian).max(between_walls(problem)).max(between_ends(problem));
        let fastest = if fastest > 0.0 { fastest } else { towards_ends(problem).max(f64::MIN_POSITIVE) };
        let slowest = slowest(problem, &gaussian).max(SLOWEST * fastest);
        Ok(TimeScales { fastest, slowest, settles })
    }

    /// Whether the Gaussian closure settles, and with it all of the linearised system decays: A S + S Aᵀ is minus the noise's mean, A the
    /// mean Jacobian and S a covariance.
    pub(crate) fn settles(&self) -> bool {
        self.settles
    }

    /// The fastest rate at some states over the system's.
    ///
    /// # Errors
    /// As [`TimeScales::of`].
    pub(crate) fn share(&self, problem: &Problem, states: &States) -> Result<f64> {
        let deviation = deviations(&near(problem)?.0);
        Ok(states.iter().map(|x| rate(problem, x, &deviation)).fold(0.0, f64::max) / self.fastest)
    }

    /// Refuses a drift that is the same everywhere, which has densities in time alone.
    ///
    /// # Errors
    /// [`Error::NoDensity`].
    pub(crate) fn require_drift(problem: &Problem) -> Result<()> {
        let driftless = problem.operator().drift().iter().all(|f| f.degree() == 0);
        if driftless && problem.ends().is_empty() { Err(Error::no_density(DRIFTLESS)) } else { Ok(()) }
    }

    /// Refuses rates of the linearised system that are too far apart.
    ///
    /// # Errors
    /// [`Error::TooStiff`]; as [`TimeScales::of`].
    pub(crate) fn require_moderate(problem: &Problem) -> Result<()> {
        let (gaussian, _) = near(problem)?;
        let jacobian = mean_jacobian(problem, &gaussian);
        // The slowest rate would be lost in the rounding of the fastest.
        let Some(inverse) = jacobian.clone().try_inverse() else { return Ok(()) };
        let largest = |matrix: DMatrix<f64>| -> Option<f64> {
            Some(eigenvalues(matrix)?.iter().map(|l| l.norm()).fold(0.0, f64::max))
        };
        match [jacobian, inverse].map(largest) {
            [Some(fastest), Some(time)] if fastest * time > STIFF => {
                Err(Error::TooStiff { fastest, slowest: time.recip() })
            }
            _ => Ok(()),
        }
    }

    /// So many times the shortest of the system's times.
    pub(crate) fn short(&self, count: f64) -> f64 {
        count / self.fastest
    }

    /// The time in which the slowest motion falls to e⁻⁵, and energies with it to e⁻¹⁰; between 60 and 2000 of the shortest
    /// times.
    pub(crate) fn memory(&self) -> f64 {
        (5.0 / self.slowest).clamp(self.short(60.0), self.short(2000.0))
    }

    /// The fastest growth of small motions about the state where trajectories start; 0 where they decay.
    pub(crate) fn growth(&self, problem: &Problem) -> f64 {
        let (n, start) = (problem.dimension(), problem.still());
        let slope = |i: usize, j: usize| problem.operator().drift()[i].derivative(j).evaluate(&start);
        let found = eigenvalues(DMatrix::from_fn(n, n, slope)).unwrap_or_default();
        let growth = found.iter().map(|l| l.re).fold(0.0, f64::max);
        // What is far below the fastest rate is the rounding of 0.
        if growth > ROUNDING * self.fastest { growth } else { 0.0 }
    }

    /// The standard deviations of the Gaussian closure.
    ///
    /// # Errors
    /// As [`TimeScales::of`].
    pub(crate) fn deviations(problem: &Problem) -> Result<Vec<f64>> {
        Ok(deviations(&near(problem)?.0))
    }
}

/// The Gaussian closure's density, and whether it settles; if not, the natural units about 0.
fn near(problem: &Problem) -> Result<(Gaussian, bool)> {
    match problem.gaussian() {
        Ok(gaussian) => Ok((gaussian, true)),
        // The system may still be stable: if not, the simulation explodes.
        Err(Error::NoDensity { .. }) => {
            let (frame, _) = natural_units(&problem.operator().diffusive())?;
            let scale = frame.scale();
            let mean = DVector::zeros(problem.dimension());
            Ok((Gaussian { mean, covariance: scale * scale.transpose() }, false))
        }
        Err(error) => Err(error),
    }
}

/// The standard deviations.
fn deviations(gaussian: &Gaussian) -> Vec<f64> {
    (0..gaussian.mean.len()).map(|i| gaussian.covariance[(i, i)].sqrt()).collect()
}

/// The largest sum of a row of the Jacobian at a point, in units of these deviations.
fn rate(problem: &Problem, x: &[f64], deviation: &[f64]) -> f64 {
    let row = |a: usize| -> f64 {
        let slopes = problem.operator().drift()[a].gradient(x);
        slopes.iter().zip(deviation).map(|(slope, b)| slope.abs() * b / deviation[a]).sum()
    };
    (0..deviation.len()).map(row).fold(0.0, f64::max)
}

/// The largest such sum at points up to two deviations away.
fn fastest(problem: &Problem, gaussian: &Gaussian) -> f64 {
    let n = problem.dimension();
    let deviation = deviations(gaussian);
    let mut fastest = 0.0_f64;
    for reach in [0.0, 1.0, 2.0] {
        for i in 0..n {
            for sign in [-1.0, 1.0] {
                let mut x = gaussian.mean.clone();
                x[i] += sign * reach * deviation[i];
                fastest = fastest.max(rate(problem, x.as_slice(), &deviation));
            }
        }
    }
    fastest
}

/// The largest rate (2D / L²)^(1/3) at which noise of the intensity D moves a trajectory from one wall to another at the distance L, where
/// impacts take energy; 0 without such walls. Trajectories graze these at all times, and steps of more than its inverse would be
/// shortened without end.
fn between_walls(problem: &Problem) -> f64 {
    let contacts = problem.contacts();
    let facing = |a: &Contact, b: &Contact| {
        a.wall.state() == b.wall.state()
            && a.wall.other() == b.wall.other()
            && a.wall.is_above()
            && !b.wall.is_above()
            && a.wall.restitution().min(b.wall.restitution()) < 1.0
    };
    let rate = |a: &Contact, b: &Contact| {
        let intensities = [a, b].map(|contact| problem.intensity_at(contact).unwrap_or(0.0));
        let distance = b.wall.offset() - a.wall.offset();
        (2.0 * intensities[0].max(intensities[1]) / (distance * distance)).cbrt()
    };
    let pairs = contacts.iter().flat_map(|a| contacts.iter().map(move |b| (a, b)));
    pairs.filter(|(a, b)| facing(a, b)).map(|(a, b)| rate(a, b)).filter(|rate| rate.is_finite()).fold(0.0, f64::max)
}

/// The largest rate π² D / L² at which noise of the intensity D evens out a density between two reflecting ends at the distance L.
fn between_ends(problem: &Problem) -> f64 {
    let rate = |state: usize| {
        let [Some(low), Some(high)] = problem.end_limits(state) else { return 0.0 };
        let intensity = problem.operator().diffusion()[state][state].constant_term() / 2.0;
        (std::f64::consts::PI / (high - low)).powi(2) * intensity
    };
    (0..problem.dimension()).map(rate).fold(0.0, f64::max)
}

/// The largest rate a²/D of a density exp(−a x/D) that a drift a leaves next to a reflecting end. Where the drift has slopes these are its
/// rates.
fn towards_ends(problem: &Problem) -> f64 {
    let rate = |end: &Wall| {
        let (state, mut x) = (end.state(), problem.still());
        x[state] = end.offset();
        let [drift, diffusion] =
            [&problem.operator().drift()[state], &problem.operator().diffusion()[state][state]].map(|p| p.evaluate(&x));
        2.0 * drift * drift / diffusion
    };
    problem.ends().iter().map(rate).fold(0.0, f64::max)
}

fn mean_jacobian(problem: &Problem, gaussian: &Gaussian) -> DMatrix<f64> {
    let n = problem.dimension();
    let near = problem.operator().near(gaussian);
    let slope = |i: usize, j: usize| gaussian.expectation(&near.drift()[i].derivative(j));
    DMatrix::from_fn(n, n, slope)
}

/// The least real part, in modulus, of the eigenvalues of the mean Jacobian.
fn slowest(problem: &Problem, gaussian: &Gaussian) -> f64 {
    let found = eigenvalues(mean_jacobian(problem, gaussian)).unwrap_or_default();
    found.iter().map(|l| l.re.abs()).fold(f64::INFINITY, f64::min)
}

/// The number rounded down to two decimal digits.
pub(crate) fn two_digits(x: f64) -> f64 {
    let unit = 10.0_f64.powi(x.log10().floor() as i32 - 1);
    let digits = (x / unit).floor();
    // A quotient of whole numbers is the double nearest to the decimal number, and prints as that.
    if unit < 1.0 { digits / unit.recip().round() } else { digits * unit }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::{Duffing, Solved};

    /// c/2 = 0.1; and k + 3μx² = 3.29 at two deviations, times the ratio of the deviations, 0.80, and c.
    #[test]
    fn a_duffing_oscillator_has_its_rates() -> Result<()> {
        let scales = TimeScales::of(&Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?)?;
        assert!((scales.slowest - 0.1).abs() < 1e-12 && (scales.fastest - 2.82).abs() < 0.01, "{scales:?}");
        assert_eq!((two_digits(scales.memory()), two_digits(scales.short(3.0))), (50.0, 1.0));
        // Time in units of 10⁻⁶: c, k, μ and D take the powers 1, 2, 2 and 3 of it.
        let hasty = TimeScales::of(&Duffing::new(0.2e6, 1e12, 0.3e12, 0.2e18)?.problem()?)?;
        assert!((hasty.slowest - 1e5).abs() < 1e-4 && (hasty.fastest / scales.fastest - 1e6).abs() < 1e-4);
        Ok(())
    }

    /// Nothing but two lossy walls, 0.1 apart, bounds noise of 4e19: it crosses in (0.01 / 8e19)^(1/3) = 5e-8.
    #[test]
    fn noise_between_two_walls_has_its_rate() -> Result<()> {
        let duffing = Duffing::new(0.2, 1.0, 0.3, 4e19)?.problem()?;
        let free = TimeScales::of(&duffing)?;
        let between = |below: f64, r: f64| -> Result<TimeScales> {
            let problem = duffing.clone().with_wall(Wall::above(0.0, r)?)?.with_wall(Wall::below(below, r)?)?;
            TimeScales::of(&problem)
        };
        let walls = between(0.1, 0.7)?;
        assert!((walls.fastest / 2e7 - 1.0).abs() < 1e-3, "{walls:?}");
        assert!(walls.fastest > 10.0 * free.fastest);
        // Far walls, and those that take no energy, change nothing.
        assert_eq!(between(1e6, 0.7)?.fastest, free.fastest);
        assert_eq!(between(0.1, 1.0)?.fastest, free.fastest);
        Ok(())
    }

    #[test]
    fn two_digits_are_left() {
        let numbers = [(0.0123, 0.012), (0.99, 0.99), (1.0, 1.0), (128.0, 120.0), (3.19e-7, 3.1e-7), (3.19e7, 3.1e7)];
        for (x, rounded) in numbers {
            assert_eq!(two_digits(x), rounded);
        }
    }
}
