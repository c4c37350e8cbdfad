//! High-order discontinuous Galerkin solution of the Fokker-Planck equation of two states.
//!
//! - `legendre`, `space`, `mesh`: polynomials, elements, mesh lines;
//! - `flux`: the operator at a point; `blocks`, `assembly`, `face`, `wall`: the matrix: volumes, faces between elements,
//!   rebounds;
//! - `sparse`: the matrix by entries; `dissection`: the order of elimination; `condensation`, `elimination`, `panel`: LU factors of
//!   the unknowns within elements, of those at faces, and of a group of them;
//! - `stationary`: the null vector of the matrix;
//! - `domain`: where the density is; `layout`: its elements; `solver`: domain, mesh and two degrees for an error estimate;
//! - `field`, `density`: the piecewise polynomial, and the density made of it; `sensitivity`: its derivatives by parameters;
//! - `relaxation`, `march`: the spectrum next to zero and steps in time on the same matrix;
//! - `initial`, `transient`: a start on the mesh and p(x, t); `survival`: the part of it that has passed no level.

mod assembly;
mod blocks;
mod condensation;
mod density;
mod dissection;
mod domain;
mod elimination;
mod face;
mod field;
mod flux;
mod initial;
mod layout;
mod legendre;
mod march;
mod mesh;
mod panel;
mod relaxation;
mod sensitivity;
mod solver;
mod space;
mod sparse;
mod stationary;
mod survival;
mod transient;
mod tuning;
mod wall;

pub use density::GridDensity;
pub use sensitivity::GridSensitivity;
pub use survival::Survival;

use crate::checks::{finite, positive, require};
use crate::error::{Error, Result};
use crate::memory::MemoryLimit;
use crate::problem::{PlaneMotion, Problem, Wall};
use field::Field;
use solver::Solver;
use std::time::Instant;

/// A discontinuous Galerkin method: tensor Legendre polynomials on a rectangular mesh, for problems of two states.
///
/// 0 = −∂_i(f_i p) + ½ ∂_i∂_j(B_ij p) is solved with upwind advection and the symmetric interior penalty for diffusion. For
/// a smooth density the error falls exponentially with the degree.
///
/// ```
/// use expoly::{Density, Grid, models::{Duffing, Solved}};
/// let density = Grid::new().solve(&Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?)?;
/// let second = density.moment(&[2, 0])?;
/// assert!((second.value - 0.661714969204).abs() < 1e-7);
/// assert!(second.error < 1e-9 && density.l1_estimate() < 1e-7);
/// # Ok::<(), expoly::Error>(())
/// ```
///
/// # Reference
/// B. Cockburn and C.-W. Shu, Runge-Kutta discontinuous Galerkin methods for convection-dominated problems, Journal of
/// Scientific Computing 16 (2001) 173-261, doi:10.1023/A:1012873910884.
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use = "options return the value with the option; nothing happens before it is used"]
pub struct Grid {
    degree: Option<usize>,
    cells: Option<[usize; 2]>,
    domain: Option<[[f64; 2]; 2]>,
    edge_level: f64,
    grazing: f64,
    memory: MemoryLimit,
}

impl Default for Grid {
    fn default() -> Self {
        Grid {
            degree: None,
            cells: None,
            domain: None,
            edge_level: 1e-10,
            grazing: 1e-3,
            memory: MemoryLimit::default(),
        }
    }
}

impl Grid {
    /// The method with the defaults named at each option.
    pub fn new() -> Self {
        Self::default()
    }

    /// The polynomials' degree in each state, 10 by default, 7 above a wall with r < 1; from 2 to 24.
    pub fn degree(self, degree: usize) -> Self {
        Grid { degree: Some(degree), ..self }
    }

    /// Cells along each state, [9, 10] by default, [8, 10] above a wall with r < 1; from 2 to 1000. Layers towards a
    /// grazing point come on top.
    pub fn cells(self, cells: [usize; 2]) -> Self {
        Grid { cells: Some(cells), ..self }
    }

