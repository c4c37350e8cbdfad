//! The Galerkin equations under exp(Q), with the Fokker-Planck operator at eight states at a time.

use super::likelihood::{BLOCK, Fit, Likelihood, ROOM, ROWS, lane};
use crate::fokker_planck::Local;
use crate::functions::{Corner, Form, Scratch};
use crate::numerics::{EIGHT, Eight, Number, add_gram, symmetric};
use crate::parallel;
use crate::problem::Problem;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};

/// Eight states with the coefficients of the operator there.
#[derive(Clone, Debug)]
pub(super) struct Sites {
    pub(super) x: Vec<Eight>,
    /// f.
    pub(super) drift: Vec<Eight>,
    /// B, by rows.
    pub(super) diffusion: Vec<Eight>,
    /// −f + ∂B.
    pub(super) backward: Vec<Eight>,
    /// −∇·f + ½ ∂∂B.
    pub(super) source: Eight,
    /// The states i with some B_ij ≠ 0, j ≠ i.
    pub(super) coupled: Vec<usize>,
    /// The states with noise.
    pub(super) noisy: Vec<usize>,
    local: Local,
    /// The walls whose grazing impacts make a part S of ln p that is known.
    grazed: Vec<Corner>,
}

impl Sites {
    pub(super) fn new(problem: &Problem, corners: &[Corner]) -> Self {
        let n = problem.dimension();
        let [x, drift, backward] = [(); 3].map(|()| vec![Eight::ZERO; n]);
        let b = problem.operator().diffusion();
        let coupled = problem.operator().coupled();
        let noisy = (0..n).filter(|&i| !b[i][i].is_zero()).collect();
        let (diffusion, local) = (vec![Eight::ZERO; n * n], Local::new(n));
        let grazed = corners.iter().filter(|corner| corner.grazes()).cloned().collect();
        Sites { x, drift, diffusion, backward, source: Eight::ZERO, coupled, noisy, local, grazed }
    }

    /// Up to eight states, one after the other in `states`; the last stands in for those that are missing.
    pub(super) fn place(&mut self, problem: &Problem, states: &[f64]) {
        let n = problem.dimension();
        let count = states.len() / n;
        for l in 0..EIGHT {
            let x = &states[l.min(count - 1) * n..][..n];
            problem.local(x, &mut self.local);
            for i in 0..n {
                self.x[i][l] = x[i];
                self.drift[i][l] = self.local.drift[i];
                self.backward[i][l] = self.local.backward(i);
            }
            self.diffusion.iter_mut().zip(&self.local.diffusion).for_each(|(lane, b)| lane[l] = *b);
            self.source[l] = self.local.source();
        }
        if !self.grazed.is_empty() {
            self.add_known();
        }
    }

    /// Makes the residual that of exp(S + Q) as a function of Q: its constant part becomes the residual of exp(S), and its
    /// coefficients of ∇Q become −f + ∂B + B∇S.
    ///
    /// At each wall −w S_u + D (S_ww + S_w²) = 0 exactly, terms that are large and would leave their rounding.
    fn add_known(&mut self) {
        let n = self.x.len();
        let backward = self.backward.clone();
        let mut slopes: Vec<(Form, Eight)> = Vec::with_capacity(self.grazed.len());
        for corner in &self.grazed {
            let jet = corner.grazing_jet(&self.x);
            let (slope, bend) = (jet.gradient[1], jet.hessian[1][1]);
            let [_, rate] = corner.forms();
            let (back, noise) = (rate.of(&backward), rate.diffusion(&rate, &self.diffusion, n));
            let excess = noise * 0.5 - corner.intensity();
            self.source += back * slope + excess * (bend + slope * slope);
            for (other, with) in &slopes {
                self.source += rate.diffusion(other, &self.diffusion, n) * slope * *with;
            }
            slopes.push((rate, slope));
            for (j, sign) in rate.parts() {
                for i in 0..n {
                    self.backward[i] += self.diffusion[i * n + j] * sign * slope;
                }
            }
        }
    }
}

