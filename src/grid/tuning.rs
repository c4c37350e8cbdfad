//! The constants that decide something in the grid solution, each with its unit and where its value comes from.

/// The domain.
pub(super) mod domain {
    /// A pilot resolves densities down to about 1e-5 of the peak. A Gaussian falls to 1e-10 at 1.6 times the distance.
    pub(crate) const WIDENING: f64 = 1.6;
    /// The first share of the peak from which a fall is continued; a coarse solution resolves it well.
    pub(crate) const NEAR: f64 = 1e-2;
    /// The second one, to which the same applies.
    pub(crate) const FAR: f64 = 1e-4;
    /// The factor beyond the limit by the continued fall: a few percent more.
    pub(crate) const SAFETY: f64 = 1.04;
    /// The degree of the solutions by which the domain is adjusted, independent of the final one.
    pub(crate) const TRIAL_DEGREE: usize = 5;
    /// Their cells: cheap, and fine enough for a narrow ridge in a domain that is still too wide.
    pub(crate) const TRIAL_CELLS: [usize; 2] = [14, 14];
    /// How often a domain is adjusted before the search is given up.
    pub(crate) const ATTEMPTS: usize = 6;
    /// A density of this size at the edge, relative to the peak, is cut off and not merely badly resolved.
    pub(crate) const CUT: f64 = 1e-3;
    /// A solution with a larger mass below zero does not resolve its density.
    pub(crate) const NEGATIVE: f64 = 0.1;
}

/// The mesh.
pub(super) mod mesh {
    /// The ratio between the distances from the wall to which a layer and the one below it reach. Above a wall with r = 0.7 the
    /// L¹ estimate is 2.3e-5, 3.3e-5 and 1.2e-4 for 4, 5 and 7, with 43, 39 and 36 thousand unknowns.
    pub(crate) const POSITION_GROWTH: f64 = 5.0;
    /// The same ratio along the velocity. Since the density near the grazing point is a power of u times a function of w³/9Du,
    /// the cube root of the ratio of positions would match; somewhat more costs little: the estimate is 2.7e-5, 3.3e-5 and
    /// 5.2e-5 for 2, 2.3 and 2.6, with 45, 39 and 37 thousand unknowns.
    pub(crate) const VELOCITY_GROWTH: f64 = 2.3;
    /// The smallest cell at a level over that at a wall: next to a level that absorbs, the density falls as the square root of
    /// the speed. For Duffing's oscillator below 2σ the rate is off by 3e-8 relative with cells of 1e-1 σ, and by 3e-9 with those
    /// of 1e-2 σ and of 1e-3 σ, where degree 7 takes 21 and 36 thousand unknowns.
    pub(crate) const LEVEL: f64 = 10.0;
    /// The fewest equal cells between two levels.
    pub(crate) const FEWEST: usize = 4;
    /// The smallest standard deviation that a mesh holds, in units of a cell's width over the degree.
    pub(crate) const RESOLVED: f64 = 1.25;
}

/// Steps of time, and the rates at which they decay.
pub(super) mod march {
    /// A step changes by this factor only, since each new one costs new factors.
    pub(crate) const CHANGE: f64 = 3.0;
    /// By this one under modulated noise, where every step has factors of its own.
    pub(crate) const FINE_CHANGE: f64 = 1.4;
    /// The first step is this part of the whole time.
    pub(crate) const FIRST: f64 = 400.0;
    /// Steps before the march is given up.
    pub(crate) const MAX_STEPS: usize = 20_000;
    /// Vectors of the Krylov space. Each costs one solve with the factors; a few dozen eigenvalues next to the shift are then
    /// known to rounding.
    pub(crate) const KRYLOV: usize = 80;
    /// The smaller space whose eigenvalues estimate the error of the larger one's.
    pub(crate) const SMALLER: usize = 60;
}
