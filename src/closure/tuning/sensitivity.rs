//! Derivatives by parameters.

/// The least degree of the moment equations.
pub(crate) const LEAST_DEGREE: u32 = 14;
/// The same under impulses,
pub(crate) const LEAST_DEGREE_STRUCK: u32 = 12;
/// and the degrees above the order there, by the number of states: high degrees ring. Gamma's law of shape 10 lost its derivatives at
/// n = 8 by degree 16, and has them to 1e-3 by 12; for a Duffing oscillator at n = 6 the estimate is 4 times as large by 12 as by 14.
pub(crate) const EXCESS_STRUCK: [u32; 2] = [4, 8];
/// The degree of the polynomial that the derivative of the weight's logarithm is,
pub(crate) const DEGREE: u32 = 12;
/// how often it is renewed at most,
pub(crate) const RENEWALS: usize = 12;
/// and the factor by which what it leaves must fall each time.
pub(crate) const FALLS: f64 = 0.9;
/// Draws on which the equations of an exact density are solved where there are no nodes.
pub(crate) const DRAWS: usize = 1 << 16;
/// On the pilot's states: the degrees of the functions,
pub(crate) const DEGREES: [u32; 4] = [2, 4, 6, 8];
/// and the logarithm of the ratio of standard errors above which two degrees less are taken. Of 16 seeds of a filter, where both degrees
/// are as noisy, some took the lower one with 0.7, which is 0.2 % off there; of a chain the highest degree is noisier by far more.
pub(crate) const NOISIER: f64 = 1.4;
/// The step of the differences that are the slope of an integrand, relative to the domain's width: its square and rounding over it are some
/// 1e-10.
pub(crate) const STEP: f64 = 1e-5;
/// The same for sections of a density, which are sums over draws: the square of it is some tenths of a percent.
pub(crate) const WIDE_STEP: f64 = 5e-3;
/// Nodes from a level to the edge of the domain.
pub(crate) const TAIL_NODES: usize = 80;
