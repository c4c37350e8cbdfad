//! Statistics on request, beside those of every run, in constant memory.
//!
//! Each is one file, which has all of it: the option that requests it, its sums, how they are counted, and its answer. The list of
//! them is at the end of this one.

mod first_passage;
mod joint;
mod spectrum;

pub use first_passage::FirstPassage;
pub use spectrum::Spectrum;

use super::{
    plan::{Plan, same_level},
    run::at_most,
};
use crate::checks::dimension;
use crate::error::Result;
use serde::{Deserialize, Serialize};

/// The most moments that can be requested: each costs time at every sample.
const MOST_MOMENTS: usize = 64;
/// The highest degree of a moment that can be requested: beyond, a sum of powers is dominated by a single sample.
const HIGHEST_DEGREE: u32 = 32;

/// A statistic, as what counts it.
pub(super) trait Statistic: Sized {
    /// What the user asks for.
    type Request;
    /// The sums of a batch.
    type Sums;
    /// What is kept of each trajectory.
    type Path: Clone + Default;

    /// Refuses requests for so many states that are sampled at an interval.
    fn check(requests: &[Self::Request], states: usize, interval: f64) -> Result<()>;

    /// A level of state 0 whose up-crossings it needs.
    fn level(_: &Self::Request) -> Option<f64> {
        None
    }

    /// How many numbers it keeps of each trajectory, where they are many.
    fn kept(_: &Self::Request) -> usize {
        0
    }

    /// The counting of a request in a run of a plan.
    fn of(request: &Self::Request, plan: &Plan) -> Result<Self>;

    /// The sums before the first sample.
    fn sums(&self) -> Self::Sums;

    /// Counts one sample.
    fn observe(&self, sums: &mut Self::Sums, path: &mut Self::Path, sample: &Sample<'_>);
}

/// One sample of a trajectory.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample<'a> {
    /// The trajectory's number in its batch.
    pub(super) trajectory: usize,
    pub(super) x: &'a [f64],
    /// For each level the lanes that have crossed it since the last sample, one bit each; and the trajectory's lane.
    pub(super) crossed: &'a [u64],
    pub(super) lane: usize,
}

/// Counts a sample by all of a kind.
fn observe<S: Statistic>(recorders: &[S], sums: &mut [S::Sums], paths: &mut [S::Path], sample: &Sample<'_>) {
    let own = paths.iter_mut().skip(sample.trajectory * recorders.len());
    for ((recorder, sums), path) in recorders.iter().zip(sums).zip(own) {
        recorder.observe(sums, path, sample);
    }
}

/// Refuses moments that are too many or too high.
fn check_moments(moments: &[Vec<u32>], states: usize) -> Result<()> {
    at_most("number of moments", moments.len(), MOST_MOMENTS, "at most 64 can be named")?;
    moments.iter().try_for_each(|exponents| {
        dimension("the exponents of a moment", exponents.len(), states)?;
        let degree = exponents.iter().fold(0_u32, |sum, &power| sum.saturating_add(power));
        at_most("degree of a moment", degree as usize, HIGHEST_DEGREE as usize, "at most 32").map(drop)
    })
}

/// The collections of all statistics, by the name of each.
macro_rules! statistics {
    ($($name:ident: $statistic:ty),*) => {
        /// The statistics requested of a simulation beyond those of every run.
        #[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
        pub(super) struct Requests {
            /// The exponents of moments.
            pub(super) moments: Vec<Vec<u32>>,
            $(pub(super) $name: Vec<<$statistic as Statistic>::Request>),*
        }

        /// Their counting.
        #[derive(Clone, Debug, Default)]
        pub(super) struct Recorders {
            $($name: Vec<$statistic>),*
        }

        /// The sums of one batch.
        #[derive(Clone, Debug, Deserialize, Serialize)]
        pub(super) struct Recordings {
            $($name: Vec<<$statistic as Statistic>::Sums>),*
        }

        /// What is kept of the paths of a batch, those of one trajectory after another.
        #[derive(Clone, Debug, Deserialize, Serialize)]
        pub(super) struct Buffers {
            $($name: Vec<<$statistic as Statistic>::Path>),*
        }

        impl Requests {
            /// Refuses what has no meaning for trajectories of so many states that are sampled at an interval.
            pub(super) fn check(&self, states: usize, interval: f64) -> Result<()> {
                check_moments(&self.moments, states)?;
                $(<$statistic>::check(&self.$name, states, interval)?;)*
                Ok(())
            }

            /// The levels whose up-crossings are to be counted: those named, and those that statistics need.
            pub(super) fn with_levels(&self, named: &[f64]) -> Vec<f64> {
                let needed = [$(self.$name.iter().filter_map(<$statistic>::level).collect::<Vec<f64>>()),*];
                needed.into_iter().flatten().fold(named.to_vec(), |mut levels, level| {
                    if !levels.iter().any(|&other| same_level(other, level)) {
                        levels.push(level);
                    }
                    levels
                })
            }

            /// The numbers that so many trajectories keep.
            pub(super) fn kept(&self, trajectories: usize) -> f64 {
                let each = 0 $(+ self.$name.iter().map(<$statistic>::kept).sum::<usize>())*;
                each as f64 * trajectories as f64
            }
        }

        impl Recorders {
            /// Of the requests of a plan, which were checked.
            pub(super) fn new(plan: &Plan) -> Self {
                let requests = &plan.requests;
                Recorders {
                    $($name: requests.$name.iter().filter_map(|asked| <$statistic>::of(asked, plan).ok()).collect()),*
                }
            }

            /// Sums before the first sample.
            pub(super) fn recordings(&self) -> Recordings {
                Recordings { $($name: self.$name.iter().map(Statistic::sums).collect()),* }
            }

            /// The buffers of so many trajectories before their first sample.
            pub(super) fn buffers(&self, trajectories: usize) -> Buffers {
                Buffers { $($name: vec![Default::default(); trajectories * self.$name.len()]),* }
            }

            /// Counts one sample.
            pub(super) fn observe(&self, recordings: &mut Recordings, buffers: &mut Buffers, sample: Sample<'_>) {
                $(observe(&self.$name, &mut recordings.$name, &mut buffers.$name, &sample);)*
            }
        }
    };
}

statistics!(spectra: spectrum::Segments, passages: first_passage::PassageRecorder, joints: joint::JointBins);
