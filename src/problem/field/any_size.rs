//! Systems of any number of states: vectors, with packs of lanes as their numbers.

use super::super::flow::{Kicks, kick, midpoint, runge_kutta};
use super::super::pack::Pack;
use super::super::tangent::Tangent;
use super::{Field, Lane, OnRegisters};
use crate::fokker_planck::Local;
use crate::scalar::Scalar;
use crate::system::PolynomialSystem;
use num_dual::{Dual64, HyperDual64};
use num_traits::Zero;
use pulp::Arch;

/// A [`PolynomialSystem`].
pub(in crate::problem) struct AnySize<T> {
    pub(in crate::problem) system: T,
    /// Whether the noise induces a drift.
    pub(in crate::problem) induces: bool,
}

impl<T: PolynomialSystem> AnySize<T> {
    /// The Itô drift, on packs as well.
    fn ito<S: Scalar>(&self, x: &[S]) -> Vec<S> {
        let mut drift = self.system.drift(x);
        if self.induces {
            drift.iter_mut().zip(self.along(x)).for_each(|(f, induced)| *f = *f + induced);
        }
        drift
    }

    /// ½ Σ_k (G_k·∇)G_k, likewise.
    fn along<S: Scalar>(&self, x: &[S]) -> Vec<S> {
        let mut induced = vec![S::zero(); x.len()];
        let noise = self.system.noise(x);
        for k in 0..self.system.processes() {
            let at = |(value, row): (&S, &Vec<S>)| Tangent { value: *value, slope: row[k] };
            let along = self.system.noise(&x.iter().zip(&noise).map(at).collect::<Vec<_>>());
            induced.iter_mut().zip(along).for_each(|(induced, row)| *induced = *induced + row[k].slope * 0.5);
        }
        induced
    }

    fn seeded(x: &[f64], j: usize) -> Vec<Dual64> {
        x.iter().enumerate().map(|(i, x)| Dual64::new(*x, f64::from(i == j))).collect()
    }
}

/// Lanes as packs, and packs as lanes.
fn packed(x: &[Lane]) -> Vec<Pack> {
    x.iter().copied().map(Pack).collect()
}

fn unpacked(packs: impl IntoIterator<Item = Pack>, lanes: &mut [Lane]) {
    lanes.iter_mut().zip(packs).for_each(|(lane, pack)| *lane = pack.0);
}

impl<T: PolynomialSystem> Field for AnySize<T> {
    fn noise(&self, arch: Arch, k: usize, x: &[Lane], column: &mut [Lane]) {
        let call = || unpacked(self.system.noise(&packed(x)).iter().map(|row| row[k]), column);
        arch.dispatch(OnRegisters(call));
    }

    fn noise_flow(&self, arch: Arch, k: usize, x: &[Lane], s: &Lane, to: &mut [Lane]) {
        let column = |x: &Vec<Pack>| self.system.noise(x).iter().map(|row| row[k]).collect();
        arch.dispatch(OnRegisters(|| unpacked(runge_kutta(packed(x), Pack(*s), column), to)));
    }

    fn drift_flow(&self, arch: Arch, x: &[Lane], tau: f64, moved: &[f64], induced: f64, to: &mut [Lane]) {
        let drift = |x: &Vec<Pack>| {
            let mut drift = self.system.drift(x);
            if induced != 0.0 {
                drift.iter_mut().zip(self.along(x)).for_each(|(f, more)| *f = *f + more * induced);
            }
            drift
        };
        arch.dispatch(OnRegisters(|| unpacked(midpoint(packed(x), tau, moved, drift), to)));
    }

    fn kicks(&self, arch: Arch, x: &mut [Lane], w: &[Lane], kicks: &Kicks<'_>) -> (usize, bool) {
        let processes = self.system.processes();
        let noise = |i: usize, k: usize| kicks.noise[i * processes + k];
        let drift = |x: &Vec<Pack>| self.system.drift(x);
        let kick = |x: &mut [Lane], w: &[Lane]| {
            unpacked(kick(packed(x), kicks.step / 2.0, kicks.moved, noise, &packed(w), drift), x);
        };
        arch.dispatch(OnRegisters(|| kicks.run(x, w, processes, kick)))
    }

    fn kick(&self, x: &mut [f64], w: &[f64], Kicks { step, moved, noise, .. }: &Kicks<'_>) {
        let noise = |i: usize, k: usize| noise[i * w.len() + k];
        x.copy_from_slice(&kick(x.to_vec(), step / 2.0, moved, noise, w, |x| self.system.drift(x)));
    }

    fn ito_drift(&self, x: &[f64], drift: &mut [f64]) {
        drift.copy_from_slice(&self.ito(x));
    }

    fn ito_drifts(&self, arch: Arch, x: &[Lane], drift: &mut [Lane]) {
        arch.dispatch(OnRegisters(|| unpacked(self.ito(&packed(x)), drift)));
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
