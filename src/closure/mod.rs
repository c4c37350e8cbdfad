//! The exponential-polynomial closure: p = C exp(Q) with Q a polynomial of any order, in any number of states.
//!
//! [`Closure::new`] is a method that gives a density at every order. The literature's closure requires the residual of exp(Q)
//! to be orthogonal to the polynomials that Q itself is made of, and at most orders no Q satisfies that. Here the residual is
//! tested with the functions whose mean rate of change those polynomials are, so that the moments of p̃ up to the order are
//! those of the stationary density. These equations always have a solution, the best density of its order in the sense of
//! Kullback and Leibler. The steps, each in its file:
//!
//! 1. `pilot`: a short simulation at inflated intensity;
//! 2. `discretisation`: the trust domain, which is the region that the pilot has visited, the nodes in it, next to walls as
//!    well, and the initial ln p by likelihood;
//! 3. `space`: the functions of an order and those of its reference, made orthonormal under a weight;
//! 4. `reference`: a density of many more moment equations, E\[Gψ\] = 0, which are linear in its ratio to a weight, the weight
//!    renewed until it follows the density;
//! 5. `projection`: the exponential polynomial closest to it, by a convex minimisation; where a candidate near it solves the
//!    equation exactly, that one (`exactness`);
//! 6. `candidates`: their errors, the choice among them, and the guard by the pilot's likelihood;
//! 7. `density`: the answer with its trust domain, and its integrals with their errors.
//!
//! Where the equations of step 4 do not serve, `closest` takes the density of a grid in their place, on the grid's cells; it finds the
//! exponential polynomial closest to any density of one state or two.
//!
//! `method` holds the options, and `solve` the way from a problem to the steps: `nodal` takes them on Gauss nodes in one and two
//! states, also next to walls. In three and more, `carried`, `sampled` and `samples`, the pilot's states take the place of the reference:
//! their means, made precise by the moment equations, have one most likely exponential polynomial; on a lattice there can be a
//! reference as well (`lattice_reference`). Next to walls the pilot's impacts are a part of its means, and the equations have integrals over walls.
//!
//! `dynamics` has densities in time, by `closest` and on trajectories, and the modes of moment equations in time.
//!
//! `classical` is the literature's method.
//!
//! Constants stand where they are used, those of several steps here; each has its unit and the origin of its value. *Bounds on work* are the
//! largest sizes that were worth their time; *rounding* is what sums of some thousand terms leave of sixteen digits. Where two changes
//! are given, the value was halved and doubled, and they are those of the L¹ error that changed most among nine closures: of orders 4
//! to 8, of [`CubicDamping`](crate::models::CubicDamping) in two forms, of [`DuffingVanDerPol`](crate::models::DuffingVanDerPol) in two,
//! and of Duffing's oscillator above two walls. Other random numbers alone, as a pilot has them with another time step, change them by
//! up to 7 %.

mod candidates;
mod carried;
mod classical;
mod closest;
mod density;
mod discretisation;
mod dynamics;
mod lattice_reference;
mod method;
mod nodal;
mod pilot;
mod potential;
mod projection;
mod reference;
mod sampled;
mod samples;
mod sensitivity;
mod solve;
mod space;

use crate::numerics::Search;
pub use candidates::{Candidate, Origin};
pub use classical::{Basis, ClassicalClosure, Solution, Termination};
pub use density::ClosureDensity;
pub(crate) use density::cells::DomainCells;
pub(crate) use discretisation::trust_domain::TrustDomain;
pub use method::{Closure, Reference};
pub use projection::Weight;
pub(crate) use samples::Copula;
pub use sensitivity::ClosureSensitivity;
pub use space::degrees::Degrees;

