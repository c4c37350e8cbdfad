//! Problems: a system as data, made once from its definition, with its walls.

mod contact;
mod expression;
mod field;
mod flow;
mod gaussian_closure;
mod mirror;
mod pack;
mod rarity;
mod room;
mod symmetry;
mod tangent;
mod text;
mod time_scales;
#[cfg(test)]
mod two_routes;
mod units;
mod wall;
mod zhuravlev;

pub(crate) use contact::Contact;
use field::{AnySize, Fixed};
pub(crate) use field::{Field, LANES, Lane};
pub(crate) use flow::{Kicks, Nearness, Strike, near};
pub(crate) use gaussian_closure::gaussian_after;
pub(crate) use room::reflect;
pub(crate) use symmetry::Symmetry;
pub(crate) use time_scales::{TimeScales, two_digits};
pub use wall::Wall;
pub(crate) use wall::{COLLAPSE, limits};

use crate::checks::dimension;
use crate::error::{Error, Result};
use crate::fokker_planck::{FokkerPlanck, Impulse, Local, noise_induced_drift};
use crate::polynomial::{Arena, Gaussian, Polynomial, Symbol};
use crate::system::{Interpretation, PolynomialDrift, PolynomialSystem};
use std::fmt;
use std::sync::Arc;

/// A random dynamical system as data, with its walls. Every method takes one.
///
/// It is made once from a [`PolynomialDrift`], an [`Oscillator`](crate::Oscillator) or a [`PolynomialSystem`], owns it, can
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
    equations: Arc<Equations>,
    walls: Vec<Wall>,
}

/// The part of a problem that walls do not change.
struct Equations {
    states: Vec<String>,
    parameters: Vec<(String, f64)>,
    drift: Vec<Polynomial>,
    columns: Vec<Vec<Polynomial>>,
    interpretation: Interpretation,
    operator: FokkerPlanck,
    /// Whether G is the same at all states.
    constant_noise: bool,
    displacements: Vec<(usize, usize)>,
    field: Box<dyn Field>,
}

impl Problem {
    /// The problem of a system whose number of states is known when it is compiled.
    ///
    /// # Errors
    /// [`Error::NotFinite`] if a coefficient, or a product of two in the noise, is NaN or infinite, [`Error::OutOfRange`] for a
    /// degree above 60, [`Error::NoNoise`] if noise and impulses vanish identically;
    /// [`Error::Dimension`], [`Error::NotAName`] if the names do not fit the states.
    pub fn of<T, const N: usize, const M: usize>(system: T) -> Result<Self>
    where
        T: PolynomialDrift<N, M> + 'static,
    {
        let arena = Arena::new(N);
        let x: [Symbol<'_>; N] = {
            let variables = arena.variables();
            std::array::from_fn(|i| variables[i])
        };
        let drift = system.drift(x).map(|f| f.polynomial(N)).to_vec();
        let noise = system.noise(x);
        let columns = (0..M).map(|k| noise.iter().map(|row| row[k].polynomial(N)).collect()).collect();
        let impulse = |(source, jumps)| {
            let field = system.impulse(source, x).map(|h| h.polynomial(N));
            Impulse::new(jumps, field.to_vec())
        };
        let impulses = system.jumps().into_iter().enumerate().map(impulse).collect();
        let (interpretation, names, parameters) = (system.interpretation(), system.names(), system.parameters());
        let field = |induces| Box::new(Fixed::<T, N, M> { system, induces }) as Box<dyn Field>;
        Self::assembled((drift, columns, interpretation, impulses), names, parameters, field)
    }

    /// The problem of a system whose number of states is a number at run time.
    ///
    /// # Errors
    /// As [`Problem::of`]; [`Error::Dimension`] where drift or noise do not have the system's stated length.
    pub fn of_system(system: impl PolynomialSystem + 'static) -> Result<Self> {
        let (n, m) = (system.states(), system.processes());
        let arena = Arena::new(n);
        let x = arena.variables();
        let (drift, noise) = (system.drift(&x), system.noise(&x));
        dimension("a drift", drift.len(), n)?;
        dimension("a noise matrix", noise.len(), n)?;
        noise.iter().try_for_each(|row| dimension("a row of a noise matrix", row.len(), m))?;
        let drift = drift.iter().map(|f| f.polynomial(n)).collect();
        let columns = (0..m).map(|k| noise.iter().map(|row| row[k].polynomial(n)).collect()).collect();
        let impulse = |(source, jumps)| {
            let field = system.impulse(source, &x);
            dimension("the factor of an impulse", field.len(), n)?;
            Ok(Impulse::new(jumps, field.iter().map(|h| h.polynomial(n)).collect()))
        };
        let impulses = system.jumps().into_iter().enumerate().map(impulse).collect::<Result<_>>()?;
        let (interpretation, names, parameters) = (system.interpretation(), system.names(), system.parameters());
        let field = |induces| Box::new(AnySize { system, induces }) as Box<dyn Field>;
        Self::assembled((drift, columns, interpretation, impulses), names, parameters, field)
    }

