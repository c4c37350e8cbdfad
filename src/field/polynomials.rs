//! Systems that are given as polynomials, and functions of them: sums of products, at all lanes at once.

use super::flow::{KickLanes, Kicks};
use super::sums::Sums;
use super::{Bridge, Field, Lane};
use crate::fokker_planck::{Local, noise_induced_drift};
use crate::numerics::Number;
use crate::polynomial::Polynomial;
use pulp::{Arch, NullaryFnOnce};

/// The polynomials of a system, and the derivatives that are asked of it.
pub(crate) struct PolynomialField {
    /// The drift as written, and after it ½ Σ_k (G_k·∇)G_k.
    drift: Sums,
    /// The Itô drift f.
    ito: Sums,
    /// The columns of G.
    columns: Vec<Sums>,
    divergence: Sums,
    /// ∂f_i/∂x_j and, of each noise, ∂G_i/∂x_j, by rows.
    slopes: Sums,
    noise_slopes: Sums,
    /// B_ij, ∂_jB_ij and ∂_i∂_jB_ij, by rows, and the first alone.
    derivatives: Sums,
    diffusion: Sums,
    /// Where noise and a jump of the drift act together, and half of each jump.
    bridges: Vec<Bridge>,
    pushes: Sums,
    /// Whether some depend on a state of another bridge.
    pushes_move: bool,
}

