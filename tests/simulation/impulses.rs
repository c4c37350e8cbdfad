//! Poisson impulses in the simulation, against moments that moment equations give exactly.

use crate::common::*;
use expoly::{
    Amplitude, Density, Error, Estimate, Intensity, Oscillator, PoissonImpulses, Polynomial, Problem, Result, Scalar,
    SimulatedDensity, Simulation, Wall,
};

/// x″ + 0.2 x′ + x + μ x³ = ξ + impulses.
pub(crate) struct Struck {
    pub(crate) cubic: f64,
    pub(crate) white: Intensity,
    pub(crate) impulses: Vec<PoissonImpulses>,
}

impl Oscillator for Struck {
    fn force<S: Scalar>(&self, x: S, v: S) -> S {
        v * 0.2 + x + x.powi(3) * self.cubic
    }

    fn intensity(&self) -> Intensity {
        self.white
    }

    fn impulses(&self) -> Vec<PoissonImpulses> {
        self.impulses.clone()
    }
}

pub(crate) fn struck(cubic: f64, impulses: &[PoissonImpulses]) -> Problem {
    Problem::of(Struck { cubic, white: Intensity::NONE, impulses: impulses.to_vec() }).unwrap()
}

/// All laws, at the intensity D.
pub(crate) fn laws(rate: f64, d: f64) -> [PoissonImpulses; 6] {
    [
        Amplitude::Normal { mean: 0.0, deviation: 1.0 },
        Amplitude::Normal { mean: 0.6, deviation: 1.0 },
        Amplitude::Exponential { mean: -1.0 },
        Amplitude::Uniform { low: -0.5, high: 1.0 },
        Amplitude::TwoPoint { a: -1.0, b: 1.0 },
        Amplitude::Laplace { mean: 0.0, scale: 1.0 },
    ]
    .map(|shape| PoissonImpulses::with_intensity(rate, shape, d).unwrap())
}

fn plain(problem: &Problem, samples: usize) -> Result<SimulatedDensity> {
    Simulation::new().samples(samples).control_variates(false).seed(3).run(problem)
}

/// E v² = λE[Y²]/(2c), E v = 0 and E g(x) = λE[Y] for every spring and every law: 36 statistics by counting alone, within 4.5
/// standard errors; and the root mean square of the 24 of v is 1 as it should be, ± 0.14 by chance.
#[test]
fn every_oscillator_has_the_energy_of_its_impulses() -> Result<()> {
    let mut squares = Vec::new();
    for (cubic, rate) in [(0.0, 3.0), (0.3, 3.0)] {
        for impulses in laws(rate, 0.2) {
            let density = plain(&struck(cubic, &[impulses]), 200_000)?;
            let mean = rate * impulses.amplitude().moment(1);
            for (powers, exact) in [([0, 2], 1.0), ([0, 1], 0.0)] {
                let found = density.moment(&powers)?;
                let off = (found.value - exact) / found.error;
                println!("{cubic} {impulses:?}: {found} for {exact}, {off:+.1}");
                assert!(off.abs() < 4.5, "{impulses:?}: {found} for {exact}");
                squares.push(off * off);
            }
            let [x, cube] = [[1, 0], [3, 0]].map(|powers| density.moment(&powers).unwrap());
            let (spring, error) = (x.value + cubic * cube.value, x.error + cubic * cube.error);
            assert!((spring - mean).abs() < 4.5 * error, "{impulses:?}: {spring} ± {error} for {mean}");
            let balance = &density.energy_balance()[0];
            assert!(balance.value.abs() < 4.5 * balance.error, "{balance}");
        }
    }
    let root_mean_square = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    println!("root mean square {root_mean_square:.2}");
    assert!((0.6..1.4).contains(&root_mean_square), "{root_mean_square}");
    Ok(())
}

/// A linear oscillator's moments close degree by degree, and the generator's control variates leave no chance: what remains is
/// the time step's bias in the covariates' own means, far below the listed digits. Values by quadrature of h^i h′^j with the impulse
/// response h.
#[test]
fn a_linear_oscillator_is_calibrated_to_its_exact_moments() -> Result<()> {
    let normal =
        |rate: f64| PoissonImpulses::with_intensity(rate, Amplitude::Normal { mean: 0.0, deviation: 1.0 }, 0.2);
    let two = PoissonImpulses::with_intensity(2.0, Amplitude::TwoPoint { a: -1.0, b: 1.0 }, 0.2)?;
    let exponential = PoissonImpulses::with_intensity(2.0, Amplitude::Exponential { mean: 1.0 }, 0.2)?;
    let powers = [[2, 0], [0, 2], [4, 0], [2, 2], [0, 4]];
    let cases = [
        (normal(0.5)?, [1.0, 1.0, 3.873786408, 1.291262136, 3.908737864]),
        (normal(1.0)?, [1.0, 1.0, 3.436893204, 1.145631068, 3.454368932]),
        (normal(5.0)?, [1.0, 1.0, 3.087378641, 1.029126214, 3.090873786]),
        (two, [1.0, 1.0, 3.072815534, 1.024271845, 3.075728155]),
        (exponential, [1.4, 1.0, 6.589485796, 1.693779216, 3.454368932]),
    ];
    for (impulses, moments) in cases {
        let problem = struck(0.0, &[impulses]);
        let density = Simulation::new().samples(50_000).seed(2).run(&problem)?;
        for (powers, exact) in powers.iter().zip(moments) {
            let found = density.moment(powers)?;
            println!("{impulses:?} {powers:?}: {found}");
            assert!((found.value / exact - 1.0).abs() < 2e-8, "{powers:?}: {found} for {exact}");
        }
    }
    Ok(())
}

