//! Problems: a system as data, made once from its definition, with its walls.

mod contacts;
mod definition;
mod ends;
mod expression;
mod family;
mod gaussian_closure;
mod impulses;
mod in_states;
mod modulated_moments;
mod motion;
mod surfaces;
mod symmetry;
mod text;
mod time_scales;
#[cfg(test)]
mod two_routes;
mod units;
mod zhuravlev;

pub use definition::Definition;
pub(crate) use gaussian_closure::{gaussian_after, linear_after};
pub(crate) use modulated_moments::ModulatedMoments;
pub(crate) use motion::{Motion, PlaneMotion, StillMotion};
pub use surfaces::Surface;
pub(crate) use surfaces::Surfaces;
pub(crate) use symmetry::Symmetry;
pub(crate) use time_scales::{TimeScales, two_digits};

use crate::error::{Error, Result};
use crate::field::Field;
use crate::fokker_planck::{FokkerPlanck, Local, noise_induced_drift};
use crate::polynomial::{Gaussian, Polynomial};
use crate::system::Interpretation;
use crate::walls::{Wall, is_room};
use family::Family;
use serde::{Deserialize, Deserializer, Serialize, Serializer, de, ser};
use std::fmt;
use std::sync::Arc;

/// A random dynamical system as data, with its walls. Every method takes one.
///
/// It is made once from a [`Drift`](crate::Drift), an [`Oscillator`](crate::Oscillator) or a [`System`](crate::System), owns it, can
/// be cloned at no cost, sent to other threads and kept in lists beside problems of other dimensions. It holds the system
/// twice: as polynomials, where algebra is exact, and as the definition itself, which automatic differentiation works on.
///
/// ```
/// use expoly::{Problem, Wall, models::Duffing};
/// let problem = Problem::of(Duffing::new(0.2, 1.0, 0.3, 0.2)?)?.with_wall(Wall::above(-0.5, 0.9)?)?;
/// assert_eq!(problem.states(), ["x", "v"]);
/// assert_eq!(problem.drift()[1].text(problem.states()).to_string(), "- x - 0.2 v - 0.3 x^3");
/// assert_eq!(problem.displacements(), [(0, 1)]);
/// # Ok::<(), expoly::Error>(())
/// ```
#[derive(Clone)]
pub struct Problem {
    equations: Arc<SystemEquations>,
    walls: Vec<Wall>,
    /// Walls of states that are no displacements, which reflect them.
    ends: Vec<Wall>,
    /// The evaluation in time steps next to ends.
    beside_ends: Option<Arc<dyn Field>>,
    /// Those of the equations, then those of each wall.
    parameters: Arc<[(String, f64)]>,
}

/// The part of a problem that walls do not change.
struct SystemEquations {
    states: Vec<String>,
    parameters: Vec<(String, f64)>,
    drift: Vec<Polynomial>,
    columns: Vec<Vec<Polynomial>>,
    interpretation: Interpretation,
    operator: FokkerPlanck,
    /// Whether G is the same at all states.
    constant_noise: bool,
    displacements: Vec<(usize, usize)>,
    surfaces: Surfaces,
    /// Whether a jump of the drift acts together with the noise in the steps of trajectories.
    bridged: bool,
    field: Box<dyn Field>,
    /// The same system at other values of its parameters.
    family: Option<Box<dyn Family>>,
}

impl Problem {
    /// The same with one more wall. On a state that is no displacement, and that noise of its own drives, a wall with r = 1 is a
    /// reflecting end ([`Problem::ends`]): no probability passes it.
    ///
    /// # Errors
    /// [`Error::NotADisplacement`] unless some state is the velocity of the wall's, and of its other body's, or it is such an end; [`Error::OutOfRange`]
    /// for a second wall on the same side, a body that hits itself, or walls that leave the motion no room; [`Error::NotAName`]
    /// where a parameter of the wall ([`Problem::parameters`]) would have the name of another one.
    pub fn with_wall(mut self, wall: Wall) -> Result<Self> {
        let wall = wall.checked()?;
        if self.is_end(&wall) {
            return self.with_end(wall);
        }
        for state in std::iter::once(wall.state()).chain(wall.other()) {
            if self.velocity_of(state).is_none() {
                return Err(Error::NotADisplacement { state });
            }
        }
        let refused = |name, value, remedy| Err(Error::OutOfRange { name, value, remedy });
        if wall.other() == Some(wall.state()) {
            return refused(
                "body",
                wall.state() as f64,
                "a body does not hit itself: give the states of two displacements",
            );
        }
        let same = |other: &Wall| {
            let turned = (wall.other(), Some(wall.state())) == (Some(other.state()), other.other());
            (wall.state(), wall.other(), wall.is_above()) == (other.state(), other.other(), other.is_above())
                || turned && wall.is_above() != other.is_above()
        };
        if self.walls.iter().any(same) {
            let remedy = "there is a wall on this side of the state already; remove it by `without_walls`";
            return refused("offset of the wall", wall.offset(), remedy);
        }
        self.walls.push(wall);
        if !is_room(&self.walls) {
            let remedy = "the motion must have room between the walls";
            return refused("offset of the wall", wall.offset(), remedy);
        }
        let own = wall.parameters(self.states());
        if let Some((name, _)) = own.iter().find(|(name, _)| self.parameters().iter().any(|(other, _)| other == name)) {
            return Err(Error::not_a_name(name, "two parameters have it"));
        }
        self.parameters = self.parameters.iter().cloned().chain(own).collect();
        Ok(self)
    }

