//! Rules for the integrals of a density that is found.

/// The ratio of the nodes along one state to those of the coarser rule that they are compared with.
pub(crate) const FEWER: [usize; 2] = [5, 4];
/// Gauss nodes on a panel, and those of the coarser rule that they are compared with.
pub(crate) const EACH: [usize; 2] = [16, 12];
/// Panels along each state before any is halved.
pub(crate) const FIRST: usize = 4;
/// The most nodes of rules on panels along all states: a bound on work.
pub(crate) const MOST: usize = 1 << 20;
/// The relative difference of two rules must fall by this factor as panels are halved; where it does not, the edge of the domain is
/// what they differ by.
pub(crate) const FALLS: f64 = 0.7;
/// Panels are halved no more once the difference of two rules has not fallen enough so many times in a row.
pub(crate) const STALLED: usize = 2;
/// Two rules for an exact density agree to this part of its mass and second moments.
pub(crate) const EXACT: f64 = 1e-10;
/// An exact density has no known integrals where two rules differ by more than this part of its mass and second moments.
pub(crate) const UNKNOWN: f64 = 1e-6;
/// Two rules for a density that is not exact agree, relative to its mass and second moments, to this part of its estimated L¹
/// error.
pub(crate) const SHARE: f64 = 0.01;
/// The least and the largest relative difference that two rules for a density that is not exact may be asked for: the edge of its
/// domain, where it is 1e-6 of its peak, lies between nodes.
pub(crate) const BOUNDS: [f64; 2] = [1e-4, 1e-2];
/// A density whose two rules differ by more than this part of its mass and second moments has no integral: it rises between the
/// nodes.
pub(crate) const RISING: f64 = 0.1;