/// A number as small as this, relative to its parts, is rounding: what sums over some thousand nodes leave of sixteen digits. None
/// of nine closures of orders 4 to 8 depends on it.
const ROUNDING: f64 = 1e-12;
/// An equation whose residual is this small, relative to its parts, is solved, and what follows from its solution is right to this:
/// linear systems, whose conditions multiply the rounding of their entries. None of nine closures of orders 4 to 8 depends on it.
const SOLVED: f64 = 1e-9;
/// Steps of a converging iteration are at most this share of the one before, in the measure of the iteration: those of Newton's
/// method near a solution are far smaller, and what falls more slowly has come down to noise. Halved or doubled, it changes L¹
/// errors of nine closures of orders 4 to 8 by up to 0 or −3 %.
const CONVERGING: f64 = 0.5;
/// An estimated L¹ error above this is worth another attempt, and a warning if that does not help; that of a derivative counts
/// relative to its size. None of nine closures of orders 4 to 8 depends on it.
const UNRELIABLE: f64 = 0.2;
/// The trajectories of a pilot: path-steps are cheapest in multiples of so many.
const PILOT_TRAJECTORIES: usize = 512;
/// The radius of the trust domain, next to walls and in many states, relative to the farthest of the pilot's states, and the
/// variance of draws relative to that of these states.
const WIDENING: f64 = 1.1;
/// The share of the pilot's states, the farthest ones, that is left out of the trust domain next to walls in three states and
/// more.
const CUT_AT_WALLS: f64 = 5e-5;
/// The answer is defined where the reference is above e^−13.8 = 1e-6 of its peak. Halved or doubled, it changes L¹ errors of
/// nine closures of orders 4 to 8 by up to +47 % or +7 %.
const KEPT_DROP: f64 = 13.8;
/// The domain of an exact density, and any domain next to walls in two states, ends at e^−32 = 1e-14 of the peak.
const FULL_DROP: f64 = 32.0;
/// Gauss nodes along each state, in one state and in two.
const FINE_NODES: [usize; 2] = [240, 80];
/// The degree of the first guess of ln p beside its singular part next to walls, its least order on a lattice, and the order
/// that is tried first where trajectories stayed where they began.
const LOW_DEGREE: u32 = 4;
/// The search for the most likely density: its tolerance, in standard deviations of ln p, is far below the states' noise.
const LIKELIHOOD_SEARCH: Search = Search { tolerance: 1e-6, most: 80 };
/// The highest order of a closure.
const HIGHEST_ORDER: u32 = 16;
/// The highest order of a closure next to walls in two states, for which a wall's reference is accurate enough.
const HIGHEST_ORDER_AT_WALLS: u32 = 10;
/// The degree of a reference above the order of the closure, by the number of states; four have too many functions for more.
const REFERENCE_EXCESS: [u32; 4] = [8, 8, 8, 4];
/// The most functions of a reference on a lattice (degree 18 in three states, 10 in four) and of equations for derivatives on
/// samples: a bound on work. Where the density of samples two degrees higher has more, only those of one and of two states are
/// taken beyond the order.
const MOST_FUNCTIONS: usize = 800;
/// A reference with an L¹ error as small as this needs no further attempt, and a density as close to it may be exact. None of
/// nine closures of orders 4 to 8 depends on it.
const FINE_REFERENCE: f64 = 2e-5;
/// The power of the density under which the weight of a reference is fitted: flatter than the density, for the tails' sake.
/// Halved or doubled, it changes L¹ errors of nine closures of orders 4 to 8 by up to +6 % or +34 %.
const WEIGHT_POWER: f64 = 0.6;
/// The power of the density that stands for its tails in the weight of a fit.
const TAILS_POWER: f64 = 0.3;
/// The most steps of Newton's method towards an exact density, each of which converges. None of nine closures of orders 4 to 8
/// depends on it.
const EXACT_STEPS: usize = 12;
/// The tails of a density are compared with the reference's down to this share of the peak. Halved or doubled, it changes L¹
/// errors of nine closures of orders 4 to 8 by up to −28 % or −6 %, by the tails that are then not fitted.
const LOWEST_COMPARED: f64 = 1e-5;
/// The tails of a density are accurate within so many decades of the reference, and right where they have cost as much in L¹ as
/// they may. Halved or doubled, it changes L¹ errors of nine closures of orders 4 to 8 by up to +7 % or −3 %.
const TAILS_ENOUGH: f64 = 0.25;
/// The most memory of a grid that a closure is the closest to, in GiB: a bound on work, which makes it a matter of seconds.
const GRID_MEMORY: [f64; 3] = [0.3, 0.3, 3.0];
/// Draws for integrals of a density: a standard error of some tenths of a percent for fourth moments in ten states.
const DRAWS: usize = 400_000;
/// The fewest blocks of states for each function whose moment equation is used.
const BLOCKS_EACH: usize = 60;
/// The most nodes of the maximisation: a bound on work.
const MOST_NODES: usize = 1 << 18;
/// A lattice of fewer nodes is enough, and a lattice gives the mass of an exact density, if means by one half of its nodes are
/// within this of those by all, in standard deviations.
const EVEN_LATTICE: f64 = 1e-5;
