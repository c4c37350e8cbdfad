//! The constants of the closure on a pilot's own states.

/// Many states: the calibration of the pilot's means.
pub(crate) mod calibration {
    /// The degrees of the functions ψ that may be tested.
    pub(crate) const DEGREES: [u32; 6] = [2, 4, 6, 8, 10, 12];
    /// The fewest states of a block next to walls, so that most impacts belong to the block of the states that they lead to.
    pub(crate) const LENGTH_AT_WALLS: usize = 5;
    /// Beside them, next to walls, kinks A u^i w^j z^a with i + j + |a| up to this.
    pub(crate) const KINKS: u32 = 2;
    /// A mean of the moment equations that is farther from the states' own than so many standard errors is wrong by the distance.
    pub(crate) const CONTRADICTED: f64 = 6.0;
    /// Beyond so many standard errors of the states the equations say nothing of a mean.
    pub(crate) const UNKNOWN: f64 = 30.0;
    /// Blocks of states that each of them needs.
    pub(crate) const BLOCKS_EACH: usize = 60;
    /// A trajectory has at least so many blocks, if it has as many states.
    pub(crate) const LEAST_BLOCKS: usize = 5;
    /// A smaller weight of a state, where 1 is the plain one, means that the pilot has not mixed. In a prototype, three of four
    /// systems whose pilots had not showed it.
    pub(crate) const LEAST_WEIGHT: f64 = -2.0;
}

/// Many states: nodes.
pub(crate) mod lattice {
    /// The finest spacing of a lattice in standard deviations: no density needs a finer one.
    pub(crate) const FINEST: f64 = 0.12;
    /// The coarsest one, by which no density is resolved any more.
    pub(crate) const COARSEST: f64 = 1.2;
    /// The places of a lattice in a ball around the density, for each node that there may be. A bound on work.
    pub(crate) const SEARCHED: f64 = 64.0;
}

/// Three states and four next to walls: nodes.
pub(crate) mod strata {
    /// The most states. A bound on work.
    pub(crate) const MOST_STATES: usize = 4;
    /// Nodes are tried as far out as so many times the farthest state. With 1.1 a part of the trust domain had no nodes, and there
    /// one density of thirty rose to a spike.
    pub(crate) const BEYOND: f64 = 1.4;
    /// Gauss nodes in the displacement.
    pub(crate) const ACROSS: usize = 28;
    /// Gauss nodes in the speed on a wall.
    pub(crate) const SPEEDS: usize = 32;
    /// The spacing in the rate relative to that in the other states.
    pub(crate) const FINER: f64 = 0.5;
    /// The finest and the coarsest spacing, in standard deviations.
    pub(crate) const FINEST: f64 = 0.2;
    /// See [`FINEST`].
    pub(crate) const COARSEST: f64 = 0.9;
}

/// A state that nearly follows the others: nested nodes.
pub(crate) mod nest {
    use crate::numerics::Search;

    /// The most states. A bound on work: beyond, no lattice of the others has few enough points.
    pub(crate) const MOST_STATES: usize = 5;
    /// The states by which a thin one is found.
    pub(crate) const TESTED: usize = 1 << 14;
    /// A state is thin where cubics of the others leave less than this share of its variance, and linear functions so many times more:
    /// in harvesters and a filter behind a Duffing oscillator they leave .025 to .06, and 2.2 to 2.9 times more. Lorenz's system, whose
    /// .076 and 2.8 belong to two sheets that cross, is served by its lattice; an absorber has .74, and 1.05 times.
    pub(crate) const THIN: f64 = 0.065;
    /// See [`THIN`].
    pub(crate) const CURVED: f64 = 1.5;
    /// Points of the other states, by the number of these, mirror images among them. With 24 × 24 in place of 32 × 32 order 6 of a
    /// harvester lost 2e-3 nats, and 48 × 48 gained 3e-4.
    pub(crate) const POINTS: [usize; 4] = [40, 1024, 9600, 9600];
    /// Standard deviations of the state on a line that lines reach out, in which the pilot's farthest states lie. At a quality factor of
    /// 1000 the search ran to the edge with 7; with 24 exp(Q) rose again at some ends.
    pub(crate) const REACH: f64 = 14.0;
    /// Nodes on a line, an even number: half a standard deviation apart.
    pub(crate) const ALONG: usize = 56;
    /// Lines are laid once more where the density on them is wider or narrower by this share in the mean, or shifted by that many
    /// standard deviations.
    pub(crate) const WIDER: f64 = 0.1;
    /// See [`WIDER`].
    pub(crate) const SHIFTED: f64 = 0.15;
    /// How often at most.
    pub(crate) const LAID: usize = 4;
    /// The steps after which functions are made orthonormal again.
    pub(crate) const FRAMES: [usize; 4] = [2, 4, 10, usize::MAX];
    /// Functions whose part beyond all others is smaller than this are left out.
    pub(crate) const DEPENDENT: f64 = 1e-11;
    /// The search that lines are laid by, and that of the order asked for.
    pub(crate) const LAYING: Search = Search { tolerance: 3e-3, most: 40 };
    /// See [`LAYING`].
    pub(crate) const SEARCH: Search = Search { tolerance: 1e-5, most: 60 };
}

