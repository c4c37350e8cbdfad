//! Densities at times after a start, under steady noise and under noise that rises and fades.

use crate::common::moving::{Noisy, POWERS, correlated, linear_after, moments};
use crate::common::problem;
use expoly::models::{Duffing, DuffingChain, Linear, Solved};
use expoly::{Closure, Course, Density, Envelope, Error, Estimate, Problem, Result, Simulation, Start, Wall};
use nalgebra::{DMatrix, Matrix4, matrix};

/// Deviations of independent estimates: each within four standard errors, and the root of their mean square near 1.
#[derive(Default)]
struct Deviations(Vec<f64>);

impl Deviations {
    fn add(&mut self, what: &str, found: Estimate, truth: f64) {
        println!("{what}: {found}, exact {truth}, {:.1} standard errors off", found.deviation(truth));
        assert!(found.deviation(truth) < 4.0, "{what}: {found} and {truth}");
        self.0.push(found.deviation(truth));
    }

    fn root_mean_square(&self) -> f64 {
        (self.0.iter().map(|d| d * d).sum::<f64>() / self.0.len() as f64).sqrt()
    }
}

/// Means and second moments of a linear oscillator after a normal start, by 2^16 trajectories: fifteen, with a root mean square of
/// 0.6 to 1.5 standard errors.
#[test]
fn transients_have_the_moments_of_a_linear_oscillator() -> Result<()> {
    let problem = Linear::new(0.5, 1.0, 0.5)?.problem()?;
    let trajectories = || Simulation::new().trajectories(1 << 16).seed(5);
    let mut deviations = Deviations::default();
    for found in trajectories().transient(&problem, correlated().0, &[0.01, 0.8, 7.0])? {
        assert_eq!(found.density.provenance().samples, Some(1 << 16));
        let (mean, spread) = linear_after(found.time);
        for (powers, truth) in POWERS.into_iter().zip(moments(mean, spread)) {
            deviations.add(&format!("t = {}, {powers:?}", found.time), found.moment(&powers)?, truth);
        }
    }
    assert!((0.6..1.5).contains(&deviations.root_mean_square()), "{}", deviations.root_mean_square());
    // Next to a wall every trajectory starts on its side, and the bins begin there.
    let walled = problem.with_wall(Wall::above(0.5, 0.8)?)?;
    let found = trajectories().trajectories(2000).transient(&walled, correlated().0, &[1e-6])?.remove(0);
    assert_eq!(found.density.bounds()[0][0], 0.5);
    Ok(())
}

/// Where the noise rises and fades, moments of first and second order obey equations of their own, with noise in the velocity as
/// well, whose drift in Itô's sense is modulated with it, and for a step of 0.1 too, whose bias is a tenth of the errors: 45 moments.
#[test]
fn modulated_moments_follow_their_own_equations() -> Result<()> {
    let envelopes = [
        Envelope::exponentials(1.3, 0.09, 1.49)?,
        Envelope::table([(0.0, 0.2), (1.0, 1.0), (2.5, 0.4)])?,
        Envelope::steps([(0.0, 1.0), (1.5, 0.0), (1.77, 0.3)])?,
    ];
    let (start, begin) = correlated();
    let mut deviations = Deviations::default();
    for (a, time_step) in [(0.0, None), (0.5, None), (0.5, Some(0.1))] {
        for (k, envelope) in envelopes.iter().enumerate() {
            let course = Course::from(&start).under(envelope.clone());
            let simulation = Simulation::new().trajectories(1 << 15).seed(k as u64);
            let simulation = if let Some(step) = time_step { simulation.time_step(step) } else { simulation };
            let found = simulation.transient(&problem(Noisy { a }), course, &[2.0])?.remove(0);
            for (powers, truth) in POWERS.into_iter().zip(Noisy { a }.moments(envelope, begin, 2.0)) {
                deviations.add(&format!("a = {a}, envelope {k}, {powers:?}"), found.moment(&powers)?, truth);
            }
        }
    }
    // In Itô's sense noise leaves the mean alone, whatever its envelope.
    let ito = "states = ['x', 'v']\ninterpretation = 'ito'\ndrift = { x = 'v', v = '-x - 0.5*v' }\n\
        [noise]\na.v = '1'\nb.v = '0.5*v'";
    let course = Course::from(&start).under(envelopes[0].clone());
    let simulation = Simulation::new().trajectories(1 << 15).seed(7);
    let found = simulation.transient(&Problem::from_toml(ito)?, course, &[2.0])?.remove(0);
    let (mean, _) = linear_after(2.0);
    for (powers, truth) in [([1, 0], mean[0]), ([0, 1], mean[1])] {
        deviations.add(&format!("Itô, {powers:?}"), found.moment(&powers)?, truth);
    }
    assert!((0.7..1.3).contains(&deviations.root_mean_square()), "{}", deviations.root_mean_square());
    Ok(())
}

