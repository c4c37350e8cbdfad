//! Control of a simulation: the same bits on any number of threads, after interruptions and from parts; precision, time
//! and hostile input.

use crate::common::{moving::correlated, threads_of};
use expoly::{
    Crossing, Density, Drift, Error, Problem, Progress, Result, SimulatedDensity, Simulation, Stopped, Tolerance, Wall,
    models::{Duffing, Linear},
};
use std::{
    fs,
    ops::ControlFlow,
    path::{Path, PathBuf},
    time::Duration,
};

/// Every number of a result, bit for bit, but its time.
fn bits(result: &SimulatedDensity) -> Result<Vec<u64>> {
    let mut values = Vec::new();
    for i in 0..5 {
        values.extend((0..5 - i).map(|j| result.moment(&[i, j])).collect::<Result<Vec<_>>>()?);
    }
    for k in 0..result.histogram(0)?.len() {
        values.extend([result.histogram(0)?.bin(k)?, result.histogram(1)?.bin(k)?]);
    }
    if let Ok(joint) = result.joint([0, 1]) {
        let [rows, columns] = [0, 1].map(|k| joint.edges(k).count() - 1);
        for cell in 0..rows * columns {
            values.push(joint.cell(&[cell / columns, cell % columns])?);
        }
    }
    values.extend([result.upcrossing_rate(0.5)?, result.flux(Crossing::downward(0.2), 3)?]);
    values.extend(
        result
            .energy_balance()
            .into_iter()
            .chain([result.mean_impact_speed(), result.impact_rate()].into_iter().flatten()),
    );
    let mut bits: Vec<u64> = values.iter().flat_map(|e| [e.value.to_bits(), e.error.to_bits()]).collect();
    bits.extend(result.stationarity().into_iter().map(f64::to_bits));
    bits.extend((0..2).flat_map(|i| result.histogram(i)).flat_map(|h| h.edges(0).map(f64::to_bits)));
    let made = result.provenance();
    let counts = [made.trajectories, made.samples].map(|count| count.map(|count| count as u64));
    bits.extend([made.seed, counts[0], counts[1], made.path_steps].into_iter().flatten());
    Ok(bits)
}

fn samples(result: &SimulatedDensity) -> usize {
    result.provenance().samples.unwrap_or(0)
}

fn path_steps(result: &SimulatedDensity) -> u64 {
    result.provenance().path_steps.unwrap_or(0)
}

/// A file that is gone when the test ends.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        Scratch(std::env::temp_dir().join(format!("expoly-control-{}-{name}", std::process::id())))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.0);
    }
}

/// With a lossy wall, so that shorter steps, impacts and crossings are all there.
fn problem() -> Result<Problem> {
    Problem::of(Duffing::new(0.2, 1.0, 0.3, 0.2)?)?.with_wall(Wall::above(0.2, 0.8)?)
}

/// Long intervals make for many rounds and many reports of progress.
fn simulation<'a>(trajectories: usize) -> Simulation<'a> {
    let simulation = Simulation::new().levels([0.5]).burn_in(5.0).seed(11);
    simulation.trajectories(trajectories).samples(100 * trajectories).sampling_interval(4.0).time_step(0.02)
}

#[test]
fn the_result_is_the_same_on_any_number_of_threads() -> Result<()> {
    let problem = problem()?;
    // Single trajectories, and whole groups of lanes with some left over.
    for trajectories in [100, 1003] {
        let run = || simulation(trajectories).samples(4_000).run(&problem);
        let mut results = Vec::new();
        for threads in [1, 2, 7] {
            results.push(bits(&threads_of(threads).install(run)?)?);
        }
        assert!(results.iter().all(|r| *r == results[0]), "{trajectories} trajectories");
    }
    let free = problem.without_walls();
    let other = Simulation::new().samples(1000).seed(1).run(&free)?.moment(&[2, 0])?;
    assert_ne!(other, Simulation::new().samples(1000).seed(2).run(&free)?.moment(&[2, 0])?);
    Ok(())
}

