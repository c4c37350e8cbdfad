use super::store::{Reader, Stored};
use crate::{Error, Result};

/// The processes that share the trajectories of one simulation.
pub(super) trait Peers {
    /// The number of this process, from 0.
    fn rank(&self) -> usize;

    /// The number of processes.
    fn count(&self) -> usize;

    /// What every process gives, in the order of their ranks. All must call it together.
    fn exchange(&self, mine: Vec<u8>) -> Result<Vec<Vec<u8>>>;
}

/// One process alone.
#[derive(Clone, Copy, Debug)]
pub(super) struct Alone;

impl Peers for Alone {
    fn rank(&self) -> usize {
        0
    }

    fn count(&self) -> usize {
        1
    }

    fn exchange(&self, mine: Vec<u8>) -> Result<Vec<Vec<u8>>> {
        Ok(vec![mine])
    }
}

/// What every process gives, or an error: that of this process first, else that of the first that failed.
pub(super) fn share(peers: &impl Peers, mine: Result<Vec<u8>>) -> Result<Vec<Vec<u8>>> {
    if peers.count() == 1 {
        return Ok(vec![mine?]);
    }
    let word = (mine.as_ref().err().map(Error::to_string), mine.as_ref().cloned().unwrap_or_default());
    let words = peers.exchange(word.bytes())?;
    mine?;
    let read = |(rank, bytes): (usize, Vec<u8>)| match Reader(&bytes).whole::<(Option<String>, Vec<u8>)>() {
        Some((None, word)) => Ok(word),
        Some((Some(reason), _)) => Err(Error::Rank { rank, reason }),
        None => Err(Error::Rank { rank, reason: String::from("its message cannot be read") }),
    };
    words.into_iter().enumerate().map(read).collect()
}