    /// Lower and upper limit of each state. By default they are where the density has fallen to
    /// [`Grid::edge_level`]. A limit at a wall is replaced by the wall.
    pub fn domain(self, domain: [[f64; 2]; 2]) -> Self {
        Grid { domain: Some(domain), ..self }
    }

    /// The largest density at the domain's edge, relative to its peak: 1e-10 by default.
    ///
    /// A level up to the estimated L¹ error, and at most 1e-3, is accepted too: on a coarse mesh it is the error itself. A
    /// density with a power tail may end there; [`Provenance::edge_level`](crate::Provenance::edge_level) is the level
    /// reached. The part beyond is missing from moments, about 3e-10 of E x² and 3e-8 of E x⁶ for a Gaussian; an estimate of
    /// it is part of their errors.
    pub fn edge_level(self, level: f64) -> Self {
        Grid { edge_level: level, ..self }
    }

    /// The smallest cell along the velocity next to a wall with r < 1, relative to the velocity's standard deviation, 1e-3
    /// by default.
    ///
    /// At the point (b, 0), where trajectories graze the wall, the density is singular. The error of impact rates
    /// falls with a power of this number, 2 for r near 1, 1.5 for r = 0.7 and 1 for r = 0.5, that of moments faster. The error
    /// that an impact rate carries contains it.
    pub fn grazing(self, smallest: f64) -> Self {
        Grid { grazing: smallest, ..self }
    }

    /// The memory that matrix and factors may take, 8 GiB by default. They are estimated before they are allocated: 50 000
    /// unknowns take half a gibibyte to one.
    pub fn memory_limit(self, gibibytes: f64) -> Self {
        Grid { memory: MemoryLimit::gibibytes(gibibytes), ..self }
    }

    /// The stationary density of a problem of two states: on the whole plane, or where the walls of a displacement leave
    /// it, below, above or on both sides, each with its own restitution.
    ///
    /// # Errors
    /// - [`Error::NotServed`]: a problem of another number of states, a wall on state 1, or impulses;
    /// - [`Error::OutOfRange`]: an option without a meaning;
    /// - [`Error::Exploded`], [`Error::DomainCut`]: the density does not end within any domain that was tried, or
    ///   within the one given: the drift has no stationary density, or the domain is too small;
    /// - [`Error::Unreached`]: a state that no noise reaches; [`Error::Rests`]: a wall that trajectories come to rest on;
    /// - [`Error::SingularSystem`]: more than one density is stationary, or none;
    /// - [`Error::Negative`]: a tenth of the solution is below zero, since the mesh does not resolve the density;
    /// - [`Error::TooMuchMemory`]: a mesh beyond [`Grid::memory_limit`].
    ///
    /// ```
    /// use expoly::{Density, Grid, Wall, models::{Duffing, Solved}};
    /// let duffing = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?;
    /// let density = Grid::new().degree(4).solve(&duffing.with_wall(Wall::above(0.0, 0.9)?)?)?;
    /// assert!((density.moment(&[1, 0])?.value - 0.58490541).abs() < 1e-4);    // 1e-8 by the default degree
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn solve(&self, problem: &Problem) -> Result<GridDensity> {
        Ok(self.solved(problem, &[])?.0)
    }