impl PolynomialField {
    /// `induces` adds the drift that the noise induces.
    pub(crate) fn new(drift: &[Polynomial], columns: &[Vec<Polynomial>], induces: bool) -> Self {
        let n = drift.len();
        let along = noise_induced_drift(columns, n);
        let with = |(f, induced): (&Polynomial, &Polynomial)| if induces { f + induced } else { f.clone() };
        let ito: Vec<Polynomial> = drift.iter().zip(&along).map(with).collect();
        let pairs = || (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        let b = |(i, j): (usize, usize)| columns.iter().fold(Polynomial::zero(n), |sum, g| sum + &g[i] * &g[j]);
        let diffusion: Vec<Polynomial> = pairs().map(b).collect();
        let derivatives = |((i, j), b): ((usize, usize), &Polynomial)| {
            let slope = b.derivative(j);
            let bend = slope.derivative(i);
            [b.clone(), slope, bend]
        };
        let derivatives: Vec<Polynomial> = pairs().zip(&diffusion).flat_map(derivatives).collect();
        let divergence = (0..n).fold(Polynomial::zero(n), |sum, i| sum + ito[i].derivative(i));
        let slopes_of = |g: &[Polynomial]| pairs().map(|(i, j)| g[i].derivative(j)).collect::<Vec<_>>();
        let noise_slopes: Vec<Polynomial> = columns.iter().flat_map(|column| slopes_of(column)).collect();
        PolynomialField {
            drift: Sums::of(n, &[drift, &along].concat()),
            columns: columns.iter().map(|column| Sums::of(n, column)).collect(),
            divergence: Sums::of(n, &[divergence]),
            slopes: Sums::of(n, &slopes_of(&ito)),
            noise_slopes: Sums::of(n, &noise_slopes),
            derivatives: Sums::of(n, &derivatives),
            diffusion: Sums::of(n, &diffusion),
            bridges: Vec::new(),
            pushes: Sums::of(n, &[]),
            pushes_move: false,
            ito: Sums::of(n, &ito),
        }
    }

    /// The same whose short steps take some jumps of the drift, and reflecting ends, together with the noise, which is the same
    /// everywhere; `rest` is the drift without the `pushes` of the bridges.
    pub(crate) fn bridged(self, bridges: Vec<Bridge>, pushes: &[Polynomial], rest: &[Polynomial]) -> Self {
        if bridges.is_empty() {
            return self;
        }
        let n = rest.len();
        let along = vec![Polynomial::zero(n); n];
        let drift = Sums::of(n, &[rest, &along].concat());
        let on_another = |(own, push): (&Bridge, &Polynomial)| {
            bridges.iter().any(|other| other.state != own.state && push.contains(other.state))
        };
        let pushes_move = bridges.iter().zip(pushes).any(on_another);
        PolynomialField { bridges, pushes: Sums::of(n, pushes), pushes_move, drift, ..self }
    }

    /// Adds the noise to the states, with what acts together with it.
    #[inline(never)]
    fn cross<T: Number>(&self, x: &mut [T], w: &[T], kicks: &Kicks<'_>) {
        let pushes_at = |x: &[T]| {
            let mut pushes = vec![T::everywhere(0.0); self.bridges.len()];
            self.pushes.on_all(x, &mut pushes, &mut Vec::new());
            pushes
        };
        let (mut pushes, before) = (pushes_at(x), x.to_vec());
        self.cross_by(&pushes, &before, x, w, kicks);
        // Next to its place a state moves by the root of a step in the mean, and with it what it does to others.
        if self.pushes_move {
            let after = pushes_at(x);
            pushes.iter_mut().zip(after).for_each(|(push, after)| *push = (*push + after) * 0.5);
            x.copy_from_slice(&before);
            self.cross_by(&pushes, &before, x, w, kicks);
        }
    }

    /// The same with these pushes, to the states as they were before.
    fn cross_by<T: Number>(&self, pushes: &[T], before: &[T], x: &mut [T], w: &[T], kicks: &Kicks<'_>) {
        add_noise(x, w, kicks.noise);
        for (bridge, push) in self.bridges.iter().zip(pushes) {
            let row = &kicks.noise[bridge.state * w.len()..][..w.len()];
            let variance = kicks.step * kicks.gain * kicks.gain * row.iter().map(|g| g * g).sum::<f64>();
            let (from, to) = (before[bridge.state], x[bridge.state]);
            x[bridge.state] =
                T::from_points(|l| bridge.moved(from.at(l), to.at(l) - from.at(l), push.at(l) * kicks.step, variance));
        }
    }

    /// Adds the drift at the states `at`, over the time `tau`, to `x`.
    #[inline(always)]
    fn drive<T: Number>(&self, at: &[T], (tau, moved, induced): Duration<'_>, x: &mut [T], room: &mut Vec<T>) {
        let (factors, [drift, along]) = (self.drift.factors(at, room), self.drift.halves());
        for (i, x) in x.iter_mut().enumerate() {
            let tau = tau * moved[i];
            if tau != 0.0 {
                let mut slope = drift[i].on(factors);
                if induced != 0.0 {
                    slope += along[i].on(factors) * induced;
                }
                *x += slope * tau;
            }
        }
    }

    /// The flow of the drift, by the explicit midpoint rule.
    #[inline(always)]
    fn flow<T: Number>(&self, x: &mut [T], (tau, moved, induced): Duration<'_>, [middle, room]: [&mut Vec<T>; 2]) {
        middle.clear();
        middle.extend_from_slice(x);
        self.drive(x, (tau / 2.0, moved, induced), middle, room);
        self.drive(middle, (tau, moved, induced), x, room);
    }
}

/// A time, the states that move in it, and the multiple of the drift that noise induces.
type Duration<'a> = (f64, &'a [f64], f64);

/// A kick under noise that is the same everywhere, with room for a state and for functions of it.
struct PolynomialKick<'a, T> {
    field: &'a PolynomialField,
    kicks: &'a Kicks<'a>,
    room: [&'a mut Vec<T>; 2],
}

impl<T: Number> PolynomialKick<'_, T> {
    #[inline(always)]
    fn on(&mut self, x: &mut [T], w: &[T]) {
        let PolynomialKick { field, kicks, room: [middle, room] } = self;
        let half = (kicks.step / 2.0, kicks.moved, 0.0);
        field.flow(x, half, [middle, room]);
        if field.bridges.is_empty() {
            add_noise(x, w, kicks.noise);
        } else {
            field.cross(x, w, kicks);
        }
        field.flow(x, half, [middle, room]);
    }
}

/// Adds G w.
#[inline(always)]
fn add_noise<T: Number>(x: &mut [T], w: &[T], noise: &[f64]) {
    for (x, noise) in x.iter_mut().zip(noise.chunks_exact(w.len().max(1))) {
        for (w, g) in w.iter().zip(noise) {
            *x += *w * *g;
        }
    }
}

