//! The user's own definition as what can be evaluated: the only code that is compiled for a user's type.

use crate::fokker_planck::Local;
use crate::scalar::Scalar;
use crate::system::{PolynomialDrift, PolynomialSystem};
use num_dual::{Dual, Dual64, DualNum, HyperDual64};
use num_traits::{One, Zero};
use pulp::{Arch, NullaryFnOnce};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// States that are advanced in lockstep.
pub(crate) const LANES: usize = 16;

/// One state of each of them.
pub(crate) type Lane = [f64; LANES];

/// What the methods ask of a system. First derivatives come from [`Dual64`], second ones from [`HyperDual64`], and the
/// derivatives of the noise-induced drift from dual numbers over those, so that nothing is ever differenced.
pub(crate) trait Field: Send + Sync {
    /// The drift as it was written at [`LANES`] states: `x[i][l]` is state i of lane l.
    fn drift(&self, arch: Arch, x: &[Lane], drift: &mut [Lane]);

    /// Column k of G.
    fn noise(&self, arch: Arch, k: usize, x: &[Lane], column: &mut [Lane]);

    /// ½ Σ_k (G_k·∇)G_k, what Stratonovich's mean rate of change has beyond the drift.
    fn induced(&self, arch: Arch, x: &[Lane], induced: &mut [Lane]);

    /// The Itô drift f at a point.
    fn ito_drift(&self, x: &[f64], drift: &mut [f64]);

    /// ∇·f at a point.
    fn divergence(&self, x: &[f64]) -> f64;

    /// B = G Gᵀ at a point, by rows.
    fn diffusion(&self, x: &[f64], diffusion: &mut [f64]);

    /// B with Σ_j ∂_jB_ij and Σ_ij ∂_i∂_jB_ij at a point.
    fn diffusion_derivatives(&self, x: &[f64], local: &mut Local);

    /// ∂f_i/∂x_j of the Itô drift, by rows, and Σ|∂G_ik/∂x_j|².
    fn slopes(&self, x: &[f64], jacobian: &mut [f64]) -> f64;
}

/// A [`PolynomialDrift`].
pub(super) struct Fixed<T, const N: usize, const M: usize> {
    pub(super) system: T,
    /// Whether the noise induces a drift, as Stratonovich's does where it depends on the state.
    pub(super) induces: bool,
}

impl<T: PolynomialDrift<N, M>, const N: usize, const M: usize> Fixed<T, N, M> {
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
        let mut x = [[0.0; LANES]; N];
        x.copy_from_slice(&self.x[..N]);
        let mut values = [[0.0; LANES]; N];
        for l in 0..LANES {
            let value = (self.function)(std::array::from_fn(|i| x[i][l]));
            for i in 0..N {
                values[i][l] = value[i];
            }
        }
        self.values[..N].copy_from_slice(&values);
    }
}

impl<T: PolynomialDrift<N, M>, const N: usize, const M: usize> Field for Fixed<T, N, M> {
    fn drift(&self, arch: Arch, x: &[Lane], drift: &mut [Lane]) {
        arch.dispatch(OnLanes { x, values: drift, function: |x| self.system.drift(x) });
    }

    fn noise(&self, arch: Arch, k: usize, x: &[Lane], column: &mut [Lane]) {
        let entries = |x| self.system.noise(x).map(|row| row[k]);
        arch.dispatch(OnLanes { x, values: column, function: entries });
    }

    fn induced(&self, arch: Arch, x: &[Lane], induced: &mut [Lane]) {
        arch.dispatch(OnLanes { x, values: induced, function: |x| self.along(x) });
    }

    fn ito_drift(&self, x: &[f64], drift: &mut [f64]) {
        drift.copy_from_slice(&self.ito(array(x)));
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

/// A [`PolynomialSystem`].
pub(super) struct AnySize<T> {
    pub(super) system: T,
    /// As [`Fixed::induces`].
    pub(super) induces: bool,
}

impl<T: PolynomialSystem> AnySize<T> {
    fn ito<S: DualNum<Primitive = f64> + Copy>(&self, x: &[S]) -> Vec<S> {
        let mut drift = self.system.drift(x);
        if self.induces {
            drift.iter_mut().zip(self.along(x)).for_each(|(f, induced)| *f += induced);
        }
        drift
    }

    fn along<S: DualNum<Primitive = f64> + Copy>(&self, x: &[S]) -> Vec<S> {
        let mut induced = vec![S::from(0.0); x.len()];
        let noise = self.system.noise(x);
        for k in 0..self.system.processes() {
            let at: Vec<Dual<S>> = x.iter().zip(&noise).map(|(x, row)| Dual::new(*x, row[k])).collect();
            let along = self.system.noise(&at);
            induced.iter_mut().zip(along).for_each(|(induced, row)| *induced += row[k].eps * 0.5);
        }
        induced
    }

    fn seeded(x: &[f64], j: usize) -> Vec<Dual64> {
        x.iter().enumerate().map(|(i, x)| Dual64::new(*x, f64::from(i == j))).collect()
    }
}

/// A call on packs, with the registers that it is compiled for.
struct OnPacks<F>(F);

impl<F: FnOnce()> NullaryFnOnce for OnPacks<F> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        (self.0)();
    }
}

