use super::boundaries::{Boundaries, MOST_IMPACTS};
use super::lanes::{read_lane, write_lane};
use super::passage::Passages;
use super::scheme::Scheme;
use crate::problem::{Contact, LANES, Lane};

/// The fewest steps of a flight between two impacts on a wall where no white noise acts on the velocity.
const FLIGHT_STEPS: f64 = 8.0;
/// The shortest flight between two impacts on a wall without noise, in time steps: a trajectory with a shorter one comes to
/// rest.
const SHORTEST_FLIGHT: f64 = 1.0 / 4096.0;
/// The shortest step of a trajectory that is about to leave its rest on a wall, in time steps.
const SHORTEST_LEAVING: f64 = 1.0 / 256.0;

/// Shorter steps for trajectories that chatter without noise, and their rest on the wall.
///
/// Where no white noise acts on the rate w of a gap and r < 1, an acceleration −a towards the wall ends the motion in finite
/// time: flights after impacts last 2w/a, each r times as long as the one before, 2w/(a (1 − r)) all together, with
/// infinitely many impacts. Then the trajectory rests on the wall until its acceleration points away from it.
///
/// A trajectory takes the longest step τ = h, h/2, h/4, ... that is a small part of its flight. Where that is below h/2¹², what
/// is left of the flights is shorter than any other time: the trajectory comes to rest, and the chatter is complete. At rest
/// the contact's force cancels the acceleration towards the wall.
///
/// White noise elsewhere may drive the acceleration, with the mean square change s² per unit time. It then changes its sign
/// infinitely often when the trajectory leaves, and steps are shortened, to h/256 at most, until the trajectory is clear of the
/// wall or of zero acceleration: to the longest with |a| ≥ 2s√τ, |w| ≥ 2s√τ³ or u ≥ 2s√τ⁵, at the height u.
#[derive(Clone, Debug)]
pub(super) struct Chatter {
    /// The number of the wall.
    pub(super) wall: usize,
    pub(super) contact: Contact,
    /// The time step h.
    step: f64,
    /// s, at rest on the wall.
    unsteadiness: f64,
}

/// How a trajectory goes on beside a wall without noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Ahead {
    /// With the whole step.
    Free,
    /// With steps of at most this length; at rest, it may be the whole one.
    Short(f64),
    /// It comes to rest.
    Rest,
}

impl Chatter {
    /// The rule at a wall, if trajectories may come to rest there.
    pub(super) fn at(wall: usize, contact: &Contact, scheme: &Scheme<'_>) -> Option<Self> {
        contact.is_rested_on().then(|| {
            let square = scheme.unsteadiness(&contact.at_rest(scheme.states), |drift| contact.rate(drift));
            Chatter { wall, contact: *contact, step: scheme.step, unsteadiness: square.sqrt() }
        })
    }

    /// How a state goes on under the drift `drift`.
    pub(super) fn ahead(&self, x: &[f64], drift: &[f64]) -> Ahead {
        let (gap, rate, acceleration) = (self.contact.gap(x), self.contact.rate(x), self.contact.rate(drift));
        let leaving = self.leaving(gap, rate, acceleration);
        if self.contact.rests(x) {
            return Ahead::Short(leaving);
        }
        let pull = -acceleration;
        if !(pull > 0.0 && gap.is_finite() && rate.is_finite()) {
            return if leaving < self.step { Ahead::Short(leaving) } else { Ahead::Free };
        }
        // The flight that the state is on, from wall to wall.
        let flight = 2.0 * (rate * rate + 2.0 * pull * gap.max(0.0)).sqrt() / pull;
        if flight < self.step * SHORTEST_FLIGHT {
            return Ahead::Rest;
        }
        let mut step = leaving;
        while step * FLIGHT_STEPS > flight {
            step /= 2.0;
        }
        if step < self.step { Ahead::Short(step) } else { Ahead::Free }
    }

    /// The longest step in which noise does not turn the acceleration round while the trajectory is at the wall.
    fn leaving(&self, gap: f64, rate: f64, acceleration: f64) -> f64 {
        let mut step = self.step;
        loop {
            let reach = 2.0 * self.unsteadiness * step.sqrt();
            let clear = acceleration.abs() >= reach || rate.abs() >= reach * step || gap >= reach * step * step;
            if clear || step <= self.step * SHORTEST_LEAVING {
                return step;
            }
            step /= 2.0;
        }
    }