    /// The stationary density, and its derivatives by some parameters of the problem ([`Problem::parameters`]), those of walls
    /// among them.
    ///
    /// The derivative p′ solves L p′ = −L′p with the integral 0: each takes the matrix of L′ and one solution with the factors that
    /// the density has made. Upwind sides and the mesh are held, and the mesh moves with a wall whose offset is the parameter, so
    /// that the result is the derivative of the discrete solution itself. At r = 1 the one by r is that towards r < 1.
    ///
    /// # Errors
    /// As [`Grid::solve`]; [`Error::NotAName`] for a name that no parameter has, [`Error::NotKnown`] and [`Error::NotServed`] where
    /// the problem has no derivative by it.
    ///
    /// ```
    /// use expoly::{Grid, Wall, models::{Duffing, Solved}};
    /// let problem = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?.with_wall(Wall::above(-0.5, 1.0)?)?;
    /// let (density, by) = Grid::new().degree(6).sensitivities(&problem, &["D", "x.above.offset"])?;
    /// // p = C exp(−(c/D) H) where the wall leaves room: E v² = D/c.
    /// assert!((by[0].moment(&[0, 2])?.value - 5.0).abs() < 1e-3 && by[1].moment(&[0, 2])?.value.abs() < 1e-3);
    /// assert!(by[1].moment(&[1, 0])?.value > 0.0 && density.impact_rate() == by[1].density().impact_rate());
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn sensitivities(&self, problem: &Problem, parameters: &[&str]) -> Result<(GridDensity, Vec<GridSensitivity>)> {
        self.served(problem)?;
        let motion = |name: &&str| Ok(problem.motion(name)?.on_plane(problem));
        let motions: Vec<PlaneMotion> = parameters.iter().map(motion).collect::<Result<_>>()?;
        let (density, derivatives) = self.solved(problem, &motions)?;
        let all = parameters.iter().zip(motions).zip(derivatives);
        let found = all.map(|((name, motion), moved)| GridSensitivity::new(&density, name, motion, moved)).collect();
        Ok((density, found))
    }

    /// The walls of a problem that is served.
    fn served(&self, problem: &Problem) -> Result<[Option<Wall>; 2]> {
        if problem.dimension() != 2 {
            let (what, remedy) = ("a problem of other than two states", "take the closure or the simulation");
            return Err(Error::NotServed { method: "grid", what, remedy });
        }
        problem.require_no_impulses("grid")?;
        problem.require_no_rest()?;
        problem.walls_of_plane("grid")
    }

    /// The density, and its derivatives along some motions in the order of [`GridDensity::solutions`].
    fn solved(&self, problem: &Problem, motions: &[PlaneMotion]) -> Result<(GridDensity, Vec<[Field; 3]>)> {
        let begin = Instant::now();
        let walls = self.served(problem)?;
        self.memory.check()?;
        let mut solver = Solver { grid: self, degree: 0, cells: [0; 2], problem, walls, motions };
        (solver.degree, solver.cells) = self.validate([0, 1].iter().any(|side| solver.grazed(*side)))?;
        problem.operator().require_reached(&[])?;
        let (start, adjust) = match self.domain {
            Some(domain) => (domain, false),
            None => (domain::pilot(problem, walls)?, true),
        };
        let (mut density, derivatives) = solver.run(start, adjust)?;
        density.provenance.seconds = begin.elapsed().as_secs_f64();
        Ok((density, derivatives))
    }

    /// Degree and cells, by default those of a mesh with grazing points or of one without.
    fn resolution(&self, grazed: bool) -> (usize, [usize; 2]) {
        // There are many layers at a grazing point: cheaper elements are better.
        let (degree, cells) = if grazed { (7, [8, 10]) } else { (10, [9, 10]) };
        (self.degree.unwrap_or(degree), self.cells.unwrap_or(cells))
    }

    /// Degree and cells, once every option has a meaning.
    fn validate(&self, grazed: bool) -> Result<(usize, [usize; 2])> {
        let (degree, cells) = self.resolution(grazed);
        require((2..=24).contains(&degree), "degree of the grid", degree as f64, "it must lie between 2 and 24")?;
        for cells in cells {
            let remedy = "take between 2 and 1000 along each state";
            require((2..=1000).contains(&cells), "number of cells", cells as f64, remedy)?;
        }
        let share = "it is a share and must lie between 0 and 1, both excluded";
        for (name, value) in [("edge level", self.edge_level), ("smallest cell at a grazing point", self.grazing)] {
            require(value > 0.0 && value < 1.0, name, value, share)?;
        }
        for [low, high] in self.domain.into_iter().flatten() {
            finite("limit of the domain", low)?;
            finite("limit of the domain", high)?;
            positive("side of the domain", high - low, "give lower and upper limits in this order")?;
        }
        Ok((degree, cells))
    }
}