/// Two bodies on a frame that an earthquake shakes, from rest: the covariance S of the linear chain obeys dS/dt = AS + SAᵀ + e² B.
/// Both the trajectories and the closure that they carry have its moments.
#[test]
fn a_chain_in_an_earthquake_has_the_moments_of_its_own_equations() -> Result<()> {
    let (damping, stiffness, coupling, temperature) = ([0.3, 0.2], 1.0, 0.5, 0.8);
    let chain = DuffingChain::new(&damping, stiffness, 0.0, coupling, temperature)?.problem()?;
    let envelope = Envelope::exponentials(2.32, 0.09, 1.49)?;
    let k = stiffness + coupling;
    let a =
        matrix![0.0, 1.0, 0.0, 0.0; -k, -damping[0], coupling, 0.0; 0.0, 0.0, 0.0, 1.0; coupling, 0.0, -k, -damping[1]];
    let b = |t: f64| {
        let each = damping.map(|c| 2.0 * c * temperature * envelope.value(t).powi(2));
        Matrix4::from_diagonal(&[0.0, each[0], 0.0, each[1]].into())
    };
    let truth = |time: f64| {
        let (steps, mut s) = (4000, Matrix4::zeros());
        let h = time / f64::from(steps);
        for n in 0..steps {
            let rate = |s: &Matrix4<f64>, part: f64| a * s + s * a.transpose() + b(h * (f64::from(n) + part));
            let first = rate(&s, 0.0);
            let second = rate(&(s + first * (h / 2.0)), 0.5);
            let third = rate(&(s + second * (h / 2.0)), 0.5);
            let fourth = rate(&(s + third * h), 1.0);
            s += (first + (second + third) * 2.0 + fourth) * (h / 6.0);
        }
        s
    };
    let (course, times) = (Course::from([0.0; 4]).under(envelope.clone()), [2.0, 6.0, 20.0]);
    let simulated = Simulation::new().trajectories(1 << 15).seed(2).transient(&chain, &course, &times)?;
    let closed = Closure::new(2).pilot_states(1 << 15).seed(3).transient(&chain, &course, &times)?;
    let mut deviations = Deviations::default();
    for (simulated, closed) in simulated.iter().zip(&closed) {
        let truth = truth(simulated.time);
        for (i, j) in [(0, 0), (0, 2), (1, 1), (1, 2), (2, 2), (3, 3)] {
            let mut powers = [0; 4];
            [i, j].into_iter().for_each(|state| powers[state] += 1);
            let what = format!("t = {}, {powers:?}", simulated.time);
            deviations.add(&format!("{what}, simulated"), simulated.moment(&powers)?, truth[(i, j)]);
            deviations.add(&format!("{what}, closed"), closed.moment(&powers)?, truth[(i, j)]);
        }
    }
    assert!((0.5..1.5).contains(&deviations.root_mean_square()), "{}", deviations.root_mean_square());
    Ok(())
}

/// The stationary density stays under noise as it stands, and from a start it is what is left.
#[test]
fn the_stationary_density_stays() -> Result<()> {
    let (problem, exact) = (problem(Duffing::new(0.5, 1.0, 0.3, 0.5)?), Duffing::new(0.5, 1.0, 0.3, 0.5)?.exact()?);
    let square = exact.moment(&[2, 0])?.value;
    let simulation = || Simulation::new().trajectories(1 << 14);
    let still = Course::from(Start::Stationary).under(Envelope::table([(0.0, 1.0)])?);
    for (course, times) in [(still, [0.01, 3.0]), (Course::from([1.0, 0.0]), [40.0, 50.0])] {
        for found in simulation().transient(&problem, &course, &times)? {
            let moment = found.moment(&[2, 0])?;
            assert!(moment.deviation(square) < 4.0, "t = {}: {moment} and {square}", found.time);
        }
    }
    // Half of all trajectories leave at once what is half of the density.
    let at_once = simulation().survival(&problem, [0.0, f64::INFINITY], Start::Stationary, &[0.0])?;
    assert!(at_once[0].deviation(0.5) < 4.0, "{}", at_once[0]);
    Ok(())
}