/// A callback that ends a run beyond so many path-steps.
fn cancel_beyond(steps: u64) -> impl FnMut(Progress) -> ControlFlow<()> + Send {
    move |p| if p.done >= steps { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
}

#[test]
fn a_run_that_is_cancelled_again_and_again_finds_the_same() -> Result<()> {
    let (problem, file) = (problem()?, Scratch::new("cancelled"));
    // Whole groups of lanes and one with some idle; few bins, for small files.
    let run = || simulation(515).samples(515 * 60).bins(16);
    let result = run().run(&problem)?;
    let (whole, total) = (bits(&result)?, path_steps(&result));
    // The number of steps before a cancellation takes effect depends on the threads; the result must not.
    for sessions in [2, 5, 25] {
        let mut cancelled = 0;
        for session in 1..sessions {
            let stop = cancel_beyond(total / sessions * session);
            match run().checkpoint(&file.0, Duration::ZERO).progress(stop).run(&problem) {
                Err(Error::Cancelled { done, .. }) if (1..=total).contains(&done) => cancelled += 1,
                outcome => assert!(bits(&outcome?)? == whole, "it came to its end"),
            }
        }
        let result = run().checkpoint(&file.0, Duration::ZERO).run(&problem)?;
        assert!(4 * cancelled >= sessions - 1 && bits(&result)? == whole, "cancelled {cancelled} times");
        // The file now holds the result, and another run returns it.
        let again = run().checkpoint(&file.0, Duration::ZERO).run(&problem)?;
        assert!(bits(&again)? == whole && bits(&SimulatedDensity::from_checkpoint(&file.0)?)? == whole);
        assert!(fs::remove_file(&file.0).is_ok());
    }
    Ok(())
}

#[test]
fn a_run_in_many_short_sessions_finds_the_same() -> Result<()> {
    let (problem, file) = (problem()?, Scratch::new("sessions"));
    // A round of 1024 trajectories is 2²¹/1024/200 = 10 samples of each, and this run three rounds.
    let run = |samples: usize| simulation(1024).samples(1024 * samples);
    let mut lengths = Vec::new();
    let mut sessions = 0;
    let result = loop {
        let session = run(25).checkpoint(&file.0, Duration::from_secs(60));
        sessions += 1;
        assert!(sessions < 100, "it does not advance");
        match session.time_budget(Duration::from_nanos(1)).run(&problem) {
            Ok(result) if result.provenance().stopped == Some(Stopped::Samples) => break result,
            Ok(result) => {
                assert_eq!(result.provenance().stopped, Some(Stopped::TimeBudget));
                // What a session has found is the result of a shorter simulation.
                let samples = samples(&result) / 1024;
                lengths.push(samples);
                assert!(bits(&result)? == bits(&run(samples).run(&problem)?)?);
            }
            Err(Error::OutOfTime { steps }) => assert!(steps > 0),
            Err(error) => return Err(error),
        }
    };
    assert_eq!(lengths, [10, 20]);
    assert!(bits(&result)? == bits(&run(25).run(&problem)?)?);
    // A run that was over goes on with a larger number of samples.
    let more = run(26).checkpoint(&file.0, Duration::from_secs(60)).run(&problem)?;
    assert!(bits(&more)? == bits(&run(26).run(&problem)?)?);
    Ok(())
}

#[test]
fn parts_are_merged_to_the_single_run() -> Result<()> {
    let problem = problem()?;
    for (trajectories, samples) in [(100, 2_000), (520, 10_400)] {
        let run = || simulation(trajectories).samples(samples);
        let single = bits(&run().run(&problem)?)?;
        for parts in [2, 7] {
            let part = |k: usize| run().part(k, parts).run(&problem);
            // In an order of their own.
            let merged = SimulatedDensity::merge((1..=parts).rev().map(part).collect::<Result<Vec<_>>>()?)?;
            assert!(bits(&merged)? == single, "{trajectories} trajectories in {parts} parts");
        }
    }
    // A part of its own is a valid, less precise answer; parts may come from files; each must be there once.
    let file = Scratch::new("part");
    let run = || simulation(100).samples(2_000);
    let first = run().part(1, 2).checkpoint(&file.0, Duration::from_secs(60)).run(&problem)?;
    assert_eq!(first.provenance().trajectories, Some(50));
    let second = run().part(2, 2).run(&problem)?;
    let read = SimulatedDensity::from_checkpoint(&file.0)?;
    let merged = bits(&SimulatedDensity::merge([second.clone(), read])?)?;
    assert!(merged == bits(&run().run(&problem)?)?);
    let longer = run().samples(3_000).part(1, 2).run(&problem)?;
    let other = run().time_step(0.04).part(1, 2).run(&problem)?;
    let refused = [
        (vec![second.clone()], "trajectories 0..1 are missing"),
        (vec![first, second.clone(), second.clone()], "trajectories 50..51 are there twice"),
        (vec![longer, second.clone()], "have 30 and 20 samples"),
        (vec![other, second], "time step"),
    ];
    for (parts, said) in refused {
        let error = SimulatedDensity::merge(parts).err();
        assert!(matches!(&error, Some(Error::NotTheParts { problem }) if problem.contains(said)), "{said}: {error:?}");
    }
    assert!(matches!(SimulatedDensity::merge([]), Err(Error::NotTheParts { .. })));
    for (k, n) in [(0, 2), (3, 2), (1, 0), (1, 65)] {
        let refused = run().part(k, n).run(&problem);
        assert!(matches!(refused, Err(Error::OutOfRange { .. })), "part {k} of {n}");
    }
    Ok(())
}

#[test]
fn precision_ends_a_run_and_the_run_can_be_repeated() -> Result<()> {
    let problem = problem()?;
    // Plain, so that errors fall little by little; calibrated ones fall at once where a higher degree has blocks enough.
    let long = || simulation(512).sampling_interval(1.0).control_variates(false);
    let run = |bound: f64| {
        let run = long().samples(1_000_000).until(Tolerance::Relative(bound), |found| found.moment(&[0, 2]));
        run.until(Tolerance::Absolute(0.01), |found| found.flux(Crossing::downward(0.2), 1)).run(&problem)
    };
    let result = run(0.02)?;
    let (square, rate) = (result.moment(&[0, 2])?, result.flux(Crossing::downward(0.2), 1)?);
    assert_eq!(result.provenance().stopped, Some(Stopped::Precision));
    assert!(square.error <= 0.02 * square.value && rate.error <= 0.01);
    let samples = samples(&result);
    // It stopped at the first check that sufficed, an eighth after one that did not: the error then is not far below.
    assert!(samples < 1_000_000 && (square.error > 0.016 * square.value || rate.error > 0.008));
    assert!(bits(&run(0.02)?)? == bits(&result)?);
    let shorter = long().samples(samples).run(&problem)?;
    assert!(bits(&shorter)? == bits(&result)?, "it is the run of so many samples");

    // A target that is never reached leaves the run as long as it was allowed to be.
    let never = simulation(64).samples(1000);
    let never = never.until(Tolerance::Absolute(1e-9), |found| found.mean(0)).run(&problem)?;
    assert_eq!(never.provenance().stopped, Some(Stopped::Samples));
    // A value that the density does not have is no target.
    let unknown = simulation(64).until(Tolerance::Absolute(1.0), |f| f.moment(&[9, 9])).run(&problem);
    assert!(matches!(unknown, Err(Error::NotKnown { .. })));
    let uncounted = simulation(64).until(Tolerance::Absolute(1.0), |f| f.upcrossing_rate(0.7)).run(&problem);
    assert!(matches!(uncounted, Err(Error::NotKnown { what, .. }) if what.contains("0.7")));
    for bound in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let refused = simulation(64).until(Tolerance::Relative(bound), |f| f.mean(0)).run(&problem);
        assert!(matches!(refused, Err(Error::OutOfRange { .. })));
    }
    Ok(())
}

