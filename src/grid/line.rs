//! One state without impulses: p = (C/B) exp(∫ 2f/B dx), without a flux of probability.

use super::field::GridField;
use super::mesh::{Mesh, Side};
use super::refinement::refined;
use super::shape::{MOST, Shape};
use super::tree::Tree;
use crate::error::{Error, Result};
use crate::grid::{HALVINGS, ROUNDS};
use crate::numerics::{Rule, eigenvalues, sort_by_number};
use crate::polynomial::Polynomial;
use crate::problem::Problem;
use crate::states::States;
use nalgebra::DMatrix;
use std::sync::Arc;

/// Nodes of the Gauss rule for the exponent ∫ 2f/B dx of a density of one state over a step.
const NODES: usize = 20;
/// The first step along the line of a single state, over the standard deviation of the pilot's states.
const STEP: f64 = 0.1;
/// The share of the distance from where the steps along a line began that adds to the standard deviation which a step is in
/// proportion to.
const GROWTH: f64 = 0.5;
/// The most steps along a line to one side of where they began: with their growth they reach over a hundred powers of ten.
const STEPS: usize = 4000;
/// The density of one state has ended where the logarithm of what is left has fallen by so much below its highest value: to
/// 1e-26 of it.
const DEPTH: f64 = 60.0;
/// A mesh of one state is fine enough for the closed form where so much is left in the highest degree of all cells together,
/// in L¹.
const RESOLVED: f64 = 1e-13;
/// What is left in the highest degree of the closed form of one state where its mesh is fine enough, over the largest
/// exponent: p has the rounding of that.
const ROUNDING: f64 = 1e-15;

/// The logarithm of an unnormalised density.
#[derive(Clone, Debug)]
pub(super) struct Line {
    drift: Polynomial,
    diffusion: Polynomial,
    rule: Rule,
    /// Where the noise vanishes below and above, or an end reflects the motion: nothing passes there.
    ends: [Option<f64>; 2],
    reflects: [bool; 2],
    /// Where the drift has a kink or a jump.
    surfaces: Vec<f64>,
    /// Places, rising, and ∫ 2f/B up to them.
    steps: Vec<[f64; 2]>,
}

impl Line {
    /// Of a problem of one state, as far as the density reaches from a place `inside` it.
    ///
    /// # Errors
    /// [`Error::NotResolved`] where the density does not fall.
    pub(super) fn new(problem: &Problem, inside: f64, scale: f64) -> Result<Self> {
        let operator = problem.operator();
        let (drift, diffusion) = (operator.drift()[0].clone(), operator.diffusion()[0][0].clone());
        let (zeros, reflecting) = (zeros(&diffusion), problem.end_limits(0));
        let ends = [0, 1].map(|side| {
            let sign = [-1.0, 1.0][side];
            let beyond = zeros.iter().copied().filter(|zero| sign * (zero - inside) > 0.0).chain(reflecting[side]);
            beyond.min_by(|a, b| (a - inside).abs().total_cmp(&(b - inside).abs()))
        });
        let reflects = [0, 1].map(|side| ends[side].is_some() && ends[side] == reflecting[side]);
        let surfaces = problem.surfaces().iter().map(|surface| surface.place).collect();
        let (rule, steps) = (Rule::legendre(NODES), vec![[inside, 0.0]]);
        let mut line = Line { drift, diffusion, rule, ends, reflects, surfaces, steps };
        line.extend(-1.0, scale, ends[0])?;
        line.extend(1.0, scale, ends[1])?;
        sort_by_number(&mut line.steps, |step| step[0]);
        Ok(line)
    }

    /// Goes on to one side until next to nothing is left.
    fn extend(&mut self, side: f64, scale: f64, end: Option<f64>) -> Result<()> {
        let [start, mut sum] = self.steps[0];
        let (mut x, mut highest) = (start, self.log(start, 0.0));
        for _ in 0..STEPS {
            let length = STEP * (scale + GROWTH * (x - start).abs());
            let reflects = self.reflects[usize::from(side > 0.0)];
            let share = if reflects { 1.0 } else { 0.5 };
            let length = end.map_or(length, |end| length.min((end - x).abs() * share));
            // No step goes across a kink.
            let beyond = self.surfaces.iter().map(|place| side * (place - x)).filter(|distance| *distance > 0.0);
            let length = beyond.fold(length, f64::min);
            let next = x + side * length;
            sum += self.integral(x, next);
            x = next;
            self.steps.push([x, sum]);
            let log = self.log(x, sum);
            highest = highest.max(log);
            let left = end.map_or((x - start).abs(), |end| (end - x).abs());
            if reflects && left <= f64::EPSILON * end.unwrap_or(0.0).abs() {
                return Ok(());
            }
            if log + left.ln() < highest + scale.ln() - DEPTH {
                return Ok(());
            }
        }
        let towards = if side > 0.0 { "above" } else { "below" };
        let reason = format!("p = (C/B) exp(∫ 2f/B dx) does not end {towards} {start:.3}: it cannot be normalised");
        Err(Error::NotResolved { estimate: f64::INFINITY, reason })
    }

