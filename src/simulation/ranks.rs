use super::{SimulatedDensity, Simulation, processes::Processes};
use crate::{error::Result, problem::Problem};
use mpi::{Count, datatype::PartitionMut, traits::Communicator, traits::CommunicatorCollectives};

/// The most bytes that all ranks together send at once: MPI counts them in 31 bits.
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

    fn exchange(&self, mine: Vec<u8>) -> Result<Vec<Vec<u8>>> {
        let mut lengths = vec![0_u64; self.count()];
        self.0.all_gather_into(&(mine.len() as u64), &mut lengths[..]);
        let mut all = vec![Vec::new(); self.count()];
        let chunk = AT_ONCE / self.count();
        let longest = lengths.iter().max().map_or(0, |&length| length as usize);
        for begin in (0..longest).step_by(chunk) {
            let piece = |length: usize| begin.min(length)..(begin + chunk).min(length);
            let counts: Vec<Count> = lengths.iter().map(|&length| piece(length as usize).len() as Count).collect();
            let ends = counts.iter().scan(0, |end, count| {
                *end += count;
                Some(*end)
            });
            let places: Vec<Count> = ends.zip(&counts).map(|(end, count)| end - count).collect();
            let mut received = vec![0_u8; counts.iter().sum::<Count>() as usize];
            let mut partition = PartitionMut::new(&mut received[..], &counts[..], &places[..]);
            self.0.all_gather_varcount_into(&mine[piece(mine.len())], &mut partition);
            for ((whole, &place), &count) in all.iter_mut().zip(&places).zip(&counts) {
                whole.extend_from_slice(&received[place as usize..(place + count) as usize]);
            }
        }
        Ok(all)
    }
}
