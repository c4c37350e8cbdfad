//! Statistics on request, against closed forms; and the same bits however a run is made.

use crate::common::{OrnsteinUhlenbeck, threads_of};
use expoly::{
    Density, Error, Estimate, Problem, Progress, Result, SimulatedDensity, Simulation, Wall,
    models::{Duffing, DuffingChain, Linear, Solved},
};
use std::{f64::consts::PI, f64::consts::TAU, fs, ops::ControlFlow, time::Duration};

/// Values beyond four standard errors do not happen by chance: one in some thousand, with 64 batches.
const LIMIT: f64 = 4.0;

/// Within four standard errors of the truth, and with a standard error of at most `most`.
fn assert_close(what: &str, estimate: Estimate, truth: f64, most: f64) {
    println!("{what}: {estimate}, truth {truth:.6}, {:+.1}", (estimate.value - truth) / estimate.error);
    assert!(estimate.error <= most, "{what}: {estimate} is not precise to {most}");
    assert!(estimate.deviation(truth) < LIMIT, "{what}: {estimate} is not {truth}");
}

/// x″ + c x′ + k x = ξ, c = 0.5, k = 2, D = 0.3: S(ω) = (D/π)/((k − ω²)² + c²ω²), and
/// R(τ) = D/(ck) exp(−cτ/2) (cos ω_d τ + c/(2ω_d) sin ω_d τ), ω_d² = k − c²/4.
///
/// Segments last T = 102 units of time. The window adds ⅔ (π/T)² S″, which at the peak, where S″ = −31 S, makes −2 % of S, less
/// than one standard error. Frequencies above π/0.1 are folded back: 10⁻⁴ of S at 3.9, and less below.
///
/// The level a = 0.5 is crossed ν = √k/2π exp(−a²k c/2D) times per unit time. In a time t too short to come back, paths pass
/// it first with the probability P(x ≥ a) + ν t; those that begin beyond, leave and return in t are of order t³.
#[test]
fn a_linear_oscillator_has_its_spectrum_and_first_passages() -> Result<()> {
    let (c, k, d, interval, length) = (0.5, 2.0_f64, 0.3, 0.1, 1024);
    // Two lengths a trajectory, which make three segments that overlap by half.
    let simulation = Simulation::new().trajectories(512).samples(1024 * length).time_step(0.02).seed(1);
    let simulation = simulation.sampling_interval(interval).spectrum(0, length).first_passage(0.5, 1.0, 5);
    let result = simulation.run(&Problem::of(Linear::new(c, k, d)?)?)?;
    let spectrum = result.spectrum(0)?;
    for (j, omega) in spectrum.frequencies().enumerate().filter(|(j, _)| [8, 16, 22, 24, 32, 64].contains(j)) {
        let truth = d / PI / ((k - omega * omega).powi(2) + (c * omega).powi(2));
        assert_close(&format!("S({omega:.3})"), spectrum.density(j)?, truth, 0.04 * truth);
    }
    let variance = d / (c * k);
    let damped = (k - c * c / 4.0).sqrt();
    for lag in [0, 5, 11, 22, 44] {
        let tau = f64::from(lag) * interval;
        let truth =
            variance * (-c * tau / 2.0).exp() * ((damped * tau).cos() + c / (2.0 * damped) * (damped * tau).sin());
        assert_close(&format!("R({tau:.1})"), spectrum.autocovariance(lag as usize)?, truth, 0.02 * variance);
    }
    let passage = result.first_passage(0.5)?.distribution();
    let (at_once, early) = (passage[0].1, passage[1].1);
    // P(N(0, 0.3) ≥ 0.5) = erfc(0.5/√0.6)/2.
    assert_close("P(T = 0)", at_once, 0.180_655, 0.004);
    let rate = k.sqrt() / TAU * (-0.25 / (2.0 * variance)).exp();
    assert_close("P(T <= 0.2)", early, 0.180_655 + 0.2 * rate, 0.004);
    Ok(())
}

