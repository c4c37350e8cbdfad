//! Walls as the motion meets them.

use super::{LANES, Lane, Problem, Wall};
use crate::error::{Error, Result};
use crate::fokker_planck::FokkerPlanck;
use crate::polynomial::Polynomial;

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
    // Loops and no closures, so that they are compiled for the widest registers, together with the caller's.
    #[inline(always)]
    pub(crate) fn gaps(&self, x: &[Lane], tau: f64) -> Lane {
        let (mut gaps, rates) = (x[self.first.0], x[self.first.1]);
        for l in 0..LANES {
            gaps[l] += tau * rates[l];
        }
        if let Some((y, v)) = self.second {
            let (y, v) = (x[y], x[v]);
            for l in 0..LANES {
                gaps[l] -= y[l] + tau * v[l];
            }
        }
        for l in 0..LANES {
            gaps[l] = self.sign * (gaps[l] - self.wall.offset());
        }
        gaps
    }

    /// Their rates.
    #[inline(always)]
    pub(crate) fn rates(&self, x: &[Lane]) -> Lane {
        let mut rates = x[self.first.1];
        if let Some((_, v)) = self.second {
            let v = x[v];
            for l in 0..LANES {
                rates[l] -= v[l];
            }
        }
        for l in 0..LANES {
            rates[l] *= self.sign;
        }
        rates
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

impl Problem {
    /// The walls as the motion meets them, in their order.
    pub(crate) fn contacts(&self) -> Vec<Contact> {
        let pair = |state| (state, self.velocity_of(state).unwrap_or(state));
        let of = |wall: &Wall| {
            let sign = if wall.is_above() { 1.0 } else { -1.0 };
            let (first, second) = (pair(wall.state()), wall.other().map(pair));
            let contact = Contact { wall: *wall, sign, first, second, shares: wall.shares(), noiseless: false };
            Contact { noiseless: self.is_noiseless_at(&contact), ..contact }
        };
        self.walls().iter().map(of).collect()
    }

    /// The pairs of velocities that impacts between two bodies join.
    pub(crate) fn joined(&self) -> Vec<[usize; 2]> {
        let pair = |contact: &Contact| Some([contact.first.1, contact.second?.1]);
        self.contacts().iter().filter_map(pair).collect()
    }

    /// Refuses walls that trajectories come to rest on: there is no density then.
    ///
    /// # Errors
    /// [`Error::NoDensity`].
    pub(crate) fn require_no_rest(&self) -> Result<()> {
        let pressed = |contact: &Contact| {
            let [first, second] = [contact.first.1, contact.second.map_or(contact.first.1, |(_, v)| v)]
                .map(|v| &self.operator().drift()[v]);
            let force = if contact.second.is_some() { first - second } else { first.clone() };
            let force = &force.compose(&self.at_rest_on(contact)) * contact.sign;
            force.degree() > 0 || force.constant_term() <= 0.0
        };
        match self.contacts().iter().position(|contact| contact.is_rested_on() && pressed(contact)) {
            Some(wall) => Err(Error::no_density(format!(
                "no white noise acts on the velocity at wall {wall}, and its impacts take energy, so that trajectories come to rest on it \
                 for a share of the time; a simulation has that share and all means, or let some white noise act on the velocity"
            ))),
            None => Ok(()),
        }
    }

    /// The states as polynomials of themselves where the motion rests on a wall.
    fn at_rest_on(&self, Contact { wall, first, second, .. }: &Contact) -> Vec<Polynomial> {
        let n = self.dimension();
        let mut states: Vec<Polynomial> = (0..n).map(|i| Polynomial::variable(n, i)).collect();
        let nothing = || Polynomial::zero(n);
        let [y, v] = second.map_or([nothing(), nothing()], |(y, v)| [y, v].map(|i| Polynomial::variable(n, i)));
        (states[first.0], states[first.1]) = (y + wall.offset(), v);
        states
    }

    /// B_ww where the motion rests on a wall, and its largest coefficient anywhere.
    fn noise_of_rate(&self, contact: &Contact, operator: &FokkerPlanck) -> (Polynomial, f64) {
        let b = |i: usize, j: usize| &operator.diffusion()[i][j];
        let first = contact.first.1;
        let power = match contact.second {
            None => b(first, first).clone(),
            Some((_, v)) => &(b(first, first) + &(b(first, v) * -2.0)) + b(v, v),
        };
        (power.compose(&self.at_rest_on(contact)), largest(&power))
    }

    /// Whether B_ww vanishes wherever the motion rests on a wall.
    fn is_noiseless_at(&self, contact: &Contact) -> bool {
        let (at_rest, scale) = self.noise_of_rate(contact, self.operator());
        largest(&at_rest) <= NOTHING * scale
    }

    /// ½ B_ww where the motion rests on a wall. None where it depends on the state.
    pub(crate) fn intensity_at(&self, contact: &Contact) -> Option<f64> {
        let (at_rest, scale) = self.noise_of_rate(contact, self.operator());
        let intensity = at_rest.constant_term();
        let varying = &at_rest + &Polynomial::constant(self.dimension(), -intensity);
        (largest(&varying) <= NOTHING * scale).then_some(if contact.noiseless { 0.0 } else { intensity / 2.0 })
    }

    /// The constant part of ½ ∂B_ww/∂θ where the motion rests on a wall, of the derivative of an operator.
    pub(crate) fn intensity_rate_at(&self, contact: &Contact, derivative: &FokkerPlanck) -> f64 {
        self.noise_of_rate(contact, derivative).0.constant_term() / 2.0
    }

    /// The noise intensity D where an oscillator of a plane rests on a wall.
    pub(crate) fn intensity_at_rest(&self, wall: &Wall) -> f64 {
        let (mut drift, mut diffusion) = ([0.0; 2], [0.0; 4]);
        self.point(&[wall.offset(), 0.0], &mut drift, &mut diffusion);
        diffusion[3] / 2.0
    }

    /// The wall below the motion and the one above it, for a method of one displacement (state 0) and its velocity (state 1).
    pub(crate) fn walls_of_plane(&self, method: &'static str) -> Result<[Option<Wall>; 2]> {
        if self.walls.is_empty() {
            return Ok([None, None]);
        }
        if self.dimension() != 2 {
            let (what, remedy) =
                ("walls in other than two states", "the simulation serves walls in any number of them");
            return Err(Error::NotServed { method, what, remedy });
        }
        if self.walls.iter().any(|wall| wall.state() != 0) {
            let remedy = "let the displacement be the first state and its velocity the second";
            return Err(Error::NotServed { method, what: "a wall on the second state", remedy });
        }
        Ok([true, false].map(|above| self.walls.iter().find(|wall| wall.is_above() == above).copied()))
    }
}

/// The largest coefficient.
fn largest(p: &Polynomial) -> f64 {
    p.terms().map(|(_, c)| c.abs()).fold(0.0, f64::max)
}

/// What rounding leaves of terms that cancel, relative to the largest.
const NOTHING: f64 = 1e-12;
