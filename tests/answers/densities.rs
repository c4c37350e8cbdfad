//! Statistics of any density: closed forms, draws, three methods beside each other, and arguments without a meaning.
//!
//! The exact values are sums of this file's own: Boole's rule along the displacement and the trapezoidal rule along the
//! velocity over exp of the model's formula, where the library uses Gauss rules on panels.

use crate::common::*;
use expoly::models::{Linear, Solved};
use expoly::statistics::{Crossings, Cumulants, Impacts, Marginal, energy_balance, entropy, modes, samples};
use expoly::{Closure, Density, Error, Estimate, Problem, Simulation, States, Wall, compare};
use std::f64::consts::{E, PI, TAU};

/// exp of a formula on a lattice, normalised.
struct Truth<'a> {
    log: &'a dyn Fn(f64, f64) -> f64,
    low: f64,
    step: f64,
    /// The marginal at low + k step.
    marginal: Vec<f64>,
    mass: f64,
    fastest: f64,
}

/// Intervals along the displacement, a multiple of four, and along the velocity.
const ALONG: usize = 4800;
const ACROSS: usize = 240;

/// Boole's rule, whose error is of sixth order, for values at equal steps.
fn boole(step: f64, nodes: std::ops::RangeInclusive<usize>, f: impl Fn(usize) -> f64) -> f64 {
    let (first, last) = (*nodes.start(), *nodes.end());
    assert_eq!((last - first) % 4, 0);
    let weight = |k: usize| match (k - first) % 4 {
        0 if k == first || k == last => 7.0,
        0 => 14.0,
        2 => 12.0,
        _ => 32.0,
    };
    nodes.map(|k| 2.0 * step / 45.0 * weight(k) * f(k)).sum()
}

impl<'a> Truth<'a> {
    fn new(log: &'a dyn Fn(f64, f64) -> f64, [low, high]: [f64; 2], fastest: f64) -> Self {
        let step = (high - low) / ALONG as f64;
        let mut truth = Truth { log, low, step, marginal: Vec::new(), mass: 1.0, fastest };
        truth.marginal = (0..=ALONG).map(|k| truth.over_velocity(truth.at(k), |_, p| p)).collect();
        truth.mass = truth.integral(0, |_, p| p);
        truth.marginal.iter_mut().for_each(|p| *p /= truth.mass);
        truth
    }

    fn at(&self, k: usize) -> f64 {
        self.low + self.step * k as f64
    }

    /// The trapezoidal rule, which for a function that falls to rounding on both sides converges geometrically.
    fn over_velocity(&self, x: f64, g: impl Fn(f64, f64) -> f64) -> f64 {
        let h = 2.0 * self.fastest / ACROSS as f64;
        let v = |k: usize| h * k as f64 - self.fastest;
        (0..=ACROSS).map(|k| h * g(v(k), (self.log)(x, v(k)).exp() / self.mass)).sum()
    }

    /// The integral from node `from` on.
    fn integral(&self, from: usize, g: impl Fn(f64, f64) -> f64) -> f64 {
        boole(self.step, from..=ALONG, |k| g(self.at(k), self.marginal[k]))
    }

    /// P(X > x), with nodes of its own.
    fn tail(&self, x: f64) -> f64 {
        let step = (self.at(ALONG) - x) / (ALONG / 4) as f64;
        boole(step, 0..=ALONG / 4, |k| self.over_velocity(x + step * k as f64, |_, p| p))
    }

    /// P(X ≤ x), likewise.
    fn below(&self, x: f64) -> f64 {
        let step = (x - self.low) / (ALONG / 4) as f64;
        boole(step, 0..=ALONG / 4, |k| self.over_velocity(self.low + step * k as f64, |_, p| p))
    }

    /// ν⁺, by Boole's rule over v ≥ 0: v p is not even.
    fn rate(&self, x: f64) -> f64 {
        let step = self.fastest / ALONG as f64;
        boole(step, 0..=ALONG, |k| step * k as f64 * (self.log)(x, step * k as f64).exp() / self.mass)
    }

    fn central(&self, mean: f64, power: i32) -> f64 {
        self.integral(0, |x, p| p * (x - mean).powi(power))
    }

    fn entropy(&self) -> f64 {
        let at = |k: usize| self.over_velocity(self.at(k), |_, p| if p > 0.0 { -p * p.ln() } else { 0.0 });
        boole(self.step, 0..=ALONG, at)
    }
}

/// The largest relative distance of a found value from the true one, with its name.
struct Worst(f64, String);

