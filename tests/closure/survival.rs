//! First passages by the closure: against the grid, a count in a simulation, and identities.

use crate::common::problem;
use crate::simulation::impulses::{laws, struck};
use expoly::models::{Duffing, DuffingVanDerPol};
use expoly::{Closure, ClosureDensity, Density, Error, Estimate, Gaussian, Grid, Problem, Simulation, Start, Wall};
use nalgebra::{dmatrix, dvector};
use std::sync::{Arc, OnceLock};

const NONE: f64 = f64::INFINITY;
/// The standard deviation of the displacement.
const SIGMA: f64 = 0.813_459;

fn duffing() -> &'static ClosureDensity {
    static DENSITY: OnceLock<ClosureDensity> = OnceLock::new();
    DENSITY.get_or_init(|| Closure::new(4).solve(&problem(crate::common::duffing())).unwrap())
}

fn gaussian(x: f64, spread: f64) -> Start {
    Start::Gaussian(Gaussian { mean: dvector![x, 0.0], covariance: dmatrix![spread, 0.0; 0.0, spread] })
}

/// Whether an estimate is within its own error and that of the truth.
fn is_within(found: Estimate, truth: Estimate) -> bool {
    (found.value - truth.value).abs() < found.error + truth.error
}

/// Rates on low, middle and high levels, of one side and of two, are within their errors from the grid's, which are 4e-4 to 2e-2 of
/// them, and for a limit cycle, at whose levels polynomials of low degree are far off, up to 0.12. So are the probabilities from starts of every kind, a Gaussian that a level cuts in half among them.
#[test]
fn survival_agrees_with_a_grid() {
    let wells = problem(Duffing::new(0.4, -1.0, 1.0, 0.3).unwrap());
    let cycle = problem(DuffingVanDerPol::van_der_pol(0.5, 0.5).unwrap());
    for (name, problem, most) in
        [("Duffing", problem(crate::common::duffing()), 0.03), ("two wells", wells, 0.03), ("van der Pol", cycle, 0.2)]
    {
        let grid = Grid::new().accuracy(1e-4).solve(&problem).unwrap();
        let density = Closure::new(6).solve(&problem).unwrap();
        let sigma = grid.variance(0).unwrap().value.sqrt();
        for share in [[-NONE, 1.0], [-NONE, 2.0], [-2.0, 2.0], [-1.0, 1.5]] {
            let within = share.map(|share| share * sigma);
            let (found, truth) = (density.survival(within).unwrap(), grid.survival(within).unwrap());
            let rates = (found.rate(), truth.rate().unwrap());
            println!("{name} {share:?}: {} and {}", rates.0, rates.1);
            assert!(is_within(rates.0, rates.1) && rates.0.error < most * rates.0.value, "{name} {share:?}");
            // One of the systems in time is enough, at what a grid takes.
            if name != "Duffing" || share != [-1.0, 1.5] {
                continue;
            }
            let known: Arc<dyn Density> = Arc::new(grid.clone());
            for start in
                [Start::Stationary, vec![0.2 * sigma, 0.0].into(), gaussian(1.5 * sigma, 0.05), Start::Density(known)]
            {
                let times = [0.0, 1.0, 6.0];
                let found = found.probability(&start, &times).unwrap();
                for ((found, truth), time) in
                    found.iter().zip(truth.probability(&start, &times, 1e-3).unwrap()).zip(times)
                {
                    println!("   {start:?}, t = {time}: {found} and {truth}");
                    // A point is known exactly, and the grid's mesh has it to some 1e-5.
                    assert!(
                        (found.value - truth.value).abs() < found.error + truth.error + 2e-5,
                        "{found} and {truth}"
                    );
                    assert!(found.error < 0.1, "{name} {start:?} {time}: {found}");
                }
            }
        }
    }
}

/// Under impulses, where no grid serves: P(T > t) against first passages counted on trajectories, within four joint errors.
#[test]
fn survival_under_impulses_agrees_with_a_count() {
    let problem = struck(0.3, &[laws(5.0, 0.2)[0]]);
    let level = 1.5;
    // 8 windows of 121 observations on each of 1000 trajectories.
    let simulation = Simulation::new().sampling_interval(0.1).trajectories(1000).samples(1000 * 121 * 8).seed(3);
    let counted = simulation.first_passage(level, 12.0, 4).run(&problem).unwrap();
    let counted = counted.first_passage(level).unwrap().distribution();
    let times: Vec<f64> = counted.iter().map(|(time, _)| *time).collect();
    let survival = Closure::new(6).solve(&problem).unwrap().survival([-NONE, level]).unwrap();
    for ((time, passed), found) in counted.iter().zip(survival.probability(&Start::Stationary, &times).unwrap()) {
        println!("t = {time}: {found}, counted {:.5} ± {:.5}", 1.0 - passed.value, passed.error);
        let off = (1.0 - passed.value - found.value).abs();
        assert!(off < found.error + 4.0 * passed.error, "t = {time}: {found} and 1 − {passed}");
        assert!(found.error < 0.02, "{found}");
    }
}

