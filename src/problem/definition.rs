//! Problems from their definitions.

use super::family::{Family, Lifted};
use super::surfaces::Split;
use super::{Problem, Surfaces, SystemEquations};
use crate::checks::dimension;
use crate::elementary::Elementary;
use crate::error::{Error, Result};
use crate::field::{Field, Fixed, PolynomialField};
use crate::fokker_planck::{FokkerPlanck, Impulse, noise_induced_drift};
use crate::polynomial::{Arena, Polynomial, Symbol};
use crate::scalar::Scalar;
use crate::system::{Drift, Interpretation, Parameter, Parametric, System};
use num_dual::Dual64;
use std::marker::PhantomData;
use std::sync::Arc;

/// What a [`Problem`] is made of: every [`Drift`], every [`Oscillator`](crate::Oscillator) and every [`System`].
/// Which of these it is, its form, is found when it is compiled.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no definition of a system",
    note = "implement `Oscillator`, `Drift` or `System` for it"
)]
pub trait Definition<Form>: 'static {
    #[doc(hidden)]
    fn parts(self) -> Result<SystemParts>;
}

/// A definition with dual numbers for its parameters.
#[diagnostic::on_unimplemented(
    message = "`{Self}` has no parameters that are dual numbers",
    note = "implement `Oscillator<P>`, `Drift<N, M, P>` or `System<P>` for every `P: Parameter`"
)]
pub trait Differentiated<Form> {
    /// The system with one state more, the ε of its dual numbers.
    #[doc(hidden)]
    fn lifted(&self) -> Result<Lifted>;
}

/// The form of a system whose numbers of states and of processes are known when it is compiled.
#[derive(Debug)]
pub struct Arrays<const N: usize, const M: usize>;

/// The form of a system whose number of states is a number at run time.
#[derive(Debug)]
pub struct Slices;

impl<T: Drift<N, M> + 'static, const N: usize, const M: usize> Definition<Arrays<N, M>> for T {
    fn parts(self) -> Result<SystemParts> {
        let (equations, names) = (fixed(&self, 0), self.names());
        Ok(SystemParts {
            equations,
            names,
            field: Box::new(|induces| Box::new(Fixed::<T, N, M> { system: self, induces })),
        })
    }
}

impl<T: System + 'static> Definition<Slices> for T {
    fn parts(self) -> Result<SystemParts> {
        Ok(SystemParts::of_polynomials(any_size(&self, 0)?, self.names()))
    }
}

impl<T: Drift<N, M, Dual64>, const N: usize, const M: usize> Differentiated<Arrays<N, M>> for T {
    fn lifted(&self) -> Result<Lifted> {
        fixed(self, 1).lifted()
    }
}

impl<T: System<Dual64>> Differentiated<Slices> for T {
    fn lifted(&self) -> Result<Lifted> {
        any_size(self, 1)?.lifted()
    }
}

/// A system as its polynomials and its states' names, and what makes its evaluation, given whether its noise induces a drift.
#[expect(missing_debug_implementations, reason = "no user meets one")]
pub struct SystemParts {
    equations: PolynomialForm<f64>,
    names: Vec<String>,
    field: Box<dyn FnOnce(bool) -> Box<dyn Field>>,
}

impl SystemParts {
    /// A system that is followed by its polynomials.
    fn of_polynomials(equations: PolynomialForm<f64>, names: Vec<String>) -> Self {
        let (drift, columns) = (equations.drift.clone(), equations.columns.clone());
        let field = move |induces| Box::new(PolynomialField::new(&drift, &columns, induces)) as Box<dyn Field>;
        SystemParts { equations, names, field: Box::new(field) }
    }
}

/// The equations of a system as polynomials.
pub(super) struct PolynomialForm<P> {
    pub(super) drift: Vec<Polynomial>,
    pub(super) columns: Vec<Vec<Polynomial>>,
    pub(super) interpretation: Interpretation,
    pub(super) impulses: Vec<Impulse<P>>,
}

impl Problem {
    /// The problem of a system: of a [`Drift`], an [`Oscillator`](crate::Oscillator) or a [`System`]. The
    /// parameters of a [`Parametric`] one have names by [`Problem::parametric`].
    ///
    /// # Errors
    /// [`Error::NotFinite`] if a coefficient, or a product of two in the noise, is NaN or infinite, [`Error::OutOfRange`] for a
    /// degree above 60, [`Error::NoDensity`] if noise and impulses vanish identically;
    /// [`Error::Dimension`], [`Error::NotAName`] if the names do not fit the states;
    /// [`Error::Dimension`] where a [`System`]'s drift or noise do not have its stated length.
    pub fn of<Form>(system: impl Definition<Form>) -> Result<Self> {
        system.parts()?.problem(Vec::new(), None)
    }

