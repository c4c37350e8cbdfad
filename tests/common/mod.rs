//! The systems and solutions that several tests share.

pub(crate) mod closing;
pub(crate) mod elastic;
pub(crate) mod moving;

use expoly::models::{
    BistableHarvester, ColouredVibroImpact, CubicDamping, DisplacementNoise, Duffing, DuffingChain, DuffingVanDerPol,
    EnergyDamping, FilteredDuffing, Linear, NonlinearEnergySink, ParametricLinear, QuinticDuffing, Solved,
    TunedAbsorber, VanDerPolRayleigh, VelocityNoise, ViscoelasticIsolator,
};
use expoly::{
    Closure, ClosureDensity, Density, Drift, Grid, GridDensity, Intensity, Parametric, Problem, Scalar, Wall,
};
use num_dual::Dual64;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, OnceLock};

/// Values that several tests use, by key, each made at its first use.
#[derive(Debug)]
pub(crate) struct Shared<K, V>(Mutex<BTreeMap<K, Arc<OnceLock<Arc<V>>>>>);

impl<K: Ord, V> Shared<K, V> {
    pub(crate) const fn new() -> Self {
        Shared(Mutex::new(BTreeMap::new()))
    }

    pub(crate) fn get(&self, key: K, make: impl FnOnce() -> V) -> Arc<V> {
        let place = self.0.lock().unwrap().entry(key).or_default().clone();
        place.get_or_init(|| Arc::new(make())).clone()
    }
}

/// A problem of a system that must be one.
pub(crate) fn problem<T, const N: usize, const M: usize>(system: T) -> Problem
where
    T: Drift<N, M> + 'static,
{
    Problem::of(system).unwrap()
}

/// Duffing's oscillator of all reference tables above a wall.
pub(crate) fn duffing_above(offset: f64, restitution: f64) -> Problem {
    parametric(duffing()).with_wall(Wall::above(offset, restitution).unwrap()).unwrap()
}

/// The density of a named problem by the grid, to 1e-7 in L¹.
pub(crate) fn on_grid(name: &'static str, problem: &Problem) -> Arc<GridDensity> {
    static SOLVED: Shared<&str, GridDensity> = Shared::new();
    SOLVED.get(name, || Grid::new().accuracy(1e-7).solve(problem).unwrap())
}

/// Duffing's oscillator of all reference tables between two walls.
pub(crate) fn between(walls: [Wall; 2]) -> Problem {
    walls.into_iter().fold(problem(duffing()), |problem, wall| problem.with_wall(wall).unwrap())
}

/// A wall below the motion and one above it, at these offsets and with these restitutions.
pub(crate) fn walls_at([low, high]: [f64; 2], [lower, upper]: [f64; 2]) -> [Wall; 2] {
    [Wall::above(low, lower).unwrap(), Wall::below(high, upper).unwrap()]
}

/// Two walls that take energy.
pub(crate) fn inelastic() -> [Wall; 2] {
    walls_at([-0.8, 1.2], [0.8, 0.6])
}

/// The density between them, to 1e-5 in L¹, where the mean of a displacement that is at most 1.2 is known to 1.2e-5, and better
/// as measured.
pub(crate) fn on_grid_between_walls() -> Arc<GridDensity> {
    static SOLVED: Shared<(), GridDensity> = Shared::new();
    SOLVED.get((), || Grid::new().accuracy(1e-5).solve(&between(inelastic())).unwrap())
}

/// That of [`duffing_above`]: to 1e-7 above an elastic wall, where it is smooth, and by the defaults above another.
pub(crate) fn on_grid_above(offset: f64, restitution: f64) -> Arc<GridDensity> {
    static SOLVED: Shared<[u64; 2], GridDensity> = Shared::new();
    let accuracy = if restitution < 1.0 { 1e-6 } else { 1e-7 };
    let solve = || Grid::new().accuracy(accuracy).solve(&duffing_above(offset, restitution)).unwrap();
    SOLVED.get([offset, restitution].map(f64::to_bits), solve)
}

/// ∫ |p̃ − p| dx of a density from a grid's, on the grid's own nodes.
pub(crate) fn l1_from(truth: &GridDensity, density: &dyn Density) -> f64 {
    let relative = |x: &[f64]| {
        let log = truth.log_pdf(x).unwrap();
        if log.is_finite() { (density.log_pdf(x).unwrap().exp() / log.exp() - 1.0).abs() } else { 0.0 }
    };
    truth.expectation(&relative).unwrap().value
}

