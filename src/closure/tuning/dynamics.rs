//! Densities in time.

/// The degrees of the moment equations, of which the highest stable one is taken.
pub(crate) const DEGREES: [u32; 8] = [10, 12, 14, 16, 18, 20, 22, 24];
/// A mode that grows at more than this share of the slowest rate is a growing one. Rounding leaves 1e-9 of it.
pub(crate) const GROWING: f64 = 1e-6;
/// Modes of two degrees are the same within this factor on the error of the higher one.
pub(crate) const SAME_MODE: f64 = 3.0;
/// The least order of the stationary closure whose reference gives the weight.
pub(crate) const BASE: u32 = 8;
/// The largest mass of a start outside of the domain.
pub(crate) const OUTSIDE: f64 = 1e-3;
/// Gauss nodes along each axis of a normal start.
pub(crate) const START_NODES: usize = 40;
/// The answer from a frame is defined where the density is above e^−18 = 1.5e-8 of its peak: what is beyond would be the
/// largest part of its error.
pub(crate) const FRAME_KEPT: f64 = 18.0;
/// The answer at a time is defined within so many standard deviations about the mean.
pub(crate) const FARTHEST: f64 = 14.0;
/// Gauss nodes along each state on which the mass of an answer is taken again,
pub(crate) const OTHER_NODES: usize = 97;
/// and the difference from which on it counts.
pub(crate) const UNEVEN: f64 = 0.02;
/// Degrees of Hermite's polynomials in moving frames, whose distance is the error of the first.
pub(crate) const FRAME_DEGREES: [usize; 2] = [14, 10];
/// The time step of a frame times the rate at which it changes.
pub(crate) const FRAME_STEP: f64 = 0.05;
/// Steps between two looks at the error.
pub(crate) const FRAME_STEPS: usize = 4;
/// So many looks at most: a bound on work.
pub(crate) const FRAME_STRETCHES: usize = 300;
/// Gauss nodes along each axis of a frame.
pub(crate) const FRAME_NODES: usize = 24;
/// The box in which a frame's polynomials are written, in standard deviations.
pub(crate) const FRAME_BOX: f64 = 6.0;
/// Below this error, in L¹, the moment equations of the stationary weight go on from a frame,
pub(crate) const FRAME_GOOD: f64 = 1e-3;
/// and above this one it is given up.
pub(crate) const FRAME_LOST: f64 = 0.05;
/// A frame ends where a wall is so many standard deviations from its middle.
pub(crate) const CLEAR_OF_WALLS: f64 = 5.0;
/// Of a point, noise has made a Gaussian after this share of the fastest time of its linear motion.
pub(crate) const POINT: f64 = 1e-3;
/// The ratio of a density to its weight is cut off at this factor before its logarithm is taken.
pub(crate) const CUT: f64 = 1e12;
/// Densities of largest entropy are sought within so many standard deviations of the mean,
pub(crate) const WIDEST: f64 = 8.0;
/// of this degree first,
pub(crate) const FIRST: u32 = 4;
/// and up to so many degrees above the order.
pub(crate) const EXCESS: u32 = 4;
/// They are known down to e^−18 of their peak.
pub(crate) const DROP: f64 = 18.0;
