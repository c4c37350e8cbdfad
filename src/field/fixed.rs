//! Systems of a number of states that is known to the compiler: arrays, several lanes at once.

use super::flow::{KickLanes, Kicks, kick, midpoint, runge_kutta};
use super::{Field, LANES, Lane};
use crate::fokker_planck::Local;
use crate::system::Drift;
use num_dual::{Dual, Dual64, DualNum, HyperDual64};
use num_traits::Zero;
use pulp::{Arch, NullaryFnOnce};

/// A [`Drift`].
pub(crate) struct Fixed<T, const N: usize, const M: usize> {
    pub(crate) system: T,
    /// Whether the noise induces a drift, as Stratonovich's does where it depends on the state.
    pub(crate) induces: bool,
}

impl<T: Drift<N, M>, const N: usize, const M: usize> Fixed<T, N, M> {
    /// The Itô drift on any dual number.
    fn ito<S: DualNum<Primitive = f64> + Copy>(&self, x: [S; N]) -> [S; N] {
        let mut drift = self.system.drift(x);
        if self.induces {
            let induced = self.along(x);
            (0..N).for_each(|i| drift[i] += induced[i]);
        }
        drift
    }

    /// ½ Σ_k (G_k·∇)G_k on any dual number: half the derivative of each column of G along itself.
    #[inline(always)]
    fn along<S: DualNum<Primitive = f64> + Copy>(&self, x: [S; N]) -> [S; N] {
        let mut induced = [S::from(0.0); N];
        let noise = self.system.noise(x);
        for k in 0..M {
            let along = self.system.noise(std::array::from_fn(|j| Dual::new(x[j], noise[j][k])));
            for i in 0..N {
                induced[i] += along[i][k].eps * 0.5;
            }
        }
        induced
    }
}

/// A slice as the array that it is.
fn array<const N: usize>(x: &[f64]) -> [f64; N] {
    std::array::from_fn(|i| x[i])
}

/// A function of one state at all lanes, with the registers that the call is compiled for.
struct OnLanes<'a, F, const N: usize> {
    x: &'a [Lane],
    values: &'a mut [Lane],
    function: F,
}

impl<F: Fn([f64; N]) -> [f64; N], const N: usize> NullaryFnOnce for OnLanes<'_, F, N> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        // Local arrays alias nothing, so that the compiler may work on several lanes at once.
        let mut x = [Lane::ZERO; N];
        x.copy_from_slice(&self.x[..N]);
        let mut values = [Lane::ZERO; N];
        for l in 0..LANES {
            let value = (self.function)(std::array::from_fn(|i| x[i][l]));
            for i in 0..N {
                values[i][l] = value[i];
            }
        }
        self.values[..N].copy_from_slice(&values);
    }
}

/// The flow of column k of G at all lanes, likewise. A closure with four evaluations of the user's noise would be too long to
/// be inlined, and would take one lane after another.
struct OnFlow<'a, T, const N: usize, const M: usize> {
    system: &'a T,
    k: usize,
    x: &'a [Lane],
    s: &'a Lane,
    to: &'a mut [Lane],
}

impl<T: Drift<N, M>, const N: usize, const M: usize> OnFlow<'_, T, N, M> {
    /// Column k, by a choice and not by an index, so that the other columns need no memory.
    #[inline(always)]
    fn column(&self, x: [f64; N]) -> [f64; N] {
        let noise = self.system.noise(x);
        let mut column = [0.0; N];
        for i in 0..N {
            for k in 0..M {
                column[i] = if k == self.k { noise[i][k] } else { column[i] };
            }
        }
        column
    }
}

impl<T: Drift<N, M>, const N: usize, const M: usize> NullaryFnOnce for OnFlow<'_, T, N, M> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let mut x = [Lane::ZERO; N];
        x.copy_from_slice(&self.x[..N]);
        let (s, mut to) = (*self.s, [Lane::ZERO; N]);
        for l in 0..LANES {
            let state: [f64; N] = std::array::from_fn(|i| x[i][l]);
            let end = runge_kutta(state, s[l], |x| self.column(x));
            for i in 0..N {
                to[i][l] = end[i];
            }
        }
        self.to[..N].copy_from_slice(&to);
    }
}

/// Kicks at all lanes, likewise.
struct OnKicks<'a, D, const N: usize, const M: usize> {
    x: &'a mut [Lane],
    w: &'a [Lane],
    kicks: &'a Kicks<'a>,
    drift: D,
}

impl<D: Fn([f64; N]) -> [f64; N], const N: usize, const M: usize> NullaryFnOnce for OnKicks<'_, D, N, M> {
    type Output = (usize, bool);

    #[inline(always)]
    fn call(self) -> (usize, bool) {
        let Kicks { step, moved, noise, .. } = *self.kicks;
        let noise: [[f64; M]; N] = std::array::from_fn(|i| array(&noise[i * M..]));
        let mut states = [Lane::ZERO; N];
        states.copy_from_slice(&self.x[..N]);
        let kick = OneByOne { half: step / 2.0, moved: array(moved), noise, drift: self.drift };
        let kicks = self.kicks.run(&mut states, self.w, M, kick);
        self.x[..N].copy_from_slice(&states);
        kicks
    }
}

