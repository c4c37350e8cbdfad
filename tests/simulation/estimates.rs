//! The simulation against closed forms, a reference table, and itself.

use expoly::{
    Closure, Crossing, Density, Drift, Error, Estimate, Gaussian, Interpretation, Problem, Result, Scalar,
    SimulatedDensity, Simulation, Start, Wall,
    models::{Duffing, Linear},
};
use nalgebra::{DMatrix, dvector};
use support::walls::{self, Statistic};

/// Values beyond four standard errors do not happen by chance here: one test in 8000, with 64 batches.
const LIMIT: f64 = 4.0;

/// Within four standard errors of the truth, with a standard error of at most `most`.
fn assert_close(what: &str, estimate: Estimate, truth: f64, most: f64) {
    println!("{what}: {estimate}, exact {truth}, at most ± {most:.2e}");
    assert!(estimate.error <= most, "{what}: {estimate} is not precise to {most}");
    assert!(estimate.deviation(truth) < LIMIT, "{what}: {estimate} is not {truth}");
}

fn assert_relative(what: &str, estimate: Estimate, truth: f64) {
    // 0.3 %: a tenth of the error of an order-4 closure.
    assert_close(what, estimate, truth, 3e-3 * truth.abs());
}

/// dx = (1 − x) dt + σ x dW₁ + σ dW₂: two noise fields that do not commute.
struct Affine {
    sigma: f64,
    interpretation: Interpretation,
}

impl Drift<1, 2> for Affine {
    fn drift<S: Scalar>(&self, [x]: [S; 1]) -> [S; 1] {
        [-x + 1.0]
    }
    fn noise<S: Scalar>(&self, [x]: [S; 1]) -> [[S; 2]; 1] {
        [[x * self.sigma, S::from(self.sigma)]]
    }
    fn interpretation(&self) -> Interpretation {
        self.interpretation
    }
}

impl Affine {
    /// E x and E x² from the moment equations 0 = 1 − a E x, 0 = 2 E x + σ² − (2a − σ²) E x², where the Itô drift is
    /// 1 − a x.
    fn moments(&self) -> [f64; 2] {
        let square = self.sigma.powi(2);
        let a = match self.interpretation {
            Interpretation::Ito => 1.0,
            Interpretation::Stratonovich => 1.0 - square / 2.0,
        };
        [1.0 / a, (2.0 / a + square) / (2.0 * a - square)]
    }
}

/// x″ + 2αx′(1 + η) + x(1 + ζ) = ξ with D_ζ = 4α²D_η, as Stratonovich means it, or the same process written for Itô.
struct Parametric {
    alpha: f64,
    eta: f64,
    external: f64,
    interpretation: Interpretation,
}

impl Drift<2, 3> for Parametric {
    fn drift<S: Scalar>(&self, [x, v]: [S; 2]) -> [S; 2] {
        let induced = match self.interpretation {
            // ½ (2α)² 2D_η v.
            Interpretation::Ito => 4.0 * self.alpha.powi(2) * self.eta,
            Interpretation::Stratonovich => 0.0,
        };
        [v, -(v * (2.0 * self.alpha - induced)) - x]
    }
    fn noise<S: Scalar>(&self, [x, v]: [S; 2]) -> [[S; 3]; 2] {
        let damping = 2.0 * self.alpha * (2.0 * self.eta).sqrt();
        let zero = S::from(0.0);
        [[zero, zero, zero], [v * damping, x * damping, S::from((2.0 * self.external).sqrt())]]
    }
    fn interpretation(&self) -> Interpretation {
        self.interpretation
    }
}

impl Parametric {
    fn new(interpretation: Interpretation) -> Self {
        Parametric { alpha: 0.1, eta: 0.5, external: 0.2, interpretation }
    }
}

/// Damping c(1 + g x²)v and noise D(1 + g x²): the density is that of constant damping and noise.
struct Modulated {
    g: f64,
}

impl Drift<2, 2> for Modulated {
    fn drift<S: Scalar>(&self, [x, v]: [S; 2]) -> [S; 2] {
        [v, -(v * (x.powi(2) * self.g + 1.0) * 0.5) - x - x.powi(3) * 0.3]
    }
    fn noise<S: Scalar>(&self, [x, _]: [S; 2]) -> [[S; 2]; 2] {
        let zero = S::from(0.0);
        [[zero, zero], [S::from(1.0), x * self.g.sqrt()]]
    }
}

