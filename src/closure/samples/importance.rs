//! Integrals of exp(Q) over many states, by importance sampling on shifted lattices.

use super::SampleClosure;
use super::products::{LANES, Products, ZERO};
use super::proposal::{Proposal, Sampler};
use crate::Estimate;
use crate::closure::pilot::Pilot;
use crate::closure::symmetry::Symmetry;
use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};
use rayon::prelude::*;

/// Random shifts of the lattice: the spread between them is the standard error.
pub(super) const SHIFTS: usize = 16;
/// A section gets this part of the draws that a mean gets: a marginal is asked for at many places.
const OF_A_SECTION: usize = 8;
/// Draws that a thread takes at a time.
const BLOCK: usize = 2048;

/// Integrates exp(Q) times any function, with standard errors; the same, bit for bit, on any number of threads.
#[derive(Clone, Debug)]
pub(in crate::closure) struct ImportanceRule<const N: usize> {
    pub(super) products: Products<N>,
    pub(super) coefficients: Vec<f64>,
    pub(super) proposal: Proposal<N>,
    /// The random shifts, and what the lattice advances by from point to point, for each state.
    pub(super) shifts: [[f64; N]; SHIFTS],
    pub(super) advance: [f64; N],
    /// Blocks for each shift.
    pub(super) blocks: usize,
    /// Taken off all logarithms, so that no weight overflows.
    pub(super) shift: f64,
    pub(super) mass: Estimate,
    pub(super) effective: f64,
}

/// Σ w, Σ w², and Σ w f for each function f.
#[derive(Clone, Debug)]
struct Sums<const J: usize> {
    weight: f64,
    square: f64,
    functions: [f64; J],
}

impl<const J: usize> Sums<J> {
    const ZERO: Self = Sums { weight: 0.0, square: 0.0, functions: [0.0; J] };

    fn add(&mut self, other: &Self) {
        self.weight += other.weight;
        self.square += other.square;
        self.functions.iter_mut().zip(other.functions).for_each(|(sum, f)| *sum += f);
    }
}

impl<const N: usize> ImportanceRule<N> {
    /// A rule of about `draws` draws. `None` where the pilot's states lie on a surface, or no weight is finite.
    pub(in crate::closure) fn new(
        closure: &SampleClosure<N>,
        pilot: &Pilot<N>,
        symmetry: &Symmetry<N>,
        draws: usize,
        seed: u64,
    ) -> Option<Self> {
        let coefficients = std::iter::once(0.0).chain(closure.exponent.coefficients.iter().copied()).collect();
        let mut stream = ChaCha8Rng::seed_from_u64(seed);
        let mut rule = ImportanceRule {
            products: closure.products.clone(),
            coefficients,
            proposal: Proposal::new(pilot, symmetry)?,
            shifts: std::array::from_fn(|_| std::array::from_fn(|_| stream.random())),
            advance: square_roots(),
            blocks: draws.div_ceil(BLOCK * SHIFTS).max(1),
            shift: 0.0,
            mass: Estimate::exact(1.0),
            effective: 0.0,
        };
        let sampler = rule.proposal.sampler(&[])?;
        let mut top = f64::NEG_INFINITY;
        rule.block(&sampler, 0, 0, |_, logarithm| top = top.max(logarithm));
        rule.shift = top;
        let sums = rule.sums(&rule.proposal.sampler(&[])?, rule.blocks, |_| [0.0; 0]);
        let mut all = Sums::ZERO;
        sums.iter().for_each(|part| all.add(part));
        rule.mass = spread(&sums.each_ref().map(|part| part.weight / draws_in(rule.blocks)));
        rule.effective = all.weight * all.weight / all.square;
        (rule.mass.value.is_finite() && rule.mass.value > 0.0).then_some(rule)
    }

    /// ln ∫ exp(Q) dx over the trusted part of the state space.
    pub(in crate::closure) fn log_mass(&self) -> Estimate {
        Estimate::new(self.mass.value.ln() + self.shift, self.mass.error / self.mass.value)
    }

    /// How many independent draws from the density itself would do as well.
    pub(in crate::closure) fn effective(&self) -> f64 {
        self.effective
    }

    /// Whether the density is defined at a state.
    pub(in crate::closure) fn trusts(&self, x: &[f64; N]) -> bool {
        self.proposal.trusts(x)
    }

    /// The means of functions.
    pub(in crate::closure) fn means<const J: usize>(
        &self,
        functions: impl Fn(&[f64; N]) -> [f64; J] + Sync,
    ) -> Option<[Estimate; J]> {
        let sums = self.sums(&self.proposal.sampler(&[])?, self.blocks, functions);
        Some(std::array::from_fn(|j| spread(&sums.each_ref().map(|part| part.functions[j] / part.weight))))
    }

    /// All trusted draws with their weights.
    pub(in crate::closure) fn drawn(&self) -> Option<Vec<([f64; N], f64)>> {
        let sampler = self.proposal.sampler(&[])?;
        let blocks = (0..SHIFTS * self.blocks).into_par_iter().map(|task| {
            let mut drawn = Vec::with_capacity(BLOCK);
            let keep = |x: &[f64; N], logarithm: f64| drawn.push((*x, (logarithm - self.shift).exp()));
            self.block(&sampler, task / self.blocks, task % self.blocks, keep);
            drawn
        });
        Some(blocks.collect::<Vec<_>>().concat())
    }