/// From the stationary state the Ornstein-Uhlenbeck process has not passed zero from below until t with probability
/// ½ · (2/π) arcsin e^(−t): half of the starts are above, and x(t) e^t is a Brownian motion in the time e^(2t) − 1. It is
/// observed continuously there and at intervals h = 0.0025 here; the missed passages shift the level by 0.5826 √(2h), as for
/// any Brownian motion (M. Broadie, P. Glasserman and S. Kou, 1997, doi:10.1111/1467-9965.00035), so that the level is put as
/// much lower. What remains is of order h.
#[test]
fn first_passages_of_zero_have_their_distribution() -> Result<()> {
    let (interval, length, windows) = (0.0025_f64, 2.0, 3);
    let samples = windows * (length / interval) as usize + windows;
    let level = -0.5826 * (2.0 * interval).sqrt();
    let simulation = Simulation::new().samples(1024 * samples).seed(2);
    let simulation = simulation.time_step(interval).sampling_interval(interval).burn_in(5.0);
    let simulation = simulation.first_passage(level, length, 4);
    let passage = simulation.run(&Problem::of(OrnsteinUhlenbeck)?)?.first_passage(level)?;
    let survival = |t: f64| (-t).exp().asin() / PI;
    for (t, estimate) in passage.distribution().into_iter().skip(1) {
        assert_close(&format!("P(T <= {t})"), estimate, 1.0 - survival(t), 0.01);
    }
    // ∫ survival dt over the window, by the midpoint rule; the root at 0 costs 10⁻⁴.
    let mean: f64 = (0..2000).map(|k| survival((f64::from(k) + 0.5) * 1e-3) * 1e-3).sum();
    assert_close("E min(T, 2)", passage.restricted_mean(), mean, 0.05 * mean);
    Ok(())
}

/// The velocity of a Duffing oscillator is normal with variance D/c = 1 and independent of the displacement: E v⁶ = 15,
/// E v⁸ = 105, E x²v⁶ = 15 E x². The time step 0.02 biases them by 10⁻⁴ or less.
///
/// Counted crossings agree with Rice's formula.
#[test]
fn a_duffing_oscillator_has_its_high_moments_and_crossings() -> Result<()> {
    let oscillator = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
    let exact = oscillator.exact()?;
    let simulation = Simulation::new().time_step(0.02).samples(1 << 20).levels([0.0, 1.0]).seed(3);
    let result = simulation.moments([[0, 6], [0, 8], [2, 6]]).run(&oscillator.problem()?)?;
    assert_close("E v^6", result.moment(&[0, 6])?, 15.0, 0.3);
    assert_close("E v^8", result.moment(&[0, 8])?, 105.0, 4.0);
    let square = exact.moment(&[2, 0])?.value;
    assert_close("E x^2 v^6", result.moment(&[2, 6])?, 15.0 * square, 0.5 * square);
    for level in [0.0, 1.0] {
        let truth = exact.upcrossing_rate(level)?.value;
        assert_close(&format!("crossings of {level}"), result.upcrossing_rate(level)?, truth, 0.005 * truth);
    }
    Ok(())
}

/// An elastic wall changes no speed, so that the density above it is the Gibbs density and impacts have the Rayleigh
/// distribution p(w) = w/s² exp(−w²/2s²), s² = D/c = 1. The reconstruction from bins of 1/8 errs by (3/640) p⁗/8⁴: 10⁻⁵ or less.
#[test]
fn impacts_on_an_elastic_wall_have_rayleigh_speeds() -> Result<()> {
    let oscillator = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?;
    let problem = oscillator.clone().with_wall(Wall::above(0.5, 1.0)?)?;
    let result = Simulation::new().bins(64).time_step(0.02).samples(1 << 19).seed(4).run(&problem)?;
    let speeds = result.impact_speeds().unwrap();
    assert_eq!((speeds.len(), speeds.outliers()), (64, 0));
    for w in [0.25, 0.5, 1.0, 2.0, 3.0] {
        let truth = w * (-w * w / 2.0_f64).exp();
        assert_close(&format!("p({w})"), speeds.density_at(&[w])?, truth, 0.03 * truth.max(0.1));
    }
    let no_wall = Simulation::new().samples(2048).run(&oscillator)?;
    assert!(no_wall.impact_speeds().is_none());
    Ok(())
}

