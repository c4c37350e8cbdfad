//! The constants that decide something in a simulation, in the order of its course, each with its unit and where its value
//! comes from.

/// Bounds on memory and on work.
pub(super) mod limits {
    /// The most trajectories of a simulation, which holds all of them at once: about a third of a gigabyte.
    pub(crate) const MOST_TRAJECTORIES: usize = 1 << 20;
    /// The most bins of the histogram of a state: every batch holds its histograms, also the joint one, in memory.
    pub(crate) const MOST_BINS: usize = 1024;
    /// The most impulses in a time step, on average: their numbers are drawn by a sum over the possible ones.
    pub(crate) const MOST_IMPULSES: f64 = 8.0;
    /// The most levels whose crossings one simulation counts: each costs time in every step.
    pub(crate) const MOST_LEVELS: usize = 64;
    /// The most walls of a problem that is simulated: each is one bit of a word.
    pub(crate) const MOST_WALLS: usize = 64;
    /// The most moments that can be requested: each costs time at every sample.
    pub(crate) const MOST_MOMENTS: usize = 64;
    /// The most levels whose first passages one simulation measures.
    pub(crate) const MOST_PASSAGES: usize = 16;
    /// The highest degree of a moment that can be requested: beyond, a sum of powers is dominated by a single sample.
    pub(crate) const HIGHEST_DEGREE: u32 = 32;
    /// The most samples in a segment of a spectrum.
    pub(crate) const LONGEST_SEGMENT: usize = 1 << 20;
}

/// The time step.
pub(super) mod time_step {
    /// The time step as a part of the time scale 1/ω of the motion: ωh. The bias of means is (ωh)²/10, about: below 0.02 %.
    pub(crate) const RESOLUTION: f64 = 0.04;
    /// The time step beside a wall with r < 1 as a part of the time scale 1/ω of the motion, where the bias of means is (ωh)²/3,
    /// about: below 0.05 %.
    pub(crate) const BESIDE_LOSSY_WALL: f64 = 0.03;
    /// The largest product ωh of a state's rate and the time step anywhere on the way of a trajectory; at 2 the steps would be
    /// unstable.
    pub(crate) const LARGEST: f64 = 0.25;
    /// The most impulses in a time step that is chosen, on average. They are exact for any number; it bounds their work in a step.
    pub(crate) const MOST_IMPULSES: f64 = 2.0;
    /// The stretches that a try of a time step is divided into; rates are taken after each of the second half.
    pub(crate) const STRETCHES: usize = 64;
    /// The most time steps that are tried, each at most half the one before.
    pub(crate) const ATTEMPTS: usize = 12;
    /// The most steps in a stretch of a try of a time step, which reports no progress. Default times never take so many.
    pub(crate) const MOST_STEPS: f64 = 4096.0;
}

/// Steps beside a wall.
pub(super) mod grazing {
    /// The least ratio a of the speed of a trajectory beside a wall with r < 1 to what noise adds to it in one step.
    pub(crate) const RESOLUTION: f64 = 3.0;
    /// The number m of steps for which a wall with r < 1 must be out of reach where a step does not resolve the speed.
    pub(crate) const FORESIGHT: f64 = 2.0;
    /// The fewest steps of a flight between two impacts on a wall where no white noise acts on the velocity.
    pub(crate) const FLIGHT_STEPS: f64 = 8.0;
    /// The shortest flight between two impacts on a wall without noise, in time steps: a trajectory with a shorter one comes to
    /// rest.
    pub(crate) const SHORTEST_FLIGHT: f64 = 1.0 / 4096.0;
    /// The shortest step of a trajectory that is about to leave its rest on a wall, in time steps.
    pub(crate) const SHORTEST_LEAVING: f64 = 1.0 / 256.0;
    /// The shortest rest on a wall that is counted, as a part of the time between two samples; a default time step is not longer.
    pub(crate) const SHORTEST_REST: f64 = 0.05;
}

/// The start, the burn-in, and the samples.
pub(super) mod timetable {
    use std::time::Duration;

