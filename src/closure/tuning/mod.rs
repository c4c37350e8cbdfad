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

/// A number as small as this, relative to its parts, is rounding: what sums over some thousand nodes leave of sixteen digits. None
/// of nine closures of orders 4 to 8 depends on it.
pub(crate) const ROUNDING: f64 = 1e-12;
/// An equation whose residual is this small, relative to its parts, is solved, and what follows from its solution is right to this:
/// linear systems, whose conditions multiply the rounding of their entries. None of nine closures of orders 4 to 8 depends on it.
pub(crate) const SOLVED: f64 = 1e-9;
/// Steps of a converging iteration are at most this share of the one before, in the measure of the iteration: those of Newton's
/// method near a solution are far smaller, and what falls more slowly has come down to noise. Halved or doubled, it changes L¹
/// errors of nine closures of orders 4 to 8 by up to 0 or −3 %.
pub(crate) const CONVERGING: f64 = 0.5;
/// An estimated L¹ error above this is worth another attempt, and a warning if that does not help; that of a derivative counts
/// relative to its size. None of nine closures of orders 4 to 8 depends on it.
pub(crate) const UNRELIABLE: f64 = 0.2;

/// Poisson impulses.
pub(crate) mod impulses {
    /// Gauss nodes for the amplitudes of Poisson impulses without an exponential tail; 6 to 40 give the same to a tenth for the
    /// normal law.
    pub(crate) const AMPLITUDES: usize = 12;
    /// Gauss nodes for the amplitudes of Poisson impulses with an exponential tail: those that leave the domain are left out, so
    /// that 20 nodes leave an L¹ error of 1e-2 in one state.
    pub(crate) const ONE_SIDED: usize = 60;
    /// The least mass of a reference under impulses on a domain that is cut at the first fall of its density from the mean
    /// outwards; of three pilots of an oscillator with two wells one had a fall between them.
    pub(crate) const KEPT: f64 = 0.999;
    /// Impulses alone are rare where fewer than this come in the time in which volumes of the state space shrink by a factor e at
    /// rest: the density is rough or unbounded there, and no polynomial follows it.
    pub(crate) const RARE: f64 = 2.0;
    /// The states of the pilot from which the drift is followed to rest, where impulses are counted against the rate at which
    /// volumes of the state space shrink.
    pub(crate) const FLOWS: usize = 8;
}

