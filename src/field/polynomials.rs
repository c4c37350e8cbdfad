//! Systems that are given as polynomials: sums of products, at all lanes at once and without a vector of their own.

use super::flow::{KickLanes, Kicks};
use super::{Field, LANES, Lane};
use crate::fokker_planck::{Local, noise_induced_drift};
use crate::numerics::Lanes;
use crate::polynomial::Polynomial;
use pulp::{Arch, NullaryFnOnce};

/// The polynomials of a system, and the derivatives that are asked of it.
pub(crate) struct PolynomialField {
    /// The drift as written, ½ Σ_k (G_k·∇)G_k, and the Itô drift f.
    drift: Vec<Sum>,
    along: Vec<Sum>,
    ito: Vec<Sum>,
    /// The columns of G.
    columns: Vec<Vec<Sum>>,
    divergence: Sum,
    /// ∂f_i/∂x_j and, of each noise, ∂G_i/∂x_j, by rows.
    slopes: Vec<Sum>,
    noise_slopes: Vec<Sum>,
    /// B_ij, ∂_jB_ij and ∂_i∂_jB_ij, by rows.
    diffusion: Vec<[Sum; 3]>,
}

impl PolynomialField {
    /// `induces` adds the drift that the noise induces.
    pub(crate) fn new(drift: &[Polynomial], columns: &[Vec<Polynomial>], induces: bool) -> Self {
        let n = drift.len();
        let along = noise_induced_drift(columns, n);
        let with = |(f, induced): (&Polynomial, &Polynomial)| if induces { f + induced } else { f.clone() };
        let ito: Vec<Polynomial> = drift.iter().zip(&along).map(with).collect();
        let pairs = || (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        let b = |(i, j): (usize, usize)| {
            let b = columns.iter().fold(Polynomial::zero(n), |sum, g| sum + &g[i] * &g[j]);
            let slope = b.derivative(j);
            [&b, &slope, &slope.derivative(i)].map(Sum::of)
        };
        let divergence = (0..n).fold(Polynomial::zero(n), |sum, i| sum + ito[i].derivative(i));
        let slopes_of = |g: &[Polynomial]| pairs().map(|(i, j)| Sum::of(&g[i].derivative(j))).collect::<Vec<_>>();
        let sums = |all: &[Polynomial]| all.iter().map(Sum::of).collect();
        PolynomialField {
            drift: sums(drift),
            along: sums(&along),
            columns: columns.iter().map(|column| sums(column)).collect(),
            divergence: Sum::of(&divergence),
            slopes: slopes_of(&ito),
            noise_slopes: columns.iter().flat_map(|column| slopes_of(column)).collect(),
            diffusion: pairs().map(b).collect(),
            ito: sums(&ito),
        }
    }

    /// Adds the drift at the states `at`, over the time `tau`, to `x`.
    #[inline(always)]
    fn drive<const L: usize>(&self, at: &[Lanes<L>], tau: f64, moved: &[f64], induced: f64, x: &mut [Lanes<L>]) {
        for (i, x) in x.iter_mut().enumerate() {
            let tau = tau * moved[i];
            if tau != 0.0 {
                let mut slope = self.drift[i].on(at);
                if induced != 0.0 {
                    slope += self.along[i].on(at) * induced;
                }
                *x += slope * tau;
            }
        }
    }

    /// The flow of the drift, by the explicit midpoint rule.
    #[inline(always)]
    fn flow<const L: usize>(&self, x: &mut [Lanes<L>], tau: f64, moved: &[f64], induced: f64, middle: &mut [Lanes<L>]) {
        middle.copy_from_slice(x);
        self.drive(x, tau / 2.0, moved, induced, middle);
        self.drive(middle, tau, moved, induced, x);
    }
}

/// A kick under noise that is the same everywhere, with room for a state.
struct PolynomialKick<'a, const L: usize> {
    field: &'a PolynomialField,
    kicks: &'a Kicks<'a>,
    middle: &'a mut [Lanes<L>],
}

