//! The constants that decide something in the grid solution, each with its unit and where its value comes from.

/// The domain.
pub(super) mod domain {
    /// Its sides over the distances of the pilot's outermost states from their middle. A Gaussian has fallen to 1e-60 there; from 2
    /// to 8 the number of cells changes by a fifth, since far cells are wide.
    pub(crate) const WIDENING: f64 = 4.0;
    /// A density of this size at the edge, relative to the peak, is cut off.
    pub(crate) const CUT: f64 = 1e-3;
    /// How often a domain that loses too much is doubled.
    pub(crate) const DOUBLINGS: usize = 2;
    /// The share of the accuracy that what is lost at the edges may change.
    pub(crate) const SHARE: f64 = 0.2;
}

/// The pilot.
pub(super) mod pilot {
    pub(crate) const TRAJECTORIES: usize = 64;
    /// States of the main run. With 20 000 to 100 000 the meshes that follow have as many cells.
    pub(crate) const STATES: usize = 20_480;
    /// Trajectories of the run from farther starts,
    pub(crate) const SCATTERED: usize = 16;
    /// with so many states each.
    pub(crate) const EACH: usize = 60;
    /// The deviation of farther starts, over the distance of the outermost state of the main run from the middle.
    pub(crate) const FARTHER: f64 = 5.0;
    /// Their time step, which is shorter by the same factor, and the time between states, in the shortest of the system's times.
    pub(crate) const STEP: f64 = 0.4;
    pub(crate) const INTERVAL: f64 = 4.0;
}

/// The mesh.
pub(super) mod mesh {
    /// Halvings along each state before any state of the pilot counts.
    pub(crate) const HALVINGS: usize = 2;
    /// A cell is divided if it is wider than so many standard deviations of the states in it. A cell that they fill evenly is
    /// √12 = 3.46 wide; with 4 smooth densities take three times the cells, with 12 one solution more.
    pub(crate) const WIDE: f64 = 6.0;
    /// Cells with fewer states are not divided.
    pub(crate) const FEW: usize = 20;
    /// The smallest cell along the velocity at a wall with r < 1, in standard deviations of the velocity. The density is singular
    /// at the grazing point: the error of impact rates falls with a power of this number, 2 for r near 1, 1.5 for r = 0.7 and 1 for
    /// r = 0.5, that of moments faster.
    pub(crate) const GRAZING: f64 = 1e-3;
    /// The same at a level over the root of the accuracy: next to it the density falls as the square root of the speed, and rates are
    /// off with the square of the smallest cell. For Duffing's oscillator below 1.5σ a rate is off by 4e-7 relative with cells of 0.1
    /// σ, by 4e-8 with those of 0.03 σ and by less than 1e-8 with those of 0.01 σ, which take half as many cells more.
    pub(crate) const LEVEL: f64 = 10.0;
    /// The least and the most of it.
    pub(crate) const LEVELS: [f64; 2] = [1e-2, 1e-1];
    /// Cells next to a grazing point are graded up to this speed, in standard deviations.
    pub(crate) const GRADED: f64 = 1.5;
    /// Their width over s³/9D, the distance from the wall over which the density at a speed s changes.
    pub(crate) const LAYER: f64 = 4.0;
    /// The narrowest cell over the domain: less would lose its width to rounding.
    pub(crate) const NARROWEST: f64 = 1e-12;
    /// A cell is at most so many times as long along a common face as its neighbour there. With 2 meshes at grazing points have half
    /// as many cells more, with 8 and 16 they take more rounds.
    pub(crate) const RATIO: f64 = 4.0;
    /// The degree for accuracies that are not finer than the first number; for finer ones the next.
    pub(crate) const DEGREES: [(f64, usize); 3] = [(3e-6, 6), (3e-8, 8), (0.0, 10)];
    /// That next to a lossy wall or a level, where the density is not smooth.
    pub(crate) const GRAZED_DEGREE: usize = 6;
}

/// One state.
pub(super) mod line {
    /// Nodes of the rule for the exponent over a step.
    pub(crate) const NODES: usize = 20;
    /// A step over the deviation of the pilot's states,
    pub(crate) const STEP: f64 = 0.1;
    /// and what it grows by with the distance from where the steps began.
    pub(crate) const GROWTH: f64 = 0.5;
    /// The most steps to one side: with the growth they reach over a hundred powers of ten.
    pub(crate) const STEPS: usize = 4000;
    /// ln p falls by so much below its highest value before the density counts as ended: 1e-26.
    pub(crate) const DEPTH: f64 = 60.0;
    /// What is left in the highest degree of all cells together, where a mesh counts as fine enough.
    pub(crate) const RESOLVED: f64 = 1e-13;
    /// The same relative to the largest exponent, whose rounding p has.
    pub(crate) const ROUNDING: f64 = 1e-15;
    /// The degree, where none is given.
    pub(crate) const DEGREE: usize = 10;
    /// The lowest one: what is left in the highest degree of a cell falls too slowly below it to come to rounding.
    pub(crate) const LEAST: usize = 6;
}

