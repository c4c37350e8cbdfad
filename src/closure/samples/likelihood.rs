//! The most likely exponential polynomial with given means, by integrals over draws.

use super::products::{LANES, Lane, Products, Scratch, ZERO};
use super::sites::Sites;
use crate::problem::Problem;
use crate::states::States;
use faer::linalg::matmul::matmul;
use faer::linalg::solvers::Solve;
use faer::{Accum, Mat, Par, Side};
use rayon::prelude::*;

/// Draws in a block: its tables stay in a core's cache.
const BLOCK: usize = 512;
/// Matrices that are summed side by side hold about so many numbers together.
const ROOM: usize = 30_000_000;
/// With more functions than this every fourth draw makes the curvature; all make the gradient.
const MANY: usize = 400;
const EVERY: usize = 4;
/// Newton's longest step, in standard deviations of ln p.
const LONGEST: f64 = 1.0;
/// Added to the curvature, relative to its mean diagonal entry.
const RIDGE: f64 = 1e-10;
/// A curvature serves the next steps too while they fall to this part of one another.
const FALLING: f64 = 0.3;
/// The size of the residual, relative to its parts, at which the Fokker-Planck equation is solved; what must follow from
/// step to step; and the steps at most.
const SOLVED: f64 = 1e-9;
const HALVED: f64 = 0.5;
const POLISHES: usize = 12;
const FEWEST: usize = 1 << 14;
/// Draws for each function that a root is sought on: where there is one, few find it as well as many.
const ROOT_EACH: usize = 80;

/// Draws from some density near exp(Q), each with the reciprocal of that density.
#[derive(Debug)]
pub(super) struct Draws {
    pub(super) points: States,
    /// The logarithms of the reciprocals.
    pub(super) base: Vec<f64>,
}

/// Q = Σ a_k φ_k and what the draws say of exp(Q).
#[derive(Clone, Debug)]
pub(super) struct Fit {
    /// Constant first, which is zero.
    pub(super) a: Vec<f64>,
    /// The share of the draws that independent draws from exp(Q) itself would need.
    pub(super) effective: f64,
    pub(super) steps: usize,
    /// The mass of each draw.
    pub(super) masses: Vec<f64>,
}

/// When a search ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Search {
    pub(super) tolerance: f64,
    pub(super) most: usize,
}

/// Functions on draws.
#[derive(Clone, Copy, Debug)]
pub(super) struct Likelihood<'a> {
    pub(super) draws: &'a Draws,
    pub(super) products: &'a Products,
}

