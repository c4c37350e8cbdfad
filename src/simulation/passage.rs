use super::{
    grazing::Grazing,
    histogram::{Axis, Counts},
    scheme::Scheme,
};
use crate::error::{Error, Result};
use crate::problem::{LANES, Lane, Nearness, Problem, Wall};
use serde::{Deserialize, Serialize};

/// The powers 0, 1, 2 of the speed at a passage: enough for the flux moments 1, 2, 3.
pub(super) const POWERS: usize = 3;

/// The wall of a problem, if it has none but one with the motion of state 0 above it.
pub(super) fn single_wall(problem: &Problem, method: &'static str) -> Result<Option<Wall>> {
    let (what, remedy) = match problem.walls() {
        [] => return Ok(None),
        [wall] if wall.state() != 0 => {
            ("a wall on another state than the first", "let the displacement that hits the wall be the first state")
        }
        [wall] if wall.is_above() => return Ok(Some(*wall)),
        [_] => ("a wall that the motion is below", "turn the sign of the displacement and of its velocity"),
        _ => ("more than one wall", "a closure and a grid serve the two walls of one oscillator"),
    };
    Err(Error::NotServed { method, what, remedy })
}

/// The boundaries in the straight drift of the displacements: a wall, and levels whose crossings are counted.
#[derive(Clone, Debug)]
pub(super) struct Boundaries {
    /// The velocity of each state that is a displacement. The wall and the levels belong to state 0 if there are any.
    velocities: Vec<Option<usize>>,
    /// The wall's position, −∞ if there is none, and the region near it.
    pub(super) wall: Nearness,
    restitution: f64,
    /// The rule for the length of steps near it.
    pub(super) grazing: Grazing,
    /// The levels whose up-crossings by state 0 are counted.
    pub(super) levels: Vec<f64>,
    /// The bins of the speeds at impacts, if these are counted.
    speeds: Option<Axis>,
    /// Whether each passage is recorded, not only counted.
    recording: bool,
}

/// Impacts and up-crossings: Σ 1, Σ|v|, Σ v² over the passages of each kind.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub(super) struct Passages {
    /// At the wall, with the speed of approach.
    pub(super) impacts: [f64; POWERS],
    /// At each level.
    pub(super) crossings: Vec<[f64; POWERS]>,
    /// For each level the lanes that have crossed it since this was last cleared, one bit each.
    pub(super) crossed: Vec<u64>,
    /// The speeds of approach at impacts.
    pub(super) speeds: Counts,
    #[serde(skip)]
    pub(super) record: Record,
}

/// The passages of one group of trajectories on one stretch, each by itself.
#[derive(Clone, Debug, Default)]
pub(super) struct Record {
    pub(super) passages: Vec<Passage>,
    /// The lane of each impact, and the state at it with the velocity of approach.
    pub(super) lanes: Vec<usize>,
    pub(super) states: Vec<f64>,
}

/// A lane at one of the levels, or, with a number after theirs, at the wall.
#[derive(Clone, Copy, Debug)]
pub(super) struct Passage {
    pub(super) lane: usize,
    pub(super) gate: usize,
    pub(super) speed: f64,
}

impl Record {
    fn clear(&mut self) {
        let Record { passages, lanes, states } = self;
        passages.clear();
        lanes.clear();
        states.clear();
    }
}

impl Passages {
    pub(super) fn new(levels: usize) -> Self {
        Passages {
            impacts: [0.0; POWERS],
            crossings: vec![[0.0; POWERS]; levels],
            crossed: vec![0; levels],
            speeds: Counts::default(),
            record: Record::default(),
        }
    }

    /// Clears the lanes of the passages, which belong to one group only.
    pub(super) fn forget(&mut self) {
        self.crossed.fill(0);
        self.record.clear();
    }
}

impl Boundaries {
    /// `diffusion` is ½B_vv at rest on the wall.
    pub(super) fn new(
        velocities: Vec<Option<usize>>,
        wall: Option<Wall>,
        levels: Vec<f64>,
        diffusion: f64,
        step: f64,
    ) -> Self {
        let (floor, restitution) = wall.map_or((f64::NEG_INFINITY, 1.0), |b| (b.offset(), b.restitution()));
        let offset = wall.map_or(0.0, |b| b.offset());
        let grazing = Grazing::new(restitution, offset, diffusion, step);
        let velocity = velocities[0].unwrap_or(0);
        let wall = Nearness { velocity, floor, height: grazing.height, speed: grazing.speed };
        Boundaries { velocities, wall, restitution, grazing, levels, speeds: None, recording: false }
    }

