//! The exponential polynomial closest to a density on cells.

/// Gauss nodes along each side of a cell. 6 give the same distances to a hundredth for twice the nodes.
pub(crate) const ALONG: usize = 4;
/// The fewest cells in one state and in two, so that a density without cells of its own has some where its mass is.
pub(crate) const FEWEST: [usize; 2] = [64, 256];
/// The factor on the fewest cells where too much of the mass of a density without cells of its own is not on them, or not known.
pub(crate) const MORE: usize = 16;
/// The share of the mass that is not on the cells, or not known, from which on a density without cells of its own gets more of
/// them.
pub(crate) const LOST: f64 = 0.01;
/// The most nodes on all cells, of which each has a row of all functions: a bound on work and memory.
pub(crate) const MOST_NODES: usize = 160_000;
/// The density is followed down to this share of its peak: 1e-4 leaves 1e-3 of a heavy tail's mass out, with 1e-8 the tail decides.
pub(crate) const LEVEL: f64 = 1e-6;
/// The tail of a density is what is below this share of its peak.
pub(crate) const TAIL: f64 = 1e-3;
/// The share of the mass above which a tail is heavy. A normal density of two states has 1e-3 in its tail, one of one state a fifth
/// of that.
pub(crate) const HEAVY: f64 = 0.002;
/// The L¹ distance of the closest polynomial above which none is sought without the tail: what is farther off is so in the middle
/// too.
pub(crate) const FAR: f64 = 0.5;
/// The share of the peak that stands for all values that are smaller, or not known: next to nothing.
pub(crate) const FLOOR: f64 = 1e-9;
/// A value of the density is known where its error is below this share of it. Without this limit the error of a grid, which sits in
/// its tails, decides high orders: a distance of 2.8e-3 in place of 5e-4.
pub(crate) const KNOWN: f64 = 0.3;
/// The most divisions of a cell because it lies at the edge of what is known of the density.
pub(crate) const AT_EDGES: usize = 2;
/// A cell is divided while the highest Legendre polynomial that its nodes resolve makes more than this share of its mass.
pub(crate) const ROUGH: f64 = 0.1;
/// A cell with at most this share of the whole mass is not divided, however rough the density is on it.
pub(crate) const SLIGHT: f64 = 1e-6;
/// Gauss nodes along each side of a cell in the finer rule by which integrals of exp(Q) are checked.
pub(crate) const FINER: usize = 6;
/// Cells are divided while two rules for the mass of exp(Q) differ by more than this share of the distance that is found, with the
/// density's own error.
pub(crate) const APART: f64 = 1e-2;
/// The most rounds of division of the cells on which two rules for the mass of exp(Q) differ.
pub(crate) const ROUNDS: usize = 5;
/// The accuracies, in L¹, of the first and the second grid that stands for a reference.
pub(crate) const ACCURACIES: [f64; 2] = [1e-3, 1e-5];
/// A second, finer grid stands for the reference where the error of the first is above this share of the estimated L¹ distance.
pub(crate) const MINOR: f64 = 0.1;
/// The most memory of a grid that stands for a reference, in GiB: a bound on work, which makes it a matter of seconds.
pub(crate) const MEMORY: f64 = 0.3;
/// In two states the moment equations' answer is taken where its estimate is below this share of that by a grid. None of nine
/// closures depends on the value.
pub(crate) const BETTER: f64 = 0.5;
/// The moment equations serve where the error of their reference is at most this share of the whole estimate: in one state, where a
/// grid is a closed form that takes no time, and in two.
pub(crate) const SERVES: [f64; 2] = [0.01, 0.6];
/// The moment equations serve where their estimate, in L¹, is at most this, whatever share of it is the error of their reference.
pub(crate) const SMALL: f64 = 1e-4;
