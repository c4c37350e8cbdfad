use crate::error::{Error, Result};
use serde::{Serialize, de::DeserializeOwned};

/// The processes that share the trajectories of one simulation, or the rows of one study.
pub(crate) trait Processes {
    /// The number of this process, from 0.
    fn rank(&self) -> usize;

    /// The number of processes.
    fn count(&self) -> usize;

    /// The data of all processes, in the order of their ranks. All must call it together.
    fn exchange(&self, mine: Vec<u8>) -> Vec<Vec<u8>>;
}

/// One process alone.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OneProcess;

impl Processes for OneProcess {
    fn rank(&self) -> usize {
        0
    }

    fn count(&self) -> usize {
        1
    }

    fn exchange(&self, mine: Vec<u8>) -> Vec<Vec<u8>> {
        vec![mine]
    }
}

/// What the processes have, in the order of their ranks, on all of them; or an error: that of this process first, else that of
/// the first that failed. All must call it together.
pub(crate) fn gather<T: Serialize + DeserializeOwned>(processes: &impl Processes, mine: Result<T>) -> Result<Vec<T>> {
    if processes.count() == 1 {
        return Ok(vec![mine?]);
    }
    // What cannot be written is an empty word, which no process can read.
    let word = postcard::to_stdvec(&mine.as_ref().map_err(Error::to_string)).unwrap_or_default();
    let words = processes.exchange(word);
    mine?;
    let read = |(rank, word): (usize, Vec<u8>)| {
        let read: std::result::Result<T, String> =
            postcard::from_bytes(&word).unwrap_or_else(|error| Err(error.to_string()));
        read.map_err(|reason| Error::Rank { rank, reason })
    };
    words.into_iter().enumerate().map(read).collect()
}

/// Whether any process was cancelled, and whether any raises each of the flags; or the error of one of them.
pub(super) fn any_of<const N: usize>(
    processes: &impl Processes,
    outcome: Result<()>,
    flags: [bool; N],
) -> Result<(bool, [bool; N])> {
    let cancelled = matches!(outcome, Err(Error::Cancelled { .. }));
    let mine = if cancelled { Ok(()) } else { outcome };
    let all = gather(processes, mine.map(|()| (cancelled, flags.to_vec())))?;
    Ok((all.iter().any(|(cancelled, _)| *cancelled), std::array::from_fn(|k| all.iter().any(|(_, flags)| flags[k]))))
}

/// Processes that are threads.
#[cfg(test)]
pub(crate) mod threads {
    use super::*;
    use std::{
        sync::{self, Mutex, PoisonError},
        thread,
    };

