//! Several walls, in two states and in more.

use crate::common::{between, duffing_above, walls_at};
use expoly::models::{Duffing, FilteredDuffing};
use expoly::statistics::Impacts;
use expoly::{Closure, Density, Drift, Error, Estimate, Problem, Result, Scalar, SimulatedDensity, Simulation, Wall};

/// Two bodies in equilibrium with a bath, m_i y_i″ + c_i y_i′ + k_i y_i + μ y_i³ + κ (y_i − y_j) = √(2 c_i T) ξ_i:
/// p = C exp{−(½ m₁ v₁² + ½ m₂ v₂² + U)/T}, cut off by elastic walls.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bodies {
    pub(crate) masses: [f64; 2],
    pub(crate) damping: [f64; 2],
    pub(crate) stiffness: [f64; 2],
    pub(crate) cubic: f64,
    pub(crate) coupling: f64,
    pub(crate) temperature: f64,
}

impl Drift<4, 2> for Bodies {
    fn drift<S: Scalar>(&self, [x, y, u, v]: [S; 4]) -> [S; 4] {
        let force = |i: usize, own: S, other: S, speed: S| {
            let spring = own * self.stiffness[i] + own.powi(3) * self.cubic + (own - other) * self.coupling;
            -(spring + speed * self.damping[i]) / self.masses[i]
        };
        [u, v, force(0, x, y, u), force(1, y, x, v)]
    }

    fn noise<S: Scalar>(&self, _: [S; 4]) -> [[S; 2]; 4] {
        let strength = |i: usize| (2.0 * self.damping[i] * self.temperature).sqrt() / self.masses[i];
        let zero = S::from(0.0);
        [[zero; 2], [zero; 2], [S::from(strength(0)), zero], [zero, S::from(strength(1))]]
    }
}

/// The nodes and weights of Gauss' rule with three points on each of many equal parts.
fn rule([low, high]: [f64; 2], parts: usize) -> Vec<(f64, f64)> {
    let width = (high - low).max(0.0) / parts as f64;
    let points = [(-0.6_f64.sqrt(), 5.0 / 18.0), (0.0, 8.0 / 18.0), (0.6_f64.sqrt(), 5.0 / 18.0)];
    let part = |k: usize| points.map(|(x, w)| (low + width * (k as f64 + 0.5 + 0.5 * x), width * w));
    (0..parts).flat_map(part).collect()
}

/// Where walls leave the displacements of two bodies and their difference; ±7 stands for no wall.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Room {
    pub(crate) own: [[f64; 2]; 2],
    pub(crate) difference: [f64; 2],
}

impl Room {
    pub(crate) const OPEN: [f64; 2] = [-7.0, 7.0];

    pub(crate) fn walls(&self, r: f64, masses: [f64; 2]) -> Result<Vec<Wall>> {
        let mut walls = Vec::new();
        let ranges = [self.own[0], self.own[1], self.difference];
        for (k, [low, high]) in ranges.into_iter().enumerate() {
            let on = |wall: Wall| if k < 2 { Ok(wall.on(k)) } else { wall.between([0, 1], masses) };
            if low > Self::OPEN[0] {
                walls.push(on(Wall::above(low, r)?)?);
            }
            if high < Self::OPEN[1] {
                walls.push(on(Wall::below(high, r)?)?);
            }
        }
        Ok(walls)
    }
}

impl Bodies {
    /// Two of unlike masses and springs.
    pub(crate) const UNLIKE: Bodies = Bodies {
        masses: [1.0, 0.4],
        damping: [0.2, 0.1],
        stiffness: [1.0, 0.5],
        cubic: 0.2,
        coupling: 0.5,
        temperature: 0.8,
    };

    pub(crate) fn potential(&self, [x, y]: [f64; 2]) -> f64 {
        let own = |i: usize, x: f64| self.stiffness[i] * x * x / 2.0 + self.cubic * x.powi(4) / 4.0;
        own(0, x) + own(1, y) + self.coupling * (x - y).powi(2) / 2.0
    }

