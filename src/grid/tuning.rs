//! The constants that decide something in the grid solution, each with its unit and where its value comes from.

/// The domain.
pub(super) mod domain {
    /// The sides of the domain over the distances of the pilot's outermost states from their mean. A Gaussian has fallen to 1e-60
    /// there; from 2 to 8 the number of cells changes by a fifth, since far cells are wide.
    pub(crate) const WIDENING: f64 = 4.0;
    /// The largest density at the edge of the domain, relative to the peak, that a transient under an envelope may have: the
    /// domain cuts one with more.
    pub(crate) const CUT: f64 = 1e-3;
    /// How often a domain that loses too much at its edges is doubled.
    pub(crate) const DOUBLINGS: usize = 2;
    /// The share of the accuracy, in L¹, that what is lost at the edges of a domain may change before the domain is doubled.
    pub(crate) const SHARE: f64 = 0.2;
}

/// The pilot.
pub(super) mod pilot {
    /// Trajectories of the pilot's main run, which starts near rest.
    pub(crate) const TRAJECTORIES: usize = 64;
    /// States of the pilot's main run. With 20 000 to 100 000 the meshes that follow have as many cells.
    pub(crate) const STATES: usize = 20_480;
    /// Trajectories of the pilot's run from farther starts, which finds wells that the main run misses.
    pub(crate) const SCATTERED: usize = 16;
    /// States of each trajectory in the pilot's run from farther starts.
    pub(crate) const EACH: usize = 60;
    /// The standard deviation of the pilot's farther starts over the distance of the outermost state of its main run from the
    /// middle. The time step from there is shorter by the same factor.
    pub(crate) const FARTHER: f64 = 5.0;
    /// The time step of the pilot's run from farther starts, in the shortest of the system's times, before it is shortened for the
    /// steeper forces there.
    pub(crate) const STEP: f64 = 0.4;
    /// The time between states in the pilot's run from farther starts, in the shortest of the system's times.
    pub(crate) const INTERVAL: f64 = 4.0;
}

/// The mesh.
pub(super) mod mesh {
    /// Halvings of the domain along each state before any state of the pilot or any solution counts.
    pub(crate) const HALVINGS: usize = 2;
    /// A cell is divided if it is wider than so many standard deviations of the states in it. A cell that they fill evenly is √12
    /// = 3.46 wide; with 4 smooth densities take three times the cells, with 12 one solution more.
    pub(crate) const WIDE: f64 = 6.0;
    /// The fewest sampled states in a cell of the first mesh for which it is divided.
    pub(crate) const FEW: usize = 20;
    /// The smallest cell along the velocity at a wall with r < 1, in standard deviations of the velocity. The density is singular
    /// at the grazing point: the error of impact rates falls with a power of this number, 2 for r near 1, 1.5 for r = 0.7 and 1
    /// for r = 0.5, that of moments faster.
    pub(crate) const GRAZING: f64 = 1e-3;
    /// The smallest cell along the velocity at a level, in standard deviations of the velocity, over the root of the accuracy:
    /// next to a level the density falls as the square root of the speed, and rates are off with the square of the smallest cell.
    /// For Duffing's oscillator below 1.5σ a rate is off by 4e-7 relative with cells of 0.1 σ, by 4e-8 with those of 0.03 σ and by
    /// less than 1e-8 with those of 0.01 σ, which take half as many cells more.
    pub(crate) const LEVEL: f64 = 10.0;
    /// The least and the greatest size of the smallest cell along the velocity at a level, in standard deviations of the velocity,
    /// whatever the accuracy.
    pub(crate) const LEVELS: [f64; 2] = [1e-2, 1e-1];
    /// Cells next to a grazing point are graded along the displacement up to this speed, in standard deviations of the velocity.
    pub(crate) const GRADED: f64 = 1.5;
    /// The width of cells next to a grazing point over s³/9D, the distance from the wall over which the density at a speed s
    /// changes.
    pub(crate) const LAYER: f64 = 4.0;
    /// The width of the narrowest cell over that of the domain: less would be lost to rounding.
    pub(crate) const NARROWEST: f64 = 1e-12;
    /// A cell is at most so many times as long along a common face as its neighbour there. With 2 meshes at grazing points have
    /// half as many cells more, with 8 and 16 they take more rounds.
    pub(crate) const RATIO: f64 = 4.0;
    /// Accuracies in L¹, each with the degree of the polynomials for accuracies that are not finer; the first pair that fits
    /// decides.
    pub(crate) const DEGREES: [(f64, usize); 3] = [(3e-6, 6), (3e-8, 8), (0.0, 10)];
    /// The degree of the polynomials at any accuracy where there is a level or a wall with r < 1, next to which the density is not
    /// smooth.
    pub(crate) const GRAZED_DEGREE: usize = 6;
}

