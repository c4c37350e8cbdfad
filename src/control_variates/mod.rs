//! Control variates from the generator: the part that closure and simulation have in common.
//!
//! In the stationary state E\[𝓖ψ\] = 0 for every polynomial ψ, with the generator 𝓖 = f·∇ + ½ B:∇∇. The mean of 𝓖ψ over sampled
//! states is therefore chance alone, and the part of a sampled mean h̄ that is correlated with it can be taken off, E h = h̄
//! − β·mean(𝓖ψ) (A. Mira, R. Solgi and D. Imparato, 2013, doi:10.1007/s11222-012-9344-6).
//!
//! - `products`: the functions ψ, and 𝓖ψ at eight states at a time; `planes`: those of them that are functions of a plane;
//! - `impulses`: the part of 𝓖ψ that Poisson impulses make, λ E\[ψ(x + H Y) − ψ(x)\];
//! - `regression`: β.

pub(crate) mod impulses;
pub(crate) mod planes;
pub(crate) mod products;
mod regression;

pub(crate) use regression::regression;