impl Worst {
    /// Relative to the truth, or to `scale` where the truth may vanish.
    fn take(&mut self, what: &str, found: Estimate, truth: f64, scale: f64) {
        let off = (found.value - truth).abs() / truth.abs().max(scale);
        assert!(off < 1e-8, "{what}: {found:.12} instead of {truth:.12}, off by {off:.1e}");
        // The stated error covers the difference, but for the rounding of this file's own sums.
        let covered = (found.value - truth).abs() < found.error + 2e-10 * truth.abs().max(scale);
        assert!(covered, "{what}: {:e} ± {:e} instead of {truth:e}", found.value, found.error);
        if off >= self.0 {
            *self = Worst(off, what.to_owned());
        }
    }
}

/// All statistics of a density against the lattice's. The tolerance is 1e-8; the lattice's own error, by the orders of its
/// rules and by halving it, is below 1e-10.
fn check(name: &str, density: &dyn Density, log: &dyn Fn(f64, f64) -> f64, range: [f64; 2], fastest: f64) {
    let truth = Truth::new(log, range, fastest);
    let mut worst = Worst(0.0, String::new());
    let mean = truth.integral(0, |x, p| x * p);
    let [variance, third, fourth] = [2, 3, 4].map(|power| truth.central(mean, power));
    let found = Cumulants::new(density, 0).unwrap();
    let width = variance.sqrt();
    worst.take("mean", found.mean, mean, width);
    worst.take("variance", found.variance, variance, 0.0);
    worst.take("third cumulant", found.third, third, width.powi(3));
    worst.take("fourth cumulant", found.fourth, fourth - 3.0 * variance * variance, variance * variance);
    worst.take("skewness", found.skewness(), third / width.powi(3), 1.0);
    worst.take("kurtosis", found.kurtosis(), fourth / variance.powi(2), 0.0);
    worst.take("entropy", entropy(density).unwrap(), truth.entropy(), 1.0);
    let marginal = Marginal::new(density, 0).unwrap();
    let crossings = Crossings::new(density, [0, 1]).unwrap();
    let mean_rate = truth.rate(mean);
    for share in [0.1, 0.25, 0.4, 0.5, 0.6, 0.75, 0.85_f64] {
        let k = 4 * (share * ALONG as f64 / 4.0) as usize;
        let x = truth.at(k);
        let (tail, p, rate) = (truth.integral(k, |_, p| p), truth.marginal[k], truth.rate(x));
        worst.take("marginal", marginal.pdf(x).unwrap(), p, 0.0);
        worst.take("exceedance", marginal.exceedance(x).unwrap(), tail, 0.0);
        worst.take("distribution", marginal.distribution(x).unwrap(), 1.0 - tail, 0.1);
        worst.take("up-crossing rate", crossings.rate(x).unwrap(), rate, 0.0);
        worst.take("peaks above", crossings.peak_exceedance(x).unwrap(), rate / mean_rate, 0.0);
        for duration in [0.0, 3.0, 1e3] {
            let passage = 1.0 - (1.0 - tail) * (-rate * duration).exp();
            worst.take("first passage", crossings.first_passage(x, duration).unwrap(), passage, 1e-4);
        }
    }
    for q in [1e-10, 1e-8, 1e-4, 0.02, 0.3, 0.9] {
        let x = marginal.upper_quantile(q).unwrap();
        worst.take("exceedance at a quantile", Estimate::new(q, 0.0), truth.tail(x.value), 0.0);
        let mirror = marginal.quantile(q).unwrap().value;
        let below = truth.below(mirror);
        // Next to a wall the place itself has a rounding error.
        let rounding = marginal.pdf(mirror).unwrap().value * f64::EPSILON * mirror.abs() / q;
        assert!((below / q - 1.0).abs() < 1e-8 + rounding, "{name}: F({mirror}) = {below:e} instead of {q:e}");
    }
    println!("{name}: worst is {} with {:.1e}", worst.1, worst.0);
}

fn of(name: &str, model: &impl Solved, reach: f64, fastest: f64) {
    let log = |x: f64, v: f64| model.log_density(&[x, v]);
    let reach = [-reach, reach];
    check(name, &model.exact().unwrap(), &log, reach, fastest);
}

/// E0 to E4, E6, E7 and E10.
#[test]
fn closed_forms() {
    of("E0, linear", &linear(), 9.5, 13.0);
    of("E1, Duffing", &duffing(), 5.4, 9.0);
    of("E2, two wells", &bistable(), 3.5, 5.0);
    of("E2, three wells", &three_wells(), 3.2, 5.0);
    of("E3, van der Pol-Rayleigh", &van_der_pol_rayleigh(), 2.7, 2.7);
    of("E4, energy damping", &energy_damping(), 3.2, 5.0);
    of("E6, noise in the displacement", &displacement_noise(), 5.0, 9.0);
    of("E7, noise in the velocity", &velocity_noise(), 5.5, 11.0);
    for wall in [-0.5, 0.5] {
        let log = |x: f64, v: f64| duffing().log_density(&[x, v]);
        let above = duffing().exact_above(wall).unwrap();
        check(&format!("E10, wall at {wall}"), &above, &log, [wall, 4.9], 9.0);
    }
}

