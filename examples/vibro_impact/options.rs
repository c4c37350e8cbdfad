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

/// One closure to solve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Task {
    Robust(u32),
    Classical(u32, Basis),
}

impl Method {
    /// Whether `method` is requested.
    pub(crate) fn includes(self, method: Method) -> bool {
        self == Method::All || self == method
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum BasisName {
    Classical,
    Folded,
}

/// The parameters of one oscillator and its wall.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Parameters {
    pub(crate) damping: f64,
    pub(crate) stiffness: f64,
    pub(crate) cubic: f64,
    pub(crate) offset: f64,
    pub(crate) restitution: f64,
    pub(crate) intensity: f64,
}

impl Parameters {
    pub(crate) fn model(&self) -> expoly::Result<VibroImpactDuffing> {
        let oscillator = Duffing::new(self.damping, self.stiffness, self.cubic, self.intensity)?;
        VibroImpactDuffing::new(oscillator, self.offset, self.restitution)
    }

    /// The parameters in one line, for captions and tables.
    pub(crate) fn line(&self) -> String {
        let Parameters { damping: c, stiffness: k, cubic: mu, offset: b, restitution: r, intensity: d } = self;
        format!("b = {b}, r = {r}, c = {c}, k = {k}, μ = {mu}, D = {d}")
    }

    /// The case as a file name.
    pub(crate) fn stem(&self) -> String {
        format!("b{}_r{}", self.offset, self.restitution)
    }
}

impl Options {
    /// The cases to study: the one that the options describe, or the four standard ones.
    pub(crate) fn cases(&self) -> Vec<Parameters> {
        let given = [self.damping, self.stiffness, self.cubic, self.offset, self.restitution, self.intensity];
        let case = |offset: f64, restitution: f64| Parameters {
            damping: self.damping.unwrap_or(0.2),
            stiffness: self.stiffness.unwrap_or(1.0),
            cubic: self.cubic.unwrap_or(0.3),
            offset: self.offset.unwrap_or(offset),
            restitution: self.restitution.unwrap_or(restitution),
            intensity: self.intensity.unwrap_or(0.2),
        };
        if self.json || given.iter().any(Option::is_some) {
            return vec![case(0.0, 0.98)];
        }
        VibroImpactDuffing::STANDARD_WALLS.iter().map(|[b, r]| case(*b, *r)).collect()
    }

    /// The closures to solve: the one that the options describe, or for comparison the classical method in both bases
    /// beside the robust one.
    pub(crate) fn closures(&self) -> Vec<Task> {
        let basis = self.basis.map(|name| match name {
            BasisName::Classical => Basis::Classical,
            BasisName::Folded => Basis::Folded,
        });
        let classical = |basis| Task::Classical(self.order.unwrap_or(4), basis);
        let robust = Task::Robust(self.order.unwrap_or(8));
        match (self.method, basis) {
            (Method::Simulation | Method::Grid, _) => Vec::new(),
            (_, Some(basis)) => vec![classical(basis)],
            (Method::Classical, None) => vec![classical(Basis::Classical)],
            (Method::Closure, None) => vec![robust],
            (Method::All, None) if self.json || self.order.is_some() => vec![robust],
            (Method::All, None) => vec![classical(Basis::Classical), classical(Basis::Folded), robust],
        }
    }
}