/// Step 1: the pilot.
pub(crate) mod pilot {
    /// The states of a pilot, without their mirror images, where nodes carry the density. Halved or doubled, it changes L¹ errors
    /// of nine closures of orders 4 to 8 by up to −28 % or +7 %.
    pub(crate) const STATES: usize = 20_000;
    /// The states of a pilot, without their mirror images, where they carry the density themselves. Halved or doubled, it makes the
    /// standard error of E x² of an oscillator under filtered noise 1.8 or 0.44 times as large.
    pub(crate) const CARRYING_STATES: usize = 102_400;
    /// The states of a pilot that carry the density next to walls in three states and more, where functions with kinks have larger
    /// variances: the L¹ distance of the displacement and its velocity from a long simulation, 5e-3, is 9e-3 with a quarter of
    /// them.
    pub(crate) const CARRYING_STATES_AT_WALLS: usize = 409_600;
    /// The trajectories of a pilot: path-steps are cheapest in multiples of so many.
    pub(crate) const TRAJECTORIES: usize = 512;
    /// The time step of a pilot times the fastest rate: moments are off by some tenths of a percent. Halved or doubled, it changes
    /// L¹ errors of nine closures of orders 4 to 8 by up to +5 % or −3 %.
    pub(crate) const STEP: f64 = 0.4;
    /// The time step of a pilot times the fastest rate next to walls in three states and more, whose impacts no calibration
    /// corrects: E xy of an oscillator under filtered noise above a wall was off by 0.5 % with 0.4, and by up to 0.27 % with 0.1.
    pub(crate) const STEP_AT_WALLS: f64 = 0.04;
    /// The most impulses in the shortest of the system's times, on average: a bound on work.
    pub(crate) const MOST_OFTEN: f64 = 1e3;
    /// The most impulses in a time step of a pilot, on average: a bound on work.
    pub(crate) const MOST_IMPULSES: f64 = 4.0;
    /// The time between states of a pilot times the fastest rate. Halved or doubled, it changes L¹ errors of nine closures of
    /// orders 4 to 8 by up to +7 % or +6 %.
    pub(crate) const INTERVAL: f64 = 4.0;
    /// The factor on a pilot's noise intensities by which its states reach the tails. Halved or doubled, it makes an L¹ error of
    /// nine closures of orders 4 to 8 up to 5.8 times as large, or 19 % larger.
    pub(crate) const INFLATION: f64 = 3.0;
    /// A kurtosis above this is that of a power tail, in which an inflated pilot spreads too wide for any polynomial; limit cycles,
    /// wells and hardening springs are below 3 or near it. None of nine closures of orders 4 to 8 depends on it.
    pub(crate) const HEAVY: f64 = 8.0;
    /// How often the time step of a pilot is halved after explosions, at most. None of nine closures of orders 4 to 8 depends on
    /// it.
    pub(crate) const HALVINGS: u32 = 3;
    /// How often the burn-in of a pilot is doubled while its samples still change, at most. None of nine closures of orders 4 to 8
    /// depends on it.
    pub(crate) const DOUBLINGS: u32 = 5;
    /// Mean squares over the two halves of the samples of a stationary pilot differ by at most so many standard errors. None of
    /// nine closures of orders 4 to 8 depends on it.
    pub(crate) const DRIFTING: f64 = 6.0;
    /// Groups of a pilot's trajectories, whose spread is the standard error of the difference between the halves of its samples.
    /// None of nine closures of orders 4 to 8 depends on it.
    pub(crate) const GROUPS: usize = 32;
    /// Where more consecutive states of a trajectory than this are worth one independent state, the pilot's states are taken
    /// farther apart.
    pub(crate) const CORRELATED: f64 = 3.0;
    /// The largest factor by which a pilot's states are taken farther apart: a bound on work.
    pub(crate) const LONGER: f64 = 64.0;
    /// Where so many consecutive states of a trajectory, taken farther apart, are still worth only one, the trajectories have not
    /// left their starts.
    const UNMIXED: f64 = 16.0;
    /// Where this share of all states of a trajectory is worth only one, the trajectories have not left their starts: those of a
    /// Brownian motion are all worth one.
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

    /// A pilot is made longer or finer only up to so many time steps of all trajectories, where noise does not depend on the state:
    /// a bound on work, of seconds.
    pub(crate) const MOST_PATH_STEPS: f64 = 2.5e8;
    /// An impulse costs as much as so many time steps of a trajectory.
    pub(crate) const ALONE: f64 = 16.0;
    /// The fewest states of a pilot between two walls that suffice for the likelihood of a density.
    pub(crate) const LEAST_BETWEEN: usize = 100;
}

/// Step 2: the trust domain.
pub(crate) mod domain {
    /// The radius of the trust domain, next to walls and in many states, relative to the farthest of the pilot's states, and the
    /// variance of draws relative to that of these states.
    pub(crate) const WIDENING: f64 = 1.1;
    /// The variance of draws relative to that of the pilot's states next to walls in three states and more; with 1.15, E v⁴ of new
    /// draws was off by 1.4 %.
    pub(crate) const WIDENING_AT_WALLS: f64 = 1.5;
    /// The share of the pilot's states, the farthest ones, that is left out of the trust domain next to walls in three states and
    /// more.
    pub(crate) const CUT_AT_WALLS: f64 = 5e-5;
    /// The largest factor by which the domain is widened where the first guess has not fallen enough at its edge.
    pub(crate) const FOLLOWED: f64 = 1.4;
    /// The domain ends where the first guess has fallen to e^−18 = 1.5e-8 of its peak. Halved or doubled, it makes an L¹ error of
    /// nine closures of orders 4 to 8 up to 12 times as large, or 2 % smaller.
    pub(crate) const DROP: f64 = 18.0;
    /// The answer is defined where the reference is above e^−13.8 = 1e-6 of its peak. Halved or doubled, it changes L¹ errors of
    /// nine closures of orders 4 to 8 by up to +47 % or +7 %.
    pub(crate) const KEPT: f64 = 13.8;
    /// The domain of an exact density, and any domain next to walls in two states, ends at e^−32 = 1e-14 of the peak.
    pub(crate) const FULL_DROP: f64 = 32.0;
    /// Next to walls in two states the answer is defined where the reference is above e^−21 = 1e-9 of its highest value, which next
    /// to a grazing point is far above the rest.
    pub(crate) const WALLED_KEPT: f64 = 21.0;
    /// The largest factor by which the domain is widened for an exact density on Gauss nodes.
    pub(crate) const EXACT_FOLLOWED: f64 = 3.0;
    /// The factor by which the domain is widened for an exact density on a lattice, whose nodes it must not exhaust.
    pub(crate) const EXACT_ON_LATTICE: f64 = 1.8;
    /// The factor by which the domain of a lattice that carries a reference is widened.
    pub(crate) const BY_REFERENCE: f64 = 1.2;
    /// A guess that rises again so far below its peak, in ln p, is not followed any farther.
    pub(crate) const RISING: f64 = 5.0;
    /// The least slope of the fall of ln p at the edge of the domain, per length of its reach, by which the mass beyond is
    /// estimated.
    pub(crate) const STEEP: f64 = 20.0;
}

