//! The constants that decide something in the closure, in the order of its steps, each with its unit and where its value comes
//! from.
//!
//! *Bounds on work* are the largest sizes that were worth their time; *rounding* is what sums of some thousand terms leave of
//! sixteen digits. Where two changes are given, the value was halved and doubled, and they are those of the L¹ error that
//! changed most among nine closures: of orders 4 to 8, of [`CubicDamping`](crate::models::CubicDamping) in two forms, of
//! [`DuffingVanDerPol`](crate::models::DuffingVanDerPol) in two, and of Duffing's oscillator above two walls. Other random
//! numbers alone, as a pilot has them with another time step, change them by up to 7 %. *Not met* says that none of the nine
//! depends on the value. Data of mathematics, such as the terms of a series, and layouts stand where they are used.

pub(crate) mod closest;
pub(crate) mod dynamics;
mod many_states;
pub(crate) mod panels;
pub(crate) mod sensitivity;

pub(crate) use many_states::{calibration, lattice, likelihood, nest, strata};

/// What is as small as this, relative to its parts, is rounding: sums over nodes. Not met.
pub(crate) const ROUNDING: f64 = 1e-12;
/// An equation whose residual is this small, relative to its parts, is solved, and what follows from its solution is known to
/// this: linear systems, whose conditions multiply the rounding of their entries. Not met.
pub(crate) const SOLVED: f64 = 1e-9;
/// Steps of a converging iteration are at most this share of the one before, in the measure of the iteration: those of Newton's
/// method near a solution are far smaller, and what falls more slowly has come down to noise. 0, −3 %.
pub(crate) const CONVERGING: f64 = 0.5;
/// An estimated L¹ error above this is worth another attempt, and a warning if that does not help. Not met.
pub(crate) const UNRELIABLE: f64 = 0.2;

/// Poisson impulses.
pub(crate) mod impulses {
    /// Nodes of a Gauss rule for amplitudes. 6 to 40 give the same to a tenth for the normal law.
    pub(crate) const AMPLITUDES: usize = 12;
    /// The same for laws with an exponential tail on a side: those that leave the domain are left out, so that 20 leave 1e-2
    /// of L¹ in one state.
    pub(crate) const ONE_SIDED: usize = 60;
    /// The least mass of a reference on a domain that is cut at the first fall of its density from the mean outwards; of three pilots
    /// of an oscillator with two wells one had a fall between them.
    pub(crate) const KEPT: f64 = 0.999;
    /// Impulses alone, fewer than this in the time in which volumes of the state space shrink by a factor e at rest: the density is
    /// rough or unbounded there, and no polynomial follows it.
    pub(crate) const RARE: f64 = 2.0;
    /// The states from which the drift is followed to find that time.
    pub(crate) const FLOWS: usize = 8;
}

/// Step 1: the pilot.
pub(crate) mod pilot {
    /// The states of a pilot, without their mirror images, where nodes carry the density. −28 %, +7 %.
    pub(crate) const STATES: usize = 20_000;
    /// The same where they carry the density themselves. The standard error of E x² of an oscillator under filtered noise is
    /// 1.8 times as large, or 0.44 times.
    pub(crate) const CARRYING_STATES: usize = 102_400;
    /// The same next to walls in three states and more, where functions with kinks have larger variances: the L¹ distance of
    /// the displacement and its velocity from a long simulation, 5e-3, is 9e-3 with a quarter of them.
    pub(crate) const CARRYING_STATES_AT_WALLS: usize = 409_600;
    /// Trajectories: path-steps are cheapest in multiples of so many.
    pub(crate) const TRAJECTORIES: usize = 512;
    /// The time step times the fastest rate: moments are off by some tenths of a percent. +5 %, −3 %.
    pub(crate) const STEP: f64 = 0.4;
    /// The same next to walls in three states and more, whose impacts no calibration corrects: with [`STEP`] E xy of an
    /// oscillator under filtered noise above a wall was off by 0.5 %, with 0.1 by up to 0.27 %.
    pub(crate) const STEP_AT_WALLS: f64 = 0.04;
    /// The most impulses in the shortest of the system's times, and in a time step, on average. Bounds on work.
    pub(crate) const MOST_OFTEN: f64 = 1e3;
    pub(crate) const MOST_IMPULSES: f64 = 4.0;
    /// The time between states times the fastest rate. +7 %, +6 %.
    pub(crate) const INTERVAL: f64 = 4.0;
    /// The factor on the noise intensities by which the states reach the tails. 5.8 times as large, +19 %.
    pub(crate) const INFLATION: f64 = 3.0;
    /// A kurtosis above this is that of a power tail, in which an inflated pilot spreads too wide for any polynomial; limit
    /// cycles, wells and hardening springs are below 3 or near it. Not met.
    pub(crate) const HEAVY: f64 = 8.0;
    /// How often the time step is halved after an explosion. Not met.
    pub(crate) const HALVINGS: u32 = 3;
    /// How often the burn-in is doubled while the samples still change. Not met.
    pub(crate) const DOUBLINGS: u32 = 5;
    /// The two halves of the samples of a stationary pilot differ by at most so many standard errors. Not met.
    pub(crate) const DRIFTING: f64 = 6.0;
    /// Groups of trajectories whose spread is that standard error. Not met.
    pub(crate) const GROUPS: usize = 32;
    /// Where more consecutive states than this are worth one, they are taken farther apart.
    pub(crate) const CORRELATED: f64 = 3.0;
    /// The longest time between states, relative to [`INTERVAL`]. A bound on work.
    pub(crate) const LONGER: f64 = 64.0;
    /// Where so many of the states taken farther apart are still worth only one, the trajectories have not left their starts.
    const UNMIXED: f64 = 16.0;
    /// The same as a share of all states of a trajectory: those of a Brownian motion are all worth one.
    const UNMIXED_SHARE: f64 = 0.75;