impl KickLanes for PolynomialKick<'_, Lane> {
    #[inline(always)]
    fn kick(&mut self, x: &mut [Lane], w: &[Lane]) {
        self.on(x, w);
    }
}

/// Sums at all lanes, with the registers that the call is compiled for. This and the calls below are no closures, which the
/// compiler leaves as functions of their own, for registers of two numbers, where they are long.
struct SumsOnLanes<'a> {
    sums: &'a Sums,
    x: &'a [Lane],
    values: &'a mut [Lane],
}

impl NullaryFnOnce for SumsOnLanes<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.sums.on_all(self.x, self.values, &mut Vec::new());
    }
}

/// The flow of a column of G at all lanes, with room for two states.
struct NoiseFlowOnLanes<'a> {
    column: &'a Sums,
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
        let mut room = Vec::new();
        for (share, next) in [(1.0 / 6.0, 0.5), (1.0 / 3.0, 0.5), (1.0 / 3.0, 1.0), (1.0 / 6.0, 0.0)] {
            column.on_all(at, slope, &mut room);
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
    room: [&'a mut Vec<Lane>; 2],
}

impl NullaryFnOnce for DriftFlowOnLanes<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.field.flow(self.x, (self.tau, self.moved, self.induced), self.room);
    }
}

/// Kicks at all lanes.
struct KicksOnLanes<'a> {
    x: &'a mut [Lane],
    w: &'a [Lane],
    kick: PolynomialKick<'a, Lane>,
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
        let [mut middle, mut functions] = [Vec::with_capacity(x.len()), Vec::new()];
        let room = [&mut middle, &mut functions];
        arch.dispatch(DriftFlowOnLanes { field: self, x: to, tau, moved, induced, room });
    }

    fn kicks(&self, arch: Arch, x: &mut [Lane], w: &[Lane], kicks: &Kicks<'_>) -> (usize, bool) {
        let [mut middle, mut functions] = [Vec::with_capacity(x.len()), Vec::new()];
        let room = [&mut middle, &mut functions];
        arch.dispatch(KicksOnLanes { x, w, kick: PolynomialKick { field: self, kicks, room } })
    }

    fn kick(&self, x: &mut [f64], w: &[f64], kicks: &Kicks<'_>) {
        PolynomialKick { field: self, kicks, room: [&mut Vec::new(), &mut Vec::new()] }.on(x, w);
    }

    fn ito_drift(&self, x: &[f64], drift: &mut [f64]) {
        self.ito.on_all(x, drift, &mut Vec::new());
    }

    fn ito_drifts(&self, arch: Arch, x: &[Lane], drift: &mut [Lane]) {
        arch.dispatch(SumsOnLanes { sums: &self.ito, x, values: drift });
    }

    fn divergence(&self, x: &[f64]) -> f64 {
        let mut divergence = [0.0];
        self.divergence.on_all(x, &mut divergence, &mut Vec::new());
        divergence[0]
    }

    fn diffusion(&self, x: &[f64], diffusion: &mut [f64]) {
        self.diffusion.on_all(x, diffusion, &mut Vec::new());
    }

    fn diffusion_derivatives(&self, x: &[f64], local: &mut Local) {
        local.diffusion_divergence.fill(0.0);
        local.diffusion_curvature = 0.0;
        let mut room = Vec::new();
        let factors = self.derivatives.factors(x, &mut room);
        for (k, sums) in self.derivatives.sums.chunks_exact(3).enumerate() {
            local.add_derivatives(k / x.len(), k % x.len(), [0, 1, 2].map(|order| sums[order].on(factors)));
        }
    }

    fn slopes(&self, x: &[f64], jacobian: &mut [f64]) -> f64 {
        let mut room = Vec::new();
        self.slopes.on_all(x, jacobian, &mut room);
        let factors = self.noise_slopes.factors(x, &mut room);
        self.noise_slopes.sums.iter().map(|sum| sum.on(factors).powi(2)).sum()
    }
}