/// Whether any process was cancelled, and whether any raises each of the flags; or the error of one of them.
pub(super) fn agree(peers: &impl Peers, outcome: Result<()>, flags: [bool; 2]) -> Result<[bool; 3]> {
    let cancelled = matches!(outcome, Err(Error::Cancelled { .. }));
    let mine = [cancelled, flags[0], flags[1]].map(u8::from).to_vec();
    let words = share(peers, if cancelled { Ok(mine) } else { outcome.map(|()| mine) })?;
    Ok(std::array::from_fn(|k| words.iter().any(|word| word.get(k) == Some(&1))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        Barrier, Density, Estimate, Progress, SimulatedDensity, Simulation, Stopped, Tolerance,
        models::{Duffing, Linear},
    };
    use std::{
        ops::ControlFlow::{Break, Continue},
        sync::{self, Mutex, PoisonError},
        thread,
        time::Duration,
    };

    /// A process that is a thread.
    struct Thread<'a> {
        rank: usize,
        count: usize,
        board: &'a Mutex<Vec<Vec<u8>>>,
        gate: &'a sync::Barrier,
    }

    impl Peers for Thread<'_> {
        fn rank(&self) -> usize {
            self.rank
        }

        fn count(&self) -> usize {
            self.count
        }

        fn exchange(&self, mine: Vec<u8>) -> Result<Vec<Vec<u8>>> {
            let board = || self.board.lock().unwrap_or_else(PoisonError::into_inner);
            board()[self.rank] = mine;
            self.gate.wait();
            let all = board().clone();
            self.gate.wait();
            Ok(all)
        }
    }

    /// What each of `count` processes finds.
    fn among<R: Send>(count: usize, run: impl Fn(&Thread<'_>) -> Result<R> + Sync) -> Vec<Result<R>> {
        let (board, gate) = (Mutex::new(vec![Vec::new(); count]), sync::Barrier::new(count));
        let run = |rank| run(&Thread { rank, count, board: &board, gate: &gate });
        thread::scope(|scope| {
            let threads: Vec<_> = (0..count).map(|rank| scope.spawn(move || run(rank))).collect();
            let failed = |_| Err(Error::Rank { rank: 0, reason: String::from("a thread panicked") });
            threads.into_iter().map(|thread| thread.join().unwrap_or_else(failed)).collect()
        })
    }

    fn simulation(oscillator: &Duffing) -> Result<Simulation<'_, Duffing, 2, 1>> {
        let simulation = Simulation::new(oscillator).barrier(Barrier::new(0.2, 0.9)?).trajectories(1024);
        Ok(simulation.samples(1024 * 24).burn_in(5.0).sampling_interval(2.0))
    }

    fn numbers(result: &SimulatedDensity<2>) -> ([Estimate; 3], usize, u64, Stopped) {
        let made = result.provenance();
        let estimates =
            [result.moment([2, 0]), result.moment([0, 4]), result.impact_rate().unwrap_or(Estimate::exact(0.0))];
        (estimates, made.samples, made.path_steps, made.stopped)
    }

    #[test]
    fn any_number_of_processes_finds_the_same_on_each() -> Result<()> {
        let oscillator = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
        let precise =
            || Ok::<_, Error>(simulation(&oscillator)?.until(Tolerance::Relative(0.02), |f| Ok(f.moment([2, 0]))));
        let (single, single_precise) = (simulation(&oscillator)?.run()?, precise()?.run()?);
        assert_eq!(single_precise.provenance().stopped, Stopped::Precision);
        // 65 processes: one of them has no batch.
        for count in [2, 4, 65] {
            for result in among(count, |peers| simulation(&oscillator)?.run_among(peers)) {
                assert_eq!(numbers(&result?), numbers(&single), "{count} processes");
            }
        }
        for result in among(3, |peers| precise()?.run_among(peers)) {
            assert_eq!(numbers(&result?), numbers(&single_precise));
        }
        Ok(())
    }

    #[test]
    fn a_run_goes_on_with_another_number_of_processes() -> Result<()> {
        let oscillator = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
        let file = std::env::temp_dir().join(format!("expoly-peers-{}", std::process::id()));
        let run = || Ok::<_, Error>(simulation(&oscillator)?.checkpoint(&file, Duration::from_secs(60)));
        let single = simulation(&oscillator)?.run()?;
        for count in [3, 1] {
            // Out of time after one round, the second one with samples.
            let sessions = among(count, |peers| run()?.time_budget(Duration::ZERO).run_among(peers));
            let unfinished = |outcome: &Result<SimulatedDensity<2>>| match outcome {
                Ok(result) => result.provenance().stopped == Stopped::TimeBudget,
                Err(error) => matches!(error, Error::OutOfTime { .. }),
            };
            assert!(sessions.iter().all(unfinished), "{count} processes");
        }
        for result in among(4, |peers| run()?.run_among(peers)) {
            assert_eq!(numbers(&result?), numbers(&single));
        }
        let _ = std::fs::remove_file(&file);
        Ok(())
    }

    #[test]
    fn what_fails_in_one_process_ends_all() -> Result<()> {
        let growing = Linear::new(-1.0, 1.0, 0.2)?;
        let outcomes = among(4, |peers| Simulation::new(&growing).burn_in(1.0).run_among(peers));
        assert!(outcomes.iter().any(|o| matches!(o, Err(Error::Exploded { .. }))));
        assert!(outcomes.iter().all(|o| matches!(o, Err(Error::Exploded { .. } | Error::Rank { .. }))));
        let nowhere = std::env::temp_dir().join("no-such-folder").join("state");
        let oscillator = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
        let outcomes = among(2, |p| simulation(&oscillator)?.checkpoint(&nowhere, Duration::ZERO).run_among(p));
        assert!(
            matches!(&outcomes[0], Err(Error::File { .. })) && matches!(&outcomes[1], Err(Error::Rank { rank: 0, .. }))
        );
        Ok(())
    }

    #[test]
    fn with_one_process_all_are_cancelled() -> Result<()> {
        let oscillator = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
        // In the pilot, and after it, which takes 64 · 256 path-steps.
        for steps in [1, 100_000] {
            let outcomes = among(2, |peers| {
                let most = if peers.rank == 1 { steps } else { u64::MAX };
                let stop = move |p: Progress| if p.done >= most { Break(()) } else { Continue(()) };
                simulation(&oscillator)?.progress(stop).run_among(peers)
            });
            assert!(outcomes.iter().all(|o| matches!(o, Err(Error::Cancelled { .. }))), "beyond {steps}");
        }
        Ok(())
    }
}