/// What survives falls from the stationary probability between the levels with the slowest rate in the end, and its integral is
/// the mean time. The order of the closure does not matter, since its moment equations are of their own degree.
#[test]
fn survival_is_one_answer() {
    let survival = duffing().survival([-NONE, SIGMA]).unwrap();
    assert_eq!(survival.within(), [-NONE, SIGMA]);
    let step = 0.05;
    let times: Vec<f64> = (0..=1200).map(|k| step * f64::from(k)).collect();
    let found = survival.probability(&Start::Stationary, &times).unwrap();
    let below: f64 = {
        let width = 0.001;
        (0..5000).map(|k| duffing().marginal(0, SIGMA - width * (f64::from(k) + 0.5)).unwrap().value * width).sum()
    };
    println!("{} and {below}", found[0]);
    // The closure of order 4 is exact here, and the midpoint rule has 1e-7.
    assert!((found[0].value - below).abs() < 1e-6, "{} and {below}", found[0]);
    assert!(found.windows(2).all(|pair| pair[1].value < pair[0].value));
    let rate = (found[1000].value / found[1200].value).ln() / (200.0 * step);
    assert!((rate / survival.rate().value - 1.0).abs() < 1e-6, "{rate} and {}", survival.rate());
    // The trapezoidal rule errs by h²/12 of the first slope, 0.13; what comes later is e^−9.
    let ends = (found[0].value + found[1200].value) / 2.0;
    let integral = step * (found.iter().map(|found| found.value).sum::<f64>() - ends) + found[1200].value / rate;
    let mean = survival.mean_time(&Start::Stationary).unwrap();
    println!("{integral} and {mean}");
    assert!((integral - mean.value).abs() < 1e-4, "{integral} and {mean}");
    let eighth = Closure::new(8).solve(&problem(crate::common::duffing())).unwrap();
    let other = eighth.survival([-NONE, SIGMA]).unwrap().rate();
    // The density is exact at both orders; the domains of the two pilots differ.
    assert!((other.value / survival.rate().value - 1.0).abs() < 1e-3, "{other}");
}

/// A level beyond the domain is never passed, with an error by what the density is there, and a start beyond a level has passed
/// it.
#[test]
fn far_levels_and_far_starts_are_themselves() {
    let far = duffing().survival([-NONE, 6.0]).unwrap();
    let found = far.probability(&Start::Stationary, &[0.0, 10.0]).unwrap();
    println!("{found:?} {}", far.rate());
    assert!(found.iter().all(|found| (found.value - 1.0).abs() < found.error + 1e-8 && found.error < 1e-5));
    assert!(far.rate().value.abs() < 1e-9 && far.rate().error < 1e-6, "{}", far.rate());
    assert!(matches!(far.mean_time(&Start::Stationary), Err(Error::SingularSystem { .. })));
    let near = duffing().survival([-NONE, SIGMA]).unwrap();
    let beyond = near.probability(&vec![1.5 * SIGMA, 0.0].into(), &[0.0, 1.0]).unwrap();
    assert!(beyond.iter().all(|beyond| beyond.value == 0.0), "{beyond:?}");
    let half = near.probability(&gaussian(SIGMA, 0.1), &[0.0]).unwrap();
    assert!((half[0].value - 0.5).abs() < 1e-12, "{half:?}");
}

#[test]
fn survivals_without_a_meaning_are_refused() {
    let refused = |within: [f64; 2]| duffing().survival(within).map(|survival| survival.within()).unwrap_err();
    for within in [[f64::NAN, 1.0], [1.0, -1.0], [1.0, 1.0], [NONE, NONE], [7.0, 8.0], [-NONE, -7.0], [1.0, 1.0 + 1e-9]]
    {
        assert!(matches!(refused(within), Error::OutOfRange { .. }), "{within:?}: {}", refused(within));
    }
    let survival = duffing().survival([-1.0, 1.0]).unwrap();
    let asked = |start: &Start, times: &[f64]| survival.probability(start, times).unwrap_err();
    for error in [
        asked(&Start::Stationary, &[-1.0]),
        asked(&Start::Stationary, &[1.0, 1.0]),
        asked(&Start::Stationary, &[f64::NAN]),
        asked(&Start::Stationary, &[0.0, NONE]),
        asked(&vec![f64::NAN, 0.0].into(), &[1.0]),
        // Inside of the levels, but where no velocity of the domain is.
        asked(&vec![0.0, 40.0].into(), &[1.0]),
    ] {
        assert!(matches!(error, Error::OutOfRange { .. }), "{error}");
    }
    assert!(matches!(asked(&vec![0.0].into(), &[1.0]), Error::Dimension { .. }));
    let text = |text: &str| {
        Closure::new(2).solve(&Problem::from_toml(text).unwrap()).unwrap().survival([-1.0, 1.0]).unwrap_err()
    };
    // No state of these two is the velocity of the other.
    let filters = "states = [\"x\", \"y\"]\n[drift]\nx = \"-x\"\ny = \"-2*y\"\n[noise.a]\nx = 1\n[noise.b]\ny = 1\n";
    assert!(matches!(text(filters), Error::NotADisplacement { state: 0 }));
    let one = "states = [\"x\"]\n[drift]\nx = \"-x\"\n[noise.a]\nx = 1\n";
    assert!(matches!(text(one), Error::NotADisplacement { state: 0 }));
    let three =
        "states = [\"x\", \"v\", \"z\"]\n[drift]\nx = \"v\"\nv = \"-x - 0.5*v + z\"\nz = \"-z\"\n[noise.a]\nz = 1\n";
    assert!(matches!(text(three), Error::NotServed { .. }));
    let walled = problem(crate::common::duffing()).with_wall(Wall::above(-0.5, 0.9).unwrap()).unwrap();
    let walled = Closure::new(4).solve(&walled).unwrap().survival([-NONE, 1.0]);
    assert!(matches!(walled, Err(Error::NotServed { .. })));
    let document: ClosureDensity = serde_json::from_str(&serde_json::to_string(duffing()).unwrap()).unwrap();
    assert!(matches!(document.survival([-1.0, 1.0]), Err(Error::NotKnown { .. })));
}
