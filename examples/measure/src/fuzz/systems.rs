//! Random systems, tame and wild, for one method each.

use super::probe::{Probe, patience};
use super::{densities, documents, motion};
use crate::draw::Draw;
use expoly::{
    Amplitude, Basis, Closure, Density, Grid, Interpretation, PoissonImpulses, Problem, Reference, Result, Scalar,
    Simulation, Splitting, System, Wall,
};
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// Seconds after which a density on a grid is ended on its way through time, where the bound on work is half an hour.
const PATIENCE: f64 = 15.0;

type Terms = Vec<(Vec<u32>, f64)>;

/// Polynomials with any coefficients.
#[derive(Clone, Debug)]
struct Wild {
    drift: Vec<Terms>,
    /// By states, then processes.
    noise: Vec<Vec<Terms>>,
    interpretation: Interpretation,
    /// Each with H by states.
    impulses: Vec<(PoissonImpulses, Vec<Terms>)>,
}

fn sum<S: Scalar>(terms: &Terms, x: &[S]) -> S {
    terms.iter().fold(S::from(0.0), |sum, (powers, c)| {
        let factors = powers.iter().zip(x).filter(|(power, _)| **power > 0);
        sum + factors.fold(S::from(*c), |product, (power, x)| product * x.powi(*power))
    })
}

impl System for Wild {
    fn dimension(&self) -> usize {
        self.drift.len()
    }
    fn processes(&self) -> usize {
        self.noise[0].len()
    }
    fn drift<S: Scalar>(&self, x: &[S]) -> Vec<S> {
        self.drift.iter().map(|terms| sum(terms, x)).collect()
    }
    fn noise<S: Scalar>(&self, x: &[S]) -> Vec<Vec<S>> {
        self.noise.iter().map(|row| row.iter().map(|terms| sum(terms, x)).collect()).collect()
    }
    fn impulses(&self) -> Vec<PoissonImpulses> {
        self.impulses.iter().map(|(impulses, _)| *impulses).collect()
    }
    fn impulse<S: Scalar>(&self, source: usize, x: &[S]) -> Vec<S> {
        self.impulses[source].1.iter().map(|terms| sum(terms, x)).collect()
    }
    fn interpretation(&self) -> Interpretation {
        self.interpretation
    }
}

/// A coefficient: as usual, of any size, or at the ends of what a number can be.
pub(super) fn coefficient(draw: &mut Draw, wild: f64) -> f64 {
    let sign = if draw.with(0.5) { 1.0 } else { -1.0 };
    sign * match draw.within(0.0, 1.0) {
        u if u < 0.02 * wild => draw.of([0.0, 1e-300, 1e150, 1e308, f64::NAN, f64::INFINITY]),
        u if u < 0.5 * wild => draw.log_within(1e-10, 1e10),
        _ => draw.log_within(0.05, 2.0),
    }
}

impl Wild {
    fn random(draw: &mut Draw) -> Self {
        let n: usize = draw.of([1, 2, 2, 2, 2, 3, 4]);
        let oscillators = n.is_multiple_of(2) && draw.with(0.8);
        let wild = draw.of([0.0, 0.0, 0.2, 1.0]);
        let confined = draw.with(0.7);
        let driven = |i: usize| !oscillators || i % 2 == 1;
        let power = |i: usize, power: u32| (0..n).map(|j| if i == j { power } else { 0 }).collect::<Vec<u32>>();
        let mut drift: Vec<Terms> = Vec::new();
        for i in 0..n {
            if !driven(i) {
                drift.push(vec![(power(i + 1, 1), 1.0)]);
                continue;
            }
            let mut terms: Terms = Vec::new();
            let highest = draw.below(8) as u32;
            for _ in 0..draw.below(5) {
                let mut powers = vec![0; n];
                (0..draw.below(highest as usize + 1)).for_each(|_| powers[draw.below(n)] += 1);
                terms.push((powers, coefficient(draw, wild)));
            }
            if confined {
                let odd = draw.of([1, 3, 3, 5, 7]).max(highest | 1);
                terms.push((power(i, 1), -coefficient(draw, wild).abs()));
                terms.push((power(if oscillators { i - 1 } else { i }, odd), -coefficient(draw, wild).abs()));
            }
            drift.push(terms);
        }
        let processes = 1 + draw.below(n);
        let noise_kind = draw.within(0.0, 1.0);
        let mut noise = vec![vec![Terms::new(); processes]; n];
        for i in (0..n).filter(|&i| driven(i) || noise_kind > 0.95) {
            for k in 0..processes {
                if noise_kind > 0.03 && draw.with(0.7) {
                    noise[i][k].push((vec![0; n], coefficient(draw, wild)));
                }
                if noise_kind > 0.75 && draw.with(0.5) {
                    noise[i][k].push((power(draw.below(n), 1 + draw.below(3) as u32), coefficient(draw, wild)));
                }
            }
        }
        let interpretation = draw.of([Interpretation::Ito, Interpretation::Stratonovich]);
        let mut system = Wild { drift, noise, interpretation, impulses: Vec::new() };
        if draw.with(0.2) {
            system.in_other_units(draw);
        }
        if draw.with(0.25) {
            system.struck(draw, wild);
        }
        system
    }

