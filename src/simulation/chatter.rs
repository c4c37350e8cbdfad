use super::scheme::Scheme;
use crate::walls::Contact;

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Result;
    use crate::models::{Duffing, FilteredDuffing};
    use crate::walls::Wall;

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
}