/// Many states: the most likely density.
pub(crate) mod likelihood {
    use crate::numerics::Search;

    /// Nodes of the maximisation for each function. In a prototype, 220 left all mass on one node.
    pub(crate) const NODES_EACH: usize = 300;
    /// The fewest of them.
    pub(crate) const FEWEST_NODES: usize = 1 << 16;
    /// The most of them. A bound on work.
    pub(crate) const MOST_NODES: usize = 1 << 18;
    /// A lattice resolves a density if no mean by one half of its nodes is farther from that by the other, in standard
    /// deviations.
    pub(crate) const UNEVEN: f64 = 0.02;
    /// One of so many times fewer nodes does if they are as close as [`EVEN`]; so many fewer also serve the search for a root,
    /// and the curvature of many functions.
    pub(crate) const FEWER: usize = 4;
    /// See [`FEWER`]; the mass of an exact density by one half is as close to that by the other.
    pub(crate) const EVEN: f64 = 1e-5;
    /// Draws next to walls: the fewest of them, and those for each function. With 234 for each, the search found a spike.
    pub(crate) const FEWEST_AT_WALLS: usize = 1 << 17;
    /// See [`FEWEST_AT_WALLS`].
    pub(crate) const NODES_EACH_AT_WALLS: usize = 450;
    /// Draws on each wall.
    pub(crate) const ON_WALL: usize = 1 << 14;
    /// The fewest impacts on a wall that show where and how fast they are.
    pub(crate) const LEAST_IMPACTS: usize = 200;
    /// A search whose result only starts another.
    pub(crate) const ROUGH: Search = Search { tolerance: 3e-3, most: 24 };
    /// The least effective share of the nodes. In a prototype with 29 systems, those below it were some whose pilots had not
    /// mixed.
    pub(crate) const LEAST_EFFECTIVE: f64 = 1e-3;
    /// How often the pilot's means and the equations are reconciled.
    pub(crate) const RECONCILED: usize = 3;
    /// The parts of such a step that are tried, and the share of the effective draws that it leaves at least: two masses above a
    /// wall had, with one seed of three, a step that raised the density at the edge to a spike.
    pub(crate) const LENGTHS: [f64; 3] = [1.0, 0.5, 0.25];
    pub(crate) const KEPT: f64 = 0.5;
    /// The factors κ on the covariance of the equations; it is raised until the remaining deviation from the pilot's means is
    /// chance.
    pub(crate) const DOUBTS: [f64; 13] = [1.0, 3.0, 10.0, 30.0, 1e2, 3e2, 1e3, 3e3, 1e4, 1e5, 1e6, 1e7, 1e8];
    /// The density two degrees higher, by which the error is estimated, is found to this part of its distance.
    pub(crate) const FINE: f64 = 0.02;
    /// The noise of a density over the distance between those by the halves of the states: 0.55 to 0.7 in the median of nine systems.
    pub(crate) const OF_HALVES: f64 = 0.625;
    /// A lower order is tried where at least this share of the estimate is chance, which it has less of.
    pub(crate) const BY_CHANCE: f64 = 0.5;
    /// The distance assumed where there is no estimate of it, in L¹.
    pub(crate) const UNKNOWN: f64 = 0.15;
}
