use super::{
    grazing::Grazing,
    histogram::{Axis, Counts},
    scheme::Scheme,
    store::stored,
};
use crate::{Barrier, PolynomialDrift};

/// The powers 0, 1, 2 of the speed at a passage: enough for the flux moments 1, 2, 3.
pub(super) const POWERS: usize = 3;

/// What the straight drift of the displacements meets: a wall, and levels to watch.
#[derive(Clone, Debug)]
pub(super) struct Course {
    /// The displacements, each with its velocity. The wall and the levels belong to the first pair if there are any.
    pub(super) pairs: Vec<(usize, usize)>,
    /// The wall's position, or −∞.
    floor: f64,
    restitution: f64,
    /// Where the steps must be shorter.
    pub(super) grazing: Grazing,
    /// The levels whose up-crossings by state 0 are counted.
    pub(super) levels: Vec<f64>,
    /// The bins of the speeds at impacts, if these are counted.
    speeds: Option<Axis>,
}

/// Impacts and up-crossings: Σ 1, Σ|v|, Σ v² over the passages of each kind.
#[derive(Clone, Debug, Default)]
pub(super) struct Passages {
    /// At the wall, with the speed of approach.
    pub(super) impacts: [f64; POWERS],
    /// At each level.
    pub(super) crossings: Vec<[f64; POWERS]>,
    /// For each level the lanes that have crossed it since this was last cleared, one bit each.
    pub(super) crossed: Vec<u64>,
    /// The speeds of approach at impacts.
    pub(super) speeds: Counts,
}
stored!(Passages { impacts, crossings, crossed, speeds });

impl Passages {
    pub(super) fn new(levels: usize) -> Self {
        Passages {
            impacts: [0.0; POWERS],
            crossings: vec![[0.0; POWERS]; levels],
            crossed: vec![0; levels],
            speeds: Counts::default(),
        }
    }
}

impl Course {
    /// `diffusion` is ½B_vv at rest on the wall.
    pub(super) fn new(
        pairs: Vec<(usize, usize)>,
        barrier: Option<Barrier>,
        levels: Vec<f64>,
        diffusion: f64,
        step: f64,
    ) -> Self {
        let (floor, restitution) = barrier.map_or((f64::NEG_INFINITY, 1.0), |b| (b.offset(), b.restitution()));
        Course { pairs, floor, restitution, grazing: Grazing::new(restitution, diffusion, step), levels, speeds: None }
    }

    /// The course of a system's trajectories: the noise that rules grazing is that at rest on the wall.
    pub(super) fn for_scheme<T: PolynomialDrift<N, M>, const N: usize, const M: usize>(
        scheme: &Scheme<'_, T, N, M>,
        barrier: Option<Barrier>,
        levels: Vec<f64>,
    ) -> Self {
        let mut at_rest = [0.0; N];
        at_rest[0] = barrier.map_or(0.0, |b| b.offset());
        let velocity = scheme.pairs.iter().find(|&&(i, _)| i == 0).map(|&(_, j)| j);
        let diffusion = velocity.map_or(0.0, |v| scheme.power(v, at_rest)[0]);
        Course::new(scheme.pairs.clone(), barrier, levels, diffusion, scheme.step)
    }

    /// The same course, on which the crossings of `levels` and the `speeds` of impacts are counted.
    pub(super) fn counting(self, levels: Vec<f64>, speeds: Option<Axis>) -> Self {
        Course { levels, speeds, ..self }
    }

    /// No passages yet.
    pub(super) fn passages(&self) -> Passages {
        let speeds = self.speeds.map(|axis| Counts::new(&[axis])).unwrap_or_default();
        Passages { speeds, ..Passages::new(self.levels.len()) }
    }

    /// The state that moves state 0.
    #[inline(always)]
    fn velocity(&self) -> usize {
        self.pairs.first().map_or(0, |&(_, j)| j)
    }

    /// Whether a lane meets the wall within the time `tau`, or may need shorter steps after half of it.
    #[inline(always)]
    pub(super) fn near<const N: usize, const L: usize>(&self, x: &[[f64; L]; N], tau: f64) -> [bool; L] {
        // A loop and no closure, so that it is compiled for the widest registers, together with the caller's.
        let v = x[self.velocity()];
        let mut near = [false; L];
        for l in 0..L {
            let u = x[0][l] - self.floor;
            near[l] = (u + tau * v[l] < 0.0) | self.grazing.concerns(u + tau / 2.0 * v[l], v[l]);
        }
        near
    }

    /// The length of the step that a state needs: the whole one, or a shorter one where it grazes the wall.
    #[inline]
    pub(super) fn step_at<const N: usize>(&self, x: &[f64; N]) -> Option<f64> {
        self.grazing.step_at(x[0] - self.floor, x[self.velocity()])
    }

