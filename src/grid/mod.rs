//! High-order discontinuous Galerkin solution of the Fokker-Planck equation of two states.
//!
//! - `legendre`, `space`, `mesh`: polynomials, elements, mesh lines;
//! - `assembly`, `face`, `wall`: the matrix: volumes, faces between elements, rebounds;
//! - `sparse`: LU factors; `stationary`: the null vector of the matrix;
//! - `domain`: where the density is; `solver`: domain, mesh and two degrees for an error estimate;
//! - `field`, `density`: the piecewise polynomial and what it answers;
//! - `discretisation`, `relaxation`, `march`, `transient`: the spectrum next to zero and p(x, t) on the same matrix.

mod assembly;
mod density;
mod discretisation;
mod dissection;
mod domain;
mod face;
mod field;
mod legendre;
mod march;
mod mesh;
mod relaxation;
mod solver;
mod space;
mod sparse;
mod stationary;
mod transient;
mod wall;

pub use density::{GridDensity, GridProvenance};
pub use relaxation::Relaxation;
pub use transient::{Start, Transient};

use crate::error::{finite, positive};
use crate::{Barrier, Error, FokkerPlanck, PolynomialDrift, Result};
use std::time::Instant;

/// A discontinuous Galerkin method: tensor Legendre polynomials on a rectangular mesh, for systems of two states.
///
/// 0 = −∂_i(f_i p) + ½ ∂_i∂_j(B_ij p) is solved with upwind advection and the symmetric interior penalty for diffusion. For
/// a smooth density the error falls exponentially with the degree.
///
/// ```
/// use expoly::{Density, Grid, models::Duffing};
/// let density = Grid::new().solve(&Duffing::new(0.2, 1.0, 0.3, 0.2)?)?;
/// let second = density.moment([2, 0]);
/// assert!((second.value - 0.661714969204).abs() < 1e-7);
/// assert!(second.error < 1e-9 && density.provenance().l1_error < 1e-7);
/// # Ok::<(), expoly::Error>(())
/// ```
///
/// # Reference
/// B. Cockburn and C.-W. Shu, Runge-Kutta discontinuous Galerkin methods for convection-dominated problems, Journal of
/// Scientific Computing 16 (2001) 173-261, doi:10.1023/A:1012873910884.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    degree: Option<usize>,
    cells: Option<[usize; 2]>,
    domain: Option<[[f64; 2]; 2]>,
    edge_level: f64,
    grazing: f64,
}

impl Default for Grid {
    fn default() -> Self {
        Grid { degree: None, cells: None, domain: None, edge_level: 1e-10, grazing: 1e-3 }
    }
}

impl Grid {
    /// The method with the defaults named at each option.
    pub fn new() -> Self {
        Self::default()
    }

    /// The polynomials' degree in each state, 10 by default, 6 above a wall with r < 1; from 2 to 24.
    pub fn degree(self, degree: usize) -> Self {
        Grid { degree: Some(degree), ..self }
    }

    /// Cells along each state, [9, 10] by default, [8, 10] above a wall with r < 1; from 2 to 1000. Layers towards a grazing point come on top.
    pub fn cells(self, cells: [usize; 2]) -> Self {
        Grid { cells: Some(cells), ..self }
    }

    /// Lower and upper limit of each state. By default they are where the density has fallen to
    /// [`Grid::edge_level`]. A limit at a wall is replaced by the wall.
    pub fn domain(self, domain: [[f64; 2]; 2]) -> Self {
        Grid { domain: Some(domain), ..self }
    }

    /// How large the density may be at the domain's edge, relative to its peak: 1e-10 by default.
    ///
    /// A level up to the estimated L¹ error, and at most 1e-3, is accepted too: on a coarse mesh it is the error itself. A
    /// density with a power tail may end there; [`GridProvenance`] says at which level.
    /// What lies beyond is missing from moments, and their errors do not know of it: about 3e-10 of E x² and 3e-8 of
    /// E x⁶ for a Gaussian.
    pub fn edge_level(self, level: f64) -> Self {
        Grid { edge_level: level, ..self }
    }

    /// The smallest cell along the velocity next to a wall with r < 1, relative to the velocity's standard deviation, 1e-3
    /// by default.
    ///
    /// At the point (b, 0), where trajectories graze the wall, the density is singular. Moments of the displacement feel the
    /// fourth power of this number, impact rates its square.
    pub fn grazing(self, smallest: f64) -> Self {
        Grid { grazing: smallest, ..self }
    }

