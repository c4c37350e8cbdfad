//! Moments by control variates: the truth with small and right errors, the same bits however a run is made, and warnings
//! where a run was not stationary.

use crate::common::threads_of;
use expoly::{
    Crossing, Density, Error, Estimate, ExpPolynomial, Problem, Result, SimulatedDensity, Simulation, Wall,
    models::{Duffing, DuffingChain, Linear, Solved, VanDerPolRayleigh},
};
use std::{ops::ControlFlow, time::Duration};

/// Second and fourth moments of every state.
fn powers(states: usize) -> impl Iterator<Item = Vec<u32>> {
    let of =
        move |power| (0..states).map(move |state| (0..states).map(|i| if i == state { power } else { 0 }).collect());
    of(2).chain(of(4))
}

fn solved(model: impl Solved) -> Result<(Problem, ExpPolynomial)> {
    Ok((model.problem()?, model.exact()?))
}

/// Systems of known density: normal, of one well, of two, of a limit cycle, and of four states.
fn systems() -> Result<Vec<(Problem, ExpPolynomial)>> {
    Ok(vec![
        solved(Linear::new(0.5, 2.0, 0.3)?)?,
        solved(Duffing::new(0.5, 1.0, 0.3, 0.5)?)?,
        solved(Duffing::new(1.0, -1.0, 1.0, 0.3)?)?,
        solved(VanDerPolRayleigh::new(1.0, 0.15)?)?,
        solved(DuffingChain::new(&[0.2, 0.4], 1.0, 0.3, 0.5, 0.8)?)?,
    ])
}

#[test]
fn known_moments_are_hit_with_much_smaller_errors() -> Result<()> {
    for (problem, exact) in systems()? {
        let run = |calibrated| Simulation::new().samples(200_000).seed(3).control_variates(calibrated).run(&problem);
        let (plain, calibrated) = (run(false)?, run(true)?);
        let degree = calibrated.provenance().calibration_degree;
        assert!(degree >= Some(4) && plain.provenance().calibration_degree.is_none());
        assert!(calibrated.provenance().warning.is_none() && plain.provenance().warning.is_none());
        // Weights come out at 1 ± 0.03 to 0.1.
        assert!(calibrated.provenance().weight_deviation.is_some_and(|deviation| deviation < 0.2));
        let mut least = f64::INFINITY;
        for powers in powers(problem.dimension()) {
            let (found, truth) = (calibrated.moment(&powers)?, exact.moment(&powers)?.value);
            let gain = plain.moment(&powers)?.error / found.error;
            println!("{powers:?}: {found}, exact {truth}, gain {gain:.1}, {degree:?}");
            assert!(found.deviation(truth) < 4.0, "{powers:?}: {found} is not {truth}");
            least = least.min(gain);
        }
        // Fourth moments of wells and chain gain least, about 4; all others 8 and more.
        assert!(least > 3.0, "{least}");
        for state in 0..problem.dimension() {
            let (variance, kurtosis) = (calibrated.variance(state)?, calibrated.kurtosis(state)?);
            let gains = [plain.variance(state)?.error / variance.error, plain.kurtosis(state)?.error / kurtosis.error];
            println!("variance {variance}, kurtosis {kurtosis}, gains {gains:.1?}");
            assert!(variance.deviation(exact.variance(state)?.value) < 4.0);
            assert!(gains.iter().all(|gain| *gain > 1.5), "{gains:?}");
        }
    }
    Ok(())
}

#[test]
fn small_errors_are_honest() -> Result<()> {
    // Sixteen seeds of three systems with two or more statistics each; those of one run are correlated, which leaves about 80
    // independent ones: the root mean square is 1 ± 0.08. `expoly-measure calibration` takes 60 seeds and four systems.
    let mut squares = Vec::new();
    for (problem, exact) in systems()?.into_iter().skip(2) {
        // E v² = D/c without a coupling to anything is exact, without chance.
        let chance: Vec<_> = powers(problem.dimension()).filter(|p| problem.dimension() > 2 || p[1] != 2).collect();
        for seed in 0..16 {
            let result = Simulation::new().samples(50_000).seed(100 + seed).run(&problem)?;
            for powers in &chance {
                squares.push(result.moment(powers)?.deviation(exact.moment(powers)?.value).powi(2));
            }
        }
    }
    let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    println!("{} deviations, root mean square {rms}", squares.len());
    assert!((0.8..1.2).contains(&rms), "deviation over standard error has the root mean square {rms}");
    Ok(())
}

