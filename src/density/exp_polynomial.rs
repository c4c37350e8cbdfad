use super::tensor::{Section, TensorRule};
use super::{Crossing, Density, Support, escape_direction, moderate, pair, summary};
use crate::checks::{coordinate, dimension, finite, point, positive};
use crate::error::{Error, Result};
use crate::estimate::Estimate;
use crate::polynomial::{Frame, Gaussian, Polynomial, total_degree};
use crate::provenance::{CLOSED_FORM, Provenance};
use crate::record::Read;
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use std::fmt;

/// A density p = C exp(Q) with a polynomial Q, on R^n, above a wall, or cut off at a given region.
///
/// It is normalised by quadrature, whose error estimate goes into every value. Integrals cost milliseconds in two states
/// and up to seconds in six.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(into = "DensityDocument", try_from = "DensityDocument")]
pub struct ExpPolynomial {
    /// In the coordinates of the frame.
    q: Polynomial,
    frame: Frame,
    support: Support,
    /// The relative size below which a coefficient was taken for rounding.
    noise: f64,
    rule: TensorRule,
    coarse: TensorRule,
    /// ln ∫ exp(Q) dx.
    log_mass: Estimate,
    provenance: Provenance,
}

impl ExpPolynomial {
    /// The density exp(Q) for `q` in the coordinates z of `frame`.
    ///
    /// `noise` is the relative size below which a value counts as rounding and leaves the sign of Q far away open.
    pub(crate) fn new(q: Polynomial, frame: Frame, support: Support, noise: f64) -> Result<Self> {
        dimension("a polynomial", q.dimension(), frame.dimension())?;
        if !q.is_plain() {
            let (method, what) = ("exponential polynomial", "functions of the states in Q");
            return Err(Error::NotServed { method, what, remedy: "give a polynomial, or take the grid's density" });
        }
        q.terms().try_for_each(|(_, c)| finite("coefficient of Q", c).map(|_| ()))?;
        let half_space = match &support {
            Support::WholeSpace => Some(false),
            Support::Above(bound) => finite("lower limit of state 0", *bound).map(|_| Some(true))?,
            Support::Region(limits) => {
                dimension("the limits of a region", limits.len(), frame.dimension())?;
                check_sides(limits)?;
                None
            }
        };
        if let Some(direction) = half_space.and_then(|half_space| escape_direction(&q, half_space, noise)) {
            return Err(Error::NotNormalisable { order: q.degree(), direction });
        }
        let (rule, coarse) = TensorRule::fitted(&q, &frame, &support)?;
        let (log_mass, provenance) = (Estimate::exact(0.0), Provenance::of_method("exponential polynomial"));
        let mut density = ExpPolynomial { q, frame, support, noise, rule, coarse, log_mass, provenance };
        let mass = density.integral(Section::default(), |_| 1.0);
        let remedy = "Q is too steep to be integrated: give a scale that is about as wide as exp(Q)";
        positive("mass of exp(Q) relative to its peak", mass.value, remedy)?;
        let log_mass = mass.value.ln() + density.rule.top + density.frame.log_volume();
        density.log_mass = Estimate::new(log_mass, mass.error / mass.value);
        Ok(density)
    }

    /// The same with the record of how it was found.
    pub(crate) fn with_provenance(self, provenance: Provenance) -> Self {
        ExpPolynomial { provenance, ..self }
    }

    /// The same as a density that is exact, but for the error of its normalisation.
    pub(crate) fn known(self) -> Self {
        let l1_estimate = Some(self.log_mass.error);
        self.with_provenance(Provenance { l1_estimate, ..Provenance::of_method(CLOSED_FORM) })
    }

    /// The density exp(Q) for `q` in the states themselves; `scale` is a Gaussian of roughly its location and width.
    ///
    /// # Errors
    /// [`Error::NotNormalisable`] if Q does not fall in every direction that `support` leaves open; [`Error::OutOfRange`] for
    /// a support that is NaN or reversed, for a Q that is not finite or too steep to be integrated, and if the covariance of
    /// `scale` is not positive definite; [`Error::NotServed`] where the quadrature would need too many nodes, and for functions of the
    /// states in Q.
    pub fn from_states(q: &Polynomial, scale: &Gaussian, support: Support) -> Result<Self> {
        let frame = Frame::new(scale)?;
        ExpPolynomial::new(in_frame(q, &frame), frame, support, 1e-13)
    }

