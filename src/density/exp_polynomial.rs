use super::tensor::{Section, TensorRule};
use super::{Crossing, Density, Frame, Support, escape_direction, pair};
use crate::error::{positive, state_index};
use crate::{Error, Estimate, Gaussian, Polynomial, Result};
use nalgebra::{SMatrix, SVector};

/// A density p = C exp(Q) with a polynomial Q, on R^N, above a wall, or cut off at a given region.
///
/// It is normalised by quadrature, whose error estimate goes into every value. Integrals cost milliseconds in two states
/// and up to seconds in six.
#[derive(Clone, Debug)]
pub struct ExpPolynomial<const N: usize> {
    /// In the coordinates of the frame.
    pub(super) q: Polynomial<N>,
    pub(super) frame: Frame<N>,
    pub(super) support: Support<N>,
    /// The relative size below which a coefficient was taken for rounding.
    pub(super) noise: f64,
    rule: TensorRule<N>,
    coarse: TensorRule<N>,
    /// ln ∫ exp(Q) dx.
    log_mass: Estimate,
}

impl<const N: usize> ExpPolynomial<N> {
    /// The density exp(Q) for `q` in the coordinates z of `frame`.
    ///
    /// `noise` is the relative size below which a value says nothing about the sign of Q far away.
    ///
    /// # Errors
    /// [`Error::NotNormalisable`] if Q does not fall in every direction that `support` leaves open.
    pub fn new(q: Polynomial<N>, frame: Frame<N>, support: Support<N>, noise: f64) -> Result<Self> {
        let half_space = match support {
            Support::WholeSpace => Some(false),
            Support::Above(_) => Some(true),
            Support::Region(_) => None,
        };
        if let Some(direction) = half_space.and_then(|half_space| escape_direction(&q, half_space, noise)) {
            return Err(Error::NotNormalisable { order: q.degree(), direction: direction.to_vec() });
        }
        let (rule, coarse) = TensorRule::fitted(&q, &frame, &support)?;
        let mut density = ExpPolynomial { q, frame, support, noise, rule, coarse, log_mass: Estimate::exact(0.0) };
        let mass = density.integral(Section::default(), |_| 1.0);
        let log_mass = mass.value.ln() + density.rule.top + density.frame.log_volume();
        density.log_mass = Estimate::new(log_mass, mass.error / mass.value);
        Ok(density)
    }

    /// The density exp(Q) for `q` in the states themselves; `scale` is a Gaussian of roughly its location and width.
    ///
    /// # Errors
    /// As [`ExpPolynomial::new`]; [`Error::OutOfRange`] if the covariance of `scale` is not positive definite.
    pub fn from_states(q: &Polynomial<N>, scale: &Gaussian<N>, support: Support<N>) -> Result<Self> {
        let frame = Frame::new(scale)?;
        ExpPolynomial::new(in_frame(q, &frame), frame, support, 1e-13)
    }

    /// exp(Q) cut off at a box of the states, for `q` in the states themselves, whether or not Q falls outside.
    ///
    /// This is how an exp(Q) that is no density on the whole space can still be compared where it is plausible; the
    /// caller chooses the box and must say so.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if a side of the box is not finite and positive.
    pub fn cut_off(q: &Polynomial<N>, region: [[f64; 2]; N]) -> Result<Self> {
        for [low, high] in region {
            positive("side of a region", high - low, "give finite lower and upper limits in this order")?;
        }
        // In this frame the box is the cube [−1, 1]^N.
        let mean = SVector::from_fn(|i, _| (region[i][0] + region[i][1]) / 2.0);
        let covariance =
            SMatrix::from_fn(|i, j| if i == j { ((region[i][1] - region[i][0]) / 2.0).powi(2) } else { 0.0 });
        let frame = Frame::new(&Gaussian { mean, covariance })?;
        ExpPolynomial::new(in_frame(q, &frame), frame, Support::Region(region), 0.0)
    }

    /// ln ∫ exp(Q) dx, with the quadrature's error.
    pub fn log_mass(&self) -> Estimate {
        self.log_mass
    }

