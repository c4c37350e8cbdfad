//! The record of how a result was computed.

use crate::record::number;
use serde::{Deserialize, Serialize};
use std::fmt;

/// The limit that ended a simulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Stopped {
    /// All requested samples have been taken.
    Samples,
    /// Every estimate named in [`Simulation::until`](crate::Simulation::until) has the requested precision.
    Precision,
    /// The time of [`Simulation::time_budget`](crate::Simulation::time_budget) was over.
    TimeBudget,
}

/// The method of a density that is known.
pub(crate) const CLOSED_FORM: &str = "closed form";

/// The record of how a result was computed, by any method. A field is `None` where the method has no such number.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct Provenance {
    /// The method.
    pub method: String,

    /// The order n of a closure: the degree of Q.
    pub order: Option<u32>,
    /// The functions that Q is made of.
    pub basis: Option<String>,
    /// How an iteration ended.
    pub termination: Option<String>,
    /// The origin of the chosen density.
    pub origin: Option<String>,
    /// What a closure's density is closest to where that is neither the solution of moment equations nor the pilot's states, which are its
    /// origin: a grid, with its cells and its estimate, or a closed form.
    pub reference: Option<String>,
    /// Why there is no density.
    pub refusal: Option<String>,
    /// Why a closure has no reference although one was requested, so that the answer is that of the pilot's states.
    pub without_reference: Option<String>,
    /// Why the answer should not be relied on.
    pub warning: Option<String>,
    /// The number of unknowns.
    pub unknowns: Option<usize>,
    /// The number of nodes that integrals were taken on.
    pub nodes: Option<usize>,
    /// The steps of an iteration, or the linear systems that were solved.
    pub iterations: Option<usize>,
    /// The estimate of ∫ |p̃ − p| dx, between 0 and 2.
    #[serde(with = "number::option")]
    pub l1_estimate: Option<f64>,
    /// The residual tested against polynomials of a higher degree than Q's, in a norm of p̃.
    #[serde(with = "number::option")]
    pub indicator: Option<f64>,
    /// The size of the residual of the equations that were solved.
    #[serde(with = "number::option")]
    pub residual: Option<f64>,
    /// The condition number of the last linear system.
    #[serde(with = "number::option")]
    pub condition: Option<f64>,

    /// The seed of all random numbers. Trajectory i of a simulation owns stream i.
    pub seed: Option<u64>,
    /// The states of a closure's pilot, without mirror images.
    pub pilot_states: Option<usize>,
    /// The factor that the pilot's noise intensities were multiplied by.
    pub inflation: Option<f64>,
    /// Whether the pilot's earlier and later samples agree.
    pub stationary: Option<bool>,
    /// The degree of the polynomials whose moment equations the calibrated means satisfy: those of a closure's pilot, or of a
    /// simulation ([`Simulation::control_variates`](crate::Simulation::control_variates)).
    pub calibration_degree: Option<u32>,
    /// The smallest weight that calibration gave to a state of the pilot, where 1 is the plain one; below −2 the pilot
    /// has not mixed.
    #[serde(with = "number::option")]
    pub smallest_weight: Option<f64>,
    /// The standard deviation about 1 of the weights that calibration gave to a simulation's blocks of samples: small,
    /// unless the run was short, its time step long, or it was not stationary.
    #[serde(with = "number::option")]
    pub weight_deviation: Option<f64>,

    /// The number of independent trajectories.
    pub trajectories: Option<usize>,
    /// The number of samples in all.
    pub samples: Option<usize>,
    /// The number of time steps of all trajectories together, burn-in and pilot included.
    pub path_steps: Option<u64>,
    /// The time step h.
    pub time_step: Option<f64>,
    /// The rate ω that the time step was chosen by; none where the time step was given.
    pub rate: Option<f64>,
    /// The time before the first sample, as rounded.
    pub burn_in: Option<f64>,
    /// The time between two samples of a trajectory, as rounded.
    pub sampling_interval: Option<f64>,
    /// The limit that ended a simulation.
    pub stopped: Option<Stopped>,

    /// The cells of a grid.
    pub cells: Option<usize>,
    /// The degree of the polynomials within a cell.
    pub degree: Option<usize>,
    /// The entries of the matrix that are not zero.
    pub nonzeros: Option<usize>,
    /// The limits of each state, lower and upper.
    pub domain: Option<Vec<[f64; 2]>>,
    /// The matrix S of x = S y, by rows, where a grid's cells are boxes of other states y in which the density is rounder.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shear: Option<Vec<Vec<f64>>>,
    /// The largest density at an open edge of the domain, relative to the peak of a normal density with the same ∫ p² dx.
    #[serde(with = "number::option")]
    pub edge_level: Option<f64>,
    /// The probability that leaves the domain per unit time.
    #[serde(with = "number::option")]
    pub leak: Option<f64>,
    /// The most negative density relative to the peak.
    #[serde(with = "number::option")]
    pub most_negative: Option<f64>,
    /// The integral of the density's negative part.
    #[serde(with = "number::option")]
    pub negative_mass: Option<f64>,

    /// The independent replicas of a splitting.
    pub replicas: Option<usize>,
    /// The particles of each replica.
    pub particles: Option<usize>,
    /// The levels that particles are split at.
    pub thresholds: Option<Vec<f64>>,
    /// The time between two resamplings.
    pub resampling_interval: Option<f64>,
    /// The time before the first statistic of a replica.
    pub relaxation: Option<f64>,
    /// The time over which a replica's statistics were taken.
    pub duration: Option<f64>,

    /// The seconds of a grid's pilot, among the seconds in all.
    pub pilot_seconds: Option<f64>,
    /// The wall-clock time in seconds; of a resumed run, all its sessions; of merged parts, their sum.
    pub seconds: f64,
}

impl Provenance {
    /// That of a method without numbers.
    pub(crate) fn of_method(method: &str) -> Self {
        Provenance { method: method.to_owned(), ..Provenance::default() }
    }
}

impl fmt::Display for Provenance {
    /// The method with its size, the seed and the seconds, in one line: `closure, order 6, seed 0, 0.21 s`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.method)?;
        let sizes = [
            ("order", self.order.map(|order| order.to_string())),
            ("origin", self.origin.clone()),
            ("cells", self.cells.map(|cells| cells.to_string())),
            ("degree", self.degree.map(|degree| degree.to_string())),
            ("samples", self.samples.map(|samples| samples.to_string())),
            ("time step", self.time_step.map(|step| step.to_string())),
            ("particles", self.particles.map(|particles| particles.to_string())),
            ("seed", self.seed.map(|seed| seed.to_string())),
        ];
        let known = sizes.into_iter().filter_map(|(name, size)| Some((name, size?)));
        known.into_iter().try_for_each(|(name, size)| write!(f, ", {name} {size}"))?;
        if self.seconds > 0.0 { write!(f, ", {:.2} s", self.seconds) } else { Ok(()) }
    }
}
