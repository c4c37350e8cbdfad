//! Standard errors of combinations of several means of one simulation, against the spread over independent runs.

use crate::common::*;
use expoly::models::Solved;
use expoly::statistics::{Cumulants, Impacts, Marginal};
use expoly::{Density, Estimate, Problem, SimulatedDensity, Simulation};

/// Independent runs, which differ by their seeds.
const RUNS: u64 = 60;

/// One list of answers from each run.
type Answers = Vec<(&'static str, Estimate)>;

/// 256 trajectories with 16 samples each.
fn run(seed: u64, problem: &Problem) -> SimulatedDensity {
    let simulation = Simulation::new().trajectories(256).samples(4096).burn_in(30.0).seed(seed);
    simulation.time_step(0.05).run(problem).unwrap()
}

fn free(seed: u64) -> Answers {
    let density = run(seed, &problem(duffing()));
    let (cumulants, marginal) = (Cumulants::new(&density, 0).unwrap(), Marginal::new(&density, 0).unwrap());
    vec![
        ("variance", cumulants.variance),
        ("fourth cumulant", cumulants.fourth),
        ("skewness", cumulants.skewness()),
        ("kurtosis", cumulants.kurtosis()),
        ("P(X > 1)", marginal.exceedance(1.0).unwrap()),
        ("P(X <= 0.5)", marginal.distribution(0.5).unwrap()),
        ("quantile 0.8", marginal.quantile(0.8).unwrap()),
        ("upper quantile 0.05", marginal.upper_quantile(0.05).unwrap()),
    ]
}

fn walled(seed: u64) -> Answers {
    let problem = duffing_above(-0.3, 0.8);
    let impacts = Impacts::new(&run(seed, &problem), &problem).unwrap();
    vec![
        ("impact rate", impacts.rate()),
        ("mean impact speed", impacts.mean_speed()),
        ("mean impact energy loss", impacts.energy_loss()),
        ("density of impact speeds at 1", impacts.speed_pdf(1.0).unwrap()),
        ("share of impacts faster than 1", impacts.speed_exceedance(1.0).unwrap()),
    ]
}

/// The spread of each answer over the runs is its stated error. A spread from R normal values has the relative standard
/// error 1/√(2(R − 1)), 9 % here; four of these are allowed. The mean stated error adds little: one alone, from 64 batches,
/// is known to 9 %, and there are R of them.
#[test]
fn stated_errors_are_the_spread() {
    for answers in [free as fn(u64) -> Answers, walled] {
        let runs: Vec<Answers> = (0..RUNS).map(answers).collect();
        for (k, (what, _)) in runs[0].iter().enumerate() {
            let count = RUNS as f64;
            let mean = runs.iter().map(|run| run[k].1.value).sum::<f64>() / count;
            let squares: f64 = runs.iter().map(|run| (run[k].1.value - mean).powi(2)).sum();
            let spread = (squares / (count - 1.0)).sqrt();
            let stated = runs.iter().map(|run| run[k].1.error).sum::<f64>() / count;
            println!("{what}: {mean:.4}, spread {spread:.4}, stated {stated:.4}, ratio {:.2}", stated / spread);
            let allowed = 4.0 / (2.0 * (count - 1.0)).sqrt();
            assert!((spread / stated - 1.0).abs() < allowed, "{what}: spread {spread:.4}, stated {stated:.4}");
        }
    }
}

fn mean_of_power(density: &SimulatedDensity, state: usize, power: u32) -> f64 {
    let powers: Vec<u32> = (0..density.dimension()).map(|i| if i == state { power } else { 0 }).collect();
    density.moment(&powers).unwrap().value
}

/// A simulation's own statistics are the same through `statistics`, value and error.
#[test]
fn a_simulation_agrees_with_itself() {
    let problem = duffing_above(-0.3, 0.8);
    let density = Simulation::new().samples(20_000).time_step(0.1).run(&problem).unwrap();
    for state in [0, 1] {
        let found = Cumulants::new(&density, state).unwrap();
        assert_eq!(Ok(found.mean), density.mean(state));
        assert_eq!(Ok(found.variance), density.variance(state));
        assert_eq!(Ok(found.skewness()), density.skewness(state));
        assert_eq!(Ok(found.kurtosis()), density.kurtosis(state));
        // The same from the raw moments, in this test's own arithmetic.
        let raw: Vec<f64> = (0..5).map(|power| mean_of_power(&density, state, power)).collect();
        let variance = raw[2] - raw[1] * raw[1];
        let third = raw[3] - 3.0 * raw[1] * raw[2] + 2.0 * raw[1].powi(3);
        let fourth = raw[4] - 4.0 * raw[1] * raw[3] + 6.0 * raw[1].powi(2) * raw[2] - 3.0 * raw[1].powi(4);
        for (found, truth) in [
            (found.variance, variance),
            (found.third, third),
            (found.fourth, fourth - 3.0 * variance * variance),
            (found.skewness(), third / variance.powf(1.5)),
            (found.kurtosis(), fourth / (variance * variance)),
        ] {
            assert!((found.value - truth).abs() < 1e-9, "{found} instead of {truth}");
        }
    }
    let impacts = Impacts::new(&density, &problem).unwrap();
    assert_eq!(
        (Some(impacts.rate()), Some(impacts.mean_speed())),
        (density.impact_rate(), density.mean_impact_speed())
    );
    let (speeds, marginal) = (density.impact_speeds().unwrap(), Marginal::new(&density, 0).unwrap());
    let same = |a: Estimate, b: Estimate| (a.value - b.value).abs() < 1e-12 && (a.error - b.error).abs() < 1e-12;
    for x in [0.0, 0.7, 1.4] {
        assert!(same(marginal.pdf(x).unwrap(), density.marginal(0, x).unwrap()));
        let [found, counted] = [impacts.speed_pdf(x).unwrap(), speeds.density_at(&[x]).unwrap()];
        assert!((found.value - counted.value).abs() < 1e-12 && found.error > 0.999 * counted.error);
    }
    let whole = marginal.distribution(-0.3).unwrap().value + marginal.exceedance(-0.3).unwrap().value;
    // Only samples outside the histogram are in neither.
    let counted = density.histogram(0).unwrap();
    let outside = counted.outliers() as f64 / counted.samples() as f64;
    assert!((whole - (1.0 - outside)).abs() < 1e-12, "{whole}, {outside}");
    // A simulation of four states has raw moments only.
    let four = Simulation::new().samples(20_000).run(&chain_of_two().problem().unwrap()).unwrap();
    assert_eq!(Ok(Cumulants::new(&four, 3).unwrap().kurtosis()), four.kurtosis(3));
}
