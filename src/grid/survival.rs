//! First passages: the part of a density that has passed no level.

use super::density::GridDensity;
use super::field::Field;
use super::flux::Part;
use super::initial::Initial;
use super::mesh::Side;
use super::operator::{Layout, Operator, Regular};
use super::refinement::{indicator, refined};
use super::relaxation::slowest;
use super::start::Ground;
use super::transient::{Plan, Steps};
use crate::checks::{positive, require};
use crate::envelope::Envelope;
use crate::error::{Error, Result};
use crate::estimate::Estimate;
use crate::grid::kept::Kept;
use crate::grid::tuning;
use crate::problem::{Problem, TimeScales};
use crate::transient::{Start, check_times};
use std::sync::Arc;

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
    /// let found = below.probability(&Start::Stationary, &[0.0, 20.0], 1e-3)?;
    /// assert!((found[0].value - 0.98122).abs() < 1e-4 && (found[1].value - 0.60285).abs() < 1e-4);
    /// assert!((below.rate()?.value - 0.022647).abs() < 1e-5); // P(T > t) ~ exp(−rate t)
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn survival(&self, within: [f64; 2]) -> Result<Survival> {
        if self.fine.shape.states == 2 && self.kept.problem.velocity_of(0) != Some(1) {
            return Err(Error::NotADisplacement { state: 0 });
        }
        let [low, high] = within;
        for level in within {
            require(!level.is_nan(), "level", level, "it must be a number, or infinite where there is none")?;
        }
        positive(
            "room between the levels",
            (high - low).min(f64::MAX),
            "give a lower and an upper level in this order",
        )?;
        let mut domain = self.fine.mesh.domain();
        let absorbs = [low > domain[0][0], high < domain[0][1]];
        (0..2).filter(|&side| absorbs[side]).for_each(|side| domain[0][side] = within[side]);
        let width = domain[0][1] - domain[0][0];
        let remedy = "the levels leave the density no room: it lies beyond them";
        require(width > 0.0, "room between the levels in the domain", width, remedy)?;

        let walls = self.kept.walls;
        let lossy = [0, 1].map(|side| !absorbs[side] && walls[side].is_some_and(|wall| wall.restitution() < 1.0));
        let sides = [0, 1].map(|side| match walls[side] {
            _ if absorbs[side] => Side::Level,
            Some(wall) => Side::Wall(wall.restitution()),
            None => Side::Open,
        });
        let grazed = [0, 1].map(|side| absorbs[side] || lossy[side]);
        let Kept { problem, pilot, grid, .. } = &*self.kept;
        let ground = Ground { problem, pilot, domain, sides, grazed };
        let degree = grid.degree_for(true);
        let mut layout = Layout::new(ground.mesh());
        // What starts as the stationary density and leaves through the levels, per unit of its mass.
        for _ in 0..tuning::refinement::ROUNDS {
            let operator = Operator::new(problem, &layout, degree, Part::Whole, grid.memory)?;
            let start = self.fine.carried(&layout.mesh, operator.shape);
            let shift = 1.0 / pilot_time(problem)?;
            let spent = operator.factors(Regular::Shift(shift)).solve(&start.coefficients, None)?.inner;
            let scaled = spent.iter().map(|s| s * shift).collect();
            let field = Field { coefficients: scaled, ..start };
            let aim = grid.accuracy;
            let next = if indicator(&field) <= aim { None } else { refined(&field, aim) };
            match next.map(Layout::new) {
                Some(finer) if finer.fits(operator.shape, grid.memory).is_ok() => layout = finer,
                _ => break,
            }
        }
        let of = |degree: usize| Operator::new(problem, &layout, degree, Part::Whole, grid.memory);
        let operators = Arc::new([of(degree)?, of(degree - 1)?]);
        Ok(Survival { stationary: self.clone(), within, operators })
    }
}