/// Every requested number, bit for bit.
fn bits(result: &SimulatedDensity) -> Result<Vec<u64>> {
    let mut values = vec![result.moment(&[3, 4])?, result.moment(&[0, 6])?, result.upcrossing_rate(0.6)?];
    for state in [0, 1] {
        let spectrum = result.spectrum(state)?;
        for k in 0..=16 {
            values.extend([spectrum.density(k)?, spectrum.autocovariance(k)?]);
        }
    }
    for level in [0.8, 1.5] {
        let passage = result.first_passage(level)?;
        values.extend(passage.distribution().into_iter().map(|(_, p)| p));
        values.extend([passage.restricted_mean(), passage.extrapolated_mean(), result.upcrossing_rate(level)?]);
    }
    if let Some(speeds) = result.impact_speeds() {
        values.extend((0..speeds.len()).map(|k| speeds.bin(k)).collect::<Result<Vec<_>>>()?);
    }
    Ok(values.iter().flat_map(|e| [e.value.to_bits(), e.error.to_bits()]).collect())
}

/// All statistics at once, to be run above a lossy wall, with some lanes idle.
fn everything<'a>() -> Simulation<'a> {
    let simulation = Simulation::new().levels([0.6]).burn_in(5.0).seed(5);
    let simulation = simulation.trajectories(515).samples(515 * 100).sampling_interval(0.4).time_step(0.02);
    let simulation = simulation.spectrum(0, 32).spectrum(1, 48).first_passage(0.8, 4.0, 2).first_passage(1.5, 8.0, 4);
    simulation.moments([[3, 4], [0, 6]])
}

