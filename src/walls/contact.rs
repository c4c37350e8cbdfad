//! Walls as the motion meets them.

use super::Wall;
use crate::numerics::Lanes;

/// A wall by the gap g = ±(y_i − y_j − b) ≥ 0 between motion and wall, y_j = 0 for a single displacement.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contact {
    pub(crate) wall: Wall,
    /// 1 for a motion above the wall, −1 for one below it.
    sign: f64,
    /// y_i and its velocity.
    first: (usize, usize),
    /// y_j and its velocity.
    second: Option<(usize, usize)>,
    /// The parts of an impulse that the two velocities take.
    shares: [f64; 2],
    /// Whether no white noise acts on the rate of the gap while the motion rests on the wall.
    pub(crate) noiseless: bool,
}

impl Contact {
    /// Of a wall on states that have these velocities, where some white noise may act on the rate of the gap.
    pub(crate) fn new(wall: &Wall, velocity_of: impl Fn(usize) -> usize) -> Self {
        let pair = |state: usize| (state, velocity_of(state));
        let sign = if wall.is_above() { 1.0 } else { -1.0 };
        let (first, second) = (pair(wall.state()), wall.other().map(pair));
        Contact { wall: *wall, sign, first, second, shares: wall.shares(), noiseless: false }
    }

    /// The gap.
    #[inline]
    pub(crate) fn gap(&self, x: &[f64]) -> f64 {
        self.sign * (x[self.first.0] - self.second.map_or(0.0, |(y, _)| x[y]) - self.wall.offset())
    }

    /// What the gap changes by with a state: ±1 for a displacement of its bodies, 0 for all others.
    pub(crate) fn gap_slope(&self, state: usize) -> f64 {
        let of = |body: Option<(usize, usize)>| f64::from(u8::from(body.is_some_and(|(y, _)| y == state)));
        self.sign * (of(Some(self.first)) - of(self.second))
    }

    /// The rate of the gap; minus the speed of approach.
    #[inline]
    pub(crate) fn rate(&self, x: &[f64]) -> f64 {
        self.sign * (x[self.first.1] - self.second.map_or(0.0, |(_, v)| x[v]))
    }

    /// The gap at the time `tau` from now, with the velocities as they are.
    #[inline]
    pub(crate) fn gap_after(&self, x: &[f64], tau: f64) -> f64 {
        let ahead = |(y, v): (usize, usize)| x[y] + tau * x[v];
        let y = self.second.map_or(ahead(self.first), |second| ahead(self.first) - ahead(second));
        self.sign * (y - self.wall.offset())
    }

    /// The gaps of some states at the time `tau` from now, with their velocities as they are.
    // No closures, so that they are compiled for the widest registers, together with the caller's.
    #[inline(always)]
    pub(crate) fn gaps<const L: usize>(&self, x: &[Lanes<L>], tau: f64) -> Lanes<L> {
        let mut gaps = x[self.first.0] + x[self.first.1] * tau;
        if let Some((y, v)) = self.second {
            gaps = gaps - (x[y] + x[v] * tau);
        }
        (gaps - self.wall.offset()) * self.sign
    }

    /// Their rates.
    #[inline(always)]
    pub(crate) fn rates<const L: usize>(&self, x: &[Lanes<L>]) -> Lanes<L> {
        let mut rates = x[self.first.1];
        if let Some((_, v)) = self.second {
            rates = rates - x[v];
        }
        rates * self.sign
    }

    /// Whether the motion is on the wall or behind it, up to the rounding of its displacements.
    pub(crate) fn touches(&self, x: &[f64]) -> bool {
        self.gap(x) <= self.rounding(x)
    }

    /// Whether it is behind the wall, by more than that rounding.
    pub(crate) fn is_behind(&self, x: &[f64]) -> bool {
        self.gap(x) < -self.rounding(x)
    }

    fn rounding(&self, x: &[f64]) -> f64 {
        self.second.map_or(0.0, |(y, _)| 8.0 * f64::EPSILON * (x[self.first.0].abs() + x[y].abs()))
    }

    /// Whether trajectories come to rest on the wall: no noise drives them off it, and impacts take energy.
    pub(crate) fn is_rested_on(&self) -> bool {
        self.noiseless && self.wall.restitution() < 1.0
    }

    /// Whether the motion rests on the wall.
    pub(crate) fn rests(&self, x: &[f64]) -> bool {
        self.touches(x) && self.rate(x) == 0.0
    }

    /// Puts the motion onto the wall.
    #[inline]
    pub(crate) fn close(&self, x: &mut [f64]) {
        match self.second {
            None => x[self.first.0] = self.wall.offset(),
            Some((second, _)) => {
                let first = self.first.0;
                let excess = x[first] - x[second] - self.wall.offset();
                x[second] += self.shares[1] * excess;
                x[first] = x[second] + self.wall.offset();
            }
        }
    }

    /// Puts a motion behind the wall as far before it.
    pub(crate) fn mirror(&self, x: &mut [f64]) {
        let before: Vec<f64> = x.to_vec();
        self.close(x);
        x.iter_mut().zip(before).for_each(|(x, before)| *x += *x - before);
    }

    /// The impact of restitution `r`: the rate of the gap is turned round, and the momentum of two bodies kept.
    #[inline]
    pub(crate) fn collide(&self, r: f64, x: &mut [f64]) {
        let first = self.first.1;
        match self.second {
            None => x[first] *= -r,
            Some((_, second)) => {
                let change = (1.0 + r) * (x[first] - x[second]);
                x[second] += self.shares[1] * change;
                // A rebound of zero leaves the two with one velocity, whatever the rounding.
                x[first] = if r == 0.0 { x[second] } else { x[first] - self.shares[0] * change };
            }
        }
    }

    /// The displacement and the velocity of each of the wall's bodies.
    pub(crate) fn bodies(&self) -> ((usize, usize), Option<(usize, usize)>) {
        (self.first, self.second)
    }

    /// Puts the first body onto the wall, with a speed of approach, whatever it was before.
    pub(crate) fn approach(&self, speed: f64, x: &mut [f64]) {
        let [y, v] = self.second.map_or([0.0; 2], |(y, v)| [x[y], x[v]]);
        x[self.first.0] = y + self.wall.offset();
        x[self.first.1] = v - self.sign * speed;
    }

    /// Adds the force of the contact to the drift of a state at rest on the wall: the acceleration of the gap is not below zero.
    pub(crate) fn support(&self, drift: &mut [f64]) {
        let acceleration = self.rate(drift);
        if acceleration < 0.0 {
            drift[self.first.1] -= self.sign * self.shares[0] * acceleration;
            if let Some((_, second)) = self.second {
                drift[second] += self.sign * self.shares[1] * acceleration;
            }
        }
    }

    /// The entry of a symmetric matrix of the states that belongs to the rate of the gap, such as B_ww of the noise.
    pub(crate) fn of_rate(&self, entry: impl Fn(usize, usize) -> f64) -> f64 {
        let first = self.first.1;
        match self.second {
            None => entry(first, first),
            Some((_, second)) => entry(first, first) - 2.0 * entry(first, second) + entry(second, second),
        }
    }

    /// The state at rest on the wall, all other displacements at 0 as well as the velocities.
    pub(crate) fn at_rest(&self, states: usize) -> Vec<f64> {
        let mut x = vec![0.0; states];
        self.close(&mut x);
        x
    }

    /// The gap's velocities.
    pub(crate) fn velocities(&self) -> impl Iterator<Item = usize> {
        std::iter::once(self.first.1).chain(self.second.map(|(_, v)| v))
    }
}
