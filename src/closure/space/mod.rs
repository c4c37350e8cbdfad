//! The functions that ln p and its corrections are combined from.
//!
//! - `degrees`: which monomials are of an order; `folded`: their products with kinks of the drift; `wall`: which functions with the
//!   singularity of grazing impacts;
//! - `nested_spaces`: the spaces that an order needs; `orthonormal`: their bases under a weight;
//! - `sweep`: functions at many points.

pub(super) mod degrees;
pub(super) mod folded;
pub(super) mod nested_spaces;
pub(super) mod orthonormal;
pub(super) mod sweep;

mod wall;

pub(super) use wall::WallLevel;