/// Step 2: the nodes.
pub(crate) mod nodes {
    /// Gauss nodes along each state, in one state and in two.
    pub(crate) const FINE: [usize; 2] = [240, 80];
    /// Gauss nodes along each state for the first guess. Halved or doubled, it changes L¹ errors of nine closures of orders 4 to 8
    /// by up to +5 % or +6 %.
    pub(crate) const COARSE: usize = 40;
    /// Up to this order, whose functions are smoother, fewer nodes suffice in two states, and the answer is faster. Halved or
    /// doubled, it changes L¹ errors of nine closures of orders 4 to 8 by up to 0 or +5 %.
    pub(crate) const LOW_ORDER: u32 = 5;
    /// Gauss nodes along each of two states for low orders, without impulses and with them. Halved or doubled, it changes L¹ errors
    /// of nine closures of orders 4 to 8 by up to +1 % or 0.
    pub(crate) const LOW_ORDER_NODES: [usize; 2] = [44, 56];
    /// Gauss nodes on either side of 0, or of the middle, along a line across the domain, for integrals over one state. None of
    /// nine closures of orders 4 to 8 depends on it.
    pub(crate) const LINE: usize = 72;
    /// Panels from a wall on, in s with the distance u = u_max s³, since the density varies with ∛u: u/u_max at the end of each,
    /// and its nodes.
    pub(crate) const CUBED: [(f64, usize); 5] = [(1e-5, 6), (1e-4, 7), (1e-3, 7), (0.006, 7), (0.03, 7)];
    /// Panels in the distance u from a wall, beyond those that are graded by its cube root: u/u_max at the end of each, and its
    /// nodes.
    pub(crate) const PLAIN: [(f64, usize); 4] = [(0.12, 8), (0.35, 10), (0.65, 10), (1.0, 10)];
    /// Panels in the speed on either side of 0, next to walls: the speed at the end of each, relative to the largest, and its
    /// nodes.
    pub(crate) const SPEEDS: [(f64, usize); 6] = [(0.006, 7), (0.03, 7), (0.12, 7), (0.3, 8), (0.6, 9), (1.0, 9)];
    /// Nodes in each panel of speeds on a wall itself, for its impacts. None of nine closures of orders 4 to 8 depends on it.
    pub(crate) const ON_WALL: usize = 16;
}

/// Step 2: the first guess of ln p.
pub(crate) mod guess {
    use crate::numerics::Search;

    /// The degree of the polynomial that the pilot's states are fitted by, as the first guess of ln p.
    pub(crate) const DEGREE: u32 = 8;
    /// The degree of the first guess of ln p beside its singular part next to walls, its least order on a lattice, and the order
    /// that is tried first where trajectories stayed where they began.
    pub(crate) const LOW_DEGREE: u32 = 4;
    /// The search for the most likely density: its tolerance, in standard deviations of ln p, is far below the states' noise.
    pub(crate) const SEARCH: Search = Search { tolerance: 1e-6, most: 80 };
}

/// Step 3: the functions.
pub(crate) mod space {
    use crate::closure::space::{ContactLevel, WallLevel};

