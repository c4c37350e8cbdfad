//! The closed form of a density outside the program: as text in other languages, and as JSON that loads again.

mod document;
mod formula;
mod language;
mod latex;
mod matlab;
mod names;
mod python;

use crate::checks::dimension;
use crate::closure::ClosureDensity;
use crate::density::{Crossing, Density, Evidence, ExpPolynomial, summary};
use crate::error::{Error, Result};
use crate::estimate::Estimate;
use crate::file;
use crate::polynomial::Polynomial;
use crate::provenance::Provenance;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::Path;

/// A density with a closed form.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ClosedDensity {
    /// The closure's, on its trust domain.
    Closure(Box<ClosureDensity>),
    /// An exponential polynomial: exact, or of the classical closure.
    ExpPolynomial(Box<ExpPolynomial>),
}

impl From<ClosureDensity> for ClosedDensity {
    fn from(density: ClosureDensity) -> Self {
        ClosedDensity::Closure(Box::new(density))
    }
}

impl From<ExpPolynomial> for ClosedDensity {
    fn from(density: ExpPolynomial) -> Self {
        ClosedDensity::ExpPolynomial(Box::new(density))
    }
}

/// A density that can leave the program: ln p with the names of its states.
///
/// As LaTeX, Python or MATLAB it is usable without this library; as JSON it loads again to the same bits, errors,
/// moments and provenance included, without being solved anew. It is a [`Density`] itself.
///
/// ```
/// use expoly::{ClosedForm, Closure, Density, models::{Duffing, Solved}};
/// let density = Closure::classical(4).solve(&Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?)?.density()?;
/// let form = ClosedForm::new(density, &["x", "v"])?;
/// assert!(form.python()?.contains("def log_p(x, v):"));
/// let again = ClosedForm::from_json(&form.to_json()?)?;
/// assert_eq!(again.log_pdf(&[0.3, -0.4])?, form.log_pdf(&[0.3, -0.4])?);
/// # Ok::<(), expoly::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct ClosedForm {
    names: Vec<String>,
    density: ClosedDensity,
}

impl ClosedForm {
    /// A [`ClosureDensity`] or an [`ExpPolynomial`], and the names of its states, which are arguments of functions in the
    /// languages: letters, digits and underscores, a letter first.
    ///
    /// # Errors
    /// [`Error::NotAName`] if a name cannot be an argument's; [`Error::Dimension`] if there is not one for each state.
    pub fn new(density: impl Into<ClosedDensity>, names: &[impl AsRef<str>]) -> Result<Self> {
        let names = names.iter().map(|name| name.as_ref().to_owned()).collect();
        let form = ClosedForm { names, density: density.into() };
        names::check(&form.names)?;
        dimension("the names of the states", form.names.len(), form.dimension())?;
        Ok(form)
    }

    /// The names of the states.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The closure's density, if it is one.
    pub fn closure(&self) -> Option<&ClosureDensity> {
        match &self.density {
            ClosedDensity::Closure(density) => Some(density),
            ClosedDensity::ExpPolynomial(_) => None,
        }
    }

    /// The exponential polynomial, if it is one.
    pub fn exp_polynomial(&self) -> Option<&ExpPolynomial> {
        match &self.density {
            ClosedDensity::Closure(_) => None,
            ClosedDensity::ExpPolynomial(density) => Some(density),
        }
    }

    /// ln p as a polynomial of the states, valid on the support of the density; `None` where walls add terms that are no
    /// polynomials.
    pub fn log_polynomial(&self) -> Option<Polynomial> {
        match &self.density {
            ClosedDensity::Closure(density) => density.log_polynomial(),
            ClosedDensity::ExpPolynomial(density) => Some(density.log_polynomial()),
        }
    }

    /// ln p as an equation in LaTeX, its coefficients to twelve digits, with the box around its domain. `symbols` stand
    /// for the states, such as `["x", r"\dot x"]`.
    ///
    /// # Errors
    /// [`Error::NotKnown`] above a wall, where ln p is more than a polynomial; [`Error::Dimension`] if there is not one
    /// symbol for each state.
    ///
    /// ```
    /// use expoly::{ClosedForm, Closure, models::{Linear, Solved}};
    /// let form = ClosedForm::new(Linear::new(0.5, 1.0, 0.5)?.exact()?, &["x", "v"])?;
    /// assert!(form.latex(&["x", r"\dot x"])?.contains(r"- 0.5\,{\dot x}^{2}"));
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn latex(&self, symbols: &[&str]) -> Result<String> {
        dimension("the symbols of the states", symbols.len(), self.dimension())?;
        latex::text(self, symbols)
    }

    /// A Python module: `log_p` of the states, a plain function of floats that needs nothing but Python 3; and `inside`,
    /// which is true where it is valid. Outside, `log_p` is −∞.
    ///
    /// # Errors
    /// [`Error::NotKnown`] where the density is of a form that is not written out.
    pub fn python(&self) -> Result<String> {
        Ok(python::text(&self.formula()?))
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
        document::write(self).map_err(|problem| Error::NotAClosedForm { problem })
    }

    /// The density that [`ClosedForm::to_json`] wrote. Values, moments, errors and provenance have the bits that they
    /// had.
    ///
    /// # Errors
    /// [`Error::NotAClosedForm`] names what is wrong with a text that is cut off, altered, or of another version.
    pub fn from_json(text: &str) -> Result<Self> {
        document::read(text).map_err(|problem| Error::NotAClosedForm { problem })
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
        let missing = || file::file_error("read", path, std::io::ErrorKind::NotFound.into());
        let content = file::read(path)?.ok_or_else(missing)?;
        let problem = || Error::NotAClosedForm { problem: format!("{} is not UTF-8", path.display()) };
        Self::from_json(&String::from_utf8(content).map_err(|_| problem())?)
    }

    fn inner(&self) -> &dyn Density {
        match &self.density {
            ClosedDensity::Closure(density) => &**density,
            ClosedDensity::ExpPolynomial(density) => &**density,
        }
    }
}

/// Methods of [`Density`] that are passed on to the density inside.
macro_rules! forwarded {
    ($(fn $question:ident(&self $(, $argument:ident: $kind:ty)*) -> $answer:ty;)*) => {$(
        fn $question(&self $(, $argument: $kind)*) -> $answer {
            self.inner().$question($($argument),*)
        }
    )*};
}

impl Density for ClosedForm {
    forwarded! {
        fn dimension(&self) -> usize;
        fn pdf(&self, x: &[f64]) -> Result<Estimate>;
        fn log_pdf(&self, x: &[f64]) -> Result<f64>;
        fn marginal(&self, state: usize, x: f64) -> Result<Estimate>;
        fn bounds(&self) -> Vec<[f64; 2]>;
        fn expectation(&self, g: &(dyn Fn(&[f64]) -> f64 + Sync)) -> Result<Estimate>;
        fn joint_marginal(&self, states: [usize; 2], x: [f64; 2]) -> Result<Estimate>;
        fn provenance(&self) -> &Provenance;
        fn l1_estimate(&self) -> f64;
        fn impact_rate(&self) -> Option<Estimate>;
        fn evidence(&self) -> &dyn Evidence;
        fn moment(&self, powers: &[u32]) -> Result<Estimate>;
        fn flux(&self, crossing: Crossing, power: u32) -> Result<Estimate>;
        fn variance(&self, state: usize) -> Result<Estimate>;
    }
}

impl fmt::Display for ClosedForm {
    /// How it was made, its domain, moments and rates, and its estimate of the error, a line each.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        summary(self, f)
    }
}
