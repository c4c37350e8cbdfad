/// Shorter steps for trajectories that graze the wall.
///
/// Near (y, v) = (b, 0) a trajectory that loses speed at each impact chatters: white noise brings it back to the wall
/// again and again, after ever shorter times. A step h does not resolve speeds below √(2Dh), with D = ½B_vv, and misses
/// their impacts: the impact rate of a wall with r < 1 would be too low by a term of order h^(1 + 3g/2), where
/// p ~ |v|^(3g) is the density's singularity at the grazing point (g = −0.04 for r = 0.9, −0.16 for r = 0.7), though
/// moments hardly notice. A trajectory at the height u with the velocity v therefore takes steps that its own scale sets.
/// With S the larger of |v| and (2Du)^(1/3), the speed that noise gains while it crosses the height u, the step is
/// (S/a)²/2D. Little time is spent at small S, so that this costs little.
///
/// The share of impacts that happen there is of order h, and each scale has the same small relative error, because steps
/// that follow the velocity meet the wall in uneven phases. What is left in the impact rate is of first order with a small
/// factor: at r = 0.7, b = 0.5 (c = D = 0.2, k = 1, μ = 0.3) the rate was 0.52, 0.26, 0.13, 0.06 % (±0.03) high for
/// h = 0.08, 0.04, 0.02, 0.01, against −2.0, −1.0, −0.6, −0.3 % with plain steps. At r = 0.9 it is not seen.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grazing {
    /// The time step h.
    step: f64,
    /// The speed a √(2Dh) below which steps are shortened; 0 for no such speed.
    speed: f64,
    /// The height below which steps are shortened, speed³/2D.
    height: f64,
}

/// The ratio a of a trajectory's own speed to what noise adds in one step. The impact rate at h = 0.02, r = 0.7 is the same
/// with a = 2 and 3 within 2 in 10⁴, and 6 in 10⁴ lower with a = 1.5.
const RESOLUTION: f64 = 2.0;

/// How many times the step is shortened at most. What is missed falls with the power 1 + 3g/2 of it, one half at r = 0.5.
const DEPTH: f64 = 4096.0;

impl Grazing {
    /// For the restitution r, D = `diffusion` at rest on the wall, and the time step. An elastic wall needs none of it:
    /// its trajectories are those of a smooth motion, folded.
    pub(super) fn new(restitution: f64, diffusion: f64, step: f64) -> Self {
        let gain = (2.0 * diffusion * step).sqrt();
        let a = if restitution < 1.0 { RESOLUTION } else { 0.0 };
        Grazing { step, speed: a * gain, height: a.powi(3) * gain * step }
    }

    /// The height below which a straight drift over one step ends if its middle needs a shorter step.
    pub(super) fn reach(&self) -> f64 {
        self.height + self.speed * self.step / 2.0
    }

    /// The step at the height u and the velocity v, if it must be shorter than usual.
    #[inline]
    pub(super) fn step_at(&self, u: f64, v: f64) -> Option<f64> {
        if !(u < self.height && v.abs() < self.speed) {
            return None;
        }
        let (speed, height) = (v.abs() / self.speed, u / self.height);
        let scale = if speed * speed * speed > height { speed } else { height.cbrt() };
        Some(self.step * (scale * scale).max(DEPTH.recip()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_shrink_towards_the_grazing_point_and_are_whole_outside() {
        let grazing = Grazing::new(0.9, 0.2, 0.02);
        let (speed, height) = (grazing.speed, grazing.height);
        assert_eq!(grazing.step_at(0.0, 0.0), Some(0.02 / 4096.0));
        assert_eq!(grazing.step_at(0.0, -speed / 2.0), Some(0.02 / 4.0));
        let higher = grazing.step_at(height / 8.0, 0.0);
        assert!(higher.is_some_and(|step| (step - 0.02 / 4.0).abs() < 1e-16));
        assert_eq!(grazing.step_at(0.0, speed), None);
        assert_eq!(grazing.step_at(height, 0.0), None);
        assert_eq!(grazing.step_at(f64::NAN, f64::NAN), None);
        assert_eq!(Grazing::new(1.0, 0.2, 0.02).step_at(0.0, 0.0), None);
    }
}