/// The effect of ending a run at a precision on its standard errors; `-- --nocapture` prints it.
#[test]
fn standard_errors_of_runs_that_were_ended_by_precision_cover() -> Result<()> {
    let problem = Problem::of(Duffing::new(0.5, 1.0, 0.3, 0.5)?)?;
    const RUNS: u64 = 100;
    let (mut by_precision, mut by_samples) = (Vec::new(), Vec::new());
    for seed in 0..RUNS {
        let run = || Simulation::new().time_step(0.04).seed(seed);
        let result = run().until(Tolerance::Relative(0.02), |found| found.moment(&[2, 0])).run(&problem)?;
        assert_eq!(result.provenance().stopped, Some(Stopped::Precision));
        by_precision.push(result.moment(&[2, 0])?);
        by_samples.push(run().samples(samples(&result)).seed(seed + 1000).run(&problem)?.moment(&[2, 0])?);
    }
    let mut ratios = Vec::new();
    for (what, estimates) in [("precision", by_precision), ("samples", by_samples)] {
        let deviations = estimates.iter().map(|e| e.deviation(0.661714969204).powi(2)).sum::<f64>();
        let error = estimates.iter().map(|e| e.error).sum::<f64>() / RUNS as f64;
        let ratio = (deviations / RUNS as f64).sqrt();
        println!("ended by {what}: deviations / standard errors {ratio:.3}, mean error {error:.5}");
        ratios.push(ratio);
    }
    // The root mean square of 100 deviations is known to 1/√200 = 7 %: three of that, and the few percent by which a run
    // ends too soon. Measured are 1.04, and 0.94 for runs of equal length.
    assert!(ratios.iter().all(|ratio| (0.78..1.25).contains(ratio)));
    Ok(())
}

