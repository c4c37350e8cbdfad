//! Progress bars on standard error; they vanish where it is no terminal.

use indicatif::{ProgressBar, ProgressStyle};

/// A sign of activity for work without a measure of its progress.
pub fn spinner(name: &str) -> ProgressBar {
    let spinner = ProgressBar::new_spinner().with_message(name.to_owned());
    spinner.enable_steady_tick(std::time::Duration::from_millis(100));
    spinner
}

/// A bar, which [`advance`] moves.
pub fn bar(name: &str) -> ProgressBar {
    let bar = ProgressBar::new(1);
    let template = "{msg:32} [{bar:40}] {percent:>3} % {eta_precise}";
    // A template that does not parse would only change the appearance.
    bar.set_style(ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.set_message(name.to_owned());
    bar
}

/// Moves a bar to what is done of all.
pub fn advance(bar: &ProgressBar, done: u64, all: u64) {
    bar.set_length(all);
    bar.set_position(done);
}