#[test]
fn all_statistics_are_the_same_however_the_run_is_made() -> Result<()> {
    let problem = Problem::of(Duffing::new(0.2, 1.0, 0.3, 0.2)?)?.with_wall(Wall::above(0.2, 0.8)?)?;
    let whole = everything().run(&problem)?;
    let (truth, total) = (bits(&whole)?, whole.provenance().path_steps.unwrap());
    for threads in [1, 2, 7] {
        let found = threads_of(threads).install(|| everything().run(&problem))?;
        assert!(bits(&found)? == truth, "{threads} threads");
    }
    let half = |part: usize| everything().part(part, 2).run(&problem);
    assert!(bits(&SimulatedDensity::merge([half(2)?, half(1)?])?)? == truth, "merged from halves");
    // Cancelled in the middle of segments and windows.
    let file = std::env::temp_dir().join(format!("expoly-statistics-{}", std::process::id()));
    for share in [0.5, 0.7, 0.9] {
        let stop = move |p: Progress| {
            if p.done as f64 >= share * total as f64 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let outcome = everything().checkpoint(&file, Duration::ZERO).progress(stop).run(&problem);
        assert!(matches!(outcome, Err(Error::Cancelled { .. })));
    }
    // Another request is another simulation.
    let other = everything().spectrum(0, 16).checkpoint(&file, Duration::ZERO).run(&problem);
    assert!(other.is_err());
    let other = everything().moments([[0, 8]]).checkpoint(&file, Duration::ZERO).run(&problem);
    assert!(matches!(other, Err(Error::NotThisRun { problem, .. }) if problem.contains("list of further statistics")));
    let resumed = everything().checkpoint(&file, Duration::ZERO).run(&problem)?;
    let read = SimulatedDensity::from_checkpoint(&file)?;
    let _ = fs::remove_file(&file);
    assert!(bits(&resumed)? == truth && bits(&read)? == truth, "resumed");
    Ok(())
}

/// States come trajectory by trajectory, and each in order of time: the samples of one, a step apart, are close to one another,
/// and the last of one is far from the first of the next.
#[test]
fn states_come_trajectory_by_trajectory() -> Result<()> {
    let problem = Problem::of(Linear::new(0.1, 1.0, 0.1)?)?;
    // 100 trajectories in batches of one or two; 1003 in batches of whole groups of lanes.
    for (trajectories, samples) in [(100, 50), (1003, 20)] {
        let simulation = Simulation::new().trajectories(trajectories).samples(trajectories * samples);
        let states = simulation.time_step(0.01).sampling_interval(0.01).burn_in(40.0).states(&problem)?;
        assert_eq!(states.len(), trajectories * samples);
        // In one step a displacement moves by 0.01 v, and |v| stays below 6 standard deviations of 1. Two trajectories differ
        // by a normal number of the variance 2, which is below 0.06 with the probability 0.034.
        let displacements: Vec<f64> = states.iter().map(|x| x[0]).collect();
        let jump = |k: &usize| (displacements[*k] - displacements[*k - 1]).abs() > 0.06;
        let jumps: Vec<usize> = (1..states.len()).filter(jump).collect();
        assert!(jumps.iter().all(|k| k % samples == 0), "a jump inside a trajectory");
        assert!(jumps.len() > trajectories * 9 / 10, "{} jumps", jumps.len());
    }
    Ok(())
}

#[test]
fn questions_without_a_meaning_are_refused() -> Result<()> {
    let problem = Problem::of(Linear::new(0.5, 1.0, 0.5)?)?;
    let small = || Simulation::new().trajectories(64).samples(640);
    let out_of_range = |simulation: Simulation<'_>| matches!(simulation.run(&problem), Err(Error::OutOfRange { .. }));
    let other_states = |simulation: Simulation<'_>| matches!(simulation.run(&problem), Err(Error::Dimension { .. }));
    assert!(out_of_range(small().spectrum(0, 7)) && out_of_range(small().spectrum(0, usize::MAX)));
    assert!(out_of_range(small().spectrum(1, 8).spectrum(1, 16)));
    assert!(other_states(small().spectrum(2, 8)) && other_states(small().moments([[1, 0, 0]])));
    assert!(out_of_range(small().first_passage(1.0, f64::NAN, 4)));
    assert!(out_of_range(small().first_passage(1.0, 4.0, 0)));
    assert!(out_of_range(small().first_passage(1.0, 4.0, 2).first_passage(1.0, 2.0, 2)));
    assert!(small().first_passage(f64::NAN, 4.0, 2).run(&problem).is_err());
    assert!(out_of_range(small().moments([[u32::MAX, 1]])) && out_of_range(small().moments([[1, 0]; 65])));
    // Too short for one segment or one window; and statistics that were not requested.
    let short = small().spectrum(0, 16).first_passage(1.0, 20.0, 4).levels([0.0]).run(&problem)?;
    assert!(matches!(short.spectrum(0), Err(Error::OutOfRange { .. })));
    assert!(matches!(short.first_passage(1.0), Err(Error::OutOfRange { .. })));
    assert!(matches!(short.spectrum(1), Err(Error::NotKnown { .. })));
    assert!(matches!(short.first_passage(0.0), Err(Error::NotKnown { .. })));
    assert!(matches!(short.moment(&[0, 6]), Err(Error::NotKnown { .. })));
    Ok(())
}

/// Two coupled linear oscillators, whose density is normal: joint densities by the quadratic through three bins along each state, of a
/// sixth of a deviation each, which is off by 1e-3 of the peak; and pairs that cannot be had.
#[test]
fn any_two_states_have_a_joint_histogram_on_request() -> Result<()> {
    let chain = DuffingChain::new(&[0.4, 0.4], 1.0, 0.0, 0.5, 0.45)?;
    let (problem, exact) = (chain.problem()?, chain.exact()?);
    let simulation = || Simulation::new().samples(400_000).seed(2);
    let found = simulation().joint([2, 0]).joint([1, 3]).run(&problem)?;
    for (pair, x) in [([0, 2], [0.0, 0.0]), ([2, 0], [0.5, 0.3]), ([1, 3], [-0.4, 0.4]), ([0, 1], [0.2, -0.3])] {
        let truth = exact.joint_marginal(pair, x)?.value;
        assert_close(&format!("p{pair:?}"), found.joint_marginal(pair, x)?, truth, 0.06 * truth);
    }
    assert_eq!(found.joint([3, 1])?.samples(), 400_384);
    assert!(matches!(found.joint_marginal([0, 3], [0.0; 2]), Err(Error::NotKnown { .. })));
    for pair in [[1, 1], [2, 0]] {
        assert!(matches!(simulation().joint([0, 2]).joint(pair).run(&problem), Err(Error::OutOfRange { .. })));
    }
    assert!(matches!(simulation().joint([0, 4]).run(&problem), Err(Error::Dimension { .. })));
    Ok(())
}
