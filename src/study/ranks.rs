use super::order::OrderStudy;
use super::sweep::{Sweep, SweepTable};
use super::table::OrderTable;
use crate::error::Result;
use crate::simulation::ranks::Ranks;
use mpi::traits::Communicator;

impl OrderStudy<'_> {
    /// Computes the study on all ranks of an MPI communicator, each its part ([`OrderStudy::part`]), and returns the whole
    /// table on every rank. Needs the feature `mpi`, and a file in a folder that all ranks share.
    ///
    /// All ranks must call it together, with the same study. They send nothing until their parts have ended; then rank 0
    /// merges these. If a rank is killed, and MPI ends the others, what is lost are the rows in progress: another run, on any
    /// number of ranks, computes the rows that no part has. The progress callback reports the rows of its own rank, and ends
    /// the part of that rank alone. A rank's threads never call MPI, so that `MPI_THREAD_FUNNELED` suffices; ranks on one
    /// machine share its cores best with a number of threads each (`RAYON_NUM_THREADS`).
    ///
    /// # Errors
    /// As [`OrderStudy::run`] and [`merge`](super::merge()), [`Error::Rank`](crate::Error::Rank) on the ranks where nothing
    /// failed when another rank did, and [`Error::NotServed`](crate::Error::NotServed) for a study without a file and for a
    /// part.
    pub fn run_on(self, ranks: &impl Communicator) -> Result<OrderTable> {
        self.run_among(&Ranks(ranks))
    }
}

impl Sweep<'_> {
    /// Computes the sweep on all ranks of an MPI communicator, as [`OrderStudy::run_on`], each with its segments. Needs the
    /// feature `mpi`.
    ///
    /// # Errors
    /// As [`Sweep::run`] and [`OrderStudy::run_on`].
    pub fn run_on<W: Send + Sync>(
        self,
        ranks: &impl Communicator,
        solve: impl Fn(f64, Option<&W>) -> Result<(Vec<f64>, W)> + Sync,
    ) -> Result<SweepTable> {
        self.run_among(&Ranks(ranks), solve)
    }
}