    /// The stationary density on the whole plane.
    ///
    /// # Errors
    /// - [`Error::OutOfRange`]: an option without a meaning;
    /// - [`Error::NotFinite`], [`Error::NoNoise`]: the system is not one;
    /// - [`Error::Exploded`], [`Error::DomainCut`]: the density does not end within any domain that was tried, or
    ///   within the one given: the drift has no stationary density, or the domain is too small;
    /// - [`Error::SingularSystem`]: more than one density is stationary, or none.
    pub fn solve<T: PolynomialDrift<2, M> + Sync, const M: usize>(&self, system: &T) -> Result<GridDensity> {
        self.run(system, [None, None])
    }

    /// The stationary density above a wall, y ≥ b, y′₊ = −r y′₋.
    ///
    /// # Errors
    /// As [`Grid::solve`], and [`Error::NotADisplacement`] if state 0 is not a displacement with state 1 as velocity.
    ///
    /// ```
    /// use expoly::{Barrier, Density, Grid, models::Duffing};
    /// let duffing = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
    /// let density = Grid::new().degree(4).solve_with_wall(&duffing, Barrier::new(0.0, 0.9)?)?;
    /// assert!((density.moment([1, 0]).value - 0.58490541).abs() < 1e-4);    // 2e-6 by the default degree
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn solve_with_wall<T: PolynomialDrift<2, M> + Sync, const M: usize>(
        &self,
        system: &T,
        barrier: Barrier,
    ) -> Result<GridDensity> {
        self.run(system, [Some(barrier), None])
    }

    /// The stationary density between two walls, `lower` and `upper`, each with its own restitution. The upper one throws
    /// back what comes with v > 0.
    ///
    /// # Errors
    /// As [`Grid::solve_with_wall`]; [`Error::OutOfRange`] unless the upper wall stands above the lower one.
    pub fn solve_between_walls<T: PolynomialDrift<2, M> + Sync, const M: usize>(
        &self,
        system: &T,
        lower: Barrier,
        upper: Barrier,
    ) -> Result<GridDensity> {
        let gap = upper.offset() - lower.offset();
        positive("distance from the lower to the upper wall", gap, "the upper wall must stand above the lower one")?;
        self.run(system, [Some(lower), Some(upper)])
    }

    fn run<T: PolynomialDrift<2, M> + Sync, const M: usize>(
        &self,
        system: &T,
        walls: [Option<Barrier>; 2],
    ) -> Result<GridDensity> {
        let begin = Instant::now();
        let (degree, cells) = self.validate(walls)?;
        let operator = FokkerPlanck::new(system)?;
        let displacement = operator.velocity_of(0) == Some(1);
        if walls.iter().any(Option::is_some) && !displacement {
            return Err(Error::NotADisplacement { velocity: 1 });
        }
        let (start, adjust) = match self.domain {
            Some(domain) => (domain, false),
            None => (domain::pilot(system, walls[0])?, true),
        };
        let mut density = solver::Solver { grid: self, degree, cells, operator: &operator, walls, displacement }
            .run(start, adjust)?;
        density.provenance.seconds = begin.elapsed().as_secs_f64();
        Ok(density)
    }

    /// Degree and cells, once every option has a meaning.
    fn validate(&self, walls: [Option<Barrier>; 2]) -> Result<(usize, [usize; 2])> {
        // The layers at a grazing point are many, and their density is singular: cheaper elements are better there.
        let grazed = walls.iter().flatten().any(|wall| wall.restitution() < 1.0);
        let (degree, cells) = if grazed { (6, [8, 10]) } else { (10, [9, 10]) };
        let (degree, cells) = (self.degree.unwrap_or(degree), self.cells.unwrap_or(cells));
        let range = |name, value: usize, least: usize, most: usize, remedy| {
            if (least..=most).contains(&value) {
                return Ok(());
            }
            Err(Error::OutOfRange { name, value: value as f64, remedy })
        };
        range("degree of the grid", degree, 2, 24, "it must lie between 2 and 24")?;
        for cells in cells {
            range("number of cells", cells, 2, 1000, "take between 2 and 1000 along each state")?;
        }
        let share = "it is a share and must lie between 0 and 1, both excluded";
        for (name, value) in [("edge level", self.edge_level), ("smallest cell at a grazing point", self.grazing)] {
            if !(value > 0.0 && value < 1.0) {
                return Err(Error::OutOfRange { name, value, remedy: share });
            }
        }
        for [low, high] in self.domain.into_iter().flatten() {
            finite("limit of the domain", low)?;
            finite("limit of the domain", high)?;
            positive("side of the domain", high - low, "give lower and upper limits in this order")?;
        }
        Ok((degree, cells))
    }
}