    /// The boundaries that the trajectories of a system meet: the noise in the rule for grazing is that at rest on the wall.
    pub(super) fn for_scheme(scheme: &Scheme<'_>, wall: Option<Wall>, levels: Vec<f64>) -> Self {
        let mut at_rest = vec![0.0; scheme.states];
        at_rest[0] = wall.map_or(0.0, |b| b.offset());
        let velocity = |i: usize| scheme.pairs.iter().find(|&&(x, _)| x == i).map(|&(_, v)| v);
        let diffusion = velocity(0).map_or(0.0, |v| scheme.power(v, &at_rest, &mut scheme.scratch())[0]);
        Boundaries::new((0..scheme.states).map(velocity).collect(), wall, levels, diffusion, scheme.step)
    }

    /// The same boundaries, on which the crossings of `levels` and the `speeds` of impacts are counted, and all passages
    /// recorded if `recording`.
    pub(super) fn counting(self, levels: Vec<f64>, speeds: Option<Axis>, recording: bool) -> Self {
        Boundaries { levels, speeds, recording, ..self }
    }

    /// No passages yet.
    pub(super) fn passages(&self) -> Passages {
        let speeds = self.speeds.map(|axis| Counts::new(&[axis])).unwrap_or_default();
        Passages { speeds, ..Passages::new(self.levels.len()) }
    }

    /// The state that moves state 0.
    #[inline(always)]
    pub(super) fn velocity(&self) -> usize {
        self.wall.velocity
    }

    /// Turns the velocity of approach into that of rebound.
    #[inline]
    pub(super) fn throw_back(&self, v: f64) -> f64 {
        -self.restitution * v
    }

    /// The length of the step that a trajectory needs: the whole one, or a shorter one where it grazes the wall.
    #[inline]
    pub(super) fn step_at(&self, y: f64, v: f64) -> Option<f64> {
        let u = y - self.wall.floor;
        self.wall.grazes(u, v).then(|| self.grazing.step_at(u, v)).flatten()
    }

    /// Every displacement straight on for the time `tau`, its velocity frozen. Only the lanes of `counted` count passages; the
    /// others may be left anywhere.
    ///
    /// The path is a straight line, so that the time of contact with the wall is exact. After the rebound the velocity
    /// points away from the wall and nothing turns it within the straight piece: there is at most one contact in it. An
    /// infinite sequence of ever shorter rebounds is thereby cut at one contact per step; rebounds lower than about
    /// (force × h²) are not resolved, and the next kick ends them.
    #[inline(always)]
    pub(super) fn drift(
        &self,
        from: &[Lane],
        tau: f64,
        counted: impl Fn(usize) -> bool,
        x: &mut [Lane],
        passages: &mut Passages,
    ) {
        for (i, velocity) in self.velocities.iter().enumerate() {
            x[i] = from[i];
            if let Some(v) = *velocity {
                for l in 0..LANES {
                    x[i][l] += tau * from[v][l];
                }
            }
        }
        let mut before = from[0];
        let mut contact = false;
        for y in x[0] {
            contact |= y < self.wall.floor;
        }
        let v = self.velocity();
        if contact {
            for l in (0..LANES).filter(|&l| counted(l)) {
                if x[0][l] < self.wall.floor {
                    let end = |i: usize| x[i][l];
                    [before[l], x[0][l], x[v][l]] = self.rebound(l, before[l], tau, end, passages);
                }
            }
        }
        for (k, &level) in self.levels.iter().enumerate() {
            let after = x[0];
            let mut any = false;
            for l in 0..LANES {
                any |= (before[l] < level) & (after[l] >= level);
            }
            for l in (0..LANES).filter(|&l| any && counted(l)) {
                self.count(k, level, l, [before[l], after[l]], x[v][l], passages);
            }
        }
    }