impl<T: PolynomialSystem> Field for AnySize<T> {
    fn drift(&self, arch: Arch, x: &[Lane], drift: &mut [Lane]) {
        let x: Vec<Pack> = x.iter().copied().map(Pack).collect();
        let call = || drift.iter_mut().zip(self.system.drift(&x)).for_each(|(f, pack)| *f = pack.0);
        arch.dispatch(OnPacks(call));
    }

    fn noise(&self, arch: Arch, k: usize, x: &[Lane], column: &mut [Lane]) {
        let x: Vec<Pack> = x.iter().copied().map(Pack).collect();
        let call = || column.iter_mut().zip(self.system.noise(&x)).for_each(|(g, row)| *g = row[k].0);
        arch.dispatch(OnPacks(call));
    }

    fn induced(&self, _: Arch, x: &[Lane], induced: &mut [Lane]) {
        for l in 0..LANES {
            let state: Vec<f64> = x.iter().map(|lane| lane[l]).collect();
            induced.iter_mut().zip(self.along(&state)).for_each(|(lane, value)| lane[l] = value);
        }
    }

    fn ito_drift(&self, x: &[f64], drift: &mut [f64]) {
        drift.copy_from_slice(&self.ito(x));
    }

    fn divergence(&self, x: &[f64]) -> f64 {
        (0..x.len()).map(|i| self.ito(&Self::seeded(x, i))[i].eps).sum()
    }

    fn diffusion(&self, x: &[f64], diffusion: &mut [f64]) {
        let (n, noise) = (x.len(), self.system.noise(x));
        let entry = |i: usize, j: usize| noise[i].iter().zip(&noise[j]).fold(0.0, |sum, (g, h)| sum + g * h);
        diffusion.iter_mut().enumerate().for_each(|(at, b)| *b = entry(at / n, at % n));
    }

    fn diffusion_derivatives(&self, x: &[f64], local: &mut Local) {
        local.diffusion_divergence.fill(0.0);
        local.diffusion_curvature = 0.0;
        for i in 0..x.len() {
            for j in 0..x.len() {
                let at = |(k, x): (usize, &f64)| HyperDual64::new(*x, f64::from(k == i), f64::from(k == j), 0.0);
                let noise = self.system.noise(&x.iter().enumerate().map(at).collect::<Vec<_>>());
                let b = noise[i].iter().zip(&noise[j]).fold(HyperDual64::zero(), |sum, (g, h)| sum + *g * *h);
                local.add_derivatives(i, j, [b.re, b.eps2, b.eps1eps2]);
            }
        }
    }

    fn slopes(&self, x: &[f64], jacobian: &mut [f64]) -> f64 {
        let (n, mut squares) = (x.len(), 0.0);
        for j in 0..n {
            let at = Self::seeded(x, j);
            let (drift, noise) = (self.ito(&at), self.system.noise(&at));
            for i in 0..n {
                jacobian[i * n + j] = drift[i].eps;
                squares += noise[i].iter().map(|g| g.eps * g.eps).sum::<f64>();
            }
        }
        squares
    }
}

/// One number for each lane, which a drift of any length runs on.
#[derive(Clone, Copy, Debug)]
struct Pack(Lane);

impl Pack {
    #[inline(always)]
    fn each(self, f: impl Fn(f64) -> f64) -> Self {
        Pack(self.0.map(f))
    }

    #[inline(always)]
    fn with(mut self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        for l in 0..LANES {
            self.0[l] = f(self.0[l], other.0[l]);
        }
        self
    }
}

impl From<f64> for Pack {
    #[inline(always)]
    fn from(value: f64) -> Self {
        Pack([value; LANES])
    }
}

impl Neg for Pack {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        self.each(|x| -x)
    }
}

macro_rules! lane_by_lane {
    ($($operation:ident $method:ident $sign:tt),*) => {$(
        impl $operation for Pack {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.with(other, |a, b| a $sign b)
            }
        }
        impl $operation<f64> for Pack {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: f64) -> Self {
                self.each(|a| a $sign other)
            }
        }
    )*};
}
lane_by_lane!(Add add +, Sub sub -, Mul mul *);

impl Div<f64> for Pack {
    type Output = Self;

    #[inline(always)]
    fn div(self, divisor: f64) -> Self {
        self.each(|x| x / divisor)
    }
}

impl Zero for Pack {
    #[inline(always)]
    fn zero() -> Self {
        Pack::from(0.0)
    }

    fn is_zero(&self) -> bool {
        self.0.iter().all(|x| *x == 0.0)
    }
}

impl One for Pack {
    #[inline(always)]
    fn one() -> Self {
        Pack::from(1.0)
    }
}

impl Scalar for Pack {}