    /// The noise of so many time steps spreads the default start: enough for trajectories to differ, too little to leave the rest
    /// position.
    pub(crate) const SPREAD_STEPS: f64 = 4.0;
    /// The time in units of 1/λ for which a burn-in goes on after small motions that grow as e^λt have come from the start to the
    /// width of the density: one trajectory in twenty starts so near to rest that it needs more.
    pub(crate) const LEAVING: f64 = 3.0;
    /// The longest time that trajectories are given to leave a state of rest at which small motions grow, in the shortest of the
    /// system's times: a bound on work.
    pub(crate) const LONGEST_LEAVING: f64 = 20_000.0;
    /// The trajectories of the pilot, which finds the ranges of histograms.
    pub(crate) const PILOT_TRAJECTORIES: u64 = 64;
    /// The stretches that a burn-in is divided into; the pilot's states are taken between them.
    pub(crate) const BURN_IN_STRETCHES: usize = 64;
    /// The number of the stretch of a burn-in after which states are compared with the samples, where these are few.
    pub(crate) const LATE: usize = 48;
    /// Samples of each trajectory before the first check of precision.
    pub(crate) const FIRST_CHECK: usize = 8;
    /// Path-steps of all trajectories in one round, about: some hundredths of a second.
    pub(crate) const ROUND: usize = 1 << 21;
    /// Path-steps of all trajectories beyond which a stretch can be given up on its way, at the price of a copy of their states:
    /// more than about a second.
    pub(crate) const LONG: usize = 1 << 26;
    /// The most steps of trajectories in lockstep before their states are checked: some milliseconds.
    pub(crate) const PIECE: usize = 1 << 12;
    /// The shortest time after which a round of a run is given up on its way, however small the time budget, so that sessions of
    /// any length get on.
    pub(crate) const LEAST_BUDGET: Duration = Duration::from_secs(1);
    /// The most steps of a burn-in where no time is an option: at most 2000 times the shortest time of the system without its
    /// wall, in 25 steps each, and impacts may be twenty times faster.
    pub(crate) const MOST_DEFAULT_STEPS: f64 = 1e6;
    /// The most steps between two samples where no time is an option; without a wall there are 75.
    pub(crate) const MOST_DEFAULT_INTERVAL: f64 = 2000.0;
    /// The default time between two samples, in the shortest of the system's times: states closer than that add little.
    pub(crate) const INTERVAL: f64 = 3.0;
}

/// Standard errors, and what shows that a run was not stationary.
pub(super) mod errors {
    /// The number of batches of trajectories, which standard errors are made from: enough for an error known to 9 %, few enough to
    /// be cheap.
    pub(crate) const BATCHES: usize = 64;
    /// The most blocks of time for which a batch keeps the sums of squares of its states; of more, neighbours are joined.
    pub(crate) const MOST_BLOCKS: usize = 32;
    /// The mean square of a state that changes by more standard errors from one half of a run to the other has not become
    /// stationary.
    pub(crate) const DRIFTING: f64 = 4.0;
    /// The fewest batches whose spread shows the correlation times of states: from so many it is known to about a third.
    pub(crate) const LEAST_BATCHES: usize = 32;
    /// The fewest samples of a trajectory whose two halves are compared; fewer are compared with states late in the burn-in.
    pub(crate) const LEAST_TREND: usize = 16;
    /// The largest standard deviation about 1 that chance makes of the weights with which blocks of samples satisfy the moment
    /// equations.
    pub(crate) const UNEVEN: f64 = 0.5;
}

/// Control variates.
pub(super) mod calibration {
    /// The highest degree of a polynomial ψ for control variates. With a higher degree the rest of a moment after the regression
    /// depends on the far tail, where few samples are, and standard errors tend to be too small.
    pub(crate) const HIGHEST: u32 = 6;
    /// The most control variates for each state: more take more time than a quarter of the simulation's own.
    pub(crate) const MOST_EACH: usize = 25;
    /// The box on which the polynomials for control variates are Legendre's, as a part of the range of the histograms: some two
    /// and a half standard deviations to either side.
    pub(crate) const BOX: f64 = 0.4;
    /// The most numbers that calibration keeps for all trajectories together: a quarter of a gigabyte.
    pub(crate) const MOST_NUMBERS: usize = 1 << 25;
    /// Blocks of samples that each control variate needs, in either half of the batches.
    pub(crate) const BLOCKS_EACH: usize = 30;
    /// The variance of a calibrated mean counts as at least this part of the plain one: below, it is rounding.
    pub(crate) const LEAST: f64 = 1e-8;
    /// The least E x⁴/(E x²)² of calibrated moments that are those of a density: it is at least 1, and the rest is room for
    /// chance.
    pub(crate) const LEAST_KURTOSIS: f64 = 0.9;
    /// The relative error of the correction that calibration makes: the ridge of the regression, and the rounding of its sums.
    pub(crate) const ROUNDING: f64 = 1e-8;
}

