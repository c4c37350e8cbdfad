use crate::{ClosedDensity, ClosureDensity, Error, Result, Solution};
use serde::{Deserialize, Serialize, Serializer, ser};

/// How an answer came about and how far it is to be trusted. What a method does not know is missing.
///
/// As JSON a field that is missing is `null`, and a number that is none, such as NaN, is an error that names it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(remote = "Self")]
pub struct Facts {
    /// The classical method's basis.
    pub basis: Option<String>,
    /// The number of coefficients.
    pub unknowns: Option<usize>,
    /// How it ended, in a few words.
    pub termination: String,
    /// Where the chosen density comes from or, of the classical method, the search that ended there.
    pub origin: Option<String>,
    /// Why there is no density.
    pub refusal: Option<String>,
    /// Why the density should not be relied on.
    pub warning: Option<String>,
    /// The method's own estimate of the L¹ error.
    pub l1_estimate: Option<f64>,
    /// The indicator η.
    pub indicator: Option<f64>,
    /// Whether the density is the best of its order and no root.
    pub least_residual: Option<bool>,
    /// ‖F‖, the Galerkin equations: under the density itself or, of the classical method, under its Gaussian. Missing
    /// where the iteration ran away.
    pub residual: Option<f64>,
    /// The condition number of the Jacobian; missing where it is singular.
    pub condition: Option<f64>,
    /// The iterations that it took.
    pub iterations: Option<usize>,
    /// The seed of the pilot.
    pub seed: Option<u64>,
}

impl Serialize for Facts {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        let Facts { l1_estimate, indicator, residual, condition, .. } = *self;
        let numbers = [l1_estimate, indicator, residual, condition];
        let names = ["l1_estimate", "indicator", "residual", "condition"];
        match names.iter().zip(numbers).find(|(_, number)| number.is_some_and(|number| !number.is_finite())) {
            Some((name, Some(number))) => Err(ser::Error::custom(format!("{name} = {number} is no number"))),
            _ => Facts::serialize(self, serializer),
        }
    }
}

impl<'de> Deserialize<'de> for Facts {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        Facts::deserialize(deserializer)
    }
}

/// What a method found at one order: a density, or the reason why there is none.
#[derive(Clone, Debug)]
pub struct Answer<const N: usize> {
    /// How it came about.
    pub facts: Facts,
    /// The density.
    pub density: Option<ClosedDensity<N>>,
    /// The classical method's last iterate, whatever became of it.
    pub solution: Option<Solution<N>>,
}

impl<const N: usize> From<ClosureDensity<N>> for Answer<N> {
    fn from(density: ClosureDensity<N>) -> Self {
        let provenance = density.provenance();
        let facts = Facts {
            basis: None,
            unknowns: Some(provenance.unknowns),
            termination: String::from(if density.least_residual() { "least residual" } else { "root" }),
            origin: density.candidates().first().map(|chosen| chosen.origin.to_string()),
            refusal: None,
            warning: density.warning().map(str::to_owned),
            l1_estimate: Some(density.l1_estimate()),
            indicator: Some(density.indicator()),
            least_residual: Some(density.least_residual()),
            residual: Some(density.residual()),
            condition: None,
            iterations: Some(provenance.iterations),
            seed: Some(provenance.seed),
        };
        Answer { facts, density: Some(density.into()), solution: None }
    }
}

impl<const N: usize> From<Solution<N>> for Answer<N> {
    fn from(solution: Solution<N>) -> Self {
        let (density, refusal) = match solution.density() {
            Ok(density) => (Some(density.into()), None),
            Err(error) => (None, Some(error.to_string())),
        };
        let finite = |number: f64| Some(number).filter(|number| number.is_finite());
        let facts = Facts {
            basis: Some(solution.basis().to_string()),
            unknowns: Some(solution.unknowns()),
            termination: solution.termination().to_string(),
            origin: Some(solution.route().to_string()),
            refusal,
            residual: finite(solution.residual()),
            condition: finite(solution.condition()),
            iterations: Some(solution.iterations()),
            ..Facts::default()
        };
        Answer { facts, density, solution: Some(solution) }
    }
}

impl<const N: usize> Answer<N> {
    /// The answer of a method. That it has no density at some order is an answer.
    ///
    /// # Errors
    /// All others that the method returns.
    ///
    /// ```
    /// use expoly::{Closure, models::DuffingVanDerPol, study::Answer};
    /// let answer = Answer::of(Closure::classical(6).solve(&DuffingVanDerPol::van_der_pol(0.5, 0.3)?))?;
    /// assert!(answer.density.is_none() && answer.facts.termination == "no root");
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn of(answer: Result<impl Into<Self>>) -> Result<Self> {
        let none = |termination: &str, error: &Error| {
            let (termination, refusal) = (termination.to_owned(), Some(error.to_string()));
            let facts = Facts { termination, refusal, ..Facts::default() };
            Ok(Answer { facts, density: None, solution: None })
        };
        match answer {
            Ok(answer) => Ok(answer.into()),
            Err(error @ Error::NotClosed { .. }) => none("not closed", &error),
            Err(error @ Error::NoStationaryDensity { .. }) => none("no Gaussian closure", &error),
            Err(error) => Err(error),
        }
    }
}