    /// The number of states worth one from which on trajectories of so many states have not left their starts.
    pub(crate) fn unmixed(samples: usize) -> f64 {
        UNMIXED.min(UNMIXED_SHARE * samples as f64)
    }

    /// Whether trajectories of so many states have stayed where they began, as in wells that nothing leaves; of fewer than eight it shows
    /// too little.
    pub(crate) fn stayed(slowness: f64, samples: usize) -> bool {
        samples >= 8 && slowness > UNMIXED_SHARE * samples as f64
    }

    /// A pilot is made longer only up to so many time steps of all trajectories, where noise does not depend on the state:
    /// seconds. A bound on work.
    pub(crate) const MOST_PATH_STEPS: f64 = 2.5e8;
    /// The path-steps that an impulse costs as much as.
    pub(crate) const ALONE: f64 = 16.0;
    /// The fewest states between two walls that suffice for the likelihood of a density.
    pub(crate) const LEAST_BETWEEN: usize = 100;
}

/// Step 2: the trust domain.
pub(crate) mod domain {
    /// What stands for the pilot's states is as much wider than they are: the trust domain's radius next to walls and in many
    /// states, and the variance of draws.
    pub(crate) const WIDENING: f64 = 1.1;
    /// The variance of draws next to walls in three states and more. By 1.15, E v⁴ of new draws was off by 1.4 %.
    pub(crate) const WIDENING_AT_WALLS: f64 = 1.5;
    /// The share of the states that is left out there, the farthest ones.
    pub(crate) const CUT_AT_WALLS: f64 = 5e-5;
    /// The most by which the domain is widened where the first guess has not fallen enough.
    pub(crate) const FOLLOWED: f64 = 1.4;
    /// The domain ends where the first guess has fallen to e^−18 = 1.5e-8 of its peak. 12 times as large, −2 %.
    pub(crate) const DROP: f64 = 18.0;
    /// The answer is defined where the reference is above e^−13.8 = 1e-6 of its peak. +47 %, +7 %.
    pub(crate) const KEPT: f64 = 13.8;
    /// Next to walls it ends, as does that of an exact density, at e^−32 = 1e-14 of the peak.
    pub(crate) const FULL_DROP: f64 = 32.0;
    /// Next to walls the answer is defined where the reference is above e^−21 = 1e-9 of its highest value at a node, which next
    /// to a grazing point is far above the rest.
    pub(crate) const WALLED_KEPT: f64 = 21.0;
    /// The most by which the domain is widened for an exact density on Gauss nodes.
    pub(crate) const EXACT_FOLLOWED: f64 = 3.0;
    /// The factor on it on a lattice, whose nodes it must not exhaust.
    pub(crate) const EXACT_ON_LATTICE: f64 = 1.8;
    /// The factor on the domain of a lattice that carries a reference.
    pub(crate) const BY_REFERENCE: f64 = 1.2;
    /// A guess that rises again so far below its peak, in ln p, is not followed any farther.
    pub(crate) const RISING: f64 = 5.0;
    /// The least fall of ln p at the edge, for each reach.
    pub(crate) const STEEP: f64 = 20.0;
}

