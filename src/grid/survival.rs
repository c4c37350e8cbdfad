//! First passages: the part of a density that has passed no level.

use super::density::{GridDensity, estimate};
use super::evolution::{Evolution, EvolutionPlan};
use super::factors::Regular;
use super::field::GridField;
use super::flux::Part;
use super::initial::Initial;
use super::mesh::{Mesh, Side, Sides};
use super::operator::{Layout, Operator};
use super::refinement::{Finer, finer};
use super::relaxation::slowest;
use super::shape::Shape;
use crate::checks::require;
use crate::error::{Error, Result};
use crate::estimate::Estimate;
use crate::grid::kept::Kept;
use crate::grid::{GridProgress, ROUNDS, require_accuracy, singular};
use crate::problem::TimeScales;
use crate::transient::{Course, Start, check_limits, check_times};
use std::sync::Arc;

/// Rates and mean times have the smallest cells at a grazing point: two degrees do not show what larger ones are off by.
const FINEST: f64 = 0.0;

/// The survival of a displacement that must pass no level: P(T > t) for the time T of its first passage, without Poisson's
/// assumption that passages are independent of each other.
///
/// It is the mass that remains of a density between absorbing levels: trajectories leave through a level, and none comes
/// back. Its errors are the differences between two degrees, the time steps' share and what leaks through the domain's edges.
///
/// # Reference
/// L. A. Bergman and J. C. Heinrich, On the reliability of the linear oscillator and systems of coupled oscillators,
/// International Journal for Numerical Methods in Engineering 18 (1982) 1271-1295, doi:10.1002/nme.1620180902.
#[derive(Clone, Debug)]
pub struct Survival {
    stationary: GridDensity,
    within: [f64; 2],
    domain: Vec<[f64; 2]>,
    sides: Sides,
    /// The operators of two degrees between the levels.
    operators: Arc<[Operator; 2]>,
}

impl GridDensity {
    /// The survival of the displacement `within` a lower and an upper level; an infinite one is none. Walls between the levels
    /// stay; a level beyond the domain's edge is never passed, but for what leaks there.
    ///
    /// The mesh is finer towards the points (level, 0), where trajectories graze a level, and where the time spent between the levels
    /// is not resolved.
    ///
    /// # Errors
    /// [`Error::NotADisplacement`] unless the second state is the velocity of the first; [`Error::OutOfRange`] for levels that
    /// are not numbers, or that leave no room in the domain.
    ///
    /// ```
    /// use expoly::{Grid, Start, models::{Duffing, Solved}};
    /// let density = Grid::new().accuracy(1e-4).solve(&Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?)?;
    /// let below = density.survival([f64::NEG_INFINITY, 1.6269])?; // 2σ
    /// let found = below.probability(Start::Stationary, &[0.0, 20.0], 1e-3)?;
    /// assert!((found[0].value - 0.98122).abs() < 1e-4 && (found[1].value - 0.60285).abs() < 1e-4);
    /// assert!((below.rate()?.value - 0.022647).abs() < 1e-5); // P(T > t) ~ exp(−rate t)
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn survival(&self, within: [f64; 2]) -> Result<Survival> {
        if self.shear.is_some() {
            let what = "survival where the density is so thin that its states were sheared";
            let remedy = "take the simulation";
            return Err(Error::NotServed { method: "grid", what, remedy });
        }
        if self.fine.shape.states > 1 && self.kept.problem.velocity_of(0) != Some(1) {
            return Err(Error::NotADisplacement { state: 0 });
        }
        let [low, high] = within;
        check_limits(within)?;
        let mut domain = self.fine.mesh.domain();
        let absorbs = [low > domain[0][0], high < domain[0][1]];
        (0..2).filter(|&side| absorbs[side]).for_each(|side| domain[0][side] = within[side]);
        let width = domain[0][1] - domain[0][0];
        let remedy = "the levels leave the density no room: it lies beyond them";
        require(width > 0.0, "room between the levels in the domain", width, remedy)?;

        let mut sides = self.fine.mesh.sides;
        (0..2).filter(|&side| absorbs[side]).for_each(|side| sides[0][side] = Side::Level);
        let ground = self.kept.ground(domain.clone(), sides, FINEST);
        // What starts as the stationary density and leaves through the levels.
        let operators =
            resolved(&self.kept, Layout::new(ground.mesh()), |mesh, shape| Ok(self.fine.carried(mesh, shape)))?;
        Ok(Survival { stationary: self.clone(), within, domain, sides, operators: Arc::new(operators) })
    }
}