    /// The same without walls.
    pub fn without_walls(&self) -> Self {
        Self::open(Arc::clone(&self.equations))
    }

    /// The problem of equations, without walls.
    fn open(equations: Arc<SystemEquations>) -> Self {
        let parameters = equations.parameters.iter().cloned().collect();
        Problem { equations, walls: Vec::new(), ends: Vec::new(), beside_ends: None, parameters }
    }

    /// The number of states.
    pub fn dimension(&self) -> usize {
        self.equations.states.len()
    }

    /// The states' names, in order.
    pub fn states(&self) -> &[String] {
        &self.equations.states
    }

    /// The number of the state of a name.
    ///
    /// # Errors
    /// [`Error::NotAName`] if there is none.
    pub fn state(&self, name: &str) -> Result<usize> {
        let unknown = || Error::not_a_name(name, "no state has it");
        self.states().iter().position(|state| state == name).ok_or_else(unknown)
    }

    /// The names and values of all parameters: of a [`Parametric`](crate::Parametric) system, or of a text; then of each wall its
    /// offset and its restitution, `x.above.offset` and `x.above.restitution` for a wall with the motion of x above it, and
    /// `x-y.below.offset` between two bodies.
    ///
    /// ```
    /// use expoly::{Wall, models::{Duffing, Solved}};
    /// let problem = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?.with_wall(Wall::above(-0.5, 0.9)?)?;
    /// assert_eq!(problem.parameters()[4], ("x.above.offset".into(), -0.5));
    /// assert_eq!(problem.with_parameter("x.above.restitution", 0.8)?.walls()[0].restitution(), 0.8);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn parameters(&self) -> &[(String, f64)] {
        &self.parameters
    }

    /// The Fokker-Planck operator: Itô drift and diffusion matrix as polynomials.
    pub fn operator(&self) -> &FokkerPlanck {
        &self.equations.operator
    }

    /// The drift that the noise induces, which Itô's has beyond that as it was written.
    pub(crate) fn induced_drift(&self) -> Vec<Polynomial> {
        match self.interpretation() {
            Interpretation::Stratonovich => noise_induced_drift(self.columns(), self.dimension()),
            Interpretation::Ito => vec![Polynomial::zero(self.dimension()); self.dimension()],
        }
    }

    /// The drift as it was written, in the system's own interpretation.
    pub fn drift(&self) -> &[Polynomial] {
        &self.equations.drift
    }

    /// The noise matrix G by rows: `noise()[i][k]` is the factor of Wiener process k in state i.
    pub fn noise(&self) -> Vec<Vec<Polynomial>> {
        (0..self.dimension()).map(|i| self.columns().iter().map(|column| column[i].clone()).collect()).collect()
    }

    /// The columns of G, one for each Wiener process.
    pub(crate) fn columns(&self) -> &[Vec<Polynomial>] {
        &self.equations.columns
    }

    /// The interpretation of G(X) dW, Itô's or Stratonovich's.
    pub fn interpretation(&self) -> Interpretation {
        self.equations.interpretation
    }

    /// The places of single states where the drift has a kink or a jump, found from the arguments of |·|, sign, step and max.
    ///
    /// ```
    /// use expoly::Problem;
    /// let text = "states = ['x', 'v']\ndrift = { x = 'v', v = '-x - 0.2*sign(v) - pos(x - 0.5)' }\nnoise.w.v = '0.5'";
    /// let problem = Problem::from_toml(text)?;
    /// let surfaces: Vec<_> = problem.surfaces().iter().map(|found| (found.state, found.place, found.order)).collect();
    /// assert_eq!(surfaces, [(1, 0.0, 0.0), (0, 0.5, 1.0)]);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn surfaces(&self) -> &[Surface] {
        &self.equations.surfaces.straight
    }

    /// Whether a jump of the drift, or a reflecting end, acts together with the noise in the steps of trajectories.
    pub(crate) fn is_bridged(&self) -> bool {
        self.equations.bridged || !self.ends.is_empty()
    }

    /// Whether the drift has a kink or a jump anywhere, or an end reflects the motion.
    pub(crate) fn is_bent(&self) -> bool {
        !self.equations.surfaces.are_none() || !self.ends.is_empty()
    }

    /// Whether it has one along a curve or a line across several states.
    pub(crate) fn is_bent_obliquely(&self) -> bool {
        !self.equations.surfaces.others.is_empty()
    }

    /// The displacements, each with the state that is its velocity.
    pub fn displacements(&self) -> &[(usize, usize)] {
        &self.equations.displacements
    }

    /// The velocity of a state, if it is a displacement.
    pub fn velocity_of(&self, state: usize) -> Option<usize> {
        self.displacements().iter().find(|(i, _)| *i == state).map(|(_, j)| *j)
    }

    /// The walls.
    pub fn walls(&self) -> &[Wall] {
        &self.walls
    }

    /// The Gaussian closure: the normal distribution under which the moment equations of first and second order hold exactly,
    /// walls left out, impulses included. It is the weight of the classical closure and equal to it at order 2.
    ///
    /// # Errors
    /// [`Error::NoDensity`] if a variance grows without bound or does not settle.
    ///
    /// ```
    /// use expoly::{Problem, models::Duffing};
    /// let gaussian = Problem::of(Duffing::new(0.2, 1.0, 0.3, 0.2)?)?.gaussian()?;
    /// assert!((gaussian.covariance[(1, 1)] - 1.0).abs() < 1e-12); // D/c
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn gaussian(&self) -> Result<Gaussian> {
        gaussian_closure::gaussian_closure(self.operator())
    }

    /// Whether G is the same at all states.
    pub(crate) fn constant_noise(&self) -> bool {
        self.equations.constant_noise
    }

    /// The definition itself, for evaluation at points.
    pub(crate) fn field(&self) -> &dyn Field {
        self.beside_ends.as_deref().unwrap_or(&*self.equations.field)
    }

    /// The sign changes of states that leave the Fokker-Planck equation as it is, and every wall where it is.
    pub(crate) fn symmetry(&self) -> Symmetry {
        Symmetry::of(self.operator()).without_flips_of(
            self.walls().iter().chain(self.ends()).flat_map(|wall| [Some(wall.state()), wall.other()]).flatten(),
        )
    }

    /// The Itô drift and, by rows, the diffusion matrix at a point.
    pub(crate) fn point(&self, x: &[f64], drift: &mut [f64], diffusion: &mut [f64]) {
        self.field().ito_drift(x, drift);
        if self.constant_noise() {
            self.constant_diffusion(diffusion);
        } else {
            self.field().diffusion(x, diffusion);
        }
    }

    /// The operator at a point, all derivatives by dual numbers.
    pub(crate) fn local(&self, x: &[f64], local: &mut Local) {
        self.field().ito_drift(x, &mut local.drift);
        local.divergence = self.field().divergence(x);
        if self.constant_noise() {
            self.constant_diffusion(&mut local.diffusion);
            local.diffusion_divergence.fill(0.0);
            local.diffusion_curvature = 0.0;
        } else {
            self.field().diffusion_derivatives(x, local);
        }
    }

    fn constant_diffusion(&self, diffusion: &mut [f64]) {
        let entries = self.operator().diffusion().iter().flatten();
        diffusion.iter_mut().zip(entries).for_each(|(value, b)| *value = b.constant_term());
    }
}

impl fmt::Display for Problem {
    /// The text of [`Problem::to_toml`], or the Fokker-Planck equation where names do not allow for it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.to_toml() {
            Ok(text) => f.write_str(text.trim_end()),
            Err(_) => write!(f, "{}", self.operator().text(self.states())),
        }
    }
}

/// As the text of [`Problem::to_toml`].
impl Serialize for Problem {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        self.to_toml().map_err(ser::Error::custom)?.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Problem {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        Problem::from_toml(&String::deserialize(deserializer)?).map_err(de::Error::custom)
    }
}

impl fmt::Debug for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Problem")
            .field("equation", &format_args!("{}", self.operator().text(self.states())))
            .field("walls", &self.walls)
            .finish_non_exhaustive()
    }
}