/// A checkpoint of a finished run.
fn checkpointed(problem: &Problem, file: &Path) -> Result<()> {
    simulation(10).checkpoint(file, Duration::from_secs(60)).run(problem).map(|_| ())
}

/// Whether a file is refused, with a reason that has these words.
fn refused<R>(outcome: Result<R>, file: &Path, words: &str) -> bool {
    let named = |path: &str| path == file.display().to_string();
    matches!(outcome, Err(Error::NotThisRun { path, problem }) if named(&path) && problem.contains(words))
}

#[test]
fn spoiled_checkpoints_are_refused_and_left_as_they_are() -> Result<()> {
    let (problem, file) = (problem()?, Scratch::new("spoiled"));
    checkpointed(&problem, &file.0)?;
    let Ok(whole) = fs::read(&file.0) else { unreachable!("it was written just now") };
    let resume = || simulation(10).checkpoint(&file.0, Duration::from_secs(60)).run(&problem);
    let spoiled = |content: &[u8]| {
        let written = fs::write(&file.0, content).is_ok();
        let typed =
            [resume(), SimulatedDensity::from_checkpoint(&file.0)].map(|both| refused(both, &file.0, "cut off"));
        written && typed == [true; 2] && fs::read(&file.0).is_ok_and(|kept| kept == content)
    };
    // Cut off anywhere, with any byte altered, with bytes after it, a file of another kind, and an empty one.
    for k in 1..40 {
        assert!(spoiled(&whole[..whole.len() * k / 40]), "{k} fortieths of it");
        let mut altered = whole.clone();
        altered[whole.len() * k / 40] ^= 1 << (k % 8);
        assert!(spoiled(&altered), "a bit after {k} fortieths of it");
    }
    assert!(spoiled(&[&whole[..], b"more"].concat()) && spoiled(b"{ \"samples\": 1000 }") && spoiled(b""));
    assert!(fs::write(&file.0, &whole).is_ok() && resume().is_ok());

    let folder = file.0.with_file_name("no-such-folder").join("state");
    let nowhere = simulation(10).checkpoint(&folder, Duration::ZERO).run(&problem);
    assert!(matches!(nowhere, Err(Error::File { action: "write", .. })));
    assert!(matches!(SimulatedDensity::from_checkpoint(&folder), Err(Error::File { action: "read", .. })));
    Ok(())
}

