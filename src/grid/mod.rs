//! High-order discontinuous Galerkin solution of the Fokker-Planck equation of one state to three.
//!
//! - `legendre`, `shape`: polynomials, and their products on a cell;
//! - `tree`, `mesh`: cells as leaves of a tree, and the faces between them;
//! - `flux`: the operator at a point; `sides`: what passes the sides of a cell; `forms`: the matrices of a cell and its faces; `operator`: those of all cells, and K + s;
//! - `dissection`: the order of elimination; `elimination`, `panel`: LU factors of the unknowns of cells, of faces, of a group;
//! - `iteration`: in three states the unknowns of faces by `krylov`'s method, after `incomplete` factors in `drift_order`; `factors`: which of both;
//! - `pilot`, `start`: where the density is, and the first mesh; `stationary`: the null vector of K, by `pins`, with `wells` that hardly
//!   mix; `marking`, `refinement`: what a mesh does not resolve, and from a mesh to two solutions that agree; `line`: the closed form of
//!   one state; `solve`: from a problem to the answer;
//! - `field`, `along`, `density`, `tails`, `kept`: the piecewise polynomial, the density made of it, what lies beyond its edges, and what further
//!   questions need;
//!   `sensitivity`: its derivatives by parameters; `shear`: other states, in which a thin density is rounder, and `oblique`: integrals
//!   over planes that then cut cells;
//! - `relaxation`, `march`: the spectrum next to zero and steps in time on the same operator;
//! - `initial`, `evolution`, `transient`: a start, a mesh that follows the density, and p(x, t); `survival`: the part of it that has passed no level.

mod along;
mod columns;
mod density;
mod dissection;
mod drift_order;
mod elimination;
mod evolution;
mod factors;
mod field;
mod flux;
mod forms;
mod incomplete;
mod initial;
mod iteration;
mod kept;
mod krylov;
mod legendre;
mod line;
mod march;
mod marking;
mod mesh;
mod narrow;
mod oblique;
mod operator;
mod panel;
mod pilot;
mod pins;
mod refinement;
mod relaxation;
mod sensitivity;
mod shape;
mod shear;
mod sides;
mod solve;
mod start;
mod stationary;
mod survival;
mod tails;
mod transient;
mod tree;
mod wells;

pub use density::GridDensity;
pub use sensitivity::GridSensitivity;
pub use survival::Survival;

use crate::checks::{finite, positive, require};
use crate::error::{Error, Result};
use crate::memory::MemoryLimit;
use crate::problem::Problem;
use crate::walls::Wall;
use pilot::GridPilot;
use shear::Shear;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Instant;

/// Halvings of the domain along each of one state to three before any state of the pilot or any solution counts.
const HALVINGS: [usize; shape::MOST] = [2, 2, 1];
/// The accuracy in L¹ for one state to three, where none is given.
const ACCURACIES: [f64; shape::MOST] = [1e-6, 1e-6, 1e-3];
/// The smallest cell along the velocity at a wall with r < 1, in standard deviations of the velocity. The density is singular
/// at the grazing point: the error of impact rates falls with a power of this number, 2 for r near 1, 1.5 for r = 0.7 and 1
/// for r = 0.5, that of moments faster.
const GRAZING: f64 = 1e-3;
/// The width of the narrowest cell over that of the domain: less would be lost to rounding.
const NARROWEST: f64 = 1e-12;
/// An estimate in L¹, or a sum of the relative errors of steps in time, of this size is no estimate of a density.
const HOPELESS: f64 = 0.5;
/// The most solutions on the way to a mesh that is fine enough; each takes a fifth of the error or less.
const ROUNDS: usize = 40;
/// The largest part of the probability passing a pin that rounding takes away.
const ROUNDING: f64 = 1e-13;
/// A loss of probability above so many times what rounding hides is a leak at the edges of the domain.
const HIDDEN: f64 = 10.0;
/// Parts of what comes from a pin that come back to it before they arrive at another: with less than the first the pin is none
/// of a well, with less than the second its well is not resolved on its own. With less than the third at any pin the exchanges
/// of wells are not compared between degrees.
const KEPT: [f64; 3] = [0.5, 0.9, 0.999];
/// The part of the accuracy, in L¹, to which the mesh of a transient is refined, and by which the Gaussian that spreads from a
/// point may be off.
const SHARE: f64 = 0.5;