    /// ∫ g exp(−U/T) over the second displacement where the difference is `d`.
    fn section(&self, room: &Room, d: f64, g: impl Fn([f64; 2]) -> f64) -> f64 {
        let [[lx, hx], [ly, hy]] = room.own;
        let weight = |x: [f64; 2]| (-self.potential(x) / self.temperature).exp() * g(x);
        let nodes = rule([ly.max(lx - d), hy.min(hx - d)], 60);
        nodes.into_iter().map(|(y, w)| w * weight([y + d, y])).sum()
    }

    fn integral(&self, room: &Room, g: impl Fn([f64; 2]) -> f64) -> f64 {
        rule(room.difference, 120).into_iter().map(|(d, w)| w * self.section(room, d, &g)).sum()
    }

    /// The density of the displacement `k`, or of the difference for k = 2, at `at`.
    pub(crate) fn at(&self, room: &Room, k: usize, at: f64) -> f64 {
        let weight = |x: [f64; 2]| (-self.potential(x) / self.temperature).exp();
        let total = self.integral(room, |_| 1.0);
        let [[lx, hx], [ly, hy]] = room.own;
        let [ld, hd] = room.difference;
        let along: f64 = match k {
            0 => rule([ly.max(at - hd), hy.min(at - ld)], 200).into_iter().map(|(y, w)| w * weight([at, y])).sum(),
            1 => rule([lx.max(at + ld), hx.min(at + hd)], 200).into_iter().map(|(x, w)| w * weight([x, at])).sum(),
            _ => self.section(room, at, |_| 1.0),
        };
        along / total
    }
}

/// A sequence of numbers between 0 and 1.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 * 2.0_f64.powi(-53)
    }

    fn between(&mut self, [low, high]: [f64; 2]) -> f64 {
        low + (high - low) * self.next()
    }
}

pub(crate) fn with_walls(problem: Problem, walls: &[Wall]) -> Result<Problem> {
    walls.iter().try_fold(problem, |problem, wall| problem.with_wall(*wall))
}

/// The deviation in standard errors, which is printed.
fn deviation(what: &str, found: Estimate, truth: f64) -> f64 {
    deviation_from(what, found, Estimate::exact(truth))
}

/// The same from a value with an error of its own.
fn deviation_from(what: &str, found: Estimate, truth: Estimate) -> f64 {
    let deviation = (found.value - truth.value) / found.error.hypot(truth.error);
    println!("{what}: {found}, not {truth}: {deviation:.1} standard errors");
    assert!(deviation.abs() < 4.0, "{what}: {found}, not {truth}");
    deviation
}

/// Each displacement's velocity has as much power taken as put in.
fn assert_balance(what: &str, result: &SimulatedDensity) {
    for (k, balance) in result.energy_balance().into_iter().enumerate() {
        assert!(balance.error < 0.03, "{what}: the balance of velocity {k} is {balance}");
        deviation(&format!("{what}: balance of velocity {k}"), balance, 0.0);
    }
}

