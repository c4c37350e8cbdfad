//! The closed form of a density outside the program: as text in other languages, and as JSON that loads again.

mod document;
mod formula;
mod latex;
mod matlab;
mod names;
mod notation;
mod python;
mod rust;
mod similarity;

use crate::{ClosureDensity, Crossing, Density, Error, Estimate, ExpPolynomial, Polynomial, Result, file};
use std::path::Path;

/// A density with a closed form.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum ClosedDensity<const N: usize> {
    /// The closure's, on its trust domain.
    Closure(Box<ClosureDensity<N>>),
    /// An exponential polynomial: exact, or of the classical closure.
    ExpPolynomial(Box<ExpPolynomial<N>>),
}

impl<const N: usize> From<ClosureDensity<N>> for ClosedDensity<N> {
    fn from(density: ClosureDensity<N>) -> Self {
        ClosedDensity::Closure(Box::new(density))
    }
}

impl<const N: usize> From<ExpPolynomial<N>> for ClosedDensity<N> {
    fn from(density: ExpPolynomial<N>) -> Self {
        ClosedDensity::ExpPolynomial(Box::new(density))
    }
}

/// A density that can leave the program: ln p with the names of its states.
///
/// As LaTeX, Python, Rust or MATLAB it is usable without this library; as JSON it loads again to the same bits, errors,
/// moments and provenance included, without being solved anew. It is a [`Density`] itself.
///
/// ```
/// use expoly::{ClosedForm, Closure, Density, models::Duffing};
/// let density = Closure::classical(4).solve(&Duffing::new(0.2, 1.0, 0.3, 0.2)?)?.density()?;
/// let form = ClosedForm::new(density, ["x", "v"])?;
/// assert!(form.python()?.contains("def log_p(x, v):"));
/// let again = ClosedForm::<2>::from_json(&form.to_json()?)?;
/// assert_eq!(again.log_pdf(&[0.3, -0.4]), form.log_pdf(&[0.3, -0.4]));
/// # Ok::<(), expoly::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct ClosedForm<const N: usize> {
    names: [String; N],
    density: ClosedDensity<N>,
}

impl<const N: usize> ClosedForm<N> {
    /// A density and the names of its states, which are arguments of functions in the languages: letters, digits and
    /// underscores, a letter first.
    ///
    /// # Errors
    /// [`Error::NotAName`] if a name cannot be an argument's.
    pub fn new(density: impl Into<ClosedDensity<N>>, names: [&str; N]) -> Result<Self> {
        names::check(&names)?;
        Ok(ClosedForm { names: names.map(str::to_owned), density: density.into() })
    }

    /// The names of the states.
    pub fn names(&self) -> &[String; N] {
        &self.names
    }

    /// The density.
    pub fn density(&self) -> &ClosedDensity<N> {
        &self.density
    }

    /// ln p as a polynomial of the states, valid where the density lives; `None` where walls ask for more than polynomials.
    pub fn log_polynomial(&self) -> Option<Polynomial<N>> {
        match &self.density {
            ClosedDensity::Closure(density) => density.log_polynomial(),
            ClosedDensity::ExpPolynomial(density) => Some(density.log_polynomial()),
        }
    }

    /// ln p as an equation in LaTeX, its coefficients to twelve digits, with the box around its domain. `symbols` stand
    /// for the states, such as `["x", r"\dot x"]`.
    ///
    /// # Errors
    /// [`Error::NoText`] above a wall, where ln p is more than a polynomial.
    ///
    /// ```
    /// use expoly::{ClosedForm, Closure, models::{Linear, Solved}};
    /// let form = ClosedForm::new(Linear::new(0.5, 1.0, 0.5)?.exact()?, ["x", "v"])?;
    /// assert!(form.latex(["x", r"\dot x"])?.contains(r"- 0.5\,{\dot x}^{2}"));
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn latex(&self, symbols: [&str; N]) -> Result<String> {
        latex::text(self, symbols)
    }

    /// A Python module: `log_p` of the states, a plain function of floats that needs nothing but Python 3; and `inside`,
    /// which says where it is valid. Outside, `log_p` is −∞.
    ///
    /// # Errors
    /// [`Error::NoText`] where the density is of a form that is not written out.
    pub fn python(&self) -> Result<String> {
        Ok(python::text(&self.formula()?))
    }

    /// A Rust module without dependencies, as [`ClosedForm::python`].
    ///
    /// # Errors
    /// As [`ClosedForm::python`].
    pub fn rust(&self) -> Result<String> {
        Ok(rust::text(&self.formula()?))
    }