/// A discontinuous Galerkin method that refines its mesh until the density is as accurate as it is asked to be, for problems of one
/// state to three.
///
/// 0 = −∂_i(f_i p) + ½ ∂_i∂_j(B_ij p) is solved in hybridised form, with upwind advection and an interior penalty for diffusion, on
/// cells that are halved along any state where the solution is not resolved. In three states, where one nearly follows the others in
/// proportion, the cells are boxes of what is left of it beside the regressions on them, `shear` in the
/// [`Provenance`](crate::Provenance).
///
/// ```
/// use expoly::{Density, Grid, models::{Duffing, Solved}};
/// let density = Grid::new().solve(&Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?)?;
/// let second = density.moment(&[2, 0])?;
/// assert!((second.value - 0.661714969204).abs() < 1e-7);
/// assert!(density.l1_estimate() < 1e-6);
/// # Ok::<(), expoly::Error>(())
/// ```
///
/// # References
/// B. Cockburn, J. Gopalakrishnan and R. Lazarov, Unified hybridization of discontinuous Galerkin, mixed, and continuous Galerkin
/// methods for second order elliptic problems, SIAM Journal on Numerical Analysis 47 (2009) 1319-1365, doi:10.1137/070706616.
#[derive(Clone, Default)]
#[must_use = "options return the value with the option; nothing happens before it is used"]
pub struct Grid {
    accuracy: Option<f64>,
    degree: Option<usize>,
    domain: Option<Vec<[f64; 2]>>,
    memory: MemoryLimit,
    progress: Option<GridCallback>,
}

type GridCallback = Arc<dyn Fn(GridProgress) -> ControlFlow<()> + Send + Sync>;

/// How far a grid has come.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GridProgress {
    /// Linear systems that have been solved, or steps in time that have been taken.
    pub rounds: usize,
    /// Cells of the last one.
    pub cells: usize,
    /// What is left in the highest degree: a rough measure of the error in L¹, by which cells are refined.
    pub indicator: f64,
    /// The L¹ distance between the solutions of two degrees, where the last mesh has been solved for both.
    pub estimate: Option<f64>,
    /// Where a density is followed, the time that it has come to.
    pub time: Option<f64>,
}

impl std::fmt::Debug for Grid {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Grid { accuracy, degree, domain, memory, .. } = self;
        let options = (accuracy, degree, domain, memory);
        f.debug_tuple("Grid").field(&options).finish()
    }
}

impl Grid {
    /// The method with the defaults named at each option.
    pub fn new() -> Self {
        Self::default()
    }

    /// The L¹ distance ∫ |p − p̃| dx that the density should have from the exact one at most, from 1e-11 to 0.1: by default 1e-6, in three
    /// states 1e-3. The mesh is refined until the estimate is below.
    pub fn accuracy(self, l1: f64) -> Self {
        Grid { accuracy: Some(l1), ..self }
    }

    /// The accuracy for so many states.
    fn target(&self, states: usize) -> f64 {
        self.accuracy.unwrap_or(ACCURACIES[states - 1])
    }

    /// The polynomials' degree in each state, from 2 to 24. By default 6 for accuracies down to 3e-6 and next to walls with r < 1, 8
    /// below; in three states 4 for 1e-2, 5 for 1e-3 and 6 below. The closed form of one state takes 6 at least, and 10 by default.
    pub fn degree(self, degree: usize) -> Self {
        Grid { degree: Some(degree), ..self }
    }

    /// Lower and upper limit of each state. By default the limits are four times as far from the middle as the states of a short
    /// simulation, and farther where the density does not end there. A limit at a wall is replaced by the wall.
    /// States with given limits are not sheared.
    pub fn domain(self, domain: impl IntoIterator<Item = [f64; 2]>) -> Self {
        Grid { domain: Some(domain.into_iter().collect()), ..self }
    }

    /// The memory that matrices and factors may take, 8 GiB by default, estimated before they are allocated: a thousand cells of degree 8 take a
    /// quarter of a gibibyte, in three states a thousand of degree 5 two. All solutions on the way to the last mesh take eight times the limit at most; where it ends before the accuracy is
    /// reached, the density has what was reached as its estimate, and a warning.
    pub fn memory_limit(self, gibibytes: f64) -> Self {
        Grid { memory: MemoryLimit::gibibytes(gibibytes), ..self }
    }

    pub(crate) fn within(self, memory: MemoryLimit) -> Self {
        Grid { memory, ..self }
    }