    /// Every displacement straight on for the time `tau`, its velocity frozen. Lanes of `except` count nothing and may be
    /// left anywhere; `first` is the number of the first lane.
    ///
    /// The path is a straight line, so that the time of contact with the wall is exact. After the rebound the velocity
    /// points away from the wall and nothing turns it within the straight piece: there is at most one contact in it. An
    /// infinite sequence of ever shorter rebounds is thereby cut at one contact per step; rebounds lower than about
    /// (force × h²) are not resolved, and the next kick ends them.
    #[inline(always)]
    pub(super) fn drift<const N: usize, const L: usize>(
        &self,
        x: &mut [[f64; L]; N],
        tau: f64,
        except: &[bool; L],
        first: usize,
        passages: &mut Passages,
    ) {
        let before = x[0];
        for &(i, j) in &self.pairs {
            for l in 0..L {
                x[i][l] += tau * x[j][l];
            }
        }
        let mut contact = false;
        for l in 0..L {
            contact |= x[0][l] < self.floor;
        }
        if contact || !self.levels.is_empty() {
            self.pass(x, before, tau, except, first, passages);
        }
    }

    /// The same for the state of one lane.
    pub(super) fn drifted<const N: usize>(
        &self,
        x: [f64; N],
        tau: f64,
        lane: usize,
        passages: &mut Passages,
    ) -> [f64; N] {
        let mut x = x.map(|value| [value]);
        self.drift(&mut x, tau, &[false], lane, passages);
        x.map(|[value]| value)
    }

    /// Impacts and level crossings of the straight piece that took state 0 from `before` to where it is now.
    #[inline(never)]
    fn pass<const N: usize, const L: usize>(
        &self,
        x: &mut [[f64; L]; N],
        mut before: [f64; L],
        tau: f64,
        except: &[bool; L],
        first: usize,
        passages: &mut Passages,
    ) {
        let velocity = self.velocity();
        for l in 0..L {
            if !except[l] && x[0][l] < self.floor {
                let approach = -x[velocity][l];
                add_powers(&mut passages.impacts, approach);
                if let Some(axis) = self.speeds {
                    passages.speeds.add(&[axis], [approach]);
                }
                // Rounding may put the contact a hair after the end of the piece.
                let rest = (tau - (before[l] - self.floor) / approach).max(0.0);
                x[velocity][l] = self.restitution * approach;
                x[0][l] = self.floor + x[velocity][l] * rest;
                before[l] = self.floor;
            }
        }
        let Passages { crossings, crossed, .. } = passages;
        for ((level, sums), crossed) in self.levels.iter().zip(crossings).zip(crossed) {
            for l in 0..L {
                if !except[l] && before[l] < *level && x[0][l] >= *level {
                    add_powers(sums, x[velocity][l]);
                    *crossed |= 1 << (first + l);
                }
            }
        }
    }
}

fn add_powers(sums: &mut [f64; POWERS], speed: f64) {
    sums[0] += 1.0;
    sums[1] += speed;
    sums[2] += speed * speed;
}

#[cfg(test)]
mod tests {
    use super::*;

    fn course(levels: Vec<f64>) -> Result<Course, crate::Error> {
        Ok(Course::new(vec![(0, 1)], Some(Barrier::new(0.5, 0.5)?), levels, 0.2, 0.1))
    }

    /// From y = 0.75 at v = −1 the wall at 0.5 is reached after 0.25; the other 0.75 s go back at 0.5. All numbers are
    /// exact in binary.
    #[test]
    fn an_impact_is_exact() -> Result<(), crate::Error> {
        let mut passages = Passages::new(2);
        let mut x = [[0.75, 1.0], [-1.0, -0.25]];
        course(vec![0.625, 2.0])?.drift(&mut x, 1.0, &[false; 2], 0, &mut passages);
        assert_eq!(x, [[0.875, 0.75], [0.5, -0.25]]);
        assert_eq!(passages.impacts, [1.0, 1.0, 1.0]);
        assert_eq!(passages.crossings, [[1.0, 0.5, 0.25], [0.0; 3]]);
        assert_eq!(passages.crossed, [1, 0]);
        Ok(())
    }

    /// Whatever the state, the wall holds, and a non-finite state ends the piece as well.
    #[test]
    fn no_state_is_below_the_wall() -> Result<(), crate::Error> {
        let mut passages = Passages::new(0);
        for k in 0..1000 {
            let v = -1.3_f64.powi(k - 500);
            let mut x = [[0.5, 0.5 + f64::EPSILON], [v, v]];
            course(vec![])?.drift(&mut x, 0.1, &[false; 2], 0, &mut passages);
            assert!(x[0].iter().all(|&y| y >= 0.5));
        }
        let mut x = [[0.5, f64::NAN], [f64::NEG_INFINITY, f64::NAN]];
        course(vec![])?.drift(&mut x, 0.1, &[false; 2], 0, &mut passages);
        Ok(())
    }
}
