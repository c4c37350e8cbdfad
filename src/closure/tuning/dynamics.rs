//! Densities in time.

/// The degrees of the moment equations in time in one state and two, of which the highest stable one is taken.
pub(crate) const DEGREES: [u32; 8] = [10, 12, 14, 16, 18, 20, 22, 24];
/// The degrees of the moment equations in time in three states and more, as far as their functions are few enough.
pub(crate) const DEGREES_OF_MANY: [u32; 6] = [2, 4, 6, 8, 10, 12];
/// The most functions of the moment equations in time in three states and more.
pub(crate) const MOST_FUNCTIONS: usize = 500;
/// The most nodes times functions of moment equations in three states and more: two tables of so many numbers take 400 MB.
pub(crate) const MOST_ENTRIES: usize = 25_000_000;
/// The least order of the stationary density under which the moment equations of a transient in three states and more are taken.
pub(crate) const CARRIED_BASE: u32 = 4;
/// The highest order of the stationary density under which the moment equations of a transient in three states and more are taken.
pub(crate) const CARRIED_MOST: u32 = 6;
/// The trajectories of a transient in three states and more, or under noise that rises and fades, unless their number is given.
pub(crate) const ENSEMBLE: usize = 1 << 18;
/// The latest time of a transient that trajectories carry, in the shortest of the system's times: as long as the longest burn-in, a
/// bound on work.
pub(crate) const LONGEST: f64 = 2e3;
/// A mode of the moment equations is a growing one if it grows at more than this share of the slowest rate. Rounding leaves 1e-9 of
/// it.
pub(crate) const GROWING: f64 = 1e-6;
/// Modes of two degrees are the same if they differ by at most this factor times the error of the one of the higher degree.
pub(crate) const SAME_MODE: f64 = 3.0;
/// The least order of the stationary closure whose reference gives the weight of the moment equations in time.
pub(crate) const BASE: u32 = 8;
/// The order under impulses of the stationary closure that gives the weight in time, where modes grow under the weight of a higher
/// one.
pub(crate) const LOW_BASE: u32 = 4;
/// The largest mass of a start outside of the domain of the moment equations.
pub(crate) const OUTSIDE: f64 = 1e-3;
/// Gauss nodes along each axis of a normal start in one state and two.
pub(crate) const START_NODES: usize = 40;
/// The answer from a moving frame is defined where ln p is less than this below its peak, at p above e^−18 = 1.5e-8 of it: what is
/// beyond would be the largest part of its error.
pub(crate) const FRAME_KEPT: f64 = 18.0;
/// The answer at a time is defined within so many standard deviations about the mean.
pub(crate) const FARTHEST: f64 = 14.0;
/// Gauss nodes along each state on which the mass of an answer at a time is taken again, since a polynomial may rise between the
/// nodes.
pub(crate) const OTHER_NODES: usize = 97;
/// The relative difference of the masses of an answer at a time on two sets of nodes from which on it counts as an error.
pub(crate) const UNEVEN: f64 = 0.02;
/// The degrees of Hermite's polynomials in two moving frames of the same density, whose distance is the error of the first.
pub(crate) const FRAME_DEGREES: [usize; 2] = [14, 10];
/// The longest time step of a moving frame times the rate at which the frame changes.
pub(crate) const FRAME_STEP: f64 = 0.05;
/// The most steps of a moving frame between two estimates of its error.
pub(crate) const FRAME_STEPS: usize = 4;
/// The most estimates of the error of a moving frame: a bound on work.
pub(crate) const FRAME_STRETCHES: usize = 1200;
/// Gauss nodes along each axis of a moving frame.
pub(crate) const FRAME_NODES: usize = 24;
/// The half-width of the box on which the polynomials of a moving frame are written, in standard deviations.
pub(crate) const FRAME_BOX: f64 = 6.0;
/// The moment equations of the stationary weight go on from a moving frame whose error, in L¹, is below this.
pub(crate) const FRAME_GOOD: f64 = 1e-3;
/// A moving frame is given up where its error, in L¹, is above this.
pub(crate) const FRAME_LOST: f64 = 0.05;
/// A moving frame ends where a wall is so many standard deviations from its middle.
pub(crate) const CLEAR_OF_WALLS: f64 = 5.0;
/// Noise makes a Gaussian of a point within this share of the fastest time of its linear motion.
pub(crate) const POINT: f64 = 1e-3;
/// The ratio of a density in time to its weight is cut off at this factor, upwards and downwards, before its logarithm is taken.
pub(crate) const CUT: f64 = 1e12;
/// Densities of largest entropy are sought within so many standard deviations of the mean.
pub(crate) const WIDEST: f64 = 8.0;
/// The degree of the first density of largest entropy, unless the order is lower.
pub(crate) const FIRST: u32 = 4;
/// Densities of largest entropy are sought up to so many degrees above the order.
pub(crate) const EXCESS: u32 = 4;
/// A density of largest entropy is known where ln p is less than this below its peak, at p above e^−18 of it.
pub(crate) const DROP: f64 = 18.0;