impl<const L: usize> PolynomialKick<'_, L> {
    #[inline(always)]
    fn on(&mut self, x: &mut [Lanes<L>], w: &[Lanes<L>]) {
        let PolynomialKick { field, kicks, middle } = self;
        field.flow(x, kicks.step / 2.0, kicks.moved, 0.0, middle);
        for (x, noise) in x.iter_mut().zip(kicks.noise.chunks_exact(w.len().max(1))) {
            for (w, g) in w.iter().zip(noise) {
                *x += *w * *g;
            }
        }
        field.flow(x, kicks.step / 2.0, kicks.moved, 0.0, middle);
    }
}

impl KickLanes for PolynomialKick<'_, LANES> {
    #[inline(always)]
    fn kick(&mut self, x: &mut [Lane], w: &[Lane]) {
        self.on(x, w);
    }
}

/// Sums at all lanes, with the registers that the call is compiled for. This and the calls below are no closures, which the
/// compiler leaves as functions of their own, for registers of two numbers, where they are long.
struct SumsOnLanes<'a> {
    sums: &'a [Sum],
    x: &'a [Lane],
    values: &'a mut [Lane],
}

impl NullaryFnOnce for SumsOnLanes<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        on_all(self.sums, self.x, self.values);
    }
}

/// The flow of a column of G at all lanes, with room for two states.
struct NoiseFlowOnLanes<'a> {
    column: &'a [Sum],
    x: &'a [Lane],
    s: &'a Lane,
    room: [&'a mut [Lane]; 2],
    to: &'a mut [Lane],
}

impl NullaryFnOnce for NoiseFlowOnLanes<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let NoiseFlowOnLanes { column, x, s, room: [slope, at], to } = self;
        to.copy_from_slice(x);
        at.copy_from_slice(x);
        for (share, next) in [(1.0 / 6.0, 0.5), (1.0 / 3.0, 0.5), (1.0 / 3.0, 1.0), (1.0 / 6.0, 0.0)] {
            on_all(column, at, slope);
            for (i, slope) in slope.iter().enumerate() {
                to[i] += *s * share * *slope;
                at[i] = x[i] + *s * next * *slope;
            }
        }
    }
}

/// The flow of the drift at all lanes, with room for a state.
struct DriftFlowOnLanes<'a> {
    field: &'a PolynomialField,
    x: &'a mut [Lane],
    tau: f64,
    moved: &'a [f64],
    induced: f64,
    middle: &'a mut [Lane],
}

impl NullaryFnOnce for DriftFlowOnLanes<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.field.flow(self.x, self.tau, self.moved, self.induced, self.middle);
    }
}

/// Kicks at all lanes.
struct KicksOnLanes<'a> {
    x: &'a mut [Lane],
    w: &'a [Lane],
    kick: PolynomialKick<'a, LANES>,
}

impl NullaryFnOnce for KicksOnLanes<'_> {
    type Output = (usize, bool);

    #[inline(always)]
    fn call(self) -> (usize, bool) {
        let KicksOnLanes { x, w, kick } = self;
        kick.kicks.run(x, w, kick.field.columns.len(), kick)
    }
}

impl Field for PolynomialField {
    fn noise(&self, arch: Arch, k: usize, x: &[Lane], column: &mut [Lane]) {
        arch.dispatch(SumsOnLanes { sums: &self.columns[k], x, values: column });
    }

    fn noise_flow(&self, arch: Arch, k: usize, x: &[Lane], s: &Lane, to: &mut [Lane]) {
        let mut room = vec![Lane::ZERO; 2 * x.len()];
        arch.dispatch(NoiseFlowOnLanes { column: &self.columns[k], x, s, room: room.split_at_mut(x.len()).into(), to });
    }

    fn drift_flow(&self, arch: Arch, x: &[Lane], tau: f64, moved: &[f64], induced: f64, to: &mut [Lane]) {
        to.copy_from_slice(x);
        let middle = &mut vec![Lane::ZERO; x.len()];
        arch.dispatch(DriftFlowOnLanes { field: self, x: to, tau, moved, induced, middle });
    }

