//! Integrals of exp(Q) over many states, by importance sampling on shifted lattices.

use super::copula::{Copula, Sampler};
use super::nest::Nest;
use super::nest_domain::NestedSampler;
use super::nodes::SampleNodes;
use super::shifts::{BLOCK, SHIFTS, Shifts, each_draw};
use crate::closure::density::exponent::Exponent;
use crate::closure::space::sweep::Function;
use crate::error::Result;
use crate::estimate::Estimate;
use crate::functions::Scratch;
use crate::numerics::{EIGHT, Eight, exponentials};
use crate::parallel;
use crate::record::{Read, positive, states};
use crate::states::States;
use serde::{Deserialize, Serialize};

/// The factor by which a section of a density has fewer draws than a mean: a marginal is computed at many places.
const OF_A_SECTION: usize = 8;

/// Integrates exp(Q) times any function, with standard errors; the same, bit for bit, on any number of threads.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ImportanceRule {
    /// The density that the draws come from, with its trust domain.
    pub(crate) copula: Copula,
    /// The nested nodes in whose domain draws are made instead, where a state nearly follows the others.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    nest: Option<Nest>,
    shifts: Shifts,
    /// Taken off all logarithms, so that no weight overflows.
    shift: f64,
    /// ∫ exp(Q − shift) dx over the trust domain, and its standard error.
    mass: [f64; 2],
    effective: f64,
    #[serde(skip)]
    exponent: Exponent,
}

/// Draws from a copula, or in the domain of nested nodes.
enum Draws<'a> {
    Copula(Sampler<'a>),
    Nested(NestedSampler<'a>),
}

impl Draws<'_> {
    fn draw(&self, u: &mut [f64], x: &mut [f64]) -> Option<f64> {
        match self {
            Draws::Copula(sampler) => sampler.draw(u, x),
            Draws::Nested(sampler) => sampler.draw(u, x),
        }
    }
}

/// Σ w, Σ w² and Σ w g.
type WeightSums = [f64; 3];

fn added(sum: WeightSums, part: &WeightSums) -> WeightSums {
    [0, 1, 2].map(|k| sum[k] + part[k])
}

impl ImportanceRule {
    /// A rule of about `draws` draws for this Q. None where no weight is finite.
    pub(in crate::closure) fn new(exponent: &Exponent, copula: &Copula, draws: usize, seed: u64) -> Option<Self> {
        Self::within(None, exponent, copula, draws, seed)
    }

    /// The same in the domain of nested nodes, where there are any.
    pub(in crate::closure) fn within(
        nest: Option<Nest>,
        exponent: &Exponent,
        copula: &Copula,
        draws: usize,
        seed: u64,
    ) -> Option<Self> {
        let mut rule = ImportanceRule {
            copula: copula.clone(),
            nest,
            shifts: Shifts::new(copula.knots.len(), draws, seed),
            shift: 0.0,
            mass: [1.0, 0.0],
            effective: 0.0,
            exponent: without_constant(exponent),
        };
        let mut top = f64::NEG_INFINITY;
        rule.block(&rule.sampler(&[]).ok()?, 0, |_, logarithm| top = top.max(logarithm));
        rule.shift = top;
        let blocks = rule.shifts.blocks;
        let sums = rule.sums(&[], blocks, &|_| 0.0).ok()?;
        let mass = spread(sums.iter().map(|part| part[0] / draws_in(blocks)));
        let [weight, square, _] = sums.iter().fold([0.0; 3], added);
        rule.mass = [mass.value, mass.error];
        rule.effective = weight * weight / square;
        (mass.value.is_finite() && mass.value > 0.0).then_some(rule)
    }

    /// The same for this Q, if its numbers have a meaning.
    pub(in crate::closure) fn checked(self, exponent: &Exponent) -> Read<Self> {
        let n = exponent.space.dimension();
        let shifts = self.shifts.checked(n)?;
        states("the shift of the weights", &[self.shift], 1)?;
        states("the mass", &self.mass, 2)?;
        positive("the mass", self.mass[0])?;
        positive("the number of effective draws", self.effective)?;
        let copula = self.copula.checked(n)?;
        let nest = self.nest.map(|nest| nest.checked(n, &copula)).transpose()?;
        Ok(ImportanceRule { copula, nest, shifts, exponent: without_constant(exponent), ..self })
    }

