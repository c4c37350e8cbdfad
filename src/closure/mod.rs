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
//!    equation exactly, that one (`exact`);
//! 6. `candidates`: their errors, the choice among them, and the guard by the pilot's likelihood;
//! 7. `density`: the answer with its trust domain, and its integrals with their errors.
//!
//! Where the equations of step 4 do not serve, `closest` takes the density of a grid in their place, on the grid's cells; it finds the
//! exponential polynomial closest to any density of one state or two.
//!
//! `method` holds the options, and `solve` the way from a problem to the steps: `nodal` takes them on Gauss nodes in one and two
//! states, also next to walls. In three and more, `sampled` and `samples`, the pilot's states take the place of the reference:
//! their means, made precise by the moment equations, have one most likely exponential polynomial; on a lattice there can be a
//! reference as well. Next to walls the pilot's impacts are a part of its means, and the equations have integrals over walls. `tuning` lists the constants that decide something, step by step.
//!
//! `dynamics` follows densities in time, by the moment equations that `reference` solves for the stationary one.
//!
//! `classical` is the literature's method.

mod candidates;
mod classical;
mod closest;
mod density;
mod discretisation;
mod dynamics;
mod method;
mod nodal;
mod pilot;
mod projection;
mod reference;
mod sampled;
mod samples;
mod sensitivity;
mod solve;
mod space;
mod tuning;

pub use candidates::{Candidate, Origin};
pub use classical::{Basis, ClassicalClosure, Solution, Termination};
pub(crate) use closest::Cells;
pub use density::ClosureDensity;
pub(crate) use discretisation::trust_domain::TrustDomain;
pub use method::{Closure, Reference};
pub use projection::Weight;
pub(crate) use samples::Copula;
pub use sensitivity::Sensitivity;
pub use space::degrees::Degrees;
pub(crate) use space::{CLOSEST, Corner, PER_UNIT, SMALLEST, STEPS, Similarity, TAYLOR};