/// E5: κ = 2, δ = 11/2, Ω = 1, so that √κ/3 times Student's t with 9 degrees of freedom stands behind the marginal, and
/// everything is elementary: with s = x/√(κ + x²), P(X > x) = ∫_s^1 c (1 − u²)^(7/2) du, 1/c = ∫_−1^1.
#[test]
fn a_power_tail() {
    let exact = parametric_linear().exact();
    let core = exact.core();
    let marginal = Marginal::new(&exact, 0).unwrap();
    let crossings = Crossings::new(&exact, [0, 1]).unwrap();
    // u = cos θ turns it into ∫ sin⁸ θ dθ, a trigonometric polynomial.
    let integral = |theta: f64| boole(theta / 4000.0, 0..=4000, |k| (theta * k as f64 / 4000.0).sin().powi(8));
    for x in [-2.0, 0.0, 1.0, 5.0, 20.0_f64] {
        let theta = (core.sqrt()).atan2(x);
        let tail = integral(theta) / integral(PI);
        let rate = 4.5 * core.powf(4.5) * (core + x * x).powf(-4.5) / (9.0 * PI);
        for (what, found, truth) in [
            ("exceedance", marginal.exceedance(x).unwrap(), tail),
            ("rate", crossings.rate(x).unwrap(), rate),
            ("first passage", crossings.first_passage(x, 7.0).unwrap(), 1.0 - (1.0 - tail) * (-7.0 * rate).exp()),
        ] {
            assert!((found.value / truth - 1.0).abs() < 1e-8, "{what} at {x}: {:e} and {truth:e}", found.value);
        }
    }
    // E x² = κ/7 and E x⁴ = 3κ²/35: κ₄/κ₂² = 21/5 − 3.
    let found = Cumulants::new(&exact, 0).unwrap();
    assert!((found.variance.value / (core / 7.0) - 1.0).abs() < 1e-8);
    assert!((found.kurtosis().value / 4.2 - 1.0).abs() < 1e-8, "{:.12}", found.kurtosis());
    // −E ln p = −ln C + δ (ln κ + 1/(δ − 1)), since ln(1 + ρ²/κ) is exponential with the rate δ − 1.
    let truth = -(4.5 * core.powf(4.5) / PI).ln() + 5.5 * (core.ln() + 1.0 / 4.5);
    assert!((entropy(&exact).unwrap().value - truth).abs() < 1e-8, "{:.12} and {truth:.12}", entropy(&exact).unwrap());
    assert!(modes(&exact).unwrap()[0].0.iter().all(|x| x.abs() < 1e-8));
}

/// E x² = 1, E v² = Ω² for the linear oscillator: everything in closed form, but for the maximum's mean, whose integral is
/// one over F alone.
#[test]
fn the_linear_oscillator() {
    let exact = Linear::new(0.5, 4.0, 2.0).unwrap().exact().unwrap();
    let crossings = Crossings::new(&exact, [0, 1]).unwrap();
    let marginal = Marginal::new(&exact, 0).unwrap();
    for level in [-1.0, 0.0, 0.5, 2.0, 6.0_f64] {
        let fall = (-level * level / 2.0).exp();
        // ν⁺ = (Ω/2π) exp(−y²/2), Rayleigh's exp(−y²/2) and y exp(−y²/2).
        let near = |found: Estimate, truth: f64| (found.value - truth).abs() < 1e-8 * truth.abs().max(1e-2);
        assert!(near(crossings.rate(level).unwrap(), 2.0 / TAU * fall));
        assert!(near(crossings.peak_exceedance(level).unwrap(), fall));
    }
    for duration in [3.0, 1e4] {
        let maximum = crossings.maximum(duration).unwrap();
        let f = |y: f64| {
            let below = marginal.distribution(y).unwrap().value;
            below * (-duration * 2.0 / TAU * (-y * y / 2.0).exp()).exp()
        };
        // The least F at or above: nothing but F for the short time; for the long one F below −3 is above its least
        // value, which is below e^−3000.
        let least = |y: f64| if duration > 10.0 && y < 0.0 { 0.0 } else { f(y) };
        let step = 18.0 / 36_000.0;
        let mean = -9.0 + boole(step, 0..=36_000, |k| 1.0 - least(-9.0 + step * k as f64));
        let found = maximum.mean();
        println!("expected maximum in {duration}: {found:.12}, by another rule {mean:.12}");
        assert!((found.value - mean).abs() < 1e-8, "{found:.12} and {mean:.12}");
        let median = maximum.quantile(0.5).unwrap().value;
        assert!((f(median) - 0.5).abs() < 1e-8 && (maximum.exceedance(median).unwrap().value - 0.5).abs() < 1e-8);
        if duration > 10.0 {
            // A. G. Davenport's √(2 ln νT) + 0.5772/√(2 ln νT) (1964) leaves out (ln νT)^(−3/2): 3 % here.
            let peak = (2.0 * (duration * 2.0 / TAU).ln()).sqrt();
            assert!((mean / (peak + 0.577_215_664_9 / peak) - 1.0).abs() < 0.03);
        }
    }
    assert!((entropy(&exact).unwrap().value - (TAU * E * 2.0).ln()).abs() < 1e-10);
}

