use super::{OrderStudy, OrderTable, Sweep, SweepTable};
use crate::error::Result;
use crate::simulation::ranks::Ranks;
use mpi::traits::Communicator;

impl OrderStudy<'_> {
    /// Computes the study on all ranks of an MPI communicator, its rows dealt to them, and returns the whole table on every
    /// rank. Needs the feature `mpi`.
    ///
    /// All ranks must call it together, with the same study. Each appends its rows to its [`OrderStudy::file`], and they send
    /// nothing before the end, so that a rank that is killed takes no more with it than the rows in progress. Another run, on any
    /// number of ranks that have the rows in their files, computes what is missing. The progress callback reports the rows of its
    /// own rank. A rank's threads never call MPI, so that `MPI_THREAD_FUNNELED` suffices; ranks on one machine share its cores
    /// best with a number of threads each (`RAYON_NUM_THREADS`).
    ///
    /// # Errors
    /// As [`OrderStudy::run`], and [`Error::Rank`](crate::Error::Rank) on the ranks where nothing failed when another rank
    /// did.
    pub fn run_on(self, ranks: &impl Communicator) -> Result<OrderTable> {
        self.run_among(&Ranks(ranks))
    }
}

impl Sweep<'_> {
    /// Computes the sweep on all ranks of an MPI communicator, as [`OrderStudy::run_on`], its segments dealt to them. Needs the
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