/// ∫ |p̃ − p| dx over the closure's own draws, for p up to a constant.
pub(crate) fn l1_over_draws(log_truth: impl Fn(&[f64]) -> f64, density: &ClosureDensity) -> f64 {
    let (states, weights) = density.evidence().weighted_states().unwrap();
    let ratios: Vec<f64> = states.iter().map(|x| log_truth(x) - density.log_pdf(x).unwrap()).collect();
    let total: f64 = weights.iter().sum();
    let mean = ratios.iter().zip(&weights).map(|(ratio, w)| w * ratio).sum::<f64>() / total;
    ratios.iter().zip(&weights).map(|(ratio, w)| w * ((ratio - mean).exp() - 1.0).abs()).sum::<f64>() / total
}

/// The closure of a named problem.
pub(crate) fn closed(name: &'static str, problem: &Problem, order: u32, seed: u64) -> Arc<ClosureDensity> {
    static SOLVED: Shared<(&str, u32, u64), ClosureDensity> = Shared::new();
    SOLVED.get((name, order, seed), || Closure::new(order).seed(seed).solve(problem).unwrap())
}

/// The closure above a wall with the first seed.
pub(crate) fn closed_above(order: u32, offset: f64, restitution: f64) -> Arc<ClosureDensity> {
    static SOLVED: Shared<(u32, [u64; 2]), ClosureDensity> = Shared::new();
    let solve = || Closure::new(order).solve(&duffing_above(offset, restitution)).unwrap();
    SOLVED.get((order, [offset, restitution].map(f64::to_bits)), solve)
}

/// dx = −x dt + √2 dW.
#[derive(Debug)]
pub(crate) struct OrnsteinUhlenbeck;

impl Drift<1, 1> for OrnsteinUhlenbeck {
    fn drift<S: Scalar>(&self, [x]: [S; 1]) -> [S; 1] {
        [-x]
    }
    fn noise<S: Scalar>(&self, _: [S; 1]) -> [[S; 1]; 1] {
        [[S::from(2.0_f64.sqrt())]]
    }
}

/// Duffing's oscillator of all reference tables: c = 0.2, k = 1, μ = 0.3, D = 0.2.
pub(crate) fn duffing() -> Duffing {
    Duffing::new(0.2, 1.0, 0.3, 0.2).unwrap()
}

pub(crate) fn linear() -> Linear {
    Linear::new(0.3, 2.0, 0.45).unwrap()
}

pub(crate) fn bistable() -> Duffing {
    Duffing::new(1.0, -1.0, 1.0, 0.3).unwrap()
}

pub(crate) fn three_wells() -> QuinticDuffing {
    QuinticDuffing::new(1.0, 1.0, -1.8, 0.6, 0.3).unwrap()
}

pub(crate) fn van_der_pol_rayleigh() -> VanDerPolRayleigh {
    VanDerPolRayleigh::new(1.0, 0.15).unwrap()
}

pub(crate) fn energy_damping() -> EnergyDamping {
    EnergyDamping::new(0.2, 0.3, 0.3, 0.2).unwrap()
}

pub(crate) fn parametric_linear() -> ParametricLinear {
    ParametricLinear::new(0.1, 1.0, 0.5, 0.2).unwrap()
}

pub(crate) fn displacement_noise() -> DisplacementNoise {
    DisplacementNoise::new(0.5, 1.0, 0.4, 0.7, 0.5).unwrap()
}

pub(crate) fn velocity_noise() -> VelocityNoise {
    VelocityNoise::new([0.7, 0.3], [0.8, 0.0], 1.0, 0.4).unwrap()
}

pub(crate) fn van_der_pol() -> DuffingVanDerPol {
    DuffingVanDerPol::van_der_pol(0.5, 0.3).unwrap()
}

pub(crate) fn duffing_van_der_pol() -> Problem {
    problem(DuffingVanDerPol::new([-0.5, 1.0], 1.0, 1.0, 0.5).unwrap())
}

/// Two wells, and a damping that grows with the displacement: no closed form.
pub(crate) fn bistable_damping() -> Problem {
    problem(DuffingVanDerPol::new([0.3, 0.3], -1.0, 1.0, 0.3).unwrap())
}

pub(crate) fn rayleigh() -> CubicDamping {
    CubicDamping::rayleigh(1.0, 0.2).unwrap()
}

pub(crate) fn cubic_damping() -> CubicDamping {
    CubicDamping::new([0.1, 0.3], 1.0, 1.0, 0.5).unwrap()
}

/// The chain of two oscillators.
pub(crate) fn chain_of_two() -> DuffingChain {
    DuffingChain::new(&[0.2, 0.4], 1.0, 0.3, 0.5, 0.8).unwrap()
}

pub(crate) fn chain_of_three() -> DuffingChain {
    DuffingChain::new(&[0.2, 0.4, 0.3], 1.0, 0.3, 0.5, 0.8).unwrap()
}

/// The closure of order 4 of [`chain_of_two`].
pub(crate) fn closed_chain() -> Arc<ClosureDensity> {
    closed("chain of 2", &chain_of_two().problem().unwrap(), 4, 0)
}