    /// The problem of a system with parameters, which answers can be differentiated by.
    ///
    /// # Errors
    /// As [`Problem::of`]; [`Error::NotAName`] where two parameters have the same name.
    pub fn parametric<T, Form: 'static>(system: T) -> Result<Self>
    where
        T: Definition<Form> + Parametric<With<f64> = T> + Send + Sync,
        T::With<Dual64>: Differentiated<Form>,
    {
        let (parameters, copy) = parameters_of(&system)?;
        system.parts()?.problem(parameters, Some(Box::new(Systems(copy, PhantomData))))
    }

    /// The problem of a system that is given as polynomials.
    pub(super) fn of_polynomials(
        equations: PolynomialForm<f64>,
        names: Vec<String>,
        parameters: Vec<(String, f64)>,
        family: Option<Box<dyn Family>>,
    ) -> Result<Self> {
        SystemParts::of_polynomials(equations, names).problem(parameters, family)
    }
}

/// The parameters of a system, and the system once more.
fn parameters_of<T: Parametric<With<f64> = T>>(system: &T) -> Result<(Vec<(String, f64)>, T)> {
    let mut parameters: Vec<(String, f64)> = Vec::new();
    let copy = system.with(&mut |name, value| {
        parameters.push((name.to_owned(), value));
        value
    });
    for (i, (name, _)) in parameters.iter().enumerate() {
        if parameters[..i].iter().any(|(other, _)| other == name) {
            return Err(Error::not_a_name(name, "two parameters have it"));
        }
    }
    Ok((parameters, copy))
}

/// The equations of a system as polynomials in its states and `more` variables.
fn fixed<P: Parameter, T, const N: usize, const M: usize>(system: &T, more: usize) -> PolynomialForm<P>
where
    T: Drift<N, M, P>,
    for<'a> Symbol<'a>: Scalar<P>,
{
    let n = N + more;
    let arena = Arena::new(n);
    let variables = arena.variables();
    let x: [Symbol<'_>; N] = std::array::from_fn(|i| variables[i]);
    let noise = system.noise(x);
    let impulse = |(source, impulses)| Impulse::new(impulses, padded(system.impulse(source, x), n));
    PolynomialForm {
        drift: padded(system.drift(x), n),
        columns: (0..M).map(|k| padded(noise.iter().map(|row| row[k]), n)).collect(),
        interpretation: system.interpretation(),
        impulses: system.impulses().into_iter().enumerate().map(impulse).collect(),
    }
}

/// The same for a number of states at run time.
fn any_size<P: Parameter, T: System<P>>(system: &T, more: usize) -> Result<PolynomialForm<P>>
where
    for<'a> Symbol<'a>: Scalar<P>,
{
    let (states, m) = (system.dimension(), system.processes());
    let n = states + more;
    let arena = Arena::new(n);
    let x = &arena.variables()[..states];
    let (drift, noise) = (system.drift(x), system.noise(x));
    dimension("a drift", drift.len(), states)?;
    dimension("a noise matrix", noise.len(), states)?;
    noise.iter().try_for_each(|row| dimension("a row of a noise matrix", row.len(), m))?;
    let impulse = |(source, impulses)| {
        let field = system.impulse(source, x);
        dimension("the factor of an impulse", field.len(), states)?;
        Ok(Impulse::new(impulses, padded(field, n)))
    };
    Ok(PolynomialForm {
        drift: padded(drift, n),
        columns: (0..m).map(|k| padded(noise.iter().map(|row| row[k]), n)).collect(),
        interpretation: system.interpretation(),
        impulses: system.impulses().into_iter().enumerate().map(impulse).collect::<Result<_>>()?,
    })
}

/// The polynomials of symbols in `n` variables, and zero for the variables that none of them is the drift of.
fn padded<'a>(symbols: impl IntoIterator<Item = Symbol<'a>>, n: usize) -> Vec<Polynomial> {
    let mut all: Vec<Polynomial> = symbols.into_iter().map(|symbol| symbol.polynomial(n)).collect();
    all.resize(n, Polynomial::zero(n));
    all
}