/// The exceedance 1e-8 of E1 and its quantile, to 1e-6: against exp(−x²/2 − 0.075 x⁴) alone.
#[test]
fn one_in_a_hundred_million() {
    let p = |x: f64| (-x * x / 2.0 - 0.075 * x.powi(4)).exp();
    let integral = |from: f64| boole((8.0 - from) / 8000.0, 0..=8000, |k| p(from + (8.0 - from) * k as f64 / 8000.0));
    let mass = 2.0 * integral(0.0);
    let (mut low, mut high) = (0.0, 8.0);
    for _ in 0..60 {
        let middle = (low + high) / 2.0;
        if integral(middle) / mass > 1e-8 { low = middle } else { high = middle }
    }
    let marginal = Marginal::new(&duffing().exact().unwrap(), 0).unwrap();
    let (level, share) = (marginal.upper_quantile(1e-8).unwrap(), marginal.exceedance(low).unwrap());
    println!(
        "E1: x with P(X > x) = 1e-8 is {level:.12}, by another rule {low:.12}; P(X > {low:.6}) = {:.12e}",
        share.value
    );
    assert!((level.value / low - 1.0).abs() < 1e-10 && (share.value / 1e-8 - 1.0).abs() < 1e-9);
    // 1 − 1e-8 itself has lost eight digits of the 1e-8.
    assert!((marginal.quantile(1.0 - 1e-8).unwrap().value / low - 1.0).abs() < 1e-8);
}

#[test]
fn maxima_are_where_the_force_vanishes() {
    // G′ = x − 1.8 x³ + 0.6 x⁵ vanishes at x² = (1.8 ± √0.84)/1.2; the larger root is a well.
    let outer = ((1.8 + 0.84_f64.sqrt()) / 1.2).sqrt();
    let found = modes(&three_wells().exact().unwrap()).unwrap();
    assert_eq!(found.len(), 3);
    for place in [-outer, 0.0, outer] {
        assert!(found.iter().any(|mode| (mode.0[0] - place).abs() < 1e-8 && mode.0[1].abs() < 1e-8), "{found:?}");
    }
    let marginal = Marginal::new(&three_wells().exact().unwrap(), 0).unwrap();
    let places: Vec<f64> = marginal.modes().iter().map(|(x, _)| *x).collect();
    assert!(places.len() == 3 && (places[2] - outer).abs() < 1e-8 && places[1].abs() < 1e-8, "{places:?}");
    // Above a wall on the far side of the well the most likely place is the wall.
    let above = duffing().exact_above(0.5).unwrap();
    let found = modes(&above).unwrap();
    assert!(found.len() == 1 && found[0].0[0] == 0.5 && found[0].0[1].abs() < 1e-8, "{found:?}");
    assert_eq!(Marginal::new(&above, 0).unwrap().modes()[0].0, 0.5);
    // The limit cycle's marginal has two maxima, and every point of the cycle is a maximum.
    let cycle = van_der_pol_rayleigh().exact().unwrap();
    assert_eq!(Marginal::new(&cycle, 1).unwrap().modes().len(), 2);
    for (at, _) in modes(&cycle).unwrap() {
        assert!((at[0].hypot(at[1]) - 1.0).abs() < 1e-6, "{at:?}");
    }
}