pub(crate) fn harvester() -> BistableHarvester {
    BistableHarvester::new(Duffing::new(0.1, -1.0, 1.0, 0.04).unwrap(), [0.5, 0.5], 0.2).unwrap()
}

/// A structure with a hardening spring, x″ + 0.04 x′ + x + 0.8 x³ + s = 0.25 Ẇ, and a tuned absorber of a tenth of its mass,
/// s = 0.09 (x − y) + 0.03 (x′ − y′): noise on one mass alone, which the other is coupled to by the absorber's spring and
/// damper.
pub(crate) fn absorber() -> TunedAbsorber {
    let intensity = Intensity::from_sigma(0.25).unwrap().d();
    TunedAbsorber::new(Duffing::new(0.04, 1.0, 0.8, intensity).unwrap(), 0.1, 0.09, 0.03).unwrap()
}

/// A linear structure with a nonlinear energy sink.
pub(crate) fn energy_sink() -> NonlinearEnergySink {
    NonlinearEnergySink::new(Duffing::new(0.02, 1.0, 0.0, 0.05).unwrap(), 0.15, 0.4, 0.05).unwrap()
}

/// The problem of a system with its parameters.
fn parametric<T, const N: usize, const M: usize>(system: T) -> Problem
where
    T: Drift<N, M> + Parametric<With<f64> = T> + 'static,
    T::With<Dual64>: Drift<N, M, Dual64>,
{
    Problem::parametric(system).unwrap()
}

/// Every model once, as problems: systems of fixed and of any size, of both interpretations.
pub(crate) fn every_model() -> Vec<(&'static str, Problem)> {
    vec![
        ("linear", parametric(linear())),
        ("Duffing", parametric(duffing())),
        ("three wells", parametric(three_wells())),
        ("van der Pol-Rayleigh", parametric(van_der_pol_rayleigh())),
        ("energy damping", parametric(energy_damping())),
        ("parametric linear", parametric(parametric_linear())),
        ("displacement noise", parametric(displacement_noise())),
        ("velocity noise", parametric(velocity_noise())),
        ("van der Pol", parametric(van_der_pol())),
        ("Rayleigh", parametric(rayleigh())),
        ("chain of 3", chain_of_three().problem().unwrap()),
        ("vibro-impact", duffing_above(-0.5, 0.9)),
        ("harvester", harvester().problem().unwrap()),
        ("isolator", ViscoelasticIsolator::new(duffing(), 0.5, 2.0).unwrap().problem().unwrap()),
        ("absorber", absorber().problem().unwrap()),
        ("energy sink", energy_sink().problem().unwrap()),
        ("first-order filter", FilteredDuffing::first_order(duffing(), 4.0).unwrap().problem().unwrap()),
        ("second-order filter", FilteredDuffing::second_order(duffing(), 1.5, 0.2).unwrap().problem().unwrap()),
        (
            "coloured vibro-impact",
            ColouredVibroImpact::new(duffing(), 3.0, 0.1, [-0.5, 0.9]).unwrap().problem().unwrap(),
        ),
    ]
}

/// A pool of so many threads.
pub(crate) fn threads_of(threads: usize) -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap()
}

/// Numbers in (−1, 1) from a linear congruential generator (D. E. Knuth's MMIX): fixed points for tests without a crate.
pub(crate) struct Points(u64);

impl Points {
    pub(crate) fn new(seed: u64) -> Self {
        Points(seed)
    }

    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    pub(crate) fn array<const N: usize>(&mut self, scale: f64) -> [f64; N] {
        std::array::from_fn(|_| scale * self.next())
    }

    pub(crate) fn state(&mut self, states: usize, scale: f64) -> Vec<f64> {
        (0..states).map(|_| scale * self.next()).collect()
    }
}

/// All exponents of so many states up to a total degree, the constant's first.
pub(crate) fn monomials(states: usize, degree: u32) -> Vec<Vec<u32>> {
    let mut found: Vec<Vec<u32>> = vec![Vec::new()];
    for _ in 0..states {
        let longer = |alpha: &Vec<u32>| {
            let left = degree - alpha.iter().sum::<u32>();
            let alpha = alpha.clone();
            (0..=left).map(move |power| [&alpha[..], &[power]].concat())
        };
        found = found.iter().flat_map(longer).collect();
    }
    found.sort_by_key(|alpha| (alpha.iter().sum::<u32>(), std::cmp::Reverse(alpha.clone())));
    found
}

/// The rows of a reference table as numbers, without its header.
pub(crate) fn reference(name: &str) -> Vec<Vec<f64>> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/reference").join(name);
    let mut reader = csv::Reader::from_path(&path).unwrap();
    let number = |field: &str| field.parse().unwrap_or(f64::NAN);
    reader.records().map(|row| row.unwrap().iter().map(number).collect()).collect()
}
