//! Walls and levels in the straight drift between two kicks.

use super::{
    bins::Axis,
    chatter::Chatter,
    grazing::Grazing,
    group::{read_lane, write_lane},
    passage::{Passage, Passages, Record, add_powers},
    scheme::Scheme,
};
use crate::field::{LANES, Lane, Nearness};
use crate::walls::Contact;

/// The shortest rest on a wall that is counted, as a part of the time between two samples; a default time step is not longer.
const SHORTEST_REST: f64 = 0.05;

/// The most impacts in one straight piece. Between two walls they go on, and a body between a wall and another body may hit both
/// infinitely many times in a finite time: the rest of such a piece is left out.
pub(super) const MOST_IMPACTS: usize = 1 << 10;

/// The boundaries in the straight drift of the displacements: walls, and levels whose crossings are counted.
#[derive(Clone, Debug)]
pub(super) struct Boundaries {
    /// The velocity of each state that is a displacement. The levels belong to state 0 if there are any.
    velocities: Vec<Option<usize>>,
    /// The walls, and the regions near them.
    pub(super) walls: Vec<Nearness>,
    /// The rule for the length of steps near each wall.
    grazing: Vec<Grazing>,
    /// The walls that trajectories come to rest on, by their numbers.
    pub(super) chatters: Vec<Chatter>,
    /// The levels whose up-crossings by state 0 are counted.
    pub(super) levels: Vec<f64>,
    /// The limits that state 0 leaves at its first passage.
    within: Option<[f64; 2]>,
    /// The bins of the speeds at impacts, if these are counted.
    speeds: Option<Axis>,
    /// Whether each passage is recorded, not only counted.
    recording: bool,
    /// The shortest time at rest that is counted.
    pub(super) shortest_rest: f64,
}

/// Whether a displacement is beyond limits.
#[inline(always)]
pub(super) fn is_beyond([low, high]: [f64; 2], x: f64) -> bool {
    (x <= low) | (x >= high)
}

impl Boundaries {
    /// The boundaries that the trajectories of a system meet: the noise in the rule for grazing is that at rest on a wall.
    pub(super) fn for_scheme(scheme: &Scheme<'_>, contacts: &[Contact], levels: Vec<f64>) -> Self {
        let velocity = |i: usize| scheme.pairs.iter().find(|&&(x, _)| x == i).map(|&(_, v)| v);
        let grazing = |contact: &Contact| {
            let noise = scheme.noise_at(&contact.at_rest(scheme.states));
            let diffusion = contact.of_rate(|i, j| noise[i * scheme.states + j]) / 2.0;
            Grazing::new(&contact.wall, diffusion.max(0.0), scheme.step)
        };
        let grazing: Vec<Grazing> = contacts.iter().map(grazing).collect();
        let near = |(contact, grazing): (&Contact, &Grazing)| Nearness {
            contact: *contact,
            height: grazing.height,
            speed: grazing.speed,
        };
        let at_rest = |(wall, contact)| Chatter::at(wall, contact, scheme);
        Boundaries {
            velocities: (0..scheme.states).map(velocity).collect(),
            walls: contacts.iter().zip(&grazing).map(near).collect(),
            chatters: contacts.iter().enumerate().filter_map(at_rest).collect(),
            grazing,
            levels,
            within: None,
            speeds: None,
            recording: false,
            shortest_rest: f64::INFINITY,
        }
    }

    /// The same boundaries, on which the crossings of levels are counted, the speeds of impacts in bins, and the times at rest beside
    /// which the interval between two samples is not long.
    pub(super) fn counting(self, levels: Vec<f64>, speeds: Option<Axis>, interval: f64) -> Self {
        Boundaries { levels, speeds, shortest_rest: SHORTEST_REST * interval, ..self }
    }

    /// The same boundaries, with or without a record of all passages.
    pub(super) fn recording(self, recording: bool) -> Self {
        Boundaries { recording, ..self }
    }

    /// The same boundaries, with limits of state 0 that trajectories leave.
    pub(super) fn within(self, within: Option<[f64; 2]>) -> Self {
        Boundaries { within, ..self }
    }

    /// Whether every step is to be seen: for crossings of levels, or for first passages.
    #[inline(always)]
    pub(super) fn are_watched(&self) -> bool {
        !self.levels.is_empty() || self.within.is_some()
    }

    /// No passages yet.
    pub(super) fn passages(&self) -> Passages {
        Passages::new([self.levels.len(), self.walls.len(), self.velocities.len()], self.speeds)
    }

    /// The length of the step that a trajectory needs where it grazes a wall, if that is not the whole one.
    #[inline]
    pub(super) fn step_at(&self, x: &[f64]) -> Option<f64> {
        let walls = self.walls.iter().zip(&self.grazing);
        let steps = walls.filter_map(|(wall, grazing)| {
            let (u, rate) = (wall.contact.gap(x), wall.contact.rate(x));
            wall.grazes(u, rate).then(|| grazing.step_at(u, rate)).flatten()
        });
        steps.reduce(f64::min)
    }