#[test]
fn linear_and_duffing_oscillators_have_their_closed_forms() -> Result<()> {
    let linear = Problem::of(Linear::new(0.5, 2.0, 0.3)?)?;
    let result = Simulation::new().samples(4_000_000).levels([0.0, 0.5]).seed(1).run(&linear)?;
    assert_relative("E v²", result.moment(&[0, 2])?, 0.6);
    assert_relative("E x²", result.moment(&[2, 0])?, 0.3);
    // Rice: ν⁺(ξ) = √(E v²/E x²)/2π · exp(−ξ²/2E x²), and E[v²; v > 0] p(ξ) = E v²/2 · p(ξ).
    let zero_rate = 2.0_f64.sqrt() / std::f64::consts::TAU;
    let fall = (-0.25_f64 / 0.6).exp();
    assert_relative("ν⁺(0)", result.upcrossing_rate(0.0)?, zero_rate);
    assert_relative("ν⁺(½)", result.upcrossing_rate(0.5)?, zero_rate * fall);
    let density = fall / (std::f64::consts::TAU * 0.3).sqrt();
    assert_relative("second flux", result.flux(Crossing::upward(0.5), 2)?, 0.3 * density);
    assert_close("energy balance", result.energy_balance()[0], 0.0, 3e-3);

    let duffing = Problem::of(Duffing::new(0.5, 1.0, 0.3, 0.5)?)?;
    let result = Simulation::new().samples(4_000_000).seed(2).run(&duffing)?;
    assert_relative("E x²", result.moment(&[2, 0])?, 0.661714969204);
    assert_relative("E x⁴", result.moment(&[4, 0])?, 1.12761676932);
    assert_relative("E v²", result.moment(&[0, 2])?, 1.0);
    assert_relative("kurtosis of v", result.kurtosis(1)?, 3.0);
    // Bins of a tenth of the scale: the reconstruction is exact to third order, far below the noise.
    let peak = result.marginal(0, 0.0)?;
    assert_close("p_x(0)", peak, 0.453248327025, 3e-3);
    let joint = 0.453248327025 / std::f64::consts::TAU.sqrt();
    assert_close("p(0, 0)", result.pdf(&[0.0, 0.0])?, joint, 3e-3);
    assert!(result.stationarity().iter().all(|z| z.abs() < LIMIT));
    Ok(())
}

#[test]
fn parametric_noise_has_its_closed_forms_and_both_interpretations_agree() -> Result<()> {
    let stratonovich = Problem::of(Parametric::new(Interpretation::Stratonovich))?;
    let ito = Problem::of(Parametric::new(Interpretation::Ito))?;
    let (s, i) = (stratonovich.operator(), ito.operator());
    for x in [[0.3, 0.7], [-1.0_f64, 2.0]] {
        // The same operator, up to the rounding of 2α − 4α²D_η.
        let difference: f64 = s.drift()[1].evaluate(&x) - i.drift()[1].evaluate(&x);
        assert!(difference.abs() < 1e-14);
    }
    // One process under the same noise: its paths are the same up to rounding, and with them every sum.
    // Without control variates, with which E xv is zero but for rounding.
    let simulation = || Simulation::new().samples(50_000).time_step(0.04).seed(5).control_variates(false);
    let paths = |problem: &Problem| simulation().run(problem);
    let (s, i) = (paths(&stratonovich)?, paths(&ito)?);
    for powers in [[2, 0], [0, 2], [1, 1], [4, 0], [2, 2], [0, 4]] {
        let [s, i] = [s.moment(&powers)?.value, i.moment(&powers)?.value];
        println!("{powers:?}: {s} and {i}, {:.1e} apart", i / s - 1.0);
        assert!((i / s - 1.0).abs() < 1e-9, "{powers:?}: {s} and {i}");
    }
    // The step's bias of 0.1 % is half a standard error.
    let s = Simulation::new().samples(2_000_000).sampling_interval(4.0).time_step(0.05).seed(5).run(&stratonovich)?;
    for powers in [[2, 0], [0, 2]] {
        // C(κ + v² + x²)^−δ with κ = 10, δ = 5.5: E v² = E x² = κ/(2δ − 4).
        assert_relative("second moment", s.moment(&powers)?, 10.0 / 7.0);
    }
    // E (x² + v²)² = 2κ²/((δ − 2)(δ − 3)); a heavy tail, so that 3 % is what the samples give.
    let radial = |r: &SimulatedDensity| -> Result<f64> {
        Ok(r.moment(&[4, 0])?.value + r.moment(&[0, 4])?.value + 2.0 * r.moment(&[2, 2])?.value)
    };
    let truth = 200.0 / (3.5 * 2.5);
    assert!((radial(&s)? / truth - 1.0).abs() < 0.03);
    Ok(())
}

