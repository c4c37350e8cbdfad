//! Derivatives by parameters.

/// The least degree of the moment equations.
pub(crate) const LEAST_DEGREE: u32 = 14;
/// The degree of the polynomial that the derivative of the weight's logarithm is,
pub(crate) const DEGREE: u32 = 12;
/// how often it is renewed at most,
pub(crate) const RENEWALS: usize = 12;
/// and the factor by which what it leaves must fall each time.
pub(crate) const FALLS: f64 = 0.9;
/// Draws on which the equations of an exact density are solved where there are no nodes.
pub(crate) const DRAWS: usize = 1 << 16;
/// On the pilot's states: the degrees of the functions.
pub(crate) const DEGREES: [u32; 4] = [2, 4, 6, 8];
/// and the logarithm of the ratio of errors above which two degrees less are taken, for first derivatives and for second ones. The
/// degree of p″/p is twice that of p′/p: with 0.7 second derivatives of a chain's mean squares were off by 1 %, three of their
/// standard errors.
pub(crate) const NOISIER: [f64; 2] = [0.7, 1.0];
/// The step of the differences that are the slope of an integrand, relative to the domain's width: the square of it and rounding
/// over it are some 1e-10.
pub(crate) const STEP: f64 = 1e-5;
/// The same for sections of a density, which are sums over draws: the square of it is some tenths of a percent.
pub(crate) const WIDE_STEP: f64 = 5e-3;
/// Nodes from a level to the edge of the domain.
pub(crate) const TAIL_NODES: usize = 80;