/// Splitting.
pub(super) mod splitting {
    /// The starting states of the pilot and of each replica: as many as leave a few beyond the fourth threshold.
    pub(crate) const STATES: usize = 128;
    /// The fewest replicas of a splitting: from fewer a standard error is known to worse than 18 %.
    pub(crate) const LEAST_REPLICAS: usize = 16;
    /// The most replicas of a splitting, whose starting states all come from one simulation.
    pub(crate) const MOST_REPLICAS: usize = 2048;
    /// The most particles in a bin; two hundred bins of so many fit into memory on any number of threads.
    pub(crate) const MOST_PARTICLES: usize = 4096;
    /// The pilot's particles in a bin, as a multiple of a replica's.
    pub(crate) const PILOT: usize = 4;
    /// The default time step of a splitting, in the shortest of the system's times: 0.02 for the oscillator that it was chosen
    /// with.
    pub(crate) const STEP: f64 = 0.058;
    /// The default resampling interval, in the shortest of the system's times: 0.1 for the oscillator that it was chosen with.
    pub(crate) const INTERVAL: f64 = 0.29;
    /// One round of the pilot of a splitting, as a share of the relaxation.
    pub(crate) const ROUND: f64 = 0.1;
    /// The fewest replicas with a count for what is measured that give it a standard error: with fewer it is unreliable.
    pub(crate) const LEAST_MET: usize = 8;
    /// A threshold is set only if at least this share of the weight beyond the last one lies beyond it.
    pub(crate) const SEEN: f64 = 0.1;
    /// The least number of starting states beyond the last threshold that is set from them.
    pub(crate) const LEAST_STATES: f64 = 30.0;
    /// The number of thresholds between bins at which no more are set, for any importance function.
    pub(crate) const MOST_BINS: usize = 200;
    /// So many rounds may pass without a new threshold before the importance function counts as exhausted.
    pub(crate) const PATIENCE: usize = 10;
    /// The rounds of the pilot that the scale of the tail at each level is taken from.
    pub(crate) const CELL_ROUNDS: usize = 4;
    /// The width δ of a cell about a level, as a share of the mean excess E(X − y | X > y), which is the scale of the tail there.
    /// For an exponential tail the cells then err by 6·10⁻⁵ of the density.
    pub(crate) const CELL: f64 = 1.0 / 3.0;
    /// The fewest particles beyond a level from which the mean excess there is taken.
    pub(crate) const LEAST_SEEN: f64 = 50.0;
}

/// The question whether trajectories settle.
pub(super) mod settling {
    /// The time step of trajectories that show whether they settle, in the shortest of the system's times: their states show where
    /// the density is, not what it is.
    pub(crate) const STEP: f64 = 0.4;
    /// The time between states of trajectories that show whether they settle, in the shortest of the system's times.
    pub(crate) const INTERVAL: f64 = 4.0;
    /// How often a time step with which trajectories explode is halved before they count as exploding with any.
    pub(crate) const HALVINGS: usize = 6;
    /// The numbers of trajectories and of states where nothing but whether trajectories settle is asked.
    pub(crate) const FEW: [usize; 2] = [64, 20_480];
    /// Trajectories whose median distance from the middle grows by so much from the first quarter to the last have not settled.
    pub(crate) const GROWING: f64 = 5.0;
    /// Factors by which the times between states are longer in turn until the median distance from the middle grows by less than
    /// the number beside the factor, from the first quarter to the last. A distance that diffuses, or whose square is an energy
    /// that does, grows by 1.6, 2.1 and 2.5.
    pub(crate) const LONGER: [(f64, f64); 3] = [(4.0, 1.15), (16.0, 1.15), (64.0, 1.35)];
    /// Trajectories have ended at a point where their median distance from the middle falls to this part from the first quarter to
    /// the last: e^−λt does within a few hundred of the shortest times.
    pub(crate) const ENDED: f64 = 1e-2;
}