#[test]
fn noise_that_depends_on_the_displacement_leaves_the_duffing_density() -> Result<()> {
    // The bias of this step, 0.4 h², is 0.1 %: below the standard errors of 0.13 % and more.
    let simulation = Simulation::new().samples(1_800_000).time_step(0.05).seed(3);
    let result = simulation.run(&Problem::of(Modulated { g: 0.8 })?)?;
    assert_relative("E x²", result.moment(&[2, 0])?, 0.661714969204);
    assert_relative("E x⁴", result.moment(&[4, 0])?, 1.12761676932);
    assert_relative("E v²", result.moment(&[0, 2])?, 1.0);
    Ok(())
}

#[test]
fn walls_match_the_reference() -> Result<()> {
    let (mut squares, mut balances) = (Vec::new(), Vec::new());
    for (seed, row) in (0..).zip(walls::table().unwrap()) {
        let (b, r) = (row.b, row.r);
        let result = Simulation::new().samples(400_000).seed(seed).run(&row.problem()?)?;
        for statistic in row.beside(&result)? {
            let Statistic { name, truth, scale, found } = statistic;
            let deviation = statistic.deviation();
            println!("{name} for b = {b}, r = {r}: {found}, reference {truth}, {deviation:.1} standard errors");
            // Rates come out at 0.06 to 0.13 %, moments at 0.07 % and less.
            let precise = if name == "rate" { 2e-3 } else { 1e-3 };
            assert!(found.error <= precise * scale, "{name} for b = {b}, r = {r}: {found} is not precise enough");
            assert!(deviation.abs() < 4.0, "{name} for b = {b}, r = {r}: {found}, not {truth}");
            squares.push(deviation * deviation);
        }
        // Not calibrated: it would be zero.
        let balance = result.energy_balance()[0];
        assert_close(&format!("energy balance for b = {b}, r = {r}"), balance, 0.0, 8e-3);
        balances.push(balance);
        assert_eq!(result.pdf(&[b - 0.1, 0.3])?.value, 0.0);
        assert_eq!(result.histogram(0)?.edges(0).next(), Some(b));
    }
    // A bias of one standard error in all would make the root mean square 1.4; chance gives 1 ± 0.06 for 120 statistics,
    // somewhat more because those of a row are correlated.
    assert_eq!(squares.len(), 6 * 20);
    // Of all walls together, whose runs are independent: to a thousandth of the power that the noise brings.
    let count = balances.len() as f64;
    let balance = balances.iter().map(|balance| balance.value).sum::<f64>() / count;
    let error = balances.iter().map(|balance| balance.error.powi(2)).sum::<f64>().sqrt() / count;
    assert_close("energy balance of all", Estimate::new(balance, error), 0.0, 1.5e-3);
    let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    println!("root mean square {rms}");
    assert!((0.8..1.25).contains(&rms), "the deviations have the root mean square {rms}");
    Ok(())
}

#[test]
fn fields_that_do_not_commute_have_their_moments() -> Result<()> {
    for interpretation in [Interpretation::Ito, Interpretation::Stratonovich] {
        let system = Affine { sigma: 0.5, interpretation };
        let [mean, square] = system.moments();
        let result = Simulation::new().samples(2_000_000).time_step(0.05).seed(9).run(&Problem::of(system)?)?;
        assert_relative("E x", result.mean(0)?, mean);
        assert_relative("E x²", result.moment(&[2])?, square);
        assert!(result.joint([0, 1]).is_err() && result.pdf(&[1.0])?.value > 0.0);
    }
    Ok(())
}

