//! The process that runs the inputs, from the side of the one that watches it.

use super::Options;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;

pub(super) const MOST_GIGABYTES: f64 = 6.0;

/// A report from the process.
pub(super) enum Report {
    /// An input begins.
    Input(u64),
    /// One of its steps begins.
    Step(String),
    /// This step may take so many times as long as others.
    Longer(f64),
    /// An input is done, with so many damaged texts and files.
    Done(u64),
    /// Its kind and its text.
    Finding(String, String),
    /// A line for the reader.
    Text(String),
    /// The process is no more, by a failure if there is a text.
    Ended(Option<String>),
    Nothing,
}

pub(super) struct Worker {
    child: Child,
    lines: Receiver<String>,
}

impl Worker {
    /// Starts at an input.
    pub(super) fn new(options: &Options, folder: &Path, from: u64) -> std::io::Result<Self> {
        let mut command = Command::new(std::env::current_exe()?);
        command.arg("fuzz").args(["--seed", &options.seed.to_string(), "--from", &from.to_string()]);
        for (name, value) in [("--count", options.count), ("--only", options.only)] {
            command.args(value.map(|value| format!("{name}={value}")));
        }
        let mut child = command.arg("--worker").arg(folder).stdout(Stdio::piped()).stderr(Stdio::null()).spawn()?;
        let output = child.stdout.take().ok_or(std::io::ErrorKind::BrokenPipe)?;
        let (sender, lines) = channel();
        std::thread::spawn(move || {
            for line in BufReader::new(output).lines().map_while(Result::ok) {
                if sender.send(line).is_err() {
                    break;
                }
            }
        });
        Ok(Worker { child, lines })
    }

    /// The next line, if it comes within a time.
    pub(super) fn report(&mut self, patience: Duration) -> Report {
        let line = match self.lines.recv_timeout(patience) {
            Ok(line) => line,
            Err(RecvTimeoutError::Timeout) => return Report::Nothing,
            Err(RecvTimeoutError::Disconnected) => {
                return match self.child.wait() {
                    Ok(status) if status.success() => Report::Ended(None),
                    Ok(status) => Report::Ended(Some(status.to_string())),
                    Err(error) => Report::Ended(Some(error.to_string())),
                };
            }
        };
        let (word, rest) = line.split_once(' ').unwrap_or((&line, ""));
        match word {
            "input" => Report::Input(rest.parse().unwrap_or_default()),
            "step" => Report::Step(rest.to_owned()),
            "longer" => Report::Longer(rest.parse().unwrap_or(1.0)),
            "done" => Report::Done(rest.parse().unwrap_or_default()),
            "finding" => {
                let (kind, text) = rest.split_once(' ').unwrap_or((rest, ""));
                Report::Finding(kind.to_owned(), text.to_owned())
            }
            _ => Report::Text(rest.to_owned()),
        }
    }

    /// The memory that it holds; 0 where the operating system does not report it.
    pub(super) fn gigabytes(&self) -> f64 {
        let pages = std::fs::read_to_string(format!("/proc/{}/statm", self.child.id())).unwrap_or_default();
        let resident: f64 = pages.split(' ').nth(1).and_then(|pages| pages.parse().ok()).unwrap_or(0.0);
        resident * 4096.0 / 1e9
    }

    pub(super) fn end(mut self) -> std::io::Result<()> {
        // It may have ended already.
        let _ = self.child.kill();
        self.child.wait().map(|_| ())
    }
}
