//! What a text in any language needs to know of ln p.

use super::similarity::Grazing;
use super::{ClosedDensity, ClosedForm};
use crate::closure::{ClosureRecord, CopulaRecord, DomainRecord, IntegralsRecord};
use crate::density::{ExpRecord, SupportRecord};
use crate::{ClosureDensity, Density, Error, ExpPolynomial, Polynomial, Result, Support};

/// Powers of the states themselves are written if they are as exact as this, relative to ln p or to 1.
const EXACT: f64 = 1e-13;
/// Places along each state where that is tried.
const TRIED: [usize; 2] = [33, 3];

/// ln p = constant + Σ c z^α + what walls add, z the coordinates. Texts add up in the order in which the library does, the
/// constant first in powers of the states and last otherwise: where large terms cancel, their rounding does too.
pub(super) struct Formula {
    pub(super) names: Vec<String>,
    /// Sentences for a comment, in ASCII.
    pub(super) facts: Vec<String>,
    pub(super) coordinates: Coordinates,
    pub(super) constant: f64,
    /// Exponents, or degrees of Legendre polynomials, and coefficients.
    pub(super) terms: Vec<(Vec<u32>, f64)>,
    pub(super) corners: Vec<CornerFormula>,
    pub(super) domain: Domain,
}

/// What the polynomial is written in.
pub(super) enum Coordinates {
    /// Powers of the states.
    States,
    /// Powers of z = matrix (x − origin), the matrix by rows.
    Affine { origin: Vec<f64>, matrix: Vec<Vec<f64>> },
    /// Legendre polynomials of z_i = (x_i − centre_i)/half_width_i.
    Legendre { centre: Vec<f64>, half_width: Vec<f64> },
}

/// A wall in state 0: with u = side (x − offset)/reach_0 ≥ 0, w = side v/reach_1 and A = (w⁶ + (κu)² + tiny)^{1/6}, the
/// terms c A^p u^i w^j, and the similarity solution of grazing impacts.
pub(super) struct CornerFormula {
    pub(super) offset: f64,
    pub(super) side: f64,
    pub(super) reach: [f64; 2],
    pub(super) kappa: f64,
    pub(super) kinks: Vec<([i32; 3], f64)>,
    pub(super) grazing: Option<Grazing>,
}

/// Where the density is not zero.
pub(super) enum Domain {
    Everywhere,
    /// Lower and upper limits, which may be infinite.
    Box(Vec<[f64; 2]>),
    /// Star-shaped, in one state or two; the limits are those of state 0 between walls.
    Star {
        centre: Vec<f64>,
        scale: Vec<f64>,
        reach: Vec<f64>,
        walls: [f64; 2],
    },
    /// An ellipsoid in normal scores.
    Copula(CopulaRecord),
}

impl<const N: usize> ClosedForm<N> {
    pub(super) fn formula(&self) -> Result<Formula> {
        let names = self.names().to_vec();
        match self.density() {
            ClosedDensity::Closure(density) => of_closure(density, names),
            ClosedDensity::ExpPolynomial(density) => Ok(of_exp_polynomial(density, names)),
        }
    }
}

/// The sentence that says what `log_p` is.
fn subject(names: &[String]) -> String {
    let arguments = names.join(", ");
    format!("ln p({arguments}): the natural logarithm of a stationary probability density, per unit of each state.")
}

/// The limits of the states in words.
pub(super) fn limits(names: &[String], bounds: &[[f64; 2]]) -> String {
    let sides = names.iter().zip(bounds).map(|(name, [low, high])| format!("{low:.6} <= {name} <= {high:.6}"));
    sides.collect::<Vec<_>>().join(", ")
}

fn of_closure<const N: usize>(density: &ClosureDensity<N>, names: Vec<String>) -> Result<Formula> {
    let record = ClosureRecord::from(density);
    let provenance = density.provenance();
    let mut facts = vec![
        subject(&names),
        format!(
            "Exponential-polynomial closure of order {}, {} coefficients; estimated L1 error {:.1e}.",
            provenance.order,
            provenance.unknowns,
            density.l1_estimate()
        ),
        format!("Pilot of {} states, seed {}; expoly {}.", provenance.pilot_states, provenance.seed, version()),
        format!("Trust domain, within the box {}: see inside().", limits(&names, &density.bounds())),
        String::from("Outside the trust domain the density is taken for zero, and log_p is minus infinity."),
    ];
    facts.extend(density.warning().map(|warning| format!("Warning: {warning}.")));
    if record.guarded {
        facts.push(String::from("The steep fall that continues it there is not written out."));
    }
    let domain = match &record.integrals {
        IntegralsRecord::Draws(draws) => Domain::Copula(draws.copula.clone()),
        IntegralsRecord::Panels { .. } => {
            let DomainRecord { centre, scale, reach, walls } = record.domain.clone();
            Domain::Star { centre, scale, reach, walls: walls.map(|wall| wall.0) }
        }
    };
    let value = |x: &[f64; N]| density.contains(x).then(|| density.log_pdf(x));
    let powers = density.log_polynomial().filter(|p| as_exact(p, &density.bounds(), value));
    let (coordinates, constant, terms, corners) = match powers {
        Some(polynomial) => {
            let (constant, terms) = terms_of(&polynomial);
            (Coordinates::States, constant, terms, Vec::new())
        }
        None => in_functions(&record)?,
    };
    Ok(Formula { names, facts, coordinates, constant, terms, corners, domain })
}