#[test]
fn standard_errors_cover() -> Result<()> {
    // Twenty seeds with five statistics of known value, of which x² and x⁴ are strongly correlated: about 70 independent
    // ones. Their root mean square is 1 ± 1/√140 = 1 ± 0.085 where standard errors are right, which 0.8 and 1.25 enclose by
    // more than two deviations. Samples one time unit apart are strongly correlated here: errors that took them for
    // independent would be half as large. Without control variates, since E v² and E xv are exact with them.
    let problem = Problem::of(Duffing::new(0.5, 1.0, 0.3, 0.5)?)?;
    let mut squares = Vec::new();
    for seed in 0..20 {
        let result = Simulation::new().samples(100_000).seed(seed).control_variates(false).run(&problem)?;
        squares.extend([
            result.moment(&[2, 0])?.deviation(0.661714969204),
            result.moment(&[0, 2])?.deviation(1.0),
            result.moment(&[1, 1])?.deviation(0.0),
            result.mean(0)?.deviation(0.0),
            result.skewness(1)?.deviation(0.0),
        ]);
    }
    let rms = (squares.iter().map(|z| z * z).sum::<f64>() / squares.len() as f64).sqrt();
    assert!((0.8..1.25).contains(&rms), "deviation over standard error has the root mean square {rms}");
    Ok(())
}

/// A system of three states: a linear oscillator driven by filtered noise, with the filter as the last state.
struct Filtered;

impl Drift<3, 1> for Filtered {
    fn drift<S: Scalar>(&self, [x, v, z]: [S; 3]) -> [S; 3] {
        [v, -v - x + z, -z]
    }
    fn noise<S: Scalar>(&self, _: [S; 3]) -> [[S; 1]; 3] {
        [[S::from(0.0)], [S::from(0.0)], [S::from(2.0_f64.sqrt())]]
    }
}

#[test]
fn three_states_have_moments_and_marginals_but_no_joint_density() -> Result<()> {
    let result = Simulation::new().samples(2_000_000).seed(4).run(&Problem::of(Filtered)?)?;
    // From the moment equations of second order, with E z² = 1: E xz = E vz = 1/3, E v² = 1/3, E x² = 2/3.
    for (powers, truth) in [([0, 0, 2], 1.0), ([1, 0, 1], 1.0 / 3.0), ([0, 2, 0], 1.0 / 3.0), ([2, 0, 0], 2.0 / 3.0)] {
        assert_relative("second moment", result.moment(&powers)?, truth);
    }
    assert!(matches!(result.pdf(&[0.0; 3]), Err(Error::NotKnown { .. })));
    assert!(matches!(result.moment(&[5, 0, 0]), Err(Error::NotKnown { .. })));
    assert_close("p_z(0)", result.marginal(2, 0.0)?, std::f64::consts::TAU.sqrt().recip(), 3e-3);
    assert!(matches!(result.marginal(3, 0.0), Err(Error::Dimension { expected: 3, found: 3, .. })));
    Ok(())
}

#[test]
fn fluxes_that_were_not_counted_are_refused() -> Result<()> {
    let problem = Problem::of(Linear::new(0.2, 1.0, 0.2)?)?.with_wall(Wall::above(0.0, 0.5)?)?;
    let result = Simulation::new().samples(10_000).levels([0.3]).burn_in(5.0).run(&problem)?;
    let impacts = result.flux(Crossing::downward(0.0), 2)?;
    assert_eq!(result.flux(Crossing::upward(0.0), 2)?, impacts.scaled(0.5));
    assert!(result.flux(Crossing::upward(0.3), 1)?.value > 0.0);
    // A level is known by nearness, however it was computed.
    assert_eq!(result.upcrossing_rate(0.1 + 0.2), result.upcrossing_rate(0.3));
    let unknown = |crossing: Crossing| matches!(result.flux(crossing, 1), Err(Error::NotKnown { .. }));
    assert!(unknown(Crossing::upward(0.4)) && unknown(Crossing::downward(0.3)));
    assert!(matches!(result.flux(Crossing::downward(0.0), 4), Err(Error::OutOfRange { .. })));
    let sideways = Crossing { displacement: 1, velocity: 0, level: 0.0, upward: true };
    assert_eq!(result.flux(sideways, 1), Err(Error::NotADisplacement { state: 1 }));
    Ok(())
}