    /// Q in the states, with the constant that normalises it: ln p itself as a polynomial.
    ///
    /// ```
    /// use expoly::{Closure, models::Linear};
    /// let density = Closure::classical(2).solve(&Linear::new(0.5, 1.0, 0.5)?)?.density()?;
    /// let log_p = density.log_polynomial(); // −ln 2π − (x² + v²)/2
    /// assert!((log_p.evaluate(&[0.0_f64, 0.0]) + 1.8378770664).abs() < 1e-10);
    /// assert!((log_p.evaluate(&[1.0_f64, 2.0]) + 1.8378770664 + 2.5).abs() < 1e-10);
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn log_polynomial(&self) -> Polynomial<N> {
        self.q.compose(&self.frame.coordinate_polynomials()) + -self.log_mass.value
    }

    /// Where the density lives.
    pub fn support(&self) -> &Support<N> {
        &self.support
    }

    /// ∫ g exp(Q − top) dz and the change against the coarser rule.
    fn integral(&self, section: Section, g: impl Fn(&[f64; N]) -> f64) -> Estimate {
        let fine = self.rule.integrate(&self.q, &self.frame, section, &g);
        let coarse = self.coarse.integrate(&self.q, &self.frame, section, &g) * (self.rule.top - self.coarse.top).exp();
        // Rounding of the sum itself is about √nodes ε.
        Estimate::new(fine, (fine - coarse).abs() + 1e-14 * fine.abs())
    }

    fn mean_over(&self, section: Section, g: impl Fn(&[f64; N]) -> f64) -> Estimate {
        let scale = (self.rule.top + self.frame.log_volume() - self.log_mass.value).exp();
        let part = self.integral(section, g).scaled(scale);
        Estimate::new(part.value, part.error + part.value.abs() * self.log_mass.error)
    }
}

/// Q in the coordinates of `frame`, without its constant.
fn in_frame<const N: usize>(q: &Polynomial<N>, frame: &Frame<N>) -> Polynomial<N> {
    q.compose(&frame.state_polynomials()).filtered(|m, _| m.degree() > 0)
}

impl<const N: usize> Density<N> for ExpPolynomial<N> {
    fn pdf(&self, x: &[f64; N]) -> Estimate {
        let p = self.log_pdf(x).exp();
        Estimate::new(p, p * self.log_mass.error)
    }

    fn log_pdf(&self, x: &[f64; N]) -> f64 {
        if (0..N).any(|i| !self.support.contains(i, x[i])) {
            return f64::NEG_INFINITY;
        }
        self.q.evaluate(&self.frame.coordinates(x)) - self.log_mass.value
    }

    fn marginal(&self, state: usize, x: f64) -> Result<Estimate> {
        state_index::<N>("the state of a marginal", state)?;
        if !self.support.contains(state, x) {
            return Ok(Estimate::exact(0.0));
        }
        Ok(self.mean_over(Section::at(state, x), |_| 1.0))
    }

    fn bounds(&self) -> [[f64; 2]; N] {
        let mut bounds = self.rule.bounds(&self.frame);
        match self.support {
            Support::WholeSpace => {}
            Support::Above(bound) => bounds[0][0] = bound,
            Support::Region(limits) => bounds = limits,
        }
        bounds
    }

    fn expectation(&self, g: &(dyn Fn(&[f64; N]) -> f64 + Sync)) -> Estimate {
        self.mean_over(Section::default(), g)
    }

    fn joint_marginal(&self, states: [usize; 2], x: [f64; 2]) -> Result<Estimate> {
        let states = pair::<N>(states)?;
        if states.iter().zip(x).any(|(&state, x)| !self.support.contains(state, x)) {
            return Ok(Estimate::exact(0.0));
        }
        Ok(self.mean_over(Section::at_pair(states, x), |_| 1.0))
    }

    fn flux(&self, crossing: Crossing, power: u32) -> Result<Estimate> {
        let [displacement, velocity] = crossing.states::<N>()?;
        if !self.support.contains(displacement, crossing.level) {
            return Ok(Estimate::exact(0.0));
        }
        Ok(self.mean_over(Section::crossing(crossing), |x| x[velocity].abs().powi(power as i32)))
    }
}
