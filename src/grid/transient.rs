//! Transient densities p(x, t) and the rates at which transients die.

use super::assembly::Discretisation;
use super::density::GridDensity;
use super::field::Field;
use super::march::March;
use super::relaxation::{Relaxation, slowest};
use super::solver::difference;
use super::space::Space;
use crate::checks::{dimension, finite, positive, require};
use crate::density::{Density, Frame};
use crate::error::{Error, Result};
use crate::estimate::Estimate;
use crate::grid::tuning;
use crate::polynomial::Gaussian;
use crate::problem::gaussian_after;
use nalgebra::{DMatrix, DVector};

/// Where a transient starts.
#[derive(Clone, Debug, PartialEq)]
pub enum Start {
    /// A known state. No mesh holds a point: the density is followed as a Gaussian, with the exact moments of the Gaussian
    /// closure, until it is as wide as the mesh resolves, and on the mesh from then on.
    Point([f64; 2]),
    /// A normal distribution. It should be wide enough for the mesh, which the error estimates show.
    Gaussian(Gaussian),
}

/// A transient density at one time.
#[derive(Clone, Debug)]
pub struct Transient {
    /// The time since the start.
    pub time: f64,
    /// p(x, t). Its errors are differences between two degrees; the steps' errors are in `step_error`.
    pub density: GridDensity,
    /// The sum of the time steps' error estimates up to here, relative to the root mean square of p.
    pub step_error: f64,
}