impl Likelihood<'_> {
    /// The most likely density whose functions have the `means`, the constant left out: a·m − ln ∫ exp(Q) is concave. It is
    /// found once a step is as short as `tolerance`, in standard deviations of ln p, or after `most` of them. None where
    /// integrals are not finite.
    pub(super) fn most_likely(
        &self,
        means: &[f64],
        start: Vec<f64>,
        Search { tolerance, most }: Search,
    ) -> Option<Fit> {
        let size = self.products.len() - 1;
        let mut a = start;
        let mut steps = 0;
        let (mut value, mut masses) = self.value(&a, means)?;
        let mut curvature: Option<faer::linalg::solvers::Llt<f64>> = None;
        let mut last = f64::INFINITY;
        while steps < most {
            let found = self.means(&masses);
            let gradient = Mat::from_fn(size, 1, |k, _| means[k] - found[k]);
            let fresh = curvature.is_none();
            let factor = match curvature.take() {
                Some(factor) => factor,
                None => self.curvature(&masses, &found)?,
            };
            let step = factor.solve(&gradient);
            let decrement = (0..size).map(|k| step[(k, 0)] * gradient[(k, 0)]).sum::<f64>().max(0.0).sqrt();
            if decrement < tolerance {
                break;
            }
            if !fresh && decrement > FALLING * last {
                continue;
            }
            let mut length = (LONGEST / decrement).min(1.0);
            let moved = loop {
                let next: Vec<f64> = a
                    .iter()
                    .enumerate()
                    .map(|(k, a)| if k == 0 { 0.0 } else { a + length * step[(k - 1, 0)] })
                    .collect();
                match self.value(&next, means) {
                    Some((new, p)) if new >= value + 1e-4 * length * decrement * decrement - 1e-13 * value.abs() => {
                        (a, value, masses) = (next, new, p);
                        break true;
                    }
                    _ => length *= 0.5,
                }
                if length < 1e-6 {
                    break false;
                }
            };
            steps += 1;
            if !moved {
                if fresh {
                    break;
                }
                continue;
            }
            last = decrement;
            // A full step of a curvature that is nearly right is followed by another.
            curvature = (length == 1.0 && decrement < 0.3).then_some(factor);
        }
        a.iter().all(|a| a.is_finite()).then(|| Fit { a, effective: effective(&masses), steps, masses })
    }

    /// E|δ| of the first-order change δ of ln p that a change of the means makes.
    pub(super) fn change(&self, fit: &Fit, means: [&[f64]; 2]) -> Option<f64> {
        let found = self.means(&fit.masses);
        let difference = Mat::from_fn(found.len(), 1, |k, _| means[0][k] - means[1][k]);
        let step = self.curvature(&fit.masses, &found)?.solve(&difference);
        let constant: f64 = (0..found.len()).map(|k| step[(k, 0)] * found[k]).sum();
        let a: Vec<f64> = std::iter::once(-constant).chain((0..found.len()).map(|k| step[(k, 0)])).collect();
        let part = |scratch: &mut Scratch, (block, p): (usize, &[f64])| {
            let mut sum = 0.0;
            self.each(block * BLOCK, p.len(), scratch, |at, count, scratch| {
                let delta = self.products.sum(&a, scratch);
                sum += (0..count).map(|l| p[at + l] * delta[l].abs()).sum::<f64>();
            });
            sum
        };
        let chunks = fit.masses.par_chunks(BLOCK).enumerate();
        let parts: Vec<f64> = chunks.map_init(|| self.products.scratch(), part).collect();
        Some(parts.iter().sum())
    }

    /// The root of E\[r φ_k\] = 0 under exp(Q) itself near `fit`, where the residual r vanishes at every draw: Q is then exact,
    /// whatever the draws. None where there is none.
    pub(super) fn polished(&self, problem: &Problem, fit: &Fit) -> Option<Fit> {
        let size = self.products.len() - 1;
        let zeros = vec![0.0; size];
        let count = (ROOT_EACH * size).max(FEWEST).min(fit.masses.len());
        let first = |masses: &[f64]| -> Vec<f64> {
            let sum: f64 = masses[..count].iter().sum();
            masses[..count].iter().map(|p| p / sum).collect()
        };
        let (mut a, mut all, mut last) = (fit.a.clone(), fit.masses.clone(), f64::INFINITY);
        for steps in 0..POLISHES {
            let masses = first(&all);
            let found = self.means(&masses);
            let equations = self.equations(problem, &a, &masses, true);
            if equations.size < SOLVED {
                return Some(Fit { a, effective: effective(&all), steps: fit.steps + steps, masses: all });
            }
            if equations.size.is_nan() || equations.size >= HALVED * last {
                return None;
            }
            last = equations.size;
            // Of ψ = φ − Eφ.
            let matrix = Mat::from_fn(size, size, |k, l| {
                equations.matrix[(k + 1, l + 1)] - found[k] * equations.matrix[(0, l + 1)]
            });
            let right = Mat::from_fn(size, 1, |k, _| found[k] * equations.tested[0] - equations.tested[k + 1]);
            let scale: Vec<f64> = (0..size).map(|k| matrix.col(k).norm_l2().max(f64::MIN_POSITIVE).recip()).collect();
            let scaled = Mat::from_fn(size, size, |k, l| matrix[(k, l)] * scale[l]);
            let step = scaled.partial_piv_lu().solve(&right);
            (0..size).for_each(|k| a[k + 1] += scale[k] * step[(k, 0)]);
            all = self.value(&a, &zeros)?.1;
        }
        None
    }

    /// How far Q is from what the equations under exp(Q) ask for: the root mean square of the residual, and its size relative to
    /// its parts.
    pub(super) fn residual(&self, problem: &Problem, fit: &Fit) -> [f64; 2] {
        let Equations { root, size, .. } = self.equations(problem, &fit.a, &fit.masses, false);
        [root, size]
    }

    /// a·m − ln ∫ exp(Q), and the mass of each draw. None where exp(Q) has no finite integral.
    fn value(&self, a: &[f64], means: &[f64]) -> Option<(f64, Vec<f64>)> {
        let mut q = vec![0.0; self.draws.base.len()];
        q.par_chunks_mut(BLOCK).enumerate().for_each_init(
            || self.products.scratch(),
            |scratch, (block, q)| {
                self.each(block * BLOCK, q.len(), scratch, |at, count, scratch| {
                    let sum = self.products.sum(a, scratch);
                    for l in 0..count {
                        q[at + l] = sum[l] + self.draws.base[block * BLOCK + at + l];
                    }
                });
            },
        );
        let top = q.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        q.iter_mut().for_each(|q| *q = (*q - top).exp());
        let sum: f64 = q.iter().sum();
        q.iter_mut().for_each(|p| *p /= sum);
        let along: f64 = a[1..].iter().zip(means).map(|(a, m)| a * m).sum();
        let value = along - sum.ln() - top;
        value.is_finite().then_some((value, q))
    }

    /// E φ_k, the constant left out.
    fn means(&self, masses: &[f64]) -> Vec<f64> {
        let size = self.products.len() - 1;
        let part = |scratch: &mut Scratch, (block, p): (usize, &[f64])| {
            let mut sums = vec![0.0; size];
            self.each(block * BLOCK, p.len(), scratch, |at, count, scratch| {
                for (k, sum) in sums.iter_mut().enumerate() {
                    let value = self.products.value(scratch, k + 1);
                    *sum += (0..count).map(|l| p[at + l] * value[l]).sum::<f64>();
                }
            });
            sums
        };
        let chunks = masses.par_chunks(BLOCK).enumerate();
        let parts: Vec<Vec<f64>> = chunks.map_init(|| self.products.scratch(), part).collect();
        let mut sums = vec![0.0; size];
        parts.iter().for_each(|part| sums.iter_mut().zip(part).for_each(|(sum, part)| *sum += part));
        sums
    }

    /// The factors of Cov φ.
    fn curvature(&self, masses: &[f64], means: &[f64]) -> Option<faer::linalg::solvers::Llt<f64>> {
        let size = means.len();
        let every = if size > MANY { EVERY } else { 1 };
        let blocks: Vec<usize> = (0..masses.len().div_ceil(BLOCK)).step_by(every).collect();
        let stretches = (ROOM / (size * size)).clamp(2, 64);
        let stretch = |blocks: &[usize]| {
            let mut sum = Mat::zeros(size, size);
            let mut scratch = self.products.scratch();
            let mut table = Mat::<f64>::zeros(BLOCK, size);
            let mut mass = 0.0;
            for &block in blocks {
                let p = &masses[block * BLOCK..((block + 1) * BLOCK).min(masses.len())];
                mass += p.iter().sum::<f64>();
                self.each(block * BLOCK, p.len(), &mut scratch, |at, count, scratch| {
                    for (k, mean) in means.iter().enumerate() {
                        let value = self.products.value(scratch, k + 1);
                        let column = table.col_as_slice_mut(k);
                        (0..count).for_each(|l| column[at + l] = p[at + l].sqrt() * (value[l] - mean));
                    }
                });
                let used = table.get(..p.len(), ..);
                matmul(sum.as_mut(), Accum::Add, used.transpose(), used, 1.0, Par::Seq);
            }
            (sum, mass)
        };
        let parts: Vec<_> = blocks.par_chunks(blocks.len().div_ceil(stretches).max(1)).map(stretch).collect();
        let (mut sum, mut mass) = (Mat::<f64>::zeros(size, size), 0.0);
        for (part, m) in &parts {
            sum += part;
            mass += m;
        }
        let trace = (0..size).map(|k| sum[(k, k)]).sum::<f64>() / mass;
        let ridge = RIDGE * trace / size as f64;
        let matrix = Mat::from_fn(size, size, |k, l| sum[(k, l)] / mass + if k == l { ridge } else { 0.0 });
        matrix.llt(Side::Lower).ok()
    }

    /// The size of the residual under exp(Q) and, where `whole`, all of the equations.
    fn equations(&self, problem: &Problem, a: &[f64], masses: &[f64], whole: bool) -> Equations {
        let size = if whole { self.products.len() } else { 0 };
        let stretches = (ROOM / (size * size).max(1)).clamp(2, 64);
        let blocks: Vec<usize> = (0..masses.len().div_ceil(BLOCK)).collect();
        let stretch = |blocks: &[usize]| {
            let mut sum = Equations { matrix: Mat::zeros(size, size), tested: vec![0.0; size], root: 0.0, size: 0.0 };
            let (mut scratch, mut sites) = (self.products.scratch(), Sites::new(problem));
            let [mut left, mut right] = [(); 2].map(|()| Mat::<f64>::zeros(BLOCK, size));
            for &block in blocks {
                let p = &masses[block * BLOCK..((block + 1) * BLOCK).min(masses.len())];
                for at in (0..p.len()).step_by(LANES) {
                    let count = LANES.min(p.len() - at);
                    let n = problem.dimension();
                    let first = block * BLOCK + at;
                    sites.place(problem, &self.draws.points.values()[first * n..(first + count) * n]);
                    self.products.place(&sites.x, &mut scratch);
                    let (r, parts) = self.residual_at(a, &sites, &mut scratch);
                    if whole {
                        linearised(&sites, &mut scratch);
                        self.products.apply(&sites.diffusion, &sites.coupled, &mut scratch);
                    }
                    for l in 0..count {
                        sum.root += p[at + l] * r[l] * r[l];
                        sum.size += p[at + l] * parts[l];
                    }
                    for k in 0..size {
                        let value = self.products.value(&scratch, k);
                        let image = self.products.image(&scratch, k);
                        let (left, right) = (left.col_as_slice_mut(k), right.col_as_slice_mut(k));
                        for l in 0..count {
                            left[at + l] = p[at + l] * value[l];
                            right[at + l] = image[l];
                            sum.tested[k] += p[at + l] * r[l] * value[l];
                        }
                    }
                }
                let (left, right) = (left.get(..p.len(), ..), right.get(..p.len(), ..));
                matmul(sum.matrix.as_mut(), Accum::Add, left.transpose(), right, 1.0, Par::Seq);
            }
            sum
        };
        let parts: Vec<Equations> = blocks.par_chunks(blocks.len().div_ceil(stretches).max(1)).map(stretch).collect();
        let mut all = Equations { matrix: Mat::zeros(size, size), tested: vec![0.0; size], root: 0.0, size: 0.0 };
        for part in &parts {
            all.matrix += &part.matrix;
            all.tested.iter_mut().zip(&part.tested).for_each(|(sum, part)| *sum += part);
            all.root += part.root;
            all.size += part.size;
        }
        let root = all.root.sqrt();
        Equations { size: root / all.size.sqrt().max(f64::MIN_POSITIVE), root, ..all }
    }

    /// The residual of Q at the sites where the products are placed, and the sum of the squares of the parts f_i ∂_iQ.
    fn residual_at(&self, a: &[f64], sites: &Sites, scratch: &mut Scratch) -> (Lane, Lane) {
        scratch.first.copy_from_slice(&sites.backward);
        self.products.apply(&sites.diffusion, &sites.coupled, scratch);
        let mut r = sites.source;
        for (k, a) in a.iter().enumerate() {
            let image = self.products.image(scratch, k);
            (0..LANES).for_each(|l| r[l] += a * image[l]);
        }
        self.products.gradient(a, scratch);
        let slope = &scratch.gradient;
        for &i in &sites.noisy {
            for &j in &sites.noisy {
                let b = &sites.diffusion[i * slope.len() + j];
                (0..LANES).for_each(|l| r[l] += 0.5 * b[l] * slope[i][l] * slope[j][l]);
            }
        }
        let mut parts = ZERO;
        for (f, slope) in sites.drift.iter().zip(slope) {
            (0..LANES).for_each(|l| parts[l] += (f[l] * slope[l]).powi(2));
        }
        (r, parts)
    }

    /// Places the functions at `count` draws from `first` on, eight at a time: the place of the first of them, and their number.
    fn each(&self, first: usize, count: usize, scratch: &mut Scratch, mut look: impl FnMut(usize, usize, &Scratch)) {
        let n = self.products.dimension();
        let mut lanes = vec![ZERO; n];
        for at in (0..count).step_by(LANES) {
            let used = LANES.min(count - at);
            for l in 0..LANES {
                let x = self.draws.points.state(first + at + l.min(used - 1));
                lanes.iter_mut().zip(x).for_each(|(lane, x)| lane[l] = *x);
            }
            self.products.place(&lanes, scratch);
            look(at, used, scratch);
        }
    }
}