    /// exp(Q) cut off at a box of the states, for `q` in the states themselves, whether or not Q falls outside.
    ///
    /// An exp(Q) that is no density on the whole space can so be compared where it is plausible; the caller chooses the box,
    /// and a result should be reported with it.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if a side of the box is not finite and positive, or Q not finite or too steep.
    pub fn cut_off(q: &Polynomial, region: &[[f64; 2]]) -> Result<Self> {
        let n = region.len();
        check_sides(region)?;
        // In this frame the box is the cube [−1, 1]^n.
        let mean = DVector::from_fn(n, |i, _| (region[i][0] + region[i][1]) / 2.0);
        let half_width = |i: usize| (region[i][1] - region[i][0]) / 2.0;
        let covariance = DMatrix::from_fn(n, n, |i, j| if i == j { half_width(i).powi(2) } else { 0.0 });
        let frame = Frame::new(&Gaussian { mean, covariance })?;
        ExpPolynomial::new(in_frame(q, &frame), frame, Support::Region(region.to_vec()), 0.0)
    }

    /// ln ∫ exp(Q) dx, with the quadrature's error.
    pub fn log_mass(&self) -> Estimate {
        self.log_mass
    }

    /// Q in the states, with the constant that normalises it: ln p itself as a polynomial.
    ///
    /// ```
    /// use expoly::models::{Linear, Solved};
    /// let log_p = Linear::new(0.5, 1.0, 0.5)?.exact()?.log_polynomial(); // −ln 2π − (x² + v²)/2
    /// assert!((log_p.evaluate(&[0.0_f64, 0.0]) + 1.8378770664).abs() < 1e-10);
    /// assert!((log_p.evaluate(&[1.0_f64, 2.0]) + 1.8378770664 + 2.5).abs() < 1e-10);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn log_polynomial(&self) -> Polynomial {
        self.q.compose(&self.frame.coordinate_polynomials()) + -self.log_mass.value
    }

    /// The support of the density.
    pub fn support(&self) -> &Support {
        &self.support
    }

    /// Q in the coordinates of its frame, and that frame.
    pub(crate) fn in_coordinates(&self) -> (&Polynomial, &Frame) {
        (&self.q, &self.frame)
    }

    /// ∫ g exp(Q − top) dz and the change against the coarser rule.
    fn integral(&self, section: Section, g: impl Fn(&[f64]) -> f64) -> Estimate {
        let fine = self.rule.integrate(&self.q, &self.frame, section, &g);
        let coarse = self.coarse.integrate(&self.q, &self.frame, section, &g) * (self.rule.top - self.coarse.top).exp();
        // Rounding of the sum itself is about √nodes ε.
        Estimate::new(fine, (fine - coarse).abs() + 1e-14 * fine.abs())
    }

    fn mean_over(&self, section: Section, g: impl Fn(&[f64]) -> f64) -> Estimate {
        let scale = (self.rule.top + self.frame.log_volume() - self.log_mass.value).exp();
        let part = self.integral(section, g).scaled(scale);
        Estimate::new(part.value, part.error + part.value.abs() * self.log_mass.error)
    }

    fn log_density(&self, x: &[f64]) -> f64 {
        if x.iter().enumerate().any(|(i, x)| !self.support.contains(i, *x)) {
            return f64::NEG_INFINITY;
        }
        self.q.evaluate(&self.frame.coordinates(x)) - self.log_mass.value
    }
}

fn check_sides(region: &[[f64; 2]]) -> Result<()> {
    let remedy = "give finite lower and upper limits in this order";
    region.iter().try_for_each(|[low, high]| positive("side of a region", high - low, remedy).map(|_| ()))
}

/// Q in the coordinates of `frame`, without its constant.
fn in_frame(q: &Polynomial, frame: &Frame) -> Polynomial {
    q.compose(&frame.state_polynomials()).filtered(|alpha, _| total_degree(alpha) > 0)
}

impl Density for ExpPolynomial {
    fn dimension(&self) -> usize {
        self.frame.dimension()
    }

    /// That of the closure that found Q, or that Q is known.
    fn provenance(&self) -> &Provenance {
        &self.provenance
    }