/// Means of draws, within four standard errors of the exact ones.
fn drawn(name: &str, density: &dyn Density, (samples, effective): &(States, Option<f64>)) {
    let count = effective.unwrap_or(f64::INFINITY).min(samples.len() as f64);
    let check = |what: &str, g: &dyn Fn(&[f64]) -> f64, truth: f64| {
        let total = samples.len() as f64;
        let mean = samples.iter().map(g).sum::<f64>() / total;
        let variance = samples.iter().map(|x| (g(x) - mean).powi(2)).sum::<f64>() / total;
        let z = (mean - truth) / (variance / count).sqrt();
        println!("{name}: {what} {mean:.5}, exact {truth:.5}, {z:.1} standard errors");
        assert!(z.abs() < 4.0, "{name}, {what}: {mean} instead of {truth}, {z:.1} standard errors");
    };
    let states = density.dimension();
    let moment =
        |power: &dyn Fn(usize) -> u32| density.moment(&(0..states).map(power).collect::<Vec<_>>()).unwrap().value;
    for state in 0..states {
        let power = |power: u32| moment(&|i| if i == state { power } else { 0 });
        check("mean", &|x| x[state], power(1));
        check("square", &|x| x[state].powi(2), power(2));
        check("fourth power", &|x| x[state].powi(4), power(4));
    }
    check("product", &|x| x[0] * x[1], moment(&|i| u32::from(i < 2)));
}

#[test]
fn draws_have_the_density() {
    for (name, density) in [
        ("E1", duffing().exact().unwrap()),
        ("E3", van_der_pol_rayleigh().exact().unwrap()),
        ("E10", duffing().exact_above(0.5).unwrap()),
    ] {
        let found = samples(&density, 40_000, 5).unwrap();
        assert_eq!(found.1, None);
        drawn(name, &density, &found);
        // A tail that one draw in a hundred reaches, and the middle.
        let marginal = Marginal::new(&density, 0).unwrap();
        for q in [0.01, 0.5] {
            let level = marginal.upper_quantile(q).unwrap().value;
            let share = found.0.iter().filter(|x| x[0] > level).count() as f64 / 4e4;
            let z = (share - q) / (q * (1.0 - q) / 4e4).sqrt();
            assert!(z.abs() < 4.0, "{name}: {share} above the quantile {q}");
        }
    }
    // Infinite where a lossy wall is grazed, by closure and by grid.
    for (b, r) in [(-0.5, 0.9), (0.5, 0.7)] {
        let closed = closed_above(8, b, r);
        drawn("closure above a wall", &*closed, &samples(&*closed, 40_000, 5).unwrap());
    }
    let power = parametric_linear().exact();
    let found = samples(&power, 20_000, 5).unwrap();
    let fast = found.0.iter().filter(|x| x[1] > 5.0).count() as f64 / 2e4;
    let truth = Marginal::new(&power, 1).unwrap().exceedance(5.0).unwrap().value;
    assert!((fast - truth).abs() < 4.0 * (truth / 2e4).sqrt(), "{fast} and {truth}");
    // No thread from another, no seed like another.
    let exact = duffing().exact().unwrap();
    let again = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(again.install(|| samples(&exact, 5000, 1).unwrap()), samples(&exact, 5000, 1).unwrap());
    assert_ne!(samples(&exact, 5000, 1).unwrap(), samples(&exact, 5000, 2).unwrap());
}

/// E9: a chain of two in equilibrium. Everything about x₁ by the exact density; the closure of order 4 is the same but for
/// its integration by draws, whose standard errors it states.
#[test]
fn four_states() {
    let exact = chain_of_two().exact().unwrap();
    let chain = closed_chain();
    let closed = &*chain;
    let marginal = Marginal::new(closed, 0).unwrap();
    // x₁ and x₂ go together by the potential alone.
    let log = |x: f64, y: f64| -((x * x + y * y) / 2.0 + 0.075 * (x.powi(4) + y.powi(4)) + (x - y).powi(2) / 4.0) / 0.8;
    let truth = Truth::new(&log, [-5.0, 5.0], 5.0);
    for level in [0.0, 1.0, 2.0] {
        let tail = truth.tail(level);
        let rate = truth.over_velocity(level, |_, p| p) * (0.8 / TAU).sqrt();
        for (what, found, truth) in [
            ("exceedance", marginal.exceedance(level).unwrap(), tail),
            ("rate", closed.upcrossing_rate(level).unwrap(), rate),
        ] {
            println!("{what} at {level}: {:.3e} ± {:.1e}, exact {truth:.3e}", found.value, found.error);
            assert!(found.deviation(truth) < 4.0 && found.error < 0.01 * found.value, "{what} at {level}");
        }
    }
    // Velocities are normal with the variance T, and independent of everything.
    let normal = |v: f64| (-v * v / 1.6).exp() / (0.8 * TAU).sqrt();
    let joint = closed.joint_marginal([3, 1], [0.4, -0.9]).unwrap();
    assert!(joint.deviation(normal(0.4) * normal(0.9)) < 4.0, "{joint}");
    assert!((exact.joint_marginal([3, 1], [0.4, -0.9]).unwrap().value / normal(0.4) / normal(0.9) - 1.0).abs() < 1e-10);
    assert!(modes(&exact).unwrap()[0].0.iter().all(|x| x.abs() < 1e-6));
    let found = entropy(closed).unwrap();
    assert!(found.deviation(entropy(&exact).unwrap().value) < 4.0, "{found}");
    for (name, density) in [("closure, 4 states", closed as &dyn Density), ("exact, 4 states", &exact)] {
        let found = samples(density, 10_000, 3).unwrap();
        assert!(found.1.unwrap() > 20_000.0, "{:?}", found.1);
        drawn(name, &exact, &found);
    }
    let apart = compare::distances(closed, &exact).unwrap();
    println!(
        "4 states: L1 {:.1e}, Hellinger {:.1e}, divergence {:.1e}",
        apart.l1.value, apart.hellinger.value, apart.kullback_leibler.value
    );
    // The closure is exact, and followed as far as the lattice is: 9e-12 was measured, and 1e-9 is the divergence's own error.
    assert!(apart.l1.value < 1e-10 && apart.kullback_leibler.value < 1e-9);
    assert!(compare::log_ratio(closed, &exact, 1e-4).unwrap().value < 0.01);
}

