//! Progress bars on standard error; they vanish where it is no terminal.

use indicatif::{ProgressBar, ProgressStyle};
use std::ops::ControlFlow;

/// A sign of activity for work without a measure of its progress.
pub fn spinner(name: &str) -> ProgressBar {
    let spinner = ProgressBar::new_spinner().with_message(name.to_owned());
    spinner.enable_steady_tick(std::time::Duration::from_millis(100));
    spinner
}

/// A bar for a simulation, and the callback that moves it.
pub fn simulation_bar(name: &str) -> (ProgressBar, impl FnMut(expoly::Progress) -> ControlFlow<()> + Send + use<>) {
    let bar = bar(name);
    let handle = bar.clone();
    let callback = move |progress: expoly::Progress| {
        handle.set_length(progress.total);
        handle.set_position(progress.done);
        ControlFlow::Continue(())
    };
    (bar, callback)
}

/// A bar for a study, and the callback that moves it and prints each row above it.
pub fn study_bar() -> (ProgressBar, impl FnMut(expoly::Progress, &str) -> ControlFlow<()> + Send + use<>) {
    let bar = bar("rows");
    let handle = bar.clone();
    let callback = move |progress: expoly::Progress, row: &str| {
        handle.set_length(progress.total);
        handle.set_position(progress.done);
        handle.println(row);
        ControlFlow::Continue(())
    };
    (bar, callback)
}

fn bar(name: &str) -> ProgressBar {
    let bar = ProgressBar::new(1);
    let template = "{msg:32} [{bar:40}] {percent:>3} % {eta_precise}";
    // A template that does not parse would only change the appearance.
    bar.set_style(ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.set_message(name.to_owned());
    bar
}
