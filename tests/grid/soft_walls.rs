//! Soft walls, whose contact is polynomial: an impact, the exact density of elastic ones, and the approach to rigid walls.

use crate::common::*;
use expoly::models::{Duffing, SoftWalls};
use expoly::{Density, Grid, GridDensity, Oscillator, Simulation, compare};
use std::sync::Arc;

const ENDS: [f64; 2] = [-0.5, 2.5];
const ENERGY: f64 = 0.56;

fn soft(restitution: f64, power: u32) -> SoftWalls {
    SoftWalls::new(duffing(), ENDS, restitution, power, ENERGY).unwrap()
}

/// On a domain that ends where the energy of contact is 16 D/c, and the density 1e-7 of its peak.
fn solved(restitution: f64, power: u32) -> Arc<GridDensity> {
    static SOLVED: Shared<(u64, u32), GridDensity> = Shared::new();
    SOLVED.get((restitution.to_bits(), power), || {
        let reach = 1.5 * ((16.0 / ENERGY).powf(0.5 / f64::from(power)) - 1.0);
        let domain = [[ENDS[0] - reach, ENDS[1] + reach], [-5.8, 5.8]];
        Grid::new().accuracy(1e-5).domain(domain).solve(&soft(restitution, power).problem().unwrap()).unwrap()
    })
}

/// Contact alone returns r times the speed whatever the speed and the power, since it is a linear oscillator in the square root of
/// its energy. Thousands of steps of Runge and Kutta's fourth order for an impact leave 2e-12.
#[test]
fn an_impact_on_a_soft_wall_has_its_restitution_at_every_speed() {
    let free = Duffing::new(0.0, 0.0, 0.0, 0.2).unwrap();
    let middle = (ENDS[0] + ENDS[1]) / 2.0;
    for (restitution, power) in [(1.0, 9), (0.7, 3), (0.7, 25), (0.2, 9)] {
        let walls = SoftWalls::new(free, ENDS, restitution, power, ENERGY).unwrap();
        let slope = |[y, v]: [f64; 2]| [v, -walls.force(y, v)];
        for speed in [-3.0, -1.0, 0.2] {
            let step = 2e-4 * 1.5 / f64::abs(speed);
            let [mut y, mut v] = [middle, speed];
            let mut time = 0.0;
            while (y - middle) * speed >= 0.0 {
                let moved = |h: f64, k: [f64; 2]| [y + h * k[0], v + h * k[1]];
                let first = slope([y, v]);
                let second = slope(moved(step / 2.0, first));
                let third = slope(moved(step / 2.0, second));
                let fourth = slope(moved(step, third));
                let mean = |i: usize| (first[i] + 2.0 * second[i] + 2.0 * third[i] + fourth[i]) / 6.0;
                [y, v] = moved(step, [mean(0), mean(1)]);
                time += step;
            }
            let off = -v / speed / restitution - 1.0;
            println!("r = {restitution}, m = {power}, w = {speed}: off by {off:.1e} after the time {time:.2}");
            assert!(off.abs() < 2e-11, "r = {restitution}, m = {power}, w = {speed}: {off:e}");
        }
    }
}

/// exp(−c H/D) of elastic walls: E v² = D/c, and E y² by the trapezoidal rule, which is exact for such a function. The grid is
/// within the errors that it states, 2e-6 and 2e-5.
#[test]
fn elastic_soft_walls_have_the_density_of_their_energy() {
    let density = solved(1.0, 5);
    let weight = |y: f64| (-(y * y / 2.0 + 0.3 * y.powi(4) / 4.0 + ENERGY * ((y - 1.0) / 1.5).powi(10))).exp();
    let sum = |f: &dyn Fn(f64) -> f64| (-4000..4000).map(|k| f(f64::from(k) * 1e-3)).sum::<f64>();
    let square = sum(&|y| y * y * weight(y)) / sum(&weight);
    for (exponents, truth) in [([2, 0], square), ([0, 2], 1.0)] {
        let found = density.moment(&exponents).unwrap();
        let off = (found.value - truth).abs();
        println!("E {exponents:?} = {found:.7}, off by {off:.1e}");
        assert!(off < found.error && found.error < 5e-5, "{found:.9} for {truth}");
    }
}

/// The distance from rigid walls falls like 1/m for r = 1, which is K^(−0.480) from the power 5 to 9, and more slowly with losses,
/// like K^(−0.34). The grids are right to 1e-3.
#[test]
fn soft_walls_approach_rigid_ones() {
    let distance = |restitution: f64, power: u32| {
        let density = solved(restitution, power);
        static RIGID: Shared<u64, GridDensity> = Shared::new();
        let rigid = RIGID.get(restitution.to_bits(), || {
            Grid::new().accuracy(1e-4).solve(&soft(restitution, power).rigid().unwrap()).unwrap()
        });
        let [low, high] = density.bounds()[0];
        let part = |range| compare::marginal_l1(&*density, &*rigid, 0, range).unwrap().value;
        part([low, ENDS[0]]) + part(ENDS) + part([ENDS[1], high])
    };
    for (restitution, lowest, highest) in [(1.0, -0.49, -0.47), (0.7, -0.36, -0.32)] {
        let distances = [5, 9].map(|power| distance(restitution, power));
        let stiffer = soft(restitution, 9).stiffness() / soft(restitution, 5).stiffness();
        let exponent = (distances[1] / distances[0]).ln() / stiffer.ln();
        println!("r = {restitution}: L1 {distances:?}, falls with K^{exponent:.3}");
        assert!(exponent > lowest && exponent < highest, "r = {restitution}: {distances:?}, {exponent}");
    }
}

/// The simulation, with times of its own where the walls are steep, finds the grid's moments within 4 standard errors; those of the
/// grid are right to 1e-4.
#[test]
fn the_simulation_finds_the_same_between_soft_walls() {
    let simulation = Simulation::new().time_step(0.005).burn_in(100.0).sampling_interval(1.0).samples(100_000).seed(1);
    let simulated = simulation.run(&soft(0.7, 11).problem().unwrap()).unwrap();
    assert!(simulated.provenance().warning.is_none());
    for exponents in [[2, 0], [0, 2]] {
        let [found, truth] = [&simulated as &dyn Density, &*solved(0.7, 11)].map(|d| d.moment(&exponents).unwrap());
        println!("E {exponents:?} = {found:.5}, by the grid {truth:.5}");
        assert!((found.value - truth.value).abs() < 4.0 * found.error + 1e-4, "{found:.6} and {truth:.6}");
        assert!(found.error < 0.01 * found.value);
    }
}

/// Walls in the wrong order, even powers, powers beyond the polynomials' degree, no energy.
#[test]
fn what_is_no_soft_wall_is_refused() {
    let new = |ends, restitution, power, energy| SoftWalls::new(duffing(), ends, restitution, power, energy);
    assert!(new(ENDS, 0.5, 29, 1.0).unwrap().problem().is_ok());
    for refused in [
        new([1.0, 1.0], 0.5, 5, 1.0),
        new([f64::NEG_INFINITY, 1.0], 0.5, 5, 1.0),
        new(ENDS, 0.0, 5, 1.0),
        new(ENDS, 0.5, 6, 1.0),
        new(ENDS, 0.5, 1, 1.0),
        new(ENDS, 0.5, 31, 1.0),
        new(ENDS, 0.5, 5, 0.0),
        new(ENDS, 0.5, 5, f64::NAN),
    ] {
        assert!(matches!(refused, Err(expoly::Error::OutOfRange { .. })), "{refused:?}");
    }
}
