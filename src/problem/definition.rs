//! Problems from their definitions.

use super::field::{AnySize, Field, Fixed};
use super::{Equations, Problem};
use crate::checks::dimension;
use crate::error::{Error, Result};
use crate::fokker_planck::{FokkerPlanck, Impulse, noise_induced_drift};
use crate::polynomial::{Arena, Polynomial, Symbol};
use crate::system::{Interpretation, PolynomialDrift, PolynomialSystem};
use std::sync::Arc;

/// A system as its polynomials.
struct Definition {
    drift: Vec<Polynomial>,
    columns: Vec<Vec<Polynomial>>,
    interpretation: Interpretation,
    impulses: Vec<Impulse>,
    names: Vec<String>,
    parameters: Vec<(String, f64)>,
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
        let definition = Definition { drift, columns, interpretation, impulses, names, parameters };
        definition.problem(|induces| Box::new(Fixed::<T, N, M> { system, induces }) as Box<dyn Field>)
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
        let definition = Definition { drift, columns, interpretation, impulses, names, parameters };
        definition.problem(|induces| Box::new(AnySize { system, induces }) as Box<dyn Field>)
    }
}

impl Definition {
    /// The problem; `field` makes the evaluation of the same system, given whether the noise induces a drift.
    fn problem(self, field: impl FnOnce(bool) -> Box<dyn Field>) -> Result<Problem> {
        let Definition { drift, columns, interpretation, impulses, names, parameters } = self;
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