/// Two bodies of different masses, each with up to two walls, and up to two between them, which take nothing: moments and the
/// rate of impacts at each wall, ν = √(T/2πm) p(b) with the mass m or, between the two, the reduced mass.
#[test]
fn elastic_walls_on_two_bodies_leave_the_equilibrium() -> Result<()> {
    let mut numbers = Numbers(2026);
    let mut squares = Vec::new();
    for case in 0..10_u64 {
        let mut number = |range| numbers.between(range);
        let bodies = Bodies {
            masses: [1.0, number([0.2, 1.5])],
            damping: [number([0.1, 0.4]), number([0.1, 0.3])],
            stiffness: [number([0.7, 1.3]), number([0.3, 1.0])],
            cubic: number([0.0, 0.3]),
            coupling: number([0.1, 0.6]),
            temperature: number([0.5, 1.0]),
        };
        let mut side = |chosen: bool, range| if chosen { number(range) } else { 8.0 };
        let room = Room {
            own: [
                [-side(case % 2 == 0, [-0.3, 1.0]), side(case % 4 == 0, [0.6, 1.4])],
                [-side(case % 5 == 0, [0.2, 1.0]), side(case % 3 == 0, [0.3, 1.2])],
            ],
            difference: [-side(case % 2 == 1, [0.0, 0.8]), side(case % 4 == 1, [0.4, 1.2])],
        };
        let room = Room {
            own: room.own.map(|[low, high]| [low.max(Room::OPEN[0]), high.min(Room::OPEN[1])]),
            difference: [room.difference[0].max(Room::OPEN[0]), room.difference[1].min(Room::OPEN[1])],
        };
        let walls = room.walls(1.0, bodies.masses)?;
        let problem = with_walls(Problem::of(bodies)?, &walls)?;
        let result = Simulation::new().samples(60_000).seed(case).run(&problem)?;
        let total = bodies.integral(&room, |_| 1.0);
        let mean = |g: &dyn Fn([f64; 2]) -> f64| bodies.integral(&room, g) / total;
        let speed = |k: usize| bodies.temperature / bodies.masses[k];
        for (powers, truth) in [
            ([1, 0, 0, 0], mean(&|[x, _]| x)),
            ([2, 0, 0, 0], mean(&|[x, _]| x * x)),
            ([0, 2, 0, 0], mean(&|[_, y]| y * y)),
            ([1, 1, 0, 0], mean(&|[x, y]| x * y)),
            ([0, 0, 2, 0], speed(0)),
            ([0, 0, 0, 2], speed(1)),
        ] {
            squares.push(deviation(&format!("case {case}: E of {powers:?}"), result.moment(&powers)?, truth).powi(2));
        }
        for (k, wall) in walls.iter().enumerate() {
            let impacts = Impacts::at(&result, &problem, k)?;
            let mass = if wall.other().is_some() { wall.mass() } else { bodies.masses[wall.state()] };
            let place = wall.other().map_or(wall.state(), |_| 2);
            let variance = bodies.temperature / mass;
            let rate = (variance / std::f64::consts::TAU).sqrt() * bodies.at(&room, place, wall.offset());
            squares.push(deviation(&format!("case {case}: rate at wall {k}"), impacts.rate(), rate).powi(2));
            // Rayleigh's distribution.
            let mean = (std::f64::consts::FRAC_PI_2 * variance).sqrt();
            squares.push(deviation(&format!("case {case}: speed at wall {k}"), impacts.mean_speed(), mean).powi(2));
        }
        assert_balance(&format!("case {case}"), &result);
    }
    // Of a hundred statistics, some of them correlated; chance gives 1 ± 0.07.
    let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    println!("root mean square of {}: {rms}", squares.len());
    assert!((0.85..1.15).contains(&rms), "the deviations have the root mean square {rms}");
    Ok(())
}

