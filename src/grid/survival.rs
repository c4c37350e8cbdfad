//! First passages: the part of a density that has passed no level.

use super::assembly::Discretisation;
use super::density::GridDensity;
use super::field::Field;
use super::initial::Initial;
use super::layout::Layout;
use super::relaxation::slowest;
use super::space::{Side, Space};
use super::transient::{Plan, Steps};
use crate::checks::{positive, require};
use crate::envelope::Envelope;
use crate::error::{Error, Result};
use crate::estimate::Estimate;
use crate::grid::tuning;
use crate::transient::{Start, check_times};

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
    /// The elements of two degrees between the levels.
    spaces: [Space; 2],
}

impl GridDensity {
    /// The survival of the displacement `within` a lower and an upper level; an infinite one is none. Walls between the levels
    /// stay; a level beyond the domain's edge is never passed, but for what leaks there.
    ///
    /// The mesh is finer towards the points (level, 0), where trajectories graze a level, by [`Grid::grazing`](crate::Grid::grazing).
    ///
    /// # Errors
    /// [`Error::NotADisplacement`] unless the second state is the velocity of the first; [`Error::OutOfRange`] for levels that
    /// are not numbers, or that leave no room in the domain.
    ///
    /// ```
    /// use expoly::{Grid, Start, models::{Duffing, Solved}};
    /// let density = Grid::new().degree(5).grazing(1e-2).solve(&Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?)?;
    /// let below = density.survival([f64::NEG_INFINITY, 1.6269])?; // 2σ
    /// let found = below.probability(&Start::Stationary, &[0.0, 20.0], 1e-3)?;
    /// assert!((found[0].value - 0.98122).abs() < 1e-4 && (found[1].value - 0.60285).abs() < 1e-4);
    /// assert!((below.rate()?.value - 0.022647).abs() < 1e-5); // P(T > t) ~ exp(−rate t)
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn survival(&self, within: [f64; 2]) -> Result<Survival> {
        if self.problem.velocity_of(0) != Some(1) {
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
        let mut domain = self.domain;
        let whole = domain[0][1] - domain[0][0];
        let absorbs = [low > domain[0][0], high < domain[0][1]];
        (0..2).filter(|&side| absorbs[side]).for_each(|side| domain[0][side] = within[side]);
        let width = domain[0][1] - domain[0][0];
        let remedy = "the levels leave the density no room: it lies beyond them";
        require(width > 0.0, "room between the levels in the domain", width, remedy)?;

        let walls = self.problem.walls_of_plane("grid")?;
        let lossy = [0, 1].map(|side| !absorbs[side] && walls[side].is_some_and(|wall| wall.restitution() < 1.0));
        let coarser = if lossy == [false, false] { tuning::mesh::LEVEL } else { 1.0 };
        let layout = Layout {
            problem: &self.problem,
            walls: [0, 1].map(|side| walls[side].filter(|_| !absorbs[side])),
            grazed: [0, 1].map(|side| absorbs[side] || lossy[side]),
            grazing: (coarser * self.grid.grazing).min(1.0),
        };
        let (degree, [columns, rows]) = self.grid.resolution(true);
        // As wide as they were, but for those of a narrow strip.
        let columns = ((columns as f64 * width / whole).ceil() as usize).max(tuning::mesh::FEWEST);
        let mut fine = layout.space(domain, degree, [columns, rows]);
        (0..2).filter(|&side| absorbs[side]).for_each(|side| fine.sides[side] = Side::Level);
        let coarse = Space { degree: degree - 1, ..fine.clone() };
        Ok(Survival { stationary: self.clone(), within, spaces: [fine, coarse] })
    }
}

impl Survival {
    /// The lower and the upper level.
    pub fn within(&self) -> [f64; 2] {
        self.within
    }

    /// The coefficients of the density on the mesh.
    pub fn unknowns(&self) -> usize {
        self.spaces[0].unknowns()
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
        let slowest = |space: &Space| {
            let modes = slowest(&self.operator(space)?, 0.0, 1)?;
            let singular = Error::SingularSystem { unknowns: space.unknowns() };
            modes.first().map(|mode| Estimate::new(mode.rate, mode.error)).ok_or(singular)
        };
        let [fine, coarse] = self.both(|space, _| slowest(space))?;
        Ok(Estimate::new(fine.value, (fine.value - coarse.value).abs() + fine.error + self.leak()))
    }

    /// The mean time to the first passage, E T = ∫ P(T > t) dt.
    ///
    /// # Errors
    /// As [`GridDensity::transient`]; [`Error::SingularSystem`] if nothing leaves through the levels.
    pub fn mean_time(&self, start: &Start) -> Result<Estimate> {
        let initial = self.initial(start, None)?;
        let [fine, coarse] = self.both(|space, stationary| {
            let field = initial.field(stationary, space)?;
            let before = initial.time * field.mass();
            let spent = self.operator(space)?.shifted(0.0).solve(&field.coefficients)?;
            Ok(before + Field { space: space.clone(), coefficients: spent }.mass())
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
        let [fine, coarse] = self.both(|space, stationary| {
            let field = initial.field(stationary, space)?;
            let start = (field.mass(), Steps { error: 0.0, mass: 0.0 });
            let marched = self.stationary.marched(&plan, initial.time, field)?;
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
        self.stationary.initial(start, &self.spaces[0], envelope)
    }

    fn operator(&self, space: &Space) -> Result<Discretisation> {
        Discretisation::new(&self.stationary.problem, space, self.stationary.grid.memory)
    }

    /// The probability that leaves through the domain's edges per unit time.
    fn leak(&self) -> f64 {
        self.stationary.provenance.leak.unwrap_or(0.0).abs()
    }

    /// An answer for each of the two degrees, from the elements and the stationary density of that degree.
    fn both<T: Send>(&self, answer: impl Fn(&Space, &Field) -> Result<T> + Sync) -> Result<[T; 2]> {
        let [fine, coarse] = &self.spaces;
        let (fine, coarse) =
            rayon::join(|| answer(fine, &self.stationary.fine), || answer(coarse, &self.stationary.coarse));
        Ok([fine?, coarse?])
    }
}