/// E10: impacts at the rate p_Y(b) √(D/2πc), at speeds with Rayleigh's distribution, that take nothing.
#[test]
fn impacts_at_an_elastic_wall() {
    for wall in [-0.5, 0.5] {
        let above = duffing().exact_above(wall).unwrap();
        let impacts = Impacts::new(&above, &duffing_above(wall, 1.0)).unwrap();
        let rate = above.marginal(0, wall).unwrap().value / TAU.sqrt();
        // D = c: E v² = 1, E w = √(π/2), E w² = 2.
        for (found, truth) in [
            (impacts.rate(), rate),
            (impacts.mean_speed(), (PI / 2.0).sqrt()),
            (impacts.mean_square_speed(), 2.0),
            (impacts.speed_pdf(0.7).unwrap(), 0.7 * (-0.245_f64).exp()),
            (impacts.speed_exceedance(0.7).unwrap(), (-0.245_f64).exp()),
            (impacts.speed_exceedance(6.0).unwrap(), (-18.0_f64).exp()),
        ] {
            assert!((found.value / truth - 1.0).abs() < 1e-8, "wall at {wall}: {found:.12} instead of {truth:.12}");
        }
        assert_eq!((impacts.energy_loss().value, impacts.power().value), (0.0, 0.0));
    }
}

/// One system, three methods, one set of questions: van der Pol's damping and cubic stiffness, no closed form. Each answer
/// lies within the sum of the two stated errors, four times that of the simulation, from the grid's.
#[test]
fn three_methods_agree_within_their_errors() {
    let problem = problem(cubic_damping());
    let grid = on_grid("cubic damping", &problem);
    let closed = closed("cubic damping", &problem, 8, 0);
    let levels = [0.0, 0.5, 1.0];
    let simulated = Simulation::new().samples(200_000).levels(levels).seed(2).run(&problem).unwrap();
    let [by_grid, by_closure, by_simulation] = [&*grid as &dyn Density, &*closed, &simulated].map(|density| {
        let (cumulants, marginal) = (Cumulants::new(density, 0).unwrap(), Marginal::new(density, 0).unwrap());
        let mut answers = vec![
            ("variance", cumulants.variance),
            ("kurtosis", cumulants.kurtosis()),
            ("entropy", entropy(density).unwrap()),
            ("quantile 0.9", marginal.quantile(0.9).unwrap()),
            ("upper quantile 0.01", marginal.upper_quantile(0.01).unwrap()),
        ];
        for level in levels {
            answers.push(("exceedance", marginal.exceedance(level).unwrap()));
            answers.push(("distribution", marginal.distribution(level).unwrap()));
            answers.push(("up-crossing rate", density.upcrossing_rate(level).unwrap()));
        }
        answers
    });
    for ((what, truth), ((_, closure), (_, simulation))) in
        by_grid.into_iter().zip(by_closure.into_iter().zip(by_simulation))
    {
        println!("{what}: grid {truth:.7}, closure {closure:.6}, simulation {simulation:.5}");
        assert!((closure.value - truth.value).abs() <= closure.error + truth.error, "{what}: {closure:.7}, {truth:.7}");
        assert!((simulation.value - truth.value).abs() <= 4.0 * simulation.error + truth.error, "{what}: {simulation}");
        // The errors are small enough for the comparison to be sharp.
        assert!(closure.error < 0.01 && simulation.error < 0.1, "{what}: {closure} and {simulation}");
    }
    assert!(matches!(Crossings::new(&simulated, [0, 1]), Err(Error::NotKnown { .. })));
    // Draws from the closure, which the grid's moments are compared with.
    drawn("closure", &*grid, &samples(&*closed, 20_000, 4).unwrap());
    assert_eq!(samples(&simulated, 1000, 4).unwrap().0.len(), 1000);
    // A problem has an impact rate where it has a wall, and none otherwise, by every method.
    assert_eq!([grid.impact_rate(), closed.impact_rate(), simulated.impact_rate()], [None; 3]);
}

