//! The closure above walls in three states and four.

use crate::common::l1_over_draws;
use crate::simulation::walls::{Bodies, Room, with_walls};
use expoly::models::{ColouredVibroImpact, Duffing};
use expoly::statistics::{Impacts, Marginal};
use expoly::{Closure, ClosureDensity, Density, Drift, Error, Problem, Reference, Scalar, Simulation, Wall};

pub(crate) const BODIES: Bodies = Bodies {
    masses: [1.0, 0.5],
    damping: [0.2, 0.3],
    stiffness: [1.0, 0.5],
    cubic: 0.3,
    coupling: 0.6,
    temperature: 0.8,
};

/// Two bodies in equilibrium, with one wall, between two, and against each other: elastic walls cut the density off, which the
/// closure finds to the rounding of its equations, and the rates of impacts are ν = √(T/2πm) p(b).
#[test]
fn elastic_walls_in_four_states_are_exact() {
    let open = Room { own: [Room::OPEN; 2], difference: Room::OPEN };
    let rooms = [
        Room { own: [[-0.3, Room::OPEN[1]], Room::OPEN], ..open },
        Room { own: [Room::OPEN, [-0.6, 0.9]], ..open },
        Room { difference: [-0.4, Room::OPEN[1]], ..open },
    ];
    for room in rooms {
        let walls = room.walls(1.0, BODIES.masses).unwrap();
        let problem = with_walls(Problem::of(BODIES).unwrap(), &walls).unwrap();
        let density = Closure::new(4).pilot_states(51_200).solve(&problem).unwrap();
        let energy = |x: &[f64]| {
            let kinetic = (BODIES.masses[0] * x[2] * x[2] + BODIES.masses[1] * x[3] * x[3]) / 2.0;
            -(kinetic + BODIES.potential([x[0], x[1]])) / BODIES.temperature
        };
        let l1 = l1_over_draws(energy, &density);
        println!("{room:?}: L1 {l1:.1e}, estimate {:.1e}", density.l1_estimate());
        // Measured: 5e-14 to 3e-12.
        assert!(l1 < 1e-10 && density.l1_estimate() < 1e-4 && density.warning().is_none());
        assert!(density.provenance().calibration_degree.is_some());
        for (k, wall) in walls.iter().enumerate() {
            let place = wall.other().map_or(wall.state(), |_| 2);
            let mass = if place < 2 { BODIES.masses[place] } else { wall.mass() };
            let truth =
                (BODIES.temperature / (std::f64::consts::TAU * mass)).sqrt() * BODIES.at(&room, place, wall.offset());
            let impacts = Impacts::at(&density, &problem, k).unwrap();
            let rate = impacts.rate();
            println!("  wall {k}: rate {rate}, not {truth}");
            assert!((rate.value - truth).abs() < 4.0 * rate.error && rate.error < 0.01 * truth);
            // Rayleigh's distribution of speeds: P(|w| > s) = exp(−m s²/2T), on bins of a tenth or so.
            let faster = impacts.speed_exceedance(1.0).unwrap();
            let known = (-mass / (2.0 * BODIES.temperature)).exp();
            assert!((faster.value - known).abs() < 4.0 * faster.error + 3e-3, "{faster} and {known}");
            assert_eq!(impacts.power().value, 0.0);
        }
        // Nothing is behind a wall.
        let behind = if walls[0].other().is_some() { [-1.0, 0.5, 0.0, 0.0] } else { [-0.9, -0.9, 0.0, 0.0] };
        assert_eq!(density.pdf(&behind).unwrap().value, 0.0);
    }
}

fn coloured(offset: f64, restitution: f64) -> Problem {
    let duffing = Duffing::new(0.2, 1.0, 0.3, 0.3).unwrap();
    ColouredVibroImpact::new(duffing, 2.0, 0.05, [offset, restitution]).unwrap().problem().unwrap()
}

/// An oscillator under filtered and white noise above a wall, against a simulation of its own: all within four standard errors,
/// which are some tenths of a percent.
#[test]
fn a_wall_under_filtered_noise_agrees_with_the_simulation() {
    let problem = coloured(-0.5, 0.6);
    let density = Closure::new(6).pilot_states(204_800).solve(&problem).unwrap();
    let simulated = Simulation::new().samples(250_000).time_step(0.01).seed(3).run(&problem).unwrap();
    for powers in [[1, 0, 0], [2, 0, 0], [0, 2, 0], [0, 4, 0], [1, 0, 1]] {
        let (p, q) = (density.moment(&powers).unwrap(), simulated.moment(&powers).unwrap());
        println!("{powers:?}: {p} and {q}");
        assert!((p.value - q.value).abs() < 4.0 * p.error.hypot(q.error), "{powers:?}: {p} and {q}");
        assert!(p.error < 4e-3 * p.value.abs(), "{powers:?}: {p}");
    }
    let [found, counted] = [&density as &dyn Density, &simulated].map(|d| Impacts::new(d, &problem).unwrap());
    let faster = [&found, &counted].map(|impacts| impacts.speed_exceedance(0.8).unwrap());
    // Within a bin, a fortieth of the fastest speed, the closure takes speeds as even.
    for (p, q, of_bins) in [
        (found.rate(), counted.rate(), 0.0),
        (found.mean_speed(), counted.mean_speed(), 0.0),
        (found.power(), counted.power(), 0.0),
        (faster[0], faster[1], 1e-3),
    ] {
        println!("{p} and {q}");
        assert!((p.value - q.value).abs() < 4.0 * p.error.hypot(q.error) + of_bins, "{p} and {q}");
        assert!(p.error < 0.02 * p.value, "{p}");
    }
    assert!(density.l1_estimate() < 0.05, "{}", density.l1_estimate());
    // The filter's own variance is known exactly: a D = 0.6.
    assert!((density.moment(&[0, 0, 2]).unwrap().value - 0.6).abs() < 1e-9);
    // The same from a document, to the bit.
    let text = serde_json::to_string(&density).unwrap();
    let read: ClosureDensity = serde_json::from_str(&text).unwrap();
    let x = [0.1, 0.4, -0.3];
    assert_eq!(density.pdf(&x).unwrap().value.to_bits(), read.pdf(&x).unwrap().value.to_bits());
    assert_eq!(density.impact_rate(), read.impact_rate());
    assert_eq!(density.marginal(0, 0.3).unwrap(), read.marginal(0, 0.3).unwrap());
}

