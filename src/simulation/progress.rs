use std::{fmt, ops::ControlFlow};

/// How far a simulation or a study has come, in steps or rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Path-steps taken, time steps times trajectories; or the rows that are there, those of an earlier run included.
    pub done: u64,
    /// Path-steps in all, burn-in and pilot included: the most, where precision or time may end the run before; or the
    /// rows of the whole study.
    pub total: u64,
}

/// What a user does about it.
pub(super) struct Callback<'a>(pub(super) Box<dyn FnMut(Progress) -> ControlFlow<()> + Send + 'a>);

impl fmt::Debug for Callback<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Callback")
    }
}

/// The progress callback and what it was told last.
pub(super) struct Meter<'a> {
    pub(super) progress: Progress,
    pub(super) callback: Callback<'a>,
}
