use super::VibroImpactDuffing;
use crate::checks::{coordinate, point, positive, require};
use crate::density::{Crossing, Density, moderate};
use crate::error::{Error, Result};
use crate::estimate::Estimate;
use crate::numerics::Rule;
use crate::system::Oscillator;

/// Intervals of the table of the exponent over the energy.
const TABLE: usize = 400;
/// The density is followed down to e^−45 of its peak.
const DEPTH: f64 = 45.0;
/// Nodes of each integral; the error is estimated with two thirds of them.
const NODES: usize = 72;

/// The density of a vibro-impact Duffing oscillator by averaging over its free orbits, for small c and small 1 − r:
///
/// p(y, v) = C exp{−(1/D) ∫^H [c + (1 − r²) (s − U(b))₊ / Φ(s)] ds}, H = v²/2 + U(y),
///
/// with Φ(s) = 2 ∫ √(2(s − U)) dy over the orbit of energy s above the wall, and U the potential. An orbit that reaches the
/// wall loses (1 − r²)(s − U(b)) at its one impact and c Φ(s) to damping. It is exact for r = 1 and an asymptotic formula
/// otherwise: an independent approximation beside closure and simulation, not a reference. It treats a single well, k ≥ 0 and
/// μ ≥ 0.
///
/// # Reference
/// R. L. Stratonovich, Topics in the Theory of Random Noise, volume 1, Gordon and Breach 1963, for the averaging of
/// energy; M. F. Dimentberg and D. V. Iourtchenko, Random vibrations with impacts: a review, Nonlinear Dynamics 36 (2004)
/// 229-254, doi:10.1023/B:NODY.0000045510.93602.ca, for impacts.
#[derive(Clone, Debug)]
pub struct EnergyAveraged {
    model: VibroImpactDuffing,
    /// b.
    offset: f64,
    lowest: f64,
    step: f64,
    /// The exponent and its derivative at the energies lowest + k·step.
    table: Vec<[f64; 2]>,
    mass: f64,
}

impl EnergyAveraged {
    /// The averaged density of `model`.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless damping, k + μ and D are positive and k, μ not negative.
    pub fn new(model: &VibroImpactDuffing) -> Result<Self> {
        let [damping, stiffness, cubic] = model.oscillator().coefficients();
        positive("damping", damping, "without damping there is no stationary density")?;
        for (name, value) in [("stiffness k", stiffness), ("cubic stiffness μ", cubic)] {
            let remedy = "averaging needs a single well: k ≥ 0 and μ ≥ 0";
            require(value.is_finite() && value >= 0.0, name, value, remedy)?;
        }
        positive("k + μ", stiffness + cubic, "without a spring there is no stationary density")?;
        let (offset, d) = (model.wall().offset(), model.oscillator().intensity().d());
        let mut averaged =
            EnergyAveraged { model: *model, offset, lowest: 0.0, step: 0.0, table: Vec::new(), mass: 1.0 };
        let lowest = averaged.potential(offset.max(0.0));
        averaged.lowest = lowest;
        // Damping alone takes the exponent to the depth within this range.
        averaged.step = DEPTH * d / damping / TABLE as f64;
        let rule = Rule::legendre(6);
        let mut exponent = 0.0;
        for k in 0..=TABLE {
            let low = lowest + k as f64 * averaged.step;
            averaged.table.push([exponent, averaged.loss(low) / d]);
            exponent += rule.on(low, low + averaged.step).iter().map(|(s, w)| w * averaged.loss(s) / d).sum::<f64>();
        }
        averaged.mass = averaged.integral(NODES, |_, _| 1.0);
        Ok(averaged)
    }

    /// The potential U(y) of the spring.
    fn potential(&self, y: f64) -> f64 {
        let [_, k, mu] = self.model.oscillator().coefficients();
        y * y * (k / 2.0 + mu / 4.0 * y * y)
    }

    /// c + (1 − r²) (s − U(b))₊ / Φ(s): the loss per energy.
    fn loss(&self, s: f64) -> f64 {
        let [damping, ..] = self.model.oscillator().coefficients();
        let reach = s - self.potential(self.offset);
        let restitution = self.model.wall().restitution();
        // Where the wall stands above the rest position, Φ vanishes like (s − U(b))^{3/2}.
        if reach <= 0.0 || restitution == 1.0 {
            return damping;
        }
        damping + (1.0 - restitution.powi(2)) * reach / self.action(s)
    }

    /// Φ(s). With y = y₁ + (y₂ − y₁) sin²θ the roots at the turning points become smooth.
    fn action(&self, s: f64) -> f64 {
        let right = self.turning_point(s);
        let left = self.offset.max(-right);
        let speed = |y: f64| (2.0 * (s - self.potential(y))).max(0.0).sqrt();
        let rule = Rule::legendre(24).on(0.0, std::f64::consts::FRAC_PI_2);
        let integral: f64 =
            rule.iter().map(|(t, w)| w * speed(left + (right - left) * t.sin().powi(2)) * (2.0 * t).sin()).sum();
        2.0 * (right - left) * integral
    }

