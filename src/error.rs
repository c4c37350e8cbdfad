//! The errors of the library, each with its cause and a remedy.

/// The reason why a call has no result.
///
/// An `Err` stands for misuse, or for a density that does not exist. A run that did not converge is no error: it is a result,
/// and its provenance reports it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A coefficient of the drift or of the noise is NaN or infinite.
    #[error(
        "the {part} of state {state} has the coefficient {value} at x^{exponents:?}: every parameter of a system must be a finite number"
    )]
    NotFinite {
        /// Drift or noise.
        part: &'static str,
        /// The state's index, from 0.
        state: usize,
        /// The exponents of the monomial.
        exponents: Vec<u32>,
        /// The offending coefficient.
        value: f64,
    },
    /// A number lies outside its range.
    #[error("{name} = {value}: {remedy}")]
    OutOfRange {
        /// The name of the number.
        name: &'static str,
        /// The offending value.
        value: f64,
        /// The range, or what to do.
        remedy: &'static str,
    },
    /// What is requested would take more memory than the limit; nothing of it was allocated.
    #[error("{what} would take {needed:.2} GiB, and the limit is {limit:.2} GiB: {remedy}")]
    TooMuchMemory {
        /// What takes the memory.
        what: &'static str,
        /// The estimate, in GiB.
        needed: f64,
        /// The limit, in GiB.
        limit: f64,
        /// What takes less.
        remedy: &'static str,
    },
    /// A list of numbers has the wrong length, or an index points past the last state.
    #[error("{what}: {found} does not fit a system of {expected} states")]
    Dimension {
        /// The name of the list or the index.
        what: &'static str,
        /// The number of states.
        expected: usize,
        /// The length or the index that was given.
        found: usize,
    },
    /// The system has no noise at all.
    #[error(
        "the noise vanishes identically: without noise there is no stationary density to close; give at least one intensity above zero"
    )]
    NoNoise,
    /// No noise reaches a state.
    #[error(
        "no noise reaches state {state}, not even through other states, so that it has no stationary density; leave the state out, or give it noise"
    )]
    Unreached {
        /// The first such state.
        state: usize,
    },
    /// Trajectories come to rest on a wall.
    #[error(
        "there is no density: no white noise acts on the velocity at wall {wall}, and its impacts take energy, so that trajectories come to rest on it for a share of the time; a simulation has that share and all means, or let some white noise act on the velocity"
    )]
    Rests {
        /// The first such wall, by its number in the problem.
        wall: usize,
    },
    /// The moment equations have no bounded solution.
    #[error(
        "no stationary density was found: under the Gaussian closure the variance of state {state} {behaviour}; the drift must bring every trajectory back, so check the signs of damping and leading stiffness"
    )]
    NoStationaryDensity {
        /// The state whose variance fails first.
        state: usize,
        /// The behaviour of the variance.
        behaviour: &'static str,
    },
    /// No trajectory can be followed through the system's slowest time in steps of its fastest.
    #[error(
        "the system's rates are {fastest:.1e} and {slowest:.1e} per unit time, too far apart for trajectories and cells: leave the fastest motion out, or take the closure, which has the density of a linear system without them"
    )]
    TooStiff {
        /// The fastest rate of the linearised system.
        fastest: f64,
        /// The slowest one.
        slowest: f64,
    },
    /// Trajectories do not settle.
    #[error("there is no stationary density: in state {state} trajectories {behaviour}")]
    NoDensity {
        /// The first such state.
        state: usize,
        /// What they do, and the remedy.
        behaviour: &'static str,
    },
    /// exp(Q) has no finite integral.
    #[error(
        "exp(Q) of order {order} cannot be normalised: Q grows in the direction {direction:.3?}; it is no density, try another order or basis"
    )]
    NotNormalisable {
        /// The order of the closure.
        order: u32,
        /// A direction of the state space, of length one in scaled coordinates, in which Q does not fall.
        direction: Vec<f64>,
    },
    /// The closure of an order has no density.
    #[error("the closure of order {order} has no density: {reason}")]
    NotClosed {
        /// The order of the closure.
        order: u32,
        /// The obstacle, and a remedy.
        reason: &'static str,
    },
    /// A wall, a level or a power balance needs a displacement: a state whose rate of change is another state.
    #[error(
        "state {state} is no displacement: its drift must be one other state alone, its velocity, without noise; walls, levels and power balances need one"
    )]
    NotADisplacement {
        /// The state that was taken for a displacement.
        state: usize,
    },
    /// A trajectory left every bound.
    #[error(
        "trajectory {trajectory}{} exploded: its state was {state:?} at time {time}; either the drift has no stationary density or the time step {step} is too long for it",
        if *pilot { " of the pilot" } else { "" }
    )]
    Exploded {
        /// The trajectory's number.
        trajectory: u64,
        /// Whether it is one of the pilot's, which runs first.
        pilot: bool,
        /// The last state.
        state: Vec<f64>,
        /// The time of the last state.
        time: f64,
        /// The time step.
        step: f64,
    },
    /// A simulation has fewer samples than it needs.
    #[error("{what} is too small: take at least {least}")]
    NoSamples {
        /// The count that is too small.
        what: &'static str,
        /// Its least value.
        least: usize,
    },
    /// The caller stopped a simulation or a study.
    #[error("cancelled by the progress callback after {done} {unit}; with a file it goes on from there")]
    Cancelled {
        /// How far it had come.
        done: u64,
        /// Path-steps, or rows.
        unit: &'static str,
    },
    /// The time budget of a simulation ended before every trajectory had a sample.
    #[error(
        "the time budget was over after {steps} path-steps, before every trajectory had a sample: allow more time, or \
         shorten the burn-in and the sampling interval"
    )]
    OutOfTime {
        /// How far it had come.
        steps: u64,
    },
    /// A file could not be read or written.
    #[error("cannot {action} {path}: {reason}")]
    File {
        /// To read or to write.
        action: &'static str,
        /// The file.
        path: String,
        /// The operating system's message.
        reason: String,
    },
    /// A file is not one that this simulation or this study can go on from.
    #[error("{path} is nothing to go on from: {problem}")]
    NotThisRun {
        /// The file.
        path: String,
        /// What is wrong with it, and a remedy.
        problem: String,
    },
    /// Results are not the parts of one simulation.
    #[error("these are not the parts of one simulation: {problem}")]
    NotTheParts {
        /// What is wrong with them, and a remedy.
        problem: String,
    },
    /// Another process of a simulation or a study on several ranks of MPI failed.
    #[error("rank {rank} failed: {reason}")]
    Rank {
        /// The process.
        rank: usize,
        /// Its error message.
        reason: String,
    },
    /// Parameters cannot be found from a density that a combination of them does not change.
    #[error(
        "the stationary density does not change along {}: hold one of these parameters at a known value",
        combined(combination)
    )]
    Unidentifiable {
        /// The parameters, each with its share in the combination.
        combination: Vec<(String, f64)>,
    },
    /// A density does not have a value.
    #[error("this density has no answer about {what}: {remedy}")]
    NotKnown {
        /// The value that it does not have.
        what: String,
        /// A remedy.
        remedy: &'static str,
    },
    /// A method cannot serve a problem.
    #[error("the {method} does not serve {what}: {remedy}")]
    NotServed {
        /// The method.
        method: &'static str,
        /// The property of the problem that the method does not serve.
        what: &'static str,
        /// A method that serves it, or an option to change.
        remedy: &'static str,
    },
    /// A text is no system.
    #[error("line {line}, column {column}: {name}: {problem}")]
    NotAProblem {
        /// The line of the text, from 1.
        line: usize,
        /// The character of the line, from 1.
        column: usize,
        /// The key, state, parameter or wall that is wrong.
        name: String,
        /// What is wrong with it, and what to write instead.
        problem: String,
    },
    /// The density does not end within the domain of a grid.
    #[error(
        "at state {state} = {edge} the density is {level:.1e} of its peak, above the accepted {accepted:.1e}: either the domain cuts it off, then widen `Grid::domain` or leave it out, or the drift has no stationary density"
    )]
    DomainCut {
        /// The state whose limit is too close.
        state: usize,
        /// The limit.
        edge: f64,
        /// The density there, relative to the peak.
        level: f64,
        /// The highest level accepted.
        accepted: f64,
    },
    /// The linear equations of a grid have no unique solution.
    #[error(
        "the linear system of {unknowns} unknowns is singular: the stationary density is not unique, or there is none; check that the noise reaches every state"
    )]
    SingularSystem {
        /// The number of unknowns.
        unknowns: usize,
    },
    /// A grid has ended with an error as large as the density.
    #[error(
        "the grid does not resolve the density: its estimate of the error in L1 is {estimate:.1e}{}{reason}",
        if reason.is_empty() { "; check that the noise reaches every state" } else { "; " }
    )]
    NotResolved {
        /// The estimate of ∫ |p̃ − p| dx.
        estimate: f64,
        /// What stands in the way.
        reason: String,
    },
    /// The caller stopped a grid.
    #[error("the grid was cancelled by its progress callback after {rounds} linear systems")]
    GridCancelled {
        /// How many it had solved.
        rounds: usize,
    },
    /// A text is no closed form that this library wrote, or is damaged.
    #[error("this is no closed form to load: {problem}; restore it from a copy, or solve anew and save it again")]
    NotAClosedForm {
        /// What is wrong with it.
        problem: String,
    },
    /// A state's name cannot be an argument of a function.
    #[error("the name {name:?} will not do: {problem}; x, v, x1, x2 are usual names of states")]
    NotAName {
        /// The name.
        name: String,
        /// The reason.
        problem: &'static str,
    },
    /// A density has no text in a language.
    #[error("this density cannot be written as {language}: {reason}")]
    NoText {
        /// The language.
        language: &'static str,
        /// The obstacle, and a remedy.
        reason: &'static str,
    },
    /// A table has no column of a name.
    #[error("there is no column {name:?}; there are {columns:?}")]
    NoColumn {
        /// The name that was given.
        name: String,
        /// The names that there are.
        columns: Vec<String>,
    },
}

/// The result of a question to this library.
pub type Result<T> = std::result::Result<T, Error>;
/// A combination of parameters as text.
fn combined(combination: &[(String, f64)]) -> String {
    combination.iter().map(|(name, weight)| format!("{weight:+.3} {name}")).collect::<Vec<_>>().join(" ")
}