    /// A MATLAB function file, to be saved as `log_p.m`; it takes arrays of equal size, element by element.
    ///
    /// # Errors
    /// As [`ClosedForm::python`].
    pub fn matlab(&self) -> Result<String> {
        Ok(matlab::text(&self.formula()?))
    }

    /// The density as JSON, every bit kept.
    ///
    /// # Errors
    /// [`Error::NotAClosedForm`] if a number that must be finite is not.
    pub fn to_json(&self) -> Result<String> {
        document::write(self)
    }

    /// The density that [`ClosedForm::to_json`] wrote. Values, moments, errors and provenance have the bits that they
    /// had.
    ///
    /// # Errors
    /// [`Error::NotAClosedForm`] names what is wrong with a text that is cut off, altered, of another version, or of
    /// another number of states.
    pub fn from_json(text: &str) -> Result<Self> {
        document::read(text)
    }

    /// Writes the JSON to a file, whole or not at all.
    ///
    /// # Errors
    /// [`Error::File`], and as [`ClosedForm::to_json`].
    pub fn save(&self, path: impl AsRef<Path>) -> Result<()> {
        file::write(path.as_ref(), self.to_json()?.as_bytes())
    }

    /// Reads a file of [`ClosedForm::save`].
    ///
    /// # Errors
    /// [`Error::File`], and as [`ClosedForm::from_json`].
    pub fn load(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let missing = || file::file_error("read", path, &std::io::ErrorKind::NotFound.into());
        let content = file::read(path)?.ok_or_else(missing)?;
        let problem = || Error::NotAClosedForm { problem: format!("{} is not UTF-8", path.display()) };
        Self::from_json(&String::from_utf8(content).map_err(|_| problem())?)
    }
}

impl<const N: usize> ClosedDensity<N> {
    fn inner(&self) -> &dyn Density<N> {
        match self {
            ClosedDensity::Closure(density) => &**density,
            ClosedDensity::ExpPolynomial(density) => &**density,
        }
    }
}

impl<const N: usize> Density<N> for ClosedDensity<N> {
    fn pdf(&self, x: &[f64; N]) -> Estimate {
        self.inner().pdf(x)
    }

    fn log_pdf(&self, x: &[f64; N]) -> f64 {
        self.inner().log_pdf(x)
    }

    fn marginal(&self, state: usize, x: f64) -> Result<Estimate> {
        self.inner().marginal(state, x)
    }

    fn bounds(&self) -> [[f64; 2]; N] {
        self.inner().bounds()
    }

    fn expectation(&self, g: &(dyn Fn(&[f64; N]) -> f64 + Sync)) -> Estimate {
        self.inner().expectation(g)
    }

    fn joint_marginal(&self, states: [usize; 2], x: [f64; 2]) -> Result<Estimate> {
        self.inner().joint_marginal(states, x)
    }

    fn weighted_states(&self) -> Option<Vec<([f64; N], f64)>> {
        self.inner().weighted_states()
    }

    fn moment(&self, powers: [u32; N]) -> Estimate {
        self.inner().moment(powers)
    }

    fn flux(&self, crossing: Crossing, power: u32) -> Result<Estimate> {
        self.inner().flux(crossing, power)
    }

    fn variance(&self, state: usize) -> Result<Estimate> {
        self.inner().variance(state)
    }
}

impl<const N: usize> Density<N> for ClosedForm<N> {
    fn pdf(&self, x: &[f64; N]) -> Estimate {
        self.density.pdf(x)
    }

    fn log_pdf(&self, x: &[f64; N]) -> f64 {
        self.density.log_pdf(x)
    }

    fn marginal(&self, state: usize, x: f64) -> Result<Estimate> {
        self.density.marginal(state, x)
    }

    fn bounds(&self) -> [[f64; 2]; N] {
        self.density.bounds()
    }

    fn expectation(&self, g: &(dyn Fn(&[f64; N]) -> f64 + Sync)) -> Estimate {
        self.density.expectation(g)
    }

    fn joint_marginal(&self, states: [usize; 2], x: [f64; 2]) -> Result<Estimate> {
        self.density.joint_marginal(states, x)
    }

    fn weighted_states(&self) -> Option<Vec<([f64; N], f64)>> {
        self.density.weighted_states()
    }

    fn moment(&self, powers: [u32; N]) -> Estimate {
        self.density.moment(powers)
    }

    fn flux(&self, crossing: Crossing, power: u32) -> Result<Estimate> {
        self.density.flux(crossing, power)
    }

    fn variance(&self, state: usize) -> Result<Estimate> {
        self.density.variance(state)
    }
}
