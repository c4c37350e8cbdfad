use super::{SimulatedDensity, Simulation, processes::Processes};
use crate::{error::Result, problem::Problem};
use mpi::{Rank, traits::Communicator, traits::Root};

/// The most bytes that a rank sends at once: MPI counts them in 31 bits.
const AT_ONCE: usize = 1 << 30;

impl Simulation<'_> {
    /// Runs the simulation on all ranks of an MPI communicator, each with its share of the batches, and returns the result
    /// of the single run, bit for bit, on every rank. Needs the feature `mpi`.
    ///
    /// All ranks must call it together, with the same problem and options. A rank's threads never call MPI, so that
    /// `MPI_THREAD_FUNNELED` suffices. More than 64 ranks, one for each batch, are of no use. A checkpoint is one file,
    /// read and written by rank 0: a run may go on with any number of ranks. The progress callback reports the share of its
    /// own rank; cancellation on one rank, and the end of its time, hold for all.
    ///
    /// # Errors
    /// As [`Simulation::run`], and [`Error::Rank`](crate::Error::Rank) on the ranks where nothing failed when another
    /// rank did.
    pub fn run_on(self, ranks: &impl Communicator, problem: &Problem) -> Result<SimulatedDensity> {
        self.run_among(problem, &Ranks(ranks))
    }
}

/// The ranks of a communicator.
pub(crate) struct Ranks<'a, C>(pub(crate) &'a C);

impl<C: Communicator> Processes for Ranks<'_, C> {
    fn rank(&self) -> usize {
        self.0.rank() as usize
    }

    fn count(&self) -> usize {
        self.0.size() as usize
    }

    fn exchange(&self, mine: Vec<u8>) -> Vec<Vec<u8>> {
        let word_of = |rank: usize| {
            let process = self.0.process_at_rank(rank as Rank);
            let mut length = mine.len() as u64;
            process.broadcast_into(&mut length);
            let mut word = if rank == self.rank() { mine.clone() } else { vec![0; length as usize] };
            word.chunks_mut(AT_ONCE).for_each(|piece| process.broadcast_into(piece));
            word
        };
        (0..self.count()).map(word_of).collect()
    }
}
