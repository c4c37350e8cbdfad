//! The errors of the library, each with its cause and a remedy.

use std::{io, sync::Arc};

/// The reason why a call has no result.
///
/// An `Err` stands for misuse, or for a density that does not exist. A run that did not converge is no error: it is a result,
/// and its provenance reports it.
#[derive(Clone, Debug, thiserror::Error)]
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
    /// The system has no stationary density.
    #[error("there is no stationary density: {reason}")]
    NoDensity {
        /// The first state or wall that shows it, what happens there, and a remedy.
        reason: String,
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
        "trajectory {trajectory}{} exploded: its state was {state:?} at time {time}; the drift has no stationary density, or no value there (a division by zero, a root of a negative number), or the time step {step} is too long for it",
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
    /// The caller stopped a simulation, a grid or a study. Those that keep a file go on from it.
    #[error("cancelled by the progress callback after {done} {unit}")]
    Cancelled {
        /// How far it had come.
        done: u64,
        /// Path-steps, linear systems, or rows.
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
    #[error("cannot {action} {path}: {source}")]
    File {
        /// To read or to write.
        action: &'static str,
        /// The file.
        path: String,
        /// The operating system's error, or what is wrong with the content.
        source: Arc<io::Error>,
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
    /// The density of a grid has an error as large as itself, or none was found.
    #[error("the grid does not resolve the density: {reason}")]
    NotResolved {
        /// The estimate of ∫ |p̃ − p| dx; infinite where there is none.
        estimate: f64,
        /// What stands in the way, and a remedy.
        reason: String,
    },
    /// A text is no closed form that this library wrote, or is damaged.
    #[error("this is no closed form to load: {problem}; restore it from a copy, or solve anew and save it again")]
    NotAClosedForm {
        /// What is wrong with it.
        problem: String,
    },
    /// Nothing has a name, or a name cannot be given.
    #[error("the name {name:?} will not do: {problem}")]
    NotAName {
        /// The name.
        name: String,
        /// The reason, and the names that there are or that are usual.
        problem: String,
    },
}

/// Errors are equal where they say the same: that of an operating system has no equality of its own.
impl PartialEq for Error {
    fn eq(&self, other: &Self) -> bool {
        self.to_string() == other.to_string()
    }
}

impl Error {
    /// Whether a method has no density of a problem, for which another order or another method may have one, or no method has.
    pub fn is_without_density(&self) -> bool {
        matches!(self, Error::NoDensity { .. } | Error::NotClosed { .. } | Error::NotNormalisable { .. })
    }

    /// Where there is no stationary density.
    pub(crate) fn no_density(reason: impl Into<String>) -> Self {
        Error::NoDensity { reason: reason.into() }
    }

    /// Where a name will not do.
    pub(crate) fn not_a_name(name: &str, problem: impl Into<String>) -> Self {
        Error::NotAName { name: name.to_owned(), problem: problem.into() }
    }
}

/// The result of a question to this library.
pub type Result<T> = std::result::Result<T, Error>;

/// A combination of parameters as text.
fn combined(combination: &[(String, f64)]) -> String {
    combination.iter().map(|(name, weight)| format!("{weight:+.3} {name}")).collect::<Vec<_>>().join(" ")
}