    /// A callback that is called after each linear system, and after each step of a transient or a survival that the density is asked
    /// for; it stops the grid by `Break`.
    pub fn progress(self, callback: impl Fn(GridProgress) -> ControlFlow<()> + Send + Sync + 'static) -> Self {
        Grid { progress: Some(Arc::new(callback)), ..self }
    }

    /// The stationary density of a problem of one state to three: on the whole space, or where the walls of a displacement leave it,
    /// below, above or on both sides, each with its own restitution.
    ///
    /// A run that does not reach the accuracy returns what it has, with its estimate and a warning. Where the noise of one state
    /// vanishes within the range, each side has a density of its own: returned is that where most trajectories are, with a
    /// warning if some are on the other.
    ///
    /// # Errors
    /// - [`Error::NotServed`]: a problem of another number of states, a wall on another state than the first, or impulses;
    /// - [`Error::OutOfRange`]: an option without a meaning;
    /// - [`Error::Exploded`], [`Error::NoDensity`]: the drift does not bring trajectories back, they come to rest, or no noise reaches a state;
    /// - [`Error::TooStiff`]: rates that are too far apart;
    /// - [`Error::NotResolved`]: an estimate of order 1, or more than one density is stationary, or none;
    /// - [`Error::TooMuchMemory`]: already the first mesh is beyond [`Grid::memory_limit`];
    /// - [`Error::Cancelled`]: the progress callback returned `Break`.
    ///
    /// ```
    /// use expoly::{Density, Grid, Wall, models::{Duffing, Solved}};
    /// let duffing = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?;
    /// let density = Grid::new().accuracy(1e-4).solve(&duffing.with_wall(Wall::above(0.0, 0.9)?)?)?;
    /// assert!((density.moment(&[1, 0])?.value - 0.58490541).abs() < 1e-5);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn solve(&self, problem: &Problem) -> Result<GridDensity> {
        let begin = Instant::now();
        let walls = self.served(problem)?;
        self.validate(problem)?;
        problem.operator().require_reached(&[])?;
        let pilot = GridPilot::new(problem)?;
        let piloted = begin.elapsed().as_secs_f64();
        let shear = if self.domain.is_none() { Shear::of(problem, &pilot) } else { None };
        let mut density = match shear {
            None => self.resolved(problem, walls, pilot, [false; 2])?,
            Some(shear) => {
                self.resolved(&shear.sheared()?, walls, shear.pilot(&pilot), [false; 2])?.in_states_of(shear)
            }
        };
        density.provenance.pilot_seconds = Some(piloted);
        density.provenance.seconds = begin.elapsed().as_secs_f64();
        Ok(density)
    }

    /// The walls of a problem that is served.
    fn served(&self, problem: &Problem) -> Result<[Option<Wall>; 2]> {
        if !(1..=shape::MOST).contains(&problem.dimension()) {
            let (what, remedy) = ("a problem of more than three states", "take the closure or the simulation");
            return Err(Error::NotServed { method: "grid", what, remedy });
        }
        problem.require_no_impulses("grid")?;
        problem.require_no_rest()?;
        problem.walls_of_oscillator("grid")
    }

    /// Refuses options without a meaning.
    fn validate(&self, problem: &Problem) -> Result<()> {
        self.memory.check()?;
        let degree = self.degree.unwrap_or(2);
        require((2..=24).contains(&degree), "degree of the grid", degree as f64, "it must lie between 2 and 24")?;
        require_accuracy("accuracy of the grid", self.target(problem.dimension()))?;
        if let Some(domain) = &self.domain {
            crate::checks::dimension("the domain of the grid", domain.len(), problem.dimension())?;
        }
        for [low, high] in self.domain.iter().flatten() {
            finite("limit of the domain", *low)?;
            finite("limit of the domain", *high)?;
            positive("side of the domain", high - low, "give lower and upper limits in this order")?;
        }
        Ok(())
    }
}

fn require_accuracy(name: &'static str, accuracy: f64) -> Result<()> {
    let sound = (1e-11..=0.1).contains(&accuracy);
    require(sound, name, accuracy, "it is a distance in L¹: it must lie between 1e-11 and 0.1").map(|_| ())
}

/// The refusal of a linear system without a unique solution.
fn singular(unknowns: usize) -> Error {
    let reason = format!(
        "the linear system of {unknowns} unknowns is singular: the stationary density is not unique, or there is none; check that the noise \
         reaches every state"
    );
    Error::NotResolved { estimate: f64::INFINITY, reason }
}