/// Step 2: the nodes.
pub(crate) mod nodes {
    /// Gauss nodes along each state, in one state and in two.
    pub(crate) const FINE: [usize; 2] = [240, 80];
    /// The same for the first guess. +5 %, +6 %.
    pub(crate) const COARSE: usize = 40;
    /// Up to this order, whose functions are smoother, fewer nodes suffice, and the answer is faster. 0, +5 %.
    pub(crate) const LOW_ORDER: u32 = 5;
    /// So many along each of two states, without impulses and with them. +1 %, 0.
    pub(crate) const LOW_ORDER_NODES: [usize; 2] = [44, 56];
    /// Nodes on either side of 0 along a line, for integrals over one state. Not met.
    pub(crate) const LINE: usize = 72;
    /// Panels from a wall on, in s with the distance u = u_max s³, since the density varies with ∛u: u/u_max at the end of
    /// each, and its nodes.
    pub(crate) const CUBED: [(f64, usize); 5] = [(1e-5, 6), (1e-4, 7), (1e-3, 7), (0.006, 7), (0.03, 7)];
    /// The panels beyond them, in u itself.
    pub(crate) const PLAIN: [(f64, usize); 4] = [(0.12, 8), (0.35, 10), (0.65, 10), (1.0, 10)];
    /// Panels in the speed on either side of 0, relative to the largest, likewise.
    pub(crate) const SPEEDS: [(f64, usize); 6] = [(0.006, 7), (0.03, 7), (0.12, 7), (0.3, 8), (0.6, 9), (1.0, 9)];
    /// Nodes in each of these panels on the wall itself. Not met.
    pub(crate) const ON_WALL: usize = 16;
}

/// Step 2: the first guess of ln p.
pub(crate) mod guess {
    use crate::numerics::Search;

    /// The degree of the polynomial that the pilot's states are fitted by.
    pub(crate) const DEGREE: u32 = 8;
    /// The same beside the singular part next to walls, and at least on a lattice.
    pub(crate) const LOW_DEGREE: u32 = 4;
    /// The search for the most likely density: its tolerance, in standard deviations of ln p, is far below the states' noise.
    pub(crate) const SEARCH: Search = Search { tolerance: 1e-6, most: 80 };
}

/// Step 3: the functions.
pub(crate) mod space {
    use crate::closure::space::{ContactLevel, WallLevel};

    /// The highest order.
    pub(crate) const HIGHEST_ORDER: u32 = 16;
    /// The highest order for which a wall's reference is accurate enough.
    pub(crate) const HIGHEST_ORDER_AT_WALLS: u32 = 10;
    /// The degree of a reference above that of the closure, by the number of states; four have too many functions for more.
    pub(crate) const EXCESS: [u32; 4] = [8, 8, 8, 4];
    /// The highest degrees, where the edge of the domain shows as ripples; a correction may be cut off below them.
    pub(crate) const BUFFER: u32 = 4;
    /// The same next to walls: the level that the weight is sought in, and that of the reference with the next lower one.
    pub(crate) const WALLED: [WallLevel; 3] = [
        WallLevel { degree: 8, kinks: 5, depth: 3, angular: 7 },
        WallLevel { degree: 10, kinks: 5, depth: 4, angular: 9 },
        WallLevel { degree: 12, kinks: 5, depth: 4, angular: 9 },
    ];
    /// Next to walls in three states and more, besides the polynomials of the order: the functions of the closure, and those by
    /// which its error is estimated. Polynomials of degree 0 in the other states left an oscillator beside a second mass with
    /// twice the residual.
    pub(crate) const AT_WALLS: [ContactLevel; 2] = [beside(3, 5, 1), beside(4, 7, 2)];
    /// The same in three states.
    pub(crate) const AT_WALLS_OF_THREE: [ContactLevel; 2] = [beside(3, 5, 2), beside(4, 7, 2)];
    /// The same for orders below four.
    pub(crate) const AT_WALLS_LOW: [ContactLevel; 2] = [beside(2, 3, 1), beside(3, 5, 2)];

    const fn beside(kinks: u32, angular: u32, others: u32) -> ContactLevel {
        ContactLevel { plane: WallLevel { degree: 0, kinks, depth: 3, angular }, others }
    }