    /// Under impulses, at times without any other noise. Rates and laws without a meaning are those that the library refuses.
    fn struck(&mut self, draw: &mut Draw, wild: f64) {
        let n = self.drift.len();
        if draw.with(0.5) {
            self.noise.iter_mut().flatten().for_each(Terms::clear);
        }
        for _ in 0..=draw.below(2) {
            let mut number = || coefficient(draw, wild);
            let ([a, b], rate) = ([number(), number()], 10.0 * number().abs());
            let laws = [
                Amplitude::Normal { mean: 0.0, deviation: b.abs() },
                Amplitude::Normal { mean: a, deviation: b.abs() },
                Amplitude::Exponential { mean: a },
                Amplitude::Uniform { low: a.min(b), high: a.max(b) },
                Amplitude::TwoPoint { a, b },
                Amplitude::Laplace { mean: a, scale: b.abs() },
            ];
            let Ok(impulses) = PoissonImpulses::new(rate, draw.of(laws)) else { continue };
            let mut field = vec![Terms::new(); n];
            field[n - 1].push((vec![0; n], 1.0));
            if draw.with(0.3) {
                let mut powers = vec![0; n];
                powers[draw.below(n)] += 1 + draw.below(2) as u32;
                field[draw.below(n)].push((powers, coefficient(draw, wild)));
            }
            self.impulses.push((impulses, field));
        }
    }

    /// The same system with every state and the time in units of another size.
    fn in_other_units(&mut self, draw: &mut Draw) {
        let time = draw.log_within(1e-8, 1e8);
        let length = draw.log_within(1e-8, 1e8);
        let oscillators = self.drift.len().is_multiple_of(2);
        let unit = |i: usize| if oscillators && i % 2 == 1 { length / time } else { length };
        let scaled = |terms: &mut Terms, factor: f64| {
            for (powers, c) in terms {
                *c *= powers.iter().enumerate().fold(factor, |c, (j, power)| c / unit(j).powi(*power as i32));
            }
        };
        for (i, terms) in self.drift.iter_mut().enumerate() {
            scaled(terms, unit(i) / time);
        }
        for (i, row) in self.noise.iter_mut().enumerate() {
            row.iter_mut().for_each(|terms| scaled(terms, unit(i) / time.sqrt()));
        }
    }
}

fn wall(draw: &mut Draw, above: bool, offset: f64) -> Result<Wall> {
    let restitutions = [1.0, draw.within(0.01, 1.0), draw.within(0.5, 1.0)];
    let restitution = draw.of(restitutions);
    if above { Wall::above(offset, restitution) } else { Wall::below(offset, restitution) }
}

/// With a wall or two on a displacement, if there is one, and perhaps one between it and another.
fn walled(draw: &mut Draw, mut problem: Problem) -> Result<Problem> {
    let offsets = [0.0, draw.within(-1.0, 1.0), coefficient(draw, 1.0)];
    let offset = draw.of(offsets);
    let (above, both) = (draw.with(0.7), draw.with(0.2));
    let displacement = problem.displacements().get(draw.below(problem.displacements().len())).copied();
    let Some((state, _)) = displacement.filter(|_| draw.with(0.5)) else { return Ok(problem) };
    problem = problem.with_wall(wall(draw, above, offset)?.on(state))?;
    if both {
        let room = coefficient(draw, 0.5).abs();
        let other = if above { offset + room } else { offset - room };
        problem = problem.with_wall(wall(draw, !above, other)?.on(state))?;
    }
    let body = problem.displacements().get(draw.below(problem.displacements().len())).map(|(other, _)| *other);
    if let Some(other) = body.filter(|other| *other != state && draw.with(0.5)) {
        let masses = [(); 2].map(|()| coefficient(draw, 1.0).abs());
        let gap = coefficient(draw, 1.0);
        problem = problem.with_wall(wall(draw, true, gap)?.between([state, other], masses)?)?;
    }
    Ok(problem)
}

/// A system, how it is written, and one of the methods.
pub(super) fn probe(probe: &mut Probe) {
    let system = Wild::random(&mut probe.draw);
    probe.show(&format!("{system:#?}"));
    let Some(free) = probe.ask("Problem::of", || Problem::of(system)) else { return };
    let problem = walled(&mut probe.draw, free);
    let Some(problem) = probe.ask("with_wall", || problem) else { return };
    probe.show(&format!("{problem:#?}"));
    documents::written(probe, &problem);
    let Some(density) = solved(probe, &problem) else { return };
    densities::probe(probe, &problem, &*density);
}

fn boxed<D: Density + 'static>(density: Option<D>) -> Option<Box<dyn Density>> {
    density.map(|density| Box::new(density) as Box<dyn Density>)
}