    /// The highest order of a closure.
    pub(crate) const HIGHEST_ORDER: u32 = 16;
    /// The highest order of a closure next to walls in two states, for which a wall's reference is accurate enough.
    pub(crate) const HIGHEST_ORDER_AT_WALLS: u32 = 10;
    /// The degree of a reference above the order of the closure, by the number of states; four have too many functions for more.
    pub(crate) const EXCESS: [u32; 4] = [8, 8, 8, 4];
    /// The number of highest degrees of a reference's correction, where the edge of the domain shows as ripples; the correction may
    /// be cut off below them.
    pub(crate) const BUFFER: u32 = 4;
    /// The levels of functions next to walls in two states: that of the weight, and those of the reference without and with its
    /// highest functions.
    pub(crate) const WALLED: [WallLevel; 3] = [
        WallLevel { degree: 8, kinks: 5, depth: 3, angular: 7 },
        WallLevel { degree: 10, kinks: 5, depth: 4, angular: 9 },
        WallLevel { degree: 12, kinks: 5, depth: 4, angular: 9 },
    ];
    /// The functions besides the polynomials of an order next to walls in four states and more: those of the closure, and those by
    /// which its error is estimated. Polynomials of degree 0 in the other states left an oscillator beside a second mass with twice
    /// the residual.
    pub(crate) const AT_WALLS: [ContactLevel; 2] = [beside(3, 5, 1), beside(4, 7, 2)];
    /// The functions besides the polynomials of an order next to walls in three states: those of the closure, and those by which
    /// its error is estimated.
    pub(crate) const AT_WALLS_OF_THREE: [ContactLevel; 2] = [beside(3, 5, 2), beside(4, 7, 2)];
    /// The functions besides the polynomials of an order below four next to walls in three states and more: those of the closure,
    /// and those by which its error is estimated.
    pub(crate) const AT_WALLS_LOW: [ContactLevel; 2] = [beside(2, 3, 1), beside(3, 5, 2)];

    const fn beside(kinks: u32, angular: u32, others: u32) -> ContactLevel {
        ContactLevel { plane: WallLevel { degree: 0, kinks, depth: 3, angular }, others }
    }

    /// Of more functions than this means have no covariance, no degree above the sixth is tested, and a part of the nodes makes the
    /// curvature: a bound on work.
    pub(crate) const MANY: usize = 300;
    /// The most functions of a reference on a lattice (degree 18 in three states, 10 in four) and of equations for derivatives on
    /// samples: a bound on work. Where the density of samples two degrees higher has more, only those of one and of two states are
    /// taken beyond the order.
    pub(crate) const MOST: usize = 800;
    /// Of more functions than this means have no covariance next to walls in three states and more: a bound on work.
    pub(crate) const MANY_AT_WALLS: usize = 480;
    /// Where the density of samples two degrees higher has more polynomials than this, next to walls in three states and more, only
    /// those of one and of two states are taken beyond the order: a bound on work.
    pub(crate) const MOST_AT_WALLS: usize = 260;
    /// A function that is a combination of those before it up to this relative size, which is rounding, is dependent on them.
    pub(crate) const DEPENDENT: f64 = 1e-13;
    /// Functions are nearly orthonormal under a measure where the pivots of Cholesky's factor of their Gram matrix differ by less
    /// than this factor, as under 98 % of the measures of random systems: it is then right to 1e-7, and mostly to 1e-10.
    pub(crate) const NEAR: f64 = 30.0;
}

