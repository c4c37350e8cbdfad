//! Flows of fields over short times, and steps that are made of them.

use super::{LANES, Lane};
use crate::walls::Contact;

/// Time steps under noise that is the same everywhere: kicks F(h/2) W(h) F(h/2), between them every displacement straight on.
pub(crate) struct Kicks<'a> {
    /// The time step h.
    pub(crate) step: f64,
    /// 1 for a state that F moves, 0 for a displacement.
    pub(crate) moved: &'a [f64],
    /// Each displacement with its velocity.
    pub(crate) pairs: &'a [(usize, usize)],
    /// G, by rows.
    pub(crate) noise: &'a [f64],
    /// The factor that the increments have beside the root of the time step.
    pub(crate) gain: f64,
    /// The walls that interrupt the steps; without a list each kick does.
    pub(crate) walls: Option<&'a [Nearness]>,
    /// The number of kicks.
    pub(crate) count: usize,
    /// Changes of states after them, in their order.
    pub(crate) additions: &'a [Addition],
}

/// What is added to a state of one lane after the straight piece behind a kick.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Addition {
    /// The number of the kick.
    pub(crate) kick: usize,
    pub(crate) state: usize,
    pub(crate) lane: usize,
    pub(crate) by: f64,
}

/// The region in which a trajectory is near a wall.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nearness {
    pub(crate) contact: Contact,
    /// The height and the speed below which a trajectory may graze the wall.
    pub(crate) height: f64,
    pub(crate) speed: f64,
}

impl Nearness {
    /// Marks the lanes that meet the wall within the time `tau`, or may graze it after half of that.
    #[inline(always)]
    pub(crate) fn mark(&self, x: &[Lane], tau: f64, near: &mut [bool; LANES]) {
        let (end, middle, rate) = (self.contact.gaps(x, tau), self.contact.gaps(x, tau / 2.0), self.contact.rates(x));
        for l in 0..LANES {
            near[l] |= (end[l] < 0.0) | self.grazes(middle[l], rate[l]);
        }
    }

    /// Whether a trajectory at the height `u` above the wall may graze it.
    #[inline(always)]
    pub(crate) fn grazes(&self, u: f64, rate: f64) -> bool {
        (u < self.height) & (rate.abs() < self.speed)
    }
}

/// The lanes that are near a wall.
#[inline(always)]
pub(crate) fn near(walls: &[Nearness], x: &[Lane], tau: f64) -> [bool; LANES] {
    let mut near = [false; LANES];
    for wall in walls {
        wall.mark(x, tau, &mut near);
    }
    near
}

/// A kick without the straight piece after it, at all lanes. No closure, which the compiler leaves as a function of its own, for
/// registers of two numbers, where it is long.
pub(super) trait KickLanes {
    /// Takes the states `x` through it for the increments `w` of all processes.
    fn kick(&mut self, x: &mut [Lane], w: &[Lane]);
}

impl Kicks<'_> {
    /// Kicks for the increments `w`, which are those of all processes for each, and every displacement straight on after it.
    /// They end after a kick that leaves a trajectory near the wall. Returned is their number, and whether they ended so.
    #[inline(always)]
    pub(super) fn run(&self, x: &mut [Lane], w: &[Lane], processes: usize, mut kick: impl KickLanes) -> (usize, bool) {
        let mut additions = self.additions;
        for before in 0..self.count {
            kick.kick(x, &w[before * processes..][..processes]);
            if self.walls.is_none_or(|walls| near(walls, x, self.step).contains(&true)) {
                return (before + 1, true);
            }
            for &(i, v) in self.pairs {
                x[i] += x[v] * self.step;
            }
            while let [Addition { kick, state, lane, by }, later @ ..] = additions
                && *kick == before
            {
                x[*state][*lane] += by;
                additions = later;
            }
        }
        (self.count, false)
    }
}

/// F W F: the flow of the drift over the time `half`, G w with the entries `noise` of G, and the flow once more.
#[inline(always)]
pub(super) fn kick<const N: usize>(
    x: [f64; N],
    half: f64,
    moved: &[f64],
    noise: impl Fn(usize, usize) -> f64,
    w: &[f64],
    drift: impl Fn([f64; N]) -> [f64; N],
) -> [f64; N] {
    let mut x = midpoint(x, half, moved, &drift);
    for (i, x) in x.iter_mut().enumerate() {
        for (k, w) in w.iter().enumerate() {
            *x += w * noise(i, k);
        }
    }
    midpoint(x, half, moved, drift)
}

/// The explicit midpoint rule.
#[inline(always)]
pub(super) fn midpoint<const N: usize>(
    x: [f64; N],
    tau: f64,
    moved: &[f64],
    drift: impl Fn([f64; N]) -> [f64; N],
) -> [f64; N] {
    let middle = ahead(x, drift(x), |i| moved[i] * (tau / 2.0));
    ahead(x, drift(middle), |i| moved[i] * tau)
}

/// The classical Runge-Kutta rule.
#[inline(always)]
pub(super) fn runge_kutta<const N: usize>(x: [f64; N], s: f64, field: impl Fn([f64; N]) -> [f64; N]) -> [f64; N] {
    let first = field(x);
    let second = field(ahead(x, first, |_| s / 2.0));
    let third = field(ahead(x, second, |_| s / 2.0));
    let last = field(ahead(x, third, |_| s));
    let sum = std::array::from_fn(|i| first[i] + (second[i] + third[i]) * 2.0 + last[i]);
    ahead(x, sum, |_| s / 6.0)
}

/// x_i + τ_i × slope_i.
#[inline(always)]
fn ahead<const N: usize>(mut x: [f64; N], slope: [f64; N], tau: impl Fn(usize) -> f64) -> [f64; N] {
    for i in 0..N {
        x[i] += slope[i] * tau(i);
    }
    x
}