impl Likelihood<'_> {
    /// The root mean square of the residual of Q under exp(Q), and its size relative to its parts.
    pub(super) fn residual(&self, problem: &Problem, fit: &Fit) -> [f64; 2] {
        let Equations { root, size, .. } = self.equations(problem, &fit.a, &fit.masses, false);
        [root, size]
    }

    /// The equations under exp(Q), or the size of its residual alone.
    pub(super) fn equations(&self, problem: &Problem, a: &[f64], masses: &[f64], whole: bool) -> Equations {
        let size = if whole { self.space.len() + 1 } else { 0 };
        let stretches = (ROOM / (size * size).max(1)).clamp(2, 64);
        let blocks: Vec<usize> = (0..masses.len().div_ceil(BLOCK)).collect();
        let runs: Vec<&[usize]> = blocks.chunks(blocks.len().div_ceil(stretches).max(1)).collect();
        let parts: Vec<Equations> = parallel::map(runs.len(), |run| self.summed(problem, a, masses, (size, runs[run])));
        let mut all = Equations::new(size);
        parts.iter().for_each(|part| all.add(part));
        let root = all.root.sqrt();
        let mut size = root / all.size.sqrt().max(f64::MIN_POSITIVE);
        if !self.walls.is_empty() {
            let log_mass = self.log_mass_by(a, masses);
            let defect = self.add_impacts(a, log_mass, &mut all);
            size = size.max(defect);
        }
        Equations { noise: symmetric(&all.noise), spread: symmetric(&all.spread), size, root, ..all }
    }

    /// The sums of the equations over some blocks of the nodes.
    fn summed(&self, problem: &Problem, a: &[f64], masses: &[f64], (size, blocks): (usize, &[usize])) -> Equations {
        let mut sum = Equations::new(size);
        let (mut scratch, mut sites) = (Scratch::default(), Sites::new(problem, self.corners));
        let [mut left, mut right, mut noise] = [(); 3].map(|()| Mat::<f64>::zeros(ROWS, size));
        for &block in blocks {
            let p = &masses[block * BLOCK..((block + 1) * BLOCK).min(masses.len())];
            for at in (0..p.len()).step_by(EIGHT) {
                let count = EIGHT.min(p.len() - at);
                let n = problem.dimension();
                let first = block * BLOCK + at;
                sites.place(problem, &self.nodes.points.values()[first * n..(first + count) * n]);
                self.space.place(&sites.x, &mut scratch);
                let (r, parts) = self.residual_at(a, &sites, &mut scratch);
                if size > 0 {
                    self.space.apply((&sites.drift, &sites.diffusion), &sites.coupled, &mut scratch);
                }
                let p = lane(&p[at..at + count]);
                for l in 0..EIGHT {
                    sum.root += p[l] * r[l] * r[l];
                    sum.size += p[l] * parts[l];
                }
                for k in 0..size {
                    let value = self.space.value(&scratch, k);
                    let image = self.space.image(&scratch, k);
                    let [left, right, noise] =
                        [&mut left, &mut right, &mut noise].map(|table| &mut table.col_as_slice_mut(k)[at..at + EIGHT]);
                    for l in 0..EIGHT {
                        left[l] = p[l] * value[l];
                        right[l] = image[l];
                        noise[l] = r[l] * left[l];
                        sum.tested[k] += noise[l];
                    }
                }
            }
            let [left, right, noise] = [&left, &right, &noise].map(|table| table.get(..p.len(), ..));
            matmul(sum.matrix.as_mut(), Accum::Add, left.transpose(), right, 1.0, Par::Seq);
            if size > 0 {
                add_gram(sum.noise.as_mut(), noise);
                add_gram(sum.spread.as_mut(), left);
            }
        }
        sum
    }

    /// The residual of Q at the sites where the functions are placed, and the sum of the squares of the parts f_i ∂_iQ.
    fn residual_at(&self, a: &[f64], sites: &Sites, scratch: &mut Scratch<Eight>) -> (Eight, Eight) {
        self.space.apply((&sites.backward, &sites.diffusion), &sites.coupled, scratch);
        let mut r = sites.source + self.space.sum_of_images(&a[1..], scratch);
        self.space.gradient(&a[1..], scratch);
        let slope = &scratch.gradient;
        for &i in &sites.noisy {
            for &j in &sites.noisy {
                r += sites.diffusion[i * slope.len() + j] * 0.5 * slope[i] * slope[j];
            }
        }
        let mut parts = Eight::ZERO;
        for (f, slope) in sites.drift.iter().zip(slope) {
            parts += (*f * *slope).map(|part| part.powi(2));
        }
        (r, parts)
    }
}

/// The Galerkin equations under exp(Q), the constant among the functions.
#[derive(Clone, Debug)]
pub(super) struct Equations {
    /// E\[φ_k 𝓖φ_l\].
    pub(super) matrix: Mat<f64>,
    /// E\[r φ_k\].
    pub(super) tested: Vec<f64>,
    /// The sums of (p r)² φ_k φ_l and of p² φ_k φ_l over the draws: the covariances of E\[r φ\] and of E φ by independent draws.
    pub(super) noise: Mat<f64>,
    pub(super) spread: Mat<f64>,
    /// √E r².
    pub(super) root: f64,
    /// The same relative to its parts.
    pub(super) size: f64,
}

impl Equations {
    pub(super) fn new(size: usize) -> Self {
        let [matrix, noise, spread] = [(); 3].map(|()| Mat::zeros(size, size));
        Equations { matrix, tested: vec![0.0; size], noise, spread, root: 0.0, size: 0.0 }
    }

    pub(super) fn add(&mut self, part: &Equations) {
        self.matrix += &part.matrix;
        self.noise += &part.noise;
        self.spread += &part.spread;
        self.tested.iter_mut().zip(&part.tested).for_each(|(sum, part)| *sum += part);
        self.root += part.root;
        self.size += part.size;
    }
}
