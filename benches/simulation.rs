//! Path-steps per second on one thread, beside a plain loop over the same scheme, one trajectory at a time, and beside the
//! cost of the random numbers alone, one normal number for each path-step.
#![allow(missing_docs, clippy::unwrap_used)]

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use expoly::{Barrier, Simulation, models::Duffing};
use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};
use rand_distr::StandardNormal;
use std::hint::black_box;

#[allow(dead_code, unused_imports)]
#[path = "../src/simulation/normal.rs"]
mod normal;
#[allow(dead_code, unused_imports)]
#[path = "../src/simulation/random.rs"]
mod random;

const STEP: f64 = 0.02;
/// Time steps between samples, samples in all, trajectories: a few million path-steps, of which the burn-in is a tenth.
const INTERVAL: usize = 50;
const SAMPLES: usize = 65_536;
const TRAJECTORIES: usize = 1024;
const BURN_IN: usize = 640;

/// Half drift, kick, half drift by hand for y″ + c y′ + k y + μ y³ = ξ, with the moments that a user would write down.
fn plain_loop(parameters: [f64; 4], wall: Option<(f64, f64)>) -> [f64; 3] {
    let [c, k, mu, d] = parameters;
    let force = |x: f64, v: f64| -(c * v + k * x + mu * x * x * x);
    let flow = |x: f64, v: f64| v + STEP / 2.0 * force(x, v + STEP / 4.0 * force(x, v));
    let drift = |x: &mut f64, v: &mut f64, tau: f64, impacts: &mut f64| {
        let end = *x + tau * *v;
        match wall {
            Some((b, r)) if end < b => {
                let rest = (tau - (*x - b) / -*v).max(0.0);
                *v *= -r;
                *x = b + *v * rest;
                *impacts += 1.0;
            }
            _ => *x = end,
        }
    };
    let amplitude = (2.0 * d * STEP).sqrt();
    let mut sums = [0.0; 3];
    for i in 0..TRAJECTORIES {
        let mut stream = ChaCha8Rng::seed_from_u64(1);
        stream.set_stream(i as u64);
        let (mut x, mut v) = (wall.map_or(0.0, |(b, _)| b) + 0.1, 0.0);
        for step in 1..=BURN_IN + SAMPLES / TRAJECTORIES * INTERVAL {
            drift(&mut x, &mut v, STEP / 2.0, &mut sums[2]);
            v = flow(x, v);
            v += amplitude * stream.sample::<f64, _>(StandardNormal);
            v = flow(x, v);
            drift(&mut x, &mut v, STEP / 2.0, &mut sums[2]);
            if step > BURN_IN && step % INTERVAL == 0 {
                sums[0] += x * x;
                sums[1] += v * v;
            }
        }
    }
    sums
}

/// The normal numbers that a simulation without a wall takes, in groups of lanes as it takes them.
struct Numbers {
    random: random::Random,
    pairs: u64,
}

const LANES: usize = 16;

impl pulp::NullaryFnOnce for Numbers {
    type Output = f64;

    #[inline(always)]
    fn call(self) -> f64 {
        let mut sums = [0.0; LANES];
        for place in 0..self.pairs {
            let mut numbers = [[0.0; LANES]; 2];
            for l in 0..LANES {
                [numbers[0][l], numbers[1][l]] = self.random.normals(l as u64, 0, place);
            }
            for l in 0..LANES {
                sums[l] += numbers[0][l] + numbers[1][l];
            }
        }
        sums.iter().sum()
    }
}

fn random_numbers(seed: u64) -> f64 {
    let pairs = (TRAJECTORIES * BURN_IN + SAMPLES * INTERVAL) / (2 * LANES);
    pulp::Arch::new().dispatch(Numbers { random: random::Random::new(seed), pairs: pairs as u64 })
}

fn simulation(c: &mut Criterion) {
    let oscillator = Duffing::new(0.2, 1.0, 0.3, 0.2).unwrap();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let mut group = c.benchmark_group("path-steps");
    group.throughput(Throughput::Elements((TRAJECTORIES * BURN_IN + SAMPLES * INTERVAL) as u64));
    for (name, wall) in [("no wall", None), ("elastic wall", Some((0.0, 1.0))), ("wall r = 0.9", Some((0.0, 0.9)))] {
        group.bench_function(BenchmarkId::new("plain loop", name), |b| {
            b.iter(|| plain_loop(black_box([0.2, 1.0, 0.3, 0.2]), wall));
        });
        let run = || {
            let simulation = Simulation::new(&oscillator)
                .trajectories(TRAJECTORIES)
                .samples(SAMPLES)
                .time_step(STEP)
                .burn_in(BURN_IN as f64 * STEP)
                .sampling_interval(INTERVAL as f64 * STEP);
            match wall {
                Some((offset, r)) => simulation.barrier(Barrier::new(offset, r).unwrap()).run().unwrap(),
                None => simulation.run().unwrap(),
            }
        };
        group.bench_function(BenchmarkId::new("simulation", name), |b| b.iter(|| pool.install(run)));
    }
    group.bench_function("random numbers alone", |b| b.iter(|| random_numbers(black_box(1))));
    group.finish();
}

criterion_group! { name = benches; config = Criterion::default().sample_size(20); targets = simulation }
criterion_main!(benches);
