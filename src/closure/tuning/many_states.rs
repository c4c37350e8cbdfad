//! The constants of the closure on a pilot's own states.

/// Many states: the calibration of the pilot's means.
pub(crate) mod calibration {
    /// The degrees of the functions ψ whose moment equations may calibrate the pilot's means.
    pub(crate) const DEGREES: [u32; 6] = [2, 4, 6, 8, 10, 12];
    /// The fewest consecutive states of a block next to walls, so that most impacts belong to the block of the states that they
    /// lead to.
    pub(crate) const LENGTH_AT_WALLS: usize = 5;
    /// The kinks A u^i w^j z^a beside the polynomials that calibrate the pilot's means next to walls have i + j + |a| up to this.
    pub(crate) const KINKS: u32 = 2;
    /// A mean of the moment equations that is farther from the states' own than so many standard errors of these is wrong by the
    /// distance.
    pub(crate) const CONTRADICTED: f64 = 6.0;
    /// Means of the moment equations correct those of the states where their errors are below so many standard errors of the
    /// states' means.
    pub(crate) const UNKNOWN: f64 = 30.0;
    /// The fewest blocks of states for each function whose moment equation is used.
    pub(crate) const BLOCKS_EACH: usize = 60;
    /// The fewest blocks of a trajectory, if it has as many states.
    pub(crate) const LEAST_BLOCKS: usize = 5;
    /// A smaller weight of a block of states, where 1 is the plain one, means that the pilot has not mixed. In a prototype, three
    /// of four systems whose pilots had not mixed had such a weight.
    pub(crate) const LEAST_WEIGHT: f64 = -2.0;
}

/// Many states: nodes.
pub(crate) mod lattice {
    /// The finest spacing of a lattice, in standard deviations: no density needs a finer one.
    pub(crate) const FINEST: f64 = 0.12;
    /// The coarsest spacing of a lattice, in standard deviations, by which no density is resolved any more.
    pub(crate) const COARSEST: f64 = 1.2;
    /// The most places of a lattice in a ball around the density, for each node that there may be: a bound on work.
    pub(crate) const SEARCHED: f64 = 64.0;
}

/// Three states and four next to walls: nodes.
pub(crate) mod strata {
    /// The most states in which nodes next to walls are Gauss nodes across the walls' line and a lattice along it: a bound on work.
    pub(crate) const MOST_STATES: usize = 4;
    /// Nodes next to walls are tried as far out as so many times the farthest state. With 1.1 a part of the trust domain had no
    /// nodes, and there one density of thirty rose to a spike.
    pub(crate) const BEYOND: f64 = 1.4;
    /// Gauss nodes in the displacement from a wall to the farthest states; between two walls either half has two thirds of them.
    pub(crate) const ACROSS: usize = 28;
    /// Gauss nodes in the speed of impacts on a wall.
    pub(crate) const SPEEDS: usize = 32;
    /// The spacing of nodes in the rate of the displacement that meets walls, relative to that in the other states: next to a wall
    /// the density varies faster in this rate.
    pub(crate) const FINER: f64 = 0.5;
    /// The finest spacing of the lattice along the walls' line, in standard deviations.
    pub(crate) const FINEST: f64 = 0.2;
    /// The coarsest spacing of the lattice along the walls' line, in standard deviations.
    pub(crate) const COARSEST: f64 = 0.9;
}

/// A state that nearly follows the others: nested nodes.
pub(crate) mod nest {
    use crate::numerics::Search;

    /// The most states in which nested nodes are tried: a bound on work, since beyond it no lattice of the states beside the thin
    /// one has few enough points.
    pub(crate) const MOST_STATES: usize = 5;
    /// The number of the pilot's states by which a thin state is found.
    pub(crate) const TESTED: usize = 1 << 14;
    /// A state is thin where cubics of the others leave less than this share of its variance: .025 to .06 in harvesters and a
    /// filter behind a Duffing oscillator. Lorenz's system, whose .076 belongs to two sheets that cross, is served by its lattice,
    /// and an absorber has .74.
    pub(crate) const THIN: f64 = 0.065;
    /// A state is thin where linear functions of the others leave more than so many times the variance that cubics leave: 2.2 to
    /// 2.9 times in harvesters and a filter behind a Duffing oscillator, 2.8 in Lorenz's system, and 1.05 for an absorber.
    pub(crate) const CURVED: f64 = 1.5;
    /// The most points of the states beside a thin one, by the number of these states, mirror images among the points. With 24 × 24
    /// in place of 32 × 32 order 6 of a harvester lost 2e-3 nats, and 48 × 48 gained 3e-4.
    pub(crate) const POINTS: [usize; 4] = [40, 1024, 9600, 9600];
    /// Lines along a thin state reach out so many of its standard deviations on them, in which the pilot's farthest states lie. At
    /// a quality factor of 1000 the search ran to the edge with 7; with 24 exp(Q) rose again at some ends.
    pub(crate) const REACH: f64 = 14.0;
    /// Nodes on a line along a thin state, an even number: half a standard deviation apart.
    pub(crate) const ALONG: usize = 56;
    /// Lines along a thin state are laid once more where the density on them is wider or narrower by this share in the mean.
    pub(crate) const WIDER: f64 = 0.1;
    /// Lines along a thin state are laid once more where the density on them is shifted by so many standard deviations in the mean.
    pub(crate) const SHIFTED: f64 = 0.15;
    /// The most times that lines along a thin state are laid for one density.
    pub(crate) const LAID: usize = 4;
    /// The steps of a search on a thin state after which its functions are made orthonormal again, one stretch after the other.
    pub(crate) const FRAMES: [usize; 4] = [2, 4, 10, usize::MAX];
    /// Functions on a thin state whose part beyond all others is below this, relative to the largest, are left out as dependent.
    pub(crate) const DEPENDENT: f64 = 1e-11;
    /// The search for densities by which lines along a thin state are laid, and for those of a lower or higher order: its tolerance
    /// is in standard deviations of ln p.
    pub(crate) const LAYING: Search = Search { tolerance: 3e-3, most: 40 };
    /// The search on a thin state for the density of the order asked for: its tolerance is in standard deviations of ln p.
    pub(crate) const SEARCH: Search = Search { tolerance: 1e-5, most: 60 };
}