/// y″ + 0.2 y′ + y = z + √0.4 z ξ₀, z′ = −z + ξ: noise on the velocity that depends on another state.
#[derive(Clone, Copy, Debug)]
struct Modulated;

impl Drift<3, 2> for Modulated {
    fn drift<S: Scalar>(&self, [y, v, z]: [S; 3]) -> [S; 3] {
        [v, z - v * 0.2 - y, -z]
    }

    fn noise<S: Scalar>(&self, [_, _, z]: [S; 3]) -> [[S; 2]; 3] {
        let zero = S::from(0.0);
        [[zero; 2], [z * 0.4_f64.sqrt(), zero], [zero, S::from(0.5)]]
    }
}

#[test]
fn what_has_no_density_or_no_functions_is_refused() {
    let at_rest = ColouredVibroImpact::new(Duffing::new(0.2, 1.0, 0.3, 0.3).unwrap(), 2.0, 0.0, [0.5, 0.6]).unwrap();
    let refused = Closure::new(4).solve(&at_rest.problem().unwrap());
    assert!(matches!(refused, Err(Error::NoDensity { .. })), "{refused:?}");
    let modulated = Problem::of(Modulated).unwrap().with_wall(Wall::above(-0.3, 0.9).unwrap()).unwrap();
    for (closure, problem) in
        [(Closure::new(4), modulated), (Closure::new(4).reference(Reference::Equations), coloured(0.0, 0.9))]
    {
        let refused = closure.pilot_states(10_240).solve(&problem);
        assert!(matches!(refused, Err(Error::NotServed { method: "closure", .. })), "{refused:?}");
    }
}

/// A lossy wall between two bodies: means are calibrated, and moments, the impacts' power and exceedances are those of a simulation.
#[test]
fn a_lossy_wall_between_two_bodies_agrees_with_a_simulation() {
    let open = Room { own: [Room::OPEN; 2], difference: Room::OPEN };
    let room = Room { difference: [-0.4, Room::OPEN[1]], ..open };
    let walls = room.walls(0.6, BODIES.masses).unwrap();
    let problem = with_walls(Problem::of(BODIES).unwrap(), &walls).unwrap();
    let density = Closure::new(4).pilot_states(102_400).solve(&problem).unwrap();
    println!("degree {:?}, estimate {:.1e}", density.provenance().calibration_degree, density.l1_estimate());
    assert!(density.provenance().calibration_degree.is_some());
    let powers: Vec<Vec<u32>> = (0..4).map(|i| (0..4).map(|j| if i == j { 2 } else { 0 }).collect()).collect();
    let truth = Simulation::new().samples(1_000_000).seed(3).moments(&powers).run(&problem).unwrap();
    for powers in &powers {
        let [own, other] = [density.moment(powers).unwrap(), truth.moment(powers).unwrap()];
        let apart = (own.value - other.value) / own.error.hypot(other.error);
        println!("{powers:?}: {own} and {other}, {apart:.1}");
        assert!(apart.abs() < 4.0, "{powers:?}: {own} and {other}");
    }
    let [own, other] = [Impacts::at(&density, &problem, 0).unwrap(), Impacts::at(&truth, &problem, 0).unwrap()];
    println!("rates {} and {}, power {} and {}", own.rate(), other.rate(), own.power(), other.power());
    for (own, other) in [(own.rate(), other.rate()), (own.power(), other.power())] {
        assert!((own.value - other.value).abs() < 4.0 * own.error.hypot(other.error), "{own} and {other}");
    }
    for (state, level) in [(0, 1.0), (1, 1.5)] {
        let [own, other] = [
            Marginal::new(&density, state).unwrap().exceedance(level).unwrap(),
            Marginal::new(&truth, state).unwrap().exceedance(level).unwrap(),
        ];
        println!("P(x_{state} > {level}): {own} and {other}");
        assert!((own.value - other.value).abs() < 4.0 * own.error.hypot(other.error), "{own} and {other}");
    }
}
