//! States that rest on walls.

use super::boundaries::{Boundaries, MOST_IMPACTS};
use super::chatter::Chatter;
use super::group::{read_lane, write_lane};
use super::passage::Passages;
use crate::field::{LANES, Lane};
use crate::walls::Contact;

impl Boundaries {
    /// Which of the walls that trajectories come to rest on a state rests on, one bit each.
    pub(super) fn resting(&self, x: &[f64]) -> u64 {
        let rests = |(k, chatter): (usize, &Chatter)| u64::from(chatter.contact.rests(x)) << k;
        self.chatters.iter().enumerate().map(rests).sum()
    }

    /// Adds the forces of the walls that states rest on to the drift there.
    pub(super) fn support(&self, x: &[Lane], drift: &mut [Lane]) {
        let (mut state, mut forces) = (vec![0.0; x.len()], vec![0.0; x.len()]);
        for l in (0..LANES).filter(|_| !self.chatters.is_empty()) {
            read_lane(x, l, &mut state);
            read_lane(drift, l, &mut forces);
            self.resting_contacts(&state).for_each(|contact| contact.support(&mut forces));
            write_lane(&forces, l, drift);
        }
    }

    /// The walls that a state rests on.
    pub(super) fn resting_contacts(&self, x: &[f64]) -> impl Iterator<Item = Contact> {
        self.chatters.iter().map(|chatter| chatter.contact).filter(|contact| contact.rests(x))
    }

    /// Keeps a state that rested before a kick of the length `step` on those walls that the kick presses it onto, and counts its
    /// time at rest; of the step in which it leaves, half. `rested_for` has the times since its lane came to rest.
    pub(super) fn hold(
        &self,
        x: &mut [f64],
        resting: u64,
        step: f64,
        (rested_for, lane): (&mut [Lane], usize),
        passages: &mut Passages,
    ) {
        let rested = self.chatters.iter().enumerate().filter(|(k, _)| resting >> k & 1 == 1);
        for _ in 0..MOST_IMPACTS {
            let mut pressed = false;
            for (_, Chatter { contact, .. }) in rested.clone() {
                if contact.rate(x) < 0.0 {
                    contact.collide(0.0, x);
                    pressed = true;
                }
            }
            if !pressed {
                break;
            }
        }
        for (k, Chatter { wall, contact, .. }) in self.chatters.iter().enumerate() {
            let time = match (resting >> k & 1 == 1, contact.rests(x)) {
                (true, true) => step,
                (true, false) => step / 2.0,
                _ => 0.0,
            };
            let [total, count] = &mut passages.rests[*wall];
            let before = rested_for[k][lane];
            *total += time;
            *count += f64::from(before < self.shortest_rest && before + time >= self.shortest_rest);
            rested_for[k][lane] = if time == step { before + time } else { 0.0 };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Result;
    use crate::models::{Duffing, FilteredDuffing};
    use crate::simulation::scheme::Scheme;
    use crate::walls::Wall;

    /// At rest the whole step counts, and of the step in which the trajectory leaves half; a kick towards the wall is taken back.
    #[test]
    fn rest_ends_in_the_middle_of_the_step_that_leaves() -> Result<()> {
        let filtered = FilteredDuffing::first_order(Duffing::new(0.2, 1.0, 0.0, 0.2)?, 2.0)?.problem()?;
        let problem = filtered.with_wall(Wall::above(0.0, 0.5)?)?;
        let scheme = Scheme::new(&problem, 1.0, 1.0 / 16.0);
        let boundaries = Boundaries::for_scheme(&scheme, &problem.contacts(), Vec::new());
        let (mut passages, mut rested) = (boundaries.passages(), vec![Lane::ZERO]);
        for (kicked, left) in [(-0.25, 0.0), (0.0, 0.0), (0.5, 0.5)] {
            let mut x = [0.0, kicked, 0.3];
            boundaries.hold(&mut x, 1, 0.25, (&mut rested, 0), &mut passages);
            assert_eq!(x, [0.0, left, 0.3]);
        }
        assert_eq!((passages.rests[0], rested[0][0]), ([0.625, 0.0], 0.0));
        Ok(())
    }
}