/// One state.
pub(super) mod line {
    /// Nodes of the Gauss rule for the exponent ∫ 2f/B dx of a density of one state over a step.
    pub(crate) const NODES: usize = 20;
    /// The first step along the line of a single state, over the standard deviation of the pilot's states.
    pub(crate) const STEP: f64 = 0.1;
    /// The share of the distance from where the steps along a line began that adds to the standard deviation which a step is in
    /// proportion to.
    pub(crate) const GROWTH: f64 = 0.5;
    /// The most steps along a line to one side of where they began: with their growth they reach over a hundred powers of ten.
    pub(crate) const STEPS: usize = 4000;
    /// The density of one state has ended where the logarithm of what is left has fallen by so much below its highest value: to
    /// 1e-26 of it.
    pub(crate) const DEPTH: f64 = 60.0;
    /// A mesh of one state is fine enough for the closed form where so much is left in the highest degree of all cells together,
    /// in L¹.
    pub(crate) const RESOLVED: f64 = 1e-13;
    /// What is left in the highest degree of the closed form of one state where its mesh is fine enough, over the largest
    /// exponent: p has the rounding of that.
    pub(crate) const ROUNDING: f64 = 1e-15;
    /// The degree of the polynomials for the closed form of one state, where none is given.
    pub(crate) const DEGREE: usize = 10;
    /// The lowest degree of the polynomials for the closed form of one state: with a lower one what is left in the highest degree
    /// of a cell falls too slowly to come to rounding.
    pub(crate) const LEAST: usize = 6;
}

/// The refinement.
pub(super) mod refinement {
    /// A cell is not divided along a state along which its indicator is below this share of that along the other.
    pub(crate) const ALONE: f64 = 0.1;
    /// A cell is halved twice along a state if its indicator is so many times its share: that is what a halving takes of it at
    /// degree 6 to 8.
    pub(crate) const TWICE: f64 = 200.0;
    /// Cells may be halved twice in one round where less than this, in L¹, is left in the highest degrees of all cells. That saves
    /// a solution of five to seven; with 1e-2 narrow cycles and wells take 1.5 to 2 times the cells.
    pub(crate) const SETTLED: f64 = 1e-3;
    /// The part of the highest degree in a cell counts as at least this share of that of the degree below: about what one degree
    /// gains where the density is resolved.
    pub(crate) const BELOW: f64 = 0.1;
    /// After a test by two degrees has failed, the refinement aims at this part of the indicator that would be expected to
    /// suffice.
    pub(crate) const CAUTION: f64 = 0.5;
    /// The smallest factor by which a failed test by two degrees lowers the aim of the refinement.
    pub(crate) const LEAST: f64 = 0.02;
    /// An estimate in L¹, or a sum of the relative errors of steps in time, of this size is no estimate of a density.
    pub(crate) const HOPELESS: f64 = 0.5;
    /// A mesh that a density on its way through time has outgrown is refined for this part of the aim: one that is just fine
    /// enough would not be so for long.
    pub(crate) const AHEAD: f64 = 0.5;
    /// A mesh of so many cells has an indicator below 1, or it resolves nothing: meshes from the pilot's states begin with
    /// hundreds of cells and an indicator below 1.
    pub(crate) const BEGUN: usize = 5000;
    /// The most solutions on the way to a mesh that is fine enough; each takes a fifth of the error or less.
    pub(crate) const ROUNDS: usize = 40;
}