    /// A warning where trajectories went on both sides of a place at which the noise vanishes: each side has a density of its own.
    pub(super) fn parted(&self, states: &States) -> Option<String> {
        let beyond = |side: usize, end: f64| {
            let count = states.iter().filter(|x| if side == 0 { x[0] < end } else { x[0] > end }).count();
            let (own, other) = if side == 0 { ("above", "below") } else { ("below", "above") };
            let share = 100.0 * count as f64 / states.len() as f64;
            (count > 0).then(|| {
                format!(
                    "the noise vanishes at {end:.6}: this is the density {own}; {share:.0} % of the trajectories' states are {other}"
                )
            })
        };
        (0..2).filter_map(|side| beyond(side, self.ends[side]?)).reduce(|first, second| format!("{first}; {second}"))
    }

    fn integral(&self, from: f64, to: f64) -> f64 {
        let rate = |x: f64| 2.0 * self.drift.evaluate(&[x]) / self.diffusion.evaluate(&[x]);
        self.rule.on(from, to).iter().map(|(x, weight)| weight * rate(x)).sum()
    }

    fn log(&self, x: f64, sum: f64) -> f64 {
        sum - self.diffusion.evaluate(&[x]).ln()
    }

    /// ln p but for a constant.
    fn value(&self, x: f64) -> f64 {
        let next = self.steps.partition_point(|[at, _]| *at <= x).clamp(1, self.steps.len()) - 1;
        let [at, sum] = self.steps[next];
        self.log(x, sum + self.integral(at, x))
    }

    /// The limits, and the density on a mesh that resolves it to rounding.
    pub(super) fn resolved(&self, degree: usize) -> GridField {
        let (low, high) = (self.steps[0][0], self.steps[self.steps.len() - 1][0]);
        let highest = self.steps.iter().map(|[x, sum]| self.log(*x, *sum)).fold(f64::NEG_INFINITY, f64::max);
        let inner = self.surfaces.iter().copied().filter(|place| low < *place && *place < high);
        let mut lines: Vec<f64> = inner.chain([low, high]).collect();
        sort_by_number(&mut lines, |place| *place);
        let mut tree = Tree::new(&[lines]);
        for _ in 0..HALVINGS[0] {
            tree.leaves().iter().for_each(|leaf| {
                tree.halve(*leaf, 0);
            });
        }
        let sides = self.reflects.map(|reflects| if reflects { Side::Closed } else { Side::Open });
        let mut mesh = Mesh::new([0.0; MOST], tree, sides);
        let shape = Shape { states: 1, degree };
        // exp of a sum has the sum's rounding: no mesh takes it away.
        let largest = self.steps.iter().map(|[_, sum]| sum.abs()).fold(0.0, f64::max);
        let resolved = RESOLVED.max(ROUNDING * largest);
        for _ in 0..ROUNDS {
            let field = self.normalised(mesh, shape, highest);
            match refined(&field.mesh, &field.highest(), resolved) {
                Some(finer) => mesh = finer,
                None => return field,
            }
        }
        self.normalised(mesh, shape, highest)
    }

    fn normalised(&self, mesh: Mesh, shape: Shape, highest: f64) -> GridField {
        let field = GridField::projected(&Arc::new(mesh), shape, |x| (self.value(x[0]) - highest).exp());
        field.times(field.mass().recip())
    }
}

/// The real zeros of a polynomial of one state.
fn zeros(p: &Polynomial) -> Vec<f64> {
    if !p.is_plain() {
        return Vec::new();
    }
    let degree = p.degree() as usize;
    let leading = p.coefficient(&[degree as u32]);
    if degree == 0 {
        return Vec::new();
    }
    let companion = DMatrix::from_fn(degree, degree, |i, j| {
        if j + 1 == degree { -p.coefficient(&[i as u32]) / leading } else { f64::from(u8::from(i == j + 1)) }
    });
    let all = eigenvalues(companion).unwrap_or_default();
    let size = all.iter().map(|zero| zero.norm()).fold(0.0, f64::max);
    // B is a square or a sum of squares: its real zeros are double, and rounding parts them by its root.
    all.iter().filter(|zero| zero.im.abs() <= 1e-6 * size.max(f64::MIN_POSITIVE)).map(|zero| zero.re).collect()
}