/// The first-order part −f + ∂B + B∇Q of the linearised residual L′δ = (−f + ∂B + B∇Q)·∇δ + ½ B:∇∇δ.
fn linearised(sites: &Sites, scratch: &mut Scratch) {
    scratch.first.copy_from_slice(&sites.backward);
    let n = sites.drift.len();
    for &i in &sites.noisy {
        for &j in &sites.noisy {
            let (b, slope) = (&sites.diffusion[i * n + j], &scratch.gradient[j]);
            (0..LANES).for_each(|l| scratch.first[i][l] += b[l] * slope[l]);
        }
    }
}

/// The Galerkin equations under exp(Q).
struct Equations {
    /// E\[φ_k L′φ_l\].
    matrix: Mat<f64>,
    /// E\[r φ_k\].
    tested: Vec<f64>,
    /// √E r².
    root: f64,
    /// The same relative to its parts.
    size: f64,
}

/// The share of the draws that as many independent ones would be worth.
fn effective(masses: &[f64]) -> f64 {
    masses.iter().map(|p| p * p).sum::<f64>().recip() / masses.len() as f64
}

/// ∫ |p − q| dx of two densities by their masses on the same draws.
pub(super) fn distance(p: &[f64], q: &[f64]) -> f64 {
    p.iter().zip(q).map(|(p, q)| (p - q).abs()).sum()
}
