//! The command line.

use clap::{Parser, ValueEnum};
use expoly::models::{Duffing, VibroImpactDuffing};
use expoly::{Basis, Weight};
use std::path::PathBuf;
use support::orders::weight;

/// Stationary density of the Duffing oscillator above a one-sided wall, y″ + c y′ + k y + μ y³ = ξ for y > b and
/// y′₊ = −r y′₋ at y = b, by the exponential-polynomial closure, by simulation and on a grid.
///
/// Without any option of one case, four standard walls are studied. The intensity D is that of
/// E[ξ(t)ξ(t+τ)] = 2D δ(τ).
#[derive(Clone, Debug, Parser)]
pub(crate) struct Options {
    /// Damping c [default: 0.2]
    #[arg(long, allow_negative_numbers = true)]
    damping: Option<f64>,
    /// Stiffness k [default: 1]
    #[arg(long, allow_negative_numbers = true)]
    stiffness: Option<f64>,
    /// Cubic stiffness μ [default: 0.3]
    #[arg(long, allow_negative_numbers = true)]
    cubic: Option<f64>,
    /// Position b of the wall [default: 0]
    #[arg(long, allow_negative_numbers = true)]
    offset: Option<f64>,
    /// Coefficient of restitution r, 0 < r ≤ 1 [default: 0.98]
    #[arg(long, allow_negative_numbers = true)]
    restitution: Option<f64>,
    /// Intensity D [default: 0.2]
    #[arg(long, allow_negative_numbers = true)]
    intensity: Option<f64>,
    /// Order of the closure [default: 8; of the classical method 4]
    #[arg(long)]
    order: Option<u32>,
    /// Close by the classical method, in this basis
    #[arg(long, value_enum)]
    basis: Option<BasisName>,
    /// The weight of the closure's fit: auto, density, or the share of the tails between 0 and 1
    #[arg(long, default_value = "auto", value_parser = weight, allow_negative_numbers = true)]
    pub(crate) weight: Weight,
    /// The methods to run
    #[arg(long, value_enum, default_value = "all")]
    pub(crate) method: Method,
    /// Samples of each simulation
    #[arg(long, default_value_t = 4_000_000)]
    pub(crate) samples: usize,
    /// L¹ accuracy of the grid
    #[arg(long, default_value = "1e-6")]
    pub(crate) accuracy: f64,
    /// The grid's limits of displacement and velocity [default: found by a pilot simulation]
    #[arg(long, num_args = 4, value_names = ["Y_LOW", "Y_HIGH", "V_LOW", "V_HIGH"], allow_negative_numbers = true)]
    pub(crate) domain: Option<Vec<f64>>,
    /// Seed of the simulation and of the closure's pilot
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Folder for figures and tables
    #[arg(long, default_value = "out/vibro_impact")]
    pub(crate) out: PathBuf,
    /// Displacements at which to print p_Y, separated by commas
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true)]
    pub(crate) at: Vec<f64>,
    /// Print one JSON object and write no files
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Method {
    /// The closure that gives a density at every order; with --basis, the classical one
    Closure,
    /// The literature's closure
    Classical,
    Simulation,
    Grid,
    All,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum BasisName {
    Classical,
    Folded,
}

/// c, k, μ, b, r and D.
pub(crate) type Case = [f64; 6];

pub(crate) fn model([c, k, mu, b, r, d]: Case) -> expoly::Result<VibroImpactDuffing> {
    VibroImpactDuffing::new(Duffing::new(c, k, mu, d)?, b, r)
}

impl Options {
    /// The case that the options describe, or the four standard ones.
    pub(crate) fn cases(&self) -> Vec<Case> {
        let given = [self.damping, self.stiffness, self.cubic, self.offset, self.restitution, self.intensity];
        let case = |[b, r]: [f64; 2]| {
            let standard = [0.2, 1.0, 0.3, b, r, 0.2];
            std::array::from_fn(|k| given[k].unwrap_or(standard[k]))
        };
        if self.json || given.iter().any(Option::is_some) {
            return vec![case([0.0, 0.98])];
        }
        VibroImpactDuffing::STANDARD_WALLS.map(case).to_vec()
    }

    /// The closures' orders, and the bases of classical ones: the closure that the options describe, or for comparison the
    /// classical method in both bases beside the robust one.
    pub(crate) fn closures(&self) -> Vec<(u32, Option<Basis>)> {
        let classical = |basis| (self.order.unwrap_or(4), Some(basis));
        let robust = (self.order.unwrap_or(8), None);
        match (self.method, self.basis) {
            (Method::Simulation | Method::Grid, _) => Vec::new(),
            (_, Some(BasisName::Folded)) => vec![classical(Basis::Folded)],
            (_, Some(BasisName::Classical)) | (Method::Classical, None) => vec![classical(Basis::Classical)],
            (Method::All, None) if !self.json && self.order.is_none() => {
                vec![classical(Basis::Classical), classical(Basis::Folded), robust]
            }
            (Method::All | Method::Closure, None) => vec![robust],
        }
    }
}