impl<P: Parameter> PolynomialForm<P> {
    fn operator(&self) -> Result<FokkerPlanck> {
        let impulses = self.impulses.iter().map(Impulse::real).collect();
        FokkerPlanck::new(&self.drift, &self.columns, self.interpretation, impulses)
    }
}

impl PolynomialForm<Dual64> {
    /// With the values of its parameters alone.
    pub(super) fn real(self) -> PolynomialForm<f64> {
        let PolynomialForm { drift, columns, interpretation, impulses } = self;
        PolynomialForm { drift, columns, interpretation, impulses: impulses.iter().map(Impulse::real).collect() }
    }

    /// With dual numbers for the parameters, without walls.
    pub(super) fn lifted(self) -> Result<Lifted> {
        Ok(Lifted { operator: self.operator()?, impulses: self.impulses, walls: Vec::new() })
    }
}

/// The systems of a type for all values of its parameters.
struct Systems<T, Form>(T, PhantomData<fn() -> Form>);

impl<T, Form: 'static> Family for Systems<T, Form>
where
    T: Definition<Form> + Parametric<With<f64> = T> + Send + Sync,
    T::With<Dual64>: Differentiated<Form>,
{
    fn at(&self, value: &dyn Fn(&str, f64) -> f64) -> Result<Problem> {
        Problem::parametric(self.0.with(&mut |name, present| value(name, present)))
    }

    fn lifted(&self, value: &dyn Fn(&str, f64) -> Dual64) -> Result<Lifted> {
        self.0.with(&mut |name, present| value(name, present)).lifted()
    }
}

impl SystemParts {
    fn problem(self, parameters: Vec<(String, f64)>, family: Option<Box<dyn Family>>) -> Result<Problem> {
        let SystemParts { equations, names, field } = self;
        let n = equations.drift.len();
        let operator = equations.operator()?;
        let PolynomialForm { drift, columns, interpretation, .. } = equations;
        let roots = roots(&columns, &operator).filter(|_| interpretation == Interpretation::Ito);
        let by_roots = roots.is_some();
        let columns = roots.unwrap_or(columns);
        let pairs = (0..n).filter_map(|i| operator.velocity_of(i).map(|j| (i, j)));
        let displacements: Vec<_> = pairs.filter(|&(_, j)| operator.velocity_of(j).is_none()).collect();
        let states = named(names, n, &displacements)?;
        let induced = !noise_induced_drift(&columns, n).iter().all(Polynomial::is_zero);
        let field = field(induced && interpretation == Interpretation::Stratonovich);
        let constant_noise = columns.iter().flatten().all(|entry| entry.degree() == 0);
        let surfaces = Surfaces::of(&operator);
        let split = Split::of(&drift, &surfaces.straight, constant_noise);
        let bridged = !split.bridges.is_empty();
        let field: Box<dyn Field> = if bridged || by_roots {
            let whole = PolynomialField::new(&drift, &columns, false);
            Box::new(whole.bridged(split.bridges, &split.pushes, &split.rest))
        } else {
            field
        };
        let equations = SystemEquations {
            states,
            parameters,
            drift,
            columns,
            interpretation,
            operator,
            constant_noise,
            displacements,
            surfaces,
            bridged,
            field,
            family,
        };
        Ok(Problem::open(Arc::new(equations)))
    }
}

/// The columns of a G with the same B where G has functions of the states and B is a diagonal of polynomials: √B, which is defined
/// wherever B is not below zero. Noises σ₁ and σ₂ √x have B = σ₁² + σ₂² x.
fn roots(columns: &[Vec<Polynomial>], operator: &FokkerPlanck) -> Option<Vec<Vec<Polynomial>>> {
    let n = operator.dimension();
    let plain = operator.diffusion().iter().flatten().all(Polynomial::is_plain);
    if columns.iter().flatten().all(Polynomial::is_plain) || !plain || !operator.coupled().is_empty() {
        return None;
    }
    let driven = (0..n).filter(|&i| !operator.diffusion()[i][i].is_zero());
    let root = |i: usize| operator.diffusion()[i][i].applied(Elementary::PositivePower(0.5));
    Some(driven.map(|i| (0..n).map(|j| if i == j { root(i) } else { Polynomial::zero(n) }).collect()).collect())
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
        return Err(Error::not_a_name(name, format!("{problem}; x, v, x1, x2 are usual names of states")));
    }
    Ok(names)
}
