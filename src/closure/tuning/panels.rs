//! Rules for the integrals of a density that is found.

/// The rule that it is compared with has so many of so many nodes along one state.
pub(crate) const FEWER: [usize; 2] = [5, 4];
/// Nodes on a panel, and those of the rule that they are compared with.
pub(crate) const EACH: [usize; 2] = [16, 12];
/// Panels along a state to begin with.
pub(crate) const FIRST: usize = 4;
/// The most nodes. A bound on work.
pub(crate) const MOST: usize = 1 << 20;
/// What rules differ by falls by this factor, or the edge of the domain is what they differ by: not more often than so in a row.
pub(crate) const FALLS: f64 = 0.7;
pub(crate) const STALLED: usize = 2;
/// Two rules of an exact density agree to this part of mass and second moments,
pub(crate) const EXACT: f64 = 1e-10;
/// or its integrals are not known.
pub(crate) const UNKNOWN: f64 = 1e-6;
/// Those of others agree to this part of their estimate, within these bounds: the edge of the domain, where they are 1e-6 of their
/// peak, lies between nodes.
pub(crate) const SHARE: f64 = 0.01;
pub(crate) const BOUNDS: [f64; 2] = [1e-4, 1e-2];
/// Of a density whose rules differ by more there is no integral.
pub(crate) const RISING: f64 = 0.1;