    /// A process that is a thread.
    pub(crate) struct Thread<'a> {
        rank: usize,
        count: usize,
        board: &'a Mutex<Vec<Vec<u8>>>,
        gate: &'a sync::Barrier,
    }

    impl Processes for Thread<'_> {
        fn rank(&self) -> usize {
            self.rank
        }

        fn count(&self) -> usize {
            self.count
        }

        fn exchange(&self, mine: Vec<u8>) -> Vec<Vec<u8>> {
            let board = || self.board.lock().unwrap_or_else(PoisonError::into_inner);
            board()[self.rank] = mine;
            self.gate.wait();
            let all = board().clone();
            self.gate.wait();
            all
        }
    }

    /// The results of `count` processes.
    pub(crate) fn among<R: Send>(count: usize, run: impl Fn(&Thread<'_>) -> Result<R> + Sync) -> Vec<Result<R>> {
        let (board, gate) = (Mutex::new(vec![Vec::new(); count]), sync::Barrier::new(count));
        let run = |rank| run(&Thread { rank, count, board: &board, gate: &gate });
        thread::scope(|scope| {
            let threads: Vec<_> = (0..count).map(|rank| scope.spawn(move || run(rank))).collect();
            let failed = |_| Err(Error::Rank { rank: 0, reason: String::from("a thread panicked") });
            threads.into_iter().map(|thread| thread.join().unwrap_or_else(failed)).collect()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{threads::among, *};
    use crate::models::{Duffing, Linear};
    use crate::{
        Density, Estimate, Problem, Progress, Provenance, SimulatedDensity, Simulation, Stopped, Tolerance, Wall,
    };
    use std::ops::ControlFlow::{Break, Continue};
    use std::time::Duration;

    fn problem() -> Result<Problem> {
        Problem::of(Duffing::new(0.2, 1.0, 0.3, 0.2)?)?.with_wall(Wall::above(0.2, 0.9)?)
    }

    fn simulation<'a>() -> Simulation<'a> {
        Simulation::new().trajectories(1024).samples(1024 * 24).burn_in(5.0).sampling_interval(2.0)
    }

    fn numbers(result: &SimulatedDensity) -> Result<([Estimate; 2], Option<Estimate>, Provenance)> {
        let made = Provenance { seconds: 0.0, ..result.provenance().clone() };
        Ok(([result.moment(&[2, 0])?, result.moment(&[0, 4])?], result.impact_rate(), made))
    }

    #[test]
    fn any_number_of_processes_finds_the_same_on_each() -> Result<()> {
        let problem = problem()?;
        let precise = || simulation().until(Tolerance::Relative(0.02), |f| f.moment(&[2, 0]));
        let (single, single_precise) = (simulation().run(&problem)?, precise().run(&problem)?);
        assert_eq!(single_precise.provenance().stopped, Some(Stopped::Precision));
        // 65 processes: one of them has no batch.
        for count in [2, 65] {
            for result in among(count, |processes| simulation().run_among(&problem, processes)) {
                assert_eq!(numbers(&result?)?, numbers(&single)?, "{count} processes");
            }
        }
        for result in among(3, |processes| precise().run_among(&problem, processes)) {
            assert_eq!(numbers(&result?)?, numbers(&single_precise)?);
        }
        Ok(())
    }

    /// Each session is out of time after one round, the second one with samples.
    #[test]
    fn a_run_goes_on_with_another_number_of_processes() -> Result<()> {
        let problem = problem()?;
        let file = std::env::temp_dir().join(format!("expoly-processes-{}", std::process::id()));
        let run = || simulation().checkpoint(&file, Duration::from_secs(60));
        let single = simulation().run(&problem)?;
        for count in [3, 1] {
            let sessions = among(count, |processes| run().time_budget(Duration::ZERO).run_among(&problem, processes));
            let unfinished = |outcome: &Result<SimulatedDensity>| match outcome {
                Ok(result) => result.provenance().stopped == Some(Stopped::TimeBudget),
                Err(error) => matches!(error, Error::OutOfTime { .. }),
            };
            assert!(sessions.iter().all(unfinished), "{count} processes");
        }
        for result in among(4, |processes| run().run_among(&problem, processes)) {
            assert_eq!(numbers(&result?)?, numbers(&single)?);
        }
        let _ = std::fs::remove_file(&file);
        Ok(())
    }

    #[test]
    fn what_ends_one_process_ends_all() -> Result<()> {
        let (problem, growing) = (problem()?, Problem::of(Linear::new(-1.0, 1.0, 0.2)?)?);
        let outcomes = among(4, |processes| Simulation::new().burn_in(1.0).run_among(&growing, processes));
        assert!(outcomes.iter().any(|o| matches!(o, Err(Error::Exploded { .. }))));
        assert!(outcomes.iter().all(|o| matches!(o, Err(Error::Exploded { .. } | Error::Rank { .. }))));
        // Cancelled in the pilot, and after it, which takes 64 · 256 path-steps.
        for steps in [1, 100_000] {
            let outcomes = among(2, |processes| {
                let most = if processes.rank() == 1 { steps } else { u64::MAX };
                let stop = move |p: Progress| if p.done >= most { Break(()) } else { Continue(()) };
                simulation().progress(stop).run_among(&problem, processes)
            });
            assert!(outcomes.iter().all(|o| matches!(o, Err(Error::Cancelled { .. }))), "beyond {steps}");
        }
        Ok(())
    }
}