/// The same bodies with walls that take energy: the balance of each velocity, and what all walls take together.
#[test]
fn lossy_walls_on_two_bodies_keep_the_balance() -> Result<()> {
    for (case, r) in [0.3, 0.5, 0.7, 0.9, 0.3, 0.5, 0.7, 0.9].into_iter().enumerate() {
        let bodies = Bodies::UNLIKE;
        let room = if case < 4 {
            Room { own: [[-0.3, 7.0], [-7.0, 7.0]], difference: [-0.5, 0.8] }
        } else {
            Room { own: [[-0.6, 0.9], [-0.8, 7.0]], difference: Room::OPEN }
        };
        let problem = with_walls(Problem::of(bodies)?, &room.walls(r, bodies.masses)?)?;
        let result = Simulation::new().samples(60_000).seed(case as u64).run(&problem)?;
        assert_balance(&format!("r = {r}, case {case}"), &result);
        let all = Impacts::new(&result, &problem)?;
        let each: f64 = (0..problem.walls().len())
            .map(|k| Impacts::at(&result, &problem, k).map(|impacts| impacts.power().value))
            .sum::<Result<f64>>()?;
        assert!((all.power().value / each - 1.0).abs() < 1e-9, "{} and {each}", all.power());
        // What the noise brings is what dampers and walls take; the power at a body's own wall is per unit of its mass.
        let brought: f64 = (0..2).map(|i| bodies.damping[i] * bodies.temperature / bodies.masses[i]).sum();
        let mut taken = vec![
            result.moment(&[0, 0, 2, 0])?.scaled(bodies.damping[0]),
            result.moment(&[0, 0, 0, 2])?.scaled(bodies.damping[1]),
        ];
        for (k, wall) in problem.walls().iter().enumerate() {
            let mass = if wall.other().is_some() { 1.0 } else { bodies.masses[wall.state()] };
            taken.push(Impacts::at(&result, &problem, k)?.power().scaled(mass));
        }
        let sum: f64 = taken.iter().map(|part| part.value).sum();
        let error = taken.iter().map(|part| part.error.powi(2)).sum::<f64>().sqrt();
        assert!(error < 5e-3 * brought, "{error}");
        deviation(&format!("r = {r}, case {case}: power taken"), Estimate::new(sum, error), brought);
    }
    Ok(())
}

/// The balance of a velocity is the power of the noise, D = 0.2, less what damper, springs and wall take, by the same samples: an identity
/// of sums, to rounding.
#[test]
fn the_balance_is_that_of_its_parts() -> Result<()> {
    let problem = duffing_above(-0.5, 0.6);
    let result = Simulation::new().samples(20_000).control_variates(false).run(&problem)?;
    let mean = |powers: [u32; 2]| result.moment(&powers).map(|moment| moment.value);
    let springs = mean([1, 1])? + 0.3 * mean([3, 1])?;
    let taken = 0.2 * mean([0, 2])? + springs + Impacts::new(&result, &problem)?.power().value;
    let balance = result.energy_balance()[0].value;
    println!("{balance:e}, by its parts {:e}", 1.0 - taken / 0.2);
    assert!((balance - (1.0 - taken / 0.2)).abs() < 1e-12, "{balance} and {}", 1.0 - taken / 0.2);
    Ok(())
}

/// Two walls of one oscillator, which take energy or not: against densities cut off, and against the grid.
#[test]
fn two_walls_of_one_oscillator_match_other_methods() -> Result<()> {
    let mut squares = Vec::new();
    for (seed, (offsets, restitutions)) in [
        ([-0.5, 1.0], [1.0, 1.0]),
        ([-1.5, 0.2], [1.0, 1.0]),
        ([0.2, 0.9], [1.0, 1.0]),
        ([-0.05, 0.05], [1.0, 1.0]),
        ([-0.5, 0.5], [0.9, 0.9]),
        ([-0.8, 1.2], [0.8, 0.6]),
        ([-0.3, 0.6], [0.5, 0.7]),
        ([-1.0, 0.4], [0.3, 0.9]),
    ]
    .into_iter()
    .enumerate()
    {
        let problem = between(walls_at(offsets, restitutions));
        let name = format!("between {offsets:?} with {restitutions:?}");
        let result = Simulation::new().samples(200_000).seed(seed as u64).run(&problem)?;
        assert_balance(&name, &result);
        let reference = expoly::Grid::new().accuracy(1e-4).solve(&problem)?;
        for powers in [[1, 0], [2, 0], [0, 2], [0, 4]] {
            let what = format!("{name}: E of {powers:?}");
            squares.push(deviation_from(&what, result.moment(&powers)?, reference.moment(&powers)?).powi(2));
        }
        for wall in 0..2 {
            let [found, truth] = [Impacts::at(&result, &problem, wall)?, Impacts::at(&reference, &problem, wall)?];
            let what = format!("{name}: rate at wall {wall}");
            squares.push(deviation_from(&what, found.rate(), truth.rate()).powi(2));
            let [found, truth] = [found.mean_speed(), truth.mean_speed()];
            squares.push(deviation_from(&format!("{name}: speed at wall {wall}"), found, truth).powi(2));
        }
    }
    let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    println!("root mean square of {}: {rms}", squares.len());
    assert!((0.7..1.3).contains(&rms), "the deviations have the root mean square {rms}");
    Ok(())
}