/// The time in which a problem forgets its start.
fn pilot_time(problem: &Problem) -> Result<f64> {
    Ok(TimeScales::of(problem)?.memory())
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

    /// P(T > t) at rising `times` t ≥ 0 after `start`. Of the stationary density, or of a Gaussian, the part beyond the
    /// levels has passed them at t = 0. Each step may err by `tolerance`, relative to the root mean square of the density: 1e-4
    /// is a good value.
    ///
    /// # Errors
    /// As [`GridDensity::transient`].
    pub fn probability(&self, start: &Start, times: &[f64], tolerance: f64) -> Result<Vec<Estimate>> {
        self.remaining(None, start, times, tolerance)
    }

    /// The same under modulated noise.
    ///
    /// # Errors
    /// As [`GridDensity::modulated_transient`].
    pub fn modulated_probability(
        &self,
        envelope: &Envelope,
        start: &Start,
        times: &[f64],
        tolerance: f64,
    ) -> Result<Vec<Estimate>> {
        self.remaining(Some(envelope), start, times, tolerance)
    }

    /// The rate ν of P(T > t) ~ exp(−ν t) for large t: the slowest eigenvalue, and the same for all starts. Its inverse is
    /// the mean time to the first passage once the start is forgotten.
    ///
    /// # Errors
    /// [`Error::SingularSystem`] if nothing leaves through the levels.
    pub fn rate(&self) -> Result<Estimate> {
        let [fine, coarse] = &*self.operators;
        let modes = slowest([fine, coarse], 0.0, 1)?;
        let singular = Error::SingularSystem { unknowns: fine.unknowns() };
        modes.first().map(|mode| Estimate::new(mode.rate, mode.error + self.leak())).ok_or(singular)
    }

    /// The mean time to the first passage, E T = ∫ P(T > t) dt.
    ///
    /// # Errors
    /// As [`GridDensity::transient`]; [`Error::SingularSystem`] if nothing leaves through the levels.
    pub fn mean_time(&self, start: &Start) -> Result<Estimate> {
        let initial = self.initial(start, None)?;
        let [fine, coarse] = self.both(|operator, stationary| {
            let field = initial.field(stationary, &operator.layout.mesh, operator.shape)?;
            let before = initial.time * field.mass();
            let spent = operator.factors(Regular::Shift(0.0)).solve(&field.coefficients, None)?.inner;
            Ok(before + Field { coefficients: spent, ..field }.mass())
        })?;
        Ok(Estimate::new(fine, (fine - coarse).abs() + fine * fine * self.leak()))
    }

    fn remaining(
        &self,
        envelope: Option<&Envelope>,
        start: &Start,
        times: &[f64],
        tolerance: f64,
    ) -> Result<Vec<Estimate>> {
        check_times(times, 0.0, "it must not be negative")?;
        // The density has passed nothing until the mesh resolves it.
        let initial = self.initial(start, envelope)?;
        let early = times.partition_point(|time| *time <= initial.time);
        let plan = Plan::new(envelope, &times[early..], tolerance)?;
        let [fine, coarse] = self.both(|operator, stationary| {
            let field = initial.field(stationary, &operator.layout.mesh, operator.shape)?;
            let start = (field.mass(), Steps { error: 0.0, mass: 0.0 });
            let marched = self.stationary.marched(&plan, initial.time, field, &operator.layout, Some(operator))?;
            let later = marched.into_iter().map(|(field, steps)| (field.mass(), steps));
            Ok(std::iter::repeat_n(start, early).chain(later).collect::<Vec<_>>())
        })?;
        let estimate = |k: usize| {
            let (mass, steps) = fine[k];
            Estimate::new(mass, (mass - coarse[k].0).abs() + steps.mass.abs() + self.leak() * times[k])
        };
        Ok((0..times.len()).map(estimate).collect())
    }

    fn initial(&self, start: &Start, envelope: Option<&Envelope>) -> Result<Initial> {
        self.stationary.initial(start, &self.operators[0].layout.mesh, envelope)
    }

    /// The probability that leaves through the domain's edges per unit time.
    fn leak(&self) -> f64 {
        self.stationary.provenance.leak.unwrap_or(0.0).abs()
    }

    /// An answer for each of the two degrees, from the operator and the stationary density of that degree.
    fn both<T: Send>(&self, answer: impl Fn(&Operator, &Field) -> Result<T> + Sync) -> Result<[T; 2]> {
        let [fine, coarse] = &*self.operators;
        let (fine, coarse) =
            rayon::join(|| answer(fine, &self.stationary.fine), || answer(coarse, &self.stationary.coarse));
        Ok([fine?, coarse?])
    }
}