/// Step 4: the reference.
pub(crate) mod reference {
    /// The power of the density under which the weight of a reference is fitted: flatter than the density, for the tails' sake.
    /// Halved or doubled, it changes L¹ errors of nine closures of orders 4 to 8 by up to +6 % or +34 %.
    pub(crate) const FLATNESS: f64 = 0.6;
    /// The most weights of a reference, each renewed from the solution under the one before. None of nine closures of orders 4 to 8
    /// depends on it.
    pub(crate) const RENEWALS: usize = 8;
    /// The weight of a reference settles within so many renewals from an initial one. Halved or doubled, it changes L¹ errors of
    /// nine closures of orders 4 to 8 by up to −7 % or +5 %.
    pub(crate) const SETTLING: usize = 3;
    /// The error of a reference may grow by more than this factor once while its weight settles. Halved or doubled, it changes L¹
    /// errors of nine closures of orders 4 to 8 by up to +1 % or 0.
    pub(crate) const PATIENCE: f64 = 2.0;
    /// Two errors of a reference count as the same up to this factor: a later density is then preferred to an earlier one, and a
    /// weight that starts from that of a similar system has settled once its correction is the same as there. Halved or doubled, it
    /// changes L¹ errors of nine closures of orders 4 to 8 by up to −8 % or +7 %.
    pub(crate) const SAME: f64 = 1.5;
    /// Where the initial weight of a reference leads to an L¹ error above this, another one is tried. None of nine closures of
    /// orders 4 to 8 depends on it.
    pub(crate) const GOOD: f64 = 0.05;
    /// A reference's error below this share of the answer's distance from it needs no further attempt. None of nine closures of
    /// orders 4 to 8 depends on it.
    pub(crate) const MINOR: f64 = 0.7;
    /// A reference with an L¹ error as small as this needs no further attempt, and a density as close to it may be exact. None of
    /// nine closures of orders 4 to 8 depends on it.
    pub(crate) const FINE: f64 = 2e-5;
    /// The factor at which the ratio of a reference's density to its weight is cut off, upwards and downwards, before its logarithm
    /// is taken. Halved or doubled, it changes L¹ errors of nine closures of orders 4 to 8 by up to +4 % or ±1 %.
    pub(crate) const CUT: f64 = 20.0;
    /// A reference on Gauss nodes with an L¹ error above this is not used, as the pilot's own fit is better; on a lattice, where
    /// the search starts from that fit, it does not go on from such an error. None of nine closures of orders 4 to 8 depends on it.
    pub(crate) const UNKNOWN: f64 = 1.0;
    /// A reference on a lattice, where the calibrated means are the alternative, is not used with an L¹ error above this.
    pub(crate) const UNSOLVED: f64 = 0.1;
    /// A reference on a lattice is not used where a moment of it is farther than so many standard errors from the pilot's.
    pub(crate) const CONTRADICTED: f64 = 5.0;
    /// The most nodes times functions of a reference on a lattice: four tables of so many numbers take 500 MB.
    pub(crate) const MOST_ENTRIES: usize = 16_000_000;
}

/// Step 5: the projection.
pub(crate) mod projection {
    use crate::numerics::Search;

    /// The power of the density that stands for its tails in the weight of a fit.
    pub(crate) const FLAT: f64 = 0.3;
    /// The search for the closest exponential polynomial: its tolerance is a distance between logarithms.
    pub(crate) const SEARCH: Search = Search { tolerance: 1e-10, most: 60 };
    /// The powers of the weight under which least squares give a start for a fit where those under the weight itself do not.
    pub(crate) const FLATTER: [f64; 3] = [0.6, 0.3, 0.1];
    /// The distance, in the measure that a fit makes least, at which a start by least squares is good enough.
    pub(crate) const NEAR: f64 = 0.1;
}

/// Step 5: densities that are exact.
pub(crate) mod exact {
    /// The orders at which known densities are exact: those below the order of the closure are tried.
    pub(crate) const LOWER_ORDERS: [u32; 4] = [2, 4, 6, 8];
    /// A density whose L¹ distance from the reference exceeds the reference's own error by this factor is not exact. Halved, it
    /// misses the exact density of two wells at order 6.
    pub(crate) const POLISHABLE: f64 = 30.0;
    /// The root mean square of the residual, relative to its parts, above which no exact density is near. None of nine closures of
    /// orders 4 to 8 depends on it.
    pub(crate) const NEAR: f64 = 0.3;
    /// The most steps of Newton's method towards an exact density, each of which converges. None of nine closures of orders 4 to 8
    /// depends on it.
    pub(crate) const STEPS: usize = 12;
    /// The states at which the residual of an exact density is to vanish, and those by which its root is first guessed: bounds on
    /// work, as three times as many give the same.
    pub(crate) const AT_STATES: [usize; 2] = [4000, 20_000];
    /// The most functions of an exact density that is sought at states of the pilot: a bound on work.
    pub(crate) const MOST: usize = 150;
}