/// Several wells.
pub(super) mod wells {
    /// The largest part of the probability passing a pin that rounding takes away.
    pub(crate) const ROUNDING: f64 = 1e-13;
    /// The largest part of what comes from one pin that rounding makes arrive at another. Since columns keep their sums it is far
    /// less: of 216 solutions of two unlike wells (16 to 80 temperatures, damping 0.1 and 1) none has more than a third of this.
    pub(crate) const EXCHANGED: f64 = 3e-17;
    /// The exchange of two wells may be off by so many times what that of another degree differs by: two numbers may be near by
    /// chance.
    pub(crate) const NEAR: f64 = 3.0;
    /// The least part of what comes from one pin that counts as arriving at another, so that wells have shares where nothing
    /// arrives by rounding, or by what the part may be off by.
    pub(crate) const NOTHING: f64 = 1e-200;
    /// A loss of probability above so many times what rounding hides is a leak at the edges of the domain.
    pub(crate) const HIDDEN: f64 = 10.0;
    /// The share of the accuracy, in L¹, that rounding may change before a further pin is set, for a well of its own.
    pub(crate) const SHARE: f64 = 0.1;
    /// What rounding may change in any case, in L¹, before a further pin is set. Of a single well it changes 1e-12 to 1e-10, which
    /// is part of the estimate.
    pub(crate) const APART: f64 = 1e-9;
    /// Parts of what comes from a pin that come back to it before they arrive at another: with less than the first the pin is none
    /// of a well, with less than the second its well is not resolved on its own. With less than the third at any pin the exchanges
    /// of wells are not compared between degrees.
    pub(crate) const KEPT: [f64; 3] = [0.5, 0.9, 0.999];
    /// A well, and the way from one to another, is resolved as if it had this share of the density at least. For the way 0.01
    /// would do in most cases; 1 takes half as many cells more.
    pub(crate) const LEAST: f64 = 0.1;
    /// The least probability between two wells, with one of 1 in each, for which the way between them is resolved: where less is
    /// there, beyond barriers of 40 temperatures, rounding decides what the wells exchange.
    pub(crate) const BETWEEN: f64 = 1e-15;
    /// A cell that no well fills is that of a well without a pin if it has more than this share of the pilot's states.
    pub(crate) const MANY: f64 = 0.01;
    /// A cell with many of the pilot's states is that of a well without a pin if all wells have less in it than this part of its
    /// share of the states.
    pub(crate) const MISSED: f64 = 0.01;
    /// The number of pins at which no further one is set, whatever rounding changes.
    pub(crate) const MOST: usize = 12;
    /// Shares of wells that rounding, leaks or another degree may change by so much are not determined by the equation.
    pub(crate) const UNDETERMINED: f64 = 0.1;
}

/// Steps of time, and the rates at which they decay.
pub(super) mod march {
    /// The least factor by which the length of a step in time changes: each new length costs new factors of the matrix, as much as
    /// one to two steps.
    pub(crate) const CHANGE: f64 = 1.6;
    /// The least factor by which the length of a step in time changes under modulated noise, where every step has factors of the
    /// matrix of its own.
    pub(crate) const FINE_CHANGE: f64 = 1.4;
    /// The largest factor by which the length of a step in time grows from one step to the next.
    pub(crate) const GROWTH: f64 = 4.0;
    /// The whole time of a transient over its first step.
    pub(crate) const FIRST: f64 = 400.0;
    /// The part of the accuracy, in L¹, to which the mesh of a transient is refined, and by which the Gaussian that spreads from a
    /// point may be off.
    pub(crate) const SHARE: f64 = 0.5;
    /// In a transient two cells are joined where the pair would have this part of its share of the aim, or less, in its highest
    /// degree.
    pub(crate) const LOOSE: f64 = 0.8;
    /// The number of steps in time after which a mesh is searched for cells to be joined.
    pub(crate) const LOOK: usize = 4;
    /// Cells of a transient's mesh are joined only if this part of all cells or less is left: a new mesh costs new factors of the
    /// matrix.
    pub(crate) const WORTH: f64 = 0.8;
    /// What spreads from a point is followed as a Gaussian at least until the standard deviation of a state is this part of the
    /// stationary one.
    pub(crate) const NARROW: f64 = 0.03;
    /// What spreads from a point is followed as a Gaussian only up to where a wall or a level is nearer than so many standard
    /// deviations; 8 leave out 1e-15 of the mass.
    pub(crate) const APART: f64 = 8.0;
    /// The factor by which each step in time of a Gaussian that spreads from a point is longer than the one before.
    pub(crate) const NARROW_GROWTH: f64 = 1.1;
    /// The most steps in time of a Gaussian that spreads from a point, after which the noise counts as too weak to spread it.
    pub(crate) const NARROW_STEPS: usize = 800;
    /// The smallest standard deviation of a Gaussian start over the width of the domain: cells are a few thousandths of the
    /// deviation, and must not lose their width to rounding.
    pub(crate) const THINNEST: f64 = 1e-9;
    /// The steps in time after which a transient is given up.
    pub(crate) const MAX_STEPS: usize = 20_000;
    /// The most vectors of the Krylov space for relaxation rates. Each costs one solve with the factors; a few dozen eigenvalues
    /// next to the shift are then known to rounding.
    pub(crate) const KRYLOV: usize = 80;
    /// The eigenvalues nearest to zero are compared with earlier ones each time the Krylov space has so many more vectors.
    pub(crate) const CHECKED: usize = 10;
    /// An eigenvalue μ has converged where it changes by less than this between two comparisons, relative to |μ + shift|.
    pub(crate) const STAYS: f64 = 1e-11;
    /// Eigenvalues of two degrees are the same mode if they are no farther apart, in units of their modulus or of the shift if
    /// that is larger.
    pub(crate) const SAME: f64 = 2e-2;
}