/// Steps eight times as long as the library's choice: 0.4 h² = 1.6 % too much in E v², 3.2 % in E v⁴.
#[test]
fn the_bias_of_the_time_step_goes() -> Result<()> {
    let (problem, exact) = solved(Duffing::new(0.5, 1.0, 0.3, 0.5)?)?;
    let run = |calibrated| {
        Simulation::new().samples(1_000_000).time_step(0.2).seed(1).control_variates(calibrated).run(&problem)
    };
    let (plain, calibrated) = (run(false)?, run(true)?);
    for powers in powers(2) {
        let truth = exact.moment(&powers)?.value;
        let (plain, found) = (plain.moment(&powers)?, calibrated.moment(&powers)?);
        println!("{powers:?}: {plain}, calibrated {found}, exact {truth}");
        if powers[1] > 0 {
            assert!(plain.deviation(truth) > 4.0, "{powers:?}: {plain}");
        }
        // Errors come out below 2e-4.
        assert!(found.deviation(truth) < 4.0 && found.error < 5e-4 * truth, "{powers:?}: {found}");
    }
    Ok(())
}

fn bits(result: &SimulatedDensity) -> Result<Vec<u64>> {
    let moments = (0..4).flat_map(|i| (0..4 - i).map(move |j| [i, j])).map(|powers| result.moment(&powers));
    let others = [result.variance(0)?, result.kurtosis(1)?, Estimate::new(result.marginal(0, 0.3)?.value, 0.0)];
    let moments: Vec<Estimate> = moments.collect::<Result<_>>()?;
    assert!(result.provenance().calibration_degree >= Some(4));
    Ok(moments
        .iter()
        .chain(&others)
        .chain(&result.impact_rate())
        .flat_map(|e| [e.value.to_bits(), e.error.to_bits()])
        .collect())
}

#[test]
fn bits_depend_on_nothing_but_the_numbers_asked_for() -> Result<()> {
    let problem = Problem::of(Duffing::new(0.5, 1.0, 0.3, 0.5)?)?;
    same_bits_however_it_is_run(&problem)?;
    same_bits_however_it_is_run(&problem.with_wall(Wall::above(-0.3, 0.8)?)?)
}

