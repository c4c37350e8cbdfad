//! Transient densities p(x, t) on the mesh of the stationary one, and the rates at which transients die.

use super::assembly::Discretisation;
use super::density::GridDensity;
use super::domain::Profile;
use super::field::Field;
use super::march::March;
use super::relaxation::slowest;
use super::solver::difference;
use super::space::Side;
use crate::checks::positive;
use crate::density::Density;
use crate::envelope::Envelope;
use crate::error::{Error, Result};
use crate::grid::tuning;
use crate::transient::{Relaxation, Start, Transient, check_times};

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
        let operator = Discretisation::new(&self.problem, &self.fine.space, self.grid.memory)?;
        // The growth of a state's variance by the noise per unit time over twice its second moment: a rate of the right size.
        let rate = |state: usize| -> Result<f64> {
            let injected = &self.problem.operator().diffusion()[state][state];
            Ok(self.expectation(&|x| injected.evaluate(x))?.value / 2.0 / self.variance(state)?.value)
        };
        let shift = rate(0)?.max(rate(1)?).max(f64::MIN_POSITIVE);
        slowest(&operator, shift / 4.0, count)
    }

    /// The densities at rising `times` after `start`, by a Rosenbrock method of order 4 that is stable for every step. Each
    /// step may err by `tolerance`, relative to the root mean square of p; moments err much less, and 1e-4 is a good value.
    /// The mesh is that of the stationary density.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if times do not rise or are not finite, a time lies before the first one that the mesh resolves, the tolerance is
    /// not positive, or the start lies (partly) outside the domain; [`Error::Dimension`] for a start in other than two states.
    pub fn transient(&self, start: &Start, times: &[f64], tolerance: f64) -> Result<Vec<Transient<Self>>> {
        self.evolved(None, start, times, tolerance)
    }

    /// The same under modulated noise, whose columns are multiplied by the envelope e(t). The mesh is that of the stationary
    /// density under the noise as it stands, e = 1: that noise should be about the strongest one, and the envelope's peak
    /// about 1.
    ///
    /// # Errors
    /// As [`GridDensity::transient`]; [`Error::DomainCut`] if the density has spread beyond the domain.
    ///
    /// ```
    /// use expoly::{Envelope, Grid, Start, models::{Linear, Solved}};
    /// let density = Grid::new().degree(6).solve(&Linear::new(0.5, 1.0, 0.5)?.problem()?)?;
    /// let burst = Envelope::steps([(0.0, 1.0), (3.0, 0.0)])?;
    /// let after = density.modulated_transient(&burst, &Start::Point(vec![0.0, 0.0]), &[3.0, 4.0], 1e-4)?;
    /// let [during, later] = [0, 1].map(|k| after[k].moment(&[0, 2]));
    /// assert!(later?.value < 0.7 * during?.value);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn modulated_transient(
        &self,
        envelope: &Envelope,
        start: &Start,
        times: &[f64],
        tolerance: f64,
    ) -> Result<Vec<Transient<Self>>> {
        self.evolved(Some(envelope), start, times, tolerance)
    }

    fn evolved(
        &self,
        envelope: Option<&Envelope>,
        start: &Start,
        times: &[f64],
        tolerance: f64,
    ) -> Result<Vec<Transient<Self>>> {
        let initial = self.initial(start, &self.fine.space, envelope)?;
        let remedy = "before that time the density is too narrow for the mesh: take more cells or a later time";
        check_times(times, initial.time, remedy)?;
        let plan = Plan::new(envelope, times, tolerance)?;
        let march =
            |stationary: &Field| self.marched(&plan, initial.time, initial.field(stationary, &stationary.space)?);
        let (fine, coarse) = rayon::join(|| march(&self.fine), || march(&self.coarse));
        let all = times.iter().zip(fine?).zip(coarse?);
        all.map(|((time, (fine, steps)), (coarse, _))| {
            let mut density = self.clone();
            // What a leak moves between wells grows with time to that of the stationary density.
            density.provenance.l1_estimate = Some(difference(&fine, &coarse) + density.returned.size());
            (density.fine, density.coarse) = (fine, coarse);
            if envelope.is_some() {
                density.require_inside()?;
            }
            Ok(Transient { time: *time, density, step_error: steps.error })
        })
        .collect()
    }

    /// The solutions at all times on the space of `start`, each with its steps so far.
    pub(super) fn marched(&self, plan: &Plan<'_>, begin: f64, start: Field) -> Result<Vec<(Field, Steps)>> {
        let memory = self.grid.memory;
        let space = start.space;
        let (operator, modulation) = match plan.envelope {
            None => (Discretisation::new(&self.problem, &space, memory)?, None),
            Some(envelope) => {
                let (operator, modulation) = Discretisation::modulated(&self.problem, &space, envelope, memory)?;
                (operator, Some(modulation))
            }
        };
        let span = plan.times.last().copied().unwrap_or(begin) - begin;
        let first = span / tuning::march::FIRST;
        let mut march =
            March::new(&operator, (begin, start.coefficients), first, plan.tolerance).modulated(modulation.as_ref());
        let field = |coefficients: &Vec<f64>| Field { space: space.clone(), coefficients: coefficients.clone() };
        let mut fields = Vec::new();
        for time in plan.times {
            march.advance(*time)?;
            fields.push((field(&march.p), Steps { error: march.error, mass: field(&march.difference).mass() }));
        }
        Ok(fields)
    }

    /// Refuses a density that the domain cuts, and enters the level at its edges.
    fn require_inside(&mut self) -> Result<()> {
        let accepted = tuning::domain::CUT;
        self.edge_level = 0.0;
        for (state, side) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            if state == 1 || self.fine.space.sides[side] == Side::Open {
                let level = Profile::new(&self.fine, state).edge(side);
                if level.is_nan() || level > accepted {
                    return Err(Error::DomainCut { state, edge: self.domain[state][side], level, accepted });
                }
                self.edge_level = self.edge_level.max(level);
            }
        }
        self.provenance.edge_level = Some(self.edge_level);
        Ok(())
    }
}

/// A march: the modulation of the noise, and the times that are to be reached.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plan<'a> {
    envelope: Option<&'a Envelope>,
    times: &'a [f64],
    tolerance: f64,
}

impl<'a> Plan<'a> {
    /// # Errors
    /// [`Error::OutOfRange`] unless the tolerance is positive.
    pub(super) fn new(envelope: Option<&'a Envelope>, times: &'a [f64], tolerance: f64) -> Result<Self> {
        positive("tolerance of a time step", tolerance, "it must be finite and above zero")?;
        Ok(Plan { envelope, times, tolerance })
    }
}

/// What the steps up to a time add to the error.
#[derive(Clone, Copy, Debug)]
pub(super) struct Steps {
    /// The sum of their estimates, relative to the root mean square of p.
    pub(super) error: f64,
    /// The mass of the sum of their differences from a lower order.
    pub(super) mass: f64,
}
