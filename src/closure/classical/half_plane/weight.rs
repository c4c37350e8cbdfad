use crate::closure::ROUNDING;
use crate::closure::classical::STEPS;
use crate::error::Result;
use crate::numerics::{Rule, least_norm};
use crate::polynomial::{Frame, Gaussian};
use faer::{Col, Mat, col, mat};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;
use std::sync::LazyLock;

/// The iterates that a step to the fixed point of the weight is combined from, the present one among them.
const MEMORY: usize = 4;

/// Nodes on a half line for a Gaussian times a smooth function: the error is below 1e-13 up to polynomials of degree 40.
const HALF_LINE: usize = 64;

/// The rule of [`HALF_LINE`] nodes on [−1, 1], made once.
static HALF_LINE_RULE: LazyLock<Rule> = LazyLock::new(|| Rule::legendre(HALF_LINE));

/// The Gaussian weight is cut where it has fallen by e^−60.
const CUT: f64 = 60.0;

/// The weight f_N: a Gaussian, of which only y ≥ b counts.
#[derive(Clone, Debug)]
pub(in crate::closure::classical) struct HalfPlaneWeight {
    pub(in crate::closure::classical) frame: Frame,
    /// The wall's coordinate z₁.
    wall: f64,
}

/// Points with weights that sum to one over the half plane.
pub(super) struct HalfPlaneNodes {
    pub(super) z: Vec<[f64; 2]>,
    pub(super) weights: Vec<f64>,
    /// ∫ f_N over the half plane, in the scale in which the wall's nodes are weighted.
    mass: f64,
}

impl HalfPlaneWeight {
    /// Above a wall at `offset`.
    pub(in crate::closure::classical) fn new(gaussian: &Gaussian, offset: f64) -> Result<Self> {
        let frame = Frame::new(gaussian)?;
        let wall = (offset - frame.origin()[0]) / frame.scale()[(0, 0)];
        Ok(HalfPlaneWeight { frame, wall })
    }

    /// The density of z₁ relative to its value at the wall or at the centre, so that a far wall does not underflow.
    fn outward_density(&self, z: f64) -> f64 {
        ((self.wall.max(0.0).powi(2) - z * z) / 2.0).exp() / TAU.sqrt()
    }

    /// Nodes on the half plane, exact for polynomials of degree 2`count` − 1 in each coordinate.
    pub(super) fn nodes(&self, count: usize) -> HalfPlaneNodes {
        let cut = (2.0 * CUT).sqrt();
        let last = if self.wall > 0.0 { self.wall.hypot(cut) } else { cut };
        let mut outwards = HALF_LINE_RULE.on(self.wall.max(-cut), last);
        outwards.weights.iter_mut().zip(&outwards.nodes).for_each(|(w, z)| *w *= self.outward_density(*z));
        let (outwards, along) = (outwards.condensed(count), Rule::hermite(count));
        let mass: f64 = outwards.weights.iter().sum();
        let mut nodes = HalfPlaneNodes { z: Vec::new(), weights: Vec::new(), mass };
        for (z1, w1) in outwards.iter() {
            for (z2, w2) in along.iter() {
                nodes.z.push([z1, z2]);
                nodes.weights.push(w1 * w2 / mass);
            }
        }
        nodes
    }

    /// Points on the wall with w of one sign, as pairs of w and its weight f_N(0, w) dw, normalised as `nodes`.
    pub(super) fn wall_nodes(&self, sign: f64, nodes: &HalfPlaneNodes) -> Vec<(f64, f64)> {
        let scale = self.frame.scale();
        let (mean, sigma) = (self.mean_at_wall(), scale[(1, 1)]);
        let factor = self.outward_density(self.wall) / (scale[(0, 0)] * nodes.mass);
        let far = (mean * sign).max(0.0) + (2.0 * CUT).sqrt() * sigma;
        let density = |w: f64| (-((w - mean) / sigma).powi(2) / 2.0).exp() / (sigma * TAU.sqrt());
        let rule = HALF_LINE_RULE.on(0.0, far);
        rule.iter().map(|(speed, weight)| (sign * speed, weight * density(sign * speed) * factor)).collect()
    }

    /// The coordinates of the point (b, w).
    pub(super) fn at_wall(&self, w: f64) -> [f64; 2] {
        [self.wall, (w - self.mean_at_wall()) / self.frame.scale()[(1, 1)]]
    }

    /// The mean of w under f_N on the wall.
    fn mean_at_wall(&self) -> f64 {
        self.frame.origin()[1] + self.frame.scale()[(1, 0)] * self.wall
    }
}

/// The Gaussian of a displacement and its velocity.
pub(in crate::closure::classical) fn in_plane(mean: [f64; 2], covariance: &Mat<f64>) -> Gaussian {
    let covariance = DMatrix::from_fn(2, 2, |i, j| covariance[(i, j)]);
    Gaussian { mean: DVector::from_column_slice(&mean), covariance }
}

/// Iterates `map` from `start` to its fixed point, with Anderson's acceleration (D. G. Anderson, 1965,
/// doi:10.1145/321296.321305) on the mean and the logarithmic Cholesky factor, in which every vector is a Gaussian.
///
/// Returns the last iterate where `map` gives nothing or the iterations run out: any Gaussian serves as a weight, and the
/// fixed point only makes the choice definite.
pub(in crate::closure::classical) fn fixed_point(
    start: Gaussian,
    map: impl Fn(&Gaussian) -> Option<Gaussian>,
) -> Gaussian {
    // The mean in units of `start`'s deviations, so that a map which keeps the mean has it kept by every combination.
    let unit = [0, 1].map(|i| start.covariance[(i, i)].sqrt());
    let pack = |gaussian: &Gaussian| -> Option<Col<f64>> {
        let scale = gaussian.scale().ok()?;
        let mean = [0, 1].map(|i| gaussian.mean[i] / unit[i]);
        Some(col![mean[0], mean[1], scale[(0, 0)].ln(), scale[(1, 1)].ln(), scale[(1, 0)] / unit[1]])
    };
    let mut gaussian = start;
    let mut history: Vec<(Col<f64>, Col<f64>)> = Vec::new();
    for _ in 0..STEPS {
        let mapped = map(&gaussian).and_then(|next| pack(&next));
        let Some((x, y)) = pack(&gaussian).zip(mapped) else { break };
        let change = &y - &x;
        if change.norm_max() < ROUNDING {
            break;
        }
        history.push((x, change));
        if history.len() > MEMORY {
            history.remove(0);
        }
        let x = accelerated(&history);
        let scale = mat![[x[2].exp(), 0.0], [x[4] * unit[1], x[3].exp()]];
        gaussian = in_plane([x[0] * unit[0], x[1] * unit[1]], &(&scale * scale.transpose()));
    }
    gaussian
}

/// The combination of the stored steps whose changes cancel best.
fn accelerated(history: &[(Col<f64>, Col<f64>)]) -> Col<f64> {
    let Some(((x, change), earlier)) = history.split_last() else { return Col::zeros(0) };
    let plain = x + change;
    let differences = Mat::from_fn(change.nrows(), earlier.len(), |i, k| change[i] - earlier[k].1[i]);
    let Some(share) = least_norm(&differences, change, 1e-10) else { return plain };
    let mut next = plain.clone();
    for (share, (x_old, change_old)) in share.iter().zip(earlier) {
        next -= (&plain - x_old - change_old) * *share;
    }
    // A combination that leaps is worse than the plain step.
    if (&next - x).norm_max() < 2.0 { next } else { plain }
}
