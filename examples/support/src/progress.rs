//! Progress bars of simulations and studies.

use expoly::Progress;
use indicatif::ProgressBar;
use output::progress::{advance, bar};
use std::ops::ControlFlow;

pub use output::progress::spinner;

/// A bar for a simulation, and the callback that moves it.
pub fn simulation_bar(name: &str) -> (ProgressBar, impl FnMut(Progress) -> ControlFlow<()> + Send + use<>) {
    let bar = bar(name);
    let handle = bar.clone();
    let callback = move |progress: Progress| {
        advance(&handle, progress.done, progress.total);
        ControlFlow::Continue(())
    };
    (bar, callback)
}

/// A bar for a study, and the callback that moves it and prints each row above it.
pub fn study_bar() -> (ProgressBar, impl FnMut(Progress, &str) -> ControlFlow<()> + Send + use<>) {
    let bar = bar("rows");
    let handle = bar.clone();
    let callback = move |progress: Progress, row: &str| {
        advance(&handle, progress.done, progress.total);
        handle.println(row);
        ControlFlow::Continue(())
    };
    (bar, callback)
}
