//! Transient densities p(x, t), and the rates at which transients die.

use super::density::GridDensity;
use super::evolution::{Evolution, EvolutionPlan, MOST_WORK};
use super::field::{GridField, difference};
use super::initial::Initial;
use super::relaxation::slowest;
use crate::checks::require;
use crate::error::{Error, Result};
use crate::grid::require_accuracy;
use crate::transient::{Course, Relaxation, Transient, check_times};

/// The largest density at the edge of the domain, relative to the peak, that a transient under an envelope may have: the
/// domain cuts one with more.
const CUT: f64 = 1e-3;
/// The largest part of the mass that may have left the domain.
const LOST: f64 = 1e-2;

impl GridDensity {
    /// The `count` slowest modes of relaxation by rising rate, the stationary density itself first, whose rate is 0 but for
    /// the leak. They are chosen among the 2`count` eigenvalues nearest to zero
    /// that both degrees have.
    ///
    /// A transient lasts as long as the second one: it has fallen to a thousandth after 7/rate. A bistable system's second
    /// rate is the rate at which its wells mix.
    ///
    /// # Errors
    /// [`Error::NotResolved`] if the shifted matrix is singular.
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
        let rate = |state: usize| {
            let injected = &self.kept.problem.operator().diffusion()[state][state];
            let rule = self.fine.shape.rule(4);
            let mean = |g: &(dyn Fn(&[f64]) -> f64 + Sync)| self.fine.sum_over_nodes(&rule, |y, p| p * g(y));
            let middle = mean(&|y| y[state]);
            mean(&|y| injected.evaluate(y)) / 2.0 / mean(&|y| (y[state] - middle).powi(2))
        };
        let shift = (0..self.fine.shape.states).map(rate).fold(f64::MIN_POSITIVE, f64::max);
        let [fine, coarse] = &self.kept.solutions;
        slowest([&fine.operator, &coarse.operator], shift / 4.0, count)
    }

    /// The densities at rising `times` after the start, by a Rosenbrock method of order 4 that is stable for every step, on a mesh that
    /// follows the density: it is refined before a step that it would not hold to half of `accuracy` in L¹, and coarsened behind.
    /// Each step may err by `accuracy`, relative to the root mean square of p; moments err much less, and 1e-4 is a good value. A
    /// point is followed as a Gaussian, with the moments of the Gaussian closure, until that may be off by the other half, which
    /// is part of the estimate; at least until one of its deviations is 0.03 of the stationary one.
    ///
    /// The domain is that of the stationary density under the noise as it stands: the peak of an envelope should be about 1.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if times do not rise or are not finite, a time lies before the start has a density, the accuracy is
    /// not between 1e-11 and 0.1, or the start lies (partly) outside the domain, leaves it, or is too narrow for double precision there;
    /// [`Error::Dimension`] for a start in other than the problem's states; [`Error::NotResolved`] if the errors of the steps add up to
    /// the density itself, or it has spread beyond the domain under an envelope; [`Error::Cancelled`] if
    /// [`Grid::progress`](crate::Grid::progress) stops it. Where the memory does not suffice for the mesh, or the mesh is too large for
    /// the steps, the provenance warns.
    ///
    /// ```
    /// use expoly::{Course, Envelope, Grid, models::{Linear, Solved}};
    /// let density = Grid::new().degree(6).solve(&Linear::new(0.5, 1.0, 0.5)?.problem()?)?;
    /// let burst = Course::from([0.0, 0.0]).under(Envelope::steps([(0.0, 1.0), (3.0, 0.0)])?);
    /// let after = density.transient(burst, &[3.0, 4.0], 1e-4)?;
    /// let [during, later] = [0, 1].map(|k| after[k].moment(&[0, 2]));
    /// assert!(later?.value < 0.7 * during?.value);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn transient(&self, course: impl Into<Course>, times: &[f64], accuracy: f64) -> Result<Vec<Transient<Self>>> {
        self.evolved(&course.into(), times, (accuracy, MOST_WORK))
    }

    /// The same with a bound on the unknowns that all steps together solve for.
    pub(crate) fn evolved(
        &self,
        course: &Course,
        times: &[f64],
        (accuracy, most_spent): (f64, f64),
    ) -> Result<Vec<Transient<Self>>> {
        let sheared = self.shear.as_ref().map(|shear| shear.start(&course.start)).transpose()?;
        let (start, envelope) = (sheared.as_ref().unwrap_or(&course.start), course.envelope.as_ref());
        require_accuracy("accuracy of a transient", accuracy)?;
        let ground = self.kept.ground(self.fine.mesh.domain(), self.fine.mesh.sides, accuracy);
        let [first, last] = [times.first(), times.last()].map(|time| time.copied().unwrap_or(0.0));
        let initial = Initial::new(start, &ground, envelope, (first, accuracy))?;
        check_times(times, initial.time, "a point has no density at once: take a later time")?;
        let degree = self.kept.grid.degree_for(self.fine.shape.states, accuracy, ground.grazed != [None; 2]);
        let plan = EvolutionPlan::new(envelope, accuracy, degree, &self.kept.grid);
        let plan = EvolutionPlan { most_spent, ..plan };
        let mut evolution = Evolution::new(plan, &ground, &initial, [&self.fine, &self.coarse], last)?;
        let at = |time: &f64| {
            evolution.advance(*time)?;
            let [fine, coarse] = evolution.fields.clone();
            let mut density = self.clone();
            // What a leak moves between wells grows with time to that of the stationary density.
            density.provenance.l1_estimate = Some(difference(&fine, &coarse) + self.changed() + initial.error);
            density.provenance.cells = Some(fine.mesh.cells.len());
            density.provenance.unknowns = Some(fine.coefficients.len());
            if let Some(reason) = evolution.exhausted {
                density.provenance.warning = Some(reason.into());
            }
            (density.fine, density.coarse) = (fine, coarse);
            if envelope.is_some() {
                density.require_inside()?;
            }
            let lost = (1.0 - density.fine.mass()).abs();
            let remedy = "the rest left the domain by its edges: start nearer to its middle, ask for an earlier time, or widen `Grid::domain`";
            require(lost <= LOST, "mass of a transient in the domain", density.fine.mass(), remedy)?;
            density.provenance.l1_estimate = density.provenance.l1_estimate.map(|estimate| estimate + lost);
            Ok(Transient { time: *time, density, step_error: evolution.error })
        };
        times.iter().map(at).collect()
    }

    /// The size of what changes with leaks and shares.
    pub(super) fn changed(&self) -> f64 {
        self.changes.iter().map(GridField::size).sum()
    }

    /// Refuses a density that the domain cuts, and enters the level at its edges.
    fn require_inside(&mut self) -> Result<()> {
        let accepted = CUT;
        self.edges = self.fine.at_edges();
        for &(state, side, level) in &self.edges {
            if level.is_nan() || level > accepted {
                let edge = self.fine.mesh.domain()[state][side];
                let reason = format!(
                    "at state {state} = {edge} the density is {level:.1e} of its peak, above the accepted {accepted:.1e}: the domain cuts it \
                     off, so widen `Grid::domain` or leave it out"
                );
                return Err(Error::NotResolved { estimate: f64::INFINITY, reason });
            }
        }
        self.provenance.edge_level = Some(self.edges.iter().map(|(.., level)| *level).fold(0.0, f64::max));
        Ok(())
    }
}