    /// Puts a state to rest on the wall.
    pub(super) fn rest(&self, x: &mut [f64]) {
        self.contact.close(x);
        self.contact.collide(0.0, x);
    }
}

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
    use crate::problem::Wall;
    use crate::simulation::boundaries::Boundaries;

    /// A wall at 0 behind a filter, with h = 1/16.
    fn chatter() -> Result<Chatter> {
        let filtered = FilteredDuffing::first_order(Duffing::new(0.2, 1.0, 0.0, 0.2)?, 2.0)?.problem()?;
        let problem = filtered.with_wall(Wall::above(0.0, 0.5)?)?;
        let found = Chatter::at(3, &problem.contacts()[0], &Scheme::new(&problem, 1.0, 1.0 / 16.0));
        Ok(found.unwrap_or_else(|| unreachable!("no noise acts on the velocity")))
    }

    /// Drifts of the velocity: the force z has the intensity a²·2D = 1.6 per unit time, and 2s√h = 0.632.
    #[test]
    fn steps_are_small_parts_of_flights_and_flights_end() -> Result<()> {
        let chatter = chatter()?;
        assert!((chatter.unsteadiness - 1.6_f64.sqrt()).abs() < 1e-15);
        let ahead = |x: f64, v: f64, a: f64| chatter.ahead(&[x, v, 0.0], &[v, a, 0.0]);
        let h = 1.0 / 16.0;
        // A flight of 2w/a = 8h, and one of half its length.
        assert_eq!(ahead(0.0, 0.25, -1.0), Ahead::Free);
        assert_eq!(ahead(0.0, 0.125, -1.0), Ahead::Short(h / 2.0));
        // Its highest point is on the same flight.
        assert_eq!(ahead(0.125 * 0.125 / 2.0, 0.0, -1.0), Ahead::Short(h / 2.0));
        assert_eq!(ahead(0.0, h / 8193.0, -1.0), Ahead::Rest);
        assert_eq!(ahead(0.0, 0.125, 1.0), Ahead::Free);
        assert_eq!(ahead(f64::NAN, f64::NAN, -1.0), Ahead::Free);
        // At rest, pressed by more than noise changes in a step, by half of that, and hardly.
        assert_eq!(ahead(0.0, 0.0, -0.64), Ahead::Short(h));
        assert_eq!(ahead(0.0, 0.0, -0.32), Ahead::Short(h / 4.0));
        assert_eq!(ahead(0.0, 0.0, -1e-4), Ahead::Short(h / 256.0));
        Ok(())
    }

    #[test]
    fn rest_is_on_the_wall_without_motion() -> Result<()> {
        let mut x = [1e-9, 1e-7, 0.3];
        chatter()?.rest(&mut x);
        assert_eq!(x, [0.0, 0.0, 0.3]);
        assert!(chatter()?.contact.rests(&x));
        Ok(())
    }

    /// The wall's force at rest takes away the acceleration towards the wall, and no other.
    #[test]
    fn the_force_at_rest_cancels_the_acceleration_towards_the_wall() -> Result<()> {
        let contact = chatter()?.contact;
        for (pull, left) in [(-0.7, 0.0), (0.7, 0.7)] {
            let mut drift = [0.0, pull, 0.3];
            contact.support(&mut drift);
            assert_eq!(drift, [0.0, left, 0.3]);
        }
        Ok(())
    }

    /// At rest the whole step counts, and of the step in which the trajectory leaves half; a kick towards the wall is taken back.
    #[test]
    fn rest_ends_in_the_middle_of_the_step_that_leaves() -> Result<()> {
        let filtered = FilteredDuffing::first_order(Duffing::new(0.2, 1.0, 0.0, 0.2)?, 2.0)?.problem()?;
        let problem = filtered.with_wall(Wall::above(0.0, 0.5)?)?;
        let scheme = Scheme::new(&problem, 1.0, 1.0 / 16.0);
        let boundaries = Boundaries::for_scheme(&scheme, &problem.contacts(), Vec::new());
        let (mut passages, mut rested) = (boundaries.passages(), vec![[0.0; LANES]]);
        for (kicked, left) in [(-0.25, 0.0), (0.0, 0.0), (0.5, 0.5)] {
            let mut x = [0.0, kicked, 0.3];
            boundaries.hold(&mut x, 1, 0.25, (&mut rested, 0), &mut passages);
            assert_eq!(x, [0.0, left, 0.3]);
        }
        assert_eq!((passages.rests[0], rested[0][0]), ([0.625, 0.0], 0.0));
        Ok(())
    }
}