fn same_bits_however_it_is_run(problem: &Problem) -> Result<()> {
    let simulation = || Simulation::new().samples(40_000).burn_in(20.0).seed(7);
    let whole = simulation().run(problem)?;
    let expected = bits(&whole)?;
    for threads in [1, 3] {
        assert_eq!(bits(&threads_of(threads).install(|| simulation().run(problem))?)?, expected);
    }
    let parts = [3, 1, 2].map(|k| simulation().part(k, 3).run(problem));
    let merged = SimulatedDensity::merge(parts.into_iter().collect::<Result<Vec<_>>>()?)?;
    assert_eq!(bits(&merged)?, expected);
    // Interrupted again and again, and then read from the file alone.
    let file = std::env::temp_dir().join(format!("expoly-calibration-{}", std::process::id()));
    let kept = || simulation().checkpoint(&file, Duration::ZERO);
    let mut rounds = 0;
    let resumed = loop {
        let mut reports = 0;
        let stop = |_| {
            reports += 1;
            // The pilot makes 256 of them.
            if reports > 320 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        match kept().progress(stop).run(problem) {
            Err(Error::Cancelled { .. }) if rounds < 200 => rounds += 1,
            outcome => break outcome,
        }
    };
    let stored = SimulatedDensity::from_checkpoint(&file);
    let _ = std::fs::remove_file(&file);
    assert_eq!(bits(&resumed?)?, expected);
    assert_eq!(bits(&stored?)?, expected);
    assert!(rounds > 0, "it was never interrupted");
    Ok(())
}

#[test]
fn short_runs_are_plain() -> Result<()> {
    let problem = Problem::of(Duffing::new(0.5, 1.0, 0.3, 0.5)?)?;
    let short = Simulation::new().trajectories(4).samples(100).run(&problem)?;
    assert_eq!((short.provenance().calibration_degree, short.provenance().weight_deviation), (None, None));
    Ok(())
}

/// Above an elastic wall the density is known. There impacts turn the velocity alone, so that only functions odd in it jump;
/// above a lossy wall all of it does, and E\[𝓖ψ\] without the jumps would be as far from zero as impacts take energy.
#[test]
fn impacts_are_calibrated_with_the_rest() -> Result<()> {
    let duffing = Duffing::new(0.2, 1.0, 0.3, 0.2)?;
    for (offset, restitution) in [(0.3, 1.0), (-0.5, 1.0), (0.0, 0.9), (0.5, 0.5)] {
        let problem = duffing.problem()?.with_wall(Wall::above(offset, restitution)?)?;
        let level = offset + 0.7;
        let run = |calibrated| {
            Simulation::new().samples(250_000).levels([level]).seed(5).control_variates(calibrated).run(&problem)
        };
        let (plain, calibrated) = (run(false)?, run(true)?);
        assert_eq!(calibrated.provenance().calibration_degree, Some(6));
        assert!(calibrated.provenance().warning.is_none());
        let exact = if restitution == 1.0 { Some(duffing.exact_above(offset)?) } else { None };
        let approach = Crossing { upward: false, ..Crossing::upward(offset) };
        type Answer<'a> = &'a dyn Fn(&dyn Density) -> Result<Estimate>;
        // For each the least gain; those measured are 1.2 to 2.8 times as large.
        let answers: [(&str, f64, Answer<'_>); 6] = [
            ("E y", 4.0, &|d| d.moment(&[1, 0])),
            ("E y^2", 10.0, &|d| d.moment(&[2, 0])),
            ("E v^4", 30.0, &|d| d.moment(&[0, 4])),
            ("impact rate", 1.1, &|d| d.flux(approach, 1)),
            ("E |v|^3 at the wall", 15.0, &|d| d.flux(approach, 3)),
            ("up-crossing rate", 1.1, &|d| d.upcrossing_rate(level)),
        ];
        for (what, least, answer) in answers {
            let (plain, found) = (answer(&plain)?, answer(&calibrated)?);
            let gain = plain.error / found.error;
            println!("({offset}, {restitution}) {what}: {found}, plain {plain}, gain {gain:.1}");
            assert!(gain > least, "{what}: gain {gain} above ({offset}, {restitution})");
            assert!((found.value - plain.value).abs() < 4.0 * plain.error.hypot(found.error), "{found} and {plain}");
            if let Some(exact) = &exact {
                assert!(found.deviation(answer(exact)?.value) < 4.0, "{what}: {found}");
            }
        }
        // E v = 0, and E y v = 0: 𝓖y and 𝓖y²/2, which no impact changes.
        for powers in [[0, 1], [1, 1]] {
            assert!(calibrated.moment(&powers)?.value.abs() < 1e-9);
        }
    }
    Ok(())
}

/// dx = −x dt + b x dW₁ + dW₂, whose density falls as |x|^−(2 + 2/b²): E x^m exists while (m − 1) b² < 2. Where E x⁴ does not,
/// degree 4 is left out and named, and the mean square is still right.
#[test]
fn moments_that_do_not_exist_calibrate_nothing() -> Result<()> {
    for square in [0.2_f64, 0.5, 0.8, 1.2] {
        let b = square.sqrt();
        let text = format!("states = [\"x\"]\n[drift]\nx = \"-x\"\n[noise.a]\nx = \"{b} * x\"\n[noise.b]\nx = 1");
        let density = Simulation::new().samples(100_000).run(&Problem::from_toml(&text)?)?;
        let (second, fourth) = (density.moment(&[2])?, density.moment(&[4])?);
        let warning = density.provenance().warning.clone().unwrap_or_default();
        println!("{square}: {second}, {fourth}, {:?}, {warning}", density.provenance().calibration_degree);
        // E 𝓖x² = 0 is the mean square itself.
        assert!(second.deviation(1.0 / (2.0 - square)) < 4.0, "{square}: {second}");
        if 3.0 * square < 2.0 {
            let exact = 6.0 / ((2.0 - square) * (4.0 - 6.0 * square));
            assert!(fourth.deviation(exact) < 4.0, "{square}: {fourth} is not {exact}");
            // E x⁶ exists for the first alone.
            assert!(warning.is_empty() || square > 0.4 && warning.contains("degree 6"), "{square}: {warning}");
        } else {
            assert_eq!(density.provenance().calibration_degree, Some(2));
            assert!(warning.contains("moment equations of degree 4"), "{square}: {warning}");
            // That of the samples, with what the equations would change, to a negative number, as its error.
            assert!(fourth.value > 0.0 && fourth.error > fourth.value, "{square}: {fourth}");
        }
    }
    Ok(())
}

/// Damping below zero: energy grows and no density is stationary, above a wall that takes too little energy as well. With any
/// number of samples, the answer has a warning or there is none.
#[test]
fn what_is_not_stationary_warns() -> Result<()> {
    for damping in [-0.3, -0.1, -0.02] {
        let linear = Problem::of(Linear::new(damping, 1.0, 0.2)?)?;
        let walled = Problem::of(Duffing::new(damping, 1.0, 0.3, 0.2)?)?.with_wall(Wall::above(-0.5, 1.0)?)?;
        for problem in [linear, walled] {
            for samples in [1000, 3000, 50_000] {
                let warned = match Simulation::new().samples(samples).run(&problem) {
                    Ok(result) => {
                        println!(
                            "{damping} {samples} {:?} {:?}",
                            result.stationarity(),
                            result.provenance().weight_deviation
                        );
                        result.provenance().warning.is_some()
                    }
                    Err(error) => matches!(error, Error::Exploded { .. }),
                };
                assert!(warned, "damping {damping}, {samples} samples");
            }
        }
    }
    Ok(())
}