/// A wall that takes energy: the power D of the noise is c E v² and the power that the impacts take.
#[test]
fn impacts_take_what_the_damper_leaves() {
    let problem = duffing_above(-0.5, 0.9);
    let grid = on_grid_above(-0.5, 0.9);
    let closed = closed_above(8, -0.5, 0.9);
    for (name, density) in [("grid", &*grid as &dyn Density), ("closure", &*closed)] {
        let impacts = Impacts::new(density, &problem).unwrap();
        let square = density.moment(&[0, 2]).unwrap();
        let left = 0.2 - 0.2 * square.value - impacts.power().value;
        let error = 0.2 * square.error + impacts.power().error;
        println!("{name}: power {:.7}, D - c E v^2 - power = {left:.1e} ± {error:.1e}", impacts.power());
        // The closure's moments are known to 1e-5 here, the grid's to 1e-8.
        assert!(left.abs() <= error && error < 1e-4, "{name}: {left:e} ± {error:e}");
        let product = impacts.rate().value * impacts.energy_loss().value;
        assert!((product / impacts.power().value - 1.0).abs() < 1e-12);
        // The exceedance begins at 1, up to the error of the flux itself.
        let whole = impacts.speed_exceedance(0.0).unwrap();
        assert!((whole.value - 1.0).abs() <= whole.error + 1e-6, "{name}: {whole:.8}");
    }
}

#[test]
fn questions_without_sense_are_refused() {
    let exact = duffing().exact().unwrap();
    let (marginal, crossings) = (Marginal::new(&exact, 0).unwrap(), Crossings::new(&exact, [0, 1]).unwrap());
    let refused = |answer: Result<Estimate, Error>, value: &str| {
        let error = answer.unwrap_err();
        assert!(matches!(error, Error::OutOfRange { .. }) && error.to_string().contains(value), "{error}");
    };
    for level in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        refused(marginal.pdf(level), "level");
        refused(marginal.distribution(level), "level");
        refused(marginal.exceedance(level), "level");
        refused(crossings.rate(level), "level");
        refused(crossings.peak_exceedance(level), "level");
        refused(crossings.first_passage(level, 1.0), "level");
    }
    let maximum = crossings.maximum(1.0).unwrap();
    for p in [-0.1, 0.0, 1.0, 1.5, f64::NAN, f64::INFINITY] {
        refused(marginal.quantile(p), "probability");
        refused(marginal.upper_quantile(p), "probability");
        refused(maximum.quantile(p), "probability");
    }
    for duration in [-1.0, f64::NAN, f64::INFINITY] {
        refused(crossings.first_passage(1.0, duration), "duration");
        assert!(matches!(crossings.maximum(duration), Err(Error::OutOfRange { name: "duration", .. })));
    }
    assert!(crossings.maximum(0.0).is_err());
    for level in [0.0, -1.0, 2.0, f64::NAN] {
        refused(compare::log_ratio(&exact, &exact, level), "level");
    }
    // States that are not there.
    assert!(matches!(Marginal::new(&exact, 2), Err(Error::Dimension { expected: 2, found: 2, .. })));
    assert!(matches!(Cumulants::new(&exact, 7), Err(Error::Dimension { found: 7, .. })));
    for pair in [[0, 2], [2, 0], [0, 0]] {
        assert!(matches!(Crossings::new(&exact, pair), Err(Error::Dimension { .. })));
        assert!(matches!(exact.joint_marginal(pair, [0.0; 2]), Err(Error::Dimension { .. })));
    }
    // Impacts of a problem without a wall, and of one of another number of states.
    assert!(matches!(Impacts::new(&exact, &problem(duffing())), Err(Error::NotServed { .. })));
    let chain = chain_of_two().problem().unwrap().with_wall(Wall::above(0.0, 0.9).unwrap()).unwrap();
    assert!(matches!(Impacts::new(&exact, &chain), Err(Error::Dimension { expected: 2, found: 4, .. })));
    assert!(matches!(samples(&exact, 0, 1), Err(Error::OutOfRange { .. })));
    for count in [1 << 40, usize::MAX] {
        assert!(matches!(samples(&exact, count, 1), Err(Error::TooMuchMemory { .. })));
    }
    // Beyond the table every probability is 0 or 1, and none is NaN.
    assert_eq!((marginal.exceedance(1e9).unwrap().value, marginal.distribution(-1e9).unwrap().value), (0.0, 0.0));
    assert!((marginal.exceedance(-1e9).unwrap().value - 1.0).abs() < 1e-12);
    assert_eq!(crossings.rate(1e9).unwrap().value, 0.0);
}

