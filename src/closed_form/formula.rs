//! The content of ln p that a text in any language must contain.

use super::{ClosedDensity, ClosedForm};
use crate::closure::{ClosureDensity, Copula, DomainCells, TrustDomain};
use crate::density::{Density, ExpPolynomial, Support};
use crate::error::{Error, Result};
use crate::functions::{Corner, Similarity};
use crate::polynomial::{Polynomial, total_degree};

/// Powers of the states themselves are written if their error is at most this, relative to ln p or to 1.
const EXACT: f64 = 1e-13;
/// Places along each state where that error is measured: in up to two states, and in more.
const TRIED: [usize; 2] = [33, 3];

/// Exponents, or degrees of Legendre polynomials, and coefficients.
type Terms = Vec<(Vec<u32>, f64)>;

/// ln p = constant + Σ c z^α + what walls add, z the coordinates. Texts add up in the order in which the library does, the
/// constant first in powers of the states and last otherwise: where large terms cancel, their rounding does too.
pub(super) struct Formula<'a> {
    pub(super) names: &'a [String],
    /// Sentences for a comment, in ASCII.
    pub(super) facts: Vec<String>,
    pub(super) coordinates: Coordinates<'a>,
    pub(super) constant: f64,
    pub(super) terms: Terms,
    pub(super) corners: Vec<CornerFormula<'a>>,
    pub(super) domain: Domain<'a>,
}

/// The coordinates that the polynomial is written in.
pub(super) enum Coordinates<'a> {
    /// Powers of the states.
    States,
    /// Powers of z = matrix (x − origin), the matrix by rows.
    Affine { origin: &'a [f64], matrix: Vec<Vec<f64>> },
    /// Legendre polynomials of z_i = (x_i − centre_i)/half_width_i.
    Legendre { centre: &'a [f64], half_width: &'a [f64] },
}

/// A wall in state 0: with u = side (x − offset)/reach_0 ≥ 0, w = side v/reach_1 and A = (w⁶ + (κu)² + tiny)^{1/6}, the
/// terms c A^p u^i w^j, and the similarity solution of grazing impacts.
pub(super) struct CornerFormula<'a> {
    pub(super) offset: f64,
    pub(super) side: f64,
    pub(super) reach: [f64; 2],
    pub(super) kappa: f64,
    pub(super) kinks: Vec<([i32; 3], f64)>,
    pub(super) grazing: Option<&'a Similarity>,
}

impl<'a> CornerFormula<'a> {
    /// Without kinks.
    fn at(corner: &'a Corner, grazes: bool) -> Self {
        let reach = corner.reach();
        CornerFormula {
            offset: corner.wall().offset(),
            side: corner.side(),
            reach,
            kappa: 27.0 * corner.intensity() * reach[0] / reach[1].powi(3),
            kinks: Vec::new(),
            // None at an elastic wall.
            grazing: Some(corner).filter(|_| grazes).and_then(Corner::similarity).filter(|found| found.exponent != 0.0),
        }
    }
}

/// Where the density is not zero.
pub(super) enum Domain<'a> {
    Everywhere,
    /// Lower and upper limits, which may be infinite.
    Box(Vec<[f64; 2]>),
    /// Star-shaped, in one state or two.
    Star(&'a TrustDomain),
    /// An ellipsoid in normal scores.
    Ellipsoid(&'a Copula),
    /// Boxes, in one state or two.
    Cells(&'a DomainCells),
}

impl ClosedForm {
    pub(super) fn formula(&self) -> Result<Formula<'_>> {
        match &self.density {
            ClosedDensity::Closure(density) => of_closure(density, &self.names),
            ClosedDensity::ExpPolynomial(density) => of_exp_polynomial(density, &self.names),
        }
    }
}

/// The sentence that defines `log_p`.
fn subject(names: &[String]) -> String {
    let arguments = names.join(", ");
    format!("ln p({arguments}): the natural logarithm of a stationary probability density, per unit of each state.")
}

/// The limits of the states as inequalities.
fn limits(names: &[String], bounds: &[[f64; 2]]) -> String {
    let sides = names.iter().zip(bounds).map(|(name, [low, high])| format!("{low:.6} <= {name} <= {high:.6}"));
    sides.collect::<Vec<_>>().join(", ")
}

const VERSION: &str = env!("CARGO_PKG_VERSION");

fn of_closure<'a>(density: &'a ClosureDensity, names: &'a [String]) -> Result<Formula<'a>> {
    let (provenance, bounds) = (density.provenance(), density.bounds());
    let [unknowns, states] = [provenance.unknowns, provenance.pilot_states].map(Option::unwrap_or_default);
    let (order, seed) = (provenance.order.unwrap_or_default(), provenance.seed.unwrap_or_default());
    let error = density.l1_estimate();
    let mut facts = vec![
        subject(names),
        format!(
            "Exponential-polynomial closure of order {order}, {unknowns} coefficients; estimated L1 error {error:.1e}."
        ),
        match &provenance.reference {
            Some(reference) => format!("Closest to: {reference}; expoly {VERSION}."),
            None => format!("Pilot of {states} states, seed {seed}; expoly {VERSION}."),
        },
        format!("Trust domain, within the box {}: see inside().", limits(names, &bounds)),
        String::from("Outside the trust domain the density is taken for zero, and log_p is minus infinity."),
    ];
    facts.extend(density.warning().map(|warning| format!("Warning: {warning}.")));
    let domain = match density.cells_of_domain() {
        Some(cells) => Domain::Cells(cells),
        None => density.domain().map_or_else(Domain::Ellipsoid, Domain::Star),
    };
    let within = |x: &[f64]| density.contains(x)?.then(|| density.log_pdf(x)).transpose();
    let powers = match density.log_polynomial().filter(Polynomial::is_plain) {
        Some(polynomial) if as_exact(&polynomial, &bounds, within)? => Some(polynomial),
        _ => None,
    };
    let (coordinates, (constant, terms), corners) = match powers {
        Some(polynomial) => (Coordinates::States, terms_of(&polynomial), Vec::new()),
        None => in_functions(density)?,
    };
    Ok(Formula { names, facts, coordinates, constant, terms, corners, domain })
}

type Written<'a> = (Coordinates<'a>, (f64, Terms), Vec<CornerFormula<'a>>);

/// ln p in the functions that it was sought in.
fn in_functions(density: &ClosureDensity) -> Result<Written<'_>> {
    let exponent = density.exponent();
    let space = &exponent.space;
    let corner = |corner| CornerFormula::at(corner, exponent.known.contains(corner));
    let mut corners: Vec<CornerFormula<'_>> = space.corners().iter().map(corner).collect();
    let mut terms = Vec::new();
    for (kink, polynomials, a) in space.terms(&exponent.coefficients) {
        if !polynomials.folds().is_empty() {
            let reason = "its functions have kinks where the drift has them; take LaTeX, or save it as JSON";
            return Err(Error::NotKnown { what: "its text in a language".into(), remedy: reason });
        }
        let own = polynomials.exponents().iter().cloned().zip(a.iter().copied());
        match kink {
            None => terms.extend(own),
            Some((wall, kink)) if space.dimension() == 2 => {
                corners[wall].kinks.extend(own.map(|(_, a)| (kink.0, a)));
            }
            Some(_) => {
                let reason = "its kinks are multiplied by polynomials of other states; save it as JSON instead";
                return Err(Error::NotKnown { what: "its text in a language".into(), remedy: reason });
            }
        }
    }
    let [centre, half_width] = space.box_around();
    Ok((Coordinates::Legendre { centre, half_width }, (exponent.constant, terms), corners))
}