    /// Every displacement straight on for the time `tau`, its velocity frozen. Only the lanes of `counted` count passages; the
    /// others may be left anywhere. `state` has room for one of them.
    ///
    /// The path is a straight line, so that the times of contact with walls are exact.
    #[inline(always)]
    pub(super) fn drift(
        &self,
        from: &[Lane],
        tau: f64,
        counted: impl Fn(usize) -> bool,
        (x, state): (&mut [Lane], &mut [f64]),
        passages: &mut Passages,
    ) {
        for (i, velocity) in self.velocities.iter().enumerate() {
            x[i] = velocity.map_or(from[i], |v| from[i] + from[v] * tau);
        }
        let mut beyond = [false; LANES];
        for wall in &self.walls {
            let gaps = wall.contact.gaps(from, tau);
            for l in 0..LANES {
                beyond[l] |= gaps[l] < 0.0;
            }
        }
        if beyond.contains(&true) {
            for l in (0..LANES).filter(|&l| beyond[l] && counted(l)) {
                read_lane(from, l, state);
                self.drift_lane(state, l, tau, passages);
                write_lane(state, l, x);
            }
        }
        if let Some(within) = self.within {
            for l in (0..LANES).filter(|&l| !beyond[l] && counted(l)) {
                passages.left |= u64::from(is_beyond(within, x[0][l])) << l;
            }
        }
        for (k, &level) in self.levels.iter().enumerate() {
            let (before, after) = (from[0], x[0]);
            let mut any = false;
            for l in 0..LANES {
                any |= (before[l] < level) & (after[l] >= level);
            }
            for l in (0..LANES).filter(|&l| any && !beyond[l] && counted(l)) {
                let speed = self.velocities[0].map_or(0.0, |v| x[v][l]);
                self.count(k, level, l, [before[l], after[l]], speed, passages);
            }
        }
    }

    /// The same for the state of one lane, from one contact to the next.
    pub(super) fn drift_lane(&self, x: &mut [f64], lane: usize, tau: f64, passages: &mut Passages) {
        let mut left = tau;
        for _ in 0..MOST_IMPACTS {
            let Some((wall, time)) = self.first_contact(x, left) else {
                return self.straight_on(x, lane, left, passages);
            };
            self.straight_on(x, lane, time, passages);
            self.impact(wall, x, lane, passages);
            left -= time;
        }
    }

    /// The first wall that is met within the time `left`, and when.
    fn first_contact(&self, x: &[f64], left: f64) -> Option<(usize, f64)> {
        let mut first: Option<(usize, f64)> = None;
        for (k, Nearness { contact, .. }) in self.walls.iter().enumerate() {
            let rate = contact.rate(x);
            if rate < 0.0 && contact.gap_after(x, left) < 0.0 {
                // Rounding may put the contact a hair outside the piece.
                let time = (contact.gap(x) / -rate).clamp(0.0, left);
                if first.is_none_or(|(_, earliest)| time < earliest) {
                    first = Some((k, time));
                }
            }
        }
        first
    }

    /// A piece without contact.
    fn straight_on(&self, x: &mut [f64], lane: usize, tau: f64, passages: &mut Passages) {
        let before = x[0];
        for (i, velocity) in self.velocities.iter().enumerate() {
            if let Some(v) = *velocity {
                x[i] += tau * x[v];
            }
        }
        passages.left |= u64::from(self.within.is_some_and(|within| is_beyond(within, x[0]))) << lane;
        for (k, &level) in self.levels.iter().enumerate() {
            self.count(k, level, lane, [before, x[0]], self.velocities[0].map_or(0.0, |v| x[v]), passages);
        }
    }

    /// The impact at a wall.
    fn impact(&self, wall: usize, x: &mut [f64], lane: usize, passages: &mut Passages) {
        let contact = &self.walls[wall].contact;
        contact.close(x);
        let approach = -contact.rate(x);
        add_powers(&mut passages.impacts[wall], approach);
        if let Some(axis) = self.speeds {
            passages.speeds[wall].add(&[axis], &[approach]);
        }
        if self.recording {
            let Record { passages, impacts, states } = &mut passages.record;
            passages.push(Passage { lane, gate: self.levels.len() + wall, speed: approach });
            impacts.push((lane, wall));
            states.extend_from_slice(x);
        }
        for v in contact.velocities() {
            passages.taken[v] += x[v] * x[v] / 2.0;
        }
        contact.collide(contact.wall.restitution(), x);
        for v in contact.velocities() {
            passages.taken[v] -= x[v] * x[v] / 2.0;
        }
    }