/// Two normal densities of E0: every distance in closed form. And an exact density from itself.
#[test]
fn distances_between_closed_forms() {
    let normal = |d: f64| Linear::new(0.5, 1.0, d).unwrap().exact().unwrap();
    let (one, two) = (normal(0.5), normal(0.6));
    let found = compare::distances(&one, &two).unwrap();
    // In ρ² = x² + v²: p = e^(−ρ²/2)/2π, q = e^(−ρ²/2.4)/2.4π; they are equal where ρ² (1 − 1/1.2)/2 = ln 1.2.
    let equal = 2.0 * 1.2_f64.ln() / (1.0 - 1.0 / 1.2);
    let l1 = 2.0 * ((-equal / 2.4).exp() - (-equal / 2.0).exp());
    println!("L1 {:.8}, {l1:.8}; Hellinger {:.10}", found.l1, found.hellinger);
    // The kink along a circle leaves the L¹ distance with the error that it states.
    assert!((found.l1.value - l1).abs() <= found.l1.error && found.l1.error < 1e-4, "{:.8} and {l1:.8}", found.l1);
    assert!((found.hellinger.value.powi(2) - (1.0 - 2.0 * 1.2_f64.sqrt() / 2.2)).abs() < 1e-10);
    assert!((found.kullback_leibler.value - (1.0 / 1.2 - 1.0 + 1.2_f64.ln())).abs() < 1e-10);
    let decades = compare::log_ratio(&one, &two, 1e-6).unwrap();
    let truth = 6.0 * 0.2 - 1.2_f64.log10();
    println!("decades {decades:?}, {truth}");
    // The part between the last point that is high enough and the level is in the error.
    assert!((decades.value - truth).abs() <= decades.error && decades.error < 1e-3, "{decades} and {truth}");
    let same = compare::distances(&two, &normal(0.6)).unwrap();
    assert!(same.l1.value < 1e-12 && same.hellinger.value < 1e-12 && same.kullback_leibler.value < 1e-12);
    // A simulation's noise is in the error: the simulated density does not differ from it by more.
    let problem = problem(Linear::new(0.5, 1.0, 0.5).unwrap());
    let simulated = Simulation::new().samples(100_000).seed(3).run(&problem).unwrap();
    let found = compare::distances(&one, &simulated).unwrap();
    println!(
        "from a simulation of itself: L1 {:.3}, Hellinger {:.3}, divergence {:.4}",
        found.l1, found.hellinger, found.kullback_leibler
    );
    for distance in [found.l1, found.hellinger, found.kullback_leibler] {
        assert!(distance.value > 0.0 && distance.value <= distance.error && distance.error < 0.5, "{distance}");
    }
    let balance = energy_balance(&problem, &one).unwrap();
    assert!(balance.value.abs() < 1e-12);
}

/// A density prints how it was made, its domain, moments, rates and error, a line each; estimates and problems come back from JSON.
#[test]
fn answers_print_themselves_and_come_back_from_json() {
    let problem = duffing_above(-0.3, 0.8);
    let density = Closure::new(4).pilot_states(5120).solve(&problem).unwrap();
    let text = density.to_string();
    let names =
        ["closure", "domain", "means", "mean squares", "up-crossings", "impacts per unit time", "estimate of the L1"];
    for (name, line) in names.iter().zip(text.lines()) {
        assert!(line.starts_with(name), "{text}");
    }
    let square = density.moment(&[2, 0]).unwrap();
    assert!(text.contains(&square.to_string()), "{text}");
    let through = serde_json::to_string(&square).unwrap();
    assert_eq!(serde_json::from_str::<Estimate>(&through).unwrap(), square);
    let through = serde_json::to_string(&problem).unwrap();
    let again: Problem = serde_json::from_str(&through).unwrap();
    assert_eq!(again.to_string(), problem.to_string());
    assert_eq!(again.walls(), problem.walls());
}
