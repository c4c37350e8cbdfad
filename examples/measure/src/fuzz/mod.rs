//! Does any input make the library panic, hang, or return a value that is no number?
//!
//! An input is a function of the seed and its number: a random system for one of the methods and for the statistics of what
//! comes back, mutants of a text or a document, or damaged files of a simulation or a study. Inputs run one after another in
//! another process, so that one that does not end, that aborts, or that takes all memory is a finding like the others.

mod densities;
mod documents;
mod files;
mod motion;
mod mutants;
mod probe;
mod systems;
mod watch;

use crate::Outcome;
use clap::Args;
use std::path::PathBuf;
use std::time::{Duration, Instant};
use watch::{Report, Worker};

/// Random inputs of all kinds.
#[derive(Clone, Debug, Args)]
pub(crate) struct Options {
    /// How long to go on
    #[arg(long, default_value_t = 10.0)]
    minutes: f64,
    /// Seed of all inputs
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// So many inputs, however long they take
    #[arg(long)]
    count: Option<u64>,
    /// The input of this number alone, printed whole
    #[arg(long)]
    only: Option<u64>,
    /// Seconds that one method may take for one input; closures by references in many states, which by their documentation
    /// take up to half a minute, may take three times as long
    #[arg(long, default_value_t = 20.0)]
    bound: f64,
    /// The folder of the process that runs the inputs
    #[arg(long, hide = true)]
    worker: Option<PathBuf>,
    /// The first input
    #[arg(long, default_value_t = 0, hide = true)]
    from: u64,
}

impl Options {
    /// The numbers of the inputs.
    fn numbers(&self) -> std::ops::Range<u64> {
        match (self.only, self.count) {
            (Some(only), _) => only..only + 1,
            (None, Some(count)) => self.from..count,
            (None, None) => self.from..u64::MAX,
        }
    }
}

/// What is wrong with an input.
struct Finding {
    number: u64,
    kind: String,
    text: String,
}

pub(crate) fn run(options: &Options) -> Outcome {
    if let Some(folder) = &options.worker {
        probe::work(options, folder);
        return Ok(());
    }
    let folder = std::env::temp_dir().join(format!("expoly-fuzz-{}", std::process::id()));
    std::fs::create_dir_all(&folder)?;
    let outcome = watched(options, &folder);
    std::fs::remove_dir_all(&folder)?;
    outcome
}

/// Runs the inputs in other processes, a new one after each that had to be ended.
fn watched(options: &Options, folder: &std::path::Path) -> Outcome {
    let begin = Instant::now();
    let timed = options.count.is_none() && options.only.is_none();
    let over = || timed && begin.elapsed().as_secs_f64() > 60.0 * options.minutes;
    let mut findings: Vec<Finding> = Vec::new();
    let (mut tried, mut documents, mut next) = (0u64, 0u64, options.numbers().start);
    let (mut slowest, mut slowest_step) = (0.0, String::new());
    while next < options.numbers().end && !over() {
        let mut worker = Worker::new(options, folder, next)?;
        let (mut number, mut step, mut since, mut bound) = (next, String::from("start"), Instant::now(), options.bound);
        let ended = loop {
            let report = worker.report(Duration::from_millis(200));
            if !matches!(report, Report::Nothing) {
                let seconds = since.elapsed().as_secs_f64();
                if seconds > slowest {
                    (slowest, slowest_step) = (seconds, format!("{number}: {step}"));
                }
                since = Instant::now();
            }
            match report {
                Report::Input(k) => (number, step) = (k, String::from("input")),
                Report::Step(name) => (step, bound) = (name, options.bound),
                Report::Longer(factor) => bound = factor * options.bound,
                Report::Done(count) => (tried, documents) = (tried + 1, documents + count),
                Report::Finding(kind, text) => {
                    println!("{number}: {kind}: {text}");
                    findings.push(Finding { number, kind, text });
                }
                Report::Text(line) => println!("{line}"),
                Report::Ended(None) => break None,
                Report::Ended(Some(status)) => break Some(("abort", status)),
                Report::Nothing if over() => break None,
                Report::Nothing if since.elapsed().as_secs_f64() > bound => {
                    break Some(("hang", format!("no answer within {bound} s")));
                }
                Report::Nothing if worker.gigabytes() > watch::MOST_GIGABYTES => {
                    break Some(("memory", format!("more than {} GB", watch::MOST_GIGABYTES)));
                }
                Report::Nothing => {}
            }
        };
        worker.end()?;
        let Some((kind, text)) = ended else { break };
        println!("{number}: {kind}: {step}: {text}");
        findings.push(Finding { number, kind: kind.to_owned(), text: format!("{step}: {text}") });
        (tried, next) = (tried + 1, number + 1);
    }
    println!("\n{tried} inputs with {documents} damaged texts and files in {:.0} s", begin.elapsed().as_secs_f64());
    println!("longest: {slowest:.1} s, {slowest_step}");
    summary(&mut findings);
    let repeat = format!("repeat one by --seed {} --only NUMBER", options.seed);
    if findings.is_empty() { Ok(()) } else { Err(format!("{} findings; {repeat}", findings.len()).into()) }
}

/// The findings by kind and text, with their numbers.
fn summary(findings: &mut [Finding]) {
    println!("findings: {}", findings.len());
    findings.sort_by(|a, b| (&a.kind, &a.text, a.number).cmp(&(&b.kind, &b.text, b.number)));
    for group in findings.chunk_by(|a, b| (&a.kind, &a.text) == (&b.kind, &b.text)) {
        let numbers: Vec<u64> = group.iter().map(|finding| finding.number).collect();
        println!("{} × {}: {}: inputs {numbers:?}", group.len(), group[0].kind, group[0].text);
    }
}
