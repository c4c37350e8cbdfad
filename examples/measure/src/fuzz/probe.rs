//! The process that runs the inputs: it prints each step before it begins, and each finding.

use super::{Options, documents::Documents, files::Files, systems};
use crate::draw::Draw;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// The place and the message of the last panic.
static PANIC: Mutex<String> = Mutex::new(String::new());

/// When the call that is under way began.
static BEGUN: Mutex<Option<Instant>> = Mutex::new(None);

/// What a user does who waits for so many seconds: it ends the call that is under way.
pub(super) fn patience(seconds: f64) -> ControlFlow<()> {
    let begun = *BEGUN.lock().unwrap_or_else(PoisonError::into_inner);
    let over = begun.is_some_and(|begun| begun.elapsed().as_secs_f64() > seconds);
    if over { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
}

/// The calls of the library for one input, and their findings.
pub(super) struct Probe {
    pub(super) draw: Draw,
    pub(super) folder: PathBuf,
    /// Damaged texts and files so far.
    pub(super) documents: u64,
    /// Whether everything is printed.
    whole: bool,
}

/// Runs the inputs of the options.
pub(super) fn work(options: &Options, folder: &Path) {
    std::panic::set_hook(Box::new(|panic| {
        *PANIC.lock().unwrap_or_else(PoisonError::into_inner) = panic.to_string().replace('\n', " ");
    }));
    let (mut texts, mut files) = (Documents::default(), Files::default());
    for number in options.numbers() {
        println!("input {number}");
        let draw = Draw::new(options.seed, number as usize);
        let whole = options.only.is_some();
        let mut probe = Probe { draw, folder: folder.to_owned(), documents: 0, whole };
        match number % 8 {
            3 => texts.probe(&mut probe),
            7 => files.probe(&mut probe),
            _ => systems::probe(&mut probe),
        }
        println!("done {}", probe.documents);
    }
}

impl Probe {
    /// A call that must return.
    pub(super) fn step<T>(&mut self, name: &str, question: impl FnOnce() -> T) -> Option<T> {
        println!("step {name}");
        *BEGUN.lock().unwrap_or_else(PoisonError::into_inner) = Some(Instant::now());
        let answer = catch_unwind(AssertUnwindSafe(question));
        if answer.is_err() {
            let panic = PANIC.lock().unwrap_or_else(PoisonError::into_inner).clone();
            self.finding("panic", &format!("{name}: {panic}"));
        }
        answer.ok()
    }

    /// The call that is under way may take so many times as long as others.
    pub(super) fn may_take_longer(factor: f64) {
        println!("longer {factor}");
    }

    /// A call that may return an error, which must contain a remedy.
    pub(super) fn ask<T>(&mut self, name: &str, question: impl FnOnce() -> expoly::Result<T>) -> Option<T> {
        match self.step(name, question)? {
            Ok(answer) => Some(answer),
            Err(error) => {
                self.show(&format!("{name}: {error}"));
                if !has_remedy(&error) {
                    self.finding("no-remedy", &format!("{name}: {error}"));
                }
                None
            }
        }
    }

    /// A value that must be a number, and at least so much.
    pub(super) fn value(&mut self, name: &str, least: f64, question: impl FnOnce() -> expoly::Result<f64>) {
        if let Some(value) = self.ask(name, question) {
            self.show(&format!("{name} = {value}"));
            if value.is_nan() || value < least {
                self.finding("no-density", &format!("{name} = {value}"));
            }
        }
    }

    pub(super) fn finding(&mut self, kind: &str, text: &str) {
        println!("finding {kind} {}", text.replace('\n', " "));
    }

    /// Prints a text if everything is to be printed.
    pub(super) fn show(&self, text: &str) {
        if self.whole {
            text.lines().for_each(|line| println!("text {line}"));
        }
    }
}

/// Whether an error contains more than what is wrong: a clause of some words after the first.
fn has_remedy(error: &expoly::Error) -> bool {
    let text = error.to_string();
    let stopped = matches!(error, expoly::Error::Cancelled { .. });
    stopped || text.split([':', ';']).skip(1).any(|clause| clause.split_whitespace().count() > 2)
}
