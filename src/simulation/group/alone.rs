//! What one lane does by itself: straight on from impulse to impulse, shorter steps near a wall, and rest on it.

use super::steps::{Advance, Workspace};
use crate::simulation::{chatter::Ahead, normal::pair};
use std::ops::Range;

impl Advance<'_, '_> {
    /// The state of one lane straight on for the time `tau`, which is a part of a time step, from one impulse to the next.
    #[inline(never)]
    pub(super) fn drift_struck(&mut self, l: usize, step: u64, part: Range<f64>, tau: f64) {
        let Advance { scheme, boundaries, passages, work, .. } = self;
        let Workspace { state, impulses, .. } = &mut **work;
        let mut left = tau;
        if !scheme.impulses.is_empty() {
            for impulse in impulses.within(step, part.clone()).filter(|impulse| impulse.lane == l) {
                let after = tau * (part.end - impulse.time) / (part.end - part.start);
                boundaries.drift_lane(state, l, left - after, passages);
                scheme.impulses.apply(impulse, state);
                left = after;
            }
        }
        boundaries.drift_lane(state, l, left, passages);
    }

    /// Whether the state of one lane goes on with shorter steps, or rests on a wall.
    #[inline]
    pub(super) fn is_interrupted(&mut self) -> bool {
        self.boundaries.step_at(&self.work.state).is_some() || self.beside_chatter().is_some()
    }

    /// The length of the step beside a wall without noise, which may be the whole one at rest. A flight that is too short to
    /// be followed ends in rest.
    fn beside_chatter(&mut self) -> Option<f64> {
        let Workspace { state, scratch, .. } = &mut *self.work;
        let chatters = &self.boundaries.chatters;
        if chatters.is_empty() {
            return None;
        }
        let drift = self.scheme.drift(state, scratch);
        let mut longest = None::<f64>;
        for chatter in chatters {
            let step = match chatter.ahead(state, drift) {
                Ahead::Free => continue,
                Ahead::Short(step) => step,
                Ahead::Rest => {
                    chatter.rest(state);
                    self.scheme.step
                }
            };
            longest = Some(longest.map_or(step, |longest| longest.min(step)));
        }
        longest
    }

    /// A whole time step of the state of one lane in shorter steps, with random numbers that nothing else uses.
    #[inline(never)]
    pub(super) fn graze(&mut self, l: usize) {
        let (mut left, mut over) = (self.scheme.step, 0.0);
        let mut draws = 0;
        while left > 0.0 {
            let beside = self.beside_chatter();
            let step = self.boundaries.step_at(&self.work.state).into_iter().chain(beside).fold(left, f64::min);
            left -= step;
            // The part of the whole step that is over before this shorter one, and after it.
            let begin = std::mem::replace(&mut over, if left > 0.0 { 1.0 - left / self.scheme.step } else { 1.0 });
            let (middle, number) = (f64::midpoint(begin, over), self.group.taken);
            self.drift_struck(l, number, begin..middle, step / 2.0);
            let Advance { group, scheme, boundaries, passages, work, .. } = &mut *self;
            let Workspace { state, shorter, scratch, .. } = &mut **work;
            let mut draw = || {
                draws += 1;
                group.random.grazing(group.first + l as u64, group.taken, draws - 1)
            };
            let resting = boundaries.resting(state);
            let deviation = step.sqrt() * scheme.gain(number);
            for two in shorter.chunks_mut(2) {
                two.iter_mut().zip(pair(draw())).for_each(|(increment, z)| *increment = deviation * z);
            }
            let reversed = scheme.curved() && draw()[0] & 1 == 1;
            scheme.kick_alone(state, (step, number), shorter, reversed, scratch);
            boundaries.hold(state, resting, step, (&mut group.rested, l), passages);
            self.drift_struck(l, number, middle..over, step / 2.0);
        }
    }
}