    fn pdf(&self, x: &[f64]) -> Result<Estimate> {
        let p = self.log_pdf(x)?.exp();
        Ok(Estimate::new(p, p * self.log_mass.error))
    }

    fn log_pdf(&self, x: &[f64]) -> Result<f64> {
        point(x, self.dimension())?;
        Ok(self.log_density(x))
    }

    fn marginal(&self, state: usize, x: f64) -> Result<Estimate> {
        coordinate("the state of a marginal", state, x, self.dimension())?;
        if !self.support.contains(state, x) {
            return Ok(Estimate::exact(0.0));
        }
        Ok(self.mean_over(Section::at(state, x), |_| 1.0))
    }

    fn bounds(&self) -> Vec<[f64; 2]> {
        let mut bounds = self.rule.bounds(&self.frame);
        match &self.support {
            Support::WholeSpace => {}
            Support::Above(bound) => bounds[0][0] = *bound,
            Support::Region(limits) => bounds.clone_from(limits),
        }
        bounds
    }

    fn expectation(&self, g: &(dyn Fn(&[f64]) -> f64 + Sync)) -> Result<Estimate> {
        Ok(self.mean_over(Section::default(), g))
    }

    fn joint_marginal(&self, states: [usize; 2], x: [f64; 2]) -> Result<Estimate> {
        let states = pair(states, x, self.dimension())?;
        if states.iter().zip(x).any(|(&state, x)| !self.support.contains(state, x)) {
            return Ok(Estimate::exact(0.0));
        }
        Ok(self.mean_over(Section::at_pair(states, x), |_| 1.0))
    }

    fn flux(&self, crossing: Crossing, power: u32) -> Result<Estimate> {
        let [displacement, velocity] = crossing.states(self.dimension())?;
        let power = moderate(power)?;
        if !self.support.contains(displacement, crossing.level) {
            return Ok(Estimate::exact(0.0));
        }
        Ok(self.mean_over(Section::crossing(crossing), |x| x[velocity].abs().powi(power)))
    }
}

/// No density here has a polynomial of a higher degree.
const HIGHEST: u32 = 60;

/// The whole content of the density: Q in z, x = origin + scale z, the scale by rows. It is normalised anew, and the same
/// numbers give the same bits.
#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct DensityDocument {
    origin: Vec<f64>,
    scale: Vec<Vec<f64>>,
    /// Exponents and coefficients.
    terms: Vec<(Vec<u32>, f64)>,
    support: Support,
    noise: f64,
    provenance: Provenance,
}

impl From<ExpPolynomial> for DensityDocument {
    fn from(density: ExpPolynomial) -> Self {
        let ExpPolynomial { q, frame, support, noise, provenance, .. } = density;
        DensityDocument {
            origin: frame.origin().to_vec(),
            scale: frame.scale().row_iter().map(|row| row.iter().copied().collect()).collect(),
            terms: q.terms().map(|(alpha, c)| (alpha.to_vec(), c)).collect(),
            support,
            noise,
            provenance,
        }
    }
}

impl TryFrom<DensityDocument> for ExpPolynomial {
    type Error = String;

    fn try_from(document: DensityDocument) -> Read<Self> {
        let DensityDocument { origin, scale, terms, support, noise, provenance } = document;
        let n = origin.len();
        if n == 0 || scale.len() != n || scale.iter().any(|row| row.len() != n) {
            return Err(format!("the scale of the coordinates has not {n} rows of {n} numbers"));
        }
        let scale = DMatrix::from_fn(n, n, |i, j| scale[i][j]);
        let frame = Frame::of(DVector::from_vec(origin), scale);
        let frame = frame.ok_or("the scale of the coordinates is no lower triangle, or not finite")?;
        if !noise.is_finite() || terms.iter().any(|(alpha, c)| !c.is_finite() || total_degree(alpha) > HIGHEST) {
            return Err(format!("a coefficient is not finite, or a degree above {HIGHEST}"));
        }
        let q = Polynomial::from_terms(n, terms).map_err(|error| error.to_string())?;
        let density = ExpPolynomial::new(q, frame, support, noise).map_err(|error| error.to_string())?;
        Ok(density.with_provenance(provenance))
    }
}

impl fmt::Display for ExpPolynomial {
    /// How it was made, its domain, moments and rates, and its estimate of the error, a line each.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        summary(self, f)
    }
}