/// The density by a method drawn by lot, with options drawn by lot.
fn solved(probe: &mut Probe, problem: &Problem) -> Option<Box<dyn Density>> {
    let n = problem.dimension();
    let draw = &mut probe.draw;
    let order = 1 + draw.below(if n > 2 { 4 } else { 6 }) as u32;
    let (usual, seed) = (draw.with(0.1), draw.below(1000) as u64);
    match draw.below(8) {
        method @ (0..=2) => {
            let closure =
                if draw.with(0.1) { Closure::adaptive(draw.log_within(1e-3, 1.0)) } else { Closure::new(order) };
            let mut closure = closure.seed(seed);
            if !usual {
                closure = closure.pilot_states(1000 + draw.below(4000)).inflation(draw.within(1.0, 10.0));
            }
            let references = [Reference::Automatic, Reference::Equations, Reference::Grid, Reference::States];
            let reference = if method == 1 { references[draw.below(4)] } else { Reference::Automatic };
            closure = closure.reference(reference);
            let density = probe.ask(&format!("{closure:?}"), || {
                // Half a minute for a reference in four states, and an adaptive closure has several.
                if n > 2 && reference == Reference::Equations {
                    Probe::may_take_longer(3.0);
                }
                closure.solve(problem)
            })?;
            probe.show(&format!("{:?}", density.provenance()));
            densities::of_closure(probe, &density, problem);
            motion::of_closure(probe, &closure, &density, problem);
            densities::slope(probe, &density, problem);
            boxed(Some(density))
        }
        3 => {
            let closure = Closure::classical(order).basis(draw.of([Basis::Classical, Basis::Folded]));
            let solution = probe.ask(&format!("{closure:?}"), || closure.solve(problem))?;
            probe.show(&format!("{:?}", solution.provenance()));
            boxed(probe.ask("density of the classical closure", || solution.density()))
        }
        4 | 5 => {
            // What two cores fill within the bound.
            let mut grid = Grid::new().memory_limit(1.0).progress(|progress| {
                if progress.time.is_some() { patience(PATIENCE) } else { ControlFlow::Continue(()) }
            });
            if !usual {
                grid = grid.degree(2 + draw.below(4)).accuracy(draw.log_within(1e-4, 0.1));
            }
            if draw.with(0.1) {
                let limits = (0..n).map(|_| [-coefficient(draw, 1.0), coefficient(draw, 1.0).abs()]);
                grid = grid.domain(limits);
            }
            let density = probe.ask(&format!("{grid:?}"), || grid.solve(problem))?;
            probe.show(&format!("{:?}", density.provenance()));
            motion::of_grid(probe, &density);
            boxed(Some(density))
        }
        6 => {
            let (samples, levels) = (1 + draw.below(20_000), [0.0, 0.3, coefficient(draw, 1.0)]);
            let mut simulation = Simulation::new().samples(samples).trajectories(2 + draw.below(200)).seed(seed);
            simulation = simulation.time_budget(Duration::from_secs(1)).levels(levels);
            if draw.with(0.2) {
                simulation = simulation.time_step(coefficient(draw, 0.5).abs());
            }
            if draw.with(0.3) {
                let [burn_in, interval] = [0; 2].map(|_| coefficient(draw, 0.5).abs());
                simulation = simulation.burn_in(burn_in).sampling_interval(interval);
            }
            if draw.with(0.2) {
                simulation = simulation.start((0..n).map(|_| coefficient(draw, 0.5)).collect::<Vec<f64>>());
            }
            if draw.with(0.2) {
                simulation = simulation.bins(draw.below(300));
            }
            let density = probe.ask("Simulation", || simulation.run(problem))?;
            probe.show(&format!("{:?}", density.provenance()));
            densities::of_simulation(probe, &density, n);
            boxed(Some(density))
        }
        _ => {
            let begin = Instant::now();
            let levels = [draw.within(0.0, 3.0), coefficient(draw, 1.0)];
            let splitting = Splitting::new().particles(2 + draw.below(60)).replicas(2 + draw.below(2)).seed(seed);
            let splitting = splitting.levels(levels).rarest(draw.log_within(1e-6, 0.5)).progress(|_| {
                if begin.elapsed().as_secs() < 2 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
            });
            let tails = probe.ask("Splitting", || splitting.run(problem))?;
            for level in levels {
                probe.value("exceedance", 0.0, || Ok(tails.exceedance(0, level)?.value));
                probe.value("marginal tail", 0.0, || Ok(tails.marginal(0, level)?.value));
                probe.value("upcrossings of the tail", 0.0, || Ok(tails.upcrossing_rate(level)?.value));
            }
            for odd in densities::ODD {
                probe.ask("exceedance of an odd level", || tails.exceedance(0, odd));
                probe.ask("non-exceedance of an odd level", || tails.non_exceedance(n, odd));
            }
            None
        }
    }
}
