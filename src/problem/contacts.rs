//! The walls of a problem as the motion meets them.

use super::Problem;
use crate::error::{Error, Result};
use crate::fokker_planck::FokkerPlanck;
use crate::polynomial::Polynomial;
use crate::walls::{Contact, Wall, inside};

impl Problem {
    /// The walls as the motion meets them, in their order.
    pub(crate) fn contacts(&self) -> Vec<Contact> {
        let of = |wall: &Wall| {
            let mut contact = Contact::new(wall, |state| self.velocity_of(state).unwrap_or(state));
            contact.noiseless = self.is_noiseless_at(&contact);
            contact
        };
        self.walls().iter().map(of).collect()
    }

    /// A state without motion that no wall excludes: that at 0, moved as far as the walls ask.
    pub(crate) fn still(&self) -> Vec<f64> {
        let mut x = vec![0.0; self.dimension()];
        inside(&self.contacts(), &mut x, Contact::close);
        x
    }

    /// The pairs of velocities that impacts between two bodies join.
    pub(crate) fn joined(&self) -> Vec<[usize; 2]> {
        let pair = |contact: &Contact| {
            let (first, second) = contact.bodies();
            Some([first.1, second?.1])
        };
        self.contacts().iter().filter_map(pair).collect()
    }

    /// Refuses walls that trajectories come to rest on: there is no density then.
    ///
    /// # Errors
    /// [`Error::NoDensity`].
    pub(crate) fn require_no_rest(&self) -> Result<()> {
        let pressed = |contact: &Contact| {
            let ((state, velocity), other) = contact.bodies();
            let of = |v: usize| &self.operator().drift()[v];
            let force = other.map_or_else(|| of(velocity).clone(), |(_, v)| of(velocity) - of(v));
            let force = &force.compose(&self.at_rest_on(contact)) * contact.gap_slope(state);
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
    fn at_rest_on(&self, contact: &Contact) -> Vec<Polynomial> {
        let (n, (first, second)) = (self.dimension(), contact.bodies());
        let mut states: Vec<Polynomial> = (0..n).map(|i| Polynomial::variable(n, i)).collect();
        let nothing = || Polynomial::zero(n);
        let [y, v] = second.map_or([nothing(), nothing()], |(y, v)| [y, v].map(|i| Polynomial::variable(n, i)));
        (states[first.0], states[first.1]) = (y + contact.wall.offset(), v);
        states
    }

    /// B_ww where the motion rests on a wall, and its largest coefficient anywhere.
    fn noise_of_rate(&self, contact: &Contact, operator: &FokkerPlanck) -> (Polynomial, f64) {
        let b = |i: usize, j: usize| &operator.diffusion()[i][j];
        let ((_, first), second) = contact.bodies();
        let power = match second {
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

    /// The wall below the motion and the one above it, for a method of one displacement (state 0) and its velocity (state 1), and in
    /// three states of what drives them.
    pub(crate) fn walls_of_oscillator(&self, method: &'static str) -> Result<[Option<Wall>; 2]> {
        if self.walls.is_empty() {
            return Ok([None, None]);
        }
        if !(2..=3).contains(&self.dimension()) {
            let (what, remedy) =
                ("walls in other than two or three states", "the simulation serves walls in any number of them");
            return Err(Error::NotServed { method, what, remedy });
        }
        if self.walls.iter().any(|wall| wall.state() != 0) || self.velocity_of(0) != Some(1) {
            let remedy = "let the displacement be the first state and its velocity the second";
            return Err(Error::NotServed { method, what: "a wall on another state than the first", remedy });
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