#[test]
fn impossible_options_are_refused() -> Result<()> {
    let free = Problem::of(Duffing::new(0.2, 1.0, 0.3, 0.2)?)?;
    let walled = free.clone().with_wall(Wall::above(0.5, 0.9)?)?;
    let new = || Simulation::new().samples(100);
    for simulation in [
        new().time_step(0.0),
        new().time_step(-0.1),
        new().time_step(f64::NAN),
        new().time_step(1e-300),
        new().burn_in(-1.0),
        new().burn_in(f64::INFINITY),
        new().sampling_interval(0.0),
        new().sampling_interval(f64::NAN),
        new().levels([f64::NAN]),
        new().levels((0..65).map(f64::from)),
        new().start([f64::NAN, 0.0]),
        new().start(Gaussian { mean: dvector![0.0, 0.0], covariance: DMatrix::zeros(2, 2) }),
        new().bins(2),
        new().bins(usize::MAX),
        new().trajectories(usize::MAX),
    ] {
        let text = format!("{simulation:?}");
        assert!(matches!(simulation.run(&free), Err(Error::OutOfRange { .. })), "{text}");
    }
    assert!(matches!(new().start([0.4, 0.0]).run(&walled), Err(Error::OutOfRange { .. })));
    assert!(matches!(new().start([0.4]).run(&free), Err(Error::Dimension { expected: 2, found: 1, .. })));
    assert!(matches!(new().samples(0).run(&free), Err(Error::OutOfRange { .. })));
    assert!(matches!(new().trajectories(0).run(&free), Err(Error::OutOfRange { .. })));
    assert!(matches!(new().trajectories(1).run(&free), Err(Error::OutOfRange { .. })));
    assert!(new().trajectories(2).burn_in(0.0).run(&free).is_ok());
    let behind = new().start([1.1, 0.0]).run(&walled.with_wall(Wall::below(1.0, 0.9)?)?);
    assert!(matches!(behind, Err(Error::OutOfRange { name: "start", .. })));
    let density = Start::Density(std::sync::Arc::new(Closure::new(2).solve(&free)?));
    assert!(matches!(new().start(density).run(&free), Err(Error::NotServed { method: "simulation", .. })));
    Ok(())
}

/// A single state, which no wall can stop.
struct Diffusion {
    pull: f64,
    sigma: f64,
}

impl Drift<1, 1> for Diffusion {
    fn drift<S: Scalar>(&self, [x]: [S; 1]) -> [S; 1] {
        [-x.powi(3) * self.pull]
    }
    fn noise<S: Scalar>(&self, _: [S; 1]) -> [[S; 1]; 1] {
        [[S::from(self.sigma)]]
    }
}

#[test]
fn impossible_systems_are_refused() -> Result<()> {
    assert!(matches!(Problem::of(Diffusion { pull: 1.0, sigma: 0.0 }), Err(Error::NoDensity { .. })));
    let broken = Problem::of(Diffusion { pull: f64::NAN, sigma: 1.0 });
    assert!(matches!(broken, Err(Error::NotFinite { state: 0, .. })));
    let diffusion = Problem::of(Diffusion { pull: 1.0, sigma: 1.0 })?;
    let walled = diffusion.clone().with_wall(Wall::above(0.0, 0.9)?);
    assert!(matches!(walled, Err(Error::NotADisplacement { state: 0 })));
    assert!(matches!(Simulation::new().levels([0.0]).run(&diffusion), Err(Error::NotADisplacement { .. })));
    assert!(Simulation::new().samples(1000).run(&diffusion)?.energy_balance().is_empty());
    Ok(())
}

#[test]
fn explosions_name_the_trajectory() -> Result<()> {
    // At once, by the cubic drift; and slowly, by negative damping, where states grow a million times beyond the pilot's.
    let escaping = Problem::of(Diffusion { pull: -1.0, sigma: 1.0 })?;
    let Err(error @ Error::Exploded { trajectory, pilot: true, step, .. }) =
        &Simulation::new().time_step(0.02).run(&escaping)
    else {
        unreachable!("x³ pushes every trajectory out, the pilot's first")
    };
    assert!(*trajectory < 64 && *step == 0.02 && error.to_string().contains(" of the pilot exploded"), "{error}");
    let growing = Problem::of(Linear::new(-0.1, 1.0, 0.2)?)?;
    let found = Simulation::new().burn_in(1.0).run(&growing);
    assert!(matches!(found, Err(Error::Exploded { state, .. }) if state.len() == 2));
    Ok(())
}
