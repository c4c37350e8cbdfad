//! Functions of the state: products of Legendre polynomials, and of these with the singularity of grazing impacts at walls.
//!
//! - `polynomials`: products of Legendre polynomials on a box; `fold`: functions of one state by which these may be multiplied, with a kink
//!   at a place, or a `curve` by its table;
//! - `corner`: the singularity at a wall, by the `similarity` solution of grazing impacts; `kink`: the functions that have it, all of them
//!   functions of a `plane`, of the distance from a wall and its rate;
//! - `list`: lists of both; `tree`: their values, their gradients, and their images 𝓖ψ = f·∇ψ + ½ B:∇∇ψ, at a point or at several at once;
//! - `impulses`: the part of 𝓖ψ that Poisson impulses make, λ E\[ψ(x + H Y) − ψ(x)\].

mod corner;
mod curve;
mod fold;
mod impulses;
mod kink;
mod list;
mod plane;
mod polynomials;
mod similarity;
mod tree;

pub(crate) use corner::{Corner, GrazingMotion};
pub(crate) use curve::Curve;
pub(crate) use fold::Fold;
pub(crate) use impulses::{ImpulseImages, images};
pub(crate) use kink::{Kink, SMALLEST};
pub(crate) use list::{Block, Functions};
pub(crate) use plane::{Form, PlaneJet, PlaneOperator};
pub(crate) use polynomials::Polynomials;
pub(crate) use similarity::{CLOSEST, PER_UNIT, STEPS, Similarity, TAYLOR};
pub(crate) use tree::Scratch;

/// No rule here is made for polynomials of a higher degree.
pub(crate) const HIGHEST: u32 = 30;