    fn kicks(&self, arch: Arch, x: &mut [Lane], w: &[Lane], kicks: &Kicks<'_>) -> (usize, bool) {
        let middle = &mut vec![Lane::ZERO; x.len()];
        arch.dispatch(KicksOnLanes { x, w, kick: PolynomialKick { field: self, kicks, middle } })
    }

    fn kick(&self, x: &mut [f64], w: &[f64], kicks: &Kicks<'_>) {
        let [mut one, w] = [&*x, w].map(|values| values.iter().map(|&value| Lanes([value])).collect::<Vec<_>>());
        PolynomialKick { field: self, kicks, middle: &mut vec![Lanes::ZERO; x.len()] }.on(&mut one, &w);
        x.iter_mut().zip(one).for_each(|(x, one)| *x = one[0]);
    }

    fn ito_drift(&self, x: &[f64], drift: &mut [f64]) {
        drift.iter_mut().zip(&self.ito).for_each(|(f, sum)| *f = sum.at(x));
    }

    fn ito_drifts(&self, arch: Arch, x: &[Lane], drift: &mut [Lane]) {
        arch.dispatch(SumsOnLanes { sums: &self.ito, x, values: drift });
    }

    fn divergence(&self, x: &[f64]) -> f64 {
        self.divergence.at(x)
    }

    fn diffusion(&self, x: &[f64], diffusion: &mut [f64]) {
        diffusion.iter_mut().zip(&self.diffusion).for_each(|(b, [sum, ..])| *b = sum.at(x));
    }

    fn diffusion_derivatives(&self, x: &[f64], local: &mut Local) {
        local.diffusion_divergence.fill(0.0);
        local.diffusion_curvature = 0.0;
        for (k, sums) in self.diffusion.iter().enumerate() {
            local.add_derivatives(k / x.len(), k % x.len(), sums.each_ref().map(|sum| sum.at(x)));
        }
    }

    fn slopes(&self, x: &[f64], jacobian: &mut [f64]) -> f64 {
        jacobian.iter_mut().zip(&self.slopes).for_each(|(slope, sum)| *slope = sum.at(x));
        self.noise_slopes.iter().map(|sum| sum.at(x).powi(2)).sum()
    }
}

#[inline(always)]
fn on_all(sums: &[Sum], x: &[Lane], values: &mut [Lane]) {
    for (value, sum) in values.iter_mut().zip(sums) {
        *value = sum.on(x);
    }
}

/// A polynomial as a sum of products of states.
struct Sum {
    /// The coefficient of each product, and where its factors end.
    terms: Vec<(f64, usize)>,
    /// The states that are multiplied, product by product, each as often as its power.
    factors: Vec<usize>,
}

impl Sum {
    fn of(polynomial: &Polynomial) -> Self {
        let mut sum = Sum { terms: Vec::new(), factors: Vec::new() };
        for (alpha, c) in polynomial.terms().filter(|(_, c)| *c != 0.0) {
            sum.factors.extend(alpha.iter().enumerate().flat_map(|(i, &power)| (0..power).map(move |_| i)));
            sum.terms.push((c, sum.factors.len()));
        }
        sum
    }

    /// The value at all lanes.
    #[inline(always)]
    fn on<const L: usize>(&self, x: &[Lanes<L>]) -> Lanes<L> {
        let (mut sum, mut first) = (Lanes::ZERO, 0);
        for &(c, end) in &self.terms {
            let mut product = Lanes([c; L]);
            for &state in &self.factors[first..end] {
                product = product * x[state];
            }
            sum += product;
            first = end;
        }
        sum
    }

    fn at(&self, x: &[f64]) -> f64 {
        let (mut sum, mut first) = (0.0, 0);
        for &(c, end) in &self.terms {
            sum += self.factors[first..end].iter().fold(c, |product, &state| product * x[state]);
            first = end;
        }
        sum
    }
}
