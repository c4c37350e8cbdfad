//! The largest resident memory of simulations of ever more path-steps: it does not depend on their number, or this fails.
//! Linux only, since the memory is read from /proc.

use crate::Outcome;
use clap::Args;
use expoly::models::{Duffing, VibroImpactDuffing};
use expoly::{Density, Simulation};
use std::{error::Error, fs, time::Instant};

/// How long to simulate.
#[derive(Clone, Debug, Args)]
pub(crate) struct Options {
    /// The numbers of path-steps, rising, since the largest memory of the process is what is printed
    #[arg(long, value_delimiter = ',', default_values_t = [1e7, 1e8, 1e9])]
    path_steps: Vec<f64>,
    /// The number of trajectories
    #[arg(long, default_value_t = 1024)]
    trajectories: usize,
}

/// Time steps between samples; a sample each few steps would make memory grow fastest if any of it were kept.
const INTERVAL: f64 = 5.0;
const STEP: f64 = 0.02;

pub(crate) fn run(options: &Options) -> Outcome {
    let problem = VibroImpactDuffing::new(Duffing::new(0.2, 1.0, 0.3, 0.2)?, 0.2, 0.9)?.problem()?;
    println!("{:>12} {:>12} {:>8} {:>16}", "path-steps", "samples", "seconds", "peak memory, kB");
    println!("{:>12} {:>12} {:>8} {:>16}", 0, 0, "", peak_memory()?);
    let mut first = None;
    for path_steps in &options.path_steps {
        let begin = Instant::now();
        let simulation = Simulation::new().trajectories(options.trajectories).time_step(STEP).burn_in(20.0);
        let simulation = simulation.sampling_interval(INTERVAL * STEP).samples((path_steps / INTERVAL) as usize);
        let result = simulation.run(&problem)?;
        let (made, seconds) = (result.provenance(), begin.elapsed().as_secs_f64());
        let peak = peak_memory()?;
        let [steps, samples] =
            [made.path_steps, made.samples.map(|samples| samples as u64)].map(Option::unwrap_or_default);
        println!("{steps:>12} {samples:>12} {seconds:>8.1} {peak:>16}");
        // A tenth is allowed for the allocator; samples that were kept would take gigabytes.
        if peak > *first.get_or_insert(peak) * 11 / 10 {
            return Err("the memory grew with the number of path-steps".into());
        }
    }
    Ok(())
}

/// The largest resident memory of this process so far, in kB.
fn peak_memory() -> Result<u64, Box<dyn Error>> {
    let status = fs::read_to_string("/proc/self/status")?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).ok_or("no VmHWM in /proc/self/status")?;
    Ok(line.trim().trim_end_matches("kB").trim().parse()?)
}