/// The operators of two degrees on a mesh, from `layout` on, that resolves the time which a density spends within its domain.
fn resolved(
    kept: &Kept,
    mut layout: Layout,
    start: impl Fn(&Arc<Mesh>, Shape) -> Result<GridField>,
) -> Result<[Operator; 2]> {
    let Kept { problem, grid, .. } = kept;
    let accuracy = grid.target(problem.dimension());
    let degree = grid.degree_for(problem.dimension(), accuracy, true);
    let shift = 1.0 / TimeScales::of(problem)?.memory();
    for rounds in 0..ROUNDS {
        let cells = layout.mesh.cells.len();
        grid.report(|| GridProgress { rounds, cells, ..GridProgress::default() })?;
        let operator = Operator::new(problem, &layout, degree, Part::Whole, grid.memory)?;
        let start = start(&layout.mesh, operator.shape)?;
        let spent = operator.factors(Regular::Shift(shift)).solve(&start.coefficients, None)?.field;
        // Per unit of what starts.
        match finer(&spent.times(shift), accuracy, grid.memory) {
            Finer::Layout(finer) => layout = finer,
            _ => return Ok([operator, Operator::new(problem, &layout, degree - 1, Part::Whole, grid.memory)?]),
        }
    }
    let of = |degree: usize| Operator::new(problem, &layout, degree, Part::Whole, grid.memory);
    Ok([of(degree)?, of(degree - 1)?])
}

impl Survival {
    /// The lower and the upper level.
    pub fn within(&self) -> [f64; 2] {
        self.within
    }

    /// The coefficients of the density on the mesh.
    pub fn unknowns(&self) -> usize {
        self.operators[0].unknowns()
    }

    /// P(T > t) at rising `times` t ≥ 0 after the start. Of the stationary density, or of a Gaussian, the part beyond the
    /// levels has passed them at t = 0. Mesh and steps follow the density as in [`GridDensity::transient`].
    ///
    /// # Errors
    /// As [`GridDensity::transient`].
    pub fn probability(&self, course: impl Into<Course>, times: &[f64], accuracy: f64) -> Result<Vec<Estimate>> {
        self.remaining(&course.into(), times, accuracy)
    }

    /// The rate ν of P(T > t) ~ exp(−ν t) for large t: the slowest eigenvalue, and the same for all starts. Its inverse is
    /// the mean time to the first passage once the start is forgotten.
    ///
    /// # Errors
    /// [`Error::NotResolved`] if nothing leaves through the levels.
    pub fn rate(&self) -> Result<Estimate> {
        let [fine, coarse] = &*self.operators;
        let modes = slowest([fine, coarse], 0.0, 1)?;
        let singular = singular(fine.unknowns());
        modes.first().map(|mode| Estimate::new(mode.rate, mode.error + self.leak())).ok_or(singular)
    }

    /// The mean time to the first passage, E T = ∫ P(T > t) dt.
    ///
    /// # Errors
    /// As [`GridDensity::transient`]; [`Error::NotResolved`] if nothing leaves through the levels.
    pub fn mean_time(&self, start: &Start) -> Result<Estimate> {
        let kept = &self.stationary.kept;
        let target = kept.grid.target(kept.problem.dimension());
        let ground = kept.ground(self.domain.clone(), self.sides, FINEST);
        let initial = Initial::new(start, &ground, None, (f64::INFINITY, target))?;
        let stationary = [&self.stationary.fine, &self.stationary.coarse];
        let [shape, _] = self.shapes();
        let (layout, ..) = initial.held(&ground, stationary[0], (shape, kept.grid.memory), target)?;
        let operators = resolved(kept, layout, |mesh, shape| initial.field(stationary[0], mesh, shape))?;
        let spent = |number: usize| -> Result<f64> {
            let operator: &Operator = &operators[number];
            let field = initial.field(stationary[number], &operator.layout.mesh, operator.shape)?;
            let before = initial.time * field.mass();
            let spent = operator.factors(Regular::Shift(0.0)).solve(&field.coefficients, None)?.field;
            Ok(before + spent.mass())
        };
        let (fine, coarse) = rayon::join(|| spent(0), || spent(1));
        let (fine, coarse) = (fine?, coarse?);
        Ok(Estimate::new(fine, (fine - coarse).abs() + fine * (initial.error + fine * self.leak())))
    }

    fn remaining(&self, course: &Course, times: &[f64], accuracy: f64) -> Result<Vec<Estimate>> {
        let (start, envelope) = (&course.start, course.envelope.as_ref());
        check_times(times, 0.0, "it must not be negative")?;
        require_accuracy("accuracy of a survival", accuracy)?;
        let kept = &self.stationary.kept;
        let ground = kept.ground(self.domain.clone(), self.sides, accuracy);
        let initial = Initial::new(start, &ground, envelope, (f64::INFINITY, accuracy))?;
        let [shape, _] = self.shapes();
        let plan = EvolutionPlan::new(envelope, accuracy, shape.degree, &kept.grid);
        let stationary = [&self.stationary.fine, &self.stationary.coarse];
        let mut evolution = Evolution::new(plan, &ground, &initial, stationary, times.last().copied().unwrap_or(0.0))?;
        let at = |time: &f64| {
            // A point has passed nothing before it has a density.
            evolution.advance(*time)?;
            let left = estimate(evolution.fields.each_ref(), &[], GridField::mass);
            let error = left.error + evolution.moved + evolution.unresolved();
            Ok(Estimate::new(left.value, error + initial.error + self.leak() * time))
        };
        times.iter().map(at).collect()
    }

    fn shapes(&self) -> [Shape; 2] {
        self.operators.each_ref().map(|operator| operator.shape)
    }

    /// The probability that leaves through the domain's edges per unit time.
    fn leak(&self) -> f64 {
        self.stationary.provenance.leak.unwrap_or(0.0).abs()
    }
}