    /// Draws of all states but those given.
    fn sampler(&self, given: &[(usize, f64)]) -> Result<Draws<'_>> {
        Ok(match &self.nest {
            Some(nest) => Draws::Nested(nest.sampler(given)?),
            None => Draws::Copula(self.copula.sampler(given)?),
        })
    }

    /// The nested nodes, if there are any.
    pub(in crate::closure) fn nest(&self) -> Option<&Nest> {
        self.nest.as_ref()
    }

    /// ln ∫ exp(Q) dx over the trust domain.
    pub(in crate::closure) fn log_mass(&self) -> Estimate {
        let [mass, error] = self.mass;
        Estimate::new(mass.ln() + self.shift, error / mass)
    }

    /// The same with a more accurate value of ln ∫ exp(Q) dx.
    pub(in crate::closure) fn with_log_mass(self, log_mass: Estimate) -> Self {
        let mass = (log_mass.value - self.shift).exp();
        ImportanceRule { mass: [mass, mass * log_mass.error], ..self }
    }

    /// The number of independent draws from the density itself that would do as well.
    pub(in crate::closure) fn effective(&self) -> f64 {
        self.effective
    }

    /// Whether the density is defined at a state.
    pub(in crate::closure) fn trusts(&self, x: &[f64]) -> bool {
        self.is_room(x) && self.nest.as_ref().map_or_else(|| self.copula.trusts(x), |nest| nest.contains(x))
    }

    /// Whether a state is on the side of the motion at every wall.
    fn is_room(&self, x: &[f64]) -> bool {
        self.exponent.space.corners().iter().all(|corner| corner.gap(x) >= 0.0)
    }

    /// The mean of a function.
    pub(in crate::closure) fn mean(&self, g: &(dyn Fn(&[f64]) -> f64 + Sync)) -> Result<Estimate> {
        let sums = self.sums(&[], self.shifts.blocks, g)?;
        Ok(spread(sums.iter().map(|part| part[2] / part[0])))
    }

    /// All draws in the trust domain with their weights.
    pub(in crate::closure) fn drawn(&self) -> Result<(States, Vec<f64>)> {
        let SampleNodes { points, base: mut weights, .. } = self.nodes()?;
        let shift = self.shift - (self.shifts.count() as f64).ln();
        weights.iter_mut().for_each(|w| *w -= shift);
        exponentials(&mut weights);
        Ok((points, weights))
    }

    /// The same as nodes, each shift a part of them.
    pub(in crate::closure) fn nodes(&self) -> Result<SampleNodes> {
        let n = self.exponent.space.dimension();
        let sampler = self.sampler(&[])?;
        let scale = (self.shifts.count() as f64).ln();
        let blocks = parallel::map(self.shifts.blocks_in_all(), |block| {
            let (mut values, mut base) = (Vec::with_capacity(BLOCK * n), Vec::with_capacity(BLOCK));
            self.block(&sampler, block, |x, logarithm| {
                values.extend_from_slice(x);
                base.push(logarithm - scale);
            });
            (values, base)
        });
        let (values, base): (Vec<Vec<f64>>, Vec<Vec<f64>>) = blocks.into_iter().unzip();
        let mut parts = Vec::with_capacity(SHIFTS);
        for blocks in base.chunks(self.shifts.blocks) {
            parts.push(parts.last().unwrap_or(&0) + blocks.iter().map(Vec::len).sum::<usize>());
        }
        Ok(SampleNodes {
            points: States::from_values(n, values.concat()),
            base: base.concat(),
            parts,
            odd: Vec::new(),
            thin: false,
        })
    }

    /// ∫ g p dx over all other states, those of `held` at their values: the marginal density where g = 1, the flux through
    /// a level where g is a power of the velocity.
    pub(in crate::closure) fn section(
        &self,
        held: &[(usize, f64)],
        g: &(dyn Fn(&[f64]) -> f64 + Sync),
    ) -> Result<Estimate> {
        let blocks = self.shifts.blocks.div_ceil(OF_A_SECTION);
        let sums = self.sums(held, blocks, g)?;
        let [mass, error] = self.mass;
        let integral = spread(sums.iter().map(|part| part[2] / draws_in(blocks)));
        let value = integral.value / mass;
        Ok(Estimate::new(value, (integral.error / mass).hypot(value * (error / mass))))
    }

    /// The sums for each shift, of some of its blocks, with some states held.
    fn sums(
        &self,
        held: &[(usize, f64)],
        blocks: usize,
        g: &(dyn Fn(&[f64]) -> f64 + Sync),
    ) -> Result<Vec<WeightSums>> {
        let sampler = self.sampler(held)?;
        let part = |task: usize| {
            let mut sums = [0.0; 3];
            self.block(&sampler, task / blocks * self.shifts.blocks + task % blocks, |x, logarithm| {
                let w = (logarithm - self.shift).exp();
                sums = added(sums, &[w, w * w, w * g(x)]);
            });
            sums
        };
        let parts = parallel::map(SHIFTS * blocks, part);
        Ok(parts.chunks(blocks).map(|parts| parts.iter().fold([0.0; 3], added)).collect())
    }

    /// The draws of one of all blocks in the trust domain, each with the logarithm of its weight.
    fn block(&self, sampler: &Draws<'_>, block: usize, mut each: impl FnMut(&[f64], f64)) {
        let n = self.exponent.space.dimension();
        let mut scratch = Scratch::default();
        let mut lanes = vec![Eight::ZERO; n];
        let (mut points, mut logarithms) = (vec![0.0; EIGHT * n], [0.0; EIGHT]);
        let mut flush = |points: &[f64], logarithms: &[f64]| {
            lanes.fill(Eight::ZERO);
            for (l, point) in points.chunks_exact(n).enumerate() {
                lanes.iter_mut().zip(point).for_each(|(lane, x)| lane[l] = *x);
            }
            let q = self.exponent.at(&lanes, &mut scratch);
            for ((point, logarithm), q) in points.chunks_exact(n).zip(logarithms).zip(q.0) {
                each(point, q - logarithm);
            }
        };
        let mut filled = 0;
        each_draw(&|u, x| sampler.draw(u, x), &self.shifts, block, |x, logarithm| {
            if !self.is_room(x) {
                return;
            }
            points[filled * n..(filled + 1) * n].copy_from_slice(x);
            logarithms[filled] = logarithm;
            filled += 1;
            if filled == EIGHT {
                flush(&points, &logarithms);
                filled = 0;
            }
        });
        flush(&points[..filled * n], &logarithms[..filled]);
    }
}

/// Q, which the constant of a normalised density is no part of.
fn without_constant(exponent: &Exponent) -> Exponent {
    Exponent { constant: 0.0, ..exponent.clone() }
}

/// Draws in a number of blocks.
fn draws_in(blocks: usize) -> f64 {
    (blocks * BLOCK) as f64
}

/// The mean of independent values, and its standard error.
fn spread(values: impl Iterator<Item = f64>) -> Estimate {
    let values: Vec<f64> = values.collect();
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (count - 1.0);
    Estimate::new(mean, (variance / count).sqrt())
}