    /// Of more functions than this means have no covariance, no degree above the sixth is tested, and a part of the nodes makes
    /// the curvature. A bound on work.
    pub(crate) const MANY: usize = 300;
    /// More functions than this have no reference on a lattice (degree 18 in three states, 10 in four); and where the density
    /// of samples two degrees higher has more, only those of one and of two states are taken beyond the order. A bound on
    /// work.
    pub(crate) const MOST: usize = 800;
    /// The same two next to walls in three states and more.
    pub(crate) const MANY_AT_WALLS: usize = 480;
    /// See [`MANY_AT_WALLS`].
    pub(crate) const MOST_AT_WALLS: usize = 260;
    /// A function that is a combination of those before it up to this relative size is dependent on them. Rounding.
    pub(crate) const DEPENDENT: f64 = 1e-13;
    /// Functions are nearly orthonormal under a measure where the pivots of Cholesky's factor of their Gram matrix differ by
    /// less than this factor: it is then right to 1e-7, and mostly to 1e-10. 98 % of the measures of random systems.
    pub(crate) const NEAR: f64 = 30.0;
}

/// Step 4: the reference.
pub(crate) mod reference {
    /// The power of the density that the weight follows: flatter than the density, for the tails' sake. +6 %, +34 %.
    pub(crate) const FLATNESS: f64 = 0.6;
    /// How often the weight is renewed at most. Not met.
    pub(crate) const RENEWALS: usize = 8;
    /// A weight settles within so many renewals from an initial one. −7 %, +5 %.
    pub(crate) const SETTLING: usize = 3;
    /// The error may grow by this factor once while the weight settles. +1 %, 0.
    pub(crate) const PATIENCE: f64 = 2.0;
    /// Two errors count as the same up to this factor: a later density is then preferred to an earlier one, and a weight that
    /// starts from that of a similar system has settled once its correction is the same as there. −8 %, +7 %.
    pub(crate) const SAME: f64 = 1.5;
    /// Where the initial weight leads to a larger error, in L¹, another one is tried. Not met.
    pub(crate) const GOOD: f64 = 0.05;
    /// A reference's error below this share of the answer's distance from it needs no further attempt. Not met.
    pub(crate) const MINOR: f64 = 0.7;
    /// Nor does one that is as small as this, in L¹. Not met.
    pub(crate) const FINE: f64 = 2e-5;
    /// The ratio of the density to its weight is cut off at this factor, upwards and downwards, before its logarithm is taken.
    /// +4 %, ±1 %.
    pub(crate) const CUT: f64 = 20.0;
    /// A reference on Gauss nodes with a larger error, in L¹, is not used: the pilot's own fit is better. On a lattice, where
    /// the search starts from that fit, it does not go on from such an error. Not met.
    pub(crate) const UNKNOWN: f64 = 1.0;
    /// One on a lattice, where the calibrated means are the alternative, is not used above this.
    pub(crate) const UNSOLVED: f64 = 0.1;
    /// Nor where its moments are farther than so many standard errors from the pilot's.
    pub(crate) const CONTRADICTED: f64 = 5.0;
    /// The most nodes times functions of one on a lattice: four tables of so many numbers take 500 MB.
    pub(crate) const MOST_ENTRIES: usize = 16_000_000;
}

/// Step 5: the projection.
pub(crate) mod projection {
    use crate::numerics::Search;

    /// The power of the density that stands for its tails in the weight.
    pub(crate) const FLAT: f64 = 0.3;
    /// The search; its tolerance is a distance between logarithms.
    pub(crate) const SEARCH: Search = Search { tolerance: 1e-10, most: 60 };
    /// The powers of the weight under which least squares give a start where those under the weight itself do not.
    pub(crate) const FLATTER: [f64; 3] = [0.6, 0.3, 0.1];
    /// The distance with which one of them is good enough.
    pub(crate) const NEAR: f64 = 0.1;
}