    /// ∫ f p dx over all other states, those of `held` at their values: the marginal density where f = 1, the flux through
    /// a level where f is a power of the velocity.
    pub(in crate::closure) fn section<const J: usize>(
        &self,
        held: &[(usize, f64)],
        functions: impl Fn(&[f64; N]) -> [f64; J] + Sync,
    ) -> Option<[Estimate; J]> {
        let blocks = self.blocks.div_ceil(OF_A_SECTION);
        let sums = self.sums(&self.proposal.sampler(held)?, blocks, functions);
        let relative = self.mass.error / self.mass.value;
        Some(std::array::from_fn(|j| {
            let integral = spread(&sums.each_ref().map(|part| part.functions[j] / draws_in(blocks)));
            let value = integral.value / self.mass.value;
            Estimate::new(value, (integral.error / self.mass.value).hypot(value * relative))
        }))
    }

    /// The sums for each shift, of some of its blocks.
    fn sums<const J: usize>(
        &self,
        sampler: &Sampler<'_, N>,
        blocks: usize,
        functions: impl Fn(&[f64; N]) -> [f64; J] + Sync,
    ) -> [Sums<J>; SHIFTS] {
        let parts: Vec<Sums<J>> = (0..SHIFTS * blocks)
            .into_par_iter()
            .map(|task| {
                let mut sums = Sums::ZERO;
                self.block(sampler, task / blocks, task % blocks, |x, logarithm| {
                    let w = (logarithm - self.shift).exp();
                    sums.weight += w;
                    sums.square += w * w;
                    sums.functions.iter_mut().zip(functions(x)).for_each(|(sum, f)| *sum += w * f);
                });
                sums
            })
            .collect();
        std::array::from_fn(|shift| {
            let mut total = Sums::ZERO;
            parts[shift * blocks..(shift + 1) * blocks].iter().for_each(|part| total.add(part));
            total
        })
    }

    /// The trusted draws of one block, each with the logarithm of its weight.
    fn block(&self, sampler: &Sampler<'_, N>, shift: usize, block: usize, mut each: impl FnMut(&[f64; N], f64)) {
        let mut scratch = self.products.scratch();
        let mut group: Vec<([f64; N], f64)> = Vec::with_capacity(LANES);
        let mut flush = |group: &mut Vec<([f64; N], f64)>| {
            let mut x = [ZERO; N];
            for (l, (point, _)) in group.iter().enumerate() {
                (0..N).for_each(|i| x[i][l] = point[i]);
            }
            self.products.place(&x, &mut scratch);
            let q = self.products.sum(&self.coefficients, &scratch);
            for (l, (point, logarithm)) in group.iter().enumerate() {
                each(point, q[l] - logarithm);
            }
            group.clear();
        };
        for k in block * BLOCK..(block + 1) * BLOCK {
            let normals =
                std::array::from_fn(|i| normal_quantile((self.shifts[shift][i] + k as f64 * self.advance[i]).fract()));
            group.extend(sampler.draw(normals));
            if group.len() == LANES {
                flush(&mut group);
            }
        }
        flush(&mut group);
    }
}

/// Draws in a number of blocks.
fn draws_in(blocks: usize) -> f64 {
    (blocks * BLOCK) as f64
}

/// The mean of independent values, and its standard error.
fn spread(values: &[f64; SHIFTS]) -> Estimate {
    let count = SHIFTS as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (count - 1.0);
    Estimate::new(mean, (variance / count).sqrt())
}

/// The square roots of the first primes: no combination of them with small whole numbers is a whole number, so that their
/// multiples fill the unit cube evenly.
pub(super) fn square_roots<const N: usize>() -> [f64; N] {
    let mut primes = (2_u32..).filter(|n| (2..*n).take_while(|d| d * d <= *n).all(|d| n % d != 0));
    std::array::from_fn(|_| primes.next().map_or(0.5, |p| f64::from(p).sqrt().fract()))
}

/// The inverse of the normal distribution, by Acklam's rational approximations: nine digits.
fn normal_quantile(p: f64) -> f64 {
    const A: [f64; 6] = [
        -39.69683028665376,
        220.9460984245205,
        -275.9285104469687,
        138.357751867269,
        -30.66479806614716,
        2.506628277459239,
    ];
    const B: [f64; 6] =
        [-54.47609879822406, 161.5858368580409, -155.6989798598866, 66.80131188771972, -13.28068155288572, 1.0];
    const C: [f64; 6] = [
        -0.007784894002430293,
        -0.3223964580411365,
        -2.400758277161838,
        -2.549732539343734,
        4.374664141464968,
        2.938163982698783,
    ];
    const D: [f64; 5] = [0.007784695709041462, 0.3224671290700398, 2.445134137142996, 3.754408661907416, 1.0];
    const TAIL: f64 = 0.02425;
    let horner = |c: &[f64], t: f64| c.iter().fold(0.0, |sum, c| sum * t + c);
    let tail = |p: f64| {
        let q = (-2.0 * p.max(f64::MIN_POSITIVE).ln()).sqrt();
        horner(&C, q) / horner(&D, q)
    };
    if p < TAIL {
        tail(p)
    } else if p > 1.0 - TAIL {
        -tail(1.0 - p)
    } else {
        let q = p - 0.5;
        q * horner(&A, q * q) / horner(&B, q * q)
    }
}
