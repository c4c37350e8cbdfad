//! Transient densities p(x, t) on the mesh of the stationary one, and the rates at which transients die.

use super::density::GridDensity;
use super::field::{Field, difference};
use super::flux::Part;
use super::march::{March, Modulation};
use super::operator::{Layout, Operator};
use super::relaxation::slowest;
use crate::checks::positive;
use crate::density::Density;
use crate::envelope::Envelope;
use crate::error::{Error, Result};
use crate::grid::tuning;
use crate::transient::{Relaxation, Start, Transient, check_times};

impl GridDensity {
    /// The `count` slowest modes of relaxation by rising rate, the stationary density itself first, whose rate is 0 but for
    /// the leak. They are chosen among the 2`count` eigenvalues nearest to zero
    /// that both degrees have.
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
        // The growth of a state's variance by the noise per unit time over twice its second moment: a rate of the right size.
        let rate = |state: usize| -> Result<f64> {
            let injected = &self.kept.problem.operator().diffusion()[state][state];
            Ok(self.expectation(&|x| injected.evaluate(x))?.value / 2.0 / self.variance(state)?.value)
        };
        let mut shift = f64::MIN_POSITIVE;
        for state in 0..self.fine.shape.states {
            shift = shift.max(rate(state)?);
        }
        let [fine, coarse] = &self.kept.solutions;
        slowest([&fine.operator, &coarse.operator], shift / 4.0, count)
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
        let initial = self.initial(start, &self.fine.mesh, envelope)?;
        let remedy = "before that time the density is too narrow for the mesh: take a later time or a finer accuracy";
        check_times(times, initial.time, remedy)?;
        let plan = Plan::new(envelope, times, tolerance)?;
        let march = |stationary: &Field| {
            let start = initial.field(stationary, &stationary.mesh, stationary.shape)?;
            let layout = &self.kept.solutions[0].operator.layout;
            let of = self.kept.solutions.iter().map(|solution| &solution.operator).find(|own| own.shape == start.shape);
            self.marched(&plan, initial.time, start, layout, of)
        };
        let (fine, coarse) = rayon::join(|| march(&self.fine), || march(&self.coarse));
        let all = times.iter().zip(fine?).zip(coarse?);
        all.map(|((time, (fine, steps)), (coarse, _))| {
            let mut density = self.clone();
            // What a leak moves between wells grows with time to that of the stationary density.
            density.provenance.l1_estimate = Some(difference(&fine, &coarse) + self.changed());
            (density.fine, density.coarse) = (fine, coarse);
            if envelope.is_some() {
                density.require_inside()?;
            }
            Ok(Transient { time: *time, density, step_error: steps.error })
        })
        .collect()
    }

    /// The size of what changes with leaks and shares.
    pub(super) fn changed(&self) -> f64 {
        self.changes.iter().map(Field::size).sum()
    }

    /// The solutions at all times on the mesh of `start`, each with its steps so far; `known` is the operator there, if there is one.
    pub(super) fn marched(
        &self,
        plan: &Plan<'_>,
        begin: f64,
        start: Field,
        layout: &Layout,
        known: Option<&Operator>,
    ) -> Result<Vec<(Field, Steps)>> {
        let (memory, degree, problem) = (self.kept.grid.memory, start.shape.degree, &self.kept.problem);
        let made;
        let part = |part: Part<'_>| Operator::new(problem, layout, degree, part, memory);
        let (operator, modulation) = match (plan.envelope, known) {
            (None, Some(known)) => (known, None),
            (None, None) => {
                made = part(Part::Whole)?;
                (&made, None)
            }
            (Some(envelope), _) => {
                made = part(Part::Drift)?;
                (&made, Some(Modulation { noise: part(Part::Noise)?, envelope }))
            }
        };
        let span = plan.times.last().copied().unwrap_or(begin) - begin;
        let first = span / tuning::march::FIRST;
        let mut march = March::new(operator, (begin, start.coefficients.clone()), first, plan.tolerance)
            .modulated(modulation.as_ref());
        let field = |coefficients: &Vec<f64>| Field { coefficients: coefficients.clone(), ..start.clone() };
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
        self.edges = self.fine.at_edges();
        for &(state, side, level) in &self.edges {
            if level.is_nan() || level > accepted {
                return Err(Error::DomainCut { state, edge: self.fine.mesh.domain()[state][side], level, accepted });
            }
        }
        self.provenance.edge_level = Some(self.edges.iter().map(|(.., level)| *level).fold(0.0, f64::max));
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