/// Where no white noise acts on the velocity, a pressed oscillator chatters to rest. Its time at rest, 22.9 ± 0.2 % by plain
/// steps of 2·10⁻⁴ with an impact in each, does not depend on the step; nor do moments, what impacts take, and the
/// number of rests.
#[test]
fn rest_on_a_wall_does_not_depend_on_the_step() -> Result<()> {
    let filtered = FilteredDuffing::first_order(Duffing::new(0.2, 1.0, 0.3, 0.3)?, 2.0)?.problem()?;
    let problem = filtered.with_wall(Wall::above(0.5, 0.6)?)?;
    let rests = Closure::new(4).solve(&problem).unwrap_err();
    assert!(matches!(rests, Error::NoDensity { .. }) && rests.to_string().contains("wall 0"), "{rests}");
    let run = |step: f64| {
        let simulation = Simulation::new().samples(200_000).time_step(step).burn_in(60.0).sampling_interval(1.0);
        simulation.seed((1.0 / step) as u64).run(&problem)
    };
    let mut found: Vec<[Estimate; 5]> = Vec::new();
    for step in [0.02, 0.005] {
        let result = run(step)?;
        let statistics = [
            result.time_at_rest(0)?,
            result.complete_chatters(0)?,
            result.mean(0)?,
            result.moment(&[0, 2, 0])?,
            Impacts::new(&result, &problem)?.power(),
        ];
        println!("{step}: {}", statistics.map(|s| s.to_string()).join(", "));
        found.push(statistics);
    }
    assert!((found[1][0].value - 0.229).abs() < 4.0 * found[1][0].error.hypot(0.002), "{}", found[1][0]);
    for (k, name) in ["time at rest", "chatters", "E x", "E v²", "power"].into_iter().enumerate() {
        for pair in found.windows(2) {
            let [coarse, fine] = [pair[0][k], pair[1][k]];
            let change = Estimate::new(coarse.value - fine.value, coarse.error.hypot(fine.error));
            assert!(coarse.error < 0.02 * coarse.value, "{name}: {coarse}");
            deviation(&format!("{name}, from step to step"), change, 0.0);
        }
    }
    Ok(())
}

/// Noise on one of two bodies alone: the other comes to rest on its wall, with the momentum balance of its velocity kept.
#[test]
fn a_body_without_noise_of_its_own_rests() -> Result<()> {
    struct Driven(Bodies);
    impl Drift<4, 1> for Driven {
        fn drift<S: Scalar>(&self, x: [S; 4]) -> [S; 4] {
            self.0.drift(x)
        }
        fn noise<S: Scalar>(&self, x: [S; 4]) -> [[S; 1]; 4] {
            self.0.noise(x).map(|[_, second]| [second])
        }
    }
    let bodies = Bodies {
        masses: [1.0, 0.5],
        damping: [0.2, 0.2],
        stiffness: [1.0, 0.5],
        cubic: 0.0,
        coupling: 0.5,
        temperature: 1.0,
    };
    let problem = Problem::of(Driven(bodies))?.with_wall(Wall::above(0.4, 0.7)?)?;
    let result = Simulation::new().samples(100_000).run(&problem)?;
    let rest = result.time_at_rest(0)?;
    println!("at rest for {rest}, chatters {}", result.complete_chatters(0)?);
    assert!(rest.value > 0.05 && rest.error < 0.01);
    assert_balance("noise on the other body", &result);
    // Beside noise there is none.
    let noisy = Problem::of(bodies)?.with_wall(Wall::above(0.4, 0.7)?)?;
    assert_eq!(Simulation::new().samples(10_000).run(&noisy)?.time_at_rest(0)?.value, 0.0);
    Ok(())
}