/// A kick of one lane after another, several of which the compiler may join.
struct OneByOne<D, const N: usize, const M: usize> {
    half: f64,
    moved: [f64; N],
    noise: [[f64; M]; N],
    drift: D,
}

impl<D: Fn([f64; N]) -> [f64; N], const N: usize, const M: usize> KickLanes for OneByOne<D, N, M> {
    #[inline(always)]
    fn kick(&mut self, x: &mut [Lane], w: &[Lane]) {
        for l in 0..LANES {
            let (state, w): ([f64; N], [f64; M]) = (std::array::from_fn(|i| x[i][l]), std::array::from_fn(|k| w[k][l]));
            let state = kick(state, self.half, &self.moved, |i, k| self.noise[i][k], &w, &self.drift);
            for i in 0..N {
                x[i][l] = state[i];
            }
        }
    }
}

impl<T: Drift<N, M>, const N: usize, const M: usize> Field for Fixed<T, N, M> {
    fn noise(&self, arch: Arch, k: usize, x: &[Lane], column: &mut [Lane]) {
        let entries = |x| self.system.noise(x).map(|row| row[k]);
        arch.dispatch(OnLanes { x, values: column, function: entries });
    }

    fn noise_flow(&self, arch: Arch, k: usize, x: &[Lane], s: &Lane, to: &mut [Lane]) {
        arch.dispatch(OnFlow { system: &self.system, k, x, s, to });
    }

    fn drift_flow(&self, arch: Arch, x: &[Lane], tau: f64, moved: &[f64], induced: f64, to: &mut [Lane]) {
        let moved: [f64; N] = array(moved);
        let drift = |x: [f64; N]| self.system.drift(x);
        if induced == 0.0 {
            arch.dispatch(OnLanes { x, values: to, function: |x| midpoint(x, tau, &moved, drift) });
        } else {
            let both = |x: [f64; N]| {
                let (drift, more) = (drift(x), self.along(x));
                std::array::from_fn(|i| drift[i] + induced * more[i])
            };
            arch.dispatch(OnLanes { x, values: to, function: |x| midpoint(x, tau, &moved, both) });
        }
    }

    fn kicks(&self, arch: Arch, x: &mut [Lane], w: &[Lane], kicks: &Kicks<'_>) -> (usize, bool) {
        let drift = |x: [f64; N]| self.system.drift(x);
        arch.dispatch(OnKicks::<_, N, M> { x, w, kicks, drift })
    }

    fn kick(&self, x: &mut [f64], w: &[f64], Kicks { step, moved, noise, .. }: &Kicks<'_>) {
        let noise = |i: usize, k: usize| noise[i * M + k];
        x.copy_from_slice(&kick(array::<N>(x), step / 2.0, moved, noise, w, |x| self.system.drift(x)));
    }

    fn ito_drift(&self, x: &[f64], drift: &mut [f64]) {
        drift.copy_from_slice(&self.ito(array(x)));
    }

    fn ito_drifts(&self, arch: Arch, x: &[Lane], drift: &mut [Lane]) {
        arch.dispatch(OnLanes { x, values: drift, function: |x| self.ito(x) });
    }

    fn divergence(&self, x: &[f64]) -> f64 {
        let slope = |i: usize| self.ito(std::array::from_fn(|j| Dual64::new(x[j], f64::from(i == j))))[i].eps;
        (0..N).map(slope).sum()
    }

    fn diffusion(&self, x: &[f64], diffusion: &mut [f64]) {
        let noise = self.system.noise::<f64>(array(x));
        let entry = |i: usize, j: usize| (0..M).fold(0.0, |sum, k| sum + noise[i][k] * noise[j][k]);
        diffusion.iter_mut().enumerate().for_each(|(at, b)| *b = entry(at / N, at % N));
    }

    fn diffusion_derivatives(&self, x: &[f64], local: &mut Local) {
        local.diffusion_divergence.fill(0.0);
        local.diffusion_curvature = 0.0;
        for i in 0..N {
            for j in 0..N {
                let at = |k: usize| HyperDual64::new(x[k], f64::from(k == i), f64::from(k == j), 0.0);
                let noise = self.system.noise(std::array::from_fn(at));
                let b = (0..M).fold(HyperDual64::zero(), |sum, k| sum + noise[i][k] * noise[j][k]);
                local.add_derivatives(i, j, [b.re, b.eps2, b.eps1eps2]);
            }
        }
    }

    fn slopes(&self, x: &[f64], jacobian: &mut [f64]) -> f64 {
        let mut squares = 0.0;
        for j in 0..N {
            let at = std::array::from_fn(|i| Dual64::new(x[i], f64::from(i == j)));
            let (drift, noise) = (self.ito(at), self.system.noise(at));
            for i in 0..N {
                jacobian[i * N + j] = drift[i].eps;
                squares += noise[i].iter().map(|g| g.eps * g.eps).sum::<f64>();
            }
        }
        squares
    }
}