    /// Counts an up-crossing of level number `k` by a lane, if its straight piece is one.
    fn count(&self, k: usize, level: f64, lane: usize, [before, after]: [f64; 2], speed: f64, passages: &mut Passages) {
        if before < level && after >= level {
            add_powers(&mut passages.crossings[k], speed);
            passages.crossed[k] |= 1 << lane;
            if self.recording {
                passages.record.passages.push(Passage { lane, gate: k, speed });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Result;
    use crate::models::{Duffing, DuffingChain, Solved};
    use crate::numerics::Lanes;
    use crate::problem::Problem;
    use crate::walls::Wall;

    fn boundaries(problem: &Problem, levels: Vec<f64>) -> Boundaries {
        Boundaries::for_scheme(&Scheme::new(problem, 1.0, 0.1), &problem.contacts(), levels)
    }

    fn above() -> Result<Problem> {
        Duffing::new(0.2, 1.0, 0.0, 0.2)?.problem()?.with_wall(Wall::above(0.5, 0.5)?)
    }

    /// Every other lane in one of two states.
    fn lanes([y, v]: [[f64; 2]; 2]) -> [Lane; 2] {
        [y, v].map(|pair| Lanes(std::array::from_fn(|l| pair[l % 2])))
    }

    /// From y = 0.75 at v = −1 the wall at 0.5 is reached after 0.25; the other 0.75 s go back at 0.5. All numbers are
    /// exact in binary.
    #[test]
    fn an_impact_is_exact() -> Result<()> {
        let boundaries = boundaries(&above()?, vec![0.625, 2.0]);
        let (mut passages, mut x, mut state) = (boundaries.passages(), [Lane::ZERO; 2], [0.0; 2]);
        let from = lanes([[0.75, 1.0], [-1.0, -0.25]]);
        boundaries.drift(&from, 1.0, |l| l < 2, (&mut x, &mut state), &mut passages);
        assert_eq!([&x[0].0[..2], &x[1].0[..2]], [[0.875, 0.75], [0.5, -0.25]]);
        assert_eq!(passages.impacts, [[1.0; 3]]);
        assert_eq!(passages.taken, [0.0, 0.375]);
        assert_eq!(passages.crossings, [[1.0, 0.5, 0.25], [0.0; 3]]);
        assert_eq!(passages.crossed, [1, 0]);
        Ok(())
    }

    /// From every state the wall holds, and a non-finite state ends the piece as well.
    #[test]
    fn no_state_is_below_the_wall() -> Result<()> {
        let boundaries = boundaries(&above()?, vec![]);
        let (mut passages, mut x, mut state) = (boundaries.passages(), [Lane::ZERO; 2], [0.0; 2]);
        for k in 0..1000 {
            let v = -1.3_f64.powi(k - 500);
            let from = lanes([[0.5, 0.5 + f64::EPSILON], [v, v]]);
            boundaries.drift(&from, 0.1, |_| true, (&mut x, &mut state), &mut passages);
            assert!(x[0].0.iter().all(|&y| y >= 0.5));
        }
        let from = lanes([[0.5, f64::NAN], [f64::NEG_INFINITY, f64::NAN]]);
        boundaries.drift(&from, 0.1, |_| true, (&mut x, &mut state), &mut passages);
        Ok(())
    }

    /// Between walls at 0 and 1, from 0.25 at the velocity −4: one impact after 1/16, with r = 1/2, the other after 9/16, and 7/16
    /// remain at the velocity −2 to get from 1 to 1/8. All numbers are exact in binary.
    #[test]
    fn a_piece_holds_several_impacts() -> Result<()> {
        let problem = Duffing::new(0.2, 1.0, 0.0, 0.2)?.problem()?;
        let problem = problem.with_wall(Wall::above(0.0, 0.5)?)?.with_wall(Wall::below(1.0, 1.0)?)?;
        let boundaries = boundaries(&problem, vec![0.5]);
        let (mut passages, mut state) = (boundaries.passages(), [0.25, -4.0]);
        boundaries.drift_lane(&mut state, 0, 1.0, &mut passages);
        assert_eq!(state, [0.125, -2.0]);
        assert_eq!(passages.impacts, [[1.0, 4.0, 16.0], [1.0, 2.0, 4.0]]);
        assert_eq!(passages.crossings, [[1.0, 2.0, 4.0]]);
        Ok(())
    }

    /// A body of mass 3 hits one of mass 1 at rest: it keeps momentum 3/2 of 3/2 + 3/2, for r = 1, and the other hits a wall and
    /// comes back.
    #[test]
    fn two_bodies_keep_their_momentum() -> Result<()> {
        let chain = DuffingChain::new(&[0.2, 0.2], 1.0, 0.0, 0.5, 0.8)?.problem()?;
        let between = Wall::below(0.0, 1.0)?.between([0, 2], [3.0, 1.0])?;
        let problem = chain.with_wall(between)?.with_wall(Wall::below(1.5, 0.5)?.on(2))?;
        let boundaries = boundaries(&problem, vec![]);
        let mut passages = boundaries.passages();
        let mut state = [-1.0, 1.0, 0.0, 0.0];
        // They meet after 1, and part with 1/2 and 3/2; the second is at its wall 1 later, and has come back by 3/8 after 1/2.
        boundaries.drift_lane(&mut state, 0, 2.5, &mut passages);
        assert_eq!(state, [0.75, 0.5, 1.125, -0.75]);
        assert_eq!(passages.impacts, [[1.0; 3], [1.0, 1.5, 2.25]]);
        // Energies: 3/8 × 3 go over at the first impact.
        assert_eq!(passages.taken, [0.0, 0.375, 0.0, -1.125 + 1.125 - 0.28125]);
        Ok(())
    }
}
