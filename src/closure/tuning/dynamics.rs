//! Densities in time.

/// The degrees of the moment equations, of which the highest stable one is taken.
pub(crate) const DEGREES: [u32; 8] = [10, 12, 14, 16, 18, 20, 22, 24];
/// The degrees in three states and more, as far as they are so few functions,
pub(crate) const DEGREES_OF_MANY: [u32; 6] = [2, 4, 6, 8, 10, 12];
pub(crate) const MOST_FUNCTIONS: usize = 500;
/// and the nodes times functions there: two tables of so many numbers take 400 MB.
pub(crate) const MOST_ENTRIES: usize = 25_000_000;
/// The least and the highest order of the density whose moment equations they are there.
pub(crate) const CARRIED_BASE: u32 = 4;
/// See [`CARRIED_BASE`].
pub(crate) const CARRIED_MOST: u32 = 6;
/// The trajectories of a transient in three states and more.
pub(crate) const ENSEMBLE: usize = 1 << 18;
/// The latest time there, in the shortest of the system's times: as long as the longest burn-in. A bound on work.
pub(crate) const LONGEST: f64 = 2e3;
/// A mode that grows at more than this share of the slowest rate is a growing one. Rounding leaves 1e-9 of it.
pub(crate) const GROWING: f64 = 1e-6;
/// Modes of two degrees are the same within this factor on the error of the higher one.
pub(crate) const SAME_MODE: f64 = 3.0;
/// The least order of the stationary closure whose reference gives the weight.
pub(crate) const BASE: u32 = 8;
/// The order under impulses where modes grow under the weight of that one.
pub(crate) const LOW_BASE: u32 = 4;
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
pub(crate) const FRAME_STRETCHES: usize = 1200;
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