type Written = (Coordinates, f64, Vec<(Vec<u32>, f64)>, Vec<CornerFormula>);

/// ln p in the functions that it was sought in.
fn in_functions(record: &ClosureRecord) -> Result<Written> {
    let exponent = &record.exponent;
    let functions = &exponent.functions;
    let [step] = &functions.steps[..] else {
        let reason = "its functions are several lists; save it as JSON instead";
        return Err(Error::NoText { language: "source text", reason });
    };
    let (polynomials, mut singular) = exponent.coefficients.split_at(step.exponents.len());
    let terms = step.exponents.iter().cloned().zip(polynomials.iter().copied()).collect();
    let mut corners = Vec::new();
    for corner in &functions.corners {
        let (own, rest) = singular.split_at(step.kinks.len());
        singular = rest;
        let [u, w] = corner.reach;
        corners.push(CornerFormula {
            offset: corner.offset,
            side: if corner.ceiling { -1.0 } else { 1.0 },
            reach: corner.reach,
            kappa: 27.0 * corner.intensity * u / w.powi(3),
            kinks: step.kinks.iter().copied().zip(own.iter().copied()).collect(),
            grazing: exponent.singular.contains(corner).then(|| Grazing::of(corner)).flatten(),
        });
    }
    let coordinates = Coordinates::Legendre { centre: step.centre.clone(), half_width: step.half_width.clone() };
    Ok((coordinates, exponent.constant, terms, corners))
}

fn of_exp_polynomial<const N: usize>(density: &ExpPolynomial<N>, names: Vec<String>) -> Formula {
    let record = ExpRecord::from(density);
    let polynomial = density.log_polynomial();
    let origin = record.origin.clone();
    // Ten scales around the middle.
    let reach = |i: usize| 5.0 * record.scale[i].iter().map(|entry| entry * entry).sum::<f64>().sqrt();
    let around: [[f64; 2]; N] = std::array::from_fn(|i| [origin[i] - reach(i), origin[i] + reach(i)]);
    let (domain, bounds) = match &record.support {
        SupportRecord::WholeSpace => (Domain::Everywhere, None),
        SupportRecord::Above(bound) => {
            let limit = |i: usize| [if i == 0 { *bound } else { f64::NEG_INFINITY }, f64::INFINITY];
            (Domain::Box((0..N).map(limit).collect()), None)
        }
        SupportRecord::Region(limits) => (Domain::Box(limits.clone()), Some(limits.clone())),
    };
    let trust = match density.support() {
        Support::WholeSpace => String::from("Trust domain: all states."),
        Support::Above(bound) => format!("Trust domain: {} >= {bound}; below, log_p is minus infinity.", names[0]),
        Support::Region(_) => {
            let sides = limits(&names, bounds.as_deref().unwrap_or(&[]));
            format!("Cut off at the box {sides}; outside, log_p is minus infinity.")
        }
    };
    let degree = polynomial.degree();
    let facts = vec![
        subject(&names),
        format!(
            "Exponential polynomial of order {degree}, {} terms; it knows no error of its own.",
            record.terms.len()
        ),
        format!(
            "Its mass is normalised to a relative error of {:.1e}; expoly {}.",
            density.log_mass().error,
            version()
        ),
        trust,
    ];
    let within = |x: &[f64; N]| Some(density.log_pdf(x)).filter(|log| log.is_finite());
    let (coordinates, (constant, terms)) = if as_exact(&polynomial, &around, within) {
        (Coordinates::States, terms_of(&polynomial))
    } else {
        let constant = -density.log_mass().value;
        (Coordinates::Affine { origin, matrix: ExpRecord::inverse(density) }, (constant, record.terms))
    };
    Formula { names, facts, coordinates, constant, terms, corners: Vec::new(), domain }
}

/// Whether a polynomial in powers of the states has the values of ln p, on a lattice in a box.
fn as_exact<const N: usize>(
    polynomial: &Polynomial<N>,
    bounds: &[[f64; 2]; N],
    value: impl Fn(&[f64; N]) -> Option<f64>,
) -> bool {
    let along = if N <= 2 { TRIED[0] } else { TRIED[1] };
    // Three places along each of seven states and more would be too many.
    (0..along.pow(N.min(7) as u32)).all(|k| {
        let place = |i: usize| if i < 7 { k / along.pow(i as u32) % along } else { along / 2 };
        let share = |i: usize| (place(i) as f64 + 0.5) / along as f64;
        let x = std::array::from_fn(|i| bounds[i][0] + share(i) * (bounds[i][1] - bounds[i][0]));
        value(&x).is_none_or(|log| (polynomial.evaluate(&x) - log).abs() <= EXACT * log.abs().max(1.0))
    })
}

/// The constant and the other terms.
fn terms_of<const N: usize>(polynomial: &Polynomial<N>) -> (f64, Vec<(Vec<u32>, f64)>) {
    let (constants, others): (Vec<_>, Vec<_>) = polynomial.terms().partition(|(m, _)| m.degree() == 0);
    (constants.iter().map(|(_, c)| c).sum(), others.into_iter().map(|(m, c)| (m.0.to_vec(), c)).collect())
}

pub(super) fn version() -> &'static str {
    env!("CARGO_PKG_VERSION")
}

impl Formula {
    /// The highest degree in any one coordinate.
    pub(super) fn degree(&self) -> u32 {
        self.terms.iter().flat_map(|(powers, _)| powers).copied().max().unwrap_or(0).max(1)
    }
}