/// Step 5: densities that are exact.
pub(crate) mod exact {
    /// The orders at which known densities are exact.
    pub(crate) const LOWER_ORDERS: [u32; 4] = [2, 4, 6, 8];
    /// A density whose distance from the reference exceeds the reference's own error by this factor is not exact. Halved, it
    /// misses the exact density of two wells at order 6.
    pub(crate) const POLISHABLE: f64 = 30.0;
    /// The root mean square of the residual, relative to its parts, above which no solution is near. Not met.
    pub(crate) const NEAR: f64 = 0.3;
    /// The most steps of Newton's method, each of which converges. Not met.
    pub(crate) const STEPS: usize = 12;
    /// The states at which the residual is to vanish, and those by which its root is first guessed. Bounds on work: three times as many
    /// give the same.
    pub(crate) const AT_STATES: [usize; 2] = [4000, 20_000];
    /// Of more functions none is sought there. A bound on work.
    pub(crate) const MOST: usize = 150;
}

/// Step 6: the candidates.
pub(crate) mod candidates {
    /// The tails are compared with the reference's down to this share of the peak. −28 %, −6 %, by the tails that are then not
    /// fitted.
    pub(crate) const TAIL: f64 = 1e-5;
    /// The power of the reference under which it is smoothed, so that its ripples there do not count.
    pub(crate) const SMOOTHED: f64 = 0.5;
    /// They are right within so many decades of it. 0, −5 %.
    pub(crate) const WELL: f64 = 0.17;
    /// And within so many where the estimated L¹ error is [`PRICE`] times the least already. +7 %, −3 %.
    pub(crate) const ENOUGH: f64 = 0.25;
    /// The factor on the L¹ error that tails may cost. 0, +7 %.
    pub(crate) const PRICE: f64 = 1.33;
    /// While the estimated L¹ error is larger, all weight goes to the middle. −28 %, where the tails then get no weight; 0.
    pub(crate) const MIDDLE: f64 = 0.0115;
    /// The largest share of the weight that the tails get by default. 0, 0.
    pub(crate) const LARGEST_SHARE: f64 = 0.14;
    /// The pilot's states whose likelihood is taken: enough for a guard against gross errors. Not met.
    pub(crate) const VALIDATION_STATES: usize = 4000;
    /// How many consecutive states of a trajectory count as one in what a density may lose by chance. In a prototype, spurious
    /// roots lost 0.1 to 5 in mean ln p, far more than this allows. Not met.
    pub(crate) const CORRELATED: f64 = 50.0;
    /// A low order may lose this much in mean ln p and still be the best of its order: an L¹ error of 0.2 costs about this. Not
    /// met.
    pub(crate) const LEAST_LOSS: f64 = 0.05;
}

/// Step 7: impacts in three states and more.
pub(crate) mod walls {
    /// The density's own impact rate is off from so many standard errors of the counted one on,
    pub(crate) const ERRORS: f64 = 3.0;
    /// and this share of it.
    pub(crate) const SHARE: f64 = 0.003;
}

/// Step 7: the density.
pub(crate) mod density {
    /// ‖F‖ below which all Galerkin equations hold to rounding.
    pub(crate) const ROOT: f64 = 1e-8;
    /// Draws for integrals: a standard error of some tenths of a percent for fourth moments in ten states.
    pub(crate) const DRAWS: usize = 400_000;
    /// Random shifts of their lattice: the spread between them is the standard error.
    pub(crate) const SHIFTS: usize = 16;
    /// A section gets this part of the draws that a mean gets: a marginal is computed at many places.
    pub(crate) const OF_A_SECTION: usize = 8;
}

/// The literature's closure.
pub(crate) mod classical {
    /// Iterations before a search counts as stalled; roots are found in 4 to 20.
    pub(crate) const STEPS: usize = 60;
    /// A step is cut at most to 2⁻¹².
    pub(crate) const HALVINGS: u32 = 12;
    /// A full step this much smaller than the iterate is at the level of the Jacobian's own rounding.
    pub(crate) const STEP: f64 = 1e-11;
    /// Earlier iterates that a step to the weight's fixed point is combined from.
    pub(crate) const MEMORY: usize = 4;
    /// Steps along the path of a homotopy before it is given up. A bound on work.
    pub(crate) const PATH_STEPS: usize = 600;
    /// The longest and the shortest of them, in the norm of the coefficients and of the path's parameter together.
    pub(crate) const LONGEST: f64 = 0.3;
    /// See [`LONGEST`].
    pub(crate) const SHORTEST: f64 = 1e-7;
    /// Correctors that need more iterations than this halve the step.
    pub(crate) const CORRECTIONS: usize = 6;
    /// Coefficients this large (in an orthonormal basis) mean that the path goes to infinity.
    pub(crate) const FAR_AWAY: f64 = 1e4;
}