impl GridDensity {
    /// The `count` slowest modes of relaxation by rising rate, the stationary density itself first, whose rate is 0 but for
    /// the leak. They are chosen among the 2`count` eigenvalues nearest to zero.
    ///
    /// A transient lasts as long as the second one: it has fallen to a thousandth after 7/rate. A bistable system's second
    /// rate is the rate at which its wells mix.
    ///
    /// # Errors
    /// [`Error::SingularSystem`] if the shifted matrix is singular.
    ///
    /// ```
    /// use expoly::{Grid, models::{Linear, Solved}};
    /// let problem = Linear::new(0.5, 1.0, 0.5)?.problem()?;
    /// let modes = Grid::new().degree(7).solve(&problem)?.relaxation(3)?;
    /// // The eigenvalues of a linear oscillator: c/2 ± √(c²/4 − k).
    /// assert!(modes[0].rate.abs() < 1e-8);
    /// assert!((modes[1].rate - 0.25).abs() < 1e-6 && (modes[1].frequency - 0.9375_f64.sqrt()).abs() < 1e-6);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn relaxation(&self, count: usize) -> Result<Vec<Relaxation>> {
        let operator = Discretisation::new(&self.problem, &self.fine.space, self.memory)?;
        // The growth of a state's variance by the noise per unit time over twice its second moment: a rate of the right size.
        let rate = |state: usize| -> Result<f64> {
            let injected = &self.problem.operator().diffusion()[state][state];
            Ok(self.expectation(&|x| injected.evaluate(x))?.value / 2.0 / self.variance(state)?.value)
        };
        let shift = rate(0)?.max(rate(1)?).max(f64::MIN_POSITIVE);
        slowest(&operator, shift / 4.0, count)
    }

    /// The densities at rising `times` after `start`, by a Runge-Kutta method of order 4 that is stable for every step. Each
    /// step may err by `tolerance`, relative to the root mean square of p; moments err much less, and 1e-4 is a good value.
    /// The mesh is that of the stationary density.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if times do not rise or are not finite, a time lies before the first one that the mesh resolves, the tolerance is
    /// not positive, or the start lies (partly) outside the domain; [`Error::Dimension`] for a start in other than two states.
    pub fn transient(&self, start: &Start, times: &[f64], tolerance: f64) -> Result<Vec<Transient>> {
        positive("tolerance of a time step", tolerance, "it must be finite and above zero")?;
        let (begin, gaussian) = self.resolved(start)?;
        let first = times.first().copied().unwrap_or(begin);
        let remedy = "before that time the density is too narrow for the mesh: take more cells or a later time";
        require(first >= begin, "first time of a transient", first, remedy)?;
        times.iter().try_for_each(|&time| finite("time of a transient", time).map(|_| ()))?;
        for pair in times.windows(2) {
            positive("time to the next density", pair[1] - pair[0], "give times in rising order")?;
        }
        let march = |space: &Space| self.marched(space, begin, &gaussian, times, tolerance);
        let (fine, coarse) = rayon::join(|| march(&self.fine.space), || march(&self.coarse.space));
        let all = times.iter().zip(fine?).zip(coarse?);
        Ok(all
            .map(|((time, (fine, step_error)), (coarse, _))| {
                let mut density = self.clone();
                density.provenance.l1_estimate = Some(difference(&fine, &coarse));
                (density.fine, density.coarse) = (fine, coarse);
                Transient { time: *time, density, step_error }
            })
            .collect())
    }

    /// The time at which the start is wide enough for the mesh, and the Gaussian then.
    fn resolved(&self, start: &Start) -> Result<(f64, Gaussian)> {
        let x = match start {
            Start::Gaussian(gaussian) => {
                dimension("the start of a transient", gaussian.mean.len(), 2)?;
                Frame::new(gaussian)?;
                return Ok((0.0, gaussian.clone()));
            }
            Start::Point(x) => *x,
        };
        for value in x {
            finite("start of a transient", value)?;
        }
        let point = Gaussian { mean: DVector::from_column_slice(&x), covariance: DMatrix::zeros(2, 2) };
        let least: [f64; 2] = std::array::from_fn(|i| {
            let axis = &self.fine.space.axes[i];
            let cell = axis.locate(x[i] - axis.origin).unwrap_or(0);
            tuning::mesh::RESOLVED * axis.width(cell) / self.fine.space.degree as f64
        });
        let wide = |g: &Gaussian| (0..2).all(|i| g.covariance[(i, i)].sqrt() >= least[i]);
        // From far below the time in which noise crosses a cell, by steps of a tenth.
        let strength =
            (0..2).map(|i| self.problem.operator().diffusion()[i][i].evaluate(&x)).fold(f64::MIN_POSITIVE, f64::max);
        let mut time = 1e-3 * least[1].powi(2) / strength;
        for _ in 0..400 {
            let gaussian = gaussian_after(self.problem.operator(), &point, time);
            if wide(&gaussian) {
                return Ok((time, gaussian));
            }
            time *= 1.1;
        }
        let remedy = "the noise does not spread this start: give a Gaussian";
        Err(Error::OutOfRange { name: "start of a transient", value: x[0], remedy })
    }

    /// The solutions at `times` on one space, each with the steps' error so far.
    fn marched(
        &self,
        space: &Space,
        begin: f64,
        gaussian: &Gaussian,
        times: &[f64],
        tolerance: f64,
    ) -> Result<Vec<(Field, f64)>> {
        let operator = Discretisation::new(&self.problem, space, self.memory)?;
        let frame = Frame::new(gaussian)?;
        let volume = (std::f64::consts::TAU.ln() + frame.log_volume()).exp();
        let (origin, inverse) = (frame.origin(), frame.inverse());
        let density = |x: [f64; 2]| {
            let [dx, dy] = [x[0] - origin[0], x[1] - origin[1]];
            let [a, b] = [inverse[(0, 0)] * dx, inverse[(1, 0)] * dx + inverse[(1, 1)] * dy];
            (-(a * a + b * b) / 2.0).exp() / volume
        };
        let start = Field::projected(space, density);
        let mass = start.mass();
        let remedy = "the start must lie inside the domain, away from walls, and be wide enough for the mesh";
        require((mass - 1.0).abs() <= 1e-3, "mass of the start on the mesh", mass, remedy)?;
        let span = times.last().copied().unwrap_or(begin) - begin;
        let mut march = March::new(&operator, (begin, start.coefficients), span / 400.0, tolerance);
        let mut fields = Vec::new();
        for time in times {
            march.advance(*time)?;
            fields.push((Field { space: space.clone(), coefficients: march.p.clone() }, march.error));
        }
        Ok(fields)
    }
}

impl Transient {
    /// A raw moment E[x₁^p₁ x₂^p₂] at this time, its error that of space and steps together.
    ///
    /// # Errors
    /// As [`GridDensity`]'s own moments.
    pub fn moment(&self, powers: &[u32]) -> Result<Estimate> {
        let moment = self.density.moment(powers)?;
        Ok(Estimate::new(moment.value, moment.error + self.step_error * moment.value.abs()))
    }
}
