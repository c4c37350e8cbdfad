//! The exponential-polynomial closure: p = C exp(Q) with Q a polynomial of any order, in any number of states.
//!
//! [`Closure::new`] is a method that gives a density at every order. The literature's closure asks that the residual of
//! exp(Q) be orthogonal to the polynomials that Q itself is made of, and at most orders no Q obeys. Here the residual is
//! tested with the functions whose mean rate of change those polynomials are, so that the moments of p̃ up to the order are
//! those of the stationary density. These equations always have a solution, the best density of its order in the sense of
//! Kullback and Leibler. The steps, each in its file:
//!
//! 1. `pilot`: a short simulation at inflated intensity; `trust_domain`: where it has been; `discretisation`, `walled`: the nodes
//!    there and the first guess of ln p, by `likelihood`;
//! 2. `nested_spaces`, `space`: the functions of an order and those of its reference, made `orthonormal` under a weight;
//! 3. `moment_equations`, `reference`: a density of many more moment equations, E[Gψ] = 0, which are linear in its ratio to
//!    a weight, the weight renewed until it follows the density;
//! 4. `projection`, `weight`: the exponential polynomial closest to it, by a convex minimisation;
//! 5. `retained`, `choice`, `indicator`: the candidates, their errors, and the guard by the pilot's likelihood;
//! 6. `exact`: where a candidate is a solution itself, that;
//! 7. `content`, `density`, `answers`: the answer with its trust domain, and its integrals with their errors.
//!
//! `method` holds the options, and `solve` the way from a problem to the steps: Gauss nodes in one and two states, also next
//! to walls. In three and more, `samples` and `sampled`, the pilot's states take the place of the reference: their means, made
//! precise by the moment equations, have one most likely exponential polynomial; `on_lattice` solves the equations of a reference
//! in three states and four.
//!
//! `classical` is the literature's method.

mod answers;
mod choice;
mod classical;
mod content;
mod degrees;
mod density;
mod discretisation;
mod exact;
mod exponent;
mod indicator;
mod likelihood;
mod method;
mod moment_equations;
mod nested_spaces;
mod nodal;
mod nodes;
mod on_lattice;
mod orthonormal;
mod pilot;
mod polish;
mod projection;
mod reference;
mod retained;
mod sampled;
mod samples;
mod solve;
mod space;
mod table;
mod trust_domain;
mod walled;
mod weight;

pub use choice::{Candidate, Origin};
pub use classical::{Basis, ClassicalClosure, Solution, Termination};
pub use degrees::Degrees;
pub use density::ClosureDensity;
pub use method::Closure;
pub(crate) use samples::Copula;
pub(crate) use space::{CLOSEST, Corner, PER_UNIT, SMALLEST, STEPS, Similarity, TAYLOR};
pub(crate) use trust_domain::TrustDomain;
pub use weight::Weight;