    /// The problem of equations as polynomials; `field` makes the evaluation of the same, given whether the noise induces a
    /// drift.
    fn assembled(
        (drift, columns, interpretation, impulses): (
            Vec<Polynomial>,
            Vec<Vec<Polynomial>>,
            Interpretation,
            Vec<Impulse>,
        ),
        names: Vec<String>,
        parameters: Vec<(String, f64)>,
        field: impl FnOnce(bool) -> Box<dyn Field>,
    ) -> Result<Self> {
        let n = drift.len();
        let operator = FokkerPlanck::new(&drift, &columns, interpretation, impulses)?;
        let pairs = (0..n).filter_map(|i| operator.velocity_of(i).map(|j| (i, j)));
        let displacements: Vec<_> = pairs.filter(|&(_, j)| operator.velocity_of(j).is_none()).collect();
        let states = named(names, n, &displacements)?;
        let induced = !noise_induced_drift(&columns, n).iter().all(Polynomial::is_zero);
        let field = field(induced && interpretation == Interpretation::Stratonovich);
        let constant_noise = columns.iter().flatten().all(|entry| entry.degree() == 0);
        let equations = Equations {
            states,
            parameters,
            drift,
            columns,
            interpretation,
            operator,
            constant_noise,
            displacements,
            field,
        };
        Ok(Problem { equations: Arc::new(equations), walls: Vec::new() })
    }

    /// The same with one more wall.
    ///
    /// # Errors
    /// [`Error::NotADisplacement`] unless some state is the velocity of the wall's, and of its other body's; [`Error::OutOfRange`]
    /// for a second wall on the same side, a body that hits itself, or walls that leave the motion no room.
    pub fn with_wall(mut self, wall: Wall) -> Result<Self> {
        let wall = wall.checked()?;
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
        if !room::is_room(&self.walls) {
            let remedy = "the motion must have room between the walls";
            return refused("offset of the wall", wall.offset(), remedy);
        }
        Ok(self)
    }

    /// The same without walls.
    pub fn without_walls(&self) -> Self {
        Problem { equations: Arc::clone(&self.equations), walls: Vec::new() }
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
        let unknown = || Error::NotAName { name: name.to_owned(), problem: "no state has it" };
        self.states().iter().position(|state| state == name).ok_or_else(unknown)
    }

    /// The names and values of the parameters that the system lists.
    pub fn parameters(&self) -> &[(String, f64)] {
        &self.equations.parameters
    }

    /// The Fokker-Planck operator: Itô drift and diffusion matrix as polynomials.
    pub fn operator(&self) -> &FokkerPlanck {
        &self.equations.operator
    }

    /// The drift as it was written, in the system's own interpretation.
    pub fn drift(&self) -> &[Polynomial] {
        &self.equations.drift
    }

    /// The columns of G: `noise()[k][i]` is the factor of Wiener process k in state i.
    pub fn noise(&self) -> &[Vec<Polynomial>] {
        &self.equations.columns
    }

    /// The Poisson impulses, each with its H.
    pub fn impulses(&self) -> &[Impulse] {
        self.operator().impulses()
    }

    /// The interpretation of G(X) dW, Itô's or Stratonovich's.
    pub fn interpretation(&self) -> Interpretation {
        self.equations.interpretation
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
    /// [`Error::NoStationaryDensity`] if a variance grows without bound or does not settle.
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
        &*self.equations.field
    }

    /// The sign changes of states that leave the Fokker-Planck equation as it is, and every wall where it is.
    pub(crate) fn symmetry(&self) -> Symmetry {
        Symmetry::of(self.operator())
            .without_flips_of(self.walls().iter().flat_map(|wall| [Some(wall.state()), wall.other()]).flatten())
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

/// The names that were given, or the usual ones.
fn named(names: Vec<String>, n: usize, displacements: &[(usize, usize)]) -> Result<Vec<String>> {
    if names.is_empty() {
        let usual = n == 2 && displacements == [(0, 1)];
        return Ok(if usual { vec!["x".into(), "v".into()] } else { (1..=n).map(|i| format!("x{i}")).collect() });
    }
    dimension("a list of names", names.len(), n)?;
    for (i, name) in names.iter().enumerate() {
        let problem = if name.is_empty() || name.chars().any(char::is_whitespace) {
            "it must have letters and no space"
        } else if names[..i].contains(name) {
            "two states have it"
        } else {
            continue;
        };
        return Err(Error::NotAName { name: name.clone(), problem });
    }
    Ok(names)
}

impl fmt::Debug for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Problem")
            .field("equation", &format_args!("{}", self.operator().text(self.states())))
            .field("walls", &self.walls)
            .finish_non_exhaustive()
    }
}
