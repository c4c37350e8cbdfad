//! Both closures from the system to its density, per order; order 2 of the classical one is the baseline of each group.

use criterion::{Criterion, criterion_group, criterion_main};
use expoly::models::{CubicDamping, Duffing, DuffingChain};
use expoly::{Barrier, Basis, Closure};
use std::hint::black_box;

fn whole_space(criterion: &mut Criterion) {
    let (Ok(exact), Ok(inexact)) = (Duffing::new(0.2, 1.0, 0.3, 0.2), CubicDamping::new([0.1, 0.3], 1.0, 1.0, 0.5))
    else {
        return;
    };
    let mut group = criterion.benchmark_group("two states");
    for order in [2, 4, 6, 8] {
        let closure = Closure::classical(order);
        group.bench_function(format!("Duffing, n = {order}"), |b| b.iter(|| closure.solve(black_box(&exact))));
        group.bench_function(format!("cubic damping, n = {order}"), |b| b.iter(|| closure.solve(black_box(&inexact))));
    }
    group.finish();
}

fn wall(criterion: &mut Criterion) {
    let (Ok(duffing), Ok(wall)) = (Duffing::new(0.2, 1.0, 0.3, 0.2), Barrier::new(-0.5, 0.95)) else { return };
    let mut group = criterion.benchmark_group("two states and a wall");
    for basis in [Basis::Classical, Basis::Folded] {
        for order in [2, 4, 6] {
            let closure = Closure::classical(order).with_basis(basis);
            group.bench_function(format!("{basis}, n = {order}"), |b| {
                b.iter(|| closure.solve_with_wall(black_box(&duffing), wall));
            });
        }
    }
    group.finish();
}

fn robust(criterion: &mut Criterion) {
    let Ok(inexact) = CubicDamping::new([0.1, 0.3], 1.0, 1.0, 0.5) else { return };
    let (Ok(duffing), Ok(wall)) = (Duffing::new(0.2, 1.0, 0.3, 0.2), Barrier::new(-0.5, 0.95)) else { return };
    let Ok(chain) = DuffingChain::new([0.2, 0.4], 1.0, 0.3, 0.5, 0.8) else { return };
    let mut group = criterion.benchmark_group("robust, pilot included");
    group.sample_size(10);
    group.bench_function("classical, n = 2", |b| b.iter(|| Closure::classical(2).solve(black_box(&inexact))));
    for order in [4, 8, 12] {
        let closure = Closure::new(order);
        group.bench_function(format!("two states, n = {order}"), |b| b.iter(|| closure.solve(black_box(&inexact))));
    }
    group.bench_function("a wall, n = 8", |b| b.iter(|| Closure::new(8).solve_with_wall(black_box(&duffing), wall)));
    group.bench_function("4 states, n = 4", |b| b.iter(|| Closure::new(4).solve(black_box(&chain))));
    group.finish();
}

fn more_states(criterion: &mut Criterion) {
    let Ok(chain) = DuffingChain::new([0.2, 0.4], 1.0, 0.3, 0.5, 0.8) else { return };
    let Ok(long) = DuffingChain::new([0.2, 0.4, 0.3], 1.0, 0.3, 0.5, 0.8) else { return };
    let mut group = criterion.benchmark_group("more states");
    group.sample_size(20);
    for order in [2, 4] {
        let closure = Closure::classical(order);
        group.bench_function(format!("4 states, n = {order}"), |b| b.iter(|| closure.solve(black_box(&chain))));
        group.bench_function(format!("6 states, n = {order}"), |b| b.iter(|| closure.solve(black_box(&long))));
    }
    group.finish();
}

criterion_group!(benches, whole_space, wall, robust, more_states);
criterion_main!(benches);