#[test]
fn checkpoints_of_other_simulations_are_refused() -> Result<()> {
    let (problem, file) = (problem()?, Scratch::new("other"));
    checkpointed(&problem, &file.0)?;
    type Change = fn(Simulation<'_>) -> Simulation<'_>;
    let changes: [(Change, &str); 10] = [
        (|s| s.seed(12), "seed is 11, here 12"),
        (|s| s.time_step(0.01), "time step"),
        (|s| s.trajectories(20).samples(2000), "number of trajectories is 10, here 20"),
        (|s| s.burn_in(20.0), "burn-in"),
        (|s| s.sampling_interval(3.0), "sampling interval"),
        (|s| s.levels([0.25]), "list of levels"),
        (|s| s.start(correlated().0), "start"),
        (|s| s.bins(32), "number of bins"),
        (|s| s.samples(10), "samples of a trajectory, and 1 are asked for"),
        (|s| s.part(1, 2), "another part"),
    ];
    let other = |simulation: Simulation<'_>, problem: &Problem, words: &str| {
        refused(simulation.checkpoint(&file.0, Duration::ZERO).run(problem), &file.0, words)
    };
    for (change, words) in changes {
        assert!(other(change(simulation(10)), &problem, words), "{words}");
    }
    let near =
        Problem::of(Duffing::new(0.2, 1.0, 0.300_000_000_000_000_04, 0.2)?)?.with_wall(Wall::above(0.2, 0.8)?)?;
    assert!(other(simulation(10), &near, "system"));
    let wall = problem.without_walls().with_wall(Wall::above(0.2, 0.9)?)?;
    assert!(other(simulation(10), &wall, "list of walls"));
    assert!(other(simulation(10).levels([]), &Problem::of(Cubic)?, "system"));

    // A run that is not over has no result yet.
    let long = simulation(10).samples(1 << 20).checkpoint(&file.0, Duration::ZERO);
    assert!(matches!(long.progress(cancel_beyond(1_000_000)).run(&problem), Err(Error::Cancelled { .. })));
    assert!(refused(SimulatedDensity::from_checkpoint(&file.0), &file.0, "no result yet"));
    Ok(())
}

#[test]
fn no_time_is_no_result() -> Result<()> {
    let (problem, file) = (problem()?, Scratch::new("no-time"));
    let none = simulation(64).time_budget(Duration::ZERO).run(&problem);
    assert!(matches!(none, Err(Error::OutOfTime { .. })));
    // With a checkpoint of a run that was over there is a result to return.
    checkpointed(&problem, &file.0)?;
    let kept = simulation(10).checkpoint(&file.0, Duration::ZERO).time_budget(Duration::ZERO).run(&problem)?;
    assert_eq!(kept.provenance().stopped, Some(Stopped::Samples));
    Ok(())
}

/// A motion pressed to its wall, whose impacts are a hundred times faster than anything else, has no default times.
#[test]
fn impacts_that_are_too_fast_for_default_times_are_refused() -> Result<()> {
    let pressed =
        "states = ['x', 'v']\ndrift = { x = 'v', v = '-3.3e12 - 890*v - 2.36e-34*x^7' }\nnoise.w.v = '6.52e9'";
    let pressed = Problem::from_toml(pressed)?.with_wall(Wall::above(0.0, 0.464)?)?;
    let fast = Simulation::new().run(&pressed);
    assert!(matches!(fast, Err(Error::OutOfRange { name: "rate of the motion", .. })), "{fast:?}");
    Ok(())
}