    /// The same for the state of one lane.
    pub(super) fn drift_lane(&self, x: &mut [f64], lane: usize, tau: f64, passages: &mut Passages) {
        let (mut before, v) = (x[0], self.velocity());
        for (i, velocity) in self.velocities.iter().enumerate() {
            if let Some(v) = *velocity {
                x[i] += tau * x[v];
            }
        }
        if x[0] < self.wall.floor {
            let end = |i: usize| x[i];
            [before, x[0], x[v]] = self.rebound(lane, before, tau, end, passages);
        }
        for (k, &level) in self.levels.iter().enumerate() {
            self.count(k, level, lane, [before, x[0]], x[v], passages);
        }
    }

    /// The impact in a straight piece that would end in the state `end` if there were no wall: the wall, where the piece
    /// begins anew, and place and velocity at its end.
    fn rebound(
        &self,
        lane: usize,
        before: f64,
        tau: f64,
        end: impl Fn(usize) -> f64,
        passages: &mut Passages,
    ) -> [f64; 3] {
        let approach = -end(self.velocity());
        add_powers(&mut passages.impacts, approach);
        if let Some(axis) = self.speeds {
            passages.speeds.add(&[axis], &[approach]);
        }
        // Rounding may put the contact a hair after the end of the piece.
        let rest = (tau - (before - self.wall.floor) / approach).max(0.0);
        if self.recording {
            let Record { passages, lanes, states } = &mut passages.record;
            passages.push(Passage { lane, gate: self.levels.len(), speed: approach });
            lanes.push(lane);
            let velocities = self.velocities.iter().enumerate();
            states.extend(velocities.map(|(i, v)| end(i) - v.map_or(0.0, |v| rest * end(v))));
        }
        let v = self.restitution * approach;
        [self.wall.floor, self.wall.floor + v * rest, v]
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

/// 1, |v|, v².
pub(super) fn powers(speed: f64) -> [f64; POWERS] {
    [1.0, speed, speed * speed]
}

fn add_powers(sums: &mut [f64; POWERS], speed: f64) {
    sums.iter_mut().zip(powers(speed)).for_each(|(sum, power)| *sum += power);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn boundaries(levels: Vec<f64>) -> Result<Boundaries> {
        Ok(Boundaries::new(vec![Some(1), None], Some(Wall::above(0.5, 0.5)?), levels, 0.2, 0.1))
    }

    /// Every other lane in one of two states.
    fn lanes([y, v]: [[f64; 2]; 2]) -> [Lane; 2] {
        [y, v].map(|pair| std::array::from_fn(|l| pair[l % 2]))
    }

    /// From y = 0.75 at v = −1 the wall at 0.5 is reached after 0.25; the other 0.75 s go back at 0.5. All numbers are
    /// exact in binary.
    #[test]
    fn an_impact_is_exact() -> Result<()> {
        let mut passages = Passages::new(2);
        let mut x = [[0.0; LANES]; 2];
        let from = lanes([[0.75, 1.0], [-1.0, -0.25]]);
        boundaries(vec![0.625, 2.0])?.drift(&from, 1.0, |l| l < 2, &mut x, &mut passages);
        assert_eq!([&x[0][..2], &x[1][..2]], [[0.875, 0.75], [0.5, -0.25]]);
        assert_eq!(passages.impacts, [1.0, 1.0, 1.0]);
        assert_eq!(passages.crossings, [[1.0, 0.5, 0.25], [0.0; 3]]);
        assert_eq!(passages.crossed, [1, 0]);
        Ok(())
    }

    /// From every state the wall holds, and a non-finite state ends the piece as well.
    #[test]
    fn no_state_is_below_the_wall() -> Result<()> {
        let (mut x, mut passages) = ([[0.0; LANES]; 2], Passages::new(0));
        for k in 0..1000 {
            let v = -1.3_f64.powi(k - 500);
            let from = lanes([[0.5, 0.5 + f64::EPSILON], [v, v]]);
            boundaries(vec![])?.drift(&from, 0.1, |_| true, &mut x, &mut passages);
            assert!(x[0].iter().all(|&y| y >= 0.5));
        }
        let from = lanes([[0.5, f64::NAN], [f64::NEG_INFINITY, f64::NAN]]);
        boundaries(vec![])?.drift(&from, 0.1, |_| true, &mut x, &mut passages);
        Ok(())
    }
}