/// The seed fixes a transient on any number of threads; and other options are refused by name.
#[test]
fn transients_are_reproducible_and_refuse_what_has_no_meaning() -> Result<()> {
    let problem = problem(Duffing::new(0.5, 1.0, 0.3, 0.5)?);
    let walled = problem.clone().with_wall(Wall::above(0.5, 0.9)?)?;
    let envelope = Envelope::exponentials(1.3, 0.09, 1.49)?;
    let course = Course::from([0.6, 0.0]).under(envelope);
    let new = || Simulation::new().trajectories(1000).seed(7);
    let found = |threads: usize| -> Result<Vec<u64>> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let found = pool.install(|| new().transient(&walled, &course, &[0.5, 2.0]))?;
        let moments = found.iter().map(|found| Ok(found.moment(&[2, 0])?.value.to_bits()));
        moments.collect()
    };
    assert_eq!(found(1)?, found(2)?);
    let refused = |error: Result<Vec<expoly::Transient<expoly::SimulatedDensity>>>| error.err();
    for times in [&[0.0][..], &[f64::NAN], &[-1.0], &[1.0, 0.5], &[1.0, f64::INFINITY]] {
        let error = refused(new().transient(&problem, &course, times));
        assert!(matches!(error, Some(Error::OutOfRange { .. })), "{times:?}: {error:?}");
    }
    let behind = refused(new().transient(&walled, [0.4, 0.0], &[1.0]));
    assert!(matches!(behind, Some(Error::OutOfRange { name: "start", .. })), "{behind:?}");
    let flat = expoly::Gaussian { mean: nalgebra::dvector![0.0, 0.0], covariance: DMatrix::zeros(2, 2) };
    assert!(matches!(refused(new().transient(&problem, flat, &[1.0])), Some(Error::OutOfRange { .. })));
    assert!(matches!(refused(new().transient(&problem, [0.0], &[1.0])), Some(Error::Dimension { .. })));
    let endless = refused(new().time_step(1e-300).transient(&problem, &course, &[1.0]));
    assert!(matches!(endless, Some(Error::OutOfRange { name: "number of path-steps", .. })), "{endless:?}");
    // Impulses beyond what a step draws would be lost without a word.
    let hail = "states = ['x', 'v']\ndrift = { x = 'v', v = '-x - v' }\n[impulse.hail]\nrate = 50\namplitude = { normal = { mean = 0, deviation = 0.1 } }\nv = 1";
    let often = refused(new().time_step(1.0).transient(&Problem::from_toml(hail)?, &course, &[5.0]));
    assert!(matches!(often, Some(Error::OutOfRange { name: "time step", .. })), "{often:?}");
    let full = refused(new().trajectories(1 << 20).memory_limit(1e-3).transient(&problem, &course, &[1.0]));
    assert!(matches!(full, Some(Error::TooMuchMemory { .. })), "{full:?}");
    let cancelled = new().progress(|_| std::ops::ControlFlow::Break(())).transient(&problem, &course, &[1.0]);
    assert!(matches!(refused(cancelled), Some(Error::Cancelled { .. })));
    assert!(new().transient(&problem, &course, &[])?.is_empty());
    for within in [[1.0, 1.0], [1.0, -1.0], [f64::NAN, 1.0]] {
        let error = new().survival(&problem, within, &course, &[1.0]).err();
        assert!(matches!(error, Some(Error::OutOfRange { .. })), "{within:?}: {error:?}");
    }
    let one = Problem::from_toml("states = ['x']\ndrift.x = '-x'\nnoise.w.x = '1'")?;
    let none = new().survival(&one, [-1.0, 1.0], [0.0], &[1.0]).err();
    assert!(matches!(none, Some(Error::NotADisplacement { state: 0 })), "{none:?}");
    Ok(())
}