/// A burn-in of years is given up, and so is a stretch of 2·10⁸ path-steps, on its way where it takes more than a second: the
/// batches are then where they were before, and a run goes on from there to the bits of one that was never given up.
#[test]
fn what_takes_longer_than_the_budget_is_given_up() -> Result<()> {
    let (problem, file) = (problem()?, Scratch::new("given-up"));
    let endless = simulation(64).burn_in(1e9).time_budget(Duration::ZERO).run(&problem);
    assert!(matches!(endless, Err(Error::OutOfTime { .. })), "{endless:?}");
    let run = || simulation(1003).sampling_interval(4000.0).samples(1003 * 2);
    let cut = run().checkpoint(&file.0, Duration::ZERO).time_budget(Duration::ZERO).run(&problem);
    let unfinished = |result: &SimulatedDensity| result.provenance().stopped == Some(Stopped::TimeBudget);
    assert!(matches!(&cut, Err(Error::OutOfTime { .. })) || cut.as_ref().is_ok_and(unfinished), "{cut:?}");
    let resumed = run().checkpoint(&file.0, Duration::ZERO).run(&problem)?;
    assert_eq!(bits(&resumed)?, bits(&run().run(&problem)?)?);
    Ok(())
}

#[test]
fn explosions_are_the_same_error_on_any_number_of_threads() -> Result<()> {
    // States grow a million times beyond the pilot's, at different times.
    let growing = Problem::of(Linear::new(-0.1, 1.0, 0.2)?)?;
    let run = || Simulation::new().time_step(0.02).burn_in(1.0).run(&growing);
    let Err(error @ Error::Exploded { .. }) = run() else { unreachable!("its damping is negative") };
    let Error::Exploded { trajectory, pilot: false, ref state, time, step } = error else {
        unreachable!("states stay within the bounds of the pilot, which has ended")
    };
    assert!(trajectory < 1024 && state.iter().any(|x| x.abs() > 1e5) && time > 1.0 && step == 0.02);
    for threads in [1, 7] {
        assert_eq!(threads_of(threads).install(run).err().as_ref(), Some(&error), "{threads} threads");
    }
    // A checkpoint does not change the error of the explosion.
    let file = Scratch::new("explosion");
    let again =
        || Simulation::new().time_step(0.02).burn_in(1.0).checkpoint(&file.0, Duration::ZERO).run(&growing).err();
    assert_eq!((again(), again()), (Some(error.clone()), Some(error)));
    Ok(())
}

/// dx = −x³ dt + dW, whose checkpoint belongs to a single state.
struct Cubic;

impl Drift<1, 1> for Cubic {
    fn drift<S: expoly::Scalar>(&self, [x]: [S; 1]) -> [S; 1] {
        [-x.powi(3)]
    }
    fn noise<S: expoly::Scalar>(&self, _: [S; 1]) -> [[S; 1]; 1] {
        [[S::from(1.0)]]
    }
}

#[test]
fn a_single_state_is_kept_as_well() -> Result<()> {
    let file = Scratch::new("single");
    let problem = Problem::of(Cubic)?;
    let run = || Simulation::new().trajectories(64).samples(20_000).burn_in(5.0);
    let kept = run().checkpoint(&file.0, Duration::ZERO).run(&problem)?;
    let read = SimulatedDensity::from_checkpoint(&file.0)?;
    assert_eq!((kept.moment(&[4])?, kept.pdf(&[0.1])?), (read.moment(&[4])?, read.pdf(&[0.1])?));
    assert_eq!(kept.moment(&[4])?, run().run(&problem)?.moment(&[4])?);
    Ok(())
}

#[test]
fn a_run_reports_progress_and_can_be_cancelled() -> Result<()> {
    let problem = problem()?.without_walls();
    let mut last = (0, 0);
    let count = |p: Progress| {
        last = (p.done, p.total);
        ControlFlow::Continue(())
    };
    let result = Simulation::new().samples(50_000).progress(count).run(&problem)?;
    assert_eq!(last, (path_steps(&result), path_steps(&result)));
    let stopped = Simulation::new().samples(1 << 40).progress(|_| ControlFlow::Break(())).run(&problem);
    assert!(matches!(stopped, Err(Error::Cancelled { done, .. }) if done > 0));
    Ok(())
}