/// Many states: the most likely density.
pub(crate) mod likelihood {
    use crate::numerics::Search;

    /// Nodes of the maximisation for each function. In a prototype, 220 left all mass on one node.
    pub(crate) const NODES_EACH: usize = 300;
    /// The fewest nodes of the maximisation.
    pub(crate) const FEWEST_NODES: usize = 1 << 16;
    /// The most nodes of the maximisation: a bound on work.
    pub(crate) const MOST_NODES: usize = 1 << 18;
    /// Nodes resolve a density if no mean by one part of them is farther than this from that by all, in standard deviations.
    pub(crate) const UNEVEN: f64 = 0.02;
    /// The factor by which nodes are fewer on the lattice that is tried first, in the search for a root, and in the curvature of
    /// many functions.
    pub(crate) const FEWER: usize = 4;
    /// A lattice of fewer nodes is enough, and a lattice gives the mass of an exact density, if means by one half of its nodes are
    /// within this of those by all, in standard deviations.
    pub(crate) const EVEN: f64 = 1e-5;
    /// The fewest draws of the maximisation next to walls.
    pub(crate) const FEWEST_AT_WALLS: usize = 1 << 17;
    /// Draws of the maximisation next to walls for each function. With 234 for each, the search found a spike.
    pub(crate) const NODES_EACH_AT_WALLS: usize = 450;
    /// Draws of impacts on each wall.
    pub(crate) const ON_WALL: usize = 1 << 14;
    /// The fewest impacts of the pilot on a wall from which the distribution of their places and speeds is taken.
    pub(crate) const LEAST_IMPACTS: usize = 200;
    /// The search for a density that only starts another, or that an error is estimated by: its tolerance is in standard deviations
    /// of ln p.
    pub(crate) const ROUGH: Search = Search { tolerance: 3e-3, most: 24 };
    /// The least effective share of the nodes with which the states carry a density. In a prototype with 29 systems, those below it
    /// were some whose pilots had not mixed.
    pub(crate) const LEAST_EFFECTIVE: f64 = 1e-3;
    /// The most steps by which the pilot's means and the moment equations are reconciled.
    pub(crate) const RECONCILED: usize = 3;
    /// The parts that are tried of a step by which the pilot's means and the moment equations are reconciled, the whole step first.
    pub(crate) const LENGTHS: [f64; 3] = [1.0, 0.5, 0.25];
    /// The least share of the effective draws that is left by a step that reconciles the pilot's means and the moment equations.
    /// Two masses above a wall had, with one seed of three, a step that raised the density at the edge to a spike.
    pub(crate) const KEPT: f64 = 0.5;
    /// The factors κ on the covariance of the moment equations; κ is raised until the remaining deviation from the pilot's means is
    /// chance.
    pub(crate) const DOUBTS: [f64; 13] = [1.0, 3.0, 10.0, 30.0, 1e2, 3e2, 1e3, 3e3, 1e4, 1e5, 1e6, 1e7, 1e8];
    /// The density two degrees higher, by which the error is estimated, is found to this part of its distance.
    pub(crate) const FINE: f64 = 0.02;
    /// The noise of a density relative to the distance between those by the halves of the states: 0.55 to 0.7 in the median of nine
    /// systems.
    pub(crate) const OF_HALVES: f64 = 0.625;
    /// A lower order is tried where at least this share of the estimated error is chance, which a lower order has less of.
    pub(crate) const BY_CHANCE: f64 = 0.5;
    /// The distance of the density two degrees higher that is assumed where there is no estimate of it, in L¹.
    pub(crate) const UNKNOWN: f64 = 0.15;
}