fn of_exp_polynomial<'a>(density: &'a ExpPolynomial, names: &'a [String]) -> Result<Formula<'a>> {
    let polynomial = density.log_polynomial();
    let (in_coordinates, frame) = density.in_coordinates();
    let (origin, mass) = (frame.origin(), density.log_mass());
    // Ten scales around the middle.
    let around = |(i, middle): (usize, &f64)| {
        let reach = 5.0 * frame.scale().row(i).norm();
        [middle - reach, middle + reach]
    };
    let around: Vec<[f64; 2]> = origin.iter().enumerate().map(around).collect();
    let (domain, trust) = match density.support() {
        Support::WholeSpace => (Domain::Everywhere, String::from("Trust domain: all states.")),
        Support::Above(bound) => {
            let mut limits = vec![[f64::NEG_INFINITY, f64::INFINITY]; names.len()];
            limits[0][0] = *bound;
            let trust = format!("Trust domain: {} >= {bound}; below, log_p is minus infinity.", names[0]);
            (Domain::Box(limits), trust)
        }
        Support::Region(region) => {
            let trust = format!("Cut off at the box {}; outside, log_p is minus infinity.", limits(names, region));
            (Domain::Box(region.clone()), trust)
        }
    };
    let (degree, count) = (polynomial.degree(), in_coordinates.terms().count());
    let facts = vec![
        subject(names),
        format!("Exponential polynomial of order {degree}, {count} terms; it has no estimate of its own error."),
        format!("Its mass is normalised to a relative error of {:.1e}; expoly {VERSION}.", mass.error),
        trust,
    ];
    let within = |x: &[f64]| Ok(Some(density.log_pdf(x)?).filter(|log| log.is_finite()));
    let (coordinates, (constant, terms)) = if as_exact(&polynomial, &around, within)? {
        (Coordinates::States, terms_of(&polynomial))
    } else {
        let matrix = frame.inverse().row_iter().map(|row| row.iter().copied().collect()).collect();
        let terms = in_coordinates.terms().map(|(alpha, c)| (alpha.to_vec(), c)).collect();
        (Coordinates::Affine { origin, matrix }, (-mass.value, terms))
    };
    Ok(Formula { names, facts, coordinates, constant, terms, corners: Vec::new(), domain })
}

/// Whether a polynomial in powers of the states has the values of ln p, on a lattice in a box.
fn as_exact(
    polynomial: &Polynomial,
    bounds: &[[f64; 2]],
    value: impl Fn(&[f64]) -> Result<Option<f64>>,
) -> Result<bool> {
    let n = bounds.len();
    let along = if n <= 2 { TRIED[0] } else { TRIED[1] };
    // Three places along each of seven states and more would be too many.
    for k in 0..along.pow(n.min(7) as u32) {
        let place = |i: usize| if i < 7 { k / along.pow(i as u32) % along } else { along / 2 };
        let share = |i: usize| (place(i) as f64 + 0.5) / along as f64;
        let x: Vec<f64> = bounds.iter().enumerate().map(|(i, [low, high])| low + share(i) * (high - low)).collect();
        if value(&x)?.is_some_and(|log| (polynomial.evaluate(&x[..]) - log).abs() > EXACT * log.abs().max(1.0)) {
            return Ok(false);
        }
    }
    Ok(true)
}

/// The constant and the other terms.
fn terms_of(polynomial: &Polynomial) -> (f64, Terms) {
    let others = polynomial.terms().filter(|(alpha, _)| total_degree(alpha) > 0);
    (polynomial.constant_term(), others.map(|(alpha, c)| (alpha.to_vec(), c)).collect())
}

impl Formula<'_> {
    /// The highest degree in any one coordinate.
    pub(super) fn degree(&self) -> u32 {
        self.terms.iter().flat_map(|(powers, _)| powers).copied().max().unwrap_or(0).max(1)
    }
}
