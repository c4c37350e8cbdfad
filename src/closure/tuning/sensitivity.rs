//! Derivatives by parameters.

/// The least degree of the moment equations for derivatives by parameters of systems without impulses.
pub(crate) const LEAST_DEGREE: u32 = 14;
/// The least degree of the moment equations for derivatives by parameters under impulses.
pub(crate) const LEAST_DEGREE_STRUCK: u32 = 12;
/// The degree above the order, in one state and in two, of the moment equations for derivatives under impulses, where high degrees
/// ring. Gamma's law of shape 10 lost its derivatives at n = 8 by degree 16, and has them to 1e-3 by 12; for a Duffing oscillator
/// at n = 6 the estimate is 4 times as large by 12 as by 14.
pub(crate) const EXCESS_STRUCK: [u32; 2] = [4, 8];
/// The degree of the polynomial that is the derivative of the weight's logarithm by a parameter.
pub(crate) const DEGREE: u32 = 12;
/// The most times that the derivative of the weight's logarithm by a parameter is renewed.
pub(crate) const RENEWALS: usize = 12;
/// What the derivative of the weight's logarithm leaves of a density's derivative must fall by this factor each time that it is
/// renewed.
pub(crate) const FALLS: f64 = 0.9;
/// The most nodes or draws on which the equations of an exact density are solved for its derivatives in three states and more.
pub(crate) const DRAWS: usize = 1 << 16;
/// The degrees of the functions whose equations on the pilot's states give derivatives by parameters.
pub(crate) const DEGREES: [u32; 4] = [2, 4, 6, 8];
/// The logarithm of the ratio of standard errors above which derivatives on the pilot's states are taken by two degrees less. Of 16
/// seeds of a filter, where both degrees are as noisy, some took the lower one with 0.7, which is 0.2 % off there; of a chain the
/// highest degree is noisier by far more.
pub(crate) const NOISIER: f64 = 1.4;
/// The step of the differences that are the slope of an integrand, relative to the domain's width: the errors by its square and by
/// rounding over it are some 1e-10.
pub(crate) const STEP: f64 = 1e-5;
/// The step of the differences that are the slope of a section of a density, which is a sum over draws, relative to the domain's
/// width: the error by its square is some tenths of a percent.
pub(crate) const WIDE_STEP: f64 = 5e-3;
/// Gauss nodes from a level to the edge of the domain for the derivative of the probability that a state exceeds it.
pub(crate) const TAIL_NODES: usize = 80;