/// Step 6: the candidates.
pub(crate) mod candidates {
    /// The tails of a density are compared with the reference's down to this share of the peak. Halved or doubled, it changes L¹
    /// errors of nine closures of orders 4 to 8 by up to −28 % or −6 %, by the tails that are then not fitted.
    pub(crate) const TAIL: f64 = 1e-5;
    /// The power of the reference under which it is smoothed, so that its ripples in the tails do not count.
    pub(crate) const SMOOTHED: f64 = 0.5;
    /// The tails of a density are right within so many decades of the reference. Halved or doubled, it changes L¹ errors of nine
    /// closures of orders 4 to 8 by up to 0 or −5 %.
    pub(crate) const WELL: f64 = 0.17;
    /// The tails of a density are accurate within so many decades of the reference, and right where they have cost as much in L¹ as
    /// they may. Halved or doubled, it changes L¹ errors of nine closures of orders 4 to 8 by up to +7 % or −3 %.
    pub(crate) const ENOUGH: f64 = 0.25;
    /// The factor on the least estimated L¹ error that right tails may cost. Halved or doubled, it changes L¹ errors of nine
    /// closures of orders 4 to 8 by up to 0 or +7 %.
    pub(crate) const PRICE: f64 = 1.33;
    /// While the estimated L¹ error is larger than this, all weight goes to the middle of the density. Halved or doubled, it
    /// changes L¹ errors of nine closures of orders 4 to 8 by up to −28 %, where the tails then get no weight, or 0.
    pub(crate) const MIDDLE: f64 = 0.0115;
    /// The largest share of the weight of a fit that the tails get by default. Halved or doubled, it changes no L¹ error of nine
    /// closures of orders 4 to 8.
    pub(crate) const LARGEST_SHARE: f64 = 0.14;
    /// The pilot's states whose likelihood is taken: enough for a guard against gross errors. None of nine closures of orders 4 to
    /// 8 depends on it.
    pub(crate) const VALIDATION_STATES: usize = 4000;
    /// How many consecutive states of a trajectory count as one in what a density may lose by chance. In a prototype, spurious
    /// roots lost 0.1 to 5 in mean ln p, far more than this allows; none of nine closures of orders 4 to 8 depends on it.
    pub(crate) const CORRELATED: f64 = 50.0;
    /// A low order may lose this much in mean ln p and still be the best of its order: an L¹ error of 0.2 costs about this. None of
    /// nine closures of orders 4 to 8 depends on it.
    pub(crate) const LEAST_LOSS: f64 = 0.05;
}

/// Step 7: impacts in three states and more.
pub(crate) mod walls {
    /// The standard errors by which a density's own impact rate may be off from the counted one, in three states and more, beyond a
    /// small share of it.
    pub(crate) const ERRORS: f64 = 3.0;
    /// The share of the counted impact rate by which a density's own may be off, in three states and more, beyond some standard
    /// errors.
    pub(crate) const SHARE: f64 = 0.003;
}

/// Step 7: the density.
pub(crate) mod density {
    /// The norm ‖F‖ of the Galerkin equations below which all of them hold to rounding.
    pub(crate) const ROOT: f64 = 1e-8;
    /// Draws for integrals of a density: a standard error of some tenths of a percent for fourth moments in ten states.
    pub(crate) const DRAWS: usize = 400_000;
    /// Random shifts of the lattice of draws for integrals: the spread between them is the standard error.
    pub(crate) const SHIFTS: usize = 16;
    /// The factor by which a section of a density has fewer draws than a mean: a marginal is computed at many places.
    pub(crate) const OF_A_SECTION: usize = 8;
}

/// The literature's closure.
pub(crate) mod classical {
    /// Iterations before the search for a root of the literature's closure, or for the fixed point of its weight, counts as
    /// stalled; roots are found in 4 to 20.
    pub(crate) const STEPS: usize = 60;
    /// How often a step of Newton's method is halved at most, in the literature's closure: down to 2⁻¹².
    pub(crate) const HALVINGS: u32 = 12;
    /// A full step of Newton's method this small, relative to the iterate, is at the level of the Jacobian's own rounding.
    pub(crate) const STEP: f64 = 1e-11;
    /// The iterates that a step to the fixed point of the weight is combined from, the present one among them.
    pub(crate) const MEMORY: usize = 4;
    /// The most steps along the path of a homotopy: a bound on work.
    pub(crate) const PATH_STEPS: usize = 600;
    /// The longest step along the path of a homotopy, in the norm of the coefficients and of the path's parameter together.
    pub(crate) const LONGEST: f64 = 0.3;
    /// The shortest step along the path of a homotopy, in the norm of the coefficients and of the path's parameter together.
    pub(crate) const SHORTEST: f64 = 1e-7;
    /// Correctors on the path of a homotopy that need more iterations than this halve the step.
    pub(crate) const CORRECTIONS: usize = 6;
    /// The path of a homotopy goes to infinity where coefficients in an orthonormal basis are larger than this.
    pub(crate) const FAR_AWAY: f64 = 1e4;
}
