use crate::record::number;
use serde::{Deserialize, Serialize};

/// One row of the table of a study of orders. Values that are not known are `None`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct OrderRow {
    /// The problem.
    pub system: String,
    /// The method.
    pub method: String,
    /// The order n.
    pub order: u32,
    /// The classical method's basis.
    pub basis: Option<String>,
    /// The number of coefficients.
    pub unknowns: Option<usize>,
    /// The end of the search, in a few words.
    pub termination: Option<String>,
    /// Where the chosen density comes from or, of the classical method, the search that ended there.
    pub origin: Option<String>,
    /// Why there is no density.
    pub refusal: Option<String>,
    /// Why the density should not be relied on.
    pub warning: Option<String>,
    /// The method's own estimate of the L¹ error.
    #[serde(with = "number::option")]
    pub l1_estimate: Option<f64>,
    /// The indicator η.
    #[serde(with = "number::option")]
    pub indicator: Option<f64>,
    /// ‖F‖, the Galerkin equations: under the density itself or, of the classical method, under its Gaussian.
    #[serde(with = "number::option")]
    pub residual: Option<f64>,
    /// The condition number of the Jacobian.
    #[serde(with = "number::option")]
    pub condition: Option<f64>,
    /// The iterations that it took.
    pub iterations: Option<usize>,
    /// The seed of the pilot.
    pub seed: Option<u64>,
    /// The truth that the answer was compared with.
    pub truth: String,
    /// ∫ |p̃ − p| dx; against a simulation, of the first state's marginal.
    pub l1: Option<f64>,
    /// The error of that distance due to the truth's own error.
    #[serde(with = "number::option")]
    pub l1_error: Option<f64>,
    /// The distance of the closest exponential polynomial of the order, the best that any closure of it can do
    /// ([`Closure::fit`](crate::Closure::fit)): in one state to three without walls, where the truth is no simulation.
    pub closest: Option<f64>,
    /// The largest |log₁₀(p̃/p)| down to 1e-5 of the peak.
    pub tail: Option<f64>,
    /// The relative error of E x₁².
    pub mean_square_x: Option<f64>,
    /// The relative error of E x₂².
    pub mean_square_v: Option<f64>,
    /// The relative error of the rate of up-crossings of the mean; against a simulation, of 0.
    pub rate: Option<f64>,
    /// The power balance of the first oscillator, 0 for the truth.
    pub balance: Option<f64>,
    /// The time that the method took, beside other rows.
    pub seconds: f64,
}
