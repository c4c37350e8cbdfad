use crate::walls::Wall;

/// The least ratio a of the speed of a trajectory beside a wall with r < 1 to what noise adds to it in one step.
const RESOLUTION: f64 = 3.0;
/// The number m of steps for which a wall with r < 1 must be out of reach where a step does not resolve the speed.
const FORESIGHT: f64 = 2.0;

/// Shorter steps for trajectories that graze the wall, and so the end of chattering.
///
/// Near (y, v) = (b, 0) a trajectory that loses speed at each impact chatters: white noise brings it back to the wall
/// again and again, after ever shorter times. For r > e^(−π/√3) = 0.163 it gets away with probability one (S. J. Cornell,
/// M. R. Swift and A. J. Bray, 1998, doi:10.1103/PhysRevLett.81.1142), and the impact rate is finite; below, a trajectory
/// collapses onto the wall, and the impact rate of white noise is infinite: the rate found is then that of the shortest step.
/// A force that presses onto the wall does not matter at small scales, where noise is stronger than any force.
///
/// A step h does not resolve speeds below √(2Dh), with D = ½B_vv, and misses their impacts: the impact rate of a wall with
/// r < 1 would be too low by a term of order h^(1 + 3g/2), where p ~ |v|^(3g) is the density's singularity at the grazing
/// point (g = −0.04 for r = 0.9, −0.16 for r = 0.7), though moments hardly change. A trajectory at the height u with the
/// velocity v therefore takes the longest step τ = h, h/2, h/4, ... that either
///
/// - resolves the velocity, 2Dτ ≤ (v/a)², or
/// - ends before the wall can matter: neither the velocity nor the noise crosses the height within mτ, that is
///   mτ|v| ≤ u and 2D(mτ)³ ≤ u².
///
/// So the noise of one step changes the speed of an impact by 1/a of it at most, at all scales alike, down to h/2²⁰, or
/// h/2¹² for r ≤ 0.25, and not below the step whose heights are lost in the rounding of b: there is no endless loop.
///
/// The remaining error is due to impacts at a few times √(2Dh), where the noise before an impact and that after it, which
/// lost no energy, are separated to one step only; it falls as h/a². Measured against the grid at r = 0.7, b = 0.5 (c = D =
/// 0.2, k = 1, μ = 0.3) for h = 0.08, the impact rate was 0.50, 0.05, −0.05 % high for a = 2, 3, 4 (±0.06), and −2.0 %
/// without shorter steps; at h = 0.02 the same is four times smaller.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grazing {
    /// The time step h.
    step: f64,
    /// The intensity 2D of the noise, per unit time.
    noise: f64,
    /// The speed a √(2Dh) below which steps may be shortened; 0 for no such speed.
    pub(super) speed: f64,
    /// The height below which steps may be shortened.
    pub(super) height: f64,
    /// The shortest step.
    shortest: f64,
}

/// The factor by which the step is shortened at most. The missing impacts fall with the power 1 + 3g/2 of the shortest step,
/// one half at r = 0.5 and less for lower r. Few trajectories come so far down, so that depth costs little, but below r =
/// 0.163 all do and stay there.
fn depth(restitution: f64) -> f64 {
    if restitution > 0.25 { 2.0_f64.powi(20) } else { 2.0_f64.powi(12) }
}

impl Grazing {
    /// For a wall, D = `diffusion` at rest on it, and the time step. An elastic wall needs none of it: its trajectories are
    /// those of a smooth motion, folded.
    pub(super) fn new(wall: &Wall, diffusion: f64, step: f64) -> Self {
        let (restitution, offset) = (wall.restitution(), wall.offset());
        let noise = 2.0 * diffusion;
        let gain = (noise * step).sqrt();
        // √(2D (mτ)³) = ε|b|.
        let rounding = (f64::EPSILON * offset.abs()).powi(2) / noise.max(f64::MIN_POSITIVE);
        let unresolved = rounding.cbrt() / FORESIGHT;
        let (speed, height) = if restitution < 1.0 {
            // From mτ|v| ≤ u with |v| = a √(2Dh) and from 2D(mτ)³ ≤ u², at τ = h.
            (RESOLUTION * gain, FORESIGHT * step * gain * RESOLUTION.max(FORESIGHT.sqrt()))
        } else {
            (0.0, 0.0)
        };
        Grazing { step, noise, speed, height, shortest: (step / depth(restitution)).max(unresolved) }
    }

    /// The step at the height u and the velocity v, both below their bounds, if it must be shorter than usual.
    #[inline]
    pub(super) fn step_at(&self, u: f64, v: f64) -> Option<f64> {
        let resolved = v * v / (RESOLUTION * RESOLUTION * self.noise);
        let mut step = self.step;
        while step > resolved && step > self.shortest {
            let time = FORESIGHT * step;
            if time * v.abs() <= u && self.noise * time * time * time <= u * u {
                break;
            }
            step /= 2.0;
        }
        (step < self.step).then_some(step)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_shrink_towards_the_grazing_point_and_are_whole_outside() -> crate::Result<()> {
        let (h, noise) = (0.02, 0.4);
        let grazing = Grazing::new(&Wall::above(0.1, 0.9)?, noise / 2.0, h);
        let (speed, height) = (grazing.speed, grazing.height);
        assert_eq!(grazing.step_at(0.0, 0.0), Some(h / 2.0_f64.powi(20)));
        // Half the speed is resolved by a quarter of the step.
        assert_eq!(grazing.step_at(0.0, -0.501 * speed), Some(h / 4.0));
        // At rest at the height √(2D (mτ)³), with τ a little above h/8.
        let higher = (noise * (1.01 * FORESIGHT * h / 8.0).powi(3)).sqrt();
        assert_eq!(grazing.step_at(higher, 0.0), Some(h / 8.0));
        for (u, v) in [(0.0, speed), (height, 0.0), (0.99 * height, 0.5 * speed), (f64::NAN, f64::NAN)] {
            assert_eq!(grazing.step_at(u, v), None, "{u}, {v}");
        }
        assert_eq!(Grazing::new(&Wall::above(0.1, 1.0)?, noise / 2.0, h).height, 0.0);
        // Where the heights that noise reaches in a step are lost in the rounding of the wall's place, no step is shortened:
        // with D = 1e-36 and h = 1e-3 they are 1e-22, and the wall is at 0.1.
        assert_eq!(Grazing::new(&Wall::above(0.1, 0.9)?, 1e-36, 1e-3).step_at(0.0, 0.0), None);
        Ok(())
    }
}