/// The refinement.
pub(super) mod refinement {
    /// A cell is divided along one state alone if its indicator along the other is below this share of it.
    pub(crate) const ALONE: f64 = 0.1;
    /// A cell is quartered if its indicator is so many times its share: that is what a halving takes of it at degree 6 to 8,
    pub(crate) const TWICE: f64 = 200.0;
    /// where less than this is left in the highest degrees of all cells. It saves a solution of five to seven; with 1e-2 narrow cycles
    /// and wells take 1.5 to 2 times the cells.
    pub(crate) const SETTLED: f64 = 1e-3;
    /// The share of the part of the last degree but one that counts as the last one at least: about what one degree gains where the
    /// density is resolved.
    pub(crate) const BELOW: f64 = 0.1;
    /// After a test by two degrees failed, the aim is this part of what would be expected to suffice,
    pub(crate) const CAUTION: f64 = 0.5;
    /// but at least this part of the one before.
    pub(crate) const LEAST: f64 = 0.02;
    /// An estimate of this size is no estimate of a density.
    pub(crate) const HOPELESS: f64 = 0.5;
    /// In steps of time cells are divided for this part of the aim: a mesh that is just fine enough would not be so for long.
    pub(crate) const AHEAD: f64 = 0.5;
    /// Meshes of so many cells resolve something: those from the pilot's states begin with hundreds of cells and an indicator below 1.
    pub(crate) const BEGUN: usize = 5000;
    /// The most solutions; each takes a fifth of the error or less.
    pub(crate) const ROUNDS: usize = 40;
}

/// Several wells.
pub(super) mod wells {
    /// What rounding takes of all that passes a pin, at most.
    pub(crate) const ROUNDING: f64 = 1e-13;
    /// What it makes of what comes from one pin at another, at most. Since columns keep their sums it is far less: of 216 solutions of
    /// two unlike wells (16 to 80 temperatures, damping 0.1 and 1) none has more than a third of this.
    pub(crate) const EXCHANGED: f64 = 3e-17;
    /// An exchange may be off by so many times what that of another degree differs by: two numbers may be near by chance.
    pub(crate) const NEAR: f64 = 3.0;
    /// What arrives at least, so that there are shares where nothing does by rounding, or by what it may be off by.
    pub(crate) const NOTHING: f64 = 1e-200;
    /// A leak above so many times what rounding hides is one at the edges.
    pub(crate) const HIDDEN: f64 = 10.0;
    /// The share of the accuracy that rounding may change before a well gets a pin of its own.
    pub(crate) const SHARE: f64 = 0.1;
    /// What it may change in any case. Of a single well it is 1e-12 to 1e-10, which is part of the estimate.
    pub(crate) const APART: f64 = 1e-9;
    /// What comes from a pin comes back to it at least in this part, or it is none of a well; in the next part, or its well is not
    /// resolved on its own; and in the last part, or its share is not compared on its own.
    pub(crate) const KEPT: [f64; 3] = [0.5, 0.9, 0.999];
    /// A well, and the way from one to another, is resolved as if it had this share of the density at least. For the way 0.01 would
    /// do in most cases; 1 takes half as many cells more.
    pub(crate) const LEAST: f64 = 0.1;
    /// Where less is between two wells, beyond barriers of 40 temperatures, rounding decides what they exchange.
    pub(crate) const BETWEEN: f64 = 1e-15;
    /// Cells with more than the first share of the pilot's states, of which all wells have less than the second part, are those of
    /// a well without a pin.
    pub(crate) const MANY: f64 = 0.01;
    pub(crate) const MISSED: f64 = 0.01;
    /// The most pins.
    pub(crate) const MOST: usize = 12;
    /// Shares that may be off by more are not determined.
    pub(crate) const UNDETERMINED: f64 = 0.1;
}

/// Steps of time, and the rates at which they decay.
pub(super) mod march {
    /// A step changes by this factor at least: each new one costs new factors, as much as one to two steps.
    pub(crate) const CHANGE: f64 = 1.6;
    /// By this one under modulated noise, where every step has factors of its own.
    pub(crate) const FINE_CHANGE: f64 = 1.4;
    /// A step grows at most by this factor.
    pub(crate) const GROWTH: f64 = 4.0;
    /// The first step is this part of the whole time.
    pub(crate) const FIRST: f64 = 400.0;
    /// The part of the accuracy at which the mesh of a transient is refined, and that by which a point's Gaussian may be off.
    pub(crate) const SHARE: f64 = 0.5;
    /// Cells are joined where the pair would have this part of its share,
    pub(crate) const LOOSE: f64 = 0.8;
    /// looked at after so many steps,
    pub(crate) const LOOK: usize = 4;
    /// and if this part of all cells or less is left.
    pub(crate) const WORTH: f64 = 0.8;
    /// A point is followed as a Gaussian at least until a state's deviation is this part of the stationary one,
    pub(crate) const NARROW: f64 = 0.03;
    /// and where a wall or a level is nearer than so many deviations, no longer; 8 leave out 1e-15 of the mass.
    pub(crate) const APART: f64 = 8.0;
    /// The steps grow by this factor,
    pub(crate) const NARROW_GROWTH: f64 = 1.1;
    /// and there are at most so many.
    pub(crate) const NARROW_STEPS: usize = 800;
    /// The smallest deviation of a start over the domain: cells are a few thousandths of it, and must not lose their width to
    /// rounding.
    pub(crate) const THINNEST: f64 = 1e-9;
    /// Steps before the march is given up.
    pub(crate) const MAX_STEPS: usize = 20_000;
    /// The most vectors of the Krylov space. Each costs one solve with the factors; a few dozen eigenvalues next to the shift are then
    /// known to rounding.
    pub(crate) const KRYLOV: usize = 80;
    /// After so many more of them eigenvalues are compared,
    pub(crate) const CHECKED: usize = 10;
    /// and have converged where they stay to this relative part.
    pub(crate) const STAYS: f64 = 1e-11;
    /// Eigenvalues of two degrees are the same mode if they are no farther apart, in units of their size.
    pub(crate) const SAME: f64 = 2e-2;
}
