//! The exponential polynomial closest to a density on cells.

/// Gauss nodes along each side of a cell. 6 give the same distances to a hundredth for twice the nodes.
pub(crate) const ALONG: usize = 4;
/// The fewest cells, by the number of states: those of a density that names none must not miss where its mass is.
pub(crate) const FEWEST: [usize; 2] = [64, 256];
/// So many times as many where more than this share of the mass is not on them, or not known.
pub(crate) const MORE: usize = 16;
/// See [`MORE`].
pub(crate) const LOST: f64 = 0.01;
/// The most nodes, of which each has a row of all functions. A bound on work and memory.
pub(crate) const MOST_NODES: usize = 160_000;
/// The density is followed down to this share of its peak: 1e-4 leaves 1e-3 of a heavy tail's mass out, 1e-8 lets the tail decide.
pub(crate) const LEVEL: f64 = 1e-6;
/// The tail is what is below this share of the peak.
pub(crate) const TAIL: f64 = 1e-3;
/// The share of the mass in a tail that counts as heavy. A normal density of two states has [`TAIL`] in it, one of one state a fifth.
pub(crate) const HEAVY: f64 = 0.002;
/// Without the tail nothing is sought where what is closest with it is farther off than this.
pub(crate) const FAR: f64 = 0.5;
/// The share of the peak that stands for all that is smaller, or unknown: next to nothing.
pub(crate) const FLOOR: f64 = 1e-9;
/// A value is known where its error is below this share of it. Without it the error of a grid, which sits in its tails, decides high
/// orders: a distance of 2.8e-3 in place of 5e-4.
pub(crate) const KNOWN: f64 = 0.3;
/// How often a cell at the edge of what is known is divided.
pub(crate) const AT_EDGES: usize = 2;
/// A cell is divided while the highest polynomial that its nodes see makes more than this share of its mass,
pub(crate) const ROUGH: f64 = 0.1;
/// and that is more than this share of the whole.
pub(crate) const SLIGHT: f64 = 1e-6;
/// More nodes along each side, by which integrals of exp(Q) are checked.
pub(crate) const FINER: usize = 6;
/// What two rules may differ by, relative to the distance that is found, before cells are divided; and how often that is done.
pub(crate) const APART: f64 = 1e-2;
/// See [`APART`].
pub(crate) const ROUNDS: usize = 5;
/// The accuracies of a grid that stands for a reference: the second one where the error of the first is above this share of a distance.
pub(crate) const ACCURACIES: [f64; 2] = [1e-3, 1e-5];
/// See [`ACCURACIES`].
pub(crate) const MINOR: f64 = 0.1;
/// The memory of such a grid, in GiB. A bound on work: seconds.
pub(crate) const MEMORY: f64 = 0.3;
/// The estimate of moment equations below this share of that by a grid is believed. Not met.
pub(crate) const BETTER: f64 = 0.5;
/// The moment equations serve where their error is below this share of the whole estimate, in one state, whose closed form takes no time,
/// and in two,
pub(crate) const SERVES: [f64; 2] = [0.01, 0.6];
/// or where the estimate is below this.
pub(crate) const SMALL: f64 = 1e-4;