/// dx = −x dt + (1 + x/2) dJ: E x² = λs²/(2 − λs²/4) for amplitudes of mean zero and variance s², and one order more.
#[test]
fn impulses_that_depend_on_the_state_have_their_moments() -> Result<()> {
    let problem = Problem::from_toml(
        "states = [\"x\"]\n[drift]\nx = \"-x\"\n[impulse.a]\nrate = 3\namplitude = { normal = { mean = 0, deviation = 0.5 } }\n\
         x = \"1 + 0.5*x\"",
    )?;
    let calibrated = Simulation::new().samples(50_000).seed(1).run(&problem)?;
    let plain = plain(&problem, 400_000)?;
    // 𝓖x² = ¾ + ¾ x − (2 − 3/16) x², 𝓖x³ = −3x³ + 3 E[Y²] λ x (1 + x/2)²/… by the operator itself.
    let x = Polynomial::variable(1, 0);
    let rate = problem.operator().generator(&(&x * &x));
    let second = rate.coefficient(&[0]) / -rate.coefficient(&[2]);
    assert!((second - 0.75 / (2.0 - 0.1875)).abs() < 1e-14);
    assert!((calibrated.moment(&[2])?.value - second).abs() < 1e-9);
    for k in [1, 2, 3] {
        let [p, q] = [&plain, &calibrated].map(|density| density.moment(&[k]).unwrap());
        assert!((p.value - q.value).abs() < 4.5 * p.error.hypot(q.error), "{k}: {p} and {q}");
    }
    Ok(())
}

/// E x² is off by a bias of second order without control variates, which take it away.
#[test]
fn the_weak_order_is_two_under_impulses() -> Result<()> {
    let problem = struck(0.3, &[PoissonImpulses::new(2.0, Amplitude::Normal { mean: 0.2, deviation: 0.4 })?]);
    let square = |h: f64, calibrated: bool| {
        let simulation = Simulation::new().samples(8_000_000).sampling_interval(1.6).time_step(h).seed(1);
        simulation.control_variates(calibrated).run(&problem)?.moment(&[2, 0])
    };
    let truth = square(0.05, true)?;
    let [short, long] = [square(0.2, false)?, square(0.4, false)?]
        .map(|square| Estimate { value: square.value - truth.value, error: square.error.hypot(truth.error) });
    let slope = (long.value / short.value).log2();
    let error = (short.error / short.value).hypot(long.error / long.value) / 2.0_f64.ln();
    println!("{short} and {long}: slope {slope:.3} ± {error:.3}");
    assert!(error < 0.2 && (slope - 2.0).abs() < 0.15 + 3.0 * error, "slope {slope} ± {error}");
    Ok(())
}

/// Impulses that come while walls, levels and shorter steps interrupt the way: an elastic wall takes no energy, so that
/// E v² is as without it; a lossy one balances. Two sources add up.
#[test]
fn impulses_come_next_to_walls() -> Result<()> {
    let [first, second] = [laws(2.0, 0.1)[0], laws(1.0, 0.1)[4]];
    let free = Problem::of(Struck { cubic: 0.3, white: Intensity::new(0.1)?, impulses: vec![first, second] })?;
    for restitution in [1.0, 0.7] {
        let problem = free.clone().with_wall(Wall::above(-0.4, restitution)?)?;
        let simulation = Simulation::new().samples(200_000).levels([0.5]).control_variates(false).seed(5);
        let density = simulation.run(&problem)?;
        let balance = &density.energy_balance()[0];
        println!("{restitution}: {balance}, E v² {}", density.moment(&[0, 2])?);
        assert!(balance.value.abs() < 4.5 * balance.error, "{balance}");
        if restitution == 1.0 {
            let square = density.moment(&[0, 2])?;
            assert!((square.value - 1.5).abs() < 4.5 * square.error, "{square}");
        }
    }
    Ok(())
}

/// The same bits for one thread and more, and in two parts merged.
#[test]
fn impulses_are_the_same_for_any_number_of_threads() -> Result<()> {
    let problem = struck(0.3, &laws(2.0, 0.2)[..3]);
    let run = || Simulation::new().samples(20_000).seed(4).run(&problem);
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let [one, two] = [1, 2].map(|threads| pool(threads).install(run).unwrap());
    let bits = |density: &SimulatedDensity| {
        monomials(2, 4).iter().map(|powers| density.moment(powers).unwrap().value.to_bits()).collect::<Vec<u64>>()
    };
    assert_eq!(bits(&one), bits(&two));
    Ok(())
}

#[test]
fn impulses_without_a_meaning_are_refused() -> Result<()> {
    let often = struck(0.0, &[laws(1e3, 0.2)[0]]);
    let refused = Simulation::new().samples(1000).time_step(0.1).run(&often);
    assert!(matches!(refused, Err(Error::OutOfRange { name: "time step", .. })), "{refused:?}");
    assert!(Simulation::new().samples(1000).run(&often).is_ok());
    // So many that no method could follow them in a time that anybody would wait, and finite all the same.
    for rate in [1e7, 1e12, 1e300] {
        let problem = struck(0.3, &[laws(rate, 0.2)[0]]);
        for refused in [Simulation::new().run(&problem).err(), expoly::Closure::new(4).solve(&problem).err()] {
            let named = |name| name == "rate of the impulses";
            assert!(matches!(refused, Some(Error::OutOfRange { name, value, .. }) if named(name) && value == rate));
        }
    }
    let silent = Problem::of(Struck { cubic: 0.0, white: Intensity::NONE, impulses: Vec::new() });
    assert!(matches!(silent, Err(Error::NoDensity { .. })));
    Ok(())
}