    /// The largest displacement of an orbit: U(y) = s, k y² + ½ μ y⁴ = 2 s.
    fn turning_point(&self, s: f64) -> f64 {
        let [_, k, mu] = self.model.oscillator().coefficients();
        let discriminant = (k * k + 4.0 * mu * s).sqrt();
        // The form without cancellation for small μ.
        (4.0 * s / (k + discriminant)).sqrt()
    }

    /// The exponent at an energy, by cubic Hermite interpolation; infinite beyond the table.
    fn exponent(&self, energy: f64) -> f64 {
        let t = ((energy - self.lowest) / self.step).max(0.0);
        let k = t as usize;
        let (Some([y0, d0]), Some([y1, d1])) = (self.table.get(k), self.table.get(k + 1)) else { return f64::INFINITY };
        let t = t - k as f64;
        let (d0, d1) = (d0 * self.step, d1 * self.step);
        y0 + t * (d0 + t * (3.0 * (y1 - y0) - 2.0 * d0 - d1 + t * (2.0 * (y0 - y1) + d0 + d1)))
    }

    fn unscaled(&self, y: f64, v: f64) -> f64 {
        (-self.exponent(v * v / 2.0 + self.potential(y))).exp()
    }

    fn highest(&self) -> f64 {
        self.lowest + self.step * TABLE as f64
    }

    /// ∫ g(v) p(y, v) dv over both signs, or one, unscaled.
    fn over_velocity(&self, nodes: usize, y: f64, sides: [bool; 2], g: impl Fn(f64) -> f64) -> f64 {
        let limit = (2.0 * (self.highest() - self.potential(y))).max(0.0).sqrt();
        let rule = Rule::legendre(nodes).on(0.0, limit);
        let both = |v: f64| {
            [(sides[0], -v), (sides[1], v)].into_iter().filter(|(used, _)| *used).map(|(_, v)| g(v)).sum::<f64>()
        };
        rule.iter().map(|(v, w)| w * self.unscaled(y, v) * both(v)).sum()
    }

    fn integral(&self, nodes: usize, g: impl Fn(f64, f64) -> f64) -> f64 {
        let rule = Rule::legendre(nodes).on(self.offset, self.turning_point(self.highest()));
        rule.iter().map(|(y, w)| w * self.over_velocity(nodes, y, [true, true], |v| g(y, v))).sum()
    }

    /// A value over the mass, with the change that fewer nodes make.
    fn estimate(&self, integral: impl Fn(usize) -> f64) -> Estimate {
        let fine = integral(NODES) / self.mass;
        Estimate::new(fine, fine - integral(NODES * 2 / 3) / self.mass)
    }
}

impl Density for EnergyAveraged {
    fn dimension(&self) -> usize {
        2
    }

    fn pdf(&self, x: &[f64]) -> Result<Estimate> {
        point(x, 2)?;
        Ok(Estimate::exact(if x[0] >= self.offset { self.unscaled(x[0], x[1]) / self.mass } else { 0.0 }))
    }

    fn marginal(&self, state: usize, x: f64) -> Result<Estimate> {
        Ok(match coordinate("the state of a marginal", state, x, 2)? {
            0 if x < self.offset => Estimate::exact(0.0),
            0 => self.estimate(|nodes| self.over_velocity(nodes, x, [true, true], |_| 1.0)),
            _ => self.estimate(|nodes| {
                let rule = Rule::legendre(nodes).on(self.offset, self.turning_point(self.highest()));
                rule.iter().map(|(y, w)| w * self.unscaled(y, x)).sum()
            }),
        })
    }

    fn bounds(&self) -> Vec<[f64; 2]> {
        let fastest = (2.0 * (self.highest() - self.lowest)).sqrt();
        vec![[self.offset, self.turning_point(self.highest())], [-fastest, fastest]]
    }

    fn expectation(&self, g: &(dyn Fn(&[f64]) -> f64 + Sync)) -> Result<Estimate> {
        Ok(self.estimate(|nodes| self.integral(nodes, |y, v| g(&[y, v]))))
    }

    /// The flux of the displacement, state 0, with state 1 as its velocity; no other pair has one.
    fn flux(&self, crossing: Crossing, power: u32) -> Result<Estimate> {
        let power = moderate(power)?;
        match crossing.states(2)? {
            [0, _] if crossing.level < self.offset => Ok(Estimate::exact(0.0)),
            [0, _] => {
                let sides = [!crossing.upward, crossing.upward];
                let speed = |v: f64| v.abs().powi(power);
                Ok(self.estimate(|nodes| self.over_velocity(nodes, crossing.level, sides, speed)))
            }
            [state, _] => Err(Error::NotADisplacement { state }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Below the wall nothing crosses, and the velocity has no velocity of its own.
    #[test]
    fn only_the_displacement_above_its_wall_has_a_flux() -> Result<()> {
        let averaged = EnergyAveraged::new(&VibroImpactDuffing::standard([-0.5, 0.9])?)?;
        assert_eq!(averaged.flux(Crossing::downward(-0.6), 1)?.value, 0.0);
        assert!(averaged.flux(Crossing::downward(-0.5), 1)?.value > 0.1);
        let of_velocity = Crossing { displacement: 1, velocity: 0, ..Crossing::upward(0.0) };
        assert_eq!(averaged.flux(of_velocity, 1), Err(Error::NotADisplacement { state: 1 }));
        Ok(())
    }
}
